//! Files with data of a face or an encoder, without joints: of MPEG-4, and captures.

use super::OpenOptions;
use crate::clip_streams::{AccessUnitCount, StreamKind, afp1, afp2, fba, mp4, stream_limits};
use crate::error::{Context, Error, Result};
use articula_formats::live_link::{self, LiveLinkClip};
use articula_formats::mpeg4::epf::EpfFrame;
use articula_formats::mpeg4::fap::FapClip;
use articula_formats::mpeg4::fdp::FdpFile;
use articula_formats::mpeg4::{epf, fap, fdp};
use articula_formats::{Limits, Parsed, Warning};
use articula_stream::FaceReadOptions;
use std::path::Path;

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

/// Contents of a data file.
#[derive(Debug)]
pub enum Data {
    /// Facial animation parameters by frame.
    Fap(FapClip),
    /// Encoder parameters by frame.
    Epf(Vec<EpfFrame>),
    /// Feature points and shape of a face.
    Fdp(FdpFile),
    /// Blend shapes by frame.
    LiveLink(LiveLinkClip),
}

/// A data file that was read.
#[derive(Debug)]
pub struct DataFile {
    /// Contents of the file.
    pub data: Data,
    /// Size of the file in bytes.
    pub bytes: usize,
    /// Warnings about the file.
    pub warnings: Vec<Warning>,
}

impl DataFormat {
    /// The formats that a name tells.
    const ALL: [Self; 6] = [
        Self::Fap,
        Self::Afp,
        Self::Fba,
        Self::Epf,
        Self::Fdp,
        Self::Csv,
    ];

    /// Returns the format for a file name's extension.
    pub fn from_name(name: &str) -> Option<Self> {
        let extension = super::format::extension(name)?.to_ascii_lowercase();
        Self::ALL.into_iter().find(|f| f.name() == extension)
    }

    /// Returns [`Self::Mp4`] for an MP4 file whose first stream moves a face.
    pub fn of_mp4(file: &[u8], limits: &Limits) -> Option<Self> {
        let tracks = mp4::tracks(file, limits).ok()?;
        let first = tracks.iter().find_map(|track| track.kind)?;
        first.is_of_face().then_some(Self::Mp4)
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
            Self::Mp4 => mp4::NO_JOINTS,
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

/// Opens a data file without a character; `name` identifies the file in errors.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file and the position in it.
pub fn open_data(
    bytes: &[u8],
    name: &str,
    format: DataFormat,
    options: &OpenOptions,
) -> Result<DataFile> {
    let limits = &options.limits;
    let (data, warnings) = match format {
        DataFormat::Fap => parts(
            fap::read(bytes, options.absent, limits).context(name)?,
            Data::Fap,
        ),
        DataFormat::Afp => {
            let kind = StreamKind::of(bytes).filter(|kind| *kind == StreamKind::Afp2);
            let kind = kind.unwrap_or(StreamKind::Afp1);
            let clip = face_stream(bytes, name, kind, limits).context(name)?;
            (Data::Fap(clip), partial(bytes, limits).context(name)?)
        }
        DataFormat::Fba => {
            let clip = face_stream(bytes, name, StreamKind::Fba, limits).context(name)?;
            (Data::Fap(clip), Vec::new())
        }
        DataFormat::Mp4 => {
            let taken = mp4::take(bytes, limits, StreamKind::is_of_face).context(name)?;
            let no_face = || Error::unsuited("no track of the MP4 file is a stream of a face");
            let taken = taken.ok_or_else(no_face).context(name)?;
            let clip = face_stream(&taken.bytes, name, taken.kind, limits).context(name)?;
            let mut warnings = taken.warnings();
            warnings.extend(partial(&taken.bytes, limits).context(name)?);
            (Data::Fap(clip), warnings)
        }
        DataFormat::Epf => parts(epf::read(bytes, limits).context(name)?, Data::Epf),
        DataFormat::Fdp => parts(fdp::read(bytes, limits).context(name)?, Data::Fdp),
        DataFormat::Csv => parts(
            live_link::read(bytes, limits).context(name)?,
            Data::LiveLink,
        ),
    };
    Ok(DataFile {
        data,
        bytes: bytes.len(),
        warnings,
    })
}

/// The warning that access units of a stream are missing, if they are.
fn partial(bytes: &[u8], limits: &Limits) -> Result<Vec<Warning>> {
    let count = AccessUnitCount::in_stream(bytes, &stream_limits(limits))?;
    Ok(count
        .and_then(|count| count.warning())
        .into_iter()
        .collect())
}

/// Reads a stream of a face.
fn face_stream(bytes: &[u8], name: &str, kind: StreamKind, limits: &Limits) -> Result<FapClip> {
    let limits = stream_limits(limits);
    let options = FaceReadOptions::default();
    match kind {
        StreamKind::Afp2 => afp2::read(bytes, &options, &limits),
        StreamKind::Fba => {
            let stem = Path::new(name).file_stem().unwrap_or_default();
            fba::read(bytes, &stem.to_string_lossy(), &limits)
        }
        _ => afp1::read(bytes, &options, &limits),
    }
}

fn parts<T>(read: Parsed<T>, kind: fn(T) -> Data) -> (Data, Vec<Warning>) {
    (kind(read.value), read.warnings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::open::Format;

    #[test]
    fn names_are_those_of_no_character() {
        for format in DataFormat::ALL {
            let name = format!("a.{}", format.name().to_uppercase());
            assert_eq!(DataFormat::from_name(&name), Some(format));
            assert_eq!(Format::from_name(&name), None);
        }
        assert_eq!(DataFormat::from_name("fap"), None);
    }
}
