//! Points of the skin at which the error of a coded motion is measured.
//!
//! Form: `docs/methods/motion-stream.md`, part 1.

use super::truth::Truth;
use articula_core::{LocalPose, Mesh, ModelPose, Rig, local_to_model};
use glam::{Affine3A, Vec3, Vec3A};
use std::ops::Range;

/// Distance of the points of a joint without a mesh, in metres.
const BONE_METRES: Range<f32> = 0.03..0.15;

/// Points with their influences and morph offsets.
#[derive(Debug, Clone, Default)]
pub(super) struct SkinPoints {
    bindings: Vec<(usize, Affine3A)>,
    points: Vec<Point>,
    influences: Vec<(u16, f32)>,
    offsets: Vec<(u16, Vec3)>,
}

#[derive(Debug, Clone)]
struct Point {
    position: Vec3,
    influences: Range<usize>,
    offsets: Range<usize>,
}

/// Buffers of [`SkinPoints::skin`].
#[derive(Debug, Clone)]
pub(super) struct Posed {
    pub(super) local: LocalPose,
    pub(super) model: ModelPose,
    pub(super) palette: Vec<Affine3A>,
    pub(super) points: Vec<Vec3>,
}

/// Morph offsets of each vertex: slot and offset.
pub(super) fn offsets_by_vertex(mesh: &Mesh) -> Vec<Vec<(u16, Vec3)>> {
    let mut offsets = vec![Vec::new(); mesh.len()];
    for morph in &mesh.morphs {
        for (vertex, offset) in morph.vertices.iter().zip(&morph.positions) {
            offsets[*vertex as usize].push((morph.slot, *offset));
        }
    }
    offsets
}

impl SkinPoints {
    /// Takes some vertices of a mesh.
    pub(super) fn of_vertices(
        mesh: &Mesh,
        offsets: &[Vec<(u16, Vec3)>],
        vertices: impl Iterator<Item = usize>,
    ) -> Self {
        let bindings = mesh.bindings.iter();
        let mut points = Self {
            bindings: bindings
                .map(|b| (usize::from(b.joint), b.inverse_bind))
                .collect(),
            ..Self::default()
        };
        for v in vertices {
            let at = v * mesh.influences..(v + 1) * mesh.influences;
            let weights = mesh.binding_indices[at.clone()]
                .iter()
                .zip(&mesh.weights[at]);
            let (first, first_offset) = (points.influences.len(), points.offsets.len());
            points
                .influences
                .extend(weights.filter(|(_, w)| **w > 0.0).map(|(b, w)| (*b, *w)));
            points.offsets.extend(&offsets[v]);
            points.points.push(Point {
                position: mesh.positions[v],
                influences: first..points.influences.len(),
                offsets: first_offset..points.offsets.len(),
            });
        }
        points
    }

