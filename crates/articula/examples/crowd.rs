//! A crowd of a thousand of your own character, culled and reduced before a camera that drives by:
//! `cargo run --release -p articula --example crowd -- my.glb [walk.bvh …]`; motions of other files
//! are put onto it. Without a path it is a crowd of the reference human.
#![allow(clippy::print_stdout, reason = "an example may say what it does")]

use articula::crowd::{Camera, CrowdAsset, CrowdOptions, CrowdPlayer, Viewport};
use articula::{AddClipsOptions, Error, Figure, OpenOptions, Opened, Result, Work, fs, glam::Vec3};

fn main() -> Result<()> {
    let mut files = std::env::args().skip(1);
    let mut hero = files.next().map_or_else(reference_human, fs::open)?;
    for motion in files {
        let clips = [fs::open(motion)?];
        hero.add_clips(&clips, &AddClipsOptions::default(), &Work::default())?;
    }
    let figure = Figure::new(hero)?;
    let asset = CrowdAsset::new(&figure, &CrowdOptions::default(), &Work::default())?;
    for warning in asset.warnings() {
        println!("{warning}");
    }
    let mut crowd = CrowdPlayer::new(&asset, 1000)?;
    for i in 0..1000 {
        let place = Vec3::new((i % 40) as f32, 0.0, (i / 40) as f32) * 2.0;
        crowd.place(i, place, 0.0);
        crowd.play(i, i % asset.clips().len(), i as f32 * 0.37);
    }
    for frame in 0..600 {
        let eye = Vec3::new(0.13 * frame as f32, 1.7, -6.0);
        let target = eye + Vec3::new(0.0, -0.3, 10.0);
        let camera = Camera::looking_at(eye, target, Viewport::default());
        let report = crowd.frame(1.0 / 60.0, &camera);
        let mut joints = 0;
        for group in crowd.groups() {
            // Here a renderer makes one instanced draw of `group.mesh`; each of `group.draws`
            // names a character and where its matrices begin in `crowd.palettes()`.
            joints += group.draws.len() * asset.level(group.level).joints;
        }
        if frame % 60 == 0 {
            println!(
                "{:>2} s: {} visible with {joints} joints, at most {:.2} px off",
                frame / 60,
                report.visible,
                report.bound_px
            );
        }
    }
    Ok(())
}

/// The figure that is made rather than read, as a file in memory.
fn reference_human() -> Result<Opened> {
    use articula_human::{HumanOptions, human};
    let character = human(&HumanOptions::default()).map_err(|e| Error::Unsuited(e.to_string()))?;
    let glb = articula_formats::gltf::Document::from_character(&character)?.write_glb()?;
    let nothing_beside: &mut articula_formats::Resolver<'_> = &mut |_| Err("nothing".into());
    articula::open(
        &glb,
        "reference human",
        &OpenOptions::default(),
        nothing_beside,
    )
}
