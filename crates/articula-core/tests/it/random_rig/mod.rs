//! Random rigs with two clips and nested joint sets, for property tests.

use articula_core::source::{Joint, Skeleton};
use articula_core::{
    Articulation, Clip, JointArticulation, JointSet, Region, Rig, Track, Tracks, Transform,
    same_hemisphere,
};
use glam::{Quat, Vec3};
use proptest::prelude::*;

/// Optional features of the random figures.
#[derive(Clone, Copy)]
pub(crate) struct Options {
    /// Scales in the rest pose and in clips.
    pub(crate) scaled: bool,
    /// Tracks that step instead of being interpolated.
    pub(crate) steps: bool,
}

fn vector(most: f32) -> impl Strategy<Value = Vec3> {
    let one = -most..most;
    (one.clone(), one.clone(), one).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

fn rotation() -> impl Strategy<Value = Quat> {
    vector(2.0).prop_map(Quat::from_scaled_axis)
}

fn scale(scaled: bool) -> BoxedStrategy<Vec3> {
    if scaled {
        prop_oneof![
            3 => Just(Vec3::ONE),
            1 => vector(0.3).prop_map(|v| Vec3::ONE + v),
            1 => Just(Vec3::new(-1.0, 1.0, 1.0)),
        ]
        .boxed()
    } else {
        Just(Vec3::ONE).boxed()
    }
}

/// Tracks of some joints: either one value or one for each frame.
fn tracks<T: Clone + std::fmt::Debug + 'static>(
    joints: usize,
    frames: usize,
    steps: bool,
    value: impl Strategy<Value = T> + 'static,
) -> impl Strategy<Value = Vec<Track<T>>> {
    let track = (
        any::<bool>(),
        any::<bool>(),
        prop::collection::vec(value, frames),
    );
    prop::collection::vec(prop::option::of(track), joints).prop_map(move |joints| {
        let some = joints.into_iter().enumerate();
        some.filter_map(|(j, track)| {
            let (step, constant, mut values) = track?;
            values.truncate(if constant { 1 } else { values.len() });
            Some(Track {
                target: j as u16,
                step: step && steps,
                values,
            })
        })
        .collect()
    })
}

fn clip(joints: usize, options: Options) -> impl Strategy<Value = Clip> {
    (1usize..6, 1.0f32..30.0).prop_flat_map(move |(frames, rate)| {
        let scaled = if options.scaled { joints } else { 0 };
        (
            tracks(joints, frames, options.steps, vector(0.2)),
            tracks(joints, frames, options.steps, rotation()),
            tracks(scaled, frames, options.steps, scale(true)),
        )
            .prop_map(move |(translations, mut rotations, scales)| {
                for track in &mut rotations {
                    for i in 1..track.values.len() {
                        track.values[i] = same_hemisphere(track.values[i - 1], track.values[i]);
                    }
                }
                let tracks = Tracks {
                    translations,
                    rotations,
                    scales,
                    morphs: Vec::new(),
                };
                Clip::new("random", rate, frames, joints, tracks).unwrap()
            })
    })
}

/// A rig of 1 to 24 joints, two clips, and up to three nested joint sets.
pub(crate) fn figure(options: Options) -> impl Strategy<Value = (Rig, Vec<Clip>, Vec<JointSet>)> {
    (1usize..=24).prop_flat_map(move |n| {
        let joint = (
            any::<prop::sample::Index>(),
            rotation(),
            vector(0.1),
            scale(options.scaled),
        );
        (
            prop::collection::vec(joint, n),
            prop::collection::vec(clip(n, options), 2),
            prop::collection::vec(any::<prop::sample::Index>(), 0..=3),
        )
            .prop_map(|(joints, clips, cuts)| (rig(&joints), clips, nested(joints.len(), &cuts)))
    })
}

fn rig(joints: &[(prop::sample::Index, Quat, Vec3, Vec3)]) -> Rig {
    let skeleton = Skeleton {
        joints: joints
            .iter()
            .enumerate()
            .map(|(j, (parent, rotation, translation, scale))| Joint {
                name: format!("j{j}"),
                parent: (j > 0).then(|| parent.index(j)),
                rest: Transform {
                    translation: *translation,
                    rotation: *rotation,
                    // One scaled joint in four is enough to shear its descendants.
                    scale: if j % 4 == 1 { *scale } else { Vec3::ONE },
                },
                in_skin: true,
            })
            .collect(),
    };
    let joint = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Torso,
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![joint; joints.len()],
    };
    Rig::new(&skeleton, articulation).unwrap()
}

/// Prefixes of the rig's joint order, in descending size.
fn nested(joints: usize, cuts: &[prop::sample::Index]) -> Vec<JointSet> {
    let mut sizes: Vec<usize> = cuts.iter().map(|c| c.index(joints) + 1).collect();
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes.into_iter().map(JointSet::first).collect()
}
