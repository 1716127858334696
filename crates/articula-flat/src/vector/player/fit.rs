//! The smallest motion within the tolerances: number of components and quantisation steps.
//!
//! Source: `docs/methods/vector.md` 8.3. More components with coarser steps may be smaller than few
//! with fine ones, so several ranks from the minimum on are tried, each with the coarsest steps
//! that are within the tolerances, measured on the decoded result.

use super::topology::Topology;
use crate::low_rank::quantised::{MAX_STEPS, Quantised, Steps};
use crate::low_rank::{LowRank, Table, decompose};
use crate::planar::shading::Shading;
use crate::planar::{PlanarClip, PlanarError};

/// Number of ranks tried after the minimum.
const RANKS_TRIED: usize = 6;
/// Bisections of the range of steps.
const HALVINGS: usize = 6;
/// Maximum size of a matrix that is decomposed.
const MAX_NUMBERS: usize = 16 << 20;
/// Maximum absolute position that is accepted, pixels.
const MAX_PLACE_PX: f32 = 1e6;
const MAX_LIGHT: f32 = 1e3;

/// Errors: allowed or measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Errors {
    /// RMS distance of points, pixels.
    pub(super) position_px: f64,
    /// RMS error of light, 8-bit levels.
    pub(super) light_levels: f64,
}

/// Matrix of the numbers to be written, one row per frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Numbers {
    pub(super) table: Table,
    /// Number of position columns; the columns after them hold light.
    pub(super) places: usize,
    pub(super) light_weight: f64,
}

impl Errors {
    pub(super) fn holds(&self, allowed: &Self) -> bool {
        self.position_px <= allowed.position_px && self.light_levels <= allowed.light_levels
    }

    fn times(&self, factor: f64) -> Self {
        Self {
            position_px: self.position_px * factor,
            light_levels: self.light_levels * factor,
        }
    }

    /// The maximum of each error.
    pub(super) fn max(&self, other: &Self) -> Self {
        Self {
            position_px: self.position_px.max(other.position_px),
            light_levels: self.light_levels.max(other.light_levels),
        }
    }

    /// Light weight with which the allowed errors of a position number and a light number are
    /// equal.
    pub(super) fn light_weight(&self) -> f64 {
        let place = self.position_px / std::f64::consts::SQRT_2;
        // A whole number, since the container stores it.
        (place * 255.0 / self.light_levels).clamp(1e-3, 1e4).ceil()
    }
}

impl Numbers {
    /// Builds the matrix of all frames.
    pub(super) fn new(
        clip: &PlanarClip,
        topology: &Topology,
        shading: Shading,
        light_weight: f64,
    ) -> Result<Self, PlanarError> {
        let refused = |what: String| Err(PlanarError::Mismatch { at: "clip", what });
        let places = 2 * topology.point_vertices.len();
        let lit: &[u32] = match shading {
            Shading::Flat => &[],
            Shading::Gouraud => &topology.wedge_vertices,
        };
        let columns = places + lit.len();
        let count = columns * clip.frames.len();
        if count > MAX_NUMBERS {
            return refused(format!(
                "{count} values, the limit is {MAX_NUMBERS}; choose fewer triangles or frames"
            ));
        }
        let mut values = Vec::with_capacity(count);
        for frame in &clip.frames {
            for v in &topology.point_vertices {
                let place = frame.xy[*v as usize];
                if place.abs().max_element() > MAX_PLACE_PX {
                    return refused(format!(
                        "a vertex is farther than {MAX_PLACE_PX} pixels from the origin"
                    ));
                }
                values.extend(place.to_array().map(f64::from));
            }
            for v in lit {
                let light = frame.light[*v as usize];
                if light.abs() > MAX_LIGHT {
                    return refused(format!("the light of a vertex exceeds {MAX_LIGHT}"));
                }
                values.push(f64::from(light) * light_weight);
            }
        }
        Ok(Self {
            table: Table { columns, values },
            places,
            light_weight,
        })
    }

    /// Errors of the decoded motion.
    pub(super) fn errors(&self, motion: &Quantised) -> Errors {
        let (mut places, mut light) = (0.0, 0.0);
        for r in 0..self.table.rows() {
            let row = self.squares(r, &motion.row(r as f64));
            (places, light) = (places + row.0, light + row.1);
        }
        self.as_errors(self.table.rows(), (places, light))
    }

    /// Errors of one decoded row.
    pub(super) fn errors_of_row(&self, row: usize, found: &[f64]) -> Errors {
        self.as_errors(1, self.squares(row, found))
    }

