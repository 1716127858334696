//! Clip edits on random figures: key reduction moves nothing farther than it reports.

use crate::random_figure::{Row, character_of, flat, rows};
use articula_build::clip_edit::EditSubject;
use articula_build::clip_edit::{CloseOptions, close_loop};
use articula_build::clip_edit::{ReduceOptions, ReducedClip, Timelines, reduce_keys};
use articula_build::clip_edit::{RootMotionMode, RootMotionOptions, split_root_motion};
use articula_core::source::{
    Channel, Character, Interpolation, Joint, MorphTarget, Property, RawClip, evaluate,
};
use articula_core::{Mesh, ModelPose, PosedMesh, Rig, Transform, local_to_model};
use glam::{Quat, Vec3};
use proptest::prelude::*;
use std::f32::consts::FRAC_PI_2;

/// Rounding of f32 positions of up to some metres, after several products.
const ROUNDING_METRES: f32 = 2e-5;

/// The figure of some rows below an armature of another scale and up axis, with a root that
/// travels, a joint that jumps, one that grows, and two morph targets.
fn figure_of(rows: &[Row], armature: Transform) -> Character {
    let mut character = character_of(rows);
    let joints = &mut character.skeleton.joints;
    for joint in joints.iter_mut() {
        joint.parent = Some(joint.parent.map_or(0, |p| p + 1));
        joint.rest.translation /= armature.scale;
    }
    joints.insert(
        0,
        Joint {
            name: "armature".into(),
            parent: None,
            rest: armature,
            in_skin: false,
        },
    );
    let rig = Rig::new(&character.skeleton, flat(rows.len() + 1)).unwrap();
    let mut model = ModelPose::new(rig.len());
    local_to_model(&rig, rig.rest_pose(), &mut model);
    let mesh = &mut character.meshes[0];
    for (joint, bind) in mesh.skin.joints.iter_mut().zip(&mut mesh.skin.inverse_bind) {
        *joint += 1;
        *bind = model.matrices[*joint].inverse();
    }
    let vertices = mesh.primitives[0].positions.len();
    for wave in [0.7f32, 1.9] {
        let offset = |v: usize| 0.05 * Vec3::new((v as f32 * wave).sin(), 0.3, 0.0);
        mesh.primitives[0].morphs.push(MorphTarget {
            positions: (0..vertices).map(offset).collect(),
            normals: Vec::new(),
        });
        mesh.morph_names.push(String::new());
        mesh.morph_weights.push(0.0);
    }
    let clip = &mut character.clips[0];
    for channel in &mut clip.channels {
        channel.target += 1;
    }
    let times = clip.channels[0].times_secs.clone();
    let channel = |target, property, interpolation, value: &dyn Fn(f32) -> Vec<f32>| Channel {
        target,
        property,
        interpolation,
        times_secs: times.clone(),
        values: times.iter().flat_map(|t| value(*t)).collect(),
    };
    let way = |t: f32| {
        let metres = Vec3::new(t, 0.05 * (9.0 * t).sin(), 0.2 * t * t);
        (metres / armature.scale).to_array().to_vec()
    };
    let jump = |t: f32| vec![0.1 * (20.0 * t).sin() / armature.scale.x, 0.0, 0.0];
    let grow = |t: f32| vec![1.0 + 0.2 * (7.0 * t).sin(); 3];
    let smile = |t: f32| vec![0.5 + 0.5 * (5.0 * t).sin(), 0.3 * t];
    use Interpolation::{Linear, Step};
    clip.channels.extend([
        channel(1, Property::Translation, Linear, &way),
        channel(2, Property::Translation, Step, &jump),
        channel(2, Property::Scale, Linear, &grow),
        channel(0, Property::Weights, Linear, &smile),
    ]);
    character
}

fn armatures() -> impl Strategy<Value = Transform> {
    prop::sample::select(vec![1.0f32, 0.01, 100.0]).prop_map(|scale| Transform {
        translation: Vec3::new(0.3, 0.0, -0.2),
        rotation: Quat::from_rotation_x(-FRAC_PI_2),
        scale: Vec3::splat(scale),
    })
}

