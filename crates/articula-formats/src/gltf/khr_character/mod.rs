//! The draft KHR_character extensions: character data of a glTF file without VRM.
//!
//! - `skeleton`: mapping of nodes to the joints of a known rig
//! - `expressions`: animations that are driven by one number, with masks and mappings
//! - `write`: writes character, skeleton mapping and reference pose into a document
//!
//! Implements the schemas of KhronosGroup/glTF pull request 2512 as of July 2026; the reader also
//! accepts earlier and later forms (`KHR_avatar_*`, names instead of indices). The extensions are
//! not part of the core format, so a broken entry is a warning. See
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

/// Mapping of the skeleton to a known rig.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RigMapping {
    /// Name of the known rig, such as `vrmHumanoid`.
    pub rig: String,
    /// Joint of the skeleton, and its name in the known rig.
    pub joints: Vec<(usize, String)>,
}

/// A clip that is a pose for retargeting.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReferencePose {
    /// Index of the clip.
    pub clip: usize,
    /// `TPose`, `APose`, `IPose` or a name defined by the file.
    pub kind: String,
}

/// Contribution of one expression of the character to an expression of a known set.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpressionShare {
    /// Name of the expression in the known set.
    pub known: String,
    /// Index into the character's expressions.
    pub expression: usize,
    /// Its weight.
    pub weight: f32,
}

/// Mapping of the character's expressions to a known set.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpressionSet {
    /// Name of the known set.
    pub set: String,
    /// The contributions, in the order of the file.
    pub shares: Vec<ExpressionShare>,
}

/// Content of the KHR_character extensions of a file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KhrCharacter {
    /// Common ancestor of all nodes of the character.
    pub root_node: Option<usize>,
    /// The rigs that the skeleton is mapped to.
    pub rigs: Vec<RigMapping>,
    /// The clips that are reference poses.
    pub reference_poses: Vec<ReferencePose>,
    /// The clips that are responses of expressions: clip and expression.
    pub expression_clips: Vec<(usize, usize)>,
    /// The known sets of expressions that the character's are mapped to.
    pub expression_sets: Vec<ExpressionSet>,
}

/// Reads the family; `None` if the document has none of it. `expression_clips` are those of the
/// expressions that were read.
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

/// Returns an extension of the family, under the name of any draft.
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

/// Returns the name, as in the clip, and number of channels of each animation.
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
