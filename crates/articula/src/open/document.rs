//! GLB, glTF, VRM and VRM animation files, with the whole document preserved.

use super::{CharacterFile, Input, motion, partial_skin};
use crate::error::Result;
use crate::prepared::state::KeptMeshes;
use articula_core::source::Character;
use articula_formats::gltf::{self, Document, GltfFile, KhrCharacter, PassThrough};

/// The document of a glTF file, the nodes of the character's joints and meshes, and humanoid data
/// that is not part of the character.
#[derive(Debug, Clone)]
pub struct GltfSource {
    /// The whole document; unknown contents are preserved when it is written.
    pub document: Document,
    /// Node index of each joint.
    pub node_of_joint: Vec<usize>,
    /// Node index of each mesh.
    pub node_of_mesh: Vec<usize>,
    /// Version of its humanoid extension, such as `VRM 1.0`.
    pub version: Option<String>,
    /// Pairs of joint index and VRM human bone.
    pub humanoid: Option<Vec<(usize, String)>>,
    /// Contents of the draft glTF extensions for characters.
    pub khr_character: Option<KhrCharacter>,
    /// State of the stored data before meshes were removed.
    pub(crate) kept_meshes: Option<KeptMeshes>,
    /// Features that are preserved in the document but have no effect here.
    pub kept: Vec<PassThrough>,
}

impl GltfSource {
    /// Splits a file into the character and its document. The joints of a motion alone, and those
    /// beside a skin over a part of a figure, are found here, wherever its document is read.
    pub(crate) fn split(file: GltfFile) -> (Character, Self) {
        let mut character = file.character;
        motion::mark_skeleton(&mut character);
        partial_skin::mark_figure(&mut character);
        let behind = Self {
            document: file.document,
            node_of_joint: file.node_of_joint,
            node_of_mesh: file.node_of_mesh,
            version: file.version,
            humanoid: file.humanoid,
            khr_character: file.khr_character,
            kept_meshes: None,
            kept: file.kept,
        };
        (character, behind)
    }
}

/// Reads a glTF file and the files that it refers to.
pub(super) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    let limits = &input.options.limits;
    let mut read = gltf::read(input.bytes, limits, input.beside)?;
    if let Some(unit_metres) = input.options.unit_metres {
        let mut document = read.value.document;
        document.scale_scenes(unit_metres);
        let told = read.warnings;
        read = gltf::read_document(document, limits)?;
        read.warnings = told;
    }
    let (character, gltf) = GltfSource::split(read.value);
    let mut opened = input.opened(character, read.warnings, gltf.humanoid.as_deref());
    opened.gltf = Some(gltf);
    Ok(opened)
}
