//! One pose of the whole skin: joints and morph weights, and the vertices under them.

use crate::character::Asset;
use articula_core::{
    LocalPose, Mesh, ModelPose, PosedMesh, SkinnedMesh, Wrap, local_to_model, local_to_model_from,
    sample, sample_morphs,
};
use glam::{Affine3A, Vec3, Vec3A};

/// Where a pose comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PoseOrigin {
    /// The rest pose, morph weights at rest.
    Rest,
    /// A frame of a clip.
    Clip {
        /// Index of the clip.
        clip: usize,
        /// Time in it.
        secs: f64,
    },
    /// Random bends of all joints.
    Bend {
        /// Which of them.
        number: usize,
    },
    /// One morph target at weight 1, the others at rest.
    Morph {
        /// Its slot.
        slot: u16,
    },
}

/// Joints and morph weights of one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct SkinPose {
    /// Where it comes from.
    pub origin: PoseOrigin,
    /// Local transforms of all joints.
    pub joints: LocalPose,
    /// Weight of each morph slot.
    pub morphs: Vec<f32>,
}

impl SkinPose {
    /// The rest pose.
    pub(crate) fn rest(asset: &Asset) -> Self {
        Self {
            origin: PoseOrigin::Rest,
            joints: asset.rig.rest_pose().clone(),
            morphs: asset.mesh.morph_weights.clone(),
        }
    }

    /// A frame of a clip.
    ///
    /// # Panics
    /// If there is no such clip, or it is of another rig.
    pub(crate) fn of_clip(asset: &Asset, clip: usize, frame: usize) -> Self {
        let motion = &asset.clips[clip];
        let secs = frame as f64 / f64::from(motion.rate_hz());
        let mut pose = Self::rest(asset);
        let all = asset.rig.all();
        sample(motion, secs, Wrap::Clamp, &all, &mut pose.joints);
        sample_morphs(motion, secs, Wrap::Clamp, &mut pose.morphs);
        pose.origin = PoseOrigin::Clip { clip, secs };
        pose
    }

    /// Model-space matrices of all joints, the character carried back so that its root stands
    /// where it does at rest.
    ///
    /// # Panics
    /// If the pose is of another rig.
    pub(crate) fn model(&self, asset: &Asset) -> ModelPose {
        let rig = &asset.rig;
        let mut model = ModelPose::new(rig.len());
        local_to_model(rig, rig.rest_pose(), &mut model);
        let rest = model.matrices[rig.root()].translation;
        local_to_model(rig, &self.joints, &mut model);
        let back: Vec3A = rest - model.matrices[rig.root()].translation;
        if back != Vec3A::ZERO && back.is_finite() {
            let back = Affine3A::from_translation(back.into());
            local_to_model_from(rig, &self.joints, back, &mut model);
        }
        model
    }

    /// All vertices of the character's mesh in this pose, morph targets and skin applied; in
    /// model space, the root where it stands at rest.
    ///
    /// # Panics
    /// If the pose is of another character.
    pub(crate) fn positions(&self, asset: &Asset) -> Vec<Vec3> {
        self.positions_of(asset, &asset.mesh)
    }

    /// The same for another mesh on the same rig, such as that of a coarser level.
    ///
    /// # Panics
    /// If the pose or the mesh is of another character.
    pub(crate) fn positions_of(&self, asset: &Asset, mesh: &Mesh) -> Vec<Vec3> {
        self.skinned(asset, mesh).positions
    }

    /// The same with the normals.
    ///
    /// # Panics
    /// If the pose or the mesh is of another character.
    pub fn skinned(&self, asset: &Asset, mesh: &Mesh) -> SkinnedMesh {
        let mut posed = PosedMesh::new(&asset.rig, mesh);
        posed.model = self.model(asset);
        posed.skinned(&self.morphs)
    }
}

/// All vertices of the character's mesh in each pose.
///
/// # Panics
/// If a pose is of another character.
pub fn positions(asset: &Asset, poses: &[SkinPose]) -> Vec<Vec<Vec3>> {
    poses.iter().map(|p| p.positions(asset)).collect()
}
