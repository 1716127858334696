//! Joints of a face that show its parameters.
//!
//! Faces of body rigs often have no morph targets but joints below the head, for lips, lids and brows.
//! The face animation table of the feature points says how the skin moves with each parameter; joints
//! are turned and shifted so that the skin they carry comes as near to it as it can.

use super::found::FoundFace;
use crate::figure::Figure;
use articula_build::face::{FaceTable, FapInterval, FapValues, FieldFit};
use articula_core::LibmQuat;
use articula_core::fap_table::LOW_FAPS;
use articula_core::{LocalPose, PosedMesh};
use glam::{Quat, Vec3};

/// Radians and metres by which joints are moved to see what follows them.
const STEP_RAD: f32 = 0.01;
const STEP_M: f32 = 1e-3;
/// Cost of turning and of shifting a joint; rigs of faces are made to be turned.
const RIDGES: [f64; 2] = [3e-3, 3e-2];
/// Share of a parameter's displacements, by their squares, from which joints show it.
const SHOWN: f32 = 0.25;
/// Factor by which a displacement counts at the feature points, where eyes look.
const AT_POINTS: f32 = 4.0;
/// Rounds of the fit: turned joints leave the straight line.
const ROUNDS: usize = 3;
/// Turns and shifts below these do not count.
const LEAST_RAD: f32 = 2e-4;
const LEAST_M: f32 = 2e-5;

/// How a joint leaves its rest pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct JointOffset {
    /// Index of the joint.
    pub(super) joint: usize,
    /// Rotation vector in the axes of the joint at rest, radians.
    pub(super) rotation: Vec3,
    /// Translation in the axes of its parent, metres.
    pub(super) translation: Vec3,
}

/// The joints of a face, as parts of its table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FaceJoints {
    /// The parts, each with what it adds to the joints at weight 1.
    pub(super) parts: Vec<(FapInterval, Vec<JointOffset>)>,
    /// Numbers of the parameters that the joints show, with the share of the table's displacements, by
    /// their squares, that they show of it.
    pub(super) shown: Vec<(usize, f32)>,
}

impl FaceJoints {
    /// Those of a figure; `None` without joints below its head that move the skin of its face, and for
    /// one whose feature points are not found or doubtful.
    pub(super) fn of(figure: &Figure) -> Option<Self> {
        let joints = below_head(figure);
        if joints.is_empty() {
            return None;
        }
        let face = FoundFace::of(figure, &[]).ok()?;
        if !face.doubtful().is_empty() {
            return None;
        }
        let table = face.table().ok()?;
        let mut skin = JointSkin::new(figure, &face, &joints);
        let fit = skin.fit()?;
        let eyes = face.head.surface.eyes.is_some();
        let mut found = Self {
            parts: Vec::new(),
            shown: Vec::new(),
        };
        for fap in LOW_FAPS.filter(|fap| !(eyes && (23..=26).contains(fap))) {
            let parts = fitted(&table, fap, &mut skin, &fit);
            let Some((_, _, share)) = parts.last() else {
                continue;
            };
            if *share >= SHOWN {
                found.shown.push((fap, *share));
                let parts = parts.into_iter();
                found
                    .parts
                    .extend(parts.map(|(interval, offsets, _)| (interval, offsets)));
            }
        }
        (!found.parts.is_empty()).then_some(found)
    }
}

/// Joints below the head, without eyes, which turn as a whole.
fn below_head(figure: &Figure) -> Vec<usize> {
    let rig = &figure.asset.rig;
    let find = |name: &str| rig.articulation().find(name);
    let Some(head) = find("skullbase") else {
        return Vec::new();
    };
    let eyes = [find("l_eyeball_joint"), find("r_eyeball_joint")];
    let is_eye = |joint: usize| {
        let mut eyes = eyes.iter().flatten();
        eyes.any(|eye| rig.is_at_or_below(joint, *eye))
    };
    let below = (0..rig.len()).filter(|j| *j != head && rig.is_at_or_below(*j, head));
    below.filter(|joint| !is_eye(*joint)).collect()
}

/// The intervals of a parameter, with what each adds to the joints, and the share of the table's
/// displacements at its end that the joints then show.
fn fitted(
    table: &FaceTable,
    fap: usize,
    skin: &mut JointSkin<'_>,
    fit: &FieldFit,
) -> Vec<(FapInterval, Vec<JointOffset>, f32)> {
    let at = |value: i32| table.displacements(&FapValues::alone(fap, value as f32));
    let mut ends: Vec<(i32, Vec<f32>)> = vec![(0, vec![0.0; skin.freedoms()])];
    let intervals = table.intervals(fap).into_iter();
    let part = |interval: FapInterval| {
        let target = at(interval.to);
        let (weights, share) = skin.shown(fit, &target);
        let from = ends.iter().find(|(value, _)| *value == interval.from);
        let from = from.map_or_else(|| vec![0.0; weights.len()], |(_, weights)| weights.clone());
        let added: Vec<f32> = weights.iter().zip(&from).map(|(b, a)| b - a).collect();
        ends.push((interval.to, weights));
        (interval, skin.offsets(&added), share)
    };
    intervals.map(part).collect()
}

