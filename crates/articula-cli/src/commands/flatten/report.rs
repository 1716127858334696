//! The report of `flatten`.

use articula_flat::flatten::{Flattened, ImageError, Quality, Representation, TriedQuality};
use articula_flat::planar::Shading;
use serde::Serialize;

/// The report of one conversion; its field names are stable (`docs/commands.md`).
#[derive(Debug, Serialize)]
pub(crate) struct FlattenReport {
    pub(crate) out: String,
    pub(crate) profile: String,
    pub(crate) bytes: BytesReport,
    /// Triangles of the character, of those that the camera may see at the requested level, and of
    /// those that are visible in some frame.
    pub(crate) triangles_of_character: usize,
    pub(crate) triangles: usize,
    pub(crate) triangles_drawn: usize,
    pub(crate) frames: usize,
    pub(crate) fps: f32,
    pub(crate) duration_secs: f64,
    pub(crate) size_px: (u32, u32),
    pub(crate) shapes: usize,
    pub(crate) keys: usize,
    pub(crate) orders: usize,
    pub(crate) bytes_per_triangle_and_frame: PerTriangle,
    pub(crate) settings: SettingsReport,
    pub(crate) error: ErrorReport,
    pub(crate) representation: RepresentationReport,
    /// Settings tried in a search under a size limit.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) tried: Vec<TrialReport>,
}

#[derive(Debug, Serialize)]
pub(crate) struct BytesReport {
    pub(crate) raw: u64,
    pub(crate) gzip: u64,
    pub(crate) brotli: u64,
}

#[derive(Debug, Serialize)]
pub(crate) struct PerTriangle {
    pub(crate) raw: f64,
    pub(crate) brotli: f64,
}

#[derive(Debug, Serialize)]
pub(crate) struct SettingsReport {
    pub(crate) shading: &'static str,
    pub(crate) pos_tol_px: f32,
    pub(crate) col_tol_levels: f32,
    pub(crate) merge_levels: Option<f32>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ErrorReport {
    pub(crate) position_rmse_px: f64,
    pub(crate) image_rmse_levels: f64,
    pub(crate) image_rmse_levels_max: f64,
    pub(crate) ssim: f64,
    pub(crate) ssim_min: f64,
    pub(crate) pixels_off_percent: f64,
    pub(crate) moments: usize,
    pub(crate) wrong_pixels_percent: f64,
    pub(crate) wrong_pixels_percent_depth_sort: f64,
}

/// A representation of the character that can replace the 3D one.
#[derive(Debug, Serialize)]
pub(crate) struct RepresentationReport {
    pub(crate) modality: String,
    pub(crate) bytes: u64,
    pub(crate) error_px: f64,
    pub(crate) needs: Vec<&'static str>,
}

#[derive(Debug, Serialize)]
pub(crate) struct TrialReport {
    #[serde(flatten)]
    settings: SettingsReport,
    bytes: u64,
    fits: bool,
    image_rmse_levels: Option<f64>,
}

/// Settings of the conversion that the report repeats.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Made {
    pub(crate) triangles_of_character: usize,
    pub(crate) triangles: usize,
    pub(crate) size_px: (u32, u32),
    pub(crate) max_bytes: Option<u64>,
}

impl FlattenReport {
    pub(crate) fn new(out: String, flat: &Flattened, made: Made) -> Self {
        let per = |bytes| flat.per_triangle_and_frame(bytes);
        Self {
            out,
            profile: flat.profile.to_string(),
            bytes: BytesReport {
                raw: flat.sizes.raw,
                gzip: flat.sizes.gzip,
                brotli: flat.sizes.brotli,
            },
            triangles_of_character: made.triangles_of_character,
            triangles: made.triangles,
            triangles_drawn: flat.triangles_drawn,
            frames: flat.frames,
            fps: flat.fps,
            duration_secs: flat.frames.saturating_sub(1) as f64 / f64::from(flat.fps),
            size_px: made.size_px,
            shapes: flat.shapes,
            keys: flat.keys,
            orders: flat.orders,
            bytes_per_triangle_and_frame: PerTriangle {
                raw: per(flat.sizes.raw),
                brotli: per(flat.sizes.brotli),
            },
            settings: SettingsReport::new(&flat.quality),
            error: ErrorReport::new(flat),
            representation: RepresentationReport::new(flat.representation()),
            tried: made
                .max_bytes
                .map(|most| {
                    flat.tried
                        .iter()
                        .map(|t| TrialReport::new(t, most))
                        .collect()
                })
                .unwrap_or_default(),
        }
    }

