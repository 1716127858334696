//! Streams of facial animation parameters, alone or in MP4 files.

use crate::clip_streams::{AccessUnitCount, StreamKind, afp1, afp2, fba, mp4, stream_limits};
use crate::error::{Error, Result};
use crate::open::DataFormat;
use articula_formats::mpeg4::fap::FapClip;
use articula_formats::{Limits, Warning};
use articula_stream::FaceReadOptions;
use std::path::Path;

impl DataFormat {
    /// Returns [`Self::Mp4`] for an MP4 file whose first stream moves a face.
    pub fn of_mp4(file: &[u8], limits: &Limits) -> Option<Self> {
        let tracks = mp4::tracks(file, limits).ok()?;
        let first = tracks.iter().find_map(|track| track.kind)?;
        first.is_of_face().then_some(Self::Mp4)
    }
}

/// Reads a file of a format that holds a stream of a face, with warnings about what else it holds.
pub(in crate::open) fn open_face(
    bytes: &[u8],
    name: &str,
    format: DataFormat,
    limits: &Limits,
) -> Result<(FapClip, Vec<Warning>)> {
    if format == DataFormat::Mp4 {
        let taken = mp4::take(bytes, limits, StreamKind::is_of_face)?;
        let no_face = || Error::unsuited("no track of the MP4 file is a stream of a face");
        let taken = taken.ok_or_else(no_face)?;
        let clip = face_stream(&taken.bytes, name, taken.kind, limits)?;
        let mut warnings = taken.warnings();
        warnings.extend(partial(&taken.bytes, limits)?);
        return Ok((clip, warnings));
    }
    let kind = match format {
        DataFormat::Fba => StreamKind::Fba,
        _ if StreamKind::of(bytes) == Some(StreamKind::Afp2) => StreamKind::Afp2,
        _ => StreamKind::Afp1,
    };
    let clip = face_stream(bytes, name, kind, limits)?;
    Ok((clip, partial(bytes, limits)?))
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
