//! Joint levels of detail: the order in which joints are merged, the skins of the levels, and their
//! errors.
//!
//! A level keeps a prefix of a joint order that is derived from the character's own motion. A
//! merged joint stays in the mean pose of the rig relative to its nearest kept ancestor and gives
//! it its skin weights, so a coarser level computes fewer matrices and is otherwise the same.
//!
//! Source: `docs/methods/motion-lod.md` part 8, `docs/methods/runtime.md` 4.1; thesis 5.1 (levels of
//! articulation, multi-resolution bodies).
//!
//! [`merged_levels`] does all of it. Its steps are available separately:
//!
//! - [`mean_pose`]: the pose in which merged joints are shown
//! - [`joint_lods`]: the greedy joint order and the levels chosen from it
//! - [`named_joint_lods`]: levels given by expressions, such as `loa(Medium)`
//! - [`far_order`], [`far_levels`]: coarse levels that keep hands and heads, on a separate rig
//! - [`level_skins`]: the skins of all levels, on one palette
//! - [`lod_errors`]: error of each level in each clip
//! - [`skin_of`]: the points at which errors are measured, also without a mesh

mod blocks;
mod choose;
mod errors;
mod far;
mod fold;
mod mean_pose;
mod measure;
mod moments;
mod order;
mod plan;
mod prefixes;
mod skins;
#[cfg(test)]
pub(crate) mod test_figures;
mod watch;

pub(crate) use blocks::{BlockComparison, BlockPoser, Tally, distances_squared};
pub use errors::lod_errors;
pub(crate) use errors::{MAX_FRAMES, rising};
pub use far::{FarLevels, far_levels};
pub use mean_pose::mean_pose;
pub(crate) use mean_pose::principal;
pub(crate) use moments::{models_of, share_frames, spread_frames};
pub use skins::level_skins;
pub(crate) use skins::skin_part;
pub(crate) use watch::Watched;
pub use watch::skin_of;

use crate::character::Asset;
use articula_core::loa::LoaExpression;
use articula_core::{JointLods, JointSet, LevelSkins, LocalPose, LodErrors, Mismatch};
use choose::Choice;
use order::Folds;

/// Options of [`merged_levels`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLodOptions {
    /// Joints that every level keeps, such as those that carry attachments; their ancestors are
    /// kept too.
    pub protected: JointSet,
    /// Maximum number of levels, including the full character; at most [`JointLods::MAX_LEVELS`].
    pub max_levels: usize,
    /// Minimum number of joints of the coarsest level.
    pub min_joints: usize,
    /// Maximum error of the first coarser level, in metres; each further level is allowed twice the
    /// error of the one before.
    pub first_metres: f32,
    /// Error in metres from which levels may drop ancestors of kept joints; such far levels use a
    /// separate rig. Infinite for no far levels.
    pub far_from_metres: f32,
    /// Number of vertices in the random sample that errors are measured on.
    pub vertices: usize,
    /// Number of frames, over all clips, that the joint order is computed from.
    pub frames: usize,
    /// Seed of the random sample of vertices.
    pub seed: u64,
}

impl Default for JointLodOptions {
    /// At most 8 levels starting at 0.5 mm, at least 8 joints, no far levels; 700 vertices, 256
    /// frames.
    fn default() -> Self {
        Self {
            protected: JointSet::EMPTY,
            max_levels: 8,
            min_joints: 8,
            first_metres: 0.5e-3,
            far_from_metres: f32::INFINITY,
            vertices: 700,
            frames: 256,
            seed: 1,
        }
    }
}

/// Joint LODs of a character with the skins and errors of all levels.
#[derive(Debug, Clone, PartialEq)]
pub struct MergedLevels {
    /// Joint order, levels and mean pose.
    pub joint_lods: JointLods,
    /// Skins of these levels and their palette.
    pub skins: LevelSkins,
    /// Levels coarser than those of `joint_lods`, on a separate rig.
    pub far: Option<FarLevels>,
    /// Error of each level in each clip: those of `joint_lods` first, then the far ones.
    pub errors: LodErrors,
}

