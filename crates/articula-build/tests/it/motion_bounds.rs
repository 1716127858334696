//! Bounds of clips contain every vertex at every time, on random figures and on the reference
//! human.

use crate::random_figure::{RATE, Row, character_of, flat, rows, vector};
use crate::reference_human::asset_of_4000;
use articula_build::ClipOptions;
use articula_build::{Asset, character};
use articula_build::{motion_bounds, reach_bounds};
use articula_core::{
    Clip, LocalPose, Mesh, Morph, PosedMesh, Track, Tracks, Wrap, nlerp, sample, sample_morphs,
};
use glam::{Quat, Vec3};
use proptest::prelude::*;
use std::sync::Arc;

/// Motion of a random figure besides the rotation of its joints.
#[derive(Debug, Clone)]
struct Extra {
    joint: f32,
    way: Vec3,
    scale: Vec3,
    morph: f32,
    step: bool,
    rate_hz: f32,
}

fn extra() -> impl Strategy<Value = Extra> {
    let numbers = (0.0f32..1.0, vector(0.2), vector(0.8), -2.0f32..2.0);
    (numbers, any::<bool>(), 5.0f32..60.0).prop_map(
        |((joint, way, scale, morph), step, rate_hz)| Extra {
            joint,
            way,
            scale,
            morph,
            step,
            rate_hz,
        },
    )
}

/// The random figure with an additional clip that also translates, scales and morphs, partly in
/// steps.
fn asset(rows: &[Row], extra: &Extra) -> Asset {
    let source = character_of(rows);
    let opts = ClipOptions {
        rate_hz: Some(RATE),
    };
    let mut asset = character(&source, Some(flat(rows.len())), &opts).unwrap();
    let mesh = Arc::make_mut(&mut asset.mesh);
    mesh.morph_weights.push(0.0);
    mesh.morphs.push(Morph {
        slot: 0,
        vertices: vec![0, 3, 7],
        positions: vec![Vec3::X * 0.1, Vec3::Y * 0.2, Vec3::Z * -0.1],
        normals: vec![Vec3::ZERO; 3],
    });
    let turning = &asset.clips[0];
    let frames = turning.frames();
    let target = ((extra.joint * rows.len() as f32) as usize).min(rows.len() - 1) as u16;
    let wave = |i: usize| (0.9 * i as f32).sin();
    let tracks = Tracks {
        rotations: turning
            .tracks()
            .rotations
            .iter()
            .map(|t| Track {
                step: extra.step && t.target % 3 == 1,
                // Played twice as fast as the other clip, and backwards.
                values: (0..frames)
                    .map(|i| t.values[(frames - 1 - i) * (t.values.len() - 1) / (frames - 1)])
                    .collect(),
                ..*t
            })
            .collect(),
        translations: vec![Track {
            target,
            step: extra.step,
            values: (0..frames).map(|i| extra.way * wave(i) * 5.0).collect(),
        }],
        scales: vec![Track {
            target,
            step: false,
            values: (0..frames)
                .map(|i| Vec3::ONE + extra.scale * wave(i + 3))
                .collect(),
        }],
        morphs: vec![Track {
            target: 0,
            step: false,
            values: (0..frames).map(|i| extra.morph * wave(i + 5)).collect(),
        }],
    };
    let more = Clip::new("more", extra.rate_hz, frames, rows.len(), tracks).unwrap();
    asset.clips.push(more);
    asset
}

/// A character that is posed arbitrarily.
struct Body<'a> {
    asset: &'a Asset,
    morph_weights: Vec<f32>,
}

impl<'a> Body<'a> {
    fn new(asset: &'a Asset) -> Self {
        Self {
            asset,
            morph_weights: asset.mesh.morph_weights.clone(),
        }
    }

    fn sampled(&mut self, clip: &Clip, secs: f64, wrap: Wrap) -> LocalPose {
        let mut pose = self.asset.rig.rest_pose().clone();
        sample(clip, secs, wrap, &self.asset.rig.all(), &mut pose);
        self.morph_weights
            .copy_from_slice(&self.asset.mesh.morph_weights);
        sample_morphs(clip, secs, wrap, &mut self.morph_weights);
        pose
    }

