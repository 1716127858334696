//! Far levels: coarse levels on a separate rig that contains their few joints only.
//!
//! Source: `docs/methods/motion-lod.md` part 8, `docs/methods/runtime.md` 4.1. Where ancestors may
//! be dropped, a hand or a head can outlast the joints between it and the hips: at 16 joints the
//! error is one fifth of that of a near level. The kept joints form a tree in which each is a child
//! of its nearest ancestor that outlasts it, and their clips are computed from the full rig. They
//! are exact at the frames of a clip; between frames a joint moves on a chord relative to its
//! parent, which in a fast motion may be centimetres off. Such clips get more frames, and the
//! remaining distance is added to the error.

use super::errors::{add, table};
use super::moments::pose_at;
use super::prefixes::Prefixes;
use super::skins::{no_skins, placed_skins};
use super::watch::skin_of;
use super::{JointLodOptions, check};
use crate::character::Asset;
use articula_core::source::{Joint, Skeleton};
use articula_core::{
    Articulation, Binding, Clip, JointLods, JointSet, LevelSkins, LocalPose, LodErrors, Mismatch,
    ModelPose, Rig, Track, Tracks, Transform, Wrap, angle_between, local_to_model, same_hemisphere,
    sample,
};
use glam::{Affine3A, Quat, Vec3};

/// Differences below these are rounding, not motion: metres and radians, then ratio of a scale.
const STILL: f32 = 1e-5;
const STILL_SCALE: f32 = 1e-4;

/// Maximum distance of a joint from its true trajectory between frames, in metres, above which a
/// clip gets more frames; and the maximum number of frames per frame of the source.
const MAX_CHORD_METRES: f32 = 2e-3;
const MAX_FRAMES_FOR_ONE: usize = 4;

/// Maximum difference, relative to the scale, between a product of transforms and its form without
/// shear.
const MAX_SHEAR: f32 = 1e-2;

/// Coarse levels on a separate rig of few joints, for distant characters, with rig and clips.
#[derive(Debug, Clone, PartialEq)]
pub struct FarLevels {
    /// Joints that the finest far level keeps, in the joint order of the far levels.
    pub rig: Rig,
    /// Joint of the full rig for each joint of this one.
    pub joints: Vec<u16>,
    /// The clips of the character for this rig, with unchanged duration; fast clips have two or
    /// four times the frames.
    pub clips: Vec<Clip>,
    /// Joint order and levels of this rig; level 0 is the finest far level.
    pub joint_lods: JointLods,
    /// Skins of these levels; bindings refer to joints of this rig.
    pub skins: LevelSkins,
}

/// Builds the [far levels](FarLevels) of a character: rig, clips and skins, with measured errors.
///
/// `order` lists all joints of the full rig, and level `l` keeps the first `kept[l]` of them. The
/// errors start with 0 for the full character. Returns `None` if a chain of scaled joints shears,
/// since no single joint can represent that.
///
/// # Errors
/// A [`Mismatch`] if `order` is not a permutation of the rig's joints, `kept` does not fall
/// strictly from at most all of them to at least one, or a clip, the mesh or the mean pose belongs
/// to another rig.
pub fn far_levels(
    asset: &Asset,
    order: &[u16],
    kept: &[u16],
    mean: &LocalPose,
    opts: &JointLodOptions,
) -> Result<Option<(FarLevels, LodErrors)>, Mismatch> {
    check(asset)?;
    check_order(&asset.rig, order, kept, mean)?;
    let prefixes = Prefixes::new(&asset.rig, order, kept, mean);
    let joints = order[..usize::from(kept[0])].to_vec();
    let chains: Vec<Chain> = joints
        .iter()
        .map(|j| Chain::of(asset, &prefixes, *j))
        .collect();
    let composed =
        |pose: &LocalPose| -> Option<LocalPose> { chains.iter().map(|c| c.local(pose)).collect() };
    let (Some(rest), Some(far_mean)) = (composed(asset.rig.rest_pose()), composed(mean)) else {
        return Ok(None);
    };
    let rig = rig_of(asset, &prefixes, &joints, &rest)?;
    let mut clips = Vec::with_capacity(asset.clips.len());
    let mut chords_metres = Vec::with_capacity(asset.clips.len());
    for clip in &asset.clips {
        let Some((far, chord)) = clip_for(asset, clip, &rig, &chains)? else {
            return Ok(None);
        };
        clips.push(far);
        chords_metres.push(chord);
    }
    let places = (0..joints.len() as u16).collect();
    let joint_lods = JointLods::new(&rig, places, kept.to_vec(), &far_mean)?;
    let skin = skin_of(asset);
    let placed = placed_skins(asset, &skin, &prefixes, opts)?;
    let skins = if asset.mesh.is_empty() {
        no_skins(&joint_lods)?
    } else {
        placed.on(&joint_lods, |binding, joint| Binding { joint, ..binding })?
    };
    let levels = FarLevels {
        rig,
        joints,
        clips,
        joint_lods,
        skins,
    };
    let mut errors = table(asset, &skin, &placed.levels, &placed.bindings, opts)?;
    add(&mut errors, &chords_metres);
    Ok(Some((levels, errors)))
}

