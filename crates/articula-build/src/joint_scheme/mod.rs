//! Conversion of a character and its clips between the joint schemes of H-Anim and of the thesis.
//!
//! - `tree`, `skin`: joints are inserted and removed, with everything that refers to joints
//! - `motion`: clips in which the motion of a removed joint goes on in others
//! - `measure`: how far joints and skin are from where they were
//!
//! Joints are found by their H-Anim names. To the scheme of the thesis, the rotation of a subtalar
//! against its rest goes to its parent, the ankle, and `thumb0` joints are inserted above the
//! `thumb1` joints. To that of H-Anim, the motion of a `thumb0` goes to the joints below it, and
//! subtalars are inserted between ankles and feet. Where a rig lacks the neighbours of a joint, it
//! stays as it is.
//!
//! All other joints keep their transforms in model space at every key, since the joints next to a
//! removed one also take its translation, as keys of their own. Skin of a removed joint follows the
//! joint that takes its rotation, so it moves as before while the removed joint is still.
//!
//! Source: thesis 3.1.3, tables 3.2 to 3.4; `docs/methods/hanim.md` part 4.

mod measure;
mod motion;
mod scheme;
mod skin;
mod tree;

use articula_core::hanim_table::{HanimJoint, named};
use articula_core::joint_names::Side;
use articula_core::source::{Character, Skeleton};
use articula_core::{Articulation, Mismatch, Transform};
use glam::{Vec2, Vec3};
use tree::Tree;

pub use scheme::JointScheme;

/// Result of a conversion to a joint scheme.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SchemeChange {
    /// What was done, in this order; indices of joints are those at the time.
    pub edits: Vec<JointEdit>,
    /// Maximum distance in metres of a joint that was kept from where it was, at the keys of all
    /// clips and halfway between them.
    pub joints_metres: f32,
    /// The same of a vertex of the finest meshes, without morph targets.
    pub skin_metres: f32,
}

/// A joint that was inserted or removed.
#[derive(Debug, Clone, PartialEq)]
pub enum JointEdit {
    /// A joint was inserted between another one and one of its children.
    Inserted(InsertedJoint),
    /// A joint was removed, and its children hang from its parent.
    Merged(MergedJoint),
}

/// A joint that was inserted.
#[derive(Debug, Clone, PartialEq)]
pub struct InsertedJoint {
    /// Its index; that of the child is one more now.
    pub joint: usize,
    /// Its name, an H-Anim name.
    pub name: String,
    /// Index of its parent.
    pub parent: usize,
    /// Name of its parent.
    pub parent_name: String,
    /// Name of its child.
    pub child_name: String,
    /// Its offset from the parent at rest, in the parent's space.
    pub offset: Vec3,
    /// Local transform of the child at rest.
    pub child_rest: Transform,
}

/// A joint that was removed.
#[derive(Debug, Clone, PartialEq)]
pub struct MergedJoint {
    /// Index that it had.
    pub joint: usize,
    /// Its name.
    pub name: String,
    /// Index of its parent.
    pub parent: usize,
    /// Index that the joint had which took its rotation and its skin.
    pub into: usize,
    /// Name of that joint.
    pub into_name: String,
    /// Transform of the removed joint relative to that joint, at rest.
    pub rest: Transform,
    /// Indices that its children had, and their local transforms at rest now.
    pub children: Vec<(usize, Transform)>,
}

