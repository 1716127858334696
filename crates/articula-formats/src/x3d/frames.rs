//! Local frames of joints: from the fields of H-Anim joints to local transforms in metres.
//!
//! An H-Anim joint has no local frame at rest: its matrix `P` is the identity, and its position is
//! only the center of its rotation. Here a joint's frame has its origin at the center: `F = W · P ·
//! T(center) · SR / s`, with `W` the world-from-humanoid matrix and `s` its scale. Then the local
//! transform of a joint is exactly translation, rotation and scale, and all lengths are metres:
//!
//! - translation = `s · A · (translation + center)`, where `A` removes the parent's center (and the
//!   transforms in between),
//! - rotation = `A · rotation · SR`, scale = the file's.
//!
//! `SR`, the scale orientation, is almost always the identity; then so are rest rotations. A
//! humanoid that is non-uniformly scaled or mirrored gets an additional root joint, which holds
//! `W`.

use super::fields::Reader;
use super::figure::{Figure, FigureJoint};
use super::placement::{Placement, Similarity};
use crate::error::ReadError;
use articula_core::Transform;
use articula_core::source::{Joint, Skeleton};
use glam::{Affine3A, DAffine3, DMat3, DQuat, DVec3, Mat4, Quat, Vec3};

/// Maximum distance of two centers that count as equal.
const SAME_CENTER: f64 = 1e-9;

/// Conversion of one joint's fields to its local transform.
#[derive(Debug, Clone, Copy)]
pub(super) struct LocalFrame {
    /// From the parent's frame, without its length unit, to the joint's space.
    above: Similarity,
    center: DVec3,
    scale_orientation: DQuat,
    /// Metres per unit; 1 below a joint that holds the world matrix.
    unit: f64,
    /// Scale by which `above` is too large.
    scale: f64,
}

impl LocalFrame {
    /// Returns the local translation in metres for a value of the joint's field.
    pub(super) fn translation(&self, translation: DVec3) -> Vec3 {
        (self.above.point(translation + self.center) * self.unit).as_vec3()
    }

    /// Returns the local rotation for a value of the joint's field.
    pub(super) fn rotation(&self, rotation: DQuat) -> Quat {
        let local = self.above.rotation * rotation * self.scale_orientation;
        local.normalize().as_quat()
    }

    /// Returns the local scale for a value of the joint's field.
    pub(super) fn scale(&self, scale: DVec3) -> Vec3 {
        (scale * self.scale).as_vec3()
    }

    /// Returns the whole local transform.
    pub(super) fn local(&self, placement: &Placement) -> Transform {
        Transform {
            translation: self.translation(placement.translation),
            rotation: self.rotation(placement.rotation),
            scale: self.scale(placement.scale),
        }
    }
}

/// The skeleton of a figure, and its relation to the joints of the file.
#[derive(Debug)]
pub(super) struct Frames {
    pub(super) skeleton: Skeleton,
    /// One entry for each joint of the figure.
    pub(super) locals: Vec<LocalFrame>,
    /// Transform of each joint of the figure where no motion moves it.
    pub(super) stored: Vec<Transform>,
    /// Number of skeleton joints before those of the figure: 0 or 1.
    pub(super) first: usize,
    /// Joint-from-model matrices for rigidly attached shapes.
    pub(super) rigid: Vec<Affine3A>,
    /// Joint-from-model matrices for skin.
    pub(super) bind: Vec<Affine3A>,
}

