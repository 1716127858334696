//! Acceptance test 5 of `spec/motion-lod.md` part 10: errors of held joints stay within their
//! bounds, on random rigs, skins and clips.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use articula_build::character::{Asset, character};
use articula_build::clip::ClipOptions;
use articula_build::evaluate::Points;
use articula_build::motion_error::bounds::{ChainShare, LeverKind, joint_bounds};
use articula_build::motion_error::levers::levers;
use articula_core::articulation::{Articulation, JointArticulation, Region};
use articula_core::drift::{Drift, DriftOptions, JointViews};
use articula_core::hierarchy::local_to_model;
use articula_core::math::{Transform, angle_between};
use articula_core::pose::ModelPose;
use articula_core::sample::{Wrap, sample};
use articula_core::source::{
    Channel, Character, Clip, Interpolation, Joint, Mesh, Primitive, Property, Skeleton, Skin,
};
use glam::{Quat, Vec3};
use proptest::prelude::*;

const RATE: f32 = 30.0;
const FRAMES: usize = 24;

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    (-size..size, -size..size, -size..size).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

fn rotation(size: f32) -> impl Strategy<Value = Quat> {
    vector(size).prop_map(Quat::from_scaled_axis)
}

/// (parent choice, offset, rest rotation, turn a frame) of a joint.
type Row = (f32, Vec3, Quat, Vec3);

fn rows() -> impl Strategy<Value = Vec<Row>> {
    prop::collection::vec(
        (0.0f32..1.0, vector(0.4), rotation(1.5), vector(0.12)),
        2..9,
    )
}

fn parents(rows: &[Row]) -> Vec<Option<usize>> {
    rows.iter()
        .enumerate()
        .map(|(j, r)| (j > 0).then(|| ((r.0 * j as f32) as usize).min(j - 1)))
        .collect()
}

/// A mesh whose vertices each hang on one, two or three neighbouring joints.
fn skinned(rows: &[Row], skeleton: &Skeleton) -> Mesh {
    let count = rows.len();
    let articulation = flat(count);
    let rig = articula_core::rig::Rig::new(skeleton, articulation).unwrap();
    let mut model = ModelPose::new(count);
    local_to_model(&rig, rig.rest_pose(), &mut model);
    let mut primitive = Primitive {
        influences: 3,
        ..Primitive::default()
    };
    for v in 0..30 {
        let joint = v % count;
        let offset = Vec3::new(
            (v as f32).sin(),
            (1.7 * v as f32).cos(),
            (2.9 * v as f32).sin(),
        ) * 0.3;
        primitive.positions.push(model.position(joint) + offset);
        let parent = rig.parent(joint).unwrap_or(0);
        primitive
            .joints
            .extend([joint as u16, parent as u16, ((joint + 1) % count) as u16]);
        let w = 0.4 + 0.6 * (v as f32 * 0.37).fract();
        primitive
            .weights
            .extend([w, (1.0 - w) * 0.75, (1.0 - w) * 0.25]);
    }
    primitive.triangles = (0..10).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Mesh {
        name: "skin".into(),
        skin: Skin {
            joints: (0..count).collect(),
            inverse_bind: model.matrices.iter().map(|m| m.inverse()).collect(),
        },
        primitives: vec![primitive],
        ..Mesh::default()
    }
}

fn flat(joints: usize) -> Articulation {
    let entry = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Torso,
    };
    Articulation {
        profile: String::new(),
        joints: vec![entry; joints],
    }
}

fn asset(rows: &[Row]) -> Asset {
    let skeleton = Skeleton {
        joints: rows
            .iter()
            .zip(parents(rows))
            .enumerate()
            .map(|(j, (row, parent))| Joint {
                name: format!("j{j}"),
                parent,
                rest: Transform {
                    translation: row.1,
                    rotation: row.2,
                    scale: Vec3::ONE,
                },
                in_skin: true,
            })
            .collect(),
    };
    let times: Vec<f32> = (0..FRAMES).map(|i| i as f32 / RATE).collect();
    let channels = rows.iter().enumerate().map(|(j, row)| Channel {
        target: j,
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times_secs: times.clone(),
        values: (0..FRAMES)
            .flat_map(|i| {
                (row.2 * Quat::from_scaled_axis(row.3 * (0.4 * i as f32).sin() * 6.0)).to_array()
            })
            .collect(),
    });
    let clip = Clip {
        name: "random".into(),
        duration_secs: times[FRAMES - 1],
        channels: channels.collect(),
    };
    let source = Character {
        meshes: vec![skinned(rows, &skeleton)],
        skeleton,
        clips: vec![clip],
        ..Character::default()
    };
    let opts = ClipOptions {
        rate_hz: Some(RATE),
    };
    character(&source, Some(flat(rows.len())), &opts).unwrap()
}

