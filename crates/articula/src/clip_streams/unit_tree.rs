//! The unit tree of any stream, by how it begins.

use crate::error::{Error, Result};
use articula_stream::abp2::motion_map;
use articula_stream::mesh::MeshStream;
use articula_stream::{StreamKind, StreamLimits, Unit, abp1, afp1};

/// How mesh streams begin.
const MESH: &[u8] = b"AMS";

/// Returns the unit tree of a stream of a motion, a face or a mesh, made from its bytes: what a cut or
/// a description of it needs.
///
/// # Errors
/// An [`Error`] that names the byte, or says that the bytes are no stream with units.
pub fn unit_tree(stream: &[u8], limits: &StreamLimits) -> Result<Unit> {
    Ok(match StreamKind::of(stream) {
        Some(StreamKind::Abp1) => abp1::unit(stream, limits)?,
        Some(StreamKind::Afp1) => afp1::unit(stream, limits)?,
        Some(StreamKind::Abp2 | StreamKind::Afp2) => motion_map(stream, limits)?,
        None if stream.starts_with(MESH) => MeshStream::open(stream, limits)?.unit(),
        Some(StreamKind::Fba) | None => {
            let what = "no stream with units: expected ABP-1, ABP-2 (.abp), AFP-1, AFP-2 (.afp) or \
                        mesh levels (.ams)";
            return Err(Error::unsuited(what));
        }
    })
}
