//! Representative poses of a character: one set to simplify its mesh by, another to measure errors
//! on.
//!
//! Source: `docs/methods/clustered-mesh.md` part 6; pose-summed quadrics after Mohr and Gleicher
//! (Deformation Sensitive Decimation, 2003) and DeCoro and Rusinkiewicz (Pose-independent
//! Simplification of Articulated Meshes, 2005). Poses are those of the character's own clips that
//! differ most in shape (farthest-point sampling, Gonzalez 1985); those to measure on are distinct
//! from those to simplify by.
//!
//! The distance of two poses is the root mean square distance of their skins, over a seeded sample
//! of vertices, after the best rigid motion. Motion of the whole character through the world
//! therefore does not count.

mod bends;
mod candidates;
mod shape;
mod skin_pose;
mod spread;

pub use skin_pose::{PoseOrigin, SkinPose, positions};

use crate::character::Asset;
use crate::joint_lods;
use articula_core::Mismatch;
use candidates::Candidates;
use shape::Sample;
use spread::Picked;

/// Distance below which two poses count as one, relative to the diagonal of the skin at rest.
const SAME_SHAPE: f32 = 0.0025;

/// Options of [`poses`]: the number of poses of each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PoseOptions {
    /// Maximum number of poses to simplify by, besides the rest pose.
    pub shaping: usize,
    /// Maximum number of further ones of single morph targets, where no clip drives any.
    pub morphs: usize,
    /// Maximum number of poses to measure on.
    pub measuring: usize,
    /// Seed of the sample of vertices and of bends.
    pub seed: u64,
}

impl Default for PoseOptions {
    /// 5 and at most 3 to simplify by, 24 to measure on.
    fn default() -> Self {
        Self {
            shaping: 5,
            morphs: 3,
            measuring: 24,
            seed: 1,
        }
    }
}

/// Kind of data that all poses of a character are selected from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SkinPoseSource {
    /// The character's clips.
    Clips,
    /// Random bends of the joints within human limits, since no clip changes the shape.
    Bends,
    /// Morph targets only: neither clips nor joints change the shape.
    Morphs,
    /// Nothing changes the shape: there is the rest pose only.
    Rest,
}

/// Selected poses of a character.
#[derive(Debug, Clone, PartialEq)]
pub struct Poses {
    /// Source of the poses.
    pub source: SkinPoseSource,
    /// Poses to simplify by: the rest pose, then those that differ most in shape.
    pub shaping: Vec<SkinPose>,
    /// Poses to measure on: spread over all clips and different from all of `shaping`.
    pub measuring: Vec<SkinPose>,
    /// Minimum shape distance between the two sets, in metres; infinite if one is empty.
    pub separation_metres: f32,
}

/// Selects poses of a character; fewer than asked for if there are not enough different ones.
///
/// Deterministic. O(sampled frames, which are limited, times sampled vertices times poses).
///
/// # Errors
/// A [`Mismatch`] if a clip, the mesh or a morph target belongs to another character.
pub fn poses(asset: &Asset, opts: &PoseOptions) -> Result<Poses, Mismatch> {
    check(asset)?;
    let mut picked = Picked::new(opts);
    let rest = SkinPose::rest(asset);
    let sample = Sample::draw(&asset.mesh, opts.seed);
    let Some(rest_shape) = sample.shape(asset, &rest) else {
        return Ok(alone(rest));
    };
    let min_metres = SAME_SHAPE * rest_shape.diagonal_metres();
    picked.known.push(rest_shape);
    picked.min_metres = min_metres;

    let mut moving = Candidates::of_clips(asset, &sample);
    let mut source = SkinPoseSource::Clips;
    if !moving.differ(min_metres) {
        moving = Candidates::of_bends(asset, &sample, opts.seed);
        source = SkinPoseSource::Bends;
    }
    let morphs = Candidates::of_morphs(asset, &sample);
    let mut shaping = picked.farthest(&moving, opts.shaping);
    if shaping.is_empty() {
        source = SkinPoseSource::Morphs;
    }
    let most = if shaping.is_empty() {
        opts.shaping.max(opts.morphs)
    } else {
        opts.morphs
    };
    shaping.extend(picked.farthest(&morphs, most));

    let all = moving.and(morphs);
    let mut measuring = picked.held_out(&all, opts.measuring);
    if measuring.is_empty() && source == SkinPoseSource::Clips {
        let bends = Candidates::of_bends(asset, &sample, opts.seed);
        measuring = picked.held_out(&bends, opts.measuring);
    }
    if shaping.is_empty() && measuring.is_empty() {
        return Ok(alone(rest));
    }
    shaping.insert(0, rest);
    Ok(Poses {
        source,
        shaping,
        measuring,
        separation_metres: picked.separation_metres,
    })
}

