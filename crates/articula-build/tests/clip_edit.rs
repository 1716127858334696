//! Edited clips on random figures: key reduction moves nothing farther than it says.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

mod random_figure;

use articula_build::clip_edit::Subject;
use articula_build::clip_edit::key_reduction::{ReduceOptions, Reduced, reduce_keys};
use articula_core::hierarchy::local_to_model;
use articula_core::math::Transform;
use articula_core::mesh::Mesh;
use articula_core::pose::ModelPose;
use articula_core::rig::Rig;
use articula_core::skin::{SkinnedMesh, palette, skin};
use articula_core::source::{
    Channel, Character, Clip, Interpolation, Joint, MorphTarget, Property, evaluate,
};
use glam::{Affine3A, Quat, Vec3};
use proptest::prelude::*;
use random_figure::{Row, character_of, flat, rows};
use std::f32::consts::FRAC_PI_2;

/// Rounding of f32 positions up to some metres, several products deep.
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

/// Where a clip has every joint and every vertex, morph targets applied.
fn shown(character: &Character, rig: &Rig, mesh: &Mesh, clip: &Clip, secs: f32) -> Vec<Vec3> {
    let mut pose = rig.rest_pose().clone();
    evaluate::pose(clip, &character.skeleton, secs, &mut pose);
    let mut model = ModelPose::new(rig.len());
    local_to_model(rig, &pose, &mut model);
    let mut matrices = vec![Affine3A::IDENTITY; mesh.bindings.len()];
    palette(mesh, &model, &mut matrices);
    let mut weights = mesh.morph_weights.clone();
    for channel in &clip.channels {
        if channel.property == Property::Weights {
            evaluate::channel(channel, secs, &mut weights);
        }
    }
    let mut skinned = SkinnedMesh::new(mesh);
    skin(mesh, &matrices, &weights, &mut skinned);
    let joints = (0..rig.len()).map(|j| model.position(j));
    joints.chain(skinned.positions).collect()
}

/// The greatest distance of any joint or vertex between two clips, at times that none of the
/// grids of the reduction has.
fn worst(character: &Character, reduced: &Reduced) -> f32 {
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
        let subject = Subject::new(&character, flat(rows.len() + 1), &[]).unwrap();
        let opts = ReduceOptions { bound_metres, drop_rest };
        let reduced = reduce_keys(&subject, &character.clips[0], &opts).unwrap();
        prop_assert!(reduced.worst_metres <= bound_metres);
        prop_assert!(reduced.after.bytes <= reduced.before.bytes);
        let found = worst(&character, &reduced);
        // Between two times of the grid, at most 1/120 s apart, an error that is nowhere greater
        // on it can bulge by the bend of the motion: these turn by up to 0.5 rad a frame.
        prop_assert!(found <= 1.02 * bound_metres + ROUNDING_METRES, "{found} of {bound_metres}");
        let again = reduce_keys(&subject, &reduced.clip, &opts).unwrap();
        prop_assert!(again.after.keys <= reduced.after.keys);
    }
}
