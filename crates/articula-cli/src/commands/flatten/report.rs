//! The report of `flatten`.

use articula::flat::flatten::{
    DroppedDetail, Flattened, ImageError, JudgedRegion, LocalDifferences, Profile, Quality,
    Representation, TriedQuality, WorstDifference,
};
use articula::flat::planar::Shading;
use articula::flatten::{
    DETAIL_DELTA_E, FACE_DELTA_E, FramedCharacter, REST_DELTA_E, TriedTriangles, excess,
};
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
    /// Choice of the triangle count, if it was not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) triangle_choice: Option<ChoiceReport>,
    /// Size limit, and the bytes by which the smallest file misses it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) max_bytes: Option<u64>,
    pub(crate) bytes_over: Option<u64>,
    /// Painted detail that vertex colours do not show.
    pub(crate) dropped_detail: Vec<DetailReport>,
    pub(crate) warnings: Vec<String>,
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
    pub(crate) local: Option<LocalReport>,
    pub(crate) wrong_pixels_percent: f64,
    pub(crate) wrong_pixels_percent_depth_sort: f64,
}

/// The largest local differences from the character itself.
#[derive(Debug, Serialize)]
pub(crate) struct LocalReport {
    pub(crate) face: Option<WorstReport>,
    pub(crate) rest: Option<WorstReport>,
}

/// A largest local difference, and where it lies.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct WorstReport {
    pub(crate) delta_e: f64,
    pub(crate) region: String,
    pub(crate) x: u32,
    pub(crate) y: u32,
    pub(crate) frame: f64,
}

/// Painted detail of a region that vertex colours do not show.
#[derive(Debug, Serialize)]
pub(crate) struct DetailReport {
    pub(crate) mesh: String,
    #[serde(flatten)]
    pub(crate) worst: WorstReport,
}

/// The chosen triangle count and what was tried.
#[derive(Debug, Serialize)]
pub(crate) struct ChoiceReport {
    pub(crate) count: Option<usize>,
    pub(crate) face_weight: f32,
    pub(crate) hands_weight: f32,
    pub(crate) tried: Vec<CountReport>,
}

#[derive(Debug, Serialize)]
pub(crate) struct CountReport {
    count: usize,
    triangles: usize,
    face_weight: f32,
    hands_weight: f32,
    #[serde(flatten)]
    local: LocalReport,
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
pub(crate) struct Made<'a> {
    pub(crate) triangles_of_character: usize,
    pub(crate) framed: &'a FramedCharacter<'a>,
    pub(crate) size_px: (u32, u32),
    pub(crate) max_bytes: Option<u64>,
}

impl FlattenReport {
    pub(crate) fn new(out: String, flat: &Flattened, made: Made<'_>) -> Self {
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
            triangles: made.framed.triangles.len(),
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
            triangle_choice: ChoiceReport::new(made.framed),
            max_bytes: made.max_bytes,
            bytes_over: flat.bytes_over,
            dropped_detail: dropped(flat).map(DetailReport::new).collect(),
            warnings: warnings(flat, made.max_bytes),
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
        if let Some(local) = &error.local {
            let of = |name: &str, worst: &Option<WorstReport>, bound: f64| {
                let worst = worst.as_ref()?;
                Some(format!("{name} {} (bound {bound})", worst.text()))
            };
            let face = of("face", &local.face, FACE_DELTA_E);
            let rest = of("rest", &local.rest, REST_DELTA_E);
            let both: Vec<String> = face.into_iter().chain(rest).collect();
            text.push_str(&format!("largest local difference: {}\n", both.join("; ")));
        }
        if let Some(choice) = &self.triangle_choice {
            text.push_str(&format!(
                "triangle count chosen from {} tried: {}; weight of the face {}, of the hands {}\n",
                choice.tried.len(),
                choice.count.unwrap_or(self.triangles),
                choice.face_weight,
                choice.hands_weight,
            ));
        }
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
        for warning in &self.warnings {
            text.push_str(&format!("warning: {warning}\n"));
        }
        text
    }
}

