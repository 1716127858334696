//! The 2D section of the demo: the clip as pictures that play without 3D.

use super::Folder;
use crate::commands::flatten::report::{FlattenReport, Made};
use crate::console::Console;
use articula::core::Viewport;
use articula::evaluate::EvaluatedClip;
use articula::flat::flatten::{PrepareClipOptions, Profile, Quality, Settings};
use articula::flat::planar::Shading;
use articula::flat::vector::ThesisSvgOptions;
use articula::flat::vector::player::PlayerOutput;
use articula::flatten::{FramedCharacter, Shot, TriangleCount, flatten};

/// Side of the pictures in pixels.
const SIDE: u32 = 360;

/// Converts the clip to the thesis' form, then to the others.
pub(super) fn of(
    folder: &Folder<'_>,
    scene: &EvaluatedClip<'_>,
    console: &Console,
) -> anyhow::Result<Vec<FlattenReport>> {
    let shot = Shot {
        clip: Some(scene.clip),
        still_at: None,
        cycles: 1,
        fps: 25.0,
        yaw_deg: 30.0,
        pitch_deg: 5.0,
        turn_deg: 0.0,
        viewport: Viewport {
            width_px: SIDE as f32,
            height_px: SIDE as f32,
            fov_y_radians: 25.0f32.to_radians(),
        },
        triangles: TriangleCount::About(1000),
    };
    let framed = console.work(|work| FramedCharacter::new(scene.figure, shot, work))?;
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
        let flat = console.work(|work| flatten(&framed, options, &settings, work))?;
        folder.write(file, &flat.bytes)?;
        let made = Made {
            triangles_of_character: scene.figure.asset.mesh.triangles.len(),
            framed: &framed,
            size_px: (SIDE, SIDE),
            max_bytes: None,
        };
        reports.push(FlattenReport::new(file.into(), &flat, made));
    }
    Ok(reports)
}
