//! The 15 visemes: mouth shapes of speech, in the order of FAP 1.
//!
//! Numbers and example words are those of MPEG-4 (ISO/IEC 14496-2, annex C, table C-5); OpenXR's
//! `XR_META_face_tracking_visemes` has the same order, and the short names are those of Oculus
//! LipSync, which heads of many makers call their morph targets (`viseme_PP`).

/// Number of visemes, silence included.
pub const VISEME_COUNT: usize = 15;

/// A mouth shape of speech.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Viseme {
    /// A pause.
    Silence,
    /// p, b, m: *put, bed, mill*.
    Pp,
    /// f, v: *far, voice*.
    Ff,
    /// th: *think, that*.
    Th,
    /// t, d: *tip, doll*.
    Dd,
    /// k, g: *call, gas*.
    Kk,
    /// ch, j, sh: *chair, join, she*.
    Ch,
    /// s, z: *sir, zeal*.
    Ss,
    /// n, l: *lot, not*.
    Nn,
    /// r: *red*.
    Rr,
    /// a: *car*.
    Aa,
    /// e: *bed*.
    E,
    /// i: *tip*.
    I,
    /// o: *top*.
    O,
    /// u: *book*.
    U,
}

impl Viseme {
    /// All, by their number.
    pub const ALL: [Self; VISEME_COUNT] = [
        Self::Silence,
        Self::Pp,
        Self::Ff,
        Self::Th,
        Self::Dd,
        Self::Kk,
        Self::Ch,
        Self::Ss,
        Self::Nn,
        Self::Rr,
        Self::Aa,
        Self::E,
        Self::I,
        Self::O,
        Self::U,
    ];

    /// Number in FAP 1 and in OpenXR, 0 for silence.
    pub const fn number(self) -> usize {
        self as usize
    }

    /// Name in Oculus LipSync, such as `PP` or `aa`.
    pub const fn name(self) -> &'static str {
        const NAMES: [&str; VISEME_COUNT] = [
            "sil", "PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "I", "O", "U",
        ];
        NAMES[self as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_stand_at_their_numbers_under_names_of_their_own() {
        for (number, viseme) in Viseme::ALL.iter().enumerate() {
            assert_eq!(viseme.number(), number);
            let same = Viseme::ALL.iter().filter(|v| v.name() == viseme.name());
            assert_eq!(same.count(), 1);
        }
        assert_eq!(Viseme::Aa.name(), "aa");
    }
}
