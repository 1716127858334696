//! The adaptation ratio of the thesis: the share of the content that network or device allow.
//!
//! Source: thesis 3.2.1 and 3.2.2, whose fraction bars are lost in the scan; they are restored here
//! from the prose and the one worked value.

/// What a network carries within the time that somebody is prepared to wait.
///
/// ```
/// use articula_stream::decide::NetworkShare;
///
/// // 64 kbit/s for 2 s, of content of 32,000 bytes.
/// let share = NetworkShare { bits_per_second: 64e3, window_secs: 2.0, content_bits: 256e3 };
/// assert_eq!(share.ratio(), 0.5);
/// assert_eq!(share.bytes_allowed(), 16_000);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NetworkShare {
    /// Available bandwidth `C_B`, bits per second.
    pub bits_per_second: f64,
    /// Time to transfer, `T_W`, seconds; of a stream, the stretch of content that is decided on.
    pub window_secs: f64,
    /// Size `F_S` at full quality of what is transferred in that time, **bits**.
    pub content_bits: f64,
}

impl NetworkShare {
    /// `R_A = min(1, C_B · T_W / F_S)`: the share of the content's bits that fits, 0 to 1. The size after
    /// adaptation is `R_A` times the size before.
    ///
    /// The prose of the thesis says the inverse, "the ratio of the original file to the adapted
    /// file". With it a faster network would mean more adaptation, and the rule of 3.2.2 (adapt
    /// below 1) would not hold, so the formula is taken as adapted to original.
    ///
    /// Content without bits gives 1; what is negative or NaN counts as 0.
    pub fn ratio(&self) -> f64 {
        let carried = self.bits_allowed();
        let content = positive(self.content_bits);
        if carried >= content {
            1.0
        } else {
            carried / content
        }
    }

    /// The number of whole bytes that fit, whatever the size of the content.
    pub fn bytes_allowed(&self) -> u64 {
        (self.bits_allowed() / 8.0) as u64
    }

    fn bits_allowed(&self) -> f64 {
        positive(self.bits_per_second) * positive(self.window_secs)
    }
}

/// Results of a benchmark on a reference machine and on the user's device.
///
/// ```
/// use articula_stream::decide::DeviceBenchmark;
///
/// let mut device = DeviceBenchmark {
///     reference_fps: 50.0,
///     wanted_fps: 25.0,
///     reference_score: 90.0,
///     device_score: 30.0,
///     share: 1.0,
/// };
/// assert_eq!(device.media_ratio(), 2.0);
/// assert_eq!(device.device_ratio(), 3.0);
/// // A device three times slower shows 50 / 3 frames per second, two thirds of the 25 wanted.
/// assert!((device.ratio() - 2.0 / 3.0).abs() < 1e-12);
/// device.device_score = 60.0;
/// assert!(device.ratio() > 1.0, "no adaptation");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceBenchmark {
    /// Frame rate `F_R` that the reference machine reaches with the full content, frames per second.
    pub reference_fps: f64,
    /// Frame rate `F_D` wanted on the device.
    pub wanted_fps: f64,
    /// Benchmark score `B_R` of the reference machine; a larger score is faster.
    pub reference_score: f64,
    /// Score `B_D` of the device in the same benchmark.
    pub device_score: f64,
    /// Share `C_R` of the device that this content may use, 0 to 1; 1 if it does nothing else.
    pub share: f64,
}

impl DeviceBenchmark {
    /// Media ratio `M_r = F_R / F_D`; the worked value of the thesis is `50 / 25 = 2`.
    pub fn media_ratio(&self) -> f64 {
        divided(self.reference_fps, self.wanted_fps)
    }

    /// Benchmark ratio `D_r = B_R / B_D`: how many times slower than the reference the device is.
    pub fn device_ratio(&self) -> f64 {
        divided(self.reference_score, self.device_score)
    }

    /// `R_A = (M_r / D_r) · C_R`: the share of the content's cost that the device can bear. Below 1,
    /// adaptation is required; from 1 on, none.
    ///
    /// The device shows `F_R / D_r` frames per second of the full content; divided by the wanted
    /// `F_D` that is `M_r / D_r`. A sentence of the thesis contradicts this: `D_r` above 1 would need
    /// no adaptation. With `D_r = B_R / B_D` as printed, a value above 1 is a *slower* device. The
    /// sentence holds for the inverse `B_D / B_R`, with which the product `M_r · D_r · C_R` is the same
    /// number as here.
    ///
    /// Without a score of the device or a wanted rate nothing limits: infinity. What is negative or
    /// NaN counts as 0.
    pub fn ratio(&self) -> f64 {
        let can = positive(self.reference_fps)
            * positive(self.device_score)
            * positive(self.share).min(1.0);
        let wanted = positive(self.wanted_fps) * positive(self.reference_score);
        divided(can, wanted)
    }