    /// Takes three points around each joint of a rig without a mesh, half a bone away.
    pub(super) fn of_bones(rig: &Rig) -> Self {
        let mut model = ModelPose::new(rig.len());
        local_to_model(rig, rig.rest_pose(), &mut model);
        let mut points = Self::default();
        for joint in 0..rig.len() {
            let children = (joint + 1..rig.len()).filter(|c| rig.parent(*c) == Some(joint));
            let ends = children.chain(rig.parent(joint));
            let length = ends.map(|end| model.position(end).distance(model.position(joint)));
            let length = length.fold(0.0, f32::max) / 2.0;
            let away = length.clamp(BONE_METRES.start, BONE_METRES.end);
            // In metres along the joint's axes, whatever the scale above it.
            let inverse = model.matrices[joint].inverse();
            points.bindings.push((joint, Affine3A::IDENTITY));
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                let at = points.influences.len();
                points.influences.push((joint as u16, 1.0));
                let position = model.position(joint) + away * axis;
                points.points.push(Point {
                    position: inverse.transform_point3(position),
                    influences: at..at + 1,
                    offsets: 0..0,
                });
            }
        }
        points
    }

    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// The joints that a point follows, with their weights.
    pub(super) fn joints(&self, point: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        let influences = self.influences(point).iter();
        influences.map(|(b, w)| (self.bindings[usize::from(*b)].0, *w))
    }

    /// The morph targets that move a point, with their offsets.
    pub(super) fn offsets(&self, point: usize) -> &[(u16, Vec3)] {
        &self.offsets[self.points[point].offsets.clone()]
    }

    /// Allocates buffers.
    pub(super) fn posed(&self, rig: &Rig) -> Posed {
        Posed {
            local: rig.rest_pose().clone(),
            model: ModelPose::new(rig.len()),
            palette: vec![Affine3A::IDENTITY; self.bindings.len()],
            points: vec![Vec3::ZERO; self.points.len()],
        }
    }

    /// Skins the points by the local pose in `posed`.
    pub(super) fn skin(&self, rig: &Rig, weights: &[f32], posed: &mut Posed) {
        self.turn(rig, posed);
        for point in 0..self.points.len() {
            posed.points[point] = self.skinned(point, weights, &posed.palette);
        }
    }

    /// Sets the matrices of the bindings by the local pose in `posed`.
    pub(super) fn turn(&self, rig: &Rig, posed: &mut Posed) {
        local_to_model(rig, &posed.local, &mut posed.model);
        for (matrix, (joint, inverse)) in posed.palette.iter_mut().zip(&self.bindings) {
            *matrix = posed.model.matrices[*joint] * *inverse;
        }
    }

    /// One point, by the matrices of the bindings.
    pub(super) fn skinned(&self, point: usize, weights: &[f32], palette: &[Affine3A]) -> Vec3 {
        let point = &self.points[point];
        let offsets = self.offsets[point.offsets.clone()].iter();
        let moved = offsets.fold(point.position, |p, (slot, offset)| {
            p + *offset * weights[usize::from(*slot)]
        });
        let moved = Vec3A::from(moved);
        let mut sum = Vec3A::ZERO;
        for (binding, weight) in &self.influences[point.influences.clone()] {
            sum += palette[usize::from(*binding)].transform_point3a(moved) * *weight;
        }
        sum.into()
    }

    /// A point at rest.
    pub(super) fn position(&self, point: usize) -> Vec3 {
        self.points[point].position
    }

    /// The bindings that a point follows, with their weights.
    pub(super) fn influences(&self, point: usize) -> &[(u16, f32)] {
        &self.influences[self.points[point].influences.clone()]
    }

    /// Skins the points at all frames, frame by frame.
    pub(super) fn shown(&self, rig: &Rig, motion: &Truth) -> Vec<Vec3> {
        let mut posed = self.posed(rig);
        let mut shown = Vec::with_capacity(motion.frames * self.len());
        for frame in 0..motion.frames {
            motion.pose(frame, &mut posed.local);
            self.skin(rig, motion.weights(frame), &mut posed);
            shown.extend_from_slice(&posed.points);
        }
        shown
    }
}

/// Greatest and mean distance of the points of two motions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SkinError {
    /// Greatest distance over all points and frames, in metres.
    pub max_metres: f64,
    /// Mean distance in metres.
    pub mean_metres: f64,
}

/// What a motion is measured against.
pub(super) struct Measure<'a> {
    pub(super) rig: &'a Rig,
    pub(super) points: &'a SkinPoints,
    pub(super) truth: &'a Truth,
    /// The true points of all frames, frame by frame, if they are known.
    pub(super) shown: Option<&'a [Vec3]>,
}

impl Measure<'_> {
    /// Calls `each` with every point and its distance from the truth, frame by frame.
    pub(super) fn distances(
        &self,
        motion: &Truth,
        frames: Range<usize>,
        mut each: impl FnMut(usize, f64),
    ) {
        let (mut expected, mut found) = (self.points.posed(self.rig), self.points.posed(self.rig));
        let count = self.points.len();
        for frame in frames {
            let expected = match self.shown {
                Some(shown) => &shown[frame * count..(frame + 1) * count],
                None => {
                    self.truth.pose(frame, &mut expected.local);
                    self.points
                        .skin(self.rig, self.truth.weights(frame), &mut expected);
                    &expected.points
                }
            };
            motion.pose(frame, &mut found.local);
            self.points
                .skin(self.rig, motion.weights(frame), &mut found);
            for (i, (a, b)) in expected.iter().zip(&found.points).enumerate() {
                each(i, f64::from(a.distance(*b)));
            }
        }
    }

    /// Measures all frames.
    pub(super) fn error(&self, motion: &Truth) -> SkinError {
        self.error_in(motion, 0..self.truth.frames)
    }

    /// Measures some frames.
    pub(super) fn error_in(&self, motion: &Truth, frames: Range<usize>) -> SkinError {
        let mut sums = Sums::default();
        self.distances(motion, frames, |_, distance| sums.add(distance));
        sums.error()
    }
}

/// Distances so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    most: f64,
    sum: f64,
    pub(super) squares: f64,
    count: usize,
}

impl Sums {
    pub(super) fn add(&mut self, distance: f64) {
        self.most = self.most.max(distance);
        self.sum += distance;
        self.squares += distance * distance;
        self.count += 1;
    }

    pub(super) fn error(&self) -> SkinError {
        SkinError {
            max_metres: self.most,
            mean_metres: self.sum / self.count.max(1) as f64,
        }
    }
}
