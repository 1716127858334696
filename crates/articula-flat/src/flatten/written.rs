//! A file of a profile, and what it shows at any moment.
//!
//! What is measured is read back from the file wherever a reader of our own exists: the sampler
//! for SVG, the decoder for the player. Lottie has players of its own; what its file holds is the
//! keyed clip, which is measured as SVG. The thesis' form is drawn from what it was made of.

use super::pages::pages;
use super::prepared::PreparedClip;
use super::reference_frames::BACKGROUND;
use super::settings::{Profile, Quality};
use crate::item_buffer::Supersampling;
use crate::picture::Picture;
use crate::planar::PlanarError;
use crate::planar::key_frames::{KeyOptions, keyed};
use crate::planar::keyed_clip::LineUnits;
use crate::planar::reference::reference;
use crate::planar::underlap::{UnderlapOptions, seal};
use crate::vector::AnimatedSvg;
use crate::vector::flipbook::flipbook;
use crate::vector::lottie;
use crate::vector::player::{PlayerClip, PlayerOptions, decode, player};
use crate::vector::raster;
use crate::vector::smil;
use crate::vector::still::{StillOptions, still};
use crate::vector::thesis::{ThesisSvgOptions, thesis, thesis_frame};

/// What was written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Written {
    /// The file.
    pub bytes: Vec<u8>,
    /// Root mean square distance of corners from where they should be, pixels.
    pub position_rmse_px: f64,
    /// Keys of outlines and paints in all; 0 where there are none.
    pub keys: usize,
    /// Shapes that were written.
    pub shapes: usize,
    /// Frames that are in it.
    pub frames: usize,
    /// Triangles that it shows in some frame.
    pub triangles_drawn: usize,
    shown: ReadBack,
}

/// What reads the file back.
#[derive(Debug, Clone, PartialEq)]
enum ReadBack {
    Moving(Box<AnimatedSvg>),
    Player(Box<PlayerClip>),
    Still(String),
    Naive(ThesisSvgOptions),
}

/// Half a step of the grid that outlines lie on, as the root mean square of rounding both
/// coordinates, pixels.
const GRID_RMSE_PX: f64 = 0.25 * 0.408_248;

/// How much further edges reach under their neighbours for each pixel that corners may lie off.
const SLACK: f32 = 1.0;

/// Writes a prepared clip.
///
/// # Errors
/// What a writer says of the clip ([`PlanarError`]).
pub(super) fn write(
    prepared: &PreparedClip,
    profile: Profile,
    quality: &Quality,
    name: &str,
) -> Result<Written, PlanarError> {
    match profile {
        Profile::Smil => key_framed(prepared, quality, name, false),
        Profile::Lottie => key_framed(prepared, quality, name, true),
        Profile::Flipbook => paged(prepared, quality, name),
        Profile::Player(output) => {
            let options = PlayerOptions {
                pos_tol_px: f64::from(quality.pos_tol_px),
                col_tol_levels: f64::from(quality.col_tol_levels),
                shading: quality.shading,
                output,
            };
            played(prepared, &options)
        }
        Profile::Still { frame, exact } => one_frame(prepared, quality, frame, exact),
        Profile::Thesis(options) => naive(prepared, options),
    }
}

impl Written {
    /// The picture at a moment, in frames.
    ///
    /// # Errors
    /// [`PlanarError::Picture`] if it cannot be drawn.
    pub(super) fn picture(
        &self,
        prepared: &PreparedClip,
        frame: f64,
    ) -> Result<Picture, PlanarError> {
        let secs = frame / f64::from(prepared.clip.fps);
        Ok(match &self.shown {
            ReadBack::Moving(moving) => raster(&moving.at(secs)?, BACKGROUND)?,
            ReadBack::Still(text) => raster(text, BACKGROUND)?,
            ReadBack::Player(clip) => {
                reference(&clip.painted(frame), 0, Supersampling::Four, BACKGROUND)?
            }
            ReadBack::Naive(options) => {
                let still = thesis_frame(&prepared.clip, options, frame)?;
                raster(&still, BACKGROUND)?
            }
        })
    }
}

fn key_options(quality: &Quality, lines: LineUnits) -> KeyOptions {
    KeyOptions {
        shading: quality.shading,
        pos_tol_px: quality.pos_tol_px,
        col_tol_levels: quality.col_tol_levels,
        lines,
        merge_levels: quality.merge_levels,
    }
}

