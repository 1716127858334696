//! How a default inside of the mouth moves with the morph targets of a face.

use super::shape::{MouthShape, MouthVertex};
use crate::face::FoundFace;
use crate::figure::Figure;
use articula_build::face::JawMotion;
use articula_core::fap_table::FapUnit;
use articula_core::feature_points::PointId;
use articula_core::{Mesh, ModelPose, Morph, local_to_model, palette};
use glam::{Affine3A, Mat3A, Quat, Vec2, Vec3, Vec3A};

/// Points of the chin; their mean is what the jaw does, as one may be moved by a shape of the skin alone.
const CHIN: [PointId; 3] = [(2, 1), (2, 11), (2, 12)];
/// Motion of the chin up to which the jaw rests, by the height of the face.
const STILL: f32 = 0.01;

/// The motion of chin and lips by morph targets.
pub(super) struct FaceMotion<'a> {
    figure: &'a Figure,
    face: &'a FoundFace,
    palette: Vec<Affine3A>,
    hinge: Vec3,
    /// Vertices of the head's surface.
    lips: [u32; 2],
    /// Vertex of the figure's mesh with the joints of which the mouth turns.
    skull: u32,
}

impl<'a> FaceMotion<'a> {
    /// `None` if no skin stands for the points of the lips and the chin.
    pub(super) fn new(figure: &'a Figure, face: &'a FoundFace) -> Option<Self> {
        let asset = &figure.asset;
        let mut rest = ModelPose::new(asset.rig.len());
        local_to_model(&asset.rig, asset.rig.rest_pose(), &mut rest);
        let mut matrices = vec![Affine3A::IDENTITY; asset.mesh.bindings.len()];
        palette(&asset.mesh, &rest, &mut matrices);
        let vertex = |point| face.points.get(point)?.vertex;
        Some(Self {
            figure,
            face,
            palette: matrices,
            hinge: face.points.jaw_hinge()?,
            lips: [vertex((2, 2))?, vertex((2, 3))?],
            skull: face.head.vertices[vertex((9, 3))? as usize],
        })
    }

    /// The vertices of the upper and of the lower lip in the middle.
    pub(super) fn lips(&self) -> [u32; 2] {
        self.lips
    }

    pub(super) fn height(&self) -> f32 {
        self.face.points.height()
    }

    /// The distance of a unit of facial animation parameters, metres.
    pub(super) fn unit(&self, unit: FapUnit) -> f32 {
        self.face.points.units().distance(unit)
    }

    /// By how much a morph target moves the lips apart at weight 1, metres.
    pub(super) fn parted(&self, slot: u16) -> f32 {
        let [upper, lower] = self.lips.map(|v| self.moved(slot, v));
        (upper - lower).y
    }

    /// Adds the vertices of a mouth to a mesh, with their offsets by its morph targets.
    pub(super) fn append(&self, shape: &MouthShape, mesh: &mut Mesh) {
        let first = mesh.len() as u32;
        let skull =
            self.skull as usize * mesh.influences..(self.skull as usize + 1) * mesh.influences;
        let bindings = mesh.binding_indices[skull.clone()].to_vec();
        let weights = mesh.weights[skull].to_vec();
        let mesh_from_head = self.mesh_from_head();
        for vertex in &shape.vertices {
            mesh.positions
                .push(mesh_from_head.transform_point3(vertex.place));
            let normal = mesh_from_head.transform_vector3(vertex.normal);
            mesh.normals.push(normal.try_normalize().unwrap_or(Vec3::Z));
            mesh.texcoords.push(Vec2::ZERO);
            mesh.colors.push(vertex.color.extend(1.0));
            mesh.binding_indices.extend(&bindings);
            mesh.weights.extend(&weights);
        }
        for slot in 0..mesh.morph_weights.len() as u16 {
            let jaw = self.jaw(slot);
            let moved = shape.vertices.iter().map(|v| self.followed(slot, jaw, v));
            let moved = moved.map(|moved| mesh_from_head.transform_vector3(moved));
            mesh.morphs.extend(morph(slot, first, moved.collect()));
        }
    }

