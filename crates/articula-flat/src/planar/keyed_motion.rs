//! A motion that many shapes share, as few keys.

use super::keyed_track::KeyedTrack;
use articula_core::Libm;
use glam::{DAffine2, DMat2, DVec2};

/// Units of a translation in a grid step.
pub(crate) const TRANSLATION: f64 = 10.0;
/// Units of a rotation or skew in a degree.
pub(crate) const ANGLE: f64 = 100.0;
/// Units of a scale of 1.
pub(crate) const SCALE: f64 = 10_000.0;

/// An affine motion: shapes are scaled, skewed along x, rotated and translated, in that sequence.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct KeyedMotion {
    /// x and y of the translation, tenths of a grid step.
    pub translation: KeyedTrack,
    /// Rotation from x to y, hundredths of a degree.
    pub rotation: KeyedTrack,
    /// Angle by which the y axis leans towards x, hundredths of a degree.
    pub skew: KeyedTrack,
    /// Factors on x and y, ten-thousandths.
    pub scale: KeyedTrack,
}

impl KeyedMotion {
    /// Map from the coordinates of shapes to those of the picture, grid steps, at a time in frames.
    pub(crate) fn at(&self, frame: f64) -> DAffine2 {
        let pair = |track: &KeyedTrack, unit: f64| {
            let values = track.at(frame);
            DVec2::new(values[0], values[1]) / unit
        };
        let angle = |track: &KeyedTrack| (track.at(frame)[0] / ANGLE).to_radians();
        let skew = DMat2::from_cols(DVec2::X, DVec2::new(angle(&self.skew).libm_tan(), 1.0));
        let (sin, cos) = angle(&self.rotation).libm_sin_cos();
        let rotation = DMat2::from_cols(DVec2::new(cos, sin), DVec2::new(-sin, cos));
        let linear = rotation * skew * DMat2::from_diagonal(pair(&self.scale, SCALE));
        DAffine2::from_mat2_translation(linear, pair(&self.translation, TRANSLATION))
    }

    /// Checks that the tracks belong to a clip with some frames.
    ///
    /// # Errors
    /// What is wrong.
    pub(crate) fn check(&self, frames: u32) -> Result<(), &'static str> {
        let widths = [2, 1, 1, 2];
        for (track, width) in self.tracks().into_iter().zip(widths) {
            track.check(frames)?;
            if track.width != width {
                return Err("a track has another number of values");
            }
        }
        Ok(())
    }

    /// The tracks: translation, rotation, skew, scale.
    pub(crate) fn tracks(&self) -> [&KeyedTrack; 4] {
        [&self.translation, &self.rotation, &self.skew, &self.scale]
    }
}

/// Rotation, skew and scale of a linear map that keeps the orientation: radians, radians, factors.
pub(crate) fn parts(linear: DMat2) -> (f64, f64, DVec2) {
    let [x, y] = [linear.x_axis, linear.y_axis];
    let wide = x.length().max(1e-6);
    let high = (x.perp_dot(y) / wide).max(1e-6);
    (
        x.y.libm_atan2(x.x),
        (x.dot(y) / wide / high).libm_atan2(1.0),
        DVec2::new(wide, high),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_linear_map_is_its_parts(
            angle in -3.0f64..3.0,
            skew in -1.2f64..1.2,
            wide in 0.2f64..3.0,
            high in 0.2f64..3.0,
        ) {
            let still = |values: &[f64]| {
                KeyedTrack::still(values.iter().map(|v| v.round() as i32).collect())
            };
            let degrees = |radians: f64| radians.to_degrees() * ANGLE;
            let motion = KeyedMotion {
                translation: still(&[30.0, -50.0]),
                rotation: still(&[degrees(angle)]),
                skew: still(&[degrees(skew)]),
                scale: still(&[wide * SCALE, high * SCALE]),
            };
            let map = motion.at(0.0);
            prop_assert_eq!(map.translation, DVec2::new(3.0, -5.0));
            let (a, s, scale) = parts(map.matrix2);
            prop_assert!((a - angle).abs() < 2e-4 && (s - skew).abs() < 2e-4);
            prop_assert!((scale - DVec2::new(wide, high)).abs().max_element() < 2e-4);
        }
    }
}
