//! GLB and glTF 2.0, including VRM files: a thin layer that keeps the whole document.
//!
//! [`read`] returns the character that a file shows and the [`Document`] that it came from. Content
//! that is not understood stays in the document untouched and is written again. The modules, in the
//! order in which data passes through them:
//!
//! - `container`, `document`, `open`: from bytes to JSON, buffers and pictures
//! - `compression`: decoding of compressed buffer views
//! - `place`, `reader`, `accessor`: JSON values with their paths, limits, arrays
//! - `extension`: which required extensions are supported
//! - `node`, `skeleton`, `skin`: from nodes to joints
//! - `material`, `texcoord`, `mesh`, `node_meshes`, `primitive`, `influences`, `lod`: geometry and
//!   appearance
//! - `origin`: from a part of a mesh back to the document
//! - `animation`, `single_weights`, `pointer`: animations
//! - `vrm`, `khr_character`, `credits`: human metadata and credits
//! - `articulation`: the extension `ARTICULA_articulation`
//! - `clustered`: the extension `ARTICULA_clustered_mesh`, and levels as `MSFT_lod`
//! - `prepared`: the extension `ARTICULA_prepared`
//! - `face`: the extension `ARTICULA_face`
//! - `append`, `arrays`, `clips`, `bounds`, `prune`, `samplers`, `unit`: changes to a document
//! - `keys`: other keys for the channels that a document has
//! - `joints`, `renumbered_skin`: joints that are inserted and removed
//! - `fresh`, `geometry`: a new document from a character
//! - `exchange`, `plain_textures`: a document without geometry and pictures, and with others
//! - `picture_materials`: the materials that show each picture; `merged_pictures`: one for several materials
//! - `morph_targets`, `kept_morphs`: morph targets that are added and left out
//! - `unused_attributes`: what no material uses
//! - `vertex_order`: triangles and vertices in an order that caches like
//! - `kinds`, `weight`: sizes of parts, and of meshes, in bytes; `compact`: equal arrays once, numbers of few digits
//! - `quantized_positions`: positions of skinned meshes as integers
//! - `rounded_nodes`: transforms of nodes in few digits
//! - `write`: back to bytes; `compressed`: with rounded and compressed arrays
//!
//! Source: glTF 2.0 specification (ISO/IEC 12113:2022). See `docs/formats/gltf.md`.

mod accessor;
mod animation;
mod append;
mod arrays;
mod articulation;
mod bounds;
mod clips;
mod clustered;
mod compact;
mod compressed;
mod compression;
mod container;
mod credits;
mod document;
mod exchange;
mod extension;
mod face;
mod facing;
mod fresh;
mod geometry;
mod influences;
mod joints;
mod kept_morphs;
mod keys;
mod khr_character;
mod kinds;
mod lod;
mod material;
mod matrices;
mod merged_pictures;
mod mesh;
mod morph_targets;
mod node;
mod node_meshes;
mod open;
mod origin;
mod picture_materials;
mod place;
mod plain_textures;
mod pointer;
mod prepared;
mod primitive;
mod prune;
mod quantized_positions;
mod reader;
mod renumbered_skin;
mod replaced_triangles;
mod rounded_nodes;
mod samplers;
mod single_weights;
mod skeleton;
mod skin;
mod texcoord;
mod texture_source;
mod unit;
mod unused_attributes;
mod vertex_order;
mod vrm;
mod weight;
mod write;

pub use clustered::{MeshParts, PartLevels};
pub use compressed::{
    ArrayPrecision, Compression, KeySteps, WeightPrecision, compressed_clip_bytes, rounded_clip,
};
pub use compression::has_compressed_views;
pub use document::Document;
pub use exchange::{MeshGeometry, placeholder};
pub use face::{StoredFace, StoredPoint};
pub use joints::{NewJoint, OldJoint};
pub use khr_character::{ExpressionSet, ExpressionShare, KhrCharacter, ReferencePose, RigMapping};
pub use kinds::BytesByKind;
pub use merged_pictures::ShownPictures;
pub use plain_textures::PictureUse;
pub use prepared::{PreparedEntry, PreparedHeader, PreparedState};
pub use rounded_nodes::NodeTolerance;
pub use vrm::PassThrough;

use crate::error::{Parsed, ReadError};
use crate::{Limits, Resolver};
use articula_core::source::Character;
use place::Place;
use reader::{Notes, Reader};

/// A glTF file as read: the character that it shows, and the underlying document.
#[derive(Debug, Clone, PartialEq)]
pub struct GltfFile {
    /// The whole document, to write it again.
    pub document: Document,
    /// The character that the document shows.
    pub character: Character,
    /// Node of each joint of the character's skeleton.
    pub node_of_joint: Vec<usize>,
    /// Node of each mesh of the character.
    pub node_of_mesh: Vec<usize>,
    /// Human extension of the file and its version, such as `VRM 1.0`.
    pub version: Option<String>,
    /// Joint and VRM human bone, if the file has a humanoid map. Bones have the names of the file's
    /// version (versions differ in the thumb).
    pub humanoid: Option<Vec<(usize, String)>>,
    /// Content of the draft KHR_character extensions.
    pub khr_character: Option<KhrCharacter>,
    /// Content that stays in the document but has no effect here, such as spring bones.
    pub kept: Vec<PassThrough>,
}