/// Checks that an order lists every joint once, and that the counts fall.
fn check_order(rig: &Rig, order: &[u16], kept: &[u16], mean: &LocalPose) -> Result<(), Mismatch> {
    let inside = order.iter().filter(|j| usize::from(**j) < rig.len());
    let named: JointSet = inside.map(|j| usize::from(*j)).collect();
    if order.len() != rig.len() || named.len() != rig.len() {
        let what = format!("lists {} joints, the rig has {}", named.len(), rig.len());
        return Err(Mismatch::new("order", what));
    }
    let falls = kept.windows(2).all(|w| w[0] > w[1]) && kept.last().is_some_and(|n| *n > 0);
    if !falls || usize::from(kept[0]) > rig.len() {
        let what = format!(
            "{kept:?} must begin at most at {}, fall strictly and stay at least 1",
            rig.len()
        );
        return Err(Mismatch::new("kept", what));
    }
    if mean.rotations.len() != rig.len() {
        let what = format!("{} joints, the rig has {}", mean.rotations.len(), rig.len());
        return Err(Mismatch::new("mean", what));
    }
    Ok(())
}

/// Joints of the full rig from below the far parent of a far joint down to that joint.
struct Chain {
    links: Vec<usize>,
}

impl Chain {
    fn of(asset: &Asset, prefixes: &Prefixes<'_>, joint: u16) -> Self {
        let top = prefixes.far_parent(usize::from(joint));
        let mut links = vec![usize::from(joint)];
        let mut at = asset.rig.parent(usize::from(joint));
        while let Some(j) = at.filter(|j| Some(*j) != top) {
            links.push(j);
            at = asset.rig.parent(j);
        }
        links.reverse();
        Self { links }
    }

    /// Product of the local transforms; `None` if it shears.
    fn local(&self, pose: &LocalPose) -> Option<Transform> {
        if let [joint] = self.links[..] {
            return Some(pose.get(joint));
        }
        let product = self
            .links
            .iter()
            .fold(Affine3A::IDENTITY, |m, j| m * pose.get(*j).to_affine());
        let (mut scale, rotation, translation) = product.to_scale_rotation_translation();
        if (scale - Vec3::ONE).abs().max_element() < STILL_SCALE {
            scale = Vec3::ONE;
        }
        let split = Transform {
            translation,
            rotation: rotation.normalize(),
            scale,
        };
        let apart = (split.to_affine().matrix3 - product.matrix3).to_cols_array();
        let apart = apart.iter().fold(0.0f32, |a, x| a.max(x.abs()));
        (split.is_finite() && apart <= MAX_SHEAR * scale.abs().max_element()).then_some(split)
    }
}

/// Local transforms of the far joints for a pose of the full rig.
fn composed(chains: &[Chain], pose: &LocalPose) -> Option<LocalPose> {
    chains.iter().map(|c| c.local(pose)).collect()
}

