//! `prepare`: computes offline data of a character and stores it in one GLB.

use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::mesh_levels::{self, CodedMeshLevels, MeshLevelOptions};
use crate::motion_tables::{ClipTables, POSE_KEYS, SEGS, TableMaker};
use crate::open::{CharacterFile, GltfSource};
use crate::work::Executor;
use articula_core::Mesh;
use articula_formats::Limits;
use articula_formats::gltf::{self, Document};

/// Options of [`prepare`].
#[derive(Debug, Clone, PartialEq)]
pub struct PrepareOptions {
    /// Seed of the selection of vertices that whole-pose keys are computed from.
    pub seed: u64,
    /// Options of the mesh levels; `None` makes none.
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

/// A prepared asset and the data that was stored in it.
#[derive(Debug)]
pub struct PreparedAsset {
    /// The asset as a GLB that any glTF viewer opens.
    pub glb: Vec<u8>,
    /// The character as stored in the asset. Its document was moved into the asset, so
    /// `opened.gltf` is `None`.
    pub figure: Figure,
    /// Motion tables, one for each clip.
    pub tables: Vec<ClipTables>,
    /// Mesh levels, if they were requested.
    pub mesh_levels: Option<CodedMeshLevels>,
    /// Number of bytes of the GLB that meshes take.
    pub mesh_bytes: usize,
}

/// Computes articulation, motion tables and, on request, mesh levels, and stores them in the
/// character's document; other contents of the document are preserved.
///
/// There is one job per clip. The output does not depend on threads or order.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file and the cause, or
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
        // Tables depend on the order of the vertices, which has changed; rig and clips have not.
        let character = made.levels.character(&figure.opened.character);
        figure.opened.character = character.with_context(|| &name)?;
        let (meshes, joints) = (&figure.opened.character.meshes, figure.asset.rig.len());
        figure.asset.mesh = Mesh::new(meshes, joints).with_context(|| &name)?;
        levels = Some(made);
    }
    let maker = TableMaker::new(&figure.asset, options.seed);
    let clips: Vec<usize> = (0..figure.asset.clips.len()).collect();
    let tables = work.map("building motion tables", clips, |clip| {
        Ok(maker.tables(clip))
    })?;
    let (glb, mesh_bytes) = written(&figure, gltf, &tables).with_context(|| &name)?;
    Ok(PreparedAsset {
        glb,
        figure,
        tables,
        mesh_levels: levels,
        mesh_bytes,
    })
}

/// Returns the character and its glTF document: its own with the current clips, or a new document
/// for a character from another format.
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
    // Nodes that only a removed clip animated are not joints any more.
    let joints = &mut opened.mapping.articulation.joints;
    let joint_of = |node: &usize| before.iter().position(|n| n == node);
    let was = |node: &usize| Some(joints[joint_of(node)?].clone());
    *joints = again.node_of_joint.iter().filter_map(was).collect();
    opened.clips_changed = false;
    Ok((opened, again))
}

/// Reads a document again, so that joints, meshes and clips are in its order.
fn shown_by(document: Document, mut opened: CharacterFile) -> Result<(CharacterFile, GltfSource)> {
    let file = gltf::read_document(document, &Limits::default())?.value;
    let (character, gltf) = GltfSource::split(file);
    opened.character = character;
    Ok((opened, gltf))
}

/// Returns the bytes of the GLB and how many of them meshes take.
fn written(figure: &Figure, gltf: GltfSource, tables: &[ClipTables]) -> Result<(Vec<u8>, usize)> {
    let mut document = gltf.document;
    document.set_articulation(&figure.opened.articulation(), &gltf.node_of_joint)?;
    for (clip, tables) in tables.iter().enumerate() {
        document.set_motion_table(clip, SEGS, &tables.segs)?;
        document.set_motion_table(clip, POSE_KEYS, &tables.pose_keys)?;
    }
    Ok((document.write_glb()?, document.mesh_bytes()))
}
