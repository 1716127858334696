//! Search for the best quality under a byte budget.
//!
//! Source: `docs/methods/vector.md` 1 and 9. Within one kind of filling, each quality step is
//! smaller and worse than the one before, so the first that fits is the best of its kind; among
//! kinds the least image error wins. If none fits, the smallest file is the result. The same clip
//! and budget give the same file.

use super::prepared::PreparedClip;
use super::reference_frames::{ImageError, ReferenceFrames};
use super::report::{FileErrors, FileSize, Representation};
use super::settings::{Profile, Quality, Settings};
use super::source_frames::DroppedDetail;
use super::written::{Written, write};
use crate::planar::PlanarError;
use crate::planar::shading::Shading;
use crate::vector::player::ShownTexture;
use articula_core::Progress;

/// A converted file with its size and error.
#[derive(Debug, Clone, PartialEq)]
pub struct Flattened {
    /// The file.
    pub bytes: Vec<u8>,
    /// Profile of the file.
    pub profile: Profile,
    /// Quality that was chosen.
    pub quality: Quality,
    /// Size of the file.
    pub sizes: FileSize,
    /// Error of the file.
    pub errors: FileErrors,
    /// Triangles that are drawn in some frame.
    pub triangles_drawn: usize,
    /// Frames of the clip.
    pub frames: usize,
    /// Frames per second.
    pub fps: f32,
    /// Number of keys of all outlines and paints.
    pub keys: usize,
    /// Number of shapes written.
    pub shapes: usize,
    /// Number of painting orders, one after the other.
    pub orders: usize,
    /// The picture that triangles show; only in files of the player.
    pub texture: Option<ShownTexture>,
    /// Bytes by which the smallest file misses the budget; `None` if the budget is kept.
    pub bytes_over: Option<u64>,
    /// Settings that the search tried; one without a budget.
    pub tried: Vec<TriedQuality>,
    /// Painted detail that vertex colours do not show, the largest of each region; filled where the
    /// textures are known ([`super::dropped_detail`]).
    pub dropped_detail: Vec<DroppedDetail>,
}

/// A quality that the search tried, with its size and error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriedQuality {
    /// The quality.
    pub quality: Quality,
    /// Size of its file, bytes.
    pub bytes: u64,
    /// Image error, if the file fits and was compared.
    pub image: Option<ImageError>,
}

impl Flattened {
    /// Returns the bytes per drawn triangle and frame of a size in bytes.
    pub fn per_triangle_and_frame(&self, bytes: u64) -> f64 {
        bytes as f64 / (self.triangles_drawn * self.frames).max(1) as f64
    }

    /// Returns the representation that the file provides.
    pub fn representation(&self) -> Representation {
        Representation::new(self.profile, self.sizes.raw, self.errors.position_rmse_px)
    }
}

/// A converted file of which no picture was made.
#[derive(Debug, Clone, PartialEq)]
pub struct Unmeasured {
    /// The file.
    pub bytes: Vec<u8>,
    /// What the file provides.
    pub representation: Representation,
    /// Triangles that are drawn in some frame.
    pub triangles_drawn: usize,
    /// Frames.
    pub frames: usize,
}

/// Writes a prepared clip without pictures of the file and compressed sizes, which cost more than the
/// file; with a byte budget, at the first of the quality steps that fits, or at the coarsest if none
/// fits. Without a budget the bytes are those of [`flatten()`].
///
/// # Errors
/// Errors of the writer; [`PlanarError::Cancelled`].
pub fn flatten_unmeasured(
    prepared: &PreparedClip,
    settings: &Settings,
    progress: &mut Progress<'_>,
) -> Result<Unmeasured, PlanarError> {
    let most = settings.max_bytes.unwrap_or(u64::MAX);
    let candidates = candidates(settings);
    let share = 1.0 / candidates.len() as f32;
    let mut tries = 0.0;
    let mut written = |quality: &Quality| {
        let progress = &mut progress.part(tries * share, (tries + 1.0) * share);
        tries += 1.0;
        write(
            prepared,
            settings.profile,
            quality,
            &settings.name,
            progress,
        )
    };
    let fits = |made: &Written| made.bytes.len() as u64 <= most;
    let mut made = written(&settings.quality)?;
    if let [_, between @ .., coarsest] = &candidates[..]
        && !fits(&made)
    {
        // If not even the coarsest step fits, those between cannot.
        let coarsest = written(coarsest)?;
        if fits(&coarsest) {
            let steps = between.iter().map(written);
            let mut first = steps.filter(|made| made.as_ref().is_ok_and(fits) || made.is_err());
            made = first.next().transpose()?.unwrap_or(coarsest);
        } else if coarsest.bytes.len() < made.bytes.len() {
            made = coarsest;
        }
    }
    let bytes = made.bytes.len() as u64;
    Ok(Unmeasured {
        representation: Representation::new(settings.profile, bytes, made.position_rmse_px),
        triangles_drawn: made.triangles_drawn,
        frames: made.frames,
        bytes: made.bytes,
    })
}