/// Returns the clip for the far rig, with more frames where joints are fast, and its remaining
/// distance from the true motion in metres; `None` if a chain shears.
fn clip_for(
    asset: &Asset,
    clip: &Clip,
    rig: &Rig,
    chains: &[Chain],
) -> Result<Option<(Clip, f32)>, Mismatch> {
    let mut each = 1;
    loop {
        let rate = f64::from(clip.rate_hz()) * each as f64;
        let frames = (clip.frames() - 1) * each + 1;
        let pose = |at: f64| composed(chains, &pose_at(asset, clip, at / rate));
        let poses = (0..frames).map(|f| pose(f as f64));
        let Some(poses) = poses.collect::<Option<Vec<LocalPose>>>() else {
            return Ok(None);
        };
        let far = clip_of(clip, each, chains, rig.rest_pose(), &poses)?;
        let mut chord = 0.0f32;
        let (mut truth, mut shown) = (ModelPose::new(rig.len()), ModelPose::new(rig.len()));
        for f in 1..frames {
            let at = f as f64 - 0.5;
            let Some(pose) = pose(at) else {
                return Ok(None);
            };
            local_to_model(rig, &pose, &mut truth);
            let mut pose = rig.rest_pose().clone();
            sample(&far, at / rate, Wrap::Clamp, &rig.all(), &mut pose);
            local_to_model(rig, &pose, &mut shown);
            let apart = (0..rig.len()).map(|j| truth.position(j).distance(shown.position(j)));
            chord = apart.fold(chord, f32::max);
        }
        if chord <= MAX_CHORD_METRES || each >= MAX_FRAMES_FOR_ONE {
            return Ok(Some((far, chord)));
        }
        each *= 2;
    }
}

fn rig_of(
    asset: &Asset,
    prefixes: &Prefixes<'_>,
    joints: &[u16],
    rest: &LocalPose,
) -> Result<Rig, Mismatch> {
    let joint = |(place, &joint): (usize, &u16)| {
        let joint = usize::from(joint);
        Joint {
            name: asset.rig.name(joint).to_owned(),
            parent: prefixes.far_parent(joint).map(|p| prefixes.place(p)),
            rest: rest.get(place),
            in_skin: asset.rig.skin_joints().contains(joint),
        }
    };
    let skeleton = Skeleton {
        joints: joints.iter().enumerate().map(joint).collect(),
    };
    let articulation = asset.rig.articulation();
    let entry = |j: &u16| articulation.joints[usize::from(*j)].clone();
    let articulation = Articulation {
        profile: articulation.profile.clone(),
        joints: joints.iter().map(entry).collect(),
    };
    Rig::new(&skeleton, articulation)
}

fn clip_of(
    clip: &Clip,
    each: usize,
    chains: &[Chain],
    rest: &LocalPose,
    poses: &[LocalPose],
) -> Result<Clip, Mismatch> {
    let mut tracks = Tracks {
        morphs: clip
            .tracks()
            .morphs
            .iter()
            .map(|t| more_frames(t, each))
            .collect(),
        ..Tracks::default()
    };
    for (place, chain) in chains.iter().enumerate() {
        let target = place as u16;
        let steps = |held: &dyn Fn(usize) -> bool| chain.links.iter().any(|j| held(*j));
        let vectors = |all: &dyn Fn(&LocalPose) -> Vec3, within: f32, step: bool| {
            let values: Vec<Vec3> = poses.iter().map(all).collect();
            track(target, step, all(rest), values, |a, b| {
                (*a - *b).abs().max_element() <= within
            })
        };
        let step = steps(&|j| holds(&clip.tracks().translations, j));
        let translation = vectors(&|p| p.translations[place], STILL, step);
        tracks.translations.extend(translation);
        let step = steps(&|j| holds(&clip.tracks().scales, j));
        let scale = vectors(&|p| p.scales[place], STILL_SCALE, step);
        tracks.scales.extend(scale);
        let mut rotations: Vec<Quat> = Vec::with_capacity(poses.len());
        for pose in poses {
            let q = pose.rotations[place];
            rotations.push(rotations.last().map_or(q, |last| same_hemisphere(*last, q)));
        }
        let step = steps(&|j| holds(&clip.tracks().rotations, j));
        tracks.rotations.extend(track(
            target,
            step,
            rest.rotations[place],
            rotations,
            |a, b| angle_between(*a, *b) <= STILL,
        ));
    }
    Clip::new(
        &clip.name,
        clip.rate_hz() * each as f32,
        poses.len(),
        chains.len(),
        tracks,
    )
}