impl Frames {
    /// Computes the frames of all joints.
    pub(super) fn new(reader: &mut Reader<'_>, figure: &Figure) -> Result<Self, ReadError> {
        if !figure.world.is_finite() || figure.world.matrix3.determinant().abs() < 1e-18 {
            return Err(reader.malformed(figure.id, "the scale of the humanoid is 0"));
        }
        let world = Similarity::of(&figure.world);
        let mut frames = Self {
            skeleton: Skeleton::default(),
            locals: Vec::new(),
            stored: Vec::new(),
            first: 0,
            rigid: Vec::new(),
            bind: Vec::new(),
        };
        if world.is_none() {
            frames.skeleton.joints.push(stretched(reader, figure));
            frames.first = 1;
        }
        for joint in &figure.joints {
            let local = frames.local(reader, figure, joint, world.as_ref());
            frames.locals.push(local);
        }
        let binding = binding(reader, figure)?;
        let stores_shape = centers_say_nothing(&figure.joints);
        for (index, joint) in figure.joints.iter().enumerate() {
            let rest = match &binding {
                Some(binding) => binding[index],
                None if stores_shape => joint.stored,
                None => joint.stored.at_rest(),
            };
            frames.push(index, joint, &rest);
        }
        if stores_shape && figure.joints.iter().any(|j| !j.stored.is_at_rest()) {
            let what = "no joint has a center; the translations of the joints give the shape of \
                        the figure";
            reader.warn(figure.id, what);
        }
        frames.check(reader, figure)?;
        frames.set_matrices(figure, binding.is_some());
        Ok(frames)
    }

    /// Makes the pose of the file's fields the rest pose. Shapes stay bound as they are.
    pub(super) fn rest_as_stored(&mut self) {
        for (joint, stored) in self.skeleton.joints[self.first..]
            .iter_mut()
            .zip(&self.stored)
        {
            joint.rest = *stored;
        }
    }

    fn local(
        &self,
        reader: &mut Reader<'_>,
        figure: &Figure,
        joint: &FigureJoint,
        world: Option<&Similarity>,
    ) -> LocalFrame {
        let unit = world.map_or(1.0, |w| w.scale);
        let (before, is_root) = match joint.parent {
            Some(parent) => {
                let parent = &figure.joints[parent].stored;
                let turn = DAffine3::from_quat(parent.scale_orientation.inverse());
                (turn * DAffine3::from_translation(-parent.center), false)
            }
            None if world.is_some() => (figure.world, true),
            None => (DAffine3::IDENTITY, false),
        };
        let matrix = before * joint.above;
        let above = Similarity::of(&matrix).unwrap_or_else(|| {
            let what = "a transform above the joint scales it unevenly or mirrors it; a uniform \
                        scale is used instead";
            reader.warn(joint.id, what);
            Similarity::near(&matrix)
        });
        LocalFrame {
            above,
            center: joint.stored.center,
            scale_orientation: joint.stored.scale_orientation,
            unit: if is_root { 1.0 } else { unit },
            scale: if is_root {
                above.scale / unit
            } else {
                above.scale
            },
        }
    }

    fn push(&mut self, index: usize, joint: &FigureJoint, rest: &Placement) {
        let first = self.first;
        let top = (first == 1).then_some(0);
        self.skeleton.joints.push(Joint {
            name: joint.name.clone(),
            parent: joint.parent.map_or(top, |p| Some(p + first)),
            rest: self.locals[index].local(rest),
            in_skin: true,
        });
        self.stored.push(self.locals[index].local(&joint.stored));
    }

    fn check(&self, reader: &Reader<'_>, figure: &Figure) -> Result<(), ReadError> {
        for (index, joint) in figure.joints.iter().enumerate() {
            let rest = self.skeleton.joints[index + self.first].rest;
            let stored = self.stored[index];
            let finite = |t: &Transform| t.is_finite() && t.translation.abs().max_element() < 1e12;
            if !finite(&rest) || !finite(&stored) {
                return Err(reader.malformed(joint.id, "the position of the joint is too large"));
            }
        }
        Ok(())
    }

    /// Sets the matrices. Rigid parts are in the space of their joint; skin is in that of the
    /// humanoid with every joint at its binding placement.
    fn set_matrices(&mut self, figure: &Figure, bound: bool) {
        let mut globals: Vec<DAffine3> = Vec::new();
        for joint in &self.skeleton.joints {
            let local = DAffine3::from_scale_rotation_translation(
                joint.rest.scale.as_dvec3(),
                joint.rest.rotation.as_dquat(),
                joint.rest.translation.as_dvec3(),
            );
            globals.push(joint.parent.map_or(local, |p| globals[p] * local));
        }
        let unit = match self.first {
            0 => 1.0 / Similarity::of(&figure.world).map_or(1.0, |w| w.scale),
            _ => 1.0,
        };
        for (index, joint) in figure.joints.iter().enumerate() {
            let turn = DMat3::from_quat(joint.stored.scale_orientation) * unit;
            let own = DAffine3::from_mat3_translation(turn, joint.stored.center);
            let rigid = inverse(&(figure.world * own));
            self.rigid.push(rigid.as_affine3a());
            let bind = match bound {
                true => inverse(&globals[index + self.first]),
                false => rigid,
            };
            self.bind.push(bind.as_affine3a());
        }
    }
}

