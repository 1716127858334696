//! The artist of a prepared character, and the morph weights of what is played.

use articula::{Figure, facing};
use articula_build::evaluate::Stage;
use articula_core::{ModelPose, Wrap, local_to_model, sample_morphs};
use articula_flat::Appearance;
use articula_report::Artist;

/// An artist whose pictures have a size in pixels.
pub(crate) fn artist(figure: &Figure, size: (u32, u32)) -> Artist<'_> {
    let character = &figure.opened.character;
    let (look, _) = Appearance::new(&character.materials, &character.images);
    let asset = &figure.asset;
    let mut rest = ModelPose::new(asset.rig.len());
    local_to_model(&asset.rig, asset.rig.rest_pose(), &mut rest);
    let facing = facing(&asset.rig, &rest);
    Artist::new(&asset.rig, &asset.mesh, look, facing, size)
}

/// Morph weights at a frame of the stage's clip.
pub(crate) fn morphs(stage: &Stage<'_>, frame: usize) -> Vec<f32> {
    let mut weights = stage.asset.mesh.morph_weights.clone();
    let secs = frame as f64 / f64::from(stage.clip.rate_hz());
    sample_morphs(&stage.clip, secs, Wrap::Clamp, &mut weights);
    weights
}
