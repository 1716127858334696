//! Look-up tables: results by the values of some inputs.

use articula_core::Mismatch;

/// Greatest number of axes.
const AXES: usize = 8;

/// An input of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name of its pin.
    pub pin: String,
    /// Its values, rising, at least one.
    pub values: Vec<f64>,
}

/// A result of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Content {
    /// Name of its pin.
    pub pin: String,
    /// A value for each combination of values of the axes; the last axis runs fastest.
    pub values: Vec<f64>,
    /// Whether values between those of the axes are interpolated. Otherwise the greatest value up to
    /// that of the input counts.
    pub is_linear: bool,
}

/// A table of one to eight inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct LookUpTable {
    /// Inputs.
    pub axes: Vec<Axis>,
    /// Results.
    pub contents: Vec<Content>,
}

impl LookUpTable {
    pub(super) fn check(&self) -> Result<(), Mismatch> {
        let named = self
            .contents
            .first()
            .map_or("LookUpTable", |c| c.pin.as_str());
        if !(1..=AXES).contains(&self.axes.len()) || self.contents.is_empty() {
            let what = format!(
                "{} axes, expected 1 to {AXES} and a content",
                self.axes.len()
            );
            return Err(Mismatch::new(named, what));
        }
        for axis in &self.axes {
            super::finite(&axis.pin, &axis.values)?;
            let rise = axis.values.windows(2).all(|pair| pair[0] < pair[1]);
            if axis.values.is_empty() || !rise {
                return Err(Mismatch::new(axis.pin.as_str(), "expected rising values"));
            }
        }
        let cells = self
            .axes
            .iter()
            .try_fold(1_usize, |all, axis| all.checked_mul(axis.values.len()));
        for content in &self.contents {
            super::finite(&content.pin, &content.values)?;
            if cells != Some(content.values.len()) {
                let lengths: Vec<usize> = self.axes.iter().map(|axis| axis.values.len()).collect();
                let what = format!("{} values for axes of {lengths:?}", content.values.len());
                return Err(Mismatch::new(content.pin.as_str(), what));
            }
        }
        Ok(())
    }

    /// The value of a checked content at a point, one number for each axis.
    pub(super) fn value(&self, content: &Content, point: &[f64]) -> f64 {
        // For each axis the value below, and the part of the way to the next one.
        let places: Vec<(usize, f64)> = self
            .axes
            .iter()
            .zip(point)
            .map(|(axis, at)| {
                let below = axis
                    .values
                    .partition_point(|value| value <= at)
                    .saturating_sub(1);
                let (from, next) = (axis.values[below], axis.values.get(below + 1));
                let part = next.map_or(0.0, |next| ((at - from) / (next - from)).clamp(0.0, 1.0));
                (below, part)
            })
            .collect();
        let corners = if content.is_linear {
            1_usize << places.len()
        } else {
            1
        };
        let mut sum = 0.0;
        for corner in 0..corners {
            let (mut cell, mut weight) = (0, 1.0);
            for (number, ((below, part), axis)) in places.iter().zip(&self.axes).enumerate() {
                let is_next = corner >> number & 1 == 1;
                weight *= match (content.is_linear, is_next) {
                    (false, _) => 1.0,
                    (true, true) => *part,
                    (true, false) => 1.0 - part,
                };
                let place = (below + usize::from(is_next)).min(axis.values.len() - 1);
                cell = cell * axis.values.len() + place;
            }
            if weight > 0.0 {
                sum += weight * content.values[cell];
            }
        }
        sum
    }
}
