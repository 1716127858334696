//! Tracks of an MP4 file with streams.

use crate::clip_streams::mp4::{Mp4Track, tracks};
use crate::error::{Context, Result};
use articula_formats::Limits;
use serde::Serialize;

/// A track of an MP4 file.
#[derive(Debug, Serialize)]
pub struct TrackInspection {
    /// Number of the track.
    pub track: u32,
    /// Name of the stream in it; null if it holds something else.
    pub profile: Option<&'static str>,
    /// The URI of timed metadata, else the four letters of the sample entry, such as `avc1`.
    pub form: String,
    /// Number of samples; of a stream, its access units.
    pub samples: u64,
    /// Ticks in a second.
    pub timescale: u32,
    /// Duration of all samples in seconds.
    pub duration_secs: f64,
    /// Size of the stream in bytes; 0 if the track holds something else.
    pub bytes: usize,
    /// Size of the head, which is in the sample entry, in bytes.
    pub bytes_head: usize,
}

/// Lists the tracks of an MP4 file; `file` identifies it in errors.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file and the position in it.
pub fn inspect_mp4(bytes: &[u8], file: &str, limits: &Limits) -> Result<Vec<TrackInspection>> {
    let track = |track: &Mp4Track| TrackInspection {
        track: track.id,
        profile: track.kind.map(|kind| kind.name()),
        form: track.form.clone(),
        samples: track.samples,
        timescale: track.timescale,
        duration_secs: track.secs(),
        bytes: track.bytes(),
        bytes_head: track.bytes_head(),
    };
    let tracks = tracks(bytes, limits).context(file)?;
    Ok(tracks.iter().map(track).collect())
}
