//! One figure: its skin, posed by its first clip.

use articula::{Figure, PosedMesh, SkinnedMesh, Wrap, sample_morphs};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("name a character: my.glb")?;
    let figure = Figure::new(articula::fs::open(path)?)?;
    let (rig, mesh) = (&figure.asset.rig, &figure.asset.mesh);
    let mut hero = PosedMesh::new(rig, mesh);
    let mut skin = SkinnedMesh::new(mesh);
    let mut morphs = mesh.morph_weights.clone();
    for frame in 0..=120 {
        let secs = f64::from(frame) / 60.0;
        // Without a clip the figure stands at rest.
        if let Some(clip) = figure.asset.clips.first() {
            sample_morphs(clip, secs, Wrap::Loop, &mut morphs);
            hero.pose_at(clip, secs, Wrap::Loop)
                .skin(&morphs, &mut skin);
        } else {
            hero.pose(rig.rest_pose()).skin(&morphs, &mut skin);
        }
        if let (0, Some((low, high))) = (frame % 30, skin.bounds()) {
            println!(
                "{secs:.1} s: {} vertices from {low:.2} to {high:.2} m",
                mesh.len()
            );
        }
    }
    Ok(())
}