/// Writes a prepared clip; with a byte budget, at the best quality that fits, or the smallest file
/// if none fits ([`Flattened::bytes_over`]).
///
/// # Errors
/// Errors of the writer; [`PlanarError::Cancelled`].
pub fn flatten(
    prepared: &PreparedClip,
    settings: &Settings,
    truth: &ReferenceFrames,
    progress: &mut Progress<'_>,
) -> Result<Flattened, PlanarError> {
    let candidates = candidates(settings);
    let most = settings.max_bytes.unwrap_or(u64::MAX);
    let mut tried: Vec<TriedQuality> = Vec::new();
    let mut best: Option<(Written, Quality, ImageError)> = None;
    let mut smallest: Option<(Written, Quality)> = None;
    let share = 1.0 / candidates.len() as f32;
    for (c, quality) in candidates.iter().enumerate() {
        let mut progress = progress.part(c as f32 * share, (c + 1) as f32 * share);
        let is_known = |t: &TriedQuality| t.image.is_some() && kind(&t.quality) == kind(quality);
        if !tried.iter().any(is_known) {
            let made = &mut progress.part(0.0, 0.5);
            let written = write(prepared, settings.profile, quality, &settings.name, made)?;
            progress.step(0.5)?;
            let bytes = written.bytes.len() as u64;
            let fits = bytes <= most;
            let shown = |f| written.picture(prepared, f);
            let image = fits.then(|| truth.compare(shown, &mut progress.part(0.5, 1.0)));
            let image = image.transpose()?;
            tried.push(TriedQuality {
                quality: *quality,
                bytes,
                image,
            });
            let is_better = |image: &ImageError| {
                let held = best.as_ref();
                held.is_none_or(|(_, _, held)| image.rmse_levels < held.rmse_levels)
            };
            if let Some(image) = image.filter(is_better) {
                best = Some((written, *quality, image));
            } else if !fits {
                let held = smallest.as_ref().map(|(held, _)| held.bytes.len() as u64);
                if held.is_none_or(|held| bytes < held) {
                    smallest = Some((written, *quality));
                }
            }
        }
        progress.step(1.0)?;
    }
    let (written, quality, image) = match (best, smallest) {
        (Some(best), _) => best,
        (None, Some((written, quality))) => {
            let shown = |f| written.picture(prepared, f);
            let image = truth.compare(shown, &mut Progress::none())?;
            (written, quality, image)
        }
        // Without a candidate nothing was asked for; there is always one.
        (None, None) => {
            return Err(PlanarError::Mismatch {
                at: "settings",
                what: "no quality to try".into(),
            });
        }
    };
    let bytes_over = (written.bytes.len() as u64).saturating_sub(most);
    Ok(Flattened {
        bytes_over: (bytes_over > 0).then_some(bytes_over),
        sizes: FileSize::of(&written.bytes)?,
        errors: FileErrors {
            position_rmse_px: written.position_rmse_px,
            image,
            stray_pixels_percent: written.strays(prepared, &truth.whole_frames(), &quality)?,
            wrong_pixels_percent: prepared.wrong_percent,
            wrong_pixels_percent_depth_sort: prepared.wrong_percent_depth_sort,
        },
        profile: settings.profile,
        quality,
        triangles_drawn: written.triangles_drawn,
        frames: written.frames,
        fps: prepared.clip.fps,
        keys: written.keys,
        shapes: written.shapes,
        orders: prepared.painting.epochs.len(),
        texture: written.texture(),
        bytes: written.bytes,
        tried,
        dropped_detail: Vec::new(),
    })
}

/// Candidates of the search: the requested quality and, with a budget, the steps that are coarser.
fn candidates(settings: &Settings) -> Vec<Quality> {
    let asked = settings.quality;
    let mut all = vec![asked];
    if settings.max_bytes.is_some() {
        let is_coarser = |q: &Quality| {
            let tol = q.pos_tol_px >= asked.pos_tol_px && q.col_tol_levels >= asked.col_tol_levels;
            let fill = asked.shading == Shading::Gouraud || q.shading == Shading::Flat;
            let merge = q.merge_levels.unwrap_or(0.0) >= asked.merge_levels.unwrap_or(0.0);
            tol && fill && merge && *q != asked
        };
        let steps = Quality::steps(settings.profile).into_iter();
        all.extend(steps.filter(is_coarser));
    }
    all
}

/// Kind of a quality; within one kind, size and quality fall from step to step.
fn kind(quality: &Quality) -> (bool, bool) {
    let is_flat = quality.shading == Shading::Flat;
    (is_flat, quality.merge_levels.is_some())
}
