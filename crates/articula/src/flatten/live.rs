//! A character whose morph targets are driven by the host page while a clip plays.

use super::expressions::expressions;
use super::framed::FramedCharacter;
use crate::error::{Context, Error, Result};
use articula_flat::planar::bake_shapes;
use articula_flat::portrait::{Head, PortraitClip};
use articula_flat::vector::player::LiveSource;
use glam::Vec3;

/// Projects the shape of every expression with a camera; each becomes an input.
pub(super) fn live_source(framed: &FramedCharacter<'_>) -> Result<LiveSource> {
    let (figure, clip) = (framed.figure(), framed.shot().clip);
    let asset = &figure.asset;
    let all = expressions(figure);
    if all.is_empty() {
        let what = "the file has no morph target to control; give a face with morph targets";
        return Err(Error::unsuited(what)).context(figure.opened.name());
    }
    let rest = &asset.mesh.morph_weights;
    let mut shapes = vec![rest.clone()];
    for expression in &all {
        let mut shape = rest.clone();
        for (slot, weight) in &expression.morphs {
            shape[usize::from(*slot)] += weight;
        }
        shapes.push(shape);
    }
    let mut options = framed.options.clone();
    let mut weights = Vec::new();
    if let Some(clip) = clip.map(|c| &asset.clips[c]) {
        let head = Head::Whole { pivot: Vec3::ZERO };
        let sampled = PortraitClip::sample(clip, &asset.rig, rest, &head, &all);
        options.fps = sampled.rate_hz;
        weights = sampled.weights;
    }
    let shapes =
        bake_shapes(&framed.subject(), &shapes, &options).with_context(|| figure.opened.name())?;
    Ok(LiveSource {
        shapes: framed.textured(shapes, &framed.subject())?,
        inputs: all.into_iter().map(|e| e.name).collect(),
        weights,
    })
}
