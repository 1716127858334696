//! A stream as the samples of a track: its head, its access units and their durations.

use crate::abp2::{MotionHead, motion_map};
use crate::error::StreamError;
use crate::frame_rate::FrameRate;
use crate::kind::StreamKind;
use crate::limits::StreamLimits;
use crate::unit::Unit;
use crate::{abp1, afp1, fba};

/// A stream cut into samples; head and samples in this order are its bytes.
pub(super) struct Samples<'a> {
    pub(super) kind: StreamKind,
    /// What comes before the first access unit.
    pub(super) head: &'a [u8],
    pub(super) samples: Vec<Sample<'a>>,
    /// Ticks in a second.
    pub(super) timescale: u32,
}

/// An access unit with its length, or a whole stream that has no map.
pub(super) struct Sample<'a> {
    pub(super) bytes: &'a [u8],
    /// Duration in ticks.
    pub(super) ticks: u32,
}

impl<'a> Samples<'a> {
    /// Cuts a stream by its map.
    pub(super) fn of(stream: &'a [u8], limits: &StreamLimits) -> Result<Self, StreamError> {
        let unknown = || {
            let what = "none of the streams of animations (ABP-1, ABP-2, AFP-1, AFP-2, FBA)";
            StreamError::malformed("byte 0", what)
        };
        let kind = StreamKind::of(stream).ok_or_else(unknown)?;
        let (map, [timescale, per_frame], frames) = match kind {
            StreamKind::Abp1 => {
                let (rate, frames) = abp1::frames_of(stream, limits)?;
                (abp1::unit(stream, limits)?, rate.fraction(), frames)
            }
            StreamKind::Afp1 => {
                let (rate, frames) = afp1::frames_of(stream, limits)?;
                (afp1::unit(stream, limits)?, rate.fraction(), frames)
            }
            StreamKind::Abp2 | StreamKind::Afp2 => {
                let head = MotionHead::open(stream, limits)?;
                let frames = (0..head.access_units).map(|unit| head.frames_of(unit).len());
                let frames = frames.collect();
                (motion_map(stream, limits)?, fraction(head.rate_hz)?, frames)
            }
            StreamKind::Fba => {
                let clip = fba::read(stream, limits)?.clip;
                let frames = clip.frames.last().map_or(0, |frame| frame.number + 1);
                let map = Unit {
                    children: vec![
                        Unit::of_bytes("head", 0..0),
                        Unit::of_bytes("stream", 0..stream.len()),
                    ],
                    ..Unit::of_bytes("fba", 0..stream.len())
                };
                (map, clip.rate.fraction(), vec![frames as usize])
            }
        };
        let bytes =
            |unit: &Unit| &stream[(unit.bits.start / 8) as usize..(unit.bits.end / 8) as usize];
        let (head, units) = map.children.split_first().ok_or_else(unknown)?;
        let sample = |(unit, frames): (&Unit, usize)| {
            let ticks = (frames as u64).checked_mul(u64::from(per_frame));
            let ticks = ticks.and_then(|ticks| u32::try_from(ticks).ok());
            Ok(Sample {
                bytes: bytes(unit),
                ticks: ticks.ok_or_else(|| unsupported_rate(timescale, per_frame))?,
            })
        };
        Ok(Self {
            kind,
            head: bytes(head),
            samples: units
                .iter()
                .zip(frames)
                .map(sample)
                .collect::<Result<_, StreamError>>()?,
            timescale,
        })
    }
}

fn unsupported_rate(frames: u32, secs: u32) -> StreamError {
    rate_error(format!("{frames} frames in {secs} s"))
}

fn rate_error(rate: String) -> StreamError {
    StreamError::Unsupported {
        at: "head".into(),
        what: format!("a rate of {rate} in MP4"),
        mend: "resample the clip, for example to 30 frames per second".into(),
    }
}

/// Returns frames and the seconds that they take, in lowest terms, of a rate above 0: those of
/// [`FrameRate`] if its float is the same, else those that the float has exactly.
fn fraction(hz: f32) -> Result<[u32; 2], StreamError> {
    let usual = FrameRate::nearest(f64::from(hz)).filter(|rate| rate.hz() as f32 == hz);
    if let Some(rate) = usual {
        return Ok(rate.fraction());
    }
    // A float is a whole number of 24 bits times a power of 2; 64 bits hold both of its terms.
    let (mut frames, mut secs) = (f64::from(hz), 1.0);
    while frames.fract() != 0.0 && secs < f64::from(u32::MAX) {
        frames *= 2.0;
        secs *= 2.0;
    }
    let is_exact = frames.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(&frames);
    if !is_exact || secs > f64::from(u32::MAX) {
        return Err(rate_error(format!("{hz} hertz")));
    }
    Ok([frames as u32, secs as u32])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timescales_are_exact() {
        assert_eq!(fraction(30.0), Ok([30, 1]));
        assert_eq!(fraction(24.5), Ok([49, 2]));
        assert_eq!(fraction((30_000.0 / 1001.0) as f32), Ok([30_000, 1001]));
        assert_eq!(fraction((24_000.0 / 1001.0) as f32), Ok([24_000, 1001]));
        // Rates that MPEG-4 does not have: a third of 2^-24 and the like are what the float is.
        for hz in [33.333_332_f32, 0.1, 1000.5, 120.119_88, 1e6, 29.97, 1e9] {
            let [frames, secs] = fraction(hz).unwrap();
            assert_eq!(f64::from(frames) / f64::from(secs), f64::from(hz));
        }
        for hz in [1e-30_f32, 1e30, f32::MIN_POSITIVE, f32::MAX] {
            assert!(fraction(hz).unwrap_err().to_string().contains("resample"));
        }
    }
}