/// Computes the joint LODs of a character: joint order, levels, skins and errors.
///
/// # Errors
/// A [`Mismatch`] if a clip or the mesh belongs to another rig.
pub fn merged_levels(asset: &Asset, opts: &JointLodOptions) -> Result<MergedLevels, Mismatch> {
    check(asset)?;
    let mean = mean_pose(asset);
    if opts.far_from_metres == f32::INFINITY {
        return levels_of(asset, joint_lods(asset, &mean, opts)?, opts);
    }
    let near = order::order(asset, &mean, Folds::Leaves, opts);
    let far = order::order(asset, &mean, Folds::Any, &far_options(asset, opts));
    let skin = skin_of(asset);
    let never = order::never_merged(asset, &skin, &opts.protected);
    let far_never = order::skinned_roots(asset, &skin).union(&far_options(asset, opts).protected);
    let [near_choice, far_choice] =
        [(&near, never), (&far, far_never)].map(|(order, never)| Choice {
            order,
            floor: never.len(),
        });
    let kept = choose::levels(&near_choice, Some(&far_choice), &capped(opts));
    let found = match &kept.far[..] {
        [] => None,
        counts => far_levels(asset, &far.joints, counts, &mean, opts)?,
    };
    let Some((far, far_errors)) = found else {
        return levels_of(asset, joint_lods(asset, &mean, opts)?, opts);
    };
    let joint_lods = JointLods::new(&asset.rig, near.joints, kept.near, &mean)?;
    let near = levels_of(asset, joint_lods, opts)?;
    Ok(MergedLevels {
        errors: errors::joined(near.errors, &far_errors),
        far: Some(far),
        ..near
    })
}

/// Returns the joint order of [far levels](FarLevels), which may drop ancestors of kept joints.
///
/// # Errors
/// A [`Mismatch`] if a clip or the mesh belongs to another rig.
pub fn far_order(
    asset: &Asset,
    mean: &LocalPose,
    opts: &JointLodOptions,
) -> Result<Vec<u16>, Mismatch> {
    check(asset)?;
    let opts = far_options(asset, opts);
    Ok(order::order(asset, mean, Folds::Any, &opts).joints)
}

/// Options of far levels: the joint that carries root motion is protected as well.
fn far_options(asset: &Asset, opts: &JointLodOptions) -> JointLodOptions {
    let mut protected = opts.protected.intersection(&asset.rig.all());
    protected.insert(asset.rig.root());
    JointLodOptions { protected, ..*opts }
}

fn capped(opts: &JointLodOptions) -> JointLodOptions {
    JointLodOptions {
        max_levels: opts.max_levels.min(JointLods::MAX_LEVELS),
        ..*opts
    }
}

/// Computes the skins and errors of existing joint LODs, such as those of named levels.
///
/// # Errors
/// A [`Mismatch`] if a clip, the mesh or the joint LODs belong to another rig.
pub fn levels_of(
    asset: &Asset,
    joint_lods: JointLods,
    opts: &JointLodOptions,
) -> Result<MergedLevels, Mismatch> {
    let skins = level_skins(asset, &joint_lods, opts)?;
    let errors = lod_errors(asset, &joint_lods, &skins, opts)?;
    Ok(MergedLevels {
        joint_lods,
        skins,
        far: None,
        errors,
    })
}

/// Orders the joints of a character by the error of merging each, and selects levels.
///
/// # Errors
/// A [`Mismatch`] if a clip or the mesh belongs to another rig.
pub fn joint_lods(
    asset: &Asset,
    mean: &LocalPose,
    opts: &JointLodOptions,
) -> Result<JointLods, Mismatch> {
    check(asset)?;
    let order = order::order(asset, mean, Folds::Leaves, opts);
    let never = order::never_merged(asset, &skin_of(asset), &opts.protected);
    let choice = Choice {
        order: &order,
        floor: never.len(),
    };
    let kept = choose::levels(&choice, None, &capped(opts)).near;
    JointLods::new(&asset.rig, order.joints, kept, mean)
}

/// Returns joint LODs from expressions, finest first, such as `loa(High)`, `loa(Low)`.
///
/// The full character is added as level 0. Roots with skin are kept at all levels.
///
/// # Errors
/// A [`Mismatch`] if an expression names an unknown joint or keeps a joint that the expression
/// before it has merged.
pub fn named_joint_lods(
    asset: &Asset,
    mean: &LocalPose,
    levels: &[LoaExpression],
) -> Result<JointLods, Mismatch> {
    check(asset)?;
    let never = order::never_merged(asset, &asset.mesh, &JointSet::EMPTY);
    let mut sets = Vec::with_capacity(levels.len());
    for (e, expression) in levels.iter().enumerate() {
        let set = expression
            .joints(&asset.rig)
            .map_err(|unknown| Mismatch::new(format!("levels[{e}]"), unknown.to_string()))?;
        sets.push(set.union(&never));
    }
    JointLods::of_sets(&asset.rig, &sets, mean)
}

/// Checks that clips and mesh belong to the rig.
pub(crate) fn check(asset: &Asset) -> Result<(), Mismatch> {
    let joints = asset.rig.len();
    if let Some(c) = asset.clips.iter().position(|c| c.joints() != joints) {
        let what = format!("{} joints, the rig has {joints}", asset.clips[c].joints());
        return Err(Mismatch::new(format!("clips[{c}]"), what));
    }
    let mut bindings = asset.mesh.bindings.iter();
    if let Some(b) = bindings.position(|b| usize::from(b.joint) >= joints) {
        let what = format!(
            "joint {} is out of range: the rig has {joints} joints",
            asset.mesh.bindings[b].joint
        );
        return Err(Mismatch::new(format!("mesh.bindings[{b}].joint"), what));
    }
    Ok(())
}

