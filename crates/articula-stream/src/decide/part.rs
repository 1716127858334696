//! Parts of a character that are adapted together, with their options.
//!
//! Source: thesis 7.2.1 (animation and representation adapted in harmony); `docs/methods/adaptation.md`
//! part 3.

use articula_core::{Mismatch, Viewport};

/// Maximum number of parts of one decision.
pub(super) const MAX_PARTS: usize = 16;
/// Maximum number of options of a part.
pub const MAX_OPTIONS: usize = 255;
/// Bytes and nanoseconds of an option from which on it is refused; sums then never overflow.
pub(super) const MOST: u64 = 1 << 48;

/// What a part is. Preferences name a part by its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PartKind {
    /// Motion of the body.
    BodyMotion,
    /// Motion of the face.
    FaceMotion,
    /// The mesh.
    Mesh,
    /// Textures.
    Texture,
    /// Anything else, such as cloth.
    Other,
}

/// One way to send and show a part. Bytes include all that the option builds on.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PartOption {
    /// Name for explanations, such as `tier 2`.
    pub name: String,
    /// Bytes that are sent once, such as a mesh or the head of a stream.
    pub bytes_once: u64,
    /// Bytes for each second of content.
    pub bytes_per_second: f64,
    /// Time per frame to decode, evaluate and draw it, nanoseconds.
    pub frame_ns: u64,
    /// Bytes of memory that it takes once it is decoded.
    pub memory_bytes: u64,
    /// Greatest distance of the shown skin from its true position because of this option, metres.
    pub error_m: f64,
    /// Error that does not depend on the distance, pixels.
    pub error_px: f64,
    /// Level of the option, 0 is the finest.
    pub level: u32,
    /// Level of articulation, as numbered by H-Anim.
    pub loa: Option<u32>,
    /// Bits of the regions of the body or face that it moves or holds.
    pub regions: Option<u32>,
}

impl PartOption {
    /// Error at a number of pixels per metre, pixels.
    pub fn pixels(&self, pixels_per_metre: f64) -> f64 {
        self.error_m * pixels_per_metre + self.error_px
    }

    /// Bytes for `window_secs` of content, for a client that already has `held` of the bytes that
    /// are sent once; at most 2^48.
    pub fn bytes(&self, window_secs: f64, held: u64) -> u64 {
        let streamed = (self.bytes_per_second * window_secs).ceil() as u64;
        let once = self.bytes_once.saturating_sub(held);
        once.saturating_add(streamed).min(MOST)
    }
}

/// A part of a character: exactly one of its options is chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Name for explanations.
    pub name: String,
    /// Kind.
    pub kind: PartKind,
    /// Emphasis: factor of its error in the choice, 1 is neutral.
    pub weight: f64,
    /// Bytes of `bytes_once` that the client already has.
    pub held_bytes: u64,
    /// The options, in any order.
    pub options: Vec<PartOption>,
}

impl Part {
    /// Creates a part of neutral weight, of which the client has nothing yet.
    pub fn new(name: impl Into<String>, kind: PartKind, options: Vec<PartOption>) -> Self {
        Self {
            name: name.into(),
            kind,
            weight: 1.0,
            held_bytes: 0,
            options,
        }
    }

    /// Checks the numbers of the part.
    ///
    /// # Errors
    /// If there are no options or more than [`MAX_OPTIONS`], or a number is negative, NaN or too
    /// large. The error names it.
    pub fn check(&self) -> Result<(), Mismatch> {
        let at = |what: &str| format!("part {}: {what}", self.name);
        if !(1..=MAX_OPTIONS).contains(&self.options.len()) {
            let what = format!(
                "{} options, expected 1 to {MAX_OPTIONS}",
                self.options.len()
            );
            return Err(Mismatch::new(at("options"), what));
        }
        let number = |name: &str, value: f64, limit: f64| {
            if value >= 0.0 && value <= limit {
                return Ok(());
            }
            let what = format!("{value}, expected 0 to {limit:e}");
            Err(Mismatch::new(at(name), what))
        };
        number("weight", self.weight, 1e6)?;
        for (i, option) in self.options.iter().enumerate() {
            let most = MOST as f64;
            let of = |what: &str| format!("options[{i}].{what}");
            number(&of("bytes_once"), option.bytes_once as f64, most)?;
            number(&of("bytes_per_second"), option.bytes_per_second, most)?;
            number(&of("frame_ns"), option.frame_ns as f64, most)?;
            number(&of("memory_bytes"), option.memory_bytes as f64, most)?;
            number(&of("error_m"), option.error_m, 1e6)?;
            number(&of("error_px"), option.error_px, 1e9)?;
        }
        Ok(())
    }
}

/// Pixels per metre at a distance in metres.
pub fn pixels_per_metre(viewport: &Viewport, distance_m: f32) -> f64 {
    f64::from(viewport.pixels_per_metre(distance_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_none_are_refused_by_name() {
        let part = |option| Part::new("body", PartKind::BodyMotion, vec![option]);
        let bad = part(PartOption {
            error_m: f64::NAN,
            ..Default::default()
        });
        let text = bad.check().unwrap_err().to_string();
        assert_eq!(
            text,
            "part body: options[0].error_m: NaN, expected 0 to 1e6"
        );
        assert!(part(PartOption::default()).check().is_ok());
        assert!(
            Part::new("none", PartKind::Other, Vec::new())
                .check()
                .is_err()
        );
    }

    #[test]
    fn pixels_and_bytes_by_hand() {
        let option = PartOption {
            bytes_once: 1000,
            bytes_per_second: 33.5,
            error_m: 0.01,
            error_px: 0.25,
            ..Default::default()
        };
        // 96.0 px/m at 9.05 m, as in docs/metrics.md.
        let k = pixels_per_metre(&Viewport::default(), 9.05);
        assert!((option.pixels(k) - (0.960 + 0.25)).abs() < 1e-3);
        assert_eq!(option.bytes(3.0, 0), 1101);
        assert_eq!(option.bytes(3.0, 400), 701);
        assert_eq!(option.bytes(3.0, 5000), 101);
    }
}
