//! `prepare`: computes offline data of a character and stores it in one GLB.
//!
//! - `write`: computation of the parts of `ARTICULA_prepared`
//! - `tables`: computation of the motion tables of a clip
//! - `check`: whether an asset is whole and its parts belong to its character

mod check;
mod face;
mod options;
mod part;
mod tables;
mod write;

pub use check::{CheckedPart, PartState, PreparedCheck, check_prepared};
pub use options::{PrepareOptions, PreparedMeshLevels};
pub use part::{PartBytes, PreparedPart};
pub use tables::ClipTables;

use crate::error::{Context, Error, Result};
use crate::face::FoundFace;
use crate::figure::Figure;
use crate::mesh_levels::{self, CodedMeshLevels};
use crate::open::{CharacterFile, GltfSource};
use crate::work::Executor;
use articula_formats::Limits;
use articula_formats::gltf::{self, Document};
use tables::TableMaker;
use write::{DocumentLevels, Parts, ShownHashes};

/// A prepared asset and the data that was stored in it.
#[derive(Debug)]
pub struct PreparedAsset {
    /// The asset as a GLB that any glTF viewer opens.
    pub glb: Vec<u8>,
    /// The character that was prepared. Its document was moved into the asset, so the file has none.
    pub figure: Figure,
    /// Motion tables, one for each clip.
    pub tables: Vec<ClipTables>,
    /// Mesh levels, if they were requested.
    pub mesh_levels: Option<CodedMeshLevels>,
    /// Number of bytes of the GLB that meshes take.
    pub mesh_bytes: usize,
    /// Number of bytes of each stored part.
    pub parts: Vec<PartBytes>,
    /// Number of feature points of the face that were stored; 0 if the figure shows too little of one.
    pub face_points: usize,
    /// Number of bytes of the palettes that the keys of the pose cache become when the asset is
    /// opened; they are not in the file.
    pub pose_cache_bytes: usize,
}

/// Computes everything that crowds and evaluations need, and stores it in the character's document:
/// articulation, feature points of the face, clips at a uniform rate, joint and mesh levels with
/// their errors, skins and bounds, keys of the pose cache, and motion tables. Other contents of the
/// document are preserved.
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
    let name = opened.name().to_owned();
    let opened = with_document(opened).with_context(|| &name)?;
    let wanted = options.mesh_levels.made_of(&opened.character().meshes);
    // Mesh levels are other meshes, as the document codes them.
    let shown = wanted.is_none();
    let shown = shown.then(|| ShownHashes::of(opened.character(), &opened.articulation()));
    let figure = Figure::computed(opened)?;
    let source = figure.into_source();
    let Some(mut gltf) = source.gltf else {
        // It was just put there.
        return Err(Error::unsuited("the character has no document")).context(&name);
    };
    gltf.document.remove_prepared();
    gltf.document.remove_motion_tables();
    let (mut figure, mut orders) = (source.figure, source.orders);
    let face = FoundFace::in_document(&figure, Some(&gltf.document), &options.face_points).ok();
    match &face {
        Some(face) => gltf.document.set_face(&face.stored()),
        None if options.face_points.is_empty() => gltf.document.remove_face(),
        None => {
            let what =
                "face: the figure shows too little of a face for feature points; leave them out";
            return Err(Error::unsuited(what)).context(&name);
        }
    }
    let mut triangles = source.mesh_levels;
    let mut levels = None;
    if let Some(wanted) = &wanted {
        let made = mesh_levels::add(
            &figure,
            (&mut gltf, orders.as_deref()),
            face.as_ref(),
            wanted,
            work,
        );
        let made = made.with_context(|| &name)?;
        triangles = Some(made.levels.triangles(&figure.asset.mesh));
        orders = Some(mesh_levels::source_orders(&figure, &made.levels));
        levels = Some(made);
    }
    let maker = TableMaker::new(&figure.asset, options.seed);
    let clips: Vec<usize> = (0..figure.asset.clips.len()).collect();
    let tables = work.map("building motion tables", clips, |clip| {
        maker.tables(clip, options).context(&name)
    })?;
    let orders = orders.as_deref();
    let parts = write::parts(&figure, DocumentLevels { triangles, orders }, options, work);
    let parts = parts.with_context(|| &name)?;
    let (glb, mesh_bytes) =
        written(&figure, gltf, shown, &tables, &parts).with_context(|| &name)?;
    let meshes = figure.opened.character().meshes.clone();
    if let Some(levels) = &levels {
        let made = levels.levels.character(figure.opened.character());
        let made = made.with_context(|| &name)?;
        figure.opened.edit_character(|character| *character = made);
    }
    let sizes = PreparedPart::ALL.into_iter().map(|part| PartBytes {
        part: part.name(),
        bytes: parts.bytes(part) + tables.iter().map(|t| t.bytes(part)).sum::<usize>(),
    });
    Ok(PreparedAsset {
        glb,
        mesh_bytes,
        parts: sizes.collect(),
        face_points: face.map_or(0, |face| face.points.points.len()),
        pose_cache_bytes: parts.pose_cache_bytes,
        figure: figure.with_orders(orders, meshes),
        tables,
        mesh_levels: levels,
    })
}

/// Returns the character with a glTF document that shows it: its own with the current clips, or a new
/// one for a character from another format.
pub(crate) fn with_document(opened: CharacterFile) -> Result<CharacterFile> {
    let Some(gltf) = opened.gltf() else {
        let document = Document::from_character(opened.character())?;
        return shown_by(document, opened);
    };
    if gltf.kept_meshes.is_some() {
        let what = "the character differs from its document; write it to a file and open that";
        return Err(Error::unsuited(what));
    }
    if !opened.clips_changed() {
        return Ok(opened);
    }
    let mut document = gltf.document.clone();
    let (joints, meshes) = (&gltf.node_of_joint, &gltf.node_of_mesh);
    document.replace_clips(&opened.character().clips, joints, meshes)?;
    shown_by(document, opened)
}

/// Reads a document again, so that joints, meshes and clips are in its order.
fn shown_by(document: Document, mut opened: CharacterFile) -> Result<CharacterFile> {
    let file = gltf::read_document(document, &Limits::default())?.value;
    let (character, gltf) = GltfSource::split(file);
    opened.attach_document(character, gltf);
    Ok(opened)
}

/// Returns the bytes of the GLB and how many of them meshes take. `shown` are the hashes of what a
/// reader will find; without them the document is read for it.
fn written(
    figure: &Figure,
    gltf: GltfSource,
    shown: Option<ShownHashes>,
    tables: &[ClipTables],
    parts: &Parts,
) -> Result<(Vec<u8>, usize)> {
    let mut document = gltf.document;
    let articulation = figure.opened.articulation();
    document.set_articulation(&articulation, &gltf.node_of_joint)?;
    for (clip, tables) in tables.iter().enumerate() {
        for (name, bytes) in tables.stored() {
            document.set_motion_table(clip, name, bytes)?;
        }
    }
    let shown = match shown {
        Some(shown) => shown,
        None => {
            let file = gltf::read_document(document, &Limits::default())?.value;
            let (character, gltf) = GltfSource::split(file);
            document = gltf.document;
            ShownHashes::of(&character, &articulation)
        }
    };
    document.pack_samplers();
    parts.store(&mut document, &shown);
    Ok((document.write_glb()?, document.mesh_bytes()))
}
