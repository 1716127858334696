//! GLB, glTF, VRM and VRM animation files: the whole document stays behind the character.

use super::{CharacterFile, Input};
use crate::error::Result;
use articula_core::source::Character;
use articula_formats::gltf::{self, Document, GltfFile, KhrCharacter, PassThrough};

/// The document of a glTF file, which of its nodes the character came from, and what it says of a
/// human beyond the character.
#[derive(Debug, Clone)]
pub struct GltfSource {
    /// The whole document, so that what is not understood passes through.
    pub document: Document,
    /// Node of each joint.
    pub node_of_joint: Vec<usize>,
    /// Node of each mesh.
    pub node_of_mesh: Vec<usize>,
    /// Format of its human extensions, such as `VRM 1.0`.
    pub version: Option<String>,
    /// Joint and VRM human bone.
    pub humanoid: Option<Vec<(usize, String)>>,
    /// What the draft glTF extensions for characters say.
    pub khr_character: Option<KhrCharacter>,
    /// What stays in the document but changes nothing here.
    pub kept: Vec<PassThrough>,
}

impl GltfSource {
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
pub(super) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    let read = gltf::read(input.bytes, &input.options.limits, input.beside)?;
    let (character, gltf) = GltfSource::split(read.value);
    let mut opened = input.opened(character, read.warnings, gltf.humanoid.as_deref());
    opened.gltf = Some(gltf);
    Ok(opened)
}
