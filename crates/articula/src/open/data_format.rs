//! Formats without a character, and what can be done with their files.

use super::extension::extension;

/// Explains why an MP4 file with a stream of a face has no character, and how to use it.
pub(super) const NO_JOINTS: &str = "the MP4 file has a stream of a face, which has no joints; use convert --onto CHARACTER to move a \
     face by it, inspect to list its content, or convert to write it as .afp, .fap, .fba or .csv";

/// A file format without a character.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataFormat {
    /// MPEG-4 facial animation parameters.
    Fap,
    /// Facial animation parameters as a stream of which single ones can be cut.
    Afp,
    /// Facial animation parameters as MPEG-4's binary stream.
    Fba,
    /// An MP4 file with a stream of facial animation parameters. Its name does not tell: it is the one
    /// of motions of bodies too ([`Self::of_mp4`]).
    Mp4,
    /// MPEG-4 encoder parameters.
    Epf,
    /// Xface's facial definition parameters.
    Fdp,
    /// Captures of Live Link Face.
    Csv,
}

impl DataFormat {
    /// The formats that a name tells.
    pub(super) const ALL: [Self; 6] = [
        Self::Fap,
        Self::Afp,
        Self::Fba,
        Self::Epf,
        Self::Fdp,
        Self::Csv,
    ];

    /// Returns the format for a file name's extension.
    pub fn from_name(name: &str) -> Option<Self> {
        let extension = extension(name)?.to_ascii_lowercase();
        Self::ALL.into_iter().find(|f| f.name() == extension)
    }

    /// Returns the name used in reports, which is also the file extension.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fap => "fap",
            Self::Afp => "afp",
            Self::Fba => "fba",
            Self::Mp4 => "mp4",
            Self::Epf => "epf",
            Self::Fdp => "fdp",
            Self::Csv => "csv",
        }
    }

    /// Returns whether a file has facial animation parameters by frame.
    pub fn has_faps(self) -> bool {
        matches!(self, Self::Fap | Self::Afp | Self::Fba | Self::Mp4)
    }

    /// Returns whether a file animates a face: by parameters or by blend shapes.
    pub fn animates_a_face(self) -> bool {
        self.has_faps() || self == Self::Csv
    }

    /// Returns a sentence that explains why the format has no character, and how to use the file.
    pub fn advice(self) -> &'static str {
        match self {
            Self::Fap => {
                "a FAP file animates a face and has no joints; use convert --onto CHARACTER to move a \
                 face by it, inspect to list its content, or convert to write it as .fap, .afp, .fba or \
                 .csv"
            }
            Self::Afp => {
                "an AFP stream animates a face and has no joints; use convert --onto CHARACTER to move \
                 a face by it, inspect to list its content, or convert to write it as .fap, .fba, .mp4 \
                 or .csv"
            }
            Self::Fba => {
                "an FBA stream animates a face and has no joints; use convert --onto CHARACTER to move \
                 a face by it, inspect to list its content, or convert to write it as .fap, .afp or .csv"
            }
            Self::Csv => {
                "a CSV capture animates a face and has no joints; use convert --onto CHARACTER to move \
                 a face by it, inspect to list its content, or convert to write it as .fap, .afp or \
                 .fba"
            }
            Self::Mp4 => NO_JOINTS,
            Self::Epf => {
                "an EPF file controls an encoder and has no joints; use inspect to list its \
                 content"
            }
            Self::Fdp => {
                "an FDP file describes a face without its mesh and has no joints; use inspect to \
                 list its content"
            }
        }
    }
}
