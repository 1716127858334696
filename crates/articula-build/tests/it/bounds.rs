//! Test 5 of `docs/methods/motion-lod.md` part 10: errors of held joints stay within their bounds,
//! on random rigs, skins and clips.

use crate::random_figure::{FRAMES, RATE, Row, character_of, flat, rows};
use articula_build::ClipOptions;
use articula_build::levers;
use articula_build::{Asset, character};
use articula_build::{ChainTolerance, joint_bounds};
use articula_core::{
    DriftController, DriftOptions, JointViewScales, LocalPose, PosedMesh, Wrap, angle_between,
    sample,
};
use glam::Vec3;
use proptest::prelude::*;

fn asset(rows: &[Row]) -> Asset {
    let source = character_of(rows);
    let opts = ClipOptions {
        rate_hz: Some(RATE),
    };
    character(&source, Some(flat(rows.len())), &opts).unwrap()
}

/// Positions of all vertices in a pose; those of the joints where there is no skin.
fn places(asset: &Asset, pose: &LocalPose) -> Vec<Vec3> {
    let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
    posed.pose(pose);
    if asset.mesh.is_empty() {
        let joints = 0..asset.rig.len();
        return joints.map(|j| posed.model.position(j)).collect();
    }
    let all: Vec<u32> = (0..asset.mesh.len() as u32).collect();
    let mut out = vec![Vec3::ZERO; all.len()];
    posed.points(&all, &mut out);
    out
}

/// Rounding of f32 positions of up to some metres, after several products.
const ROUNDING_METRES: f32 = 2e-5;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn one_held_joint_moves_no_vertex_farther_than_its_reach_times_the_angle(rows in rows(), pick in 0.0f32..1.0) {
        let asset = asset(&rows);
        let held = ((pick * rows.len() as f32) as usize).min(rows.len() - 1);
        let levers = levers(&asset.rig, &asset.mesh);
        let mut pose = asset.rig.rest_pose().clone();
        sample(&asset.clips[0], 0.0, Wrap::Clamp, &asset.rig.all(), &mut pose);
        let first = pose.rotations[held];
        for i in 0..FRAMES {
            sample(&asset.clips[0], f64::from(i as f32 / RATE), Wrap::Clamp, &asset.rig.all(), &mut pose);
            let truth = places(&asset, &pose);
            let angle = angle_between(first, pose.rotations[held]);
            let mut shown = pose.clone();
            shown.rotations[held] = first;
            for (s, t) in places(&asset, &shown).iter().zip(&truth) {
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
        let bare = Asset { mesh: articula_core::Mesh::default().into(), ..asset(&rows) };
        whole_body_under_split(&bare, epsilon_px)?;
    }
}

fn whole_body_under_split(asset: &Asset, epsilon_px: f32) -> Result<(), TestCaseError> {
    {
        let clip = &asset.clips[0];
        let levers = levers(&asset.rig, &asset.mesh);
        let reach_metres: Vec<f32> = levers.iter().map(|l| l.reach_metres).collect();
        let bounds = joint_bounds(asset, clip, &reach_metres, ChainTolerance::Split);
        let opts = DriftOptions {
            epsilon_px,
            pop_px: f32::INFINITY,
            ..DriftOptions::default()
        };
        let mut drift = DriftController::new(asset.rig.rest_pose(), bounds, opts);
        let ppm = vec![100.0; asset.rig.len()];
        let attention = vec![1.0; asset.rig.len()];
        let views = JointViewScales {
            pixels_per_metre: &ppm,
            attention: &attention,
        };
        let (mut wanted, mut truth) =
            (asset.rig.rest_pose().clone(), asset.rig.rest_pose().clone());
        for i in 0..2 * FRAMES - 1 {
            let secs = i as f64 / f64::from(2.0 * RATE);
            let due = drift.due(secs, views);
            sample(clip, secs, Wrap::Clamp, &due, &mut wanted);
            let shown = places(asset, drift.step(secs, views, &due, &wanted));
            sample(clip, secs, Wrap::Clamp, &asset.rig.all(), &mut truth);
            for (s, t) in shown.iter().zip(places(asset, &truth)) {
                let px = s.distance(t) * 100.0;
                prop_assert!(px <= opts.bound_px() + 100.0 * ROUNDING_METRES, "{px} px");
            }
        }
    }
    Ok(())
}
