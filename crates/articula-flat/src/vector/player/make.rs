//! Converts a planar clip to a file that plays it.
//!
//! Source: `docs/methods/vector.md` 8.3.

use super::clip::{PlayerClip, PlayerEpoch};
use super::container::{PartSizes, encode, encode_parts};
use super::fit::{Errors, Numbers, fit};
use super::page::{PlayerOutput, page, script};
use super::texture::PlayerTexture;
use super::topology::Topology;
use crate::error::PictureError;
use crate::low_rank::quantised::Quantised;
use crate::picture::Picture;
use crate::planar::shading::Shading;
use crate::planar::{Drawn, Epoch, Painting, PlanarClip, PlanarError};
use glam::Vec2;

/// Options of a player file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlayerOptions {
    /// RMS position tolerance of points, pixels.
    pub pos_tol_px: f64,
    /// RMS tolerance of light, levels.
    pub col_tol_levels: f64,
    /// Shading of the triangles.
    pub shading: Shading,
    /// Kind of file.
    pub output: PlayerOutput,
}

impl Default for PlayerOptions {
    fn default() -> Self {
        Self {
            pos_tol_px: 0.1,
            col_tol_levels: 1.0,
            shading: Shading::Gouraud,
            output: PlayerOutput::Svg,
        }
    }
}

/// Qualities of the picture that triangles show, from the usual one on.
const PICTURE_QUALITIES: [u8; 3] = [75, 80, 70];

/// Statistics of a written player file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlayerStats {
    /// Triangles that are drawn in some frame.
    pub triangles: usize,
    /// Number of components.
    pub rank: usize,
    /// RMS distance of points over all frames, pixels.
    pub position_rmse_px: f64,
    /// RMS error of light over all frames, levels; 0 with flat shading, whose light is constant.
    pub light_rmse_levels: f64,
    /// Sizes of the container's parts before compression, bytes.
    pub parts: PartSizes,
    /// Size of the script, bytes.
    pub script: usize,
}

/// A file that plays a clip.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlayerFile {
    /// The SVG or module.
    pub text: String,
    /// The container inside it.
    pub container: Vec<u8>,
    /// Statistics.
    pub stats: PlayerStats,
}

/// Writes a clip within the tolerances as a file that plays it.
///
/// O(frames x vertices x components), with a large factor: some hundred passes.
///
/// # Errors
/// Errors of the clip, or [`PlanarError::Mismatch`]: `drawn` or `painting` of another clip,
/// tolerances below a thousandth, or a clip with too many numbers.
pub(crate) fn player(
    clip: &PlanarClip,
    drawn: &Drawn,
    painting: &Painting,
    options: &PlayerOptions,
) -> Result<PlayerFile, PlanarError> {
    let allowed = allowed(options)?;
    let (mut made, topology) = still_parts(clip, drawn, painting, options.shading)?;
    let numbers = Numbers::new(clip, &topology, options.shading, allowed.light_weight())?;
    made.light_weight = numbers.light_weight;
    made.motion = fit(&numbers, &allowed, |motion| {
        let tried = PlayerClip {
            motion: motion.clone(),
            ..made.clone()
        };
        encode(&tried).len()
    })?;
    let errors = numbers.errors(&made.motion);
    finish(&made, &errors, options.output)
}

/// Checks the tolerances.
pub(super) fn allowed(options: &PlayerOptions) -> Result<Errors, PlanarError> {
    for (at, value) in [
        ("pos_tol_px", options.pos_tol_px),
        ("col_tol_levels", options.col_tol_levels),
    ] {
        if !(value.is_finite() && value >= 1e-3) {
            let what = format!("{value}, expected at least 0.001");
            return Err(PlanarError::Mismatch { at, what });
        }
    }
    Ok(Errors {
        position_px: options.pos_tol_px,
        light_levels: options.col_tol_levels,
    })
}

/// Text and statistics of a finished clip.
///
/// # Errors
/// [`PlanarError::Picture`] if the first frame cannot be drawn.
pub(super) fn finish(
    made: &PlayerClip,
    errors: &Errors,
    output: PlayerOutput,
) -> Result<PlayerFile, PlanarError> {
    let (container, parts) = encode_parts(made);
    Ok(PlayerFile {
        text: page(made, &container, output)?,
        container,
        stats: PlayerStats {
            triangles: made.triangles.len(),
            rank: made.motion.components.len(),
            position_rmse_px: errors.position_px,
            light_rmse_levels: errors.light_levels,
            parts,
            script: script(made).len(),
        },
    })
}