    /// Sums of squared errors of positions and of light in a row.
    fn squares(&self, row: usize, found: &[f64]) -> (f64, f64) {
        let of = |range: std::ops::Range<usize>| {
            let pairs = found[range.clone()].iter().zip(&self.table.row(row)[range]);
            pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
        };
        (of(0..self.places), of(self.places..found.len()))
    }

    /// Converts sums of squares to errors.
    fn as_errors(&self, rows: usize, (places, light): (f64, f64)) -> Errors {
        let mean = |sum: f64, count: usize| (sum / (rows * count.max(1)) as f64).sqrt();
        let light = mean(light, self.table.columns - self.places);
        Errors {
            position_px: mean(places, self.places / 2),
            light_levels: light / self.light_weight * 255.0,
        }
    }

    /// Errors of the first components, for every number of them from zero on.
    fn truncated(&self, low: &LowRank) -> Vec<Errors> {
        let rows = self.table.rows();
        let (mut places, mut light) = (0.0, 0.0);
        for r in 0..rows {
            let row = self.squares(r, &low.mean);
            (places, light) = (places + row.0, light + row.1);
        }
        let mut errors = vec![self.as_errors(rows, (places, light))];
        for component in &low.components {
            let energy = component.energy();
            let of = |part: &[f64]| energy * part.iter().map(|b| b * b).sum::<f64>();
            // Rounding may leave a negative rest.
            places = (places - of(&component.basis[..self.places])).max(0.0);
            light = (light - of(&component.basis[self.places..])).max(0.0);
            errors.push(self.as_errors(rows, (places, light)));
        }
        errors
    }
}

/// Tries ranks and steps; `size` returns the bytes of a motion.
pub(super) fn fit(
    numbers: &Numbers,
    allowed: &Errors,
    size: impl Fn(&Quantised) -> usize,
) -> Result<Quantised, PlanarError> {
    let least = |low: &LowRank| {
        let errors = numbers.truncated(low);
        errors.iter().position(|e| e.holds(&allowed.times(0.9)))
    };
    let low = decompose(&numbers.table, |low| {
        least(low).is_some_and(|rank| rank + RANKS_TRIED <= low.components.len())
    });
    let errors = numbers.truncated(&low);
    let first = least(&low).unwrap_or(low.components.len());
    let last = (first + RANKS_TRIED).min(low.components.len());
    let mut best: Option<(usize, Quantised)> = None;
    for (rank, truncated) in errors.iter().enumerate().take(last + 1).skip(first) {
        let Some(motion) = coarsest(numbers, &low, rank, (truncated, allowed)) else {
            continue;
        };
        let bytes = size(&motion);
        if best.as_ref().is_none_or(|(least, _)| bytes < *least) {
            best = Some((bytes, motion));
        }
    }
    let what =
        "the tolerances are too small for positions this far apart; choose larger ones".to_owned();
    let at = "tolerances";
    best.map(|(_, motion)| motion)
        .ok_or(PlanarError::Mismatch { at, what })
}

/// Quantises a rank with the longest steps that are within the tolerances; `None` if there are
/// none.
fn coarsest(
    numbers: &Numbers,
    low: &LowRank,
    rank: usize,
    (truncated, allowed): (&Errors, &Errors),
) -> Option<Quantised> {
    let left = |allowed: f64, lost: f64| allowed * allowed - lost * lost;
    let places = left(allowed.position_px, truncated.position_px) / 2.0;
    let light =
        left(allowed.light_levels, truncated.light_levels) * (numbers.light_weight / 255.0).powi(2);
    let has_light = numbers.places < numbers.table.columns;
    let variance = if has_light { places.min(light) } else { places };
    let table = &numbers.table;
    let steps = Steps::of_variance(variance.max(1e-18), rank, table.rows(), table.columns);
    let holding = |factor: f64| {
        let motion = Quantised::new(low, rank, steps.times(factor))?;
        numbers.errors(&motion).holds(allowed).then_some(motion)
    };
    // Powers of two: from a quarter to twice the theoretical steps.
    let (mut low_power, mut high_power) = (-2.0f64, 1.0f64);
    let mut best = holding(low_power.exp2())?;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low_power + high_power);
        match holding(middle.exp2()) {
            Some(motion) => (best, low_power) = (motion, middle),
            None => high_power = middle,
        }
    }
    Some(best)
}

/// Rounds numbers to integer steps; `None` if one is out of range.
pub(super) fn whole_steps(values: impl Iterator<Item = f64>, step: f64) -> Option<Vec<i32>> {
    let whole = |v: f64| {
        let steps = (v / step).round();
        (steps.abs() < f64::from(MAX_STEPS)).then_some(steps as i32)
    };
    values.map(whole).collect()
}