/// Checks that joint LODs belong to the rig.
pub(crate) fn check_tolerances(asset: &Asset, joint_lods: &JointLods) -> Result<(), Mismatch> {
    let parent = |j: usize| asset.rig.parent(j).map(|p| joint_lods.place(p));
    let stored = |j: usize| joint_lods.parents()[joint_lods.place(j)].map(usize::from);
    let joints = asset.rig.len();
    if joint_lods.joints().len() != joints || (0..joints).any(|j| parent(j) != stored(j)) {
        let what = format!(
            "the {} joints do not match the hierarchy of the rig",
            joint_lods.joints().len()
        );
        return Err(Mismatch::new("joint_lods", what));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::test_figures::{arm, figure, moving};
    use super::*;
    use articula_core::Mesh;
    use glam::Quat;
    use std::sync::Arc;

    #[test]
    fn clips_and_bindings_of_other_rigs_are_refused() {
        let mut asset = arm(3);
        assert_eq!(check(&asset), Ok(()));
        asset.clips = vec![
            moving(3, 1, &[Quat::IDENTITY]),
            moving(2, 1, &[Quat::IDENTITY]),
        ];
        assert_eq!(check(&asset).unwrap_err().at, "clips[1]");
        asset.clips.pop();
        Arc::make_mut(&mut asset.mesh).bindings[2].joint = 3;
        assert_eq!(check(&asset).unwrap_err().at, "mesh.bindings[2].joint");
    }

    #[test]
    fn joint_lods_of_other_rigs_are_refused() {
        let of = |asset: &Asset| {
            let order = (0..asset.rig.len() as u16).collect();
            let kept = vec![asset.rig.len() as u16];
            JointLods::new(&asset.rig, order, kept, &mean_pose(asset)).unwrap()
        };
        let (chain, star) = (arm(3), figure(&[None, Some(0), Some(0)]));
        assert_eq!(check_tolerances(&chain, &of(&chain)), Ok(()));
        assert!(check_tolerances(&chain, &of(&arm(2))).is_err());
        assert!(check_tolerances(&chain, &of(&star)).is_err());
    }

    #[test]
    fn far_levels_keep_the_root_and_protected_joints_longest() {
        let mut asset = figure(&[None, Some(0), Some(1), Some(0)]);
        let turn = |angle: f32| Quat::from_rotation_z(angle);
        asset.clips = vec![moving(4, 3, &[turn(-0.5), turn(0.5)])];
        let mean = mean_pose(&asset);
        let order = |protected: &[usize]| {
            let opts = JointLodOptions {
                protected: protected.iter().copied().collect(),
                ..JointLodOptions::default()
            };
            far_order(&asset, &mean, &opts).unwrap()
        };
        assert_eq!(order(&[])[..2], [0, 3]);
        let mut first = order(&[2, 900])[..2].to_vec();
        first.sort_unstable();
        assert_eq!(first, [0, 2]);
        // A root without skin moves no vertex, and stays nevertheless.
        let mut bare = arm(3);
        for index in &mut Arc::make_mut(&mut bare.mesh).binding_indices {
            *index = (*index).max(1);
        }
        bare.clips = vec![moving(3, 1, &[turn(-0.5), turn(0.5)])];
        let order = far_order(&bare, &mean_pose(&bare), &JointLodOptions::default());
        assert_eq!(order.unwrap()[0], 0);
    }

    #[test]
    fn no_more_levels_are_made_than_can_be_stored() {
        let levels = |max_levels| {
            let opts = JointLodOptions {
                max_levels,
                ..JointLodOptions::default()
            };
            capped(&opts).max_levels
        };
        assert_eq!(levels(usize::MAX), JointLods::MAX_LEVELS);
        assert_eq!(levels(3), 3);
    }

    #[test]
    fn without_a_mesh_bones_tell_the_error() {
        let mut asset = arm(2);
        asset.mesh = Mesh::default().into();
        let turns = [-0.2, 0.0, 0.2].map(Quat::from_rotation_z);
        asset.clips = vec![moving(2, 1, &turns)];
        let mean = mean_pose(&asset);
        let joint_lods = JointLods::new(&asset.rig, vec![0, 1], vec![2, 1], &mean).unwrap();
        let found = levels_of(&asset, joint_lods, &JointLodOptions::default()).unwrap();
        // The bone beyond the upper joint ends half a metre from it, and stays at the mean.
        let chord = 2.0 * 0.1f32.sin() * 0.5;
        let errors = &found.errors.clips[0].worst_metres;
        assert_eq!(errors[0], 0.0);
        assert!((errors[1] - chord).abs() < 1e-5, "{errors:?}");
    }
}
