//! From a local pose to the skinned mesh of one character, with the buffers in between.
//!
//! Runs [`local_to_model`] and [`palette`], then [`skin`] or [`skin_points`]. Crowds are evaluated
//! in batches of eight characters ([`crate::batch`]), which are tested against this path.

use crate::clip::Clip;
use crate::hierarchy::{local_to_model, local_to_model_from};
use crate::mesh::Mesh;
use crate::pose::{LocalPose, ModelPose};
use crate::rig::Rig;
use crate::sample::{Wrap, sample};
use crate::skin::{SkinnedMesh, palette, skin, skin_points};
use glam::{Affine3A, Vec3};

/// A mesh that follows the poses of a rig, with the buffers for posing and skinning it.
///
/// Only [`PosedMesh::new`] and [`PosedMesh::skinned`] allocate.
///
/// ```
/// # use articula_core::{Articulation, JointArticulation, Mesh, PosedMesh, Region, Rig, SkinnedMesh};
/// # use articula_core::{Transform, source};
/// # use glam::{Quat, Vec3};
/// # let skeleton = source::Skeleton {
/// #     joints: vec![source::Joint {
/// #         name: "root".into(),
/// #         parent: None,
/// #         rest: Transform::IDENTITY,
/// #         in_skin: true,
/// #     }],
/// # };
/// # let known = JointArticulation { hanim: None, level: 0, region: Region::Pelvis };
/// # let articulation = Articulation { profile: String::new(), joints: vec![known] };
/// # let rig = Rig::new(&skeleton, articulation)?;
/// # let mesh = Mesh::new(&[], 1)?;
/// let mut posed = PosedMesh::new(&rig, &mesh);
/// let mut local = rig.rest_pose().clone();
/// local.rotations[0] = Quat::from_rotation_y(0.5);
/// let mut skinned = SkinnedMesh::new(&mesh);
/// posed.pose(&local).skin(&mesh.morph_weights, &mut skinned);
/// assert_eq!(posed.model.position(0), Vec3::ZERO);
/// # Ok::<(), articula_core::Mismatch>(())
/// ```
#[derive(Debug, Clone)]
pub struct PosedMesh<'a> {
    rig: &'a Rig,
    mesh: &'a Mesh,
    /// Model-space pose of the joints. The next skinning uses it, including changes made by the
    /// caller.
    pub model: ModelPose,
    local: LocalPose,
    palette: Vec<Affine3A>,
}

impl<'a> PosedMesh<'a> {
    /// Allocates buffers for a mesh on its rig; all joints are at the origin until a pose is set.
    pub fn new(rig: &'a Rig, mesh: &'a Mesh) -> Self {
        Self {
            model: ModelPose::new(rig.len()),
            local: rig.rest_pose().clone(),
            palette: vec![Affine3A::IDENTITY; mesh.bindings.len()],
            rig,
            mesh,
        }
    }

    /// Sets a local pose.
    ///
    /// # Panics
    /// If the pose belongs to another rig.
    pub fn pose(&mut self, local: &LocalPose) -> &mut Self {
        local_to_model(self.rig, local, &mut self.model);
        self
    }

    /// Sets a local pose below a transform of the whole character, such as its position in the
    /// world.
    ///
    /// # Panics
    /// If the pose belongs to another rig.
    pub fn pose_from(&mut self, local: &LocalPose, world_from_model: Affine3A) -> &mut Self {
        local_to_model_from(self.rig, local, world_from_model, &mut self.model);
        self
    }

    /// Sets the pose of a clip at a time; joints without a track are in the rest pose.
    ///
    /// # Panics
    /// If the clip belongs to another rig.
    pub fn pose_at(&mut self, clip: &Clip, time_secs: f64, wrap: Wrap) -> &mut Self {
        self.local.copy_from(self.rig.rest_pose());
        sample(clip, time_secs, wrap, &self.rig.all(), &mut self.local);
        local_to_model(self.rig, &self.local, &mut self.model);
        self
    }

    /// Skins positions and normals of all vertices after morph targets.
    ///
    /// # Panics
    /// If the weights or the output belong to another mesh.
    pub fn skin(&mut self, morph_weights: &[f32], out: &mut SkinnedMesh) {
        palette(self.mesh, &self.model, &mut self.palette);
        skin(self.mesh, &self.palette, morph_weights, out);
    }

    /// Skins into new buffers; see [`PosedMesh::skin`].
    ///
    /// # Panics
    /// If the weights belong to another mesh.
    pub fn skinned(&mut self, morph_weights: &[f32]) -> SkinnedMesh {
        let mut out = SkinnedMesh::new(self.mesh);
        self.skin(morph_weights, &mut out);
        out
    }

    /// Skins the positions of the given vertices without morph targets, into `out` in the order of
    /// `vertices`.
    ///
    /// # Panics
    /// If `out` and `vertices` differ in length, or a vertex is out of range.
    pub fn points(&mut self, vertices: &[u32], out: &mut [Vec3]) {
        palette(self.mesh, &self.model, &mut self.palette);
        skin_points(self.mesh, &self.palette, vertices, out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::{Track, Tracks};
    use crate::mesh::tests::triangle;
    use crate::rig::tests::rig_of;
    use glam::Quat;

    #[test]
    fn is_the_row_of_its_steps_bit_for_bit() {
        let rig = rig_of(&[(None, Vec3::ZERO, 0), (Some(0), Vec3::Y, 0)]);
        let mesh = Mesh::new(&[triangle()], 2).unwrap();
        let tracks = Tracks {
            rotations: vec![Track {
                target: 1,
                step: false,
                values: (0..3).map(|i| Quat::from_rotation_x(i as f32)).collect(),
            }],
            ..Tracks::default()
        };
        let clip = Clip::new("turn", 1.0, 3, 2, tracks).unwrap();
        let mut local = rig.rest_pose().clone();
        sample(&clip, 0.7, Wrap::Clamp, &rig.all(), &mut local);
        let mut model = ModelPose::new(2);
        local_to_model(&rig, &local, &mut model);
        let mut matrices = vec![Affine3A::IDENTITY; mesh.bindings.len()];
        palette(&mesh, &model, &mut matrices);
        let mut expected = SkinnedMesh::new(&mesh);
        skin(&mesh, &matrices, &[0.5], &mut expected);

        let mut posed = PosedMesh::new(&rig, &mesh);
        // The earlier pose has no effect on the later one.
        let counted = allocation_counter::measure(|| {
            posed.pose_at(&clip, 2.0, Wrap::Clamp);
            posed.pose_at(&clip, 0.7, Wrap::Clamp);
        });
        assert_eq!(counted.count_total, 0);
        assert_eq!(posed.model, model);
        assert_eq!(posed.skinned(&[0.5]), expected);
        assert_eq!(posed.pose(&local).skinned(&[0.5]), expected);
        let (mut points, mut plain) = ([Vec3::ZERO; 2], [Vec3::ZERO; 2]);
        posed.points(&[2, 0], &mut points);
        skin_points(&mesh, &matrices, &[2, 0], &mut plain);
        assert_eq!(points, plain);
        let still = Affine3A::from_translation(Vec3::X);
        assert_eq!(posed.pose_from(&local, still).model.position(0), Vec3::X);
    }
}