fn holds<T>(tracks: &[Track<T>], joint: usize) -> bool {
    tracks
        .iter()
        .any(|t| usize::from(t.target) == joint && t.step)
}

/// A track with all values, with one if they are constant, or `None` if they equal the rest pose.
fn track<T: Copy>(
    target: u16,
    step: bool,
    rest: T,
    mut values: Vec<T>,
    same: impl Fn(&T, &T) -> bool,
) -> Option<Track<T>> {
    let first = values[0];
    if values.iter().all(|v| same(v, &first)) {
        if same(&first, &rest) {
            return None;
        }
        values.truncate(1);
    }
    Some(Track {
        target,
        step,
        values,
    })
}

/// Resamples a track of morph weights to `each` times the frames.
fn more_frames(track: &Track<f32>, each: usize) -> Track<f32> {
    if each == 1 || track.values.len() == 1 {
        return track.clone();
    }
    let last = track.values.len() - 1;
    let value = |i: usize| {
        let (at, part) = (i / each, (i % each) as f32 / each as f32);
        let (a, b) = (track.values[at], track.values[(at + 1).min(last)]);
        if track.step { a } else { a + (b - a) * part }
    };
    Track {
        values: (0..=last * each).map(value).collect(),
        ..*track
    }
}

#[cfg(test)]
mod tests {
    use super::super::mean_pose::mean_pose;
    use super::super::test_figures::{arm, moving};
    use super::*;

    /// An arm of three joints with a swinging shoulder; the hand outlasts the elbow.
    fn swung(turn: f32) -> (FarLevels, LodErrors) {
        let mut asset = arm(3);
        let angles = (0..5).map(|i| Quat::from_rotation_z(turn * i as f32));
        asset.clips = vec![moving(3, 1, &angles.collect::<Vec<Quat>>())];
        let opts = JointLodOptions::default();
        let found = far_levels(&asset, &[0, 2, 1], &[2, 1], &mean_pose(&asset), &opts);
        found.unwrap().unwrap()
    }

    #[test]
    fn a_hand_hangs_on_what_outlasts_its_elbow() {
        let (levels, errors) = swung(0.05);
        assert_eq!(levels.joints, [0, 2]);
        assert_eq!(levels.rig.parent(1), Some(0));
        // Two bones of 1 m, the second rotated with the first: 1 up, then along the rotation.
        let clip = &levels.clips[0];
        let hand = clip.tracks().translations[0].values[2];
        let angle = 0.1f32;
        assert!((hand - Vec3::new(-angle.sin(), 1.0 + angle.cos(), 0.0)).length() < 1e-6);
        assert_eq!((clip.frames(), clip.rate_hz()), (5, 30.0));
        errors.check(1, 3).unwrap();
    }

    #[test]
    fn a_fast_limb_gets_more_frames() {
        // A bone of 1 m rotated by 0.3 rad a frame: the chord of its end misses the arc by 11 mm,
        // by 2.8 mm with two frames per frame, by 0.7 mm with four.
        let clip = &swung(0.3).0.clips[0];
        assert_eq!((clip.frames(), clip.rate_hz()), (17, 120.0));
        // The rest is added: 0.31 mm at 0.05 rad, on top of the error of the folded elbow.
        let mut asset = arm(3);
        asset.clips = vec![moving(3, 1, &[Quat::IDENTITY, Quat::from_rotation_z(0.05)])];
        let whole = far_levels(
            &asset,
            &[0, 2, 1],
            &[3],
            &mean_pose(&asset),
            &JointLodOptions::default(),
        );
        let left = whole.unwrap().unwrap().1.clips[0].levels_metres[1];
        assert!((left - (1.0 - 0.025f32.cos())).abs() < 1e-5, "{left}");
    }

