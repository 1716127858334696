//! Contents of a stream of mesh levels.

use crate::error::{Context, Result};
use articula_stream::StreamLimits;
use articula_stream::mesh::{MeshStream, Receiver};
use serde::Serialize;

/// Contents of a stream of mesh levels.
#[derive(Debug, Serialize)]
pub struct StreamInspection {
    /// Name of the file, as in errors.
    pub file: String,
    /// Name of the format, which is also the file extension.
    pub format: &'static str,
    /// Size of the file in bytes.
    pub bytes: usize,
    /// Size of the head in bytes, at the start of the file.
    pub bytes_head: usize,
    /// Number of parts with separate chunks.
    pub objects: usize,
    /// Names of zones that may have independent levels.
    pub regions: Vec<String>,
    /// The levels, finest first.
    pub levels: Vec<StreamLevel>,
}

/// One level of a stream. Errors are null if the stream does not state them.
#[derive(Debug, Serialize)]
pub struct StreamLevel {
    /// Number of the level in the whole character; 0 is the finest.
    pub level: usize,
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices.
    pub vertices: u64,
    /// Maximum distance of the original surface from the level at rest, in metres.
    pub error_rest_m: Option<f32>,
    /// Maximum distance in motion, in metres.
    pub error_motion_m: Option<f32>,
    /// Size of its chunks in bytes.
    pub bytes_added: usize,
    /// Whether all its chunks are present.
    pub complete: bool,
}

/// Summarises a stream of mesh levels; every chunk that is present is checked and decoded, and so is
/// the map by which the stream can be cut. `file` identifies the file in errors.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file and the position in it.
pub fn inspect_stream(bytes: &[u8], file: &str, limits: &StreamLimits) -> Result<StreamInspection> {
    let received = Receiver::read(bytes, limits).context(file)?;
    let stream = received.stream();
    let map = stream.unit();
    map.check().context("map")?;
    map.check_values(bytes).context("map")?;
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
