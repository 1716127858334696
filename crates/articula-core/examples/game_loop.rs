//! A crowd in a game loop: from clips, positions, a camera and time to palettes and events.

use articula_build::ClipOptions;
use articula_build::character;
use articula_build::motion_bounds;
use articula_build::{JointLodOptions, merged_levels};
use articula_core::crowd::{ClipState, Crowd, CrowdModel, CrowdParts, Culling, DrawKind, Frame};
use articula_core::visibility::View;
use articula_core::{Camera, ClipSet, ClipStorage, PaletteRows, Viewport};
use articula_human::{HumanOptions, human};
use glam::{Quat, Vec3};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Once: levels, errors and bounds of one character. Files are read by articula-formats.
    let human = human(&HumanOptions::default())?;
    let asset = character(&human, None, &ClipOptions::default())?;
    let levels = merged_levels(&asset, &JointLodOptions::default())?;
    let clips = ClipSet::new(
        &asset.rig,
        levels.joint_lods,
        &asset.clips,
        ClipStorage::Float,
    )?;
    let bounds = motion_bounds(&asset, 0.0)?;
    let model = CrowdModel::new(CrowdParts::new(
        clips,
        levels.skins.palette,
        levels.errors,
        bounds,
    ))?;

    // A thousand characters on a square, each with its own clip and phase.
    let mut crowd = Crowd::new(&model, 1000);
    let positions: Vec<Vec3> = (0..1000)
        .map(|i| Vec3::new((i % 25) as f32, 0.0, -2.0 - (i / 25) as f32))
        .collect();
    let rotations = vec![Quat::IDENTITY; 1000];
    for i in 0..1000 {
        let clip_state = ClipState::new(&model.parts().clips, i % asset.clips.len());
        crowd.play(
            i,
            clip_state
                .at_secs(&model.parts().clips, i as f32 * 0.37)
                .into(),
        );
    }

    let mut palettes =
        vec![[0.0; 4]; 1000 * model.parts().palette.len(0) * model.parts().form.rows()];
    let mut scratch = model.evaluator().scratch();
    for step in 0..120 {
        let eye = Vec3::new(12.0, 1.7, 2.0 - step as f32 * 0.05);
        let camera = Camera::looking_at(eye, Vec3::new(12.0, 1.0, -20.0), Viewport::default());
        let frame = Frame {
            dt_secs: 1.0 / 60.0,
            positions: &positions,
            rotations: &rotations,
            culling: Culling::Views(&[View::of(&camera)]),
            ..Frame::default() // an error of one pixel; any character may have moved
        };
        let report = crowd.tick(
            &model,
            &frame,
            &mut |_notice| { /* footsteps, level changes */ },
        );
        let rows = crowd.draw_list().matrices * model.parts().form.rows();
        let all = 0..crowd.draw_list().batches; // or ranges of them, one for each thread
        crowd.evaluate(
            &model,
            all,
            PaletteRows::Float(&mut palettes[..rows]),
            &mut scratch,
        );
        for group in crowd.draw_list().groups_of(DrawKind::Palette) {
            // One instanced draw: the mesh of group.level, instances crowd.draw_list().draws[group.range].
            let _instances = &crowd.draw_list().draws[group.range.clone()];
        }
        if step % 60 == 0 {
            let joints = report.work.fk_joints as f32 / report.visible.max(1) as f32;
            let (seen, most) = (report.visible, report.bound_px);
            eprintln!("{seen} visible, {joints:.1} joints each, at most {most:.2} px off");
        }
    }
    Ok(())
}
