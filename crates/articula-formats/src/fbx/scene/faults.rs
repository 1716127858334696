//! Limits that the crate gets, and its errors in our words.

use crate::error::ReadError;
use crate::limits::Limits;
use fbx_rs::Limit;

/// Bytes of memory that a file may take for each of its own, and besides.
const MEMORY_PER_BYTE: u64 = 16;
const MEMORY: u64 = 64 << 20;
/// Records and objects of a file for each node of the limits.
const RECORDS_PER_NODE: u64 = 64;
const OBJECTS_PER_NODE: u64 = 16;
/// Corners of a polygon, and the work of cutting it.
const MAX_CORNERS: usize = 1 << 16;
const MAX_CUTTING: usize = 1 << 24;

/// The limits of the crate for a file of this many bytes.
pub(super) fn bounds(bytes: u64, limits: &Limits) -> fbx_rs::Limits {
    let size = |value: u64| usize::try_from(value).unwrap_or(usize::MAX);
    let memory = bytes.saturating_mul(MEMORY_PER_BYTE).saturating_add(MEMORY);
    let memory = size(memory.min(limits.bytes.max(MEMORY)));
    fbx_rs::Limits {
        max_input_bytes: size(limits.bytes),
        max_depth: size(limits.depth),
        max_nodes: size(limits.nodes.saturating_mul(RECORDS_PER_NODE)),
        max_objects: size(limits.nodes.saturating_mul(OBJECTS_PER_NODE)),
        max_array_elements: size(limits.elements),
        max_decompressed_bytes: memory,
        max_allocation: memory,
        max_animation_keys: size(limits.frames),
        max_face_vertices: MAX_CORNERS,
        max_triangulation_work: MAX_CUTTING,
        ..fbx_rs::Limits::default()
    }
}

/// What to do about a file that cannot be read.
const AGAIN: &str = "export it again as FBX 2020 binary (7.7)";

/// An error of the crate as one of ours; `at` is where the bytes follow no rule, if that is known.
pub(super) fn read_error(error: fbx_rs::Error, at: &str, bounds: &fbx_rs::Limits) -> ReadError {
    use fbx_rs::Error as Fault;
    let exceeded = |(which, limit): (&'static str, usize)| ReadError::LimitExceeded {
        at: at.to_owned(),
        which,
        found: limit as u64 + 1,
        limit: limit as u64,
    };
    match error {
        Fault::LimitExceeded(limit) => exceeded(limited(limit, bounds)),
        Fault::Allocation | Fault::ResourceLimit(_) => exceeded(limited(Limit::Allocation, bounds)),
        Fault::InputTooLarge { size, limit } => ReadError::LimitExceeded {
            at: at.to_owned(),
            which: "bytes",
            found: size as u64,
            limit: limit as u64,
        },
        Fault::Parse(what) if what.contains("UnsupportedVersion") => {
            let version: String = what.chars().filter(char::is_ascii_digit).collect();
            unsupported(at, format!("version {version} of FBX"))
        }
        Fault::Convert(what) if what.contains("Unsupported") => unsupported(at, what),
        Fault::Parse(what) if what.contains("Truncated") => {
            ReadError::malformed(at, "the file ends within a record; get it again")
        }
        Fault::Parse(what) if what.contains("BadCompression") => {
            ReadError::malformed(at, "a compressed array is damaged; get the file again")
        }
        Fault::Parse(_) => {
            let what = format!("the bytes are no record of FBX; get the file again, or {AGAIN}");
            ReadError::malformed(at, what)
        }
        other => {
            let text = other.to_string();
            let what = text.strip_prefix("conversion error: ").unwrap_or(&text);
            let id = what
                .split_once('(')
                .and_then(|(_, id)| id.strip_suffix(')'));
            let at = id.map_or_else(|| at.to_owned(), |id| format!("object {id}"));
            let what = format!("the objects do not fit together ({what}); {AGAIN}");
            ReadError::malformed(at, what)
        }
    }
}

fn unsupported(at: &str, what: String) -> ReadError {
    ReadError::Unsupported {
        at: at.to_owned(),
        what,
        mend: AGAIN.to_owned(),
    }
}

/// What a limit of the crate counts, and its value.
fn limited(limit: Limit, bounds: &fbx_rs::Limits) -> (&'static str, usize) {
    match limit {
        Limit::Depth => ("levels of records or more", bounds.max_depth),
        Limit::Nodes => ("records or more", bounds.max_nodes),
        Limit::Properties => ("values or more", bounds.max_properties),
        Limit::ArrayElements => ("numbers in arrays or more", bounds.max_array_elements),
        Limit::StringLength => ("bytes of a text or more", bounds.max_string_length),
        Limit::Objects => ("objects or more", bounds.max_objects),
        Limit::AnimationKeys => ("keys of a curve or more", bounds.max_animation_keys),
        Limit::Connections => ("connections or more", bounds.max_connections),
        Limit::FaceVertices => ("corners of a polygon or more", bounds.max_face_vertices),
        Limit::TriangulationWork => (
            "steps to cut a polygon or more",
            bounds.max_triangulation_work,
        ),
        Limit::DeformerWork => ("steps to bind skins or more", bounds.max_deformer_work),
        Limit::AnimationWork => ("steps to read curves or more", bounds.max_animation_work),
        Limit::Meshes => ("meshes or more", bounds.max_meshes),
        Limit::Layers => ("layers of meshes or more", bounds.max_layers),
        _ => ("bytes of memory or more", bounds.max_allocation),
    }
}
