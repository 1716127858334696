//! Encoding of all levels of all objects as a stream.

use super::codec::{QuantisedMesh, encode_level};
use super::hash::{Hash, hash_of};
use super::head::{self, MeshStream, StreamObject};
use crate::StreamLimits;
use crate::unit::Unit;
use articula_core::{LevelTable, Mismatch};
use std::ops::Range;

/// Input of [`write()`] for one object: its head and all its quantised levels.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectLevels {
    /// Properties of the object.
    pub object: StreamObject,
    /// Its levels, finest first.
    pub levels: Vec<QuantisedMesh>,
}

/// An encoded stream and its description, the tree of [`Unit`]s by which it is cut.
#[derive(Debug, Clone, PartialEq)]
pub struct EncodedMeshStream {
    /// The head and all chunks.
    pub bytes: Vec<u8>,
    /// Map of the bytes.
    pub unit: Unit,
}

/// Encodes the range `shown` of levels (0 is the finest): its coarsest is coded alone, the others
/// as refinements. `0..n` is the whole character, `l..l + 1` a single level. Refinement chunks are
/// identical in every stream that contains them, so a client that received level `l` alone refines
/// it with the chunks of the whole stream.
///
/// # Errors
/// A [`Mismatch`] if there is no level or object, an object has another number of levels than the
/// table, or a mesh does not fit its layout.
pub fn write(
    levels: &LevelTable,
    objects: &[ObjectLevels],
    shown: Range<usize>,
) -> Result<EncodedMeshStream, Mismatch> {
    let count = levels.levels.len();
    if shown.is_empty() || shown.end > count {
        return Err(Mismatch::new(
            "shown",
            format!("{shown:?} is empty or exceeds the {count} levels"),
        ));
    }
    if let Some(o) = objects.iter().position(|o| o.levels.len() != count) {
        let what = format!("{} levels, {count} in the table", objects[o].levels.len());
        return Err(Mismatch::new(format!("objects[{o}]"), what));
    }
    let records: Vec<Vec<u8>> = objects.iter().map(|o| head::record(&o.object)).collect();
    let mut entries: Vec<(u32, Hash)> = Vec::new();
    let mut chunks = Vec::new();
    let coarsest = shown.end - 1;
    for level in shown.clone().rev() {
        for (o, (object, record)) in objects.iter().zip(&records).enumerate() {
            let layout = &object.object.layout;
            let mesh = &object.levels[level];
            let chunk = if level == coarsest {
                encode_level(None, mesh, layout)
            } else {
                encode_level(Some(&object.levels[level + 1]), mesh, layout)
            };
            let within = |e: Mismatch| Mismatch::new(format!("objects[{o}].{}", e.at), e.what);
            let chunk = chunk.map_err(within)?;
            entries.push((
                chunk.len() as u32,
                hash_of(level, level == coarsest, record, &chunk),
            ));
            chunks.extend(chunk);
        }
    }
    let table = LevelTable {
        levels: levels.levels[shown.clone()].to_vec(),
        regions: levels.regions.clone(),
        mixable_to: levels.mixable_to.saturating_sub(shown.start),
    };
    let mut bytes = head::write(shown.start, &table, &records, &entries);
    let limits = StreamLimits {
        bytes: u64::MAX,
        elements: u64::MAX,
    };
    let opened = MeshStream::open(&bytes, &limits);
    let stream = opened.map_err(|e| Mismatch::new("levels", e.to_string()))?;
    bytes.extend(chunks);
    Ok(EncodedMeshStream {
        unit: stream.unit(),
        bytes,
    })
}
