//! One character walks away and comes back: its level of articulation falls and rises with its
//! distance, in transitions, while the walk goes on.

use articula::glam::Vec3;
use articula::playback::{
    FigureModel, FigurePlayer, FigureSkin, FigureViews, FullDetail, LoaController,
};
use articula::{Camera, Figure, GroupedSkin, LoaRange, Result, Viewport, fs, reference_human};

fn main() -> Result<()> {
    let file = std::env::args().nth(1);
    let figure = Figure::new(file.map_or_else(reference_human, fs::open)?)?;
    let (rig, mesh) = (&figure.asset.rig, &figure.asset.mesh);
    let model = FigureModel::new(rig.clone(), &figure.asset.clips[..])?;
    let mut hero = FigurePlayer::new(model, &mesh.morph_weights);
    let levels = LoaRange::named(rig, 0);
    let mut loa = LoaController::new(rig, levels, Default::default(), FullDetail::default());
    let mut skin = FigureSkin::new(mesh.clone(), GroupedSkin::new(mesh));
    for frame in 0..240i32 {
        let metres = 14.0 - 0.1 * (frame - 120).abs() as f32;
        loa.request((metres / 2.2) as usize);
        let camera = Camera::looking_at(metres * Vec3::Z, Vec3::Y, Viewport::default());
        hero.advance(1.0 / 60.0, &mut |_| {});
        let report = *hero.control(&mut loa, FigureViews::Cameras(&[camera]));
        hero.hierarchy();
        let vertices = skin.skin(hero.model_pose(), hero.morph_weights());
        let (joints, changing) = (report.sampled.len(), report.in_transition.len());
        let level = loa.level();
        eprintln!(
            "{metres:4.1} m: level {level}, {joints} joints, {changing} in transition, {vertices} vertices"
        );
    }
    Ok(())
}