fn key_framed(
    prepared: &PreparedClip,
    quality: &Quality,
    name: &str,
    is_lottie: bool,
) -> Result<Written, PlanarError> {
    let PreparedClip {
        clip,
        drawn,
        layers,
        ..
    } = prepared;
    let lines = if is_lottie {
        LineUnits::Grid
    } else {
        LineUnits::Box
    };
    let options = key_options(quality, lines);
    // Corners of both sides of an edge may lie off, in opposite directions.
    let underlap = UnderlapOptions {
        distance_px: prepared.underlap.distance_px + SLACK * quality.pos_tol_px,
    };
    let sealed = seal(clip, drawn, &prepared.painting, underlap);
    let (keyed, stats) = keyed(clip, drawn, layers, &sealed, &options)?;
    let text = smil(&keyed, name)?;
    let moving = Box::new(AnimatedSvg::read(&text)?);
    let bytes = if is_lottie {
        lottie(&keyed, name)?.into_bytes()
    } else {
        text.into_bytes()
    };
    Ok(Written {
        bytes,
        // The distance, not x or y alone.
        position_rmse_px: stats.position_rmse_px * std::f64::consts::SQRT_2,
        keys: stats.outline_keys + stats.line_keys,
        shapes: keyed.shapes.len(),
        frames: clip.frames.len(),
        triangles_drawn: prepared.triangles_drawn(),
        shown: ReadBack::Moving(moving),
    })
}

fn paged(prepared: &PreparedClip, quality: &Quality, name: &str) -> Result<Written, PlanarError> {
    let clip = &prepared.clip;
    let options = key_options(quality, LineUnits::Box);
    let pages = pages(prepared, &options)?;
    let text = flipbook(&pages, name)?;
    let moving = Box::new(AnimatedSvg::read(&text)?);
    Ok(Written {
        bytes: text.into_bytes(),
        position_rmse_px: GRID_RMSE_PX,
        keys: 0,
        shapes: pages.iter().map(|p| p.shapes.len()).sum(),
        frames: clip.frames.len(),
        triangles_drawn: prepared.triangles_drawn(),
        shown: ReadBack::Moving(moving),
    })
}

fn played(prepared: &PreparedClip, options: &PlayerOptions) -> Result<Written, PlanarError> {
    let PreparedClip {
        clip,
        drawn,
        painting,
        ..
    } = prepared;
    let file = player(clip, drawn, painting, options)?;
    // From the container, as a player reads it.
    let shown = decode(&file.container).map_err(|e| PlanarError::Mismatch {
        at: "player",
        what: e.to_string(),
    })?;
    Ok(Written {
        position_rmse_px: file.stats.position_rmse_px,
        keys: 0,
        shapes: file.stats.triangles,
        frames: clip.frames.len(),
        triangles_drawn: prepared.triangles_drawn(),
        bytes: file.text.into_bytes(),
        shown: ReadBack::Player(Box::new(shown)),
    })
}

fn one_frame(
    prepared: &PreparedClip,
    quality: &Quality,
    frame: usize,
    exact: bool,
) -> Result<Written, PlanarError> {
    let order = prepared.order_at(frame);
    let options = StillOptions {
        shading: quality.shading,
        exact,
        underlap: prepared.underlap,
    };
    let text = still(&prepared.clip, frame, &order, &options)?;
    Ok(Written {
        bytes: text.clone().into_bytes(),
        position_rmse_px: GRID_RMSE_PX,
        keys: 0,
        shapes: order.len(),
        frames: 1,
        triangles_drawn: order.len(),
        shown: ReadBack::Still(text),
    })
}

fn naive(prepared: &PreparedClip, options: ThesisSvgOptions) -> Result<Written, PlanarError> {
    let clip = &prepared.clip;
    let file = thesis(clip, &options)?;
    Ok(Written {
        bytes: file.text.into_bytes(),
        // Thousandths of a pixel.
        position_rmse_px: 0.0,
        keys: 0,
        shapes: file.elements,
        frames: clip.frames.len(),
        triangles_drawn: prepared.triangles_drawn(),
        shown: ReadBack::Naive(options),
    })
}
