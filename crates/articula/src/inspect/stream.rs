//! What is in a stream of mesh levels.

use crate::error::{Context, Result};
use articula_stream::StreamLimits;
use articula_stream::mesh::{MeshStream, Receiver};
use serde::Serialize;

/// What was found in a stream of mesh levels.
#[derive(Debug, Serialize)]
pub struct StreamInspection {
    /// The file, as errors call it.
    pub file: String,
    /// Name of the format, which is also the extension of its files.
    pub format: &'static str,
    /// Length of the file.
    pub bytes: usize,
    /// Bytes of the head, which comes first.
    pub bytes_head: usize,
    /// Parts with chunks of their own.
    pub objects: usize,
    /// Zones that may be at a level of their own.
    pub regions: Vec<String>,
    /// The finest first.
    pub levels: Vec<StreamLevel>,
}

/// One level of a stream. An error is null if the stream does not say it.
#[derive(Debug, Serialize)]
pub struct StreamLevel {
    /// Its number in the whole character: 0 is the finest.
    pub level: usize,
    /// Triangles.
    pub triangles: u64,
    /// Vertices.
    pub vertices: u64,
    /// Greatest distance of the original from it at rest, metres.
    pub error_rest_m: Option<f32>,
    /// The same in motion, metres.
    pub error_motion_m: Option<f32>,
    /// Bytes of its chunks.
    pub bytes_added: usize,
    /// Whether the file has all of them.
    pub complete: bool,
}

/// Looks at a stream of mesh levels: every chunk that is there is checked and decoded. `file` is
/// what errors call it.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file and the place in it.
pub fn inspect_stream(bytes: &[u8], file: &str, limits: &StreamLimits) -> Result<StreamInspection> {
    let received = Receiver::read(bytes, limits).context(file)?;
    let stream = received.stream();
    Ok(StreamInspection {
        file: file.to_owned(),
        format: "ams",
        bytes: bytes.len(),
        bytes_head: stream.head_bytes,
        objects: stream.objects.len(),
        regions: stream.levels.regions.clone(),
        levels: levels(stream, &received),
    })
}

fn levels(stream: &MeshStream, received: &Receiver) -> Vec<StreamLevel> {
    let finite = |metres: f32| metres.is_finite().then_some(metres);
    let objects = || 0..stream.objects.len();
    let rows = stream.levels.levels.iter().enumerate();
    let level = |(l, row): (usize, &articula_core::LevelRow)| StreamLevel {
        level: stream.finest_level + l,
        triangles: row.triangles,
        vertices: row.vertices,
        error_rest_m: finite(row.rest.max_metres),
        error_motion_m: finite(row.motion.max_metres),
        bytes_added: objects()
            .filter_map(|o| stream.chunk(l, o))
            .map(|chunk| chunk.len())
            .sum(),
        complete: objects().all(|o| received.finest_level(o).is_some_and(|there| there <= l)),
    };
    rows.map(level).collect()
}
