//! Files with data of a face or an encoder, without joints: of MPEG-4, and captures.

use super::{DataFormat, OpenOptions, streams};
use crate::error::{Context, Result};
use articula_formats::live_link::{self, LiveLinkClip};
use articula_formats::mpeg4::epf::EpfFrame;
use articula_formats::mpeg4::fap::FapClip;
use articula_formats::mpeg4::fdp::FdpFile;
use articula_formats::mpeg4::{epf, fap, fdp};
use articula_formats::{Parsed, Warning};

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
        DataFormat::Afp | DataFormat::Fba | DataFormat::Mp4 => {
            let (clip, warnings) = streams::open_face(bytes, name, format, limits).context(name)?;
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
