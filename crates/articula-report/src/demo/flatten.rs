//! The 2D section of the demo: the clip as pictures that play without 3D.

use super::files::DemoFiles;
use articula::core::Viewport;
use articula::evaluate::EvaluatedClip;
use articula::flat::flatten::{PrepareClipOptions, Profile, Quality, Settings};
use articula::flat::planar::Shading;
use articula::flat::vector::ThesisSvgOptions;
use articula::flat::vector::player::PlayerOutput;
use articula::flatten::{FlattenReport, FramedCharacter, Shot, TriangleCount, flatten};
use articula::{Executor, Result};

/// Side of the pictures in pixels.
const SIDE: u32 = 360;

/// Converts the clip to the thesis' form, then to the others.
pub(super) fn of(
    files: &mut DemoFiles,
    scene: &EvaluatedClip<'_>,
    work: &Executor<'_>,
) -> Result<Vec<FlattenReport>> {
    let shot = Shot {
        clip: Some(scene.clip),
        yaw_deg: 30.0,
        pitch_deg: 5.0,
        viewport: Viewport {
            width_px: SIDE as f32,
            height_px: SIDE as f32,
            ..Shot::default().viewport
        },
        triangles: TriangleCount::About(1000),
        ..Shot::default()
    };
    let framed = FramedCharacter::new(scene.figure, shot, work)?;
    let mut reports = Vec::new();
    for (file, profile, shading) in [
        (
            "walk-thesis.svg",
            Profile::Thesis(ThesisSvgOptions::default()),
            Shading::Flat,
        ),
        ("walk.svg", Profile::Smil, Shading::Gouraud),
        ("walk-flat.svg", Profile::Smil, Shading::Flat),
        (
            "walk-player.svg",
            Profile::Player(PlayerOutput::Svg),
            Shading::Gouraud,
        ),
        ("walk.json", Profile::Lottie, Shading::Gouraud),
    ] {
        let settings = Settings {
            profile,
            quality: Quality {
                shading,
                ..Quality::of(profile)
            },
            name: "walk".into(),
            max_bytes: None,
        };
        let options = PrepareClipOptions::default();
        let flat = flatten(&framed, options, &settings, work)?;
        reports.push(FlattenReport::new(file.into(), &flat, &framed, None));
        files.add(file, flat.bytes);
    }
    Ok(reports)
}
