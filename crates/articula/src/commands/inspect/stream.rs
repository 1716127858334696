//! Streams of mesh levels: every chunk that is there is checked and decoded.

use super::mesh_levels::millimetres;
use super::text::head_line;
use crate::arguments::CharacterArgs;
use crate::console::Console;
use crate::table::Table;
use crate::{fault, files};
use anyhow::Context;
use articula_stream::StreamLimits;
use articula_stream::mesh::{MeshStream, Receiver};
use serde::Serialize;
use std::path::Path;

/// The extension of such files.
const EXTENSION: &str = "ams";

/// What was found.
#[derive(Debug, Serialize)]
struct Findings {
    file: String,
    format: &'static str,
    bytes: usize,
    /// Bytes of the head, which comes first.
    bytes_head: usize,
    /// Parts with chunks of their own.
    objects: usize,
    /// Zones that may be at a level of their own.
    regions: Vec<String>,
    /// The finest first.
    levels: Vec<Level>,
}

#[derive(Debug, Serialize)]
struct Level {
    /// Its number in this stream, and in a whole character: 0 is the finest.
    level: usize,
    triangles: u64,
    vertices: u64,
    error_rest_m: Option<f32>,
    error_motion_m: Option<f32>,
    /// Bytes of its chunks.
    bytes_added: usize,
    /// Whether the file has all of them.
    complete: bool,
}

/// Whether a file is called as streams are.
pub(super) fn is_one(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str());
    extension.is_some_and(|e| e.eq_ignore_ascii_case(EXTENSION))
}

/// Reads the file and prints what was found.
pub(super) fn run(args: &CharacterArgs, console: &Console) -> anyhow::Result<()> {
    if args.leaves_out() {
        let what = "--hide and --only choose meshes of a character; a mesh stream has parts";
        return Err(fault::usage(what));
    }
    let limits = StreamLimits::default();
    let bytes = files::read(&args.file, limits.bytes)?;
    let place = || files::shown(&args.file);
    let received = Receiver::read(&bytes, &limits).with_context(place)?;
    let stream = received.stream();
    let findings = Findings {
        file: place(),
        format: EXTENSION,
        bytes: bytes.len(),
        bytes_head: stream.head_bytes(),
        objects: stream.objects.len(),
        regions: stream.levels.regions.clone(),
        levels: levels(stream, &received),
    };
    console.result(&findings, text)
}

fn levels(stream: &MeshStream, received: &Receiver) -> Vec<Level> {
    let finite = |metres: f32| metres.is_finite().then_some(metres);
    let objects = || 0..stream.objects.len();
    let there = objects().map(|o| received.levels(o)).min().unwrap_or(0);
    let count = stream.levels.levels.len();
    let rows = stream.levels.levels.iter().enumerate();
    let level = |(finer, row): (usize, &articula_core::LevelRow)| Level {
        level: finer,
        triangles: row.triangles,
        vertices: row.vertices,
        error_rest_m: finite(row.rest.max_metres),
        error_motion_m: finite(row.motion.max_metres),
        bytes_added: objects()
            .filter_map(|o| stream.chunk(count - 1 - finer, o))
            .map(|chunk| chunk.len())
            .sum(),
        complete: count - 1 - finer < there,
    };
    rows.map(level).collect()
}

fn text(found: &Findings) -> String {
    let mut text = head_line(&found.file, found.format, found.bytes, "");
    text.push_str(&format!(
        "{} parts, a head of {} bytes\n",
        found.objects, found.bytes_head
    ));
    let mut table = Table::new(&[
        "level",
        "triangles",
        "vertices",
        "off at rest",
        "in motion",
        "bytes added",
        "",
    ]);
    for level in &found.levels {
        let [rest, motion] = [level.error_rest_m, level.error_motion_m].map(millimetres);
        table.row([
            level.level.to_string(),
            level.triangles.to_string(),
            level.vertices.to_string(),
            rest,
            motion,
            level.bytes_added.to_string(),
            (if level.complete { "" } else { "not whole" }).to_owned(),
        ]);
    }
    text.push_str(&table.text());
    text
}
