//! A pose of the whole skin: joints, morph weights and the resulting vertices.

use crate::character::Asset;
use articula_core::{
    LocalPose, Mesh, ModelPose, PosedMesh, SkinnedMesh, Wrap, local_to_model, local_to_model_from,
    sample, sample_morphs,
};
use glam::{Affine3A, Vec3, Vec3A};

/// Origin of one pose, such as a time of a clip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PoseOrigin {
    /// The rest pose, with morph weights at rest.
    Rest,
    /// A frame of a clip.
    Clip {
        /// Index of the clip.
        clip: usize,
        /// Time in the clip, in seconds.
        secs: f64,
    },
    /// Random bends of all joints.
    Bend {
        /// Number of the random pose, from 0.
        number: usize,
    },
    /// One morph target at weight 1, the others at rest.
    Morph {
        /// Slot of the morph target.
        slot: u16,
    },
}

/// A pose that deforms the skin: local joint transforms and morph weights.
#[derive(Debug, Clone, PartialEq)]
pub struct SkinPose {
    /// Origin of the pose.
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

    /// Pose at a frame of a clip.
    ///
    /// # Panics
    /// If the clip does not exist or belongs to another rig.
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

    /// Model-space matrices of all joints, translated so that the root is at its rest position.
    ///
    /// # Panics
    /// If the pose belongs to another rig.
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

    /// Positions of all vertices in model space, with morph targets and skinning applied and the
    /// root at its rest position.
    ///
    /// # Panics
    /// If the pose belongs to another character.
    pub(crate) fn positions(&self, asset: &Asset) -> Vec<Vec3> {
        self.positions_of(asset, &asset.mesh)
    }

    /// Positions of the vertices of another mesh on the same rig, such as that of a coarser level.
    ///
    /// # Panics
    /// If the pose or the mesh belongs to another character.
    pub(crate) fn positions_of(&self, asset: &Asset, mesh: &Mesh) -> Vec<Vec3> {
        self.skinned(asset, mesh).positions
    }

    /// Skins a mesh in this pose, with morph targets; the root is at its rest position.
    ///
    /// # Panics
    /// If the pose or the mesh belongs to another character.
    pub fn skinned(&self, asset: &Asset, mesh: &Mesh) -> SkinnedMesh {
        let mut posed = PosedMesh::new(&asset.rig, mesh);
        posed.model = self.model(asset);
        posed.skinned(&self.morphs)
    }
}

/// Returns the positions of all vertices of the character's mesh in each pose.
///
/// # Panics
/// If a pose belongs to another character.
pub fn positions(asset: &Asset, poses: &[SkinPose]) -> Vec<Vec<Vec3>> {
    poses.iter().map(|p| p.positions(asset)).collect()
}