    /// The cost per frame that the device can bear, nanoseconds on the reference machine, of content
    /// whose full cost there is `full_ns`.
    pub fn frame_ns_allowed(&self, full_ns: u64) -> u64 {
        (self.ratio().min(1.0) * full_ns as f64) as u64
    }
}

/// Returns the finest level whose share of the full content is within an adaptation ratio; `None`
/// if even the coarsest needs more, so that another representation is needed.
///
/// `shares` has the size, or the cost, of each level as a fraction of that of level 0. A ratio of 1
/// or more allows level 0.
pub fn finest_level(ratio: f64, shares: &[f64]) -> Option<usize> {
    let fits = |share: &f64| *share <= ratio;
    match shares {
        [] => None,
        _ if ratio >= 1.0 => Some(0),
        shares => shares.iter().position(fits),
    }
}

fn positive(value: f64) -> f64 {
    if value > 0.0 { value } else { 0.0 }
}

fn divided(above: f64, below: f64) -> f64 {
    let (above, below) = (positive(above), positive(below));
    if below == 0.0 {
        f64::INFINITY
    } else {
        above / below
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn device(reference_fps: f64, wanted_fps: f64, scores: [f64; 2]) -> DeviceBenchmark {
        DeviceBenchmark {
            reference_fps,
            wanted_fps,
            reference_score: scores[0],
            device_score: scores[1],
            share: 1.0,
        }
    }

    #[test]
    fn the_worked_value_of_the_thesis() {
        assert_eq!(device(50.0, 25.0, [1.0, 1.0]).media_ratio(), 2.0);
    }

    #[test]
    fn a_slower_device_needs_adaptation_though_its_ratio_is_above_one() {
        let slow = device(50.0, 25.0, [100.0, 25.0]);
        assert_eq!(slow.device_ratio(), 4.0);
        assert_eq!(slow.ratio(), 0.5);
        // Read as in the sentence of the thesis, D_r above 1 is a faster device.
        let fast = device(50.0, 25.0, [25.0, 100.0]);
        assert_eq!(fast.ratio(), 8.0);
        let half = DeviceBenchmark { share: 0.5, ..slow };
        assert_eq!(half.ratio(), 0.25);
        assert_eq!(half.frame_ns_allowed(1000), 250);
        assert_eq!(fast.frame_ns_allowed(1000), 1000);
    }

    #[test]
    fn levels_by_ratio() {
        let shares = [1.0, 0.6, 0.25, 0.1];
        let of = |ratio| finest_level(ratio, &shares);
        assert_eq!(of(3.0), Some(0));
        assert_eq!(of(0.99), Some(1));
        assert_eq!(of(0.25), Some(2));
        assert_eq!(of(0.09), None);
        assert_eq!(of(f64::NAN), None);
        assert_eq!(finest_level(2.0, &[]), None);
    }

    #[test]
    fn what_is_no_number_counts_as_nothing() {
        let share = |bits_per_second, content_bits| NetworkShare {
            bits_per_second,
            window_secs: 1.0,
            content_bits,
        };
        assert_eq!(share(f64::NAN, 100.0).ratio(), 0.0);
        assert_eq!(share(-5.0, 100.0).ratio(), 0.0);
        assert_eq!(share(0.0, 0.0).ratio(), 1.0);
        assert_eq!(share(1e9, 1.0).ratio(), 1.0);
        assert_eq!(device(50.0, 0.0, [1.0, 1.0]).ratio(), f64::INFINITY);
        assert_eq!(device(50.0, 25.0, [1.0, f64::NAN]).ratio(), 0.0);
    }

    proptest! {
        #[test]
        fn the_ratio_of_a_network_is_the_share_that_arrives_in_time(
            bits_per_second in 0.0_f64..1e8,
            window_secs in 0.0_f64..100.0,
            content_bits in 1.0_f64..1e9,
        ) {
            let ratio = NetworkShare { bits_per_second, window_secs, content_bits }.ratio();
            prop_assert!((0.0..=1.0).contains(&ratio));
            // The adapted content takes the window, or less if nothing was to be adapted.
            let secs = ratio * content_bits / bits_per_second;
            prop_assert!(ratio == 0.0 || secs <= window_secs * (1.0 + 1e-12));
        }
    }
}