/// Returns the inverse; for a singular matrix, the identity.
fn inverse(matrix: &DAffine3) -> DAffine3 {
    let inverse = matrix.inverse();
    let sound = inverse.is_finite() && inverse.to_cols_array().iter().all(|e| e.abs() < 1e30);
    if sound { inverse } else { DAffine3::IDENTITY }
}

/// Returns the joint that holds the matrix of a humanoid if it is not a similarity.
fn stretched(reader: &mut Reader<'_>, figure: &Figure) -> Joint {
    let m = figure.world;
    let matrix = Mat4::from_cols(
        m.matrix3.x_axis.as_vec3().extend(0.0),
        m.matrix3.y_axis.as_vec3().extend(0.0),
        m.matrix3.z_axis.as_vec3().extend(0.0),
        m.translation.as_vec3().extend(1.0),
    );
    let rest = Transform::from_matrix(matrix).unwrap_or_else(|| {
        reader.warn(
            figure.id,
            "the transform of the humanoid is sheared; shown without the shear",
        );
        let near = Similarity::near(&m);
        Transform {
            translation: near.translation.as_vec3(),
            rotation: near.rotation.as_quat(),
            scale: Vec3::splat(near.scale as f32),
        }
    });
    Joint {
        name: reader.name(figure.id),
        parent: None,
        rest,
        in_skin: false,
    }
}

/// Returns whether all joints have the same center, so that the centers cannot define the figure's
/// shape. Files converted from other formats store offsets as translations.
fn centers_say_nothing(joints: &[FigureJoint]) -> bool {
    let first = joints.first().map_or(DVec3::ZERO, |j| j.stored.center);
    joints.len() > 1
        && joints
            .iter()
            .all(|j| j.stored.center.distance(first) < SAME_CENTER)
}

/// Returns the placements at which the skin was bound (H-Anim 2, 6.2), if the humanoid has any. One
/// value applies to all joints; several follow the order of the field `joints`.
fn binding(reader: &mut Reader<'_>, figure: &Figure) -> Result<Option<Vec<Placement>>, ReadError> {
    let positions = reader.tuples::<3>(figure.id, "jointBindingPositions")?;
    let rotations = reader.tuples::<4>(figure.id, "jointBindingRotations")?;
    let scales = reader.tuples::<3>(figure.id, "jointBindingScales")?;
    let mut placements: Vec<Placement> = figure.joints.iter().map(|j| j.stored.at_rest()).collect();
    let listed = reader.nodes(figure.id, "joints");
    let slots: std::collections::HashMap<_, _> =
        listed.iter().enumerate().map(|(i, id)| (*id, i)).collect();
    for (joint, placement) in figure.joints.iter().zip(&mut placements) {
        let slot = slots.get(&joint.id).copied();
        if let Some(position) = one_of(&positions, slot) {
            placement.translation = DVec3::from_array(position);
        }
        if let Some(rotation) = one_of(&rotations, slot) {
            placement.rotation = reader.turn(rotation);
        }
        if let Some(scale) = one_of(&scales, slot) {
            placement.scale = DVec3::from_array(scale);
        }
    }
    let says_something = placements.iter().any(|p| !p.is_at_rest());
    Ok(says_something.then_some(placements))
}

fn one_of<const N: usize>(values: &[[f64; N]], slot: Option<usize>) -> Option<[f64; N]> {
    match values {
        [only] => Some(*only),
        many => many.get(slot?).copied(),
    }
}
