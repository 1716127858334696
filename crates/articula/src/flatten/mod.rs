//! From 3D to 2D: an animated character as vector graphics, or its face as a portrait.
//!
//! [`flatten()`] is the complete conversion; [`FramedCharacter`] and [`FramedHead`] give access to
//! the intermediate steps.

mod expressions;
mod framed;
mod head;
mod live;

pub use framed::{FramedCharacter, FramedParts, Shot};
pub use head::FramedHead;

use crate::error::{Context, Result};
use crate::work::Executor;
use articula_core::Progress;
use articula_flat::flatten::{
    Flattened, PrepareClipOptions, PreparedClip, ReferenceFrames, Settings, flatten as write,
    flatten_live, sampled_frames,
};
use articula_flat::planar::OrderOptions;
use articula_flat::vector::player::LiveSource;

/// Converts a framed character to vector graphics: projects, sorts by painting order, and writes
/// the file.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file and what cannot be converted, or
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub fn flatten(
    framed: &FramedCharacter<'_>,
    options: PrepareClipOptions,
    settings: &Settings,
    work: &Executor<'_>,
) -> Result<Flattened> {
    let name = || framed.name();
    work.step("projecting", 0, 1)?;
    let clip = framed.clip()?;
    let frames = sampled_frames(clip.frames.len());
    let truth = ReferenceFrames::new(&framed.at_frames(&frames)?, &frames).with_context(name)?;
    let prepared = work
        .with_progress("computing the painting order", |p| {
            PreparedClip::new(clip, &options, p)
        })
        .with_context(name)?;
    work.with_progress("writing", |p| write(&prepared, settings, &truth, p))
        .with_context(name)
}

/// Converts a framed character to a file whose morph targets the host page drives while the clip
/// plays.
///
/// # Errors
/// As [`flatten()`], and if the character has no morph target.
pub fn flatten_driven(
    framed: &FramedCharacter<'_>,
    options: PrepareClipOptions,
    settings: &Settings,
    work: &Executor<'_>,
) -> Result<Flattened> {
    let source = live::live_source(framed)?;
    let frames = sampled_frames(source.weights.len().max(1));
    let fps = f64::from(source.shapes.fps);
    let moments: Vec<f64> = frames.iter().map(|f| f / fps).collect();
    let truth =
        ReferenceFrames::new(&framed.at(&moments)?, &frames).with_context(|| framed.name())?;
    // Driven shapes share one painting order.
    let options = PrepareClipOptions {
        order: OrderOptions {
            max_epochs: 1,
            ..options.order
        },
        ..options
    };
    let shapes = PreparedClip::new(source.shapes, &options, &mut Progress::none());
    let shapes = shapes.with_context(|| framed.name())?;
    let source = LiveSource {
        shapes: shapes.clip.clone(),
        ..source
    };
    work.with_progress("writing", |p| {
        flatten_live(&source, &shapes, settings, &truth, p)
    })
    .with_context(|| framed.name())
}