/// The clip without its motion.
pub(super) fn still_parts(
    clip: &PlanarClip,
    drawn: &Drawn,
    painting: &Painting,
    shading: Shading,
) -> Result<(PlayerClip, Topology), PlanarError> {
    clip.check()?;
    drawn.fits(clip)?;
    let epochs = &painting.epochs;
    let ends = std::iter::once(0).chain(epochs.iter().map(|e| e.frames.end));
    let joined = epochs
        .iter()
        .zip(ends)
        .all(|(e, end)| e.frames.start == end && !e.frames.is_empty());
    let whole = epochs
        .last()
        .is_some_and(|e| e.frames.end == clip.frames.len());
    let all: Vec<u32> = epochs
        .iter()
        .flat_map(|e| e.order.iter().copied())
        .collect();
    let within = all.iter().all(|t| (*t as usize) < clip.triangles.len());
    if !(joined && whole && within) {
        let (at, what) = (
            "painting",
            "the painting orders must cover all frames of the clip, and its triangles only"
                .to_owned(),
        );
        return Err(PlanarError::Mismatch { at, what });
    }
    let topology = Topology::new(clip, drawn, &all, shading);
    if topology.triangles.is_empty() {
        return Err(PlanarError::NothingVisible);
    }
    let mut numbers = vec![None; clip.triangles.len()];
    for (number, source) in topology.sources.iter().enumerate() {
        numbers[*source as usize] = Some(number as u32);
    }
    let epoch = |epoch: &Epoch| PlayerEpoch {
        first_frame: epoch.frames.start as u32,
        order: epoch
            .order
            .iter()
            .filter_map(|t| numbers[*t as usize])
            .collect(),
    };
    let spans = |t: &u32| {
        let spans = drawn.spans(*t as usize).into_iter();
        spans.map(|s| s.start as u32..s.end as u32).collect()
    };
    let made = PlayerClip {
        width: clip.width,
        height: clip.height,
        fps: clip.fps,
        frames: clip.frames.len() as u32,
        shading,
        light_weight: 1.0,
        colors: colors(clip, drawn, &topology, shading),
        shown: topology.sources.iter().map(spans).collect(),
        epochs: epochs.iter().map(epoch).collect(),
        triangles: topology.triangles.clone(),
        wedge_points: topology.wedge_points.clone(),
        motion: Quantised {
            step: 1.0,
            mean: Vec::new(),
            components: Vec::new(),
        },
        inputs: Vec::new(),
        texture: texture(clip, &topology, shading)?,
    };
    Ok((made, topology))
}

/// The picture that the clip's triangles show; `None` if none of those that are drawn does.
///
/// # Errors
/// [`PlanarError::Picture`] if it cannot be encoded.
fn texture(
    clip: &PlanarClip,
    topology: &Topology,
    shading: Shading,
) -> Result<Option<PlayerTexture>, PlanarError> {
    let wanted = clip
        .texture
        .as_ref()
        .filter(|_| shading == Shading::Gouraud);
    let Some(texture) = wanted else {
        return Ok(None);
    };
    let sources = topology.sources.iter();
    let shows: Vec<bool> = sources.map(|t| texture.shows[*t as usize]).collect();
    if !shows.contains(&true) {
        return Ok(None);
    }
    let mut places = vec![Vec2::ZERO; topology.wedge_vertices.len()];
    for (corners, _) in topology.triangles.iter().zip(&shows).filter(|(_, s)| **s) {
        for wedge in corners.map(|w| w as usize) {
            places[wedge] = texture.places[topology.wedge_vertices[wedge] as usize];
        }
    }
    let file = picture_file(&texture.picture)?;
    let made = PlayerTexture::new(file, shows, places.into_iter());
    made.map(Some).map_err(|e| PlanarError::Mismatch {
        at: "texture",
        what: e.to_string(),
    })
}

/// A picture as a file: lossy, or without loss if no quality gives a file that can be decoded. The
/// encoder fails for some pictures.
fn picture_file(picture: &Picture) -> Result<Vec<u8>, PictureError> {
    let lossy = PICTURE_QUALITIES.into_iter().find_map(|quality| {
        let file = picture.to_webp(quality).ok()?;
        Picture::decode(&file).is_ok().then_some(file)
    });
    lossy.map_or_else(|| picture.to_lossless_webp(), Ok)
}

/// Albedo of wedges, or mean colours of triangles over the frames in which they are drawn.
fn colors(clip: &PlanarClip, drawn: &Drawn, topology: &Topology, shading: Shading) -> Vec<[u8; 3]> {
    let levels = |color: [f32; 3]| color.map(|level| level.round().clamp(0.0, 255.0) as u8);
    let mean = |t: &u32| {
        let mut sum = [0.0f32; 3];
        let mut count = 0.0f32;
        for f in drawn.spans(*t as usize).into_iter().flatten() {
            for v in clip.triangles[*t as usize] {
                let color = clip.color(f, v);
                sum = [0, 1, 2].map(|k| sum[k] + color[k]);
                count += 1.0;
            }
        }
        levels(sum.map(|s| s / count.max(1.0)))
    };
    match shading {
        Shading::Gouraud => {
            let vertices = topology.wedge_vertices.iter();
            let albedo = vertices.map(|v| levels(clip.albedo[*v as usize]));
            repeated(albedo, &topology.needs_color(clip))
        }
        Shading::Flat => topology.sources.iter().map(mean).collect(),
    }
}

/// The colours, where those that no triangle shows repeat the last new one, which takes no bytes.
fn repeated(colors: impl Iterator<Item = [u8; 3]>, is_needed: &[bool]) -> Vec<[u8; 3]> {
    let mut known = std::collections::BTreeSet::new();
    let mut last = [0; 3];
    let shown = colors.zip(is_needed).map(|(color, is_needed)| {
        let color = if *is_needed { color } else { last };
        if known.insert(color) {
            last = color;
        }
        color
    });
    shown.collect()
}
