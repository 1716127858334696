//! Poses and skins one character, frame by frame, in its first clip.

use articula::{Figure, PosedMesh, Result, SkinnedMesh, Wrap, fs, reference_human, sample_morphs};

fn main() -> Result<()> {
    let mut files = std::env::args().skip(1);
    let opened = files.next().map_or_else(reference_human, fs::open)?;
    let figure = Figure::new(opened)?;
    let (rig, mesh) = (&figure.asset.rig, &figure.asset.mesh);
    let mut hero = PosedMesh::new(rig, mesh);
    let mut skin = SkinnedMesh::new(mesh);
    let mut morphs = mesh.morph_weights.clone();
    for frame in 0..120 {
        let secs = f64::from(frame) / 60.0;
        hero.pose(rig.rest_pose());
        if let Some(clip) = figure.asset.clips.first() {
            sample_morphs(clip, secs, Wrap::Loop, &mut morphs);
            hero.pose_at(clip, secs, Wrap::Loop);
        }
        hero.skin(&morphs, &mut skin);
        eprintln!("{secs:.2} s: the skin lies within {:?}", skin.bounds());
    }
    Ok(())
}
