//! Choice of a level, for joints and for meshes: the coarsest within the tolerance, with
//! hysteresis.

/// A coarser level is taken only when its error is below this fraction of the tolerance, so that a
/// character at the limit does not alternate between levels.
const HYSTERESIS: f32 = 0.8;

/// Returns the coarsest level within a tolerance, starting from the level that is shown now. A NaN
/// tolerance gives full detail.
#[inline]
pub(crate) fn level_within(
    tolerance_metres: f32,
    shown: Option<usize>,
    coarsest: usize,
    error_metres: impl Fn(usize) -> f32,
) -> usize {
    let start = shown.unwrap_or(0);
    let mut level = start;
    let fits = |level, part: f32| error_metres(level) <= tolerance_metres * part;
    while level > 0 && !fits(level, 1.0) {
        level -= 1;
    }
    if level == start {
        // A character that just came into view has no level to keep.
        let part = if shown.is_some() { HYSTERESIS } else { 1.0 };
        while level < coarsest && fits(level + 1, part) {
            level += 1;
        }
    }
    level
}

/// Returns the range of pixels per metre in which [`level_within`] keeps a level: below it a
/// coarser level is chosen, above it a finer one.
#[inline]
pub(crate) fn level_range(errors_metres: &[f32], level: usize, px: f32) -> [f32; 2] {
    // Full detail is never too coarse, the coarsest level never too fine. A NaN tolerance keeps no
    // level.
    let most = px / errors_metres[level];
    let least = errors_metres
        .get(level + 1)
        .map_or(0.0, |next| px * HYSTERESIS / next);
    if px > 0.0 {
        [least, most]
    } else {
        [f32::INFINITY, 0.0]
    }
}

/// The same as tolerances in metres: from the error of the level on, included, to that at which the
/// next coarser level, of error `next_metres`, is chosen.
#[inline]
pub(crate) fn tolerance_range(error_metres: f32, next_metres: Option<f32>) -> [f32; 2] {
    let next = next_metres.map_or(f32::INFINITY, |next| next / HYSTERESIS);
    [error_metres, next]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let errors = [0.0, 0.01, 0.02, 0.04];
        let level = |tolerance, shown| level_within(tolerance, shown, 3, |l| errors[l]);
        assert_eq!(level(0.02, None), 2);
        assert_eq!(level(f32::NAN, Some(2)), 0);
        assert_eq!(level(0.0, None), 0);
        assert_eq!(level(9.0, Some(1)), 3);
        // At the limit: kept if it is shown, not chosen if a finer one is.
        assert_eq!(level(0.02, Some(2)), 2);
        assert_eq!(level(0.02, Some(1)), 1);
        assert_eq!(level(0.026, Some(1)), 2);
        assert_eq!(level(0.019, Some(2)), 1);
    }

    #[test]
    fn a_level_is_kept_just_where_it_would_be_chosen_again() {
        let errors = [0.0, 0.01, 0.02, 0.02, 0.04];
        for (px, level) in [0.5, 1.0, 2.0]
            .into_iter()
            .flat_map(|px| (0..5).map(move |l| (px, l)))
        {
            let [least, most] = level_range(&errors, level, px);
            for density in (1..4000).map(|i| i as f32 * 0.1) {
                let again = level_within(px / density, Some(level), 4, |l| errors[l]);
                let kept = (least..most).contains(&density);
                let at_border = [least, most].iter().any(|b| (b - density).abs() < 1e-3 * b);
                assert!(
                    at_border || kept == (again == level),
                    "{px} px, {density} px/m, {level}"
                );
                let metres = px / density;
                let [least, most] = tolerance_range(errors[level], errors.get(level + 1).copied());
                assert!(at_border || kept == (least..most).contains(&metres));
            }
        }
        for none in [f32::NAN, 0.0, -1.0] {
            assert_eq!(level_range(&errors, 1, none), [f32::INFINITY, 0.0]);
        }
    }
}