    /// Positions of the skin, or of the joints where there is none.
    fn points(&self, pose: &LocalPose) -> Vec<Vec3> {
        let (rig, mesh) = (&self.asset.rig, &self.asset.mesh);
        let mut posed = PosedMesh::new(rig, mesh);
        posed.pose(pose);
        if mesh.is_empty() {
            return (0..rig.len()).map(|j| posed.model.position(j)).collect();
        }
        posed.skinned(&self.morph_weights).positions
    }
}

fn bare(asset: Asset) -> Asset {
    Asset {
        mesh: Mesh::default().into(),
        ..asset
    }
}

fn blended(a: &LocalPose, b: &LocalPose, weight: impl Fn(usize) -> f32) -> LocalPose {
    let mut out = a.clone();
    for j in 0..a.rotations.len() {
        let w = weight(j);
        out.rotations[j] = nlerp(a.rotations[j], b.rotations[j], w);
        out.translations[j] = a.translations[j].lerp(b.translations[j], w);
        out.scales[j] = a.scales[j].lerp(b.scales[j], w);
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn every_vertex_is_inside_at_every_time_ahead(
        rows in rows(),
        extra in extra(),
        is_bare in any::<bool>(),
        now in -3.0f64..9.0,
        horizon in 0.0f32..2.0,
        speed in -2.0f32..2.0,
        parts in prop::collection::vec(0.0f64..=1.0, 12),
        wrap in prop::sample::select(vec![Wrap::Loop, Wrap::Clamp]),
    ) {
        let asset = asset(&rows, &extra);
        let asset = if is_bare { bare(asset) } else { asset };
        let bounds = motion_bounds(&asset, 0.0).unwrap();
        let reach = reach_bounds(&asset).unwrap();
        let mut body = Body::new(&asset);
        let each = bounds.clips.iter().zip(&reach.clips);
        for (clip, (bounds, reach)) in asset.clips.iter().zip(each) {
            let bound = bounds.over(now, horizon, speed, wrap);
            let reach = reach.over(now, horizon, speed, wrap);
            for part in &parts {
                let secs = now + f64::from(speed) * f64::from(horizon) * part;
                let pose = body.sampled(clip, secs, wrap);
                for p in body.points(&pose) {
                    prop_assert!(bound.contains(p), "{p} at {secs} s outside {bound:?}");
                    prop_assert!(reach.contains(p), "{p} at {secs} s outside {reach:?}");
                }
            }
        }
    }

    #[test]
    fn every_vertex_of_a_blend_is_within_reach(
        rows in rows(),
        extra in extra(),
        is_bare in any::<bool>(),
        times in prop::collection::vec((0.0f64..2.0, 0.0f64..2.0), 6),
        weights in prop::collection::vec(0.0f32..=1.0, 9),
    ) {
        let asset = asset(&rows, &extra);
        let asset = if is_bare { bare(asset) } else { asset };
        let bounds = motion_bounds(&asset, 0.0).unwrap();
        let reach = reach_bounds(&asset).unwrap();
        let mut body = Body::new(&asset);
        for (s, t) in times {
            let a = body.sampled(&asset.clips[0], s, Wrap::Loop);
            let b = body.sampled(&asset.clips[1], t, Wrap::Loop);
            // A separate weight for each joint, as with masks of parts of the body.
            let pose = blended(&a, &b, |joint| weights[joint]);
            for sphere in [&bounds, &reach].map(|b| b.blended(0, 1)) {
                for p in body.points(&pose) {
                    prop_assert!(p.distance(sphere.centre) <= sphere.radius, "{p} outside {sphere:?}");
                }
            }
        }
    }
}

/// A stepped value of the last frame is shown from the end of the clip on, and at no other time.
#[test]
fn the_last_frame_of_a_stepped_track_is_inside() {
    // 23 intervals of a fifth of a second: 4.6 s, which rounds down in 32 bits.
    let extra = Extra {
        joint: 0.0,
        way: Vec3::Z,
        scale: Vec3::ZERO,
        morph: 0.0,
        step: true,
        rate_hz: 5.0,
    };
    let still = (0.0, Vec3::ZERO, Quat::IDENTITY, Vec3::ZERO);
    let asset = asset(&[still, still], &extra);
    let clip = &asset.clips[1];
    assert!(f64::from(clip.duration_secs()) * 5.0 < (clip.frames() - 1) as f64);
    let bounds = motion_bounds(&asset, 0.0).unwrap();
    let mut body = Body::new(&asset);
    let pose = body.sampled(clip, 10.0, Wrap::Clamp);
    for p in body.points(&pose) {
        assert!(bounds.clips[1].whole().contains(p), "{p}");
    }
}

#[test]
fn bounds_of_the_reference_human_are_close() {
    let asset = asset_of_4000();
    let bounds = motion_bounds(asset, 0.0).unwrap();
    let mut body = Body::new(asset);
    for (clip, bounds) in asset.clips.iter().zip(&bounds.clips) {
        let mut least = Vec3::INFINITY;
        let mut greatest = Vec3::NEG_INFINITY;
        for i in 0..clip.frames() {
            let secs = i as f64 / f64::from(clip.rate_hz());
            let pose = body.sampled(clip, secs, Wrap::Clamp);
            for p in body.points(&pose) {
                assert!(bounds.over(secs, 0.0, 1.0, Wrap::Clamp).contains(p));
                least = least.min(p);
                greatest = greatest.max(p);
            }
        }
        // The margin between sampled times adds centimetres, not the size of a body.
        let whole = bounds.whole();
        let spare = (least - whole.least).max(whole.greatest - greatest);
        assert!(spare.max_element() < 0.08, "{}: {spare}", clip.name);
        let ball = (0.5 * (greatest - least)).length();
        assert!(whole.sphere.radius < ball + 0.08, "{}", clip.name);
    }
    // From the hips to fingertips or toes of a figure of 1.75 m, in any pose.
    let reach = bounds.reach_metres;
    assert!((1.0..1.8).contains(&reach), "{reach} m");
}

#[test]
fn what_has_no_place_is_refused() {
    let rows: Vec<Row> = vec![(0.0, Vec3::Y, Quat::IDENTITY, Vec3::ZERO); 2];
    let extra = Extra {
        joint: 0.0,
        way: Vec3::ZERO,
        scale: Vec3::ZERO,
        morph: 0.0,
        step: false,
        rate_hz: 30.0,
    };
    let asset = asset(&rows, &extra);
    for margin in [f32::NAN, f32::INFINITY, -1.0] {
        let refused = motion_bounds(&asset, margin).unwrap_err();
        assert_eq!(refused.at, "margin_metres");
    }
    for bad in [f32::NAN, f32::INFINITY, 1e30] {
        let mut lost = asset.clone();
        let tracks = Tracks {
            translations: vec![Track {
                target: 0,
                step: false,
                values: vec![Vec3::ZERO, Vec3::splat(bad * 1e10), Vec3::ZERO],
            }],
            ..Tracks::default()
        };
        lost.clips
            .push(Clip::new("lost", 30.0, 3, 2, tracks).unwrap());
        let refused = motion_bounds(&lost, 0.0).unwrap_err();
        assert_eq!(refused.at, "clip \"lost\"");
        assert!(motion_bounds(&bare(lost), 0.0).is_err());
    }
    let pose = Clip::new("pose", 30.0, 1, 2, Tracks::default()).unwrap();
    let still = Asset {
        clips: vec![pose],
        ..asset
    };
    let bounds = motion_bounds(&still, 0.25).unwrap();
    let mut body = Body::new(&still);
    let pose = body.sampled(&still.clips[0], 0.0, Wrap::Loop);
    let whole = bounds.clips[0].whole();
    assert!(
        body.points(&pose)
            .iter()
            .all(|p| whole.contains(*p + Vec3::Y * 0.2))
    );
}
