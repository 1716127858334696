//! GLB, glTF, VRM and VRM animation files: the whole document stays behind the character.

use super::{Loaded, Source};
use crate::files;
use articula_core::source::Character;
use articula_formats::gltf::{self, Document, GltfFile, Kept, KhrCharacter};

/// The document of a glTF file, which of its nodes the character came from, and what it says of a
/// human beyond the character.
#[derive(Debug, Clone)]
pub(crate) struct Behind {
    pub(crate) document: Document,
    pub(crate) node_of_joint: Vec<usize>,
    pub(crate) node_of_mesh: Vec<usize>,
    /// Format of its human extensions, such as `VRM 1.0`.
    pub(crate) version: Option<String>,
    /// Joint and VRM human bone.
    pub(crate) humanoid: Option<Vec<(usize, String)>>,
    pub(crate) khr_character: Option<KhrCharacter>,
    /// What stays in the document but changes nothing here.
    pub(crate) kept: Vec<Kept>,
}

impl Behind {
    /// Parts a file into its character and what stands behind it.
    pub(crate) fn split(file: GltfFile) -> (Character, Self) {
        let behind = Self {
            document: file.document,
            node_of_joint: file.node_of_joint,
            node_of_mesh: file.node_of_mesh,
            version: file.version,
            humanoid: file.humanoid,
            khr_character: file.khr_character,
            kept: file.kept,
        };
        (file.character, behind)
    }
}

/// Reads a glTF file and what lies beside it.
pub(super) fn load(source: &Source<'_>) -> anyhow::Result<Loaded> {
    let mut fetch = files::beside(source.path, source.limits.bytes);
    let read = gltf::read(source.bytes, &source.limits, &mut fetch)?;
    let (character, behind) = Behind::split(read.value);
    let mut loaded = source.loaded(character, read.warnings, behind.humanoid.as_deref());
    loaded.behind = Some(behind);
    Ok(loaded)
}
