//! The streams of animations, told apart by how they begin.

/// A stream of an animation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamKind {
    /// Bones, BBA-style, profile ABP-1.
    Abp1,
    /// A motion within a tolerance of the skin, profile ABP-2.
    Abp2,
    /// Facial animation parameters, profile AFP-1.
    Afp1,
    /// Facial animation parameters within a tolerance, profile AFP-2.
    Afp2,
    /// Facial animation parameters as MPEG-4's binary stream.
    Fba,
}

impl StreamKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Abp1, Self::Abp2, Self::Afp1, Self::Afp2, Self::Fba];

    /// Returns which stream some bytes are, by how they begin.
    ///
    /// MPEG program streams of pictures and sound begin like FBA streams.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        match bytes.first_chunk()? {
            b"ABPF" => Some(Self::Abp1),
            b"ABP2" => Some(Self::Abp2),
            b"AFPF" => Some(Self::Afp1),
            b"AFP2" => Some(Self::Afp2),
            [0, 0, 1, 0xba | 0x01] => Some(Self::Fba),
            _ => None,
        }
    }

    /// Returns the name of the profile.
    pub fn name(self) -> &'static str {
        match self {
            Self::Abp1 => "ABP-1",
            Self::Abp2 => "ABP-2",
            Self::Afp1 => "AFP-1",
            Self::Afp2 => "AFP-2",
            Self::Fba => "FBA",
        }
    }

    /// Returns the extension of its files, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Abp1 | Self::Abp2 => "abp",
            Self::Afp1 | Self::Afp2 => "afp",
            Self::Fba => "fba",
        }
    }

    /// Returns whether it moves a face, not the joints of a body.
    pub fn is_of_face(self) -> bool {
        !matches!(self, Self::Abp1 | Self::Abp2)
    }
}
