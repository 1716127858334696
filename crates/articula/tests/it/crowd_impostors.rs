//! Impostors in crowds of the library: who is far is shown by them, with an error as measured within
//! the tolerance, the same for any number of parts.

use crate::crowd::{asset_of, human};
use articula::crowd::{
    BakedImpostors, Camera, CrowdAsset, CrowdOptions, CrowdPlayer, Culling, ErrorMeter, LevelTally,
    PaletteHash, View, Viewport,
};
use articula::{Executor, Figure};
use articula_flat::Appearance;
use articula_flat::impostor::{ImpostorBound, ImpostorOptions};
use glam::Vec3;
use std::sync::OnceLock;

/// Error of the impostors, metres.
const METRES: f32 = 0.5;

/// The human with cached poses and impostors, made once for all tests.
pub(crate) fn asset_with_impostors() -> &'static CrowdAsset {
    static ASSET: OnceLock<CrowdAsset> = OnceLock::new();
    let options = CrowdOptions {
        pose_cache: true,
        impostors: Some(ImpostorOptions {
            bound: ImpostorBound::Metres(METRES),
            ..ImpostorOptions::default()
        }),
        ..CrowdOptions::default()
    };
    ASSET.get_or_init(|| asset_of(human(), &options))
}

#[test]
fn who_is_far_is_shown_by_an_impostor_within_the_tolerance() {
    let asset = asset_with_impostors();
    let plan = asset.impostors().unwrap();
    assert_eq!(plan.clips.len(), asset.clips().len());
    let worst = plan.clips.iter().map(|c| c.error_m).fold(0.0, f32::max);
    assert!(worst < 1.3 * METRES, "{worst}");
    let atlas = asset.impostor_atlas(&Appearance::default(), &Executor::default());
    let atlas = atlas.unwrap().unwrap();
    assert!(atlas.width() >= plan.cell.size_px[0] && atlas.height() >= plan.cell.size_px[1]);
    // The first row is near, the others where a metre is about a pixel.
    let mut crowd = CrowdPlayer::new(asset, 64).unwrap();
    for i in 0..64 {
        let z = if i < 8 { -8.0 } else { -900.0 - 4.0 * i as f32 };
        crowd.place(i, Vec3::new((i % 8) as f32 - 4.0, 0.0, z), 0.9 * i as f32);
        crowd.play(i, i % asset.clips().len(), 0.07 * i as f32);
    }
    let camera = Camera::looking_at(Vec3::Y * 60.0, Vec3::NEG_Z * 300.0, Viewport::default());
    let views = [View::of(&camera)];
    let mut meter = ErrorMeter::new(asset, 1);
    let mut tally = LevelTally::new(asset);
    let mut samples = Vec::new();
    for frame in 0..12 {
        crowd.plan(1.0 / 30.0, Culling::Views(&views), &mut |_| ());
        crowd.evaluate();
        let mut whole = PaletteHash::default();
        whole.add(&crowd);
        let draws = crowd.impostors().to_vec();
        crowd.parts(3).for_each(|mut part| part.evaluate());
        assert_eq!(crowd.impostors(), draws);
        let mut parted = PaletteHash::default();
        parted.add(&crowd);
        assert_eq!(parted.text(), whole.text());
        assert!(draws.len() > 40, "{}", draws.len());
        tally.add(&crowd);
        let sample = meter.measure(&crowd, f64::from(frame), &[camera.into()]);
        let far: Vec<_> = sample
            .characters
            .iter()
            .filter(|c| c.level == asset.levels())
            .collect();
        assert!(far.len() > 40);
        for error in far {
            assert!(error.p95_px <= 1.05 && error.worst_px <= 2.1, "{error:?}");
            assert!(error.p95_px > 0.0);
        }
        samples.push(sample);
    }
    let levels = tally.levels(asset, &samples);
    let tier = levels.last().unwrap();
    assert!(tier.is_impostor && tier.joints == 0 && tier.characters > 40.0);
    assert_eq!(tier.renderer.impostor_bytes, 8.0 * tier.characters);
    assert_eq!(tier.renderer.skinned_vertices, 4.0 * tier.characters);
}

/// The human with the impostors of a table.
fn with_table(json: &str) -> articula::Result<CrowdAsset> {
    let options = CrowdOptions {
        pose_cache: true,
        baked_impostors: Some(BakedImpostors::read(json.as_bytes())?),
        ..CrowdOptions::default()
    };
    CrowdAsset::new(&Figure::new(human())?, &options, &Executor::default())
}

#[test]
fn the_table_of_an_atlas_shows_the_same_as_baking_anew() {
    let chosen = asset_with_impostors();
    let read = with_table(&chosen.impostors().unwrap().to_json("atlas.png")).unwrap();
    let mut crowds = [chosen, &read].map(|asset| CrowdPlayer::new(asset, 40).unwrap());
    let camera = Camera::looking_at(Vec3::Y * 40.0, Vec3::NEG_Z * 300.0, Viewport::default());
    let mut shown = 0;
    for frame in 0..10 {
        let mut draws = Vec::new();
        for crowd in &mut crowds {
            for i in 0..40 {
                crowd.place(i, Vec3::new(i as f32, 0.0, -30.0 * i as f32), i as f32);
                if frame == 0 {
                    crowd.play(i, i % chosen.clips().len(), 0.21 * i as f32);
                }
            }
            let views = [View::of(&camera)];
            crowd.plan(0.13, Culling::Views(&views), &mut |_| ());
            crowd.evaluate();
            draws.push(crowd.impostors().to_vec());
        }
        assert_eq!(draws[0], draws[1]);
        shown += draws[0].len();
    }
    assert!(shown > 50, "{shown}");
}

#[test]
fn tables_of_others_are_refused() {
    let plan = asset_with_impostors().impostors().unwrap();
    let json = plan.to_json("atlas.png");
    let said = |json: &str| with_table(json).unwrap_err().to_string();
    let first = &plan.clips[0];
    let [name, secs] = [
        format!("\"name\":\"{}\"", first.name),
        format!("\"duration_secs\":{}", first.duration_secs),
    ];
    for (from, to, part) in [
        (
            "\"version\":1",
            "\"version\":2",
            "articula-impostor 2 is not",
        ),
        ("\"first_pose\":0", "\"first_pose\":1", "first_pose"),
        ("\"from_secs\":[0,", "\"from_secs\":[-1,", "from_secs"),
        ("\"error_m\":0", "\"error_m\":-0", "error_m"),
        (&secs, "\"duration_secs\":77", "of 77 s"),
        ("\"clips\":[", "\"clips\":[5", "line"),
    ] {
        let changed = json.replacen(from, to, 1);
        assert_ne!(changed, json, "{from}");
        let text = said(&changed);
        assert!(text.contains(part), "{text}");
    }
    // Clips that it does not show have none.
    let other = json.replacen(&name, "\"name\":\"unknown\"", 1);
    match plan.clips.len() {
        1 => assert!(said(&other).contains("unknown")),
        _ => assert!(with_table(&other).is_ok()),
    }
}
