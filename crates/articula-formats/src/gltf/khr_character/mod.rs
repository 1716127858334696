//! The draft KHR_character family: what a glTF file says of a character without VRM.
//!
//! - `skeleton`: which node stands for which joint of a known rig
//! - `expressions`: animations that are driven by one number, with masks and mappings
//! - `write`: character, skeleton mapping and reference pose into a document
//!
//! Written against the schemas of KhronosGroup/glTF pull request 2512 as of July 2026; read with
//! tolerance for what came before and after (`KHR_avatar_*`, names in the place of indices). All
//! of it stands outside of the core format, so a broken entry is a warning. The page is
//! `docs/formats/khr-character.md`.

mod expressions;
mod skeleton;
mod write;

pub(super) use expressions::read as read_expressions;
pub(super) use skeleton::bones;

use super::place::Place;
use super::reader::Reader;
use super::skeleton::Skeletal;
use articula_core::source::Expression;
use serde_json::Value;

/// Names of the extensions of the family.
pub(super) const CHARACTER: &str = "KHR_character";
pub(super) const SKELETON_MAPPING: &str = "KHR_character_skeleton_mapping";
pub(super) const REFERENCE_POSE: &str = "KHR_character_reference_pose";
pub(super) const EXPRESSION: &str = "KHR_character_expression";

/// How the skeleton goes to a rig that others know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RigMapping {
    /// Name of the known rig, such as `vrmHumanoid`.
    pub rig: String,
    /// Joint of the skeleton and what the known rig calls it.
    pub joints: Vec<(usize, String)>,
}

/// A clip that is a pose for retargeting.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReferencePose {
    /// Index of the clip.
    pub clip: usize,
    /// `TPose`, `APose`, `IPose` or a name of the file's own.
    pub kind: String,
}

/// How one expression of the character makes part of one that others know.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpressionShare {
    /// Name of the expression in the known set.
    pub known: String,
    /// Index into the character's expressions.
    pub expression: usize,
    /// Its share.
    pub weight: f32,
}

/// How the expressions make up a set that others know.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpressionSet {
    /// Name of the known set.
    pub set: String,
    /// The shares, in the order of the file.
    pub shares: Vec<ExpressionShare>,
}

/// What the KHR_character family says of a file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KhrCharacter {
    /// Node above everything that belongs to the character.
    pub root_node: Option<usize>,
    /// The rigs that the skeleton is mapped to.
    pub rigs: Vec<RigMapping>,
    /// The clips that are poses.
    pub reference_poses: Vec<ReferencePose>,
    /// The clips that are responses of expressions: clip and expression.
    pub expression_clips: Vec<(usize, usize)>,
    /// The sets of expressions that the own ones are mapped to.
    pub expression_sets: Vec<ExpressionSet>,
}

/// Reads the family; `None` if the document has nothing of it. `expression_clips` are those of
/// the expressions that were read.
pub(super) fn read(
    reader: &mut Reader<'_>,
    skeletal: &Skeletal,
    expressions: &[Expression],
    expression_clips: Vec<(usize, usize)>,
) -> Option<KhrCharacter> {
    let root = reader.root.clone();
    let nodes = skeletal.joint_of_node.len();
    let character = extension(&root, CHARACTER);
    let found = KhrCharacter {
        root_node: character
            .as_ref()
            .and_then(|c| c.index("rootNode", nodes).ok()?),
        rigs: skeleton::rigs(reader, skeletal),
        reference_poses: reference_poses(&root),
        expression_clips,
        expression_sets: expressions::sets(reader, expressions),
    };
    (character.is_some() || found != KhrCharacter::default()).then_some(found)
}

/// An extension of the family on an object, in the spelling of any draft.
fn extension<'a>(owner: &Place<'a>, name: &str) -> Option<Place<'a>> {
    let extensions = owner.get("extensions")?;
    let older = name.replacen("KHR_character", "KHR_avatar", 1);
    let spellings = [
        name.to_owned(),
        format!("{name}s"),
        older.clone(),
        format!("{older}s"),
    ];
    spellings
        .iter()
        .find_map(|spelling| extensions.get(spelling))
}

fn reference_poses(root: &Place<'_>) -> Vec<ReferencePose> {
    let animations = root.entries("animations").unwrap_or_default();
    let pose = |(clip, animation): (usize, &Place<'_>)| {
        let pose = extension(animation, REFERENCE_POSE)?;
        let kind = match pose.text("poseType") {
            "" => "TPose",
            kind => kind,
        };
        let kind = kind.to_owned();
        Some(ReferencePose { clip, kind })
    };
    animations.iter().enumerate().filter_map(pose).collect()
}

/// Name, as the clip has it, and number of channels of each animation.
pub(super) fn named(animations: Option<&Vec<Value>>) -> Vec<(String, usize)> {
    let animations = animations.into_iter().flatten().enumerate();
    let named = |(i, animation): (usize, &Value)| {
        let place = Place::root(animation);
        let name = match place.text("name") {
            "" => format!("animation_{i}"),
            name => name.to_owned(),
        };
        (name, place.count("channels"))
    };
    animations.map(named).collect()
}
