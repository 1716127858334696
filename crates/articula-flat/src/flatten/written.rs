//! A written file of any profile, and the picture it shows at any time.
//!
//! Pictures are read back from the file where this crate has a reader: the sampler for SVG, the
//! decoder for the player. Lottie is measured by the same keyed clip written as SVG, and the
//! thesis' form by the clip it was made from.

use super::pages::pages;
use super::prepared::PreparedClip;
use super::settings::{Profile, Quality};
use super::source_frames::BACKGROUND;
use super::strays::{self, Strays};
use crate::item_buffer::Supersampling;
use crate::picture::Picture;
use crate::planar::key_frames::{KeyOptions, keyed_along};
use crate::planar::keyed_clip::LineUnits;
use crate::planar::reference::reference;
use crate::planar::shading::Shading;
use crate::planar::shared_motion::SharedMotions;
use crate::planar::underlap::{UnderlapOptions, seal};
use crate::planar::{Painting, PlanarError};
use crate::vector::AnimatedSvg;
use crate::vector::flipbook::flipbook;
use crate::vector::lottie;
use crate::vector::player::{PlayerClip, PlayerOptions, ShownTexture, decode, on_canvas, player};
use crate::vector::smil;
use crate::vector::still::{StillOptions, still};
use crate::vector::thesis::{
    ThesisForm, ThesisSvgOptions, thesis, thesis_frame, thesis_gouraud_picture,
};
use crate::vector::{raster, raster_scaled};
use articula_core::Progress;

/// A written file with its statistics.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Written {
    /// The file.
    pub bytes: Vec<u8>,
    /// Root mean square distance of corners from their exact positions, pixels.
    pub position_rmse_px: f64,
    /// Number of keys of all outlines and paints; 0 where there are none.
    pub keys: usize,
    /// Number of shapes written.
    pub shapes: usize,
    /// Number of frames in the file.
    pub frames: usize,
    /// Triangles that are drawn in some frame.
    pub triangles_drawn: usize,
    /// The painting order, if it is not that of the prepared clip.
    painting: Option<Painting>,
    shown: ReadBack,
}

/// Reader of the file.
#[derive(Debug, Clone, PartialEq)]
enum ReadBack {
    Moving(Box<AnimatedSvg>),
    Player(Box<PlayerClip>),
    Still(String),
    Naive(ThesisSvgOptions),
}

/// RMS distance, in pixels, caused by rounding both coordinates to the grid of outlines.
const GRID_RMSE_PX: f64 = 0.25 * 0.408_248;

/// Additional underlap per pixel of position tolerance. Less shows fewer thorns on most figures, but opens
/// gaps beside long thin triangles at silhouettes.
const SLACK: f32 = 1.0;

/// Writes a prepared clip.
///
/// # Errors
/// Errors of the writer ([`PlanarError`]); [`PlanarError::Cancelled`].
pub(super) fn write(
    prepared: &PreparedClip,
    profile: Profile,
    quality: &Quality,
    name: &str,
    progress: &mut Progress<'_>,
) -> Result<Written, PlanarError> {
    match profile {
        Profile::Smil => key_framed(prepared, quality, name, false, progress),
        Profile::Lottie => key_framed(prepared, quality, name, true, progress),
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
    /// Returns the picture at a time in frames.
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
            ReadBack::Player(clip) => played_picture(clip, frame)?,
            ReadBack::Naive(
                options @ ThesisSvgOptions {
                    form: ThesisForm::GouraudStill { frame },
                    ..
                },
            ) => thesis_gouraud_picture(&prepared.clip, *frame, options, BACKGROUND)?,
            ReadBack::Naive(options) => {
                let still = thesis_frame(&prepared.clip, options, frame)?;
                raster(&still, BACKGROUND)?
            }
        })
    }

    /// The picture that triangles of the file show.
    pub(super) fn texture(&self) -> Option<ShownTexture> {
        match &self.shown {
            ReadBack::Player(clip) => clip.shown_texture(),
            _ => None,
        }
    }
}

