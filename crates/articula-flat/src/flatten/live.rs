//! Files with named inputs that a host drives, with size and error.
//!
//! Source: `docs/methods/vector.md` 8.3. Inputs are linear on the screen and the painting order is
//! fixed, so the error compares the clip inside the file with the original one.

use super::prepared::PreparedClip;
use super::reference_frames::ReferenceFrames;
use super::report::{FileErrors, FileSize};
use super::search::{Flattened, TriedQuality};
use super::settings::{Profile, Settings};
use super::written::played_picture;
use crate::planar::PlanarError;
use crate::vector::player::{LiveSource, PlayerOptions, PlayerOutput, decode, live_player};
use articula_core::Progress;

/// Writes a file whose named inputs the host page drives; `prepared` is made from the shapes of
/// `source`, `truth` from its clip.
///
/// # Errors
/// Errors of the writer; [`PlanarError::Cancelled`].
pub fn flatten_live(
    source: &LiveSource,
    prepared: &PreparedClip,
    settings: &Settings,
    truth: &ReferenceFrames,
    progress: &mut Progress<'_>,
) -> Result<Flattened, PlanarError> {
    let quality = settings.quality;
    let output = match settings.profile {
        Profile::Player(output) => output,
        _ => PlayerOutput::Svg,
    };
    let options = PlayerOptions {
        pos_tol_px: f64::from(quality.pos_tol_px),
        col_tol_levels: f64::from(quality.col_tol_levels),
        shading: quality.shading,
        output,
    };
    let file = live_player(source, &prepared.drawn, &prepared.painting, &options)?;
    let clip = decode(&file.container).map_err(|e| PlanarError::Mismatch {
        at: "player",
        what: e.to_string(),
    })?;
    let shown = |frame| played_picture(&clip, frame);
    progress.step(0.5)?;
    let image = truth.compare(shown, &mut progress.part(0.5, 1.0))?;
    let bytes = file.text.into_bytes();
    let raw = bytes.len() as u64;
    let bytes_over = settings
        .max_bytes
        .map_or(0, |most| raw.saturating_sub(most));
    Ok(Flattened {
        bytes_over: (bytes_over > 0).then_some(bytes_over),
        sizes: FileSize::of(&bytes)?,
        errors: FileErrors {
            position_rmse_px: file.stats.position_rmse_px,
            image,
            stray_pixels_percent: None,
            wrong_pixels_percent: prepared.wrong_percent,
            wrong_pixels_percent_depth_sort: prepared.wrong_percent_depth_sort,
        },
        profile: settings.profile,
        quality,
        triangles_drawn: prepared.triangles_drawn(),
        frames: source.weights.len().max(1),
        fps: prepared.clip.fps,
        keys: 0,
        shapes: file.stats.triangles,
        orders: 1,
        texture: clip.shown_texture(),
        tried: vec![TriedQuality {
            quality,
            bytes: raw,
            image: Some(image),
        }],
        bytes,
        dropped_detail: Vec::new(),
    })
}
