//! Files of MPEG-4 that hold data of a face or of an encoder, but no joint.

use crate::arguments::ReadArgs;
use crate::files;
use anyhow::Context;
use articula_formats::mpeg4::epf::EpfFrame;
use articula_formats::mpeg4::fap::FapClip;
use articula_formats::mpeg4::fdp::FdpFile;
use articula_formats::mpeg4::{epf, fap, fdp};
use articula_formats::{Limits, Read, Warning};
use std::path::Path;

/// A format without a character in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DataFormat {
    /// Facial animation parameters.
    Fap,
    /// Parameters of the encoder.
    Epf,
    /// What Xface knows of a face.
    Fdp,
}

/// What such a file holds.
#[derive(Debug)]
pub(crate) enum Data {
    Fap(FapClip),
    Epf(Vec<EpfFrame>),
    Fdp(FdpFile),
}

/// A file as it was read.
#[derive(Debug)]
pub(crate) struct LoadedData {
    pub(crate) data: Data,
    /// Length of the file itself.
    pub(crate) bytes: usize,
    pub(crate) warnings: Vec<Warning>,
}

impl DataFormat {
    const ALL: [Self; 3] = [Self::Fap, Self::Epf, Self::Fdp];

    /// The format that a file name's extension says.
    pub(crate) fn of_name(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Self::ALL.into_iter().find(|f| f.name() == extension)
    }

    /// Name as reports spell it, which is also the extension of its files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Fap => "fap",
            Self::Epf => "epf",
            Self::Fdp => "fdp",
        }
    }

    /// Why there is no character in it, and what can be done with it.
    pub(crate) fn advice(self) -> &'static str {
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

/// Reads a file of data.
pub(crate) fn read(path: &Path, format: DataFormat, args: &ReadArgs) -> anyhow::Result<LoadedData> {
    let limits = Limits::default();
    let bytes = files::read(path, limits.bytes)?;
    let place = || files::shown(path);
    let (data, warnings) = match format {
        DataFormat::Fap => parts(
            fap::read(&bytes, args.absent(), &limits).with_context(place)?,
            Data::Fap,
        ),
        DataFormat::Epf => parts(epf::read(&bytes, &limits).with_context(place)?, Data::Epf),
        DataFormat::Fdp => parts(fdp::read(&bytes, &limits).with_context(place)?, Data::Fdp),
    };
    Ok(LoadedData {
        data,
        bytes: bytes.len(),
        warnings,
    })
}

fn parts<T>(read: Read<T>, kind: fn(T) -> Data) -> (Data, Vec<Warning>) {
    (kind(read.value), read.warnings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::Format;

    #[test]
    fn names_are_those_of_no_character() {
        for format in DataFormat::ALL {
            let name = format!("a.{}", format.name().to_uppercase());
            assert_eq!(DataFormat::of_name(Path::new(&name)), Some(format));
            assert_eq!(Format::of_name(Path::new(&name)), None);
        }
        assert_eq!(DataFormat::of_name(Path::new("fap")), None);
    }
}
