//! Streams in MP4 files, and MP4 files around streams.
//!
//! Form: `docs/formats/mp4.md`. A file is a box: where a stream is read, one stream of the file is
//! taken out, and the others are named in a warning.

use super::stream_limits;
use crate::error::{Context, Error, Result};
use articula_formats::{Limits, Warning};
use articula_stream::{StreamKind, mp4};
use std::borrow::Cow;

pub use articula_stream::mp4::{Mp4Track, is_mp4};

/// A stream that was taken out of a file.
#[derive(Debug, Clone)]
pub struct TakenStream {
    /// Which stream it is.
    pub kind: StreamKind,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// The other tracks of the file.
    pub left_out: Vec<Mp4Track>,
}

/// Returns the tracks of a file, also those that hold no stream.
///
/// # Errors
/// An [`Error`] that names the position in the file.
pub fn tracks(file: &[u8], limits: &Limits) -> Result<Vec<Mp4Track>> {
    Ok(mp4::read(file, &stream_limits(limits))?)
}

/// Takes the first stream that fits out of a file; `None` if none fits.
///
/// # Errors
/// An [`Error`] that names the position in the file, also if the file has none of the streams.
pub fn take(
    file: &[u8],
    limits: &Limits,
    fits: impl Fn(StreamKind) -> bool,
) -> Result<Option<TakenStream>> {
    let mut tracks = tracks(file, limits)?;
    if tracks.iter().all(|track| track.kind.is_none()) {
        return Err(no_stream(&tracks));
    }
    let of_track = |track: &Mp4Track| track.kind.filter(|kind| fits(*kind));
    let first = tracks.iter().enumerate();
    let mut first = first.filter_map(|(i, track)| Some((i, of_track(track)?)));
    let Some((index, kind)) = first.next() else {
        return Ok(None);
    };
    let bytes = tracks.remove(index).stream(file)?;
    Ok(Some(TakenStream {
        kind,
        bytes,
        left_out: tracks,
    }))
}

impl TakenStream {
    /// Returns a warning for each track that was left out.
    pub fn warnings(&self) -> Vec<Warning> {
        self.left_out.iter().map(left_out).collect()
    }
}

/// The warning that a track was left out.
pub fn left_out(track: &Mp4Track) -> Warning {
    let what = match track.kind {
        Some(kind) => format!(
            "{} is left out; convert the file to .{} for it",
            kind.name(),
            kind.extension()
        ),
        None => format!(
            "{} is left out; it is no stream of an animation",
            track.form
        ),
    };
    Warning {
        at: format!("track {}", track.id),
        what,
        guess: None,
    }
}

/// Writes an MP4 file of streams, each in a track of its own. A part that is an MP4 file itself gives
/// all of its streams. Each has a name for errors.
///
/// # Errors
/// An [`Error`] that names the part and the position in it, or says that it is neither.
pub fn write(parts: &[(&str, &[u8])], limits: &Limits) -> Result<Vec<u8>> {
    let mut streams: Vec<Cow<'_, [u8]>> = Vec::new();
    for (name, part) in parts {
        if is_mp4(part) {
            streams.extend(all(part, limits).context(name)?.into_iter().map(Cow::Owned));
        } else {
            // Alone, so that an error is that of this part.
            mp4::write(&[part], &stream_limits(limits)).context(name)?;
            streams.push(Cow::Borrowed(*part));
        }
    }
    let streams: Vec<&[u8]> = streams.iter().map(Cow::as_ref).collect();
    Ok(mp4::write(&streams, &stream_limits(limits))?)
}

/// All streams of a file.
fn all(file: &[u8], limits: &Limits) -> Result<Vec<Vec<u8>>> {
    let tracks = tracks(file, limits)?;
    let with_streams = tracks.iter().filter(|track| track.kind.is_some());
    let streams = with_streams.map(|track| Ok(track.stream(file)?));
    let streams = streams.collect::<Result<Vec<_>>>()?;
    if streams.is_empty() {
        return Err(no_stream(&tracks));
    }
    Ok(streams)
}

/// Most forms of tracks that an error names.
const MOST_FORMS: usize = 8;

fn no_stream(tracks: &[Mp4Track]) -> Error {
    let mut forms: Vec<&str> = tracks.iter().map(|track| track.form.as_str()).collect();
    forms.truncate(MOST_FORMS);
    let forms = match tracks.len() {
        0 => "it has no tracks".to_owned(),
        more if more > MOST_FORMS => format!("its tracks hold {} and others", forms.join(", ")),
        _ => format!("its tracks hold {}", forms.join(", ")),
    };
    Error::unsuited(format!(
        "no track of the MP4 file is a stream of an animation (ABP, AFP, FBA); {forms}"
    ))
}