    #[test]
    fn refuses_what_is_no_order() {
        let asset = arm(3);
        let mean = mean_pose(&asset);
        let at = |order: &[u16], kept: &[u16]| {
            let found = far_levels(&asset, order, kept, &mean, &JointLodOptions::default());
            found.unwrap_err().at
        };
        assert_eq!(at(&[0, 1], &[1]), "order");
        assert_eq!(at(&[0, 1, 1], &[1]), "order");
        assert_eq!(at(&[0, 1, 9], &[1]), "order");
        assert_eq!(at(&[0, 1, 2], &[4]), "kept");
        assert_eq!(at(&[0, 1, 2], &[2, 2]), "kept");
        assert_eq!(at(&[0, 1, 2], &[]), "kept");
        assert_eq!(at(&[0, 1, 2], &[0]), "kept");
    }

    #[test]
    fn morphs_get_as_many_frames() {
        let track = |step| Track {
            target: 3,
            step,
            values: vec![0.0, 1.0],
        };
        assert_eq!(more_frames(&track(false), 2).values, [0.0, 0.5, 1.0]);
        assert_eq!(more_frames(&track(true), 2).values, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn far_clips_keep_their_morphs() {
        let mut asset = arm(3);
        let still = moving(3, 1, &[Quat::IDENTITY; 3]);
        let mut tracks = still.tracks().clone();
        tracks.morphs = vec![Track {
            target: 0,
            step: false,
            values: vec![0.0, 0.5, 0.25],
        }];
        asset.clips = vec![Clip::new("face", 30.0, 3, 3, tracks.clone()).unwrap()];
        let opts = JointLodOptions::default();
        let found = far_levels(&asset, &[0, 2, 1], &[2], &mean_pose(&asset), &opts);
        let (levels, _) = found.unwrap().unwrap();
        assert_eq!(levels.clips[0].frames(), 3);
        assert_eq!(levels.clips[0].tracks().morphs, tracks.morphs);
    }

    /// The product of two joints, each with a scale and a rotation about an axis.
    fn product(scales: [Vec3; 2], angle: f32) -> Option<Transform> {
        let axes = [Vec3::new(1.0, 2.0, 2.0) / 3.0, Vec3::Z];
        let joint = |k: usize| Transform {
            translation: Vec3::Y,
            rotation: Quat::from_axis_angle(axes[k], angle),
            scale: scales[k],
        };
        let links = vec![0, 1];
        Chain { links }.local(&[joint(0), joint(1)].into_iter().collect())
    }

    #[test]
    fn chains_keep_a_scale_of_one_exactly_and_no_shear() {
        for i in 0..50 {
            let angle = i as f32 * 0.13;
            let plain = product([Vec3::ONE; 2], angle).unwrap();
            assert_eq!(plain.scale, Vec3::ONE);
            let expected =
                Vec3::Y + Quat::from_axis_angle(Vec3::new(1.0, 2.0, 2.0) / 3.0, angle) * Vec3::Y;
            assert!(plain.translation.distance(expected) < 1e-5);
            let scaled = product([Vec3::splat(2.0), Vec3::splat(1.5)], angle).unwrap();
            assert!((scaled.scale - Vec3::splat(3.0)).abs().max_element() < 1e-4);
        }
        let stretched = Vec3::new(1.0, 3.0, 1.0);
        assert_eq!(product([stretched, Vec3::ONE], 0.8), None);
        let along = product([stretched, Vec3::ONE], 0.0).unwrap();
        assert!((along.scale - stretched).abs().max_element() < 1e-5);
    }
}