/// The skin of a head as its joints move it.
struct JointSkin<'a> {
    figure: &'a Figure,
    face: &'a FoundFace,
    posed: PosedMesh<'a>,
    /// Joints that move skin.
    joints: Vec<usize>,
    rest: Vec<Vec3>,
    to_head: Quat,
    /// Factor by which the displacement of each vertex counts.
    counts: Vec<f32>,
}

impl<'a> JointSkin<'a> {
    fn new(figure: &'a Figure, face: &'a FoundFace, joints: &[usize]) -> Self {
        let asset = &figure.asset;
        let mut skin = Self {
            figure,
            face,
            posed: PosedMesh::new(&asset.rig, &asset.mesh),
            joints: Vec::new(),
            rest: Vec::new(),
            to_head: face.head.model_from_head.inverse(),
            counts: vec![1.0; face.head.vertices.len()],
        };
        let points = face.points.points.iter();
        points
            .filter_map(|p| p.vertex)
            .for_each(|v| skin.counts[v as usize] = AT_POINTS);
        skin.rest = skin.places(asset.rig.rest_pose());
        let mut carries = vec![false; asset.rig.len()];
        for vertex in &face.head.vertices {
            let influences = asset.mesh.influences_of(*vertex as usize);
            influences
                .filter(|(_, weight)| *weight > 0.0)
                .for_each(|(joint, _)| carries[joint] = true);
        }
        // One that carries others alone moves skin too.
        let moves = |joint: usize| {
            let mut all = (0..carries.len()).filter(|j| carries[*j]);
            all.any(|j| asset.rig.is_at_or_below(j, joint))
        };
        skin.joints = joints.iter().copied().filter(|j| moves(*j)).collect();
        skin
    }

    /// Turns about three axes and shifts along three for each joint.
    fn freedoms(&self) -> usize {
        6 * self.joints.len()
    }

    /// Places of the vertices of the head, in its frame.
    fn places(&mut self, pose: &LocalPose) -> Vec<Vec3> {
        let mut out = vec![Vec3::ZERO; self.face.head.vertices.len()];
        self.posed
            .pose(pose)
            .points(&self.face.head.vertices, &mut out);
        out.iter().map(|p| self.to_head * *p).collect()
    }

    fn displacements(&mut self, weights: &[f32]) -> Vec<Vec3> {
        let mut pose = self.figure.asset.rig.rest_pose().clone();
        for offset in self.offsets(weights) {
            let joint = offset.joint;
            pose.rotations[joint] *= Quat::libm_scaled_axis(offset.rotation);
            pose.translations[joint] += offset.translation;
        }
        let moved = self.places(&pose);
        moved.iter().zip(&self.rest).map(|(a, b)| *a - *b).collect()
    }

    /// What each freedom of the joints does to the skin; `None` without joints.
    fn fit(&mut self) -> Option<FieldFit> {
        let count = self.freedoms();
        let skin_counts = self.counts.clone();
        let mut fields = Vec::with_capacity(count);
        let mut ridges = Vec::with_capacity(count);
        for freedom in 0..count {
            let is_shift = freedom % 6 >= 3;
            let step = if is_shift { STEP_M } else { STEP_RAD };
            let mut weights = vec![0.0; count];
            weights[freedom] = step;
            let moved = self.displacements(&weights);
            let field = moved.iter().zip(&skin_counts);
            fields.push(field.map(|(o, count)| *count * *o / step).collect());
            ridges.push(RIDGES[usize::from(is_shift)]);
        }
        (count > 0).then(|| FieldFit::new(&fields, &ridges))
    }

    /// The weights of the freedoms that come nearest to displacements, and the share that they show.
    fn shown(&mut self, fit: &FieldFit, target: &[Vec3]) -> (Vec<f32>, f32) {
        let mut weights = vec![0.0; self.freedoms()];
        let mut left = target.to_vec();
        for _ in 0..ROUNDS {
            let counted = left.iter().zip(&self.counts).map(|(o, count)| *count * *o);
            let more = fit.weights(&counted.collect::<Vec<_>>());
            weights.iter_mut().zip(more).for_each(|(w, m)| *w += m);
            let shown = self.displacements(&weights);
            left = target.iter().zip(&shown).map(|(t, s)| *t - *s).collect();
        }
        let squares = |field: &[Vec3]| field.iter().map(|o| o.length_squared()).sum::<f32>();
        let share = 1.0 - squares(&left) / squares(target).max(f32::MIN_POSITIVE);
        (weights, share)
    }

    /// The joints that weights of the freedoms move.
    fn offsets(&self, weights: &[f32]) -> Vec<JointOffset> {
        let of_joint = self.joints.iter().zip(weights.chunks_exact(6));
        let offset = of_joint.map(|(joint, w)| JointOffset {
            joint: *joint,
            rotation: Vec3::from_slice(&w[..3]),
            translation: Vec3::from_slice(&w[3..]),
        });
        let moves =
            |o: &JointOffset| o.rotation.length() > LEAST_RAD || o.translation.length() > LEAST_M;
        offset.filter(moves).collect()
    }
}