    /// Formats the report for people.
    pub(crate) fn text(&self) -> String {
        let Self { bytes, error, .. } = self;
        let mut text = format!(
            "{}: {}, {} x {} px, {} frames, {:.2} s\n\
             {:.1} kB ({:.1} gzip, {:.1} brotli): {:.2} bytes a triangle and frame ({:.2} brotli)\n\
             {} triangles, {} after cutting piercing ones; {} shapes, {} keys, {} painting orders\n",
            self.out,
            self.profile,
            self.size_px.0,
            self.size_px.1,
            self.frames,
            self.duration_secs,
            bytes.raw as f64 / 1e3,
            bytes.gzip as f64 / 1e3,
            bytes.brotli as f64 / 1e3,
            self.bytes_per_triangle_and_frame.raw,
            self.bytes_per_triangle_and_frame.brotli,
            self.triangles,
            self.triangles_drawn,
            self.shapes,
            self.keys,
            self.orders,
        );
        text.push_str(&format!(
            "error: position {:.2} px, colour {:.1} levels of 0 to 255 (max {:.1}), SSIM {:.4} (min {:.4}) at {} frames; \
             pixels painted in the wrong order {:.2} % (depth sort {:.2} %)\n",
            error.position_rmse_px,
            error.image_rmse_levels,
            error.image_rmse_levels_max,
            error.ssim,
            error.ssim_min,
            error.moments,
            error.wrong_pixels_percent,
            error.wrong_pixels_percent_depth_sort,
        ));
        if !self.tried.is_empty() {
            let s = &self.settings;
            let merge = s.merge_levels.map(|m| format!(", merged {m} levels"));
            text.push_str(&format!(
                "best of {} settings: {}, {} px, {} levels{}\n",
                self.tried.len(),
                s.shading,
                s.pos_tol_px,
                s.col_tol_levels,
                merge.unwrap_or_default(),
            ));
        }
        text
    }
}

impl SettingsReport {
    fn new(quality: &Quality) -> Self {
        Self {
            shading: match quality.shading {
                Shading::Flat => "flat",
                Shading::Gouraud => "gouraud",
            },
            pos_tol_px: quality.pos_tol_px,
            col_tol_levels: quality.col_tol_levels,
            merge_levels: quality.merge_levels,
        }
    }
}

impl ErrorReport {
    fn new(flat: &Flattened) -> Self {
        let errors = &flat.errors;
        let ImageError {
            rmse_levels,
            rmse_levels_max,
            ssim,
            ssim_min,
            off_percent,
            moments,
        } = errors.image;
        Self {
            position_rmse_px: errors.position_rmse_px,
            image_rmse_levels: rmse_levels,
            image_rmse_levels_max: rmse_levels_max,
            ssim,
            ssim_min,
            pixels_off_percent: off_percent,
            moments,
            wrong_pixels_percent: errors.wrong_pixels_percent,
            wrong_pixels_percent_depth_sort: errors.wrong_pixels_percent_depth_sort,
        }
    }
}

impl RepresentationReport {
    pub(crate) fn new(entry: Representation) -> Self {
        Self {
            modality: entry.modality,
            bytes: entry.bytes,
            error_px: entry.error_px,
            needs: entry.needs,
        }
    }
}

impl TrialReport {
    fn new(trial: &TriedQuality, most: u64) -> Self {
        Self {
            settings: SettingsReport::new(&trial.quality),
            bytes: trial.bytes,
            fits: trial.bytes <= most,
            image_rmse_levels: trial.image.map(|i| i.rmse_levels),
        }
    }
}
