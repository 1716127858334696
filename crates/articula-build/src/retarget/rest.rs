//! A skeleton at rest, in the form that retargeting needs: joint positions, orientations and names.

use super::RetargetFigure;
use articula_core::Mismatch;
use glam::{Affine3A, Mat3, Mat3A, Quat, Vec3};
use std::collections::BTreeMap;

/// Positions and orientations at rest, and the mapping to H-Anim.
#[derive(Debug, Clone)]
pub(super) struct Rest {
    pub(super) parents: Vec<Option<usize>>,
    /// Model-from-joint matrices.
    pub(super) matrices: Vec<Affine3A>,
    /// Positions in model space, metres.
    pub(super) positions: Vec<Vec3>,
    /// Rotation part of `matrices`; of a mirrored joint, of the negated matrix. Conjugation with it
    /// converts a rotation between the joint's space and model space in both cases.
    pub(super) rotations: Vec<Quat>,
    /// Local rotations and translations.
    pub(super) locals: Vec<(Quat, Vec3)>,
    /// H-Anim name of each mapped joint.
    pub(super) hanim: Vec<Option<String>>,
    /// Joint names of the rig.
    pub(super) names: Vec<String>,
    by_hanim: BTreeMap<String, usize>,
}

impl Rest {
    /// Converts a figure.
    pub(super) fn new(figure: &RetargetFigure<'_>, which: &str) -> Result<Self, Mismatch> {
        let joints = &figure.skeleton.joints;
        let known = &figure.articulation.joints;
        if known.len() != joints.len() {
            let what = format!(
                "{} joints, but the articulation lists {}",
                joints.len(),
                known.len()
            );
            return Err(Mismatch::new(which, what));
        }
        let mut matrices: Vec<Affine3A> = Vec::with_capacity(joints.len());
        for (j, joint) in joints.iter().enumerate() {
            let at = || format!("{which}.joints[{j}]");
            let local = joint.rest.to_affine();
            let matrix = match joint.parent {
                Some(p) if p >= j => {
                    return Err(Mismatch::new(at(), "its parent must come before it"));
                }
                Some(p) => matrices[p] * local,
                None => local,
            };
            if !matrix.is_finite() {
                return Err(Mismatch::new(at(), "its rest transform must be finite"));
            }
            matrices.push(matrix);
        }
        let hanim: Vec<Option<String>> = known.iter().map(|k| k.hanim.clone()).collect();
        let mut by_hanim = BTreeMap::new();
        for (j, name) in hanim.iter().enumerate() {
            if let Some(name) = name {
                by_hanim.entry(name.clone()).or_insert(j);
            }
        }
        Ok(Self {
            parents: joints.iter().map(|j| j.parent).collect(),
            positions: matrices.iter().map(|m| m.translation.into()).collect(),
            rotations: matrices
                .iter()
                .map(|m| proper_rotation(m.matrix3.into()))
                .collect(),
            locals: joints
                .iter()
                .map(|j| (j.rest.rotation, j.rest.translation))
                .collect(),
            names: joints.iter().map(|j| j.name.clone()).collect(),
            matrices,
            hanim,
            by_hanim,
        })
    }

    /// The same joints in another pose: rotations from this one, and positions, in model space.
    pub(super) fn posed(&self, turns: &[Quat], positions: &[Vec3]) -> Self {
        let mut posed = self.clone();
        for (j, turn) in turns.iter().enumerate() {
            let above = self.parents[j].map_or(Quat::IDENTITY, |p| turns[p]);
            let around = self.parent_rotation(j);
            let local = around.inverse() * above.inverse() * *turn * around;
            posed.locals[j].0 = (local * self.locals[j].0).normalize();
            posed.rotations[j] = (*turn * self.rotations[j]).normalize();
            let linear = Mat3A::from_quat(*turn) * self.matrices[j].matrix3;
            posed.matrices[j] = Affine3A {
                matrix3: linear,
                translation: positions[j].into(),
            };
        }
        posed.positions = positions.to_vec();
        posed
    }

    pub(super) fn len(&self) -> usize {
        self.parents.len()
    }

    /// The joint that is mapped to an H-Anim name.
    pub(super) fn find(&self, hanim: &str) -> Option<usize> {
        self.by_hanim.get(hanim).copied()
    }

    /// The joint of that name on one side, `l` or `r`.
    pub(super) fn sided(&self, side: char, name: &str) -> Option<usize> {
        self.find(&format!("{side}_{name}"))
    }

    /// The knuckles of a hand, from the index finger on: the first joint of each finger beyond the
    /// palm, or what the rig has of it.
    pub(super) fn knuckles(&self, side: char) -> Vec<usize> {
        let knuckle = |name: &str| {
            let digits = [1, 2, 0].into_iter();
            digits
                .filter_map(|d| self.sided(side, &format!("{name}{d}")))
                .next()
        };
        let fingers = ["index", "middle", "ring", "pinky"].into_iter();
        fingers.filter_map(knuckle).collect()
    }

    /// The highest joint of spine, neck and head.
    pub(super) fn spine_top(&self) -> Option<usize> {
        let tops = ["skullbase", "vc1", "vc2", "vc4", "vc7"];
        tops.iter().find_map(|name| self.find(name))
    }

    /// The joints in whose middle the trunk ends: the shoulders, or the lowest joint of the neck.
    pub(super) fn trunk_top(&self) -> Vec<usize> {
        let shoulders = ['l', 'r'].map(|side| self.sided(side, "shoulder"));
        if let [Some(left), Some(right)] = shoulders {
            return vec![left, right];
        }
        let names = ["vc7", "vc4", "vc2", "skullbase"];
        names
            .iter()
            .find_map(|name| self.find(name))
            .into_iter()
            .collect()
    }

    /// H-Anim name of a joint, or `""`.
    pub(super) fn title(&self, joint: usize) -> &str {
        self.hanim[joint].as_deref().unwrap_or("")
    }

    /// The joints strictly between `above` and `joint`, upper first; `None` if `above` is no
    /// ancestor of `joint`.
    pub(super) fn between(&self, above: usize, joint: usize) -> Option<Vec<usize>> {
        let mut path = Vec::new();
        let mut at = self.parents[joint];
        while let Some(j) = at {
            if j == above {
                path.reverse();
                return Some(path);
            }
            path.push(j);
            at = self.parents[j];
        }
        None
    }

    /// Rotation of a joint's parent in model space; the identity for a root.
    pub(super) fn parent_rotation(&self, joint: usize) -> Quat {
        self.parents[joint].map_or(Quat::IDENTITY, |p| self.rotations[p])
    }

    /// Offset from one joint to another at rest, in model space.
    pub(super) fn way(&self, from: usize, to: usize) -> Vec3 {
        self.positions[to] - self.positions[from]
    }

    pub(super) fn children(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        (joint + 1..self.len()).filter(move |c| self.parents[*c] == Some(joint))
    }
}

/// The rotation in a linear map, without scale and shear; of the negated map if it mirrors.
pub(super) fn proper_rotation(linear: Mat3) -> Quat {
    let linear = if linear.determinant() < 0.0 {
        -linear
    } else {
        linear
    };
    let x = linear.x_axis.normalize_or_zero();
    let y = (linear.y_axis - x * x.dot(linear.y_axis)).normalize_or_zero();
    if x == Vec3::ZERO || y == Vec3::ZERO {
        return Quat::IDENTITY;
    }
    Quat::from_mat3(&Mat3::from_cols(x, y, x.cross(y))).normalize()
}
