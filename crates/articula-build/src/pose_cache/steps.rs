//! Which levels of a clip have palettes to be shown as they are, and how many.

/// Maximum number of palettes a second that are shown as they are: two for each frame of a display.
const MAX_STEP_HZ: f32 = 120.0;

/// Part of the error of a coarser level that a finer one may have to be stepped too.
const WORTH_A_LEVEL: f32 = 0.8;

/// Levels that are worth to be stepped in a clip, and the number of palettes of each, coarsest first:
/// so many that the error of a step is within the tightest tolerance for blending, at most those of
/// [`MAX_STEP_HZ`]. A level whose errors together are not clearly less than those of the coarser
/// ones is left out, since a step costs the same at every level.
pub(super) fn wanted_steps(
    own: &[f32],
    tolerances: &[Vec<f32>],
    (duration_secs, metres_per_sec): (f32, f32),
) -> Vec<(usize, usize)> {
    let mut least = f32::INFINITY;
    let mut wanted = Vec::new();
    for (level, tolerances) in tolerances.iter().enumerate().rev() {
        // The nearest palette is at most half a span away.
        let tolerance = tolerances.first().copied().unwrap_or_default();
        let hz = 0.5 * metres_per_sec / tolerance;
        let hz = if hz > 0.0 { hz.min(MAX_STEP_HZ) } else { 0.0 };
        let spans = (duration_secs * hz)
            .ceil()
            .max(f32::from(duration_secs > 0.0));
        let step_metres = match spans {
            0.0 => 0.0,
            _ => 0.5 * metres_per_sec * duration_secs / spans,
        };
        let error = own.get(level).copied().unwrap_or_default() + step_metres;
        if error < WORTH_A_LEVEL * least {
            least = error;
            wanted.push((level, spans as usize + 1));
        }
    }
    wanted
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wanted(own: &[f32], tolerances: &[f32], way: (f32, f32)) -> Vec<(usize, usize)> {
        let tolerances: Vec<Vec<f32>> = tolerances.iter().map(|t| vec![*t]).collect();
        wanted_steps(own, &tolerances, way)
    }

    #[test]
    fn by_hand() {
        // Two seconds at 3 m/s: within 0.5 m in three steps a second, within 0.05 m in thirty.
        let found = wanted(&[0.0, 0.2, 2.0], &[0.001, 0.05, 0.5], (2.0, 3.0));
        // At the finest level 120 a second are 12.5 mm off.
        assert_eq!(found, [(2, 7), (1, 61), (0, 241)]);
        // A level that is hardly better is left out.
        let found = wanted(&[0.18, 0.2, 2.0], &[0.05, 0.05, 0.5], (2.0, 3.0));
        assert_eq!(found, [(2, 7), (1, 61)]);
        // A pose that does not move, and a clip that takes no time.
        assert_eq!(
            wanted(&[0.0, 0.2], &[0.001, 0.05], (2.0, 0.0)),
            [(1, 2), (0, 2)]
        );
        assert_eq!(
            wanted(&[0.0, 0.2], &[0.001, 0.05], (0.0, 3.0)),
            [(1, 1), (0, 1)]
        );
        assert_eq!(wanted(&[0.0], &[0.0], (0.0, 0.0)), [(0, 1)]);
        // No errors are known without clips.
        assert_eq!(wanted(&[], &[0.0], (0.0, 0.0)), [(0, 1)]);
        // Whatever is wrong with numbers, palettes are limited.
        let found = wanted(&[f32::NAN, 0.1], &[0.0, 0.0], (1.0, f32::INFINITY));
        assert!(found.iter().all(|(_, count)| *count <= 121), "{found:?}");
    }
}
