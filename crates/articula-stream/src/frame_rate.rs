//! The frame rate of MPEG-4's temporal header: sixteenths of a frame, and the factor of NTSC.

use crate::bits::{BitReader, BitWriter};
use crate::error::StreamError;

/// Number of bits.
pub(crate) const BITS: u32 = 13;

/// Frames per second as MPEG-4 writes them: below 256, in sixteenths, possibly times 1000/1001.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FrameRate {
    /// 16 times the rate, without the factor; 1 to 4095.
    sixteenths: u16,
    ntsc: bool,
}

impl FrameRate {
    /// Returns the nearest rate, if there is one within 1/32 of a frame per second.
    ///
    /// ```
    /// use articula_stream::FrameRate;
    ///
    /// assert_eq!(FrameRate::nearest(24.5).map(|rate| rate.hz()), Some(24.5));
    /// let ntsc = FrameRate::nearest(29.97).map(|rate| rate.hz());
    /// assert_eq!(ntsc, Some(30_000.0 / 1001.0));
    /// assert_eq!(FrameRate::nearest(256.0), None);
    /// ```
    pub fn nearest(hz: f64) -> Option<Self> {
        let of = |ntsc: bool| {
            let factor = if ntsc { 1001.0 / 1000.0 } else { 1.0 };
            let sixteenths = (hz * factor * 16.0).round();
            let fits = (1.0..4096.0).contains(&sixteenths);
            fits.then_some(Self {
                sixteenths: sixteenths as u16,
                ntsc,
            })
        };
        let error = |rate: &Self| (rate.hz() - hz).abs();
        let rates = [of(false), of(true)].into_iter().flatten();
        let nearest = rates.min_by(|a, b| error(a).total_cmp(&error(b)))?;
        (error(&nearest) <= 1.0 / 32.0).then_some(nearest)
    }

    /// Returns the frames per second.
    pub fn hz(self) -> f64 {
        let hz = f64::from(self.sixteenths) / 16.0;
        if self.ntsc { hz * 1000.0 / 1001.0 } else { hz }
    }

    /// Returns frames and the seconds that they take, in lowest terms.
    ///
    /// ```
    /// use articula_stream::FrameRate;
    ///
    /// assert_eq!(FrameRate::nearest(24.5).map(|rate| rate.fraction()), Some([49, 2]));
    /// let ntsc = FrameRate::nearest(29.97).map(|rate| rate.fraction());
    /// assert_eq!(ntsc, Some([30_000, 1001]));
    /// ```
    pub fn fraction(self) -> [u32; 2] {
        let frames = u32::from(self.sixteenths);
        let [frames, secs] = if self.ntsc {
            [1000 * frames, 16 * 1001]
        } else {
            [frames, 16]
        };
        let common = common_divisor(frames, secs);
        [frames / common, secs / common]
    }

    pub(crate) fn write(self, out: &mut BitWriter) {
        out.push(12, u64::from(self.sixteenths));
        out.push(1, u64::from(self.ntsc));
    }

    pub(crate) fn read(reader: &mut BitReader<'_>) -> Result<Self, StreamError> {
        let sixteenths = reader.take(BITS - 1)? as u16;
        let ntsc = reader.flag()?;
        if sixteenths == 0 {
            return Err(reader.bad("a frame rate of 0"));
        }
        Ok(Self { sixteenths, ntsc })
    }
}

/// Greatest common divisor of two positive numbers.
fn common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rate_is_the_nearest_to_itself() {
        for sixteenths in 1..4096 {
            for ntsc in [false, true] {
                let rate = FrameRate { sixteenths, ntsc };
                // 1001 sixteenths with the factor are 1000 without it.
                let nearest = FrameRate::nearest(rate.hz()).map(FrameRate::hz);
                assert_eq!(nearest, Some(rate.hz()));
                let [frames, secs] = rate.fraction().map(f64::from);
                assert!((frames / secs - rate.hz()).abs() < 1e-12 * rate.hz());
                let mut out = BitWriter::default();
                rate.write(&mut out);
                assert_eq!(out.bits, u64::from(BITS));
                let mut reader = BitReader::new(&out.bytes, 0..2);
                assert_eq!(FrameRate::read(&mut reader), Ok(rate));
            }
        }
    }

    #[test]
    fn rates_that_cannot_be_written() {
        for hz in [0.0, 0.02, -1.0, 300.0, f64::NAN, f64::INFINITY] {
            assert_eq!(FrameRate::nearest(hz), None, "{hz}");
        }
        // The smallest: one sixteenth with the factor.
        let least = FrameRate::nearest(0.05).map(FrameRate::hz);
        assert_eq!(least, Some(0.0625 * 1000.0 / 1001.0));
    }
}
