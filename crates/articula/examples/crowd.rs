//! Plays 1000 instances of one character, with motions from further files retargeted to it.

use articula::crowd::{Camera, CrowdAsset, CrowdOptions, CrowdPlayer, Viewport};
use articula::{AddClipsOptions, Executor, Figure, Result, fs, glam::Vec3, reference_human};

fn main() -> Result<()> {
    let mut files = std::env::args().skip(1);
    let mut opened = files.next().map_or_else(reference_human, fs::open)?;
    let motions = files.map(fs::open).collect::<Result<Vec<_>>>()?;
    opened.add_clips(&motions, &AddClipsOptions::default(), &Executor::default())?;
    let figure = Figure::new(opened)?;
    let asset = CrowdAsset::new(&figure, &CrowdOptions::default(), &Executor::default())?;
    let mut crowd = CrowdPlayer::new(&asset, 1000)?;
    for i in 0..1000 {
        let place = Vec3::new((i % 40) as f32, 0.0, (i / 40) as f32);
        crowd.place(i, 2.0 * place, 0.0);
        crowd.play(i, i % asset.clips().len(), 0.37 * i as f32);
    }
    let eye = Vec3::new(39.0, 1.7, -6.0);
    let camera = Camera::looking_at(eye, eye + Vec3::Z, Viewport::default());
    for _ in 0..120 {
        let report = crowd.frame(1.0 / 60.0, &camera);
        let draws = crowd.draws().count(); // one instanced draw each: mesh, characters, poses
        eprintln!("{} visible in {draws} draws", report.visible);
    }
    Ok(())
}