    /// Adds a morph target by which the tip (0) or the body (1) of the tongue moves; its slot, if there is room for one.
    pub(super) fn append_tongue(
        &self,
        shape: &MouthShape,
        part: usize,
        by: Vec3,
        mesh: &mut Mesh,
    ) -> Option<u16> {
        let slot = u16::try_from(mesh.morph_weights.len()).ok()?;
        let first = (mesh.len() - shape.vertices.len()) as u32;
        let by = self.mesh_from_head().transform_vector3(by);
        let moved = shape.vertices.iter().map(|v| v.tongue[part] * by);
        mesh.morphs.push(morph(slot, first, moved.collect())?);
        mesh.morph_weights.push(0.0);
        Some(slot)
    }

    /// The displacement of a vertex of the mouth by a morph target at weight 1, in the frame of the head.
    fn followed(&self, slot: u16, jaw: Option<JawMotion>, vertex: &MouthVertex) -> Vec3 {
        if let Some((points, share)) = vertex.lips {
            let [from, to] = points.map(|point| {
                let lip = self.face.points.get(point).and_then(|p| p.vertex);
                lip.map_or(Vec3::ZERO, |v| self.moved(slot, v))
            });
            return from.lerp(to, share);
        }
        jaw.map_or(Vec3::ZERO, |jaw| {
            vertex.jaw * jaw.of_place(vertex.place - self.hinge)
        })
    }

    /// The motion of the jaw by a morph target; `None` where it rests.
    fn jaw(&self, slot: u16) -> Option<JawMotion> {
        let found = CHIN.iter().filter_map(|point| {
            let vertex = self.face.points.get(*point)?.vertex?;
            Some(self.moved(slot, vertex))
        });
        let (count, sum) = found.fold((0, Vec3::ZERO), |(n, sum), m| (n + 1, sum + m));
        let moved = sum / (count as f32).max(1.0);
        let chin = self.face.points.get(CHIN[0])?.place;
        let moves = moved.length() > STILL * self.height();
        moves.then(|| JawMotion::of(chin - self.hinge, moved))
    }

    /// The displacement of a vertex of the head's surface by a morph target at weight 1, in the frame of the head.
    fn moved(&self, slot: u16, vertex: u32) -> Vec3 {
        let vertex = self.face.head.vertices[vertex as usize];
        let of_slot = self
            .figure
            .asset
            .mesh
            .morphs
            .iter()
            .filter(|m| m.slot == slot);
        let offsets = of_slot.filter_map(|m| {
            let at = m.vertices.binary_search(&vertex).ok()?;
            Some(m.positions[at])
        });
        let offset: Vec3 = offsets.sum();
        let model = self.model_from_mesh(vertex).transform_vector3(offset);
        self.head_from_model() * model
    }

    fn head_from_model(&self) -> Quat {
        self.face.head.model_from_head.inverse()
    }

    /// From the frame of the head to the space of the mesh, where the mouth is bound as the skull is.
    fn mesh_from_head(&self) -> Affine3A {
        self.model_from_mesh(self.skull).inverse()
            * Affine3A::from_quat(self.face.head.model_from_head)
    }

    /// The transform of a vertex by its joints at rest.
    fn model_from_mesh(&self, vertex: u32) -> Affine3A {
        let mesh = &self.figure.asset.mesh;
        let at = vertex as usize * mesh.influences..(vertex as usize + 1) * mesh.influences;
        let influences = mesh.binding_indices[at.clone()]
            .iter()
            .zip(&mesh.weights[at]);
        let zero = Affine3A {
            matrix3: Mat3A::ZERO,
            translation: Vec3A::ZERO,
        };
        influences.fold(zero, |sum, (binding, weight)| {
            let matrix = self.palette[usize::from(*binding)];
            Affine3A {
                matrix3: sum.matrix3 + *weight * matrix.matrix3,
                translation: sum.translation + *weight * matrix.translation,
            }
        })
    }
}

/// The morph target that moves vertices from a first one on; none if they rest.
fn morph(slot: u16, first: u32, moved: Vec<Vec3>) -> Option<Morph> {
    let moving = moved.into_iter().zip(first..);
    let (positions, vertices): (Vec<Vec3>, Vec<u32>) =
        moving.filter(|(m, _)| *m != Vec3::ZERO).unzip();
    (!vertices.is_empty()).then(|| Morph {
        slot,
        normals: vec![Vec3::ZERO; vertices.len()],
        vertices,
        positions,
    })
}
