//! From 3D to 2D: an animated character as vector graphics, or its face as a portrait.
//!
//! [`flatten()`] is the complete conversion, [`portrait()`] that of a head; [`FramedCharacter`] and [`FramedHead`] give access to
//! the intermediate steps.

mod alternatives;
mod expressions;
mod eyes;
mod features;
mod framed;
mod head;
mod inputs;
mod judged;
mod levels;
mod live;
mod mouth;
mod portrait;
mod report;
mod shown_clip;
mod surfaces;

pub use alternatives::{AlternativeMeshes, alternative_meshes};
pub use framed::{
    FramedCharacter, FramedParts, LEAST_TRIANGLES, LEAST_TRIANGLES_OF_PLAYER, Shot, TriangleCount,
};
pub use head::FramedHead;
pub use judged::{DETAIL_DELTA_E, FACE_DELTA_E, REST_DELTA_E, RegionWeights, TriedTriangles};
pub use mouth::TeethAndTongue;
pub use portrait::{PortraitReport, PortraitShot, YawError, portrait, portrait_errors};
pub use report::{
    BytesPerTriangle, DetailDifference, FlatBytes, FlatErrors, FlatSettings, FlatTexture,
    FlattenReport, LocalDifference, RepresentationReport, TriangleChoice, TriedCount,
    TriedSettings, WorstByPart,
};
pub use shown_clip::shown_clip;
pub use surfaces::surfaces_shown_otherwise;

use crate::error::{Context, Result};
use crate::work::Executor;
use articula_core::Progress;
use articula_flat::flatten::{
    Flattened, PrepareClipOptions, PreparedClip, ReferenceFrames, Settings, SourceTime,
    dropped_detail, flatten as write, flatten_live, sampled_frames,
};
use articula_flat::planar::{OrderOptions, PlanarClip};
use articula_flat::vector::player::LiveSource;

/// Fewest triangles that a byte budget leads to.
const FEWEST: usize = 50;

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
    // Shapes are switched halfway between frames, where either state is right.
    let whole: Vec<f64> = frames
        .iter()
        .copied()
        .filter(|f| f.fract() == 0.0)
        .collect();
    let source = framed.source_frames(&framed.times(&whole))?;
    let sampled = PlanarClip {
        texture: clip.texture.clone(),
        ..framed.at_frames(&frames)?
    };
    let truth = ReferenceFrames::new(&sampled, &frames)
        .with_context(name)?
        .with_source(source);
    let prepared = work
        .with_progress("computing the painting order", |p| {
            PreparedClip::new(clip, &options, p)
        })
        .with_context(name)?;
    let flat = work
        .with_progress("writing", |p| write(&prepared, settings, &truth, p))
        .with_context(name)?;
    detailed(framed, flat)
}

/// A framed character, ready to be written.
#[cfg(feature = "item")]
pub(crate) fn prepared(
    framed: &FramedCharacter<'_>,
    options: &PrepareClipOptions,
    work: &Executor<'_>,
) -> Result<PreparedClip> {
    work.step("projecting", 0, 1)?;
    let clip = framed.clip()?;
    work.with_progress("computing the painting order", |p| {
        PreparedClip::new(clip, options, p)
    })
    .with_context(|| framed.name())
}

/// Adds the painted detail that the vertex colours do not show.
fn detailed(framed: &FramedCharacter<'_>, mut flat: Flattened) -> Result<Flattened> {
    let (times, shading) = (framed.judged_times(), flat.quality.shading);
    if flat.texture.is_some() {
        return Ok(flat);
    }
    let subject = framed.subject();
    flat.dropped_detail =
        dropped_detail(&subject, framed.regions(), &times, &framed.options, shading)
            .with_context(|| framed.name())?;
    Ok(flat)
}

/// As [`flatten()`], and if not even the coarsest quality keeps the byte budget, again with half as
/// many triangles, down to 50, unless the number was given ([`TriangleCount::About`]).
///
/// # Errors
/// As [`flatten()`].
pub fn flatten_within<'a>(
    mut framed: FramedCharacter<'a>,
    options: &PrepareClipOptions,
    settings: &Settings,
    work: &Executor<'_>,
) -> Result<(FramedCharacter<'a>, Flattened)> {
    let mut flat = flatten(&framed, options.clone(), settings, work)?;
    while flat.bytes_over.is_some() && framed.may_coarsen() {
        let fewer = framed.with_triangles((framed.triangles.len() / 2).max(FEWEST))?;
        if fewer.triangles.len() >= framed.triangles.len() {
            break;
        }
        let next = flatten(&fewer, options.clone(), settings, work)?;
        if next.sizes.raw >= flat.sizes.raw {
            break;
        }
        (framed, flat) = (fewer, next);
    }
    Ok((framed, flat))
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
    let times: Vec<SourceTime> = frames
        .iter()
        .zip(&moments)
        .filter(|(frame, _)| frame.fract() == 0.0)
        .map(|(frame, secs)| SourceTime {
            frame: *frame,
            secs: *secs,
        })
        .collect();
    let pictures = framed.source_frames(&times)?;
    let sampled = PlanarClip {
        texture: source.shapes.texture.clone(),
        ..framed.at(&moments)?
    };
    let truth = ReferenceFrames::new(&sampled, &frames)
        .with_context(|| framed.name())?
        .with_source(pictures);
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
    let flat = work
        .with_progress("writing", |p| {
            flatten_live(&source, &shapes, settings, &truth, p)
        })
        .with_context(|| framed.name())?;
    detailed(framed, flat)
}