/// Reads a GLB or glTF 2.0 file (including VRM 0.x, VRM 1.0 and VRMA) as one character.
///
/// The resolver is called for external buffers and pictures with their relative, percent-decoded
/// URI; it alone decides which paths are allowed.
///
/// - *Joints* are the nodes that a skin or a humanoid extension names, that an animation moves or
///   that carry a mesh without skin, and all ancestors of these; parents first, depth first in the
///   order of the document. All other nodes are left out.
/// - *Meshes*: one for each node of a scene that shows one; nodes that MSFT_lod names as coarser
///   levels of another are levels of that node's mesh. A skinned mesh ignores the transform of its
///   own node, as the format requires.
/// - *Clips* are the animations in order: clip `i` is `animations[i]`.
/// - *Expressions* are those of VRM, else those of KHR_character.
/// - A VRM 0.x character, which faces -Z in its file, is turned to +Z.
///
/// ```
/// use articula_formats::{Limits, gltf};
///
/// let file = br#"{"asset": {"version": "2.0"}, "nodes": [{"name": "hips"}],
///     "skins": [{"joints": [0]}]}"#;
/// let mut nothing_beside = |uri: &str| Err(format!("{uri}: no such file"));
/// let read = gltf::read(file, &Limits::default(), &mut nothing_beside)?;
/// assert_eq!(read.value.character.skeleton.joints[0].name, "hips");
/// assert!(read.warnings.is_empty());
/// # Ok::<(), articula_formats::ReadError>(())
/// ```
///
/// # Errors
/// [`ReadError::Malformed`] with the path of the offending value, [`ReadError::Unsupported`] for a
/// required extension that is not supported, [`ReadError::Missing`] for a buffer that the resolver
/// cannot supply, [`ReadError::LimitExceeded`]. A missing picture is only a warning.
pub fn read(
    bytes: &[u8],
    limits: &Limits,
    resolver: &mut Resolver<'_>,
) -> Result<Parsed<GltfFile>, ReadError> {
    let mut notes = Notes::default();
    let document = Document::open(bytes, limits, resolver, &mut notes)?;
    read_noted(document, limits, notes)
}

/// Reads a document that is in memory, with the same result as [`read`] on its written bytes.
///
/// # Errors
/// Those of [`read`], except for a missing buffer.
pub fn read_document(document: Document, limits: &Limits) -> Result<Parsed<GltfFile>, ReadError> {
    read_noted(document, limits, Notes::default())
}

fn read_noted(
    document: Document,
    limits: &Limits,
    notes: Notes,
) -> Result<Parsed<GltfFile>, ReadError> {
    let mut reader = Reader::new(&document, limits, notes);
    let tree = node::read_tree(&reader)?;
    let skins = skin::read_all(&mut reader, tree.len())?;
    let human = vrm::read_nodes(&mut reader, tree.len());
    let skeletal = skeleton::read(&mut reader, &tree, &skins, &human)?;
    let look = material::read_all(&mut reader)?;
    let lods = lod::read(&mut reader, &tree);
    let given = node_meshes::Given {
        skeletal: &skeletal,
        skins: &skins,
        texcoords: &look.texcoords,
    };
    let shown = mesh::read_all(&mut reader, &given, &lods)?;
    let clips = animation::read_all(&mut reader, &skeletal, &shown)?;
    let articulation = articulation::read(&mut reader, &skeletal)?;
    let mut expressions = vrm::read_expressions(&mut reader, &shown)?;
    let mut responses = Vec::new();
    if expressions.is_empty() {
        let found = khr_character::read_expressions(&mut reader, &skeletal, &shown, &clips)?;
        (expressions, responses) = (found.expressions, found.clips);
    }
    let khr_character = khr_character::read(&mut reader, &skeletal, &expressions, responses);
    let joint = |(node, bone): (usize, String)| Some((skeletal.joint_of_node[node]?, bone));
    let humanoid: Vec<_> = human.bones.into_iter().filter_map(joint).collect();
    let kept = vrm::read_kept(&reader.root, &expressions);
    let mesh_levels = clustered::read_levels(&mut reader, &shown.meshes);
    let mut character = Character {
        name: name(&reader.root),
        skeleton: skeletal.skeleton,
        articulation,
        meshes: shown.meshes,
        mesh_levels,
        clips,
        materials: look.materials,
        images: look.images,
        expressions,
        told_controls: Default::default(),
        credits: credits::read(&reader.root),
    };
    if facing::faces_back(&document.json) {
        facing::turn(&mut character);
    }
    let draft = || {
        khr_character
            .as_ref()
            .map(|_| "KHR_character (draft)".to_owned())
    };
    let version = vrm::version(&reader.root).or_else(draft);
    let warnings = reader.notes.into_list();
    let value = GltfFile {
        document,
        character,
        node_of_joint: skeletal.node_of_joint,
        node_of_mesh: shown.node_of_mesh,
        version,
        humanoid: (!humanoid.is_empty()).then_some(humanoid),
        khr_character,
        kept,
    };
    Ok(Parsed { value, warnings })
}

/// Returns the character's name from a VRM extension, else that of the scene.
fn name(root: &Place<'_>) -> String {
    let meta = |keys: &[&str], key| root.dig(keys).map_or("", |meta| meta.text(key));
    let scene = root
        .get("scene")
        .and_then(|scene| scene.whole().ok())
        .and_then(|i| root.entry("scenes", i as usize))
        .map_or("", |scene| scene.text("name"));
    [
        meta(&["extensions", "VRMC_vrm", "meta"], "name"),
        meta(&["extensions", "VRM", "meta"], "title"),
        scene,
    ]
    .into_iter()
    .find(|name| !name.is_empty())
    .unwrap_or("")
    .to_owned()
}