/// Positions of every joint and every vertex in a clip, morph targets applied.
fn shown(character: &Character, rig: &Rig, mesh: &Mesh, clip: &RawClip, secs: f32) -> Vec<Vec3> {
    let mut pose = rig.rest_pose().clone();
    evaluate::pose(clip, &character.skeleton, secs, &mut pose);
    let mut weights = mesh.morph_weights.clone();
    for channel in &clip.channels {
        if channel.property == Property::Weights {
            evaluate::channel(channel, secs, &mut weights);
        }
    }
    let mut posed = PosedMesh::new(rig, mesh);
    let skinned = posed.pose(&pose).skinned(&weights);
    let joints = (0..rig.len()).map(|j| posed.model.position(j));
    joints.chain(skinned.positions).collect()
}

/// Maximum distance of any joint or vertex between two clips, at times on none of the grids of the
/// reduction.
fn worst(character: &Character, reduced: &ReducedClip) -> f32 {
    let rig = Rig::new(&character.skeleton, flat(character.skeleton.joints.len())).unwrap();
    let mesh = Mesh::new(&character.meshes, rig.len()).unwrap();
    let clip = &character.clips[0];
    let times = (0..=241).map(|i| clip.duration_secs * i as f32 / 241.0);
    let apart = times.map(|secs| {
        let [a, b] = [clip, &reduced.clip].map(|c| shown(character, &rig, &mesh, c, secs));
        let distances = a.iter().zip(&b).map(|(p, q)| p.distance(*q));
        distances.fold(0.0, f32::max)
    });
    apart.fold(0.0, f32::max)
}

/// The figure with a hips joint that travels over the ground, turns and sways, and a second,
/// independent joint below the armature.
fn traveller(rows: &[Row], armature: Transform, how: Interpolation) -> Character {
    let mut character = figure_of(rows, armature);
    let joints = &mut character.skeleton.joints;
    joints.push(Joint {
        name: "target".into(),
        parent: Some(0),
        rest: Transform::from_translation(Vec3::X / armature.scale),
        in_skin: true,
    });
    let last = joints.len() - 1;
    let clip = &mut character.clips[0];
    clip.channels
        .retain(|c| c.target != 1 || !c.property.is_of_joint());
    let times: Vec<f32> = (0..12)
        .map(|i| i as f32 * clip.duration_secs / 11.0)
        .collect();
    let up = armature.rotation.inverse();
    let turn =
        |t: f32| up * Quat::from_rotation_y(3.0 * t) * Quat::from_rotation_x(0.3 * (9.0 * t).sin());
    let way = |t: f32| up * Vec3::new(2.0 * t, 0.9 + 0.1 * (9.0 * t).sin(), (4.0 * t).sin());
    let cubic = how == Interpolation::CubicSpline;
    let keys = |value: &dyn Fn(f32) -> Vec<f32>| -> Vec<f32> {
        let slope = |t: f32| -> Vec<f32> {
            let [a, b] = [t - 1e-3, t + 1e-3].map(value);
            a.iter().zip(b).map(|(a, b)| (b - a) / 2e-3).collect()
        };
        let key = |t: &f32| match cubic {
            true => [slope(*t), value(*t), slope(*t)].concat(),
            false => value(*t),
        };
        times.iter().flat_map(key).collect()
    };
    let channel = |target, property, value: &dyn Fn(f32) -> Vec<f32>| Channel {
        target,
        property,
        interpolation: how,
        times_secs: times.clone(),
        values: keys(value),
    };
    clip.channels.extend([
        channel(1, Property::Rotation, &|t| turn(t).to_array().to_vec()),
        channel(1, Property::Translation, &|t| {
            (way(t) / armature.scale).to_array().to_vec()
        }),
        channel(last, Property::Translation, &|t| {
            (Vec3::new(t, -t, 1.0) / armature.scale).to_array().to_vec()
        }),
    ]);
    character
}

fn interpolations() -> impl Strategy<Value = Interpolation> {
    use Interpolation::{CubicSpline, Linear, Step};
    prop::sample::select(vec![Linear, Step, CubicSpline])
}

