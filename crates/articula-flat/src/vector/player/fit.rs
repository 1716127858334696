//! The smallest motion within the tolerances: how many components, how finely written.
//!
//! Source: `docs/methods/vector.md` 8.3. Differs: more components written more coarsely may be smaller
//! than few fine ones, so ranks from the least that can do are tried, each with the coarsest
//! steps that hold, measured on what a reader gets back.

use super::topology::Topology;
use crate::low_rank::quantised::{MAX_STEPS, Quantised, Steps};
use crate::low_rank::{LowRank, Table, decompose};
use crate::planar::shading::Shading;
use crate::planar::{PlanarClip, PlanarError};

/// Ranks that are tried from the least one on.
const RANKS_TRIED: usize = 6;
/// Halvings of the range of step lengths.
const HALVINGS: usize = 6;
/// Most numbers of a table that is decomposed.
const MAX_NUMBERS: usize = 16 << 20;
/// Places and light beyond these are no picture.
const MAX_PLACE_PX: f32 = 1e6;
const MAX_LIGHT: f32 = 1e3;

/// Errors that are allowed, or were found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Errors {
    /// Root of the mean square distance of points, pixels.
    pub(super) position_px: f64,
    /// Root of the mean square of light, 8-bit levels.
    pub(super) light_levels: f64,
}

/// The numbers that are to be written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Numbers {
    pub(super) table: Table,
    /// Columns of places; those after them hold light.
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

    /// The greater of each.
    pub(super) fn max(&self, other: &Self) -> Self {
        Self {
            position_px: self.position_px.max(other.position_px),
            light_levels: self.light_levels.max(other.light_levels),
        }
    }

    /// Weight that makes the allowed errors of a place's number and of light's the same.
    pub(super) fn light_weight(&self) -> f64 {
        let place = self.position_px / std::f64::consts::SQRT_2;
        // A round number, since the container writes it.
        (place * 255.0 / self.light_levels).clamp(1e-3, 1e4).ceil()
    }
}

impl Numbers {
    /// Columns of all frames.
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
                "{count} numbers are more than {MAX_NUMBERS}; choose fewer triangles or frames"
            ));
        }
        let mut values = Vec::with_capacity(count);
        for frame in &clip.frames {
            for v in &topology.point_vertices {
                let place = frame.xy[*v as usize];
                if place.abs().max_element() > MAX_PLACE_PX {
                    return refused(format!("a vertex lies beyond {MAX_PLACE_PX} pixels"));
                }
                values.extend(place.to_array().map(f64::from));
            }
            for v in lit {
                let light = frame.light[*v as usize];
                if light.abs() > MAX_LIGHT {
                    return refused(format!("light is beyond {MAX_LIGHT}"));
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

    /// How far what a reader gets back is from the table.
    pub(super) fn errors(&self, motion: &Quantised) -> Errors {
        let (mut places, mut light) = (0.0, 0.0);
        for r in 0..self.table.rows() {
            let row = self.squares(r, &motion.row(r as f64));
            (places, light) = (places + row.0, light + row.1);
        }
        self.as_errors(self.table.rows(), (places, light))
    }

    /// How far one row is from the table's.
    pub(super) fn errors_of_row(&self, row: usize, found: &[f64]) -> Errors {
        self.as_errors(1, self.squares(row, found))
    }

    /// Sums of squares over places and over light of a row.
    fn squares(&self, row: usize, found: &[f64]) -> (f64, f64) {
        let of = |range: std::ops::Range<usize>| {
            let pairs = found[range.clone()].iter().zip(&self.table.row(row)[range]);
            pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
        };
        (of(0..self.places), of(self.places..found.len()))
    }

    /// Errors of these sums of squares.
    fn as_errors(&self, rows: usize, (places, light): (f64, f64)) -> Errors {
        let mean = |sum: f64, count: usize| (sum / (rows * count.max(1)) as f64).sqrt();
        let light = mean(light, self.table.columns - self.places);
        Errors {
            position_px: mean(places, self.places / 2),
            light_levels: light / self.light_weight * 255.0,
        }
    }

    /// Errors of the first components, for every number of them from none on.
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
            // What rounding leaves may fall below nothing.
            places = (places - of(&component.basis[..self.places])).max(0.0);
            light = (light - of(&component.basis[self.places..])).max(0.0);
            errors.push(self.as_errors(rows, (places, light)));
        }
        errors
    }
}

/// Tries ranks and steps; `size` says how many bytes a motion takes.
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
    let what = "the tolerances are too small for places this far apart".to_owned();
    let at = "tolerances";
    best.map(|(_, motion)| motion)
        .ok_or(PlanarError::Mismatch { at, what })
}

/// The longest steps with which a rank holds, if there are any.
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
    // Powers of two: from a quarter to twice the steps that theory gives.
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

/// Numbers in whole steps, if none of them is too far away.
pub(super) fn whole_steps(values: impl Iterator<Item = f64>, step: f64) -> Option<Vec<i32>> {
    let whole = |v: f64| {
        let steps = (v / step).round();
        (steps.abs() < f64::from(MAX_STEPS)).then_some(steps as i32)
    };
    values.map(whole).collect()
}