/// Rounding of f32 positions up to some metres, several products deep.
const ROUNDING_METRES: f32 = 2e-5;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn one_held_joint_moves_no_vertex_farther_than_its_reach_times_the_angle(rows in rows(), pick in 0.0f32..1.0) {
        let asset = asset(&rows);
        let held = ((pick * rows.len() as f32) as usize).min(rows.len() - 1);
        let levers = levers(&asset.rig, &asset.mesh);
        let points = Points::draw(&asset, usize::MAX, 1);
        let mut pose = asset.rig.rest_pose().clone();
        sample(&asset.clips[0], 0.0, Wrap::Clamp, &asset.rig.all(), &mut pose);
        let first = pose.rotations[held];
        for i in 0..FRAMES {
            sample(&asset.clips[0], f64::from(i as f32 / RATE), Wrap::Clamp, &asset.rig.all(), &mut pose);
            let truth = points.posed(&asset, &pose);
            let angle = angle_between(first, pose.rotations[held]);
            let mut shown = pose.clone();
            shown.rotations[held] = first;
            for (s, t) in points.posed(&asset, &shown).iter().zip(&truth) {
                let bound = levers[held].reach_metres * angle + ROUNDING_METRES;
                prop_assert!(s.distance(*t) <= bound, "{} m of {bound}", s.distance(*t));
            }
        }
    }

    #[test]
    fn a_whole_body_under_split_stays_within_the_tolerance(rows in rows(), epsilon_px in 0.5f32..8.0) {
        whole_body_under_split(&asset(&rows), epsilon_px)?;
    }

    #[test]
    fn a_skeleton_without_skin_stays_within_the_tolerance_too(rows in rows(), epsilon_px in 0.5f32..8.0) {
        let bare = Asset { mesh: articula_core::mesh::Mesh::default(), ..asset(&rows) };
        whole_body_under_split(&bare, epsilon_px)?;
    }
}

fn whole_body_under_split(asset: &Asset, epsilon_px: f32) -> Result<(), TestCaseError> {
    {
        let clip = &asset.clips[0];
        let levers = levers(&asset.rig, &asset.mesh);
        let bounds = joint_bounds(asset, clip, &levers, LeverKind::Reach, ChainShare::Split);
        let opts = DriftOptions {
            epsilon_px,
            pop_px: f32::INFINITY,
            ..DriftOptions::default()
        };
        let mut drift = Drift::new(asset.rig.rest_pose(), bounds, opts);
        let points = Points::draw(asset, usize::MAX, 1);
        let ppm = vec![100.0; asset.rig.len()];
        let attention = vec![1.0; asset.rig.len()];
        let views = JointViews {
            pixels_per_metre: &ppm,
            attention: &attention,
        };
        let (mut wanted, mut truth) =
            (asset.rig.rest_pose().clone(), asset.rig.rest_pose().clone());
        for i in 0..2 * FRAMES - 1 {
            let secs = i as f64 / f64::from(2.0 * RATE);
            let due = drift.due(secs, views);
            sample(clip, secs, Wrap::Clamp, &due, &mut wanted);
            let shown = points.posed(asset, drift.step(secs, views, &due, &wanted));
            sample(clip, secs, Wrap::Clamp, &asset.rig.all(), &mut truth);
            for (s, t) in shown.iter().zip(points.posed(asset, &truth)) {
                let px = s.distance(t) * 100.0;
                prop_assert!(px <= opts.bound_px() + 100.0 * ROUNDING_METRES, "{px} px");
            }
        }
    }
    Ok(())
}
