//! Numbers of few digits: a manifest is the first that a client fetches, and digits are half of it.

use super::manifest::Manifest;
use super::part::{ItemLayer, ItemPart};

impl Manifest {
    /// Rounds all errors up to four digits, so that bounds stay bounds.
    pub(super) fn round_errors(&mut self) {
        self.parts.iter_mut().for_each(ItemPart::round_errors);
        for form in &mut self.flat {
            form.error_px = up(form.error_px);
        }
    }
}

impl ItemPart {
    fn round_errors(&mut self) {
        self.base_error_m = self.base_error_m.map(up);
        self.layers.iter_mut().for_each(ItemLayer::round_errors);
        for level in &mut self.levels {
            for error in [
                &mut level.error_rest_m,
                &mut level.error_motion_m,
                &mut level.error_motion_p95_m,
            ] {
                *error = up(*error);
            }
        }
        for region in self.regions.iter_mut().chain(&mut self.face_levels) {
            region.error_without_m = region.error_without_m.map(up);
        }
    }
}

impl ItemLayer {
    fn round_errors(&mut self) {
        self.error_m = up(self.error_m);
        self.error_mean_m = self.error_mean_m.map(up);
        self.error_alone_m = self.error_alone_m.map(up);
        self.texel_m = self.texel_m.map(up);
        for view in &mut self.views {
            for number in [&mut view.rms_levels, &mut view.error_px] {
                *number = up(*number);
            }
            view.texel_px = view.texel_px.map(up);
        }
    }
}

/// The least number of four significant decimal digits that is not below a number.
fn up(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return x;
    }
    let rounded = |x: f64| format!("{x:.3e}").parse().unwrap_or(x);
    let nearest: f64 = rounded(x);
    if nearest >= x {
        return nearest;
    }
    let digit = 10_f64.powi(x.log10().floor() as i32 - 3);
    rounded(nearest + digit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn few_digits_are_never_below() {
        assert_eq!(up(0.149_256_944_656), 0.1493);
        assert_eq!(up(0.149_2), 0.1492);
        assert_eq!(up(0.149_200_000_001), 0.1493);
        assert_eq!((up(9.999_1), up(1e-7), up(0.0)), (10.0, 1e-7, 0.0));
    }

    proptest! {
        #[test]
        fn rounding_keeps_bounds_and_order(mantissa in 1.0..10.0_f64, exponent in -12..6_i32, more in 1.0..2.0_f64) {
            let x = mantissa * 10_f64.powi(exponent);
            let rounded = up(x);
            prop_assert!(rounded >= x && rounded <= 1.001 * x * (1.0 + 1e-12), "{x} {rounded}");
            prop_assert!(up(x * more) >= rounded);
            prop_assert_eq!(up(rounded), rounded);
            prop_assert!(format!("{rounded:e}").len() <= 9, "{rounded:e}");
        }
    }
}
