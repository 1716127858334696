//! What one frame of the budget did.

/// A character whose option is another one than in the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OptionChange {
    /// Which character.
    pub character: u32,
    /// Its option before; nothing if it was hidden.
    pub from: Option<u8>,
    /// Its option now; nothing if it is hidden.
    pub to: Option<u8>,
}

/// Sums over all visible characters after a frame was solved.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AllocationReport {
    /// What could be spent.
    pub budget: f64,
    /// What is spent. More than the budget only if the cheapest options together cost more.
    pub used: f64,
    /// What would be spent if there were no limit.
    pub demand: f64,
    /// Characters that are not hidden.
    pub visible: usize,
    /// Visible characters whose error exceeds the cap.
    pub above_cap: usize,
    /// Largest error of a visible character, pixels.
    pub worst_px: f32,
    /// Mean error of the visible characters, pixels.
    pub mean_px: f32,
    /// Characters whose option changed.
    pub changes: usize,
}

/// Number of lanes of the sums below: what the widest usual registers hold.
const LANES: usize = 8;
/// Entries that are summed before the sum is widened, so that large crowds lose no digits.
const BLOCK: usize = 1024;

/// Worst, sum and number above the cap of `error_metres · pixels_per_metre`. Every entry counts:
/// a hidden character has no error.
pub(super) fn survey(
    error_metres: &[f32],
    pixels_per_metre: &[f32],
    cap_px: f32,
) -> (f32, f64, usize) {
    let (mut worst, mut sum, mut above) = ([0.0_f32; LANES], 0.0_f64, 0_usize);
    let blocks = error_metres
        .chunks(BLOCK)
        .zip(pixels_per_metre.chunks(BLOCK));
    for (errors, scales) in blocks {
        let (mut sums, mut counts) = ([0.0_f32; LANES], [0_u32; LANES]);
        let rows = errors.chunks(LANES).zip(scales.chunks(LANES));
        for (errors, scales) in rows {
            let px = row(errors, scales);
            for l in 0..LANES {
                worst[l] = if px[l] > worst[l] { px[l] } else { worst[l] };
                sums[l] += px[l];
                counts[l] += u32::from(px[l] > cap_px);
            }
        }
        sum += sums.iter().map(|s| f64::from(*s)).sum::<f64>();
        above += counts.iter().sum::<u32>() as usize;
    }
    (worst.into_iter().fold(0.0, f32::max), sum, above)
}

/// One row of products, zeros behind the end.
fn row(errors: &[f32], scales: &[f32]) -> [f32; LANES] {
    let mut px = [0.0; LANES];
    if let (Ok(errors), Ok(scales)) = (
        <&[f32; LANES]>::try_from(errors),
        <&[f32; LANES]>::try_from(scales),
    ) {
        for l in 0..LANES {
            px[l] = errors[l] * scales[l];
        }
    } else {
        for ((px, error), scale) in px.iter_mut().zip(errors).zip(scales) {
            *px = error * scale;
        }
    }
    px
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_survey_by_hand() {
        // 1, 2, 3 … 11 px: the sum is 66, the last row is a short one, three exceed 8 px.
        let errors: Vec<f32> = (1..=11).map(|i| 0.01 * i as f32).collect();
        let (worst, sum, above) = survey(&errors, &[100.0; 11], 8.0001);
        assert!((worst - 11.0).abs() < 1e-5);
        assert!((sum - 66.0).abs() < 1e-4);
        assert_eq!(above, 3);
        assert_eq!(survey(&[], &[], 1.0), (0.0, 0.0, 0));
    }

    #[test]
    fn sums_of_large_crowds_keep_their_digits() {
        let n = 1_000_003;
        let (_, sum, _) = survey(&vec![0.1; n], &vec![1.0; n], 1.0);
        let expected = n as f64 * f64::from(0.1_f32);
        assert!((sum / expected - 1.0).abs() < 1e-6, "{sum}");
    }
}