/// What the player shows at a time in frames: with a picture, as its script draws it.
///
/// # Errors
/// [`PlanarError::Picture`] if it cannot be drawn.
pub(super) fn played_picture(clip: &PlayerClip, frame: f64) -> Result<Picture, PlanarError> {
    Ok(match clip.shown_texture() {
        Some(_) => on_canvas(clip, frame, BACKGROUND)?,
        None => reference(&clip.painted(frame), 0, Supersampling::Four, BACKGROUND)?,
    })
}

/// Maximum number of frames in which stray pixels are counted.
const STRAY_FRAMES: usize = 4;

impl Written {
    /// Returns the stray pixels at some of these frames, percent of the character's; `None` if the
    /// file is not read back as SVG.
    ///
    /// # Errors
    /// [`PlanarError::Picture`] if the file cannot be drawn.
    pub(super) fn strays(
        &self,
        prepared: &PreparedClip,
        frames: &[usize],
        quality: &Quality,
    ) -> Result<Option<f64>, PlanarError> {
        if !Strays::are_counted(&prepared.clip) {
            return Ok(None);
        }
        let step = frames.len().div_ceil(STRAY_FRAMES).max(1);
        let known = |f: &&usize| **f < prepared.clip.frames.len();
        let mut all = Strays::default();
        for frame in frames.iter().step_by(step).filter(known) {
            let secs = *frame as f64 / f64::from(prepared.clip.fps);
            let text = match &self.shown {
                ReadBack::Moving(moving) => &moving.at(secs)?,
                ReadBack::Still(text) => text,
                ReadBack::Player(_) | ReadBack::Naive(_) => return Ok(None),
            };
            let shown = raster_scaled(text, BACKGROUND, strays::FACTOR)?;
            // Positions of stills and pages are exact.
            let tolerance = if self.keys > 0 {
                quality.pos_tol_px
            } else {
                0.0
            };
            let painting = self.painting.as_ref().unwrap_or(&prepared.painting);
            let order = prepared.order_of(painting, *frame);
            let clip = &prepared.clip;
            all.add(Strays::count(clip, (*frame, &order), &shown, tolerance)?);
        }
        Ok(Some(all.percent()))
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
    progress: &mut Progress<'_>,
) -> Result<Written, PlanarError> {
    let PreparedClip { clip, drawn, .. } = prepared;
    let lines = if is_lottie {
        LineUnits::Grid
    } else {
        LineUnits::Box
    };
    let options = key_options(quality, lines);
    // Corners on both sides of an edge may be off in opposite directions.
    let underlap = UnderlapOptions {
        distance_px: prepared.underlap.distance_px + SLACK * quality.pos_tol_px,
        ..prepared.underlap
    };
    let PreparedClip {
        painting,
        layers,
        overlaps,
        ..
    } = prepared;
    // Shapes that are merged follow no motion.
    let is_merged = quality.shading == Shading::Flat && quality.merge_levels.is_some();
    let shared = match is_merged {
        true => SharedMotions::none(painting, layers),
        false => SharedMotions::of(
            (clip, painting, layers, overlaps),
            quality.pos_tol_px,
            &mut progress.part(0.0, 0.5),
        )?,
    };
    let sealed = seal(clip, drawn, &shared.painting, underlap);
    let follow = (&shared.motions[..], &shared.of_layer[..]);
    let subject = (clip, drawn, &shared.layers[..], &sealed);
    let (keyed, stats) = keyed_along(subject, follow, &options, &mut progress.part(0.5, 1.0))?;
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
        keys: stats.outline_keys + stats.line_keys + stats.color_keys,
        shapes: keyed.shapes.len(),
        frames: clip.frames.len(),
        triangles_drawn: prepared.triangles_drawn(),
        painting: Some(shared.painting),
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
        painting: None,
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
    // Decoded from the container, as the player does.
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
        painting: None,
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
        painting: None,
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
        frames: if options.form.is_gouraud() {
            1
        } else {
            clip.frames.len()
        },
        triangles_drawn: prepared.triangles_drawn(),
        painting: None,
        shown: ReadBack::Naive(options),
    })
}
