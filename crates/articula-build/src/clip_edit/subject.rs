//! The character whose clips are edited, as all edits use it.

use super::channel;
use crate::clip::check;
use articula_core::source::evaluate::{self, Sampler};
use articula_core::source::{Character, Property, RawClip, Skeleton};
use articula_core::{Articulation, LocalPose, Mesh, Mismatch, ModelPose, Rig, local_to_model};
use glam::{Affine3A, Vec3};

/// Joints, skin and names that an edit needs to measure its effect on a character.
#[derive(Debug, Clone)]
pub struct EditSubject<'a> {
    pub(super) skeleton: &'a Skeleton,
    pub(super) rig: Rig,
    pub(super) mesh: Mesh,
    pub(super) morph_counts: Vec<usize>,
    pub(super) ends: Vec<(usize, Vec3)>,
    rest: Posed,
}

impl<'a> EditSubject<'a> {
    /// Prepares a character for clip edits; `articulation` maps its joints. `ends` are points that
    /// hang from joints besides the skin, such as the end sites of a BVH file.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the inconsistent part of the character.
    pub fn new(
        character: &'a Character,
        articulation: Articulation,
        ends: &[(usize, Vec3)],
    ) -> Result<Self, Mismatch> {
        let rig = Rig::new(&character.skeleton, articulation)?;
        if let Some((joint, _)) = ends.iter().find(|(joint, _)| *joint >= rig.len()) {
            let what = format!(
                "joint {joint} is out of range: the rig has {} joints",
                rig.len()
            );
            return Err(Mismatch::new("ends", what));
        }
        let counts = character.meshes.iter().map(|m| m.morph_weights.len());
        Ok(Self {
            skeleton: &character.skeleton,
            mesh: Mesh::new(&character.meshes, rig.len())?,
            morph_counts: counts.collect(),
            ends: ends.to_vec(),
            rest: Posed::at_rest(&rig),
            rig,
        })
    }

    /// Rejects clips that are malformed or belong to another character.
    pub(super) fn check(&self, clip: &RawClip) -> Result<(), Mismatch> {
        channel::check(clip)?;
        for (c, channel) in clip.channels.iter().enumerate() {
            if channel.property == Property::Expression {
                // Any index is accepted: a library of clips may drive expressions of the characters
                // that use it.
                continue;
            }
            check(channel, self.rig.len(), &self.morph_counts).map_err(|what| {
                Mismatch::new(format!("clip \"{}\".channels[{c}]", clip.name), what)
            })?;
        }
        Ok(())
    }

    /// The joint that carries the body: the root of the humanoid, its sacroiliac where no joint is
    /// mapped to the root, else the first joint of the skin.
    pub(super) fn hips(&self) -> usize {
        let joints = self.rig.articulation();
        let root = joints.find("humanoid_root");
        root.or_else(|| joints.find("sacroiliac"))
            .unwrap_or(self.rig.root())
    }

    /// Name of a joint.
    pub fn joint_name(&self, joint: usize) -> &str {
        self.rig.name(joint)
    }

    /// Poses every joint at a time of a clip.
    pub(super) fn pose(&self, clip: &RawClip, time_secs: f32, posed: &mut Posed) {
        evaluate::pose(clip, self.skeleton, time_secs, &mut posed.local);
        local_to_model(&self.rig, &posed.local, &mut posed.model);
    }

    /// A sampler of a clip, for [`Self::next_pose`].
    pub(super) fn sampler<'b>(&'b self, clip: &'b RawClip) -> Sampler<'b> {
        Sampler::new(clip, self.skeleton)
    }

    /// Poses every joint at a time of a clip, in less time than [`Self::pose`] where times follow each other.
    pub(super) fn next_pose(&self, sampler: &mut Sampler<'_>, time_secs: f32, posed: &mut Posed) {
        sampler.pose(time_secs, &mut posed.local);
        local_to_model(&self.rig, &posed.local, &mut posed.model);
    }

    /// As [`Self::next_pose`], but in model space only of a joint and those above it.
    pub(super) fn next_pose_above(
        &self,
        (sampler, time_secs): (&mut Sampler<'_>, f32),
        joint: usize,
        posed: &mut Posed,
    ) {
        sampler.pose(time_secs, &mut posed.local);
        let chain: Vec<usize> =
            std::iter::successors(Some(joint), |j| self.rig.parent(*j)).collect();
        let mut above = Affine3A::IDENTITY;
        for j in chain.into_iter().rev() {
            above *= posed.local.get(j).to_affine();
            posed.model.matrices[j] = above;
        }
    }

    /// Metres per unit in a joint's own space, at rest.
    pub(super) fn scale_at_rest(&self, joint: usize) -> f32 {
        let axes = self.rest.model.matrices[joint].matrix3;
        let longest = axes.x_axis.length().max(axes.y_axis.length());
        longest.max(axes.z_axis.length()).max(1e-12)
    }

    /// A pose buffer at rest.
    pub(super) fn rest(&self) -> Posed {
        self.rest.clone()
    }
}

/// A pose in local and in model space.
#[derive(Debug, Clone)]
pub(super) struct Posed {
    pub(super) local: LocalPose,
    pub(super) model: ModelPose,
}

impl Posed {
    fn at_rest(rig: &Rig) -> Self {
        let mut posed = Self {
            local: rig.rest_pose().clone(),
            model: ModelPose::new(rig.len()),
        };
        local_to_model(rig, &posed.local, &mut posed.model);
        posed
    }
}
