//! GLB, glTF, VRM and VRM animation files: the whole document stays behind the character.

use super::{Loaded, Source};
use crate::files;
use articula_formats::gltf::{self, Document};

/// The document of a glTF file, and which of its nodes the character came from.
#[derive(Debug, Clone)]
pub(crate) struct Behind {
    pub(crate) document: Document,
    pub(crate) node_of_joint: Vec<usize>,
    pub(crate) node_of_mesh: Vec<usize>,
}

/// Reads a glTF file and what lies beside it.
pub(super) fn load(source: &Source<'_>) -> anyhow::Result<Loaded> {
    let mut fetch = files::beside(source.path, source.limits.bytes);
    let read = gltf::read(source.bytes, &source.limits, &mut fetch)?;
    let file = read.value;
    let mut loaded = source.loaded(file.character, read.warnings, file.humanoid.as_deref());
    loaded.behind = Some(Behind {
        document: file.document,
        node_of_joint: file.node_of_joint,
        node_of_mesh: file.node_of_mesh,
    });
    Ok(loaded)
}