/// Times between the keys, except those within a thousandth of a second of a jump.
fn moments(clip: &RawClip) -> impl Iterator<Item = f32> {
    let end = clip.duration_secs;
    (0..150)
        .map(move |i| end * (i as f32 + 0.5) / 150.0)
        .filter(move |t| {
            let phase = (t / end * 11.0).fract();
            (0.02..0.98).contains(&phase)
        })
}

fn joints(character: &Character, rig: &Rig, clip: &RawClip, secs: f32) -> ModelPose {
    let mut pose = rig.rest_pose().clone();
    evaluate::pose(clip, &character.skeleton, secs, &mut pose);
    let mut model = ModelPose::new(rig.len());
    local_to_model(rig, &pose, &mut model);
    model
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn extracted_root_motion_leaves_every_joint_where_it_was(
        rows in rows(),
        armature in armatures(),
        how in interpolations(),
        smooth_secs in prop::sample::select(vec![0.0f32, 0.3]),
    ) {
        let character = traveller(&rows, armature, how);
        let count = character.skeleton.joints.len();
        let subject = EditSubject::new(&character, flat(count), &[]).unwrap();
        let mode = RootMotionMode::Extract;
        let out = split_root_motion(&subject, &character.clips[0], &RootMotionOptions { mode, smooth_secs, ..RootMotionOptions::default() }).unwrap();
        prop_assert_eq!(out.carrier, Some(0));
        // Rounding, and the permitted error of straight pieces between keys.
        prop_assert!(out.worst_metres <= 3e-4, "{}", out.worst_metres);
        let rig = Rig::new(&character.skeleton, flat(count)).unwrap();
        let first = joints(&character, &rig, &out.clip, 0.0).matrices[0];
        for secs in moments(&character.clips[0]) {
            let [a, b] = [&character.clips[0], &out.clip].map(|c| joints(&character, &rig, c, secs));
            for j in 1..count {
                let apart = a.position(j).distance(b.position(j));
                prop_assert!(apart <= 3e-4, "joint {j} at {secs} s: {apart} m");
            }
            // The carrier stays upright and at its height.
            let step = b.matrices[0] * first.inverse();
            prop_assert!((step.transform_vector3(Vec3::Y) - Vec3::Y).length() < 1e-4);
            prop_assert!((b.position(0).y - first.translation.y).abs() < 1e-4);
        }
        // And travels with the hips.
        let last = out.trajectory.last().unwrap();
        let [a, b] = [0.0, character.clips[0].duration_secs]
            .map(|t| joints(&character, &rig, &character.clips[0], t).position(1));
        prop_assert!((last.x_metres - (b - a).x).abs() < 1e-3 && (last.z_metres - (b - a).z).abs() < 1e-3);
    }

    #[test]
    fn a_closed_loop_ends_as_it_starts(
        rows in rows(),
        armature in armatures(),
        how in interpolations(),
        window_secs in prop::option::of(0.05f32..0.5),
    ) {
        let character = traveller(&rows, armature, how);
        let count = character.skeleton.joints.len();
        let subject = EditSubject::new(&character, flat(count), &[]).unwrap();
        let clip = &character.clips[0];
        let out = close_loop(&subject, clip, &CloseOptions { window_secs }).unwrap();
        prop_assert!(out.seam_radians <= 1e-5, "{}", out.seam_radians);
        let rig = Rig::new(&character.skeleton, flat(count)).unwrap();
        let end = clip.duration_secs;
        let [a, b] = [0.0, end].map(|t| joints(&character, &rig, &out.clip, t));
        // One rigid transform over the ground takes the whole body from the first pose to the last.
        let step = b.matrices[1] * a.matrices[1].inverse();
        prop_assert!((step.transform_vector3(Vec3::Y) - Vec3::Y).length() < 1e-4);
        prop_assert!((b.position(1).y - a.position(1).y).abs() < 1e-4, "the height is closed");
        for j in 1..count - 1 {
            let taken = step.transform_point3(a.position(j));
            prop_assert!(taken.distance(b.position(j)) < 1e-4, "joint {j}");
        }
        // The distance travelled over the ground is unchanged.
        let [p, q] = [0.0, end].map(|t| joints(&character, &rig, clip, t).position(1));
        let way = Vec3::new((q - p).x, 0.0, (q - p).z).length();
        prop_assert!((out.travel_metres - way).abs() < 1e-3 * way.max(1.0));
        let again = close_loop(&subject, &out.clip, &CloseOptions { window_secs }).unwrap();
        prop_assert!(again.moved_metres < 1e-3, "{}", again.moved_metres);
        if let Some(w) = window_secs.filter(|w| 2.2 * w < end) {
            let middle = 0.5 * end;
            let [p, q] = [clip, &out.clip].map(|c| joints(&character, &rig, c, middle));
            for j in 1..count {
                prop_assert!(p.position(j).distance(q.position(j)) < 1e-3, "{w} s do not reach {middle}");
            }
        }
    }

    #[test]
    fn in_place_and_the_trajectory_are_the_whole(
        rows in rows(),
        armature in armatures(),
        how in interpolations(),
    ) {
        let character = traveller(&rows, armature, how);
        let count = character.skeleton.joints.len();
        let subject = EditSubject::new(&character, flat(count), &[]).unwrap();
        let mode = RootMotionMode::InPlace;
        let opts = RootMotionOptions { mode, ..RootMotionOptions::default() };
        let out = split_root_motion(&subject, &character.clips[0], &opts).unwrap();
        let rig = Rig::new(&character.skeleton, flat(count)).unwrap();
        let start = joints(&character, &rig, &character.clips[0], 0.0).position(1);
        for key in &out.trajectory {
            let [a, b] = [&character.clips[0], &out.clip].map(|c| joints(&character, &rig, c, key.secs));
            let (a_hips, b_hips) = (a.position(1), b.position(1));
            prop_assert!((b_hips.x - start.x).abs() < 2e-4 && (b_hips.z - start.z).abs() < 2e-4);
            let turn = Quat::from_rotation_y(key.yaw_radians);
            let ground = Vec3::new(start.x, 0.0, start.z);
            let way = Vec3::new(key.x_metres, 0.0, key.z_metres);
            for j in 1..count {
                let back = turn * (b.position(j) - ground) + ground + way;
                prop_assert!(back.distance(a.position(j)) < 3e-4);
            }
            prop_assert!((a_hips.y - b_hips.y).abs() < 1e-4, "height stays with the hips");
        }
        // An in-place clip has no trajectory left.
        let again = split_root_motion(&subject, &out.clip, &RootMotionOptions::default()).unwrap();
        for key in &again.trajectory {
            prop_assert!(key.x_metres.abs() < 3e-4 && key.z_metres.abs() < 3e-4 && key.yaw_radians.abs() < 1e-3);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn no_joint_and_no_vertex_leaves_the_bound(
        rows in rows(),
        armature in armatures(),
        bound_metres in prop::sample::select(vec![3e-4f32, 1e-3, 1e-2, 0.1]),
        drop_rest: bool,
    ) {
        let character = figure_of(&rows, armature);
        let subject = EditSubject::new(&character, flat(rows.len() + 1), &[]).unwrap();
        let opts = ReduceOptions { bound_metres, drop_rest, timelines: Timelines::Own };
        let reduced = reduce_keys(&subject, &character.clips[0], &opts).unwrap();
        prop_assert!(reduced.worst_metres <= bound_metres);
        prop_assert!(reduced.after.bytes <= reduced.before.bytes);
        let found = worst(&character, &reduced);
        // Between two times of the grid, at most 1/120 s apart, the error can exceed that on the
        // grid by the curvature of the motion: these turn by up to 0.5 rad a frame.
        prop_assert!(found <= 1.02 * bound_metres + ROUNDING_METRES, "{found} of {bound_metres}");
        let again = reduce_keys(&subject, &reduced.clip, &opts).unwrap();
        prop_assert!(again.after.keys <= reduced.after.keys);
    }
}
