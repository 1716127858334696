//! A character whose morph targets a host drives: its shapes, and the clip that plays meanwhile.

use super::{Staged, expressions};
use crate::prepared::Prepared;
use anyhow::{Context, bail};
use articula_flat::planar::bake_shapes;
use articula_flat::portrait::{Head, PortraitClip};
use articula_flat::vector::player::LiveSource;
use glam::Vec3;

/// All expressions of a character as inputs, seen by a staged camera.
pub(crate) fn live_source(
    prepared: &Prepared,
    staged: &Staged<'_>,
    clip: Option<usize>,
) -> anyhow::Result<LiveSource> {
    let asset = &prepared.asset;
    let all = expressions(prepared);
    if all.is_empty() {
        let place = prepared.loaded.place();
        bail!("{place}: no morph target to drive; leave --live out, or give a face that has some");
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
    let mut options = staged.options.clone();
    let mut weights = Vec::new();
    if let Some(clip) = clip.map(|c| &asset.clips[c]) {
        let head = Head::Whole { pivot: Vec3::ZERO };
        let sampled = PortraitClip::sample(clip, &asset.rig, rest, &head, &all);
        options.fps = sampled.rate_hz;
        weights = sampled.weights;
    }
    Ok(LiveSource {
        shapes: bake_shapes(&staged.subject(), &shapes, &options)
            .with_context(|| prepared.loaded.place())?,
        inputs: all.into_iter().map(|e| e.name).collect(),
        weights,
    })
}
