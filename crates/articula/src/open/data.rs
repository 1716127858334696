//! Files of MPEG-4 that hold data of a face or of an encoder, but no joint.

use super::OpenOptions;
use crate::error::{Context, Result};
use articula_formats::mpeg4::epf::EpfFrame;
use articula_formats::mpeg4::fap::FapClip;
use articula_formats::mpeg4::fdp::FdpFile;
use articula_formats::mpeg4::{epf, fap, fdp};
use articula_formats::{Parsed, Warning};

/// A format without a character in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataFormat {
    /// Facial animation parameters.
    Fap,
    /// Parameters of the encoder.
    Epf,
    /// What Xface knows of a face.
    Fdp,
}

/// What such a file holds.
#[derive(Debug)]
pub enum Data {
    /// Facial animation parameters.
    Fap(FapClip),
    /// Parameters of the encoder, by frame.
    Epf(Vec<EpfFrame>),
    /// What Xface knows of a face.
    Fdp(FdpFile),
}

/// A file as it was read.
#[derive(Debug)]
pub struct DataFile {
    /// What it holds.
    pub data: Data,
    /// Length of the file itself.
    pub bytes: usize,
    /// What was odd about it.
    pub warnings: Vec<Warning>,
}

impl DataFormat {
    const ALL: [Self; 3] = [Self::Fap, Self::Epf, Self::Fdp];

    /// The format that a file name's extension says.
    pub fn of_name(name: &str) -> Option<Self> {
        let extension = super::format::extension(name)?.to_ascii_lowercase();
        Self::ALL.into_iter().find(|f| f.name() == extension)
    }

    /// Name as reports spell it, which is also the extension of its files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fap => "fap",
            Self::Epf => "epf",
            Self::Fdp => "fdp",
        }
    }

    /// Why there is no character in it, and what can be done with it.
    pub fn advice(self) -> &'static str {
        match self {
            Self::Fap => {
                "a FAP file moves a face and has no joints; inspect lists what it moves, convert writes it as .fap again"
            }
            Self::Epf => {
                "an EPF file tells an encoder what to do and has no joints; inspect reads it"
            }
            Self::Fdp => {
                "an FDP file describes a face whose mesh lies elsewhere and has no joints; inspect reads it"
            }
        }
    }
}

/// Opens a file without a character in it; `name` is what errors call it.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file and the place in it.
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
        DataFormat::Epf => parts(epf::read(bytes, limits).context(name)?, Data::Epf),
        DataFormat::Fdp => parts(fdp::read(bytes, limits).context(name)?, Data::Fdp),
    };
    Ok(DataFile {
        data,
        bytes: bytes.len(),
        warnings,
    })
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
            assert_eq!(DataFormat::of_name(&name), Some(format));
            assert_eq!(Format::of_name(&name), None);
        }
        assert_eq!(DataFormat::of_name("fap"), None);
    }
}