/// Converts a character and its clips to a joint scheme; `ends` are points that hang from joints,
/// such as end sites. A rig that has no joint of the other scheme, and no place for one of this
/// scheme, stays as it is.
///
/// # Errors
/// A [`Mismatch`] if the character is not consistent, or if a joint that is involved has a scale
/// that differs along its axes, or an expression moves a joint that would be removed. The character
/// is then unchanged.
pub fn set_joint_scheme(
    character: &mut Character,
    articulation: &mut Articulation,
    ends: &mut Vec<(usize, Vec3)>,
    scheme: JointScheme,
) -> Result<SchemeChange, Mismatch> {
    let mut tree = Tree::new(character, articulation, ends)?;
    let mut edits = Vec::new();
    for side in Side::BOTH {
        let [thumb, wrist, thumb_base, ankle, subtalar] =
            ["thumb1", "wrist", "thumb0", "ankle", "subtalar"]
                .map(|part| format!("{}_{part}", side.letter()));
        match scheme {
            JointScheme::Thesis => {
                if let Some(joint) = tree.find(&subtalar) {
                    edits.extend(tree.merge_into_parent(joint)?.map(JointEdit::Merged));
                }
                if let Some(place) = tree.place_above(&thumb_base, &thumb, &wrist) {
                    let row = row(&thumb_base)?;
                    edits.push(JointEdit::Inserted(tree.insert(row, place, Vec3::ZERO)));
                }
            }
            JointScheme::Hanim => {
                if let Some(joint) = tree.find(&thumb_base) {
                    let merged = tree.merge_into_children(joint, &thumb)?;
                    edits.extend(merged.map(JointEdit::Merged));
                }
                if let Some((place, offset)) = foot(&tree, [&subtalar, &ankle], side)? {
                    let row = row(&subtalar)?;
                    edits.push(JointEdit::Inserted(tree.insert(row, place, offset)));
                }
            }
        }
    }
    if edits.is_empty() {
        return Ok(SchemeChange::default());
    }
    let (joints_metres, skin_metres) = measure::largest_distances(character, &tree);
    *character = tree.character;
    articulation.joints = tree.joints;
    *ends = tree.ends;
    Ok(SchemeChange {
        edits,
        joints_metres,
        skin_metres,
    })
}

fn row(name: &str) -> Result<&'static HanimJoint, Mismatch> {
    named(name).ok_or_else(|| Mismatch::new("joint scheme", format!("no joint \"{name}\"")))
}

/// Where a joint is inserted: its parent and the parent's child that becomes its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place {
    parent: usize,
    child: usize,
}

/// Where the subtalar of a foot is inserted, and its offset from the ankle; `None` if it is there,
/// or if ankle or foot are missing. A foot of several mapped branches, such as five toes on the
/// ankle, has no single joint below a subtalar, and stays as it is.
fn foot(
    tree: &Tree,
    [subtalar, ankle]: [&str; 2],
    side: Side,
) -> Result<Option<(Place, Vec3)>, Mismatch> {
    for part in ["midtarsal", "metatarsal"] {
        let below = format!("{}_{part}", side.letter());
        let (Some(joint), Some(place)) =
            (tree.find(&below), tree.place_below(subtalar, &below, ankle))
        else {
            continue;
        };
        if tree.has_other_branch(place) {
            return Ok(None);
        }
        let rows = [ankle, subtalar, &below].map(row);
        let [from, center, to] = rows;
        let shape = Shape::of(from?.center, center?.center, to?.center);
        let offset = shape.offset(&tree.character.skeleton, place.parent, joint);
        return Ok(Some((place, offset)));
    }
    Ok(None)
}

/// Where a point is in relation to two others in the standard's figure: the ratio of heights, and
/// that of displacements over the ground, as a complex number, which does not depend on where the
/// toes point.
#[derive(Debug, Clone, Copy)]
struct Shape {
    height: f32,
    ground: Vec2,
}

impl Shape {
    fn of(from: Vec3, point: Vec3, to: Vec3) -> Self {
        let (point, to) = (point - from, to - from);
        let (a, b) = (ground(point), ground(to));
        Self {
            height: point.y / to.y,
            ground: Vec2::new(b.dot(a), b.perp_dot(a)) / b.length_squared(),
        }
    }

    /// The offset of such a point from a joint, in the joint's space.
    fn offset(self, skeleton: &Skeleton, from: usize, to: usize) -> Vec3 {
        let model = skeleton.model_rest();
        let (from, to) = (model[from], model[to]);
        let apart = Vec3::from(to.translation - from.translation);
        let over = self.ground.rotate(ground(apart));
        let offset = Vec3::new(over.x, apart.y * self.height, over.y);
        let local = from.inverse().transform_vector3(offset);
        if local.is_finite() { local } else { Vec3::ZERO }
    }
}

fn ground(v: Vec3) -> Vec2 {
    Vec2::new(v.x, v.z)
}

#[cfg(test)]
mod tests;
