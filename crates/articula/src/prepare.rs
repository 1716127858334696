//! `prepare`: what is made once of a character goes into one GLB.

use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::mesh_levels::{self, CodedMeshLevels, MeshLevelOptions};
use crate::motion_tables::{ClipTables, POSE_KEYS, SEGS, TableMaker};
use crate::open::{CharacterFile, GltfSource};
use crate::work::Executor;
use articula_core::Mesh;
use articula_formats::Limits;
use articula_formats::gltf::{self, Document};

/// What is prepared.
#[derive(Debug, Clone, PartialEq)]
pub struct PrepareOptions {
    /// Seed of the choice of vertices that whole-pose keys watch.
    pub seed: u64,
    /// Mesh levels, if they are wanted.
    pub mesh_levels: Option<MeshLevelOptions>,
}

impl Default for PrepareOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            mesh_levels: None,
        }
    }
}

/// An asset, and what went into it.
#[derive(Debug)]
pub struct PreparedAsset {
    /// The asset as a GLB that every glTF viewer opens.
    pub glb: Vec<u8>,
    /// The character as the asset has it. Its document went into the asset: `opened.gltf` is
    /// `None`.
    pub figure: Figure,
    /// Motion tables of each clip.
    pub tables: Vec<ClipTables>,
    /// Mesh levels, if they were wanted.
    pub mesh_levels: Option<CodedMeshLevels>,
    /// Bytes of the GLB that its meshes take.
    pub mesh_bytes: usize,
}

/// Prepares a character: articulation, motion tables and, if wanted, mesh levels go into its
/// document; everything else in it passes through.
///
/// Jobs are the clips' tables. The bytes do not depend on who runs them.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file and what of it does not fit, or
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub fn prepare(
    opened: CharacterFile,
    options: &PrepareOptions,
    work: &Executor<'_>,
) -> Result<PreparedAsset> {
    let name = opened.name.clone();
    let (opened, mut gltf) = with_document(opened).with_context(|| &name)?;
    let mut figure = Figure::new(opened)?;
    let mut levels = None;
    if let Some(wanted) = &options.mesh_levels {
        let made = mesh_levels::add(&figure, &mut gltf, wanted, work).with_context(|| &name)?;
        // Tables are bound to the order of the vertices, which is new; rig and clips stay.
        let character = made.levels.character(&figure.opened.character);
        figure.opened.character = character.with_context(|| &name)?;
        let (meshes, joints) = (&figure.opened.character.meshes, figure.asset.rig.len());
        figure.asset.mesh = Mesh::new(meshes, joints).with_context(|| &name)?;
        levels = Some(made);
    }
    let maker = TableMaker::new(&figure.asset, options.seed);
    let clips: Vec<usize> = (0..figure.asset.clips.len()).collect();
    let tables = work.map("making motion tables", clips, |clip| Ok(maker.tables(clip)))?;
    let (glb, mesh_bytes) = written(&figure, gltf, &tables).with_context(|| &name)?;
    Ok(PreparedAsset {
        glb,
        figure,
        tables,
        mesh_levels: levels,
        mesh_bytes,
    })
}

/// A character with the document that shows it: its own, with the clips that it has by now, or
/// the one that a character of another format will be.
fn with_document(mut opened: CharacterFile) -> Result<(CharacterFile, GltfSource)> {
    let Some(mut gltf) = opened.gltf.take() else {
        let document = Document::from_character(&opened.character)?;
        return shown_by(document, opened);
    };
    if !opened.clips_changed {
        return Ok((opened, gltf));
    }
    let clips = &opened.character.clips;
    let (joints, meshes) = (&gltf.node_of_joint, &gltf.node_of_mesh);
    gltf.document.replace_clips(clips, joints, meshes)?;
    let before = gltf.node_of_joint;
    let (mut opened, again) = shown_by(gltf.document, opened)?;
    // Nodes that only clips moved are no joints without them.
    let joints = &mut opened.mapping.articulation.joints;
    let joint_of = |node: &usize| before.iter().position(|n| n == node);
    let was = |node: &usize| Some(joints[joint_of(node)?].clone());
    *joints = again.node_of_joint.iter().filter_map(was).collect();
    opened.clips_changed = false;
    Ok((opened, again))
}

/// A character as a document shows it: joints, meshes and clips in the document's order.
fn shown_by(document: Document, mut opened: CharacterFile) -> Result<(CharacterFile, GltfSource)> {
    let file = gltf::read_document(document, &Limits::default())?.value;
    let (character, gltf) = GltfSource::split(file);
    opened.character = character;
    Ok((opened, gltf))
}

/// The bytes of the asset, and how many of them are its meshes.
fn written(figure: &Figure, gltf: GltfSource, tables: &[ClipTables]) -> Result<(Vec<u8>, usize)> {
    let mut document = gltf.document;
    document.set_articulation(&figure.opened.articulation(), &gltf.node_of_joint)?;
    for (clip, tables) in tables.iter().enumerate() {
        document.set_motion_table(clip, SEGS, &tables.segs)?;
        document.set_motion_table(clip, POSE_KEYS, &tables.pose_keys)?;
    }
    Ok((document.write_glb()?, document.mesh_bytes()))
}
