//! Lagrange multipliers of the two budgets, and the lower bound that they prove.
//!
//! For prices `p, q >= 0` of the two budgets, in pixels for all of a budget, every choice within them
//! has at least the error `L(p, q) = Σ min (error + p · share₀ + q · share₁) - p - q`, the sum over the
//! parts and the minimum over the items of each. `L` is concave and piecewise linear. Its maximum is
//! the optimum of the linear relaxation, in which parts may mix their items.
//!
//! Source: Kellerer, Pferschy, Pisinger, *Knapsack Problems*, 2004, 11.2; the search is Kelley's cutting
//! planes in one dimension, nested.

use super::problem::{Item, Problem};

/// Steps of each search; it ends by itself at a corner of `L`, usually after less than ten.
const STEPS: usize = 48;
/// Doublings of the first guess of a price. Beyond it the bound would drown in rounding: prices are
/// taken away that were added before.
const DOUBLINGS: usize = 20;

/// Prices of both budgets and the error that no choice can fall below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dual {
    pub(super) price: [f64; 2],
    pub(super) bound: f64,
}

/// A supporting line of a concave function of one price.
#[derive(Debug, Clone, Copy)]
struct Line {
    price: f64,
    value: f64,
    slope: f64,
}

/// `L` at two prices, with the shares that its items use beyond the budgets.
#[derive(Debug, Clone, Copy)]
struct Point {
    value: f64,
    excess: [f64; 2],
}

impl Item {
    pub(super) fn priced(&self, price: [f64; 2]) -> f64 {
        self.error + price[0] * self.share[0] + price[1] * self.share[1]
    }
}

/// Finds prices whose bound is the greatest, up to rounding.
pub(super) fn dual(problem: &Problem) -> Dual {
    let second = |q: f64| {
        let (p, point) = inner(problem, q);
        (p, point.value, point.excess[1])
    };
    let mut best = Dual {
        price: [0.0; 2],
        bound: f64::NEG_INFINITY,
    };
    let worst: f64 = problem.parts.iter().map(|part| worst(part)).sum();
    climb(problem, &mut |q| {
        let (p, value, slope) = second(q);
        if value > best.bound {
            best = Dual {
                price: [p, q],
                bound: value,
            };
        }
        Line {
            price: q,
            value,
            slope,
        }
    });
    // Sums of numbers of this size have at most this rounding error.
    let terms = (4 * problem.parts.len() + 4) as f64;
    best.bound -= terms * f64::EPSILON * (worst + best.price[0] + best.price[1]);
    best
}

fn worst(part: &[Item]) -> f64 {
    part.iter().map(|i| i.error).fold(0.0, f64::max)
}

/// The best first price at a second price; the point's second excess is that of the mixture of items
/// that uses the first budget exactly.
fn inner(problem: &Problem, q: f64) -> (f64, Point) {
    let mut best = (0.0, f64::NEG_INFINITY);
    let [below, above] = climb(problem, &mut |p| {
        let point = at(problem, [p, q]);
        if point.value > best.1 {
            best = (p, point.value);
        }
        Line {
            price: p,
            value: point.value,
            slope: point.excess[0],
        }
    });
    let low = at(problem, [below.price, q]);
    let high = at(problem, [above.price, q]);
    let range = low.excess[0] - high.excess[0];
    // The weight of the cheaper items, of which the excess is not above 0.
    let mix = if low.excess[0] <= 0.0 || range <= 0.0 {
        0.0
    } else {
        (low.excess[0] / range).min(1.0)
    };
    let excess = low.excess[1] + mix * (high.excess[1] - low.excess[1]);
    let point = Point {
        value: best.1,
        excess: [0.0, excess],
    };
    (best.0, point)
}

fn at(problem: &Problem, price: [f64; 2]) -> Point {
    let mut point = Point {
        value: -price[0] - price[1],
        excess: [-1.0; 2],
    };
    for part in &problem.parts {
        let mut least = f64::INFINITY;
        let mut share = [0.0; 2];
        for item in part {
            let priced = item.priced(price);
            if priced < least {
                (least, share) = (priced, item.share);
            }
        }
        point.value += least;
        point.excess[0] += share[0];
        point.excess[1] += share[1];
    }
    point
}

/// Climbs a concave, piecewise linear function of a price from 0 on: two lines enclose the maximum;
/// where they meet, the function is asked next. Returns the last two lines.
fn climb(problem: &Problem, ask: &mut dyn FnMut(f64) -> Line) -> [Line; 2] {
    let mut low = ask(0.0);
    if low.slope <= 0.0 {
        return [low; 2];
    }
    let mut price = problem.parts.iter().map(|part| worst(part)).sum::<f64>();
    price = price.max(1e-9);
    let mut high = ask(price);
    for _ in 0..DOUBLINGS {
        if high.slope <= 0.0 {
            break;
        }
        low = high;
        price *= 2.0;
        high = ask(price);
    }
    if high.slope > 0.0 {
        return [high; 2];
    }
    for _ in 0..STEPS {
        let range = low.slope - high.slope;
        let meet =
            (high.value - low.value + low.slope * low.price - high.slope * high.price) / range;
        let top = low.value + low.slope * (meet - low.price);
        if !(low.price < meet && meet < high.price) {
            break;
        }
        let found = ask(meet);
        if found.slope > 0.0 {
            low = found;
        } else {
            high = found;
        }
        if found.value >= top - 1e-12 * top.abs().max(1.0) {
            break;
        }
    }
    [low, high]
}