fn alone(rest: SkinPose) -> Poses {
    Poses {
        source: SkinPoseSource::Rest,
        shaping: vec![rest],
        measuring: Vec::new(),
        separation_metres: f32::INFINITY,
    }
}

fn check(asset: &Asset) -> Result<(), Mismatch> {
    joint_lods::check(asset)?;
    let mesh = &asset.mesh;
    let slots = mesh.morph_weights.len();
    let outside = |m: &articula_core::Morph| usize::from(m.slot) >= slots;
    if let Some(m) = mesh.morphs.iter().position(outside) {
        let what = format!(
            "slot {} is out of range: the mesh has {slots} morph slots",
            mesh.morphs[m].slot
        );
        return Err(Mismatch::new(format!("mesh.morphs[{m}]"), what));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_lods::test_figures::{arm, moving};
    use articula_core::{Clip, Morph, Track, Tracks};
    use glam::{Quat, Vec3};
    use std::sync::Arc;

    /// An arm of three joints; the middle one swings by up to `radians` in 61 frames.
    fn swinging(radians: f32) -> Asset {
        let mut asset = arm(3);
        let turn = |i: usize| Quat::from_rotation_z(radians * i as f32 / 60.0);
        asset.clips = vec![moving(3, 1, &(0..61).map(turn).collect::<Vec<_>>())];
        asset
    }

    fn secs(pose: &SkinPose) -> f64 {
        match pose.origin {
            PoseOrigin::Clip { secs, .. } => secs,
            _ => panic!("{:?}", pose.origin),
        }
    }

    /// Number of different clips among the measuring poses.
    fn clips_measured(found: &Poses) -> usize {
        let clips = found.measuring.iter().filter_map(|p| match p.origin {
            PoseOrigin::Clip { clip, .. } => Some(clip),
            _ => None,
        });
        clips.collect::<std::collections::BTreeSet<_>>().len()
    }

    #[test]
    fn the_farthest_frame_comes_first_and_then_the_middle() {
        let asset = swinging(2.0);
        let found = poses(&asset, &PoseOptions::default()).unwrap();
        assert_eq!(found.source, SkinPoseSource::Clips);
        assert_eq!(found.shaping[0].origin, PoseOrigin::Rest);
        assert_eq!(found.shaping.len(), 6);
        assert_eq!(secs(&found.shaping[1]), 2.0, "the last frame bends most");
        assert!((secs(&found.shaping[2]) - 1.0).abs() < 0.2);
        // Every second frame is another pose: as many as asked for.
        assert_eq!((found.measuring.len(), clips_measured(&found)), (24, 1));
        let used: Vec<f64> = found.shaping[1..].iter().map(secs).collect();
        assert!(found.measuring.iter().all(|p| !used.contains(&secs(p))));
        assert!(found.separation_metres > 0.0 && found.separation_metres.is_finite());
        assert_eq!(poses(&asset, &PoseOptions::default()).unwrap(), found);
    }

    #[test]
    fn every_clip_is_measured_on_before_one_is_twice() {
        let mut asset = swinging(2.0);
        for joint in [1, 2, 1, 2] {
            let turn = |i: usize| Quat::from_rotation_x(0.02 * (i + joint) as f32);
            let frames: Vec<Quat> = (0..61).map(turn).collect();
            asset.clips.push(moving(3, joint, &frames));
        }
        let opts = PoseOptions {
            measuring: 5,
            ..PoseOptions::default()
        };
        let found = poses(&asset, &opts).unwrap();
        assert_eq!((found.measuring.len(), clips_measured(&found)), (5, 5));
    }

    #[test]
    fn walking_through_the_world_changes_no_shape() {
        let mut asset = arm(3);
        let tracks = Tracks {
            translations: vec![Track {
                target: 0,
                step: false,
                values: (0..50).map(|i| Vec3::X * i as f32).collect(),
            }],
            rotations: vec![Track {
                target: 0,
                step: false,
                values: (0..50)
                    .map(|i| Quat::from_rotation_y(0.1 * i as f32))
                    .collect(),
            }],
            ..Tracks::default()
        };
        asset.clips = vec![Clip::new("walk", 30.0, 50, 3, tracks).unwrap()];
        let found = poses(&asset, &PoseOptions::default()).unwrap();
        assert_eq!(
            found.source,
            SkinPoseSource::Bends,
            "the clip bends nothing"
        );
        assert_eq!((found.shaping.len(), found.measuring.len()), (6, 24));
        let root = asset.rig.root();
        for pose in found.shaping.iter().chain(&found.measuring) {
            assert_eq!(pose.joints.get(root), asset.rig.rest_pose().get(root));
        }
        let walked = SkinPose::of_clip(&asset, 0, 30);
        assert!(walked.positions(&asset)[0].length() < 0.2, "on the spot");
    }

    #[test]
    fn a_face_without_clips_shows_its_morphs() {
        let mut asset = arm(1);
        let corner = |slot: u16, size: f32| Morph {
            slot,
            vertices: vec![u32::from(slot)],
            positions: vec![Vec3::X * size],
            normals: vec![Vec3::ZERO],
        };
        // The last one is too small to count.
        let sizes = [0.2, 0.3, 0.25, 0.1, 0.2, 0.001];
        let morphs = sizes
            .iter()
            .enumerate()
            .map(|(s, size)| corner(s as u16, *size));
        let mesh = Arc::make_mut(&mut asset.mesh);
        mesh.morphs = morphs.collect();
        mesh.morph_weights = vec![0.0; 6];
        let opts = PoseOptions {
            shaping: 3,
            ..PoseOptions::default()
        };
        let found = poses(&asset, &opts).unwrap();
        assert_eq!(found.source, SkinPoseSource::Morphs);
        let origins: Vec<PoseOrigin> = found.shaping.iter().map(|p| p.origin).collect();
        assert_eq!(origins[1], PoseOrigin::Morph { slot: 1 }, "the largest");
        assert_eq!((found.shaping.len(), found.measuring.len()), (4, 2));
        let moved = found.shaping[1].positions(&asset)[1] - asset.mesh.positions[1];
        assert!((moved - Vec3::X * 0.3).length() < 1e-6);
    }

    #[test]
    fn what_cannot_move_has_its_rest_pose() {
        let mut asset = arm(1);
        let rest = poses(&asset, &PoseOptions::default()).unwrap();
        assert_eq!(rest.source, SkinPoseSource::Rest);
        assert_eq!((rest.shaping.len(), rest.measuring.len()), (1, 0));
        asset.mesh = articula_core::Mesh::default().into();
        let empty = poses(&asset, &PoseOptions::default()).unwrap();
        assert_eq!(positions(&asset, &empty.shaping), [Vec::<Vec3>::new()]);
    }

    #[test]
    fn what_is_no_number_is_left_out_and_another_rig_refused() {
        let mut asset = swinging(1.0);
        Arc::make_mut(&mut asset.mesh).positions[0].x = f32::NAN;
        let bad = Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0);
        asset.clips.push(moving(3, 1, &[bad; 4]));
        let found = poses(&asset, &PoseOptions::default()).unwrap();
        let clips = found.shaping[1..].iter().chain(&found.measuring);
        assert!(clips.clone().all(|p| p.joints.rotations[1].is_finite()));
        Arc::make_mut(&mut asset.mesh).positions.fill(Vec3::NAN);
        let nothing = poses(&asset, &PoseOptions::default()).unwrap();
        assert_eq!(nothing.source, SkinPoseSource::Rest);
        let other = Asset {
            clips: vec![moving(4, 1, &[Quat::IDENTITY])],
            ..arm(3)
        };
        let refused = poses(&other, &PoseOptions::default()).unwrap_err();
        assert_eq!(refused.at, "clips[0]");
    }
}