/// Painted detail that is dropped visibly.
fn dropped(flat: &Flattened) -> impl Iterator<Item = &DroppedDetail> {
    let all = flat.dropped_detail.iter();
    all.filter(|d| d.worst.delta_e > DETAIL_DELTA_E)
}

/// What the file lacks, each with what to change.
fn warnings(flat: &Flattened, max_bytes: Option<u64>) -> Vec<String> {
    let mut all = Vec::new();
    if let Some((over, most)) = flat.bytes_over.zip(max_bytes) {
        all.push(format!(
            "the smallest file has {} bytes, {over} more than --max-bytes {most}; give fewer \
             --triangles, a lower --fps or --profile player",
            flat.sizes.raw,
        ));
    }
    for detail in dropped(flat) {
        let worst = WorstReport::new(&detail.worst);
        let shading = match flat.quality.shading {
            Shading::Flat => "--shading gouraud, ",
            Shading::Gouraud => "",
        };
        all.push(format!(
            "texture detail of the {} was dropped (mesh {}): its colours differ by {}; give more \
             --triangles, {shading}or --profile portrait for a face",
            worst.region,
            crate::fault::clean(&detail.mesh),
            worst.text(),
        ));
    }
    // The form of the thesis is a baseline, not to be improved.
    let is_baseline = matches!(flat.profile, Profile::Thesis(_));
    let local = flat.errors.image.local.filter(|_| !is_baseline);
    let local = local.unwrap_or_default();
    for worst in [local.of(JudgedRegion::Face), local.rest()]
        .into_iter()
        .flatten()
    {
        if excess(&worst) > 1.0 {
            let worst = WorstReport::new(&worst);
            all.push(format!(
                "visible local difference from the character, {}: {}; give more --triangles, a lower \
                 --quality order-percent or --profile flipbook",
                worst.region,
                worst.text(),
            ));
        }
    }
    all
}

impl LocalReport {
    fn new(local: &LocalDifferences) -> Self {
        let of = |worst: Option<WorstDifference>| worst.as_ref().map(WorstReport::new);
        Self {
            face: of(local.of(JudgedRegion::Face)),
            rest: of(local.rest()),
        }
    }
}

impl WorstReport {
    fn new(worst: &WorstDifference) -> Self {
        Self {
            delta_e: worst.delta_e,
            region: worst.region.to_string(),
            x: worst.x,
            y: worst.y,
            frame: worst.frame,
        }
    }

    fn text(&self) -> String {
        format!(
            "{:.1} CIELAB units at pixel ({}, {}) of frame {}",
            self.delta_e, self.x, self.y, self.frame
        )
    }
}

impl DetailReport {
    fn new(detail: &DroppedDetail) -> Self {
        Self {
            mesh: detail.mesh.clone(),
            worst: WorstReport::new(&detail.worst),
        }
    }
}

impl ChoiceReport {
    /// `None` if the count was given or all triangles are kept.
    fn new(framed: &FramedCharacter<'_>) -> Option<Self> {
        let weights = framed.weights();
        let tried: Vec<CountReport> = framed.tried().iter().map(CountReport::new).collect();
        (!tried.is_empty()).then_some(Self {
            count: framed.count(),
            face_weight: weights.face,
            hands_weight: weights.hands,
            tried,
        })
    }
}

impl CountReport {
    fn new(tried: &TriedTriangles) -> Self {
        Self {
            count: tried.count,
            triangles: tried.triangles,
            face_weight: tried.weights.face,
            hands_weight: tried.weights.hands,
            local: LocalReport::new(&tried.local),
        }
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
            local,
        } = errors.image;
        Self {
            position_rmse_px: errors.position_rmse_px,
            image_rmse_levels: rmse_levels,
            image_rmse_levels_max: rmse_levels_max,
            ssim,
            ssim_min,
            pixels_off_percent: off_percent,
            moments,
            local: local.as_ref().map(LocalReport::new),
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
