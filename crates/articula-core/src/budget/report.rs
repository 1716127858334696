//! Report of one frame of the budget allocator.

/// Change of a character's option since the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OptionChange {
    /// Index of the character.
    pub character: u32,
    /// Index of its option before; `None` if it was hidden.
    pub from: Option<u8>,
    /// Index of its option now; `None` if it is hidden.
    pub to: Option<u8>,
}

/// Costs and errors of all visible characters after
/// [`BudgetAllocator::solve`](super::BudgetAllocator::solve).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AllocationReport {
    /// Available cost.
    pub budget: f64,
    /// Cost of the chosen options. More than the budget only if the cheapest options together cost
    /// more.
    pub used: f64,
    /// Cost that would be used without a limit.
    pub demand: f64,
    /// Number of characters that are not hidden.
    pub visible: usize,
    /// Number of visible characters whose error exceeds the cap.
    pub above_cap: usize,
    /// Largest error of a visible character, pixels.
    pub worst_px: f32,
    /// Mean error of the visible characters, pixels.
    pub mean_px: f32,
    /// Number of characters whose option changed.
    pub changes: usize,
}

/// Number of lanes of the sums below, which fits the widest common registers.
const LANES: usize = 8;
/// Number of entries summed in `f32` before the sum is added in `f64`, so that large crowds keep
/// precision.
const BLOCK: usize = 1024;

/// Maximum, sum and number above the cap of `error_metres · pixels_per_metre`. Every entry counts,
/// since a hidden character has no error.
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

/// One row of products, with zeros beyond the end.
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
