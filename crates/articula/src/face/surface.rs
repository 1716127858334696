//! The head of a figure as the surface on which its face is sought.

use crate::facing::facing_of;
use crate::figure::Figure;
use crate::head::{head_joints, head_vertices};
use articula_build::face::{FaceSurface, arkit_name};
use articula_core::LibmQuat;
use articula_core::{ModelPose, PosedMesh, local_to_model};
use glam::{Quat, Vec3};
use std::collections::BTreeMap;

/// A head at rest, without the rest of the figure.
#[derive(Debug, Clone)]
pub struct HeadSurface {
    /// Places in the frame of the head.
    pub surface: FaceSurface,
    /// Vertex of the figure's mesh for each vertex of the surface.
    pub vertices: Vec<u32>,
    /// Rotation from the frame of the head to model space; the origin is the same.
    pub model_from_head: Quat,
}

impl HeadSurface {
    /// The head of a figure in its rest pose, with all morph targets at 0; the whole mesh of a
    /// figure without a head joint.
    pub fn of(figure: &Figure) -> Self {
        let asset = &figure.asset;
        let mut rest = ModelPose::new(asset.rig.len());
        local_to_model(&asset.rig, asset.rig.rest_pose(), &mut rest);
        let articulation = asset.rig.articulation();
        let facing = facing_of(articulation, |joint| rest.position(joint));
        let model_from_head = Quat::libm_rotation_y(facing);
        let to_head = model_from_head.inverse();
        let of_head = head_vertices(figure, &head_joints(figure));
        let vertices: Vec<u32> = (0..asset.mesh.len() as u32)
            .filter(|v| of_head[*v as usize])
            .collect();
        let mut index_of = vec![u32::MAX; asset.mesh.len()];
        for (index, vertex) in vertices.iter().enumerate() {
            index_of[*vertex as usize] = index as u32;
        }
        let triangles = asset.mesh.triangles.iter();
        let triangles = triangles.map(|t| t.map(|v| index_of[v as usize]));
        let triangles = triangles.filter(|t| !t.contains(&u32::MAX)).collect();

        let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
        posed.pose(asset.rig.rest_pose());
        let mut at = |slots: &[usize]| -> Vec<Vec3> {
            let mut weights = vec![0.0; asset.mesh.morph_weights.len()];
            slots.iter().for_each(|slot| weights[*slot] = 1.0);
            let all = posed.skinned(&weights).positions;
            vertices
                .iter()
                .map(|v| to_head * all[*v as usize])
                .collect()
        };
        let positions = at(&[]);
        let shapes = slots_of_shapes(figure).into_iter().map(|(name, slots)| {
            let moved = at(&slots);
            let offsets = moved.iter().zip(&positions).map(|(a, b)| *a - *b);
            (name, offsets.collect())
        });
        let shapes = shapes.collect();
        let eye = |name: &str| Some(to_head * rest.position(articulation.find(name)?));
        let eyes = eye("l_eyeball_joint").zip(eye("r_eyeball_joint"));
        Self {
            surface: FaceSurface {
                positions,
                triangles,
                shapes,
                eyes: eyes.map(|(left, right)| [left, right]),
            },
            vertices,
            model_from_head,
        }
    }
}

/// The morph slots of each blend shape of ARKit; several meshes may have the same shape.
fn slots_of_shapes(figure: &Figure) -> BTreeMap<&'static str, Vec<usize>> {
    let meshes = &figure.opened.character().meshes;
    let mut slots: BTreeMap<&'static str, Vec<usize>> = BTreeMap::new();
    for (mesh, first) in meshes.iter().zip(&figure.asset.mesh.morph_slots) {
        for (target, name) in mesh.morph_names.iter().enumerate() {
            if let Some(name) = arkit_name(name) {
                slots.entry(name).or_default().push(first + target);
            }
        }
    }
    slots
}
