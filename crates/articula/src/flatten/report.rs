//! What a conversion to 2D gave: sizes, errors and settings, under the names of the JSON report
//! (`docs/commands.md`).

use super::framed::FramedCharacter;
use super::judged::{DETAIL_DELTA_E, TriedTriangles};
use articula_flat::flatten::{
    DroppedDetail, Flattened, ImageError, JudgedRegion, LocalDifferences, Quality, Representation,
    TriedQuality, WorstDifference,
};
use articula_flat::planar::Shading;
use serde::Serialize;

/// Report of one conversion; its field names are stable.
#[derive(Debug, Clone, Serialize)]
pub struct FlattenReport {
    /// Name of the file.
    pub out: String,
    /// Profile, as on the command line.
    pub profile: String,
    /// Size of the file.
    pub bytes: FlatBytes,
    /// Number of triangles of the character.
    pub triangles_of_character: usize,
    /// Number of those that the camera may see at the requested level.
    pub triangles: usize,
    /// Number of those that are visible in some frame, piercing ones cut.
    pub triangles_drawn: usize,
    /// Number of frames.
    pub frames: usize,
    /// Frames per second.
    pub fps: f32,
    /// Duration, seconds.
    pub duration_secs: f64,
    /// Width and height, pixels.
    pub size_px: (u32, u32),
    /// Number of shapes.
    pub shapes: usize,
    /// Number of keys.
    pub keys: usize,
    /// Number of painting orders.
    pub orders: usize,
    /// Bytes per triangle and frame.
    pub bytes_per_triangle_and_frame: BytesPerTriangle,
    /// Settings of the file.
    pub settings: FlatSettings,
    /// Errors of the file.
    pub error: FlatErrors,
    /// The file as an encoding to choose from.
    pub representation: RepresentationReport,
    /// The picture that triangles show, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture: Option<FlatTexture>,
    /// Choice of the triangle count, if it was not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub triangle_choice: Option<TriangleChoice>,
    /// Limit of the size in bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_bytes: Option<u64>,
    /// Bytes by which the smallest file misses the limit.
    pub bytes_over: Option<u64>,
    /// Painted detail that vertex colours do not show.
    pub dropped_detail: Vec<DetailDifference>,
    /// What the program says about it.
    pub warnings: Vec<String>,
    /// Settings tried in a search under a size limit.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tried: Vec<TriedSettings>,
}

/// Sizes of a file, bytes.
#[derive(Debug, Clone, Serialize)]
pub struct FlatBytes {
    /// As written.
    pub raw: u64,
    /// Compressed by gzip.
    pub gzip: u64,
    /// Compressed by Brotli.
    pub brotli: u64,
}

/// Bytes per triangle and frame.
#[derive(Debug, Clone, Serialize)]
pub struct BytesPerTriangle {
    /// As written.
    pub raw: f64,
    /// Compressed by Brotli.
    pub brotli: f64,
}

/// Settings of a file.
#[derive(Debug, Clone, Serialize)]
pub struct FlatSettings {
    /// `flat` or `gouraud`.
    pub shading: &'static str,
    /// Maximum error of corners, pixels.
    pub pos_tol_px: f32,
    /// Maximum error of colours, levels of 0 to 255.
    pub col_tol_levels: f32,
    /// Difference within which neighbouring triangles are joined, levels.
    pub merge_levels: Option<f32>,
}

/// The picture that triangles of a file show.
#[derive(Debug, Clone, Serialize)]
pub struct FlatTexture {
    /// Number of triangles that show it; others are shaded from corner to corner.
    pub triangles: usize,
    /// Width and height, pixels.
    pub size_px: (u32, u32),
    /// Size of the picture, bytes.
    pub bytes: u64,
}

/// Errors of a file against the simplified character, and locally against the character itself.
#[derive(Debug, Clone, Serialize)]
pub struct FlatErrors {
    /// Root mean square error of corners, pixels.
    pub position_rmse_px: f64,
    /// Root mean square error of pixels, levels of 0 to 255; mean over frames.
    pub image_rmse_levels: f64,
    /// The same, maximum over frames.
    pub image_rmse_levels_max: f64,
    /// Structural similarity, 0 to 1; mean over frames.
    pub ssim: f64,
    /// The same, minimum over frames.
    pub ssim_min: f64,
    /// Pixels that differ visibly, per cent.
    pub pixels_off_percent: f64,
    /// Number of frames that were compared.
    pub moments: usize,
    /// Largest local differences, where they were measured.
    pub local: Option<WorstByPart>,
    /// Pixels at twice the size outside of the silhouette, or in a colour that none of the triangles
    /// around them has, per cent, where they were counted.
    pub stray_pixels_percent: Option<f64>,
    /// Pixels painted in the wrong order, per cent.
    pub wrong_pixels_percent: f64,
    /// The same with triangles sorted by depth.
    pub wrong_pixels_percent_depth_sort: f64,
}

/// The largest local differences from the character itself.
#[derive(Debug, Clone, Serialize)]
pub struct WorstByPart {
    /// That of the face, if it is shown.
    pub face: Option<LocalDifference>,
    /// That of everything else.
    pub rest: Option<LocalDifference>,
}

/// A largest local difference, and where it lies.
#[derive(Debug, Clone, Serialize)]
pub struct LocalDifference {
    /// Difference, units of CIELAB.
    pub delta_e: f64,
    /// Region of the body.
    pub region: String,
    /// Column of the pixel.
    pub x: u32,
    /// Row of the pixel.
    pub y: u32,
    /// Frame, which may lie between two.
    pub frame: f64,
}

/// Painted detail of a region that vertex colours do not show.
#[derive(Debug, Clone, Serialize)]
pub struct DetailDifference {
    /// Name of the mesh.
    pub mesh: String,
    /// The largest difference, and where it lies.
    #[serde(flatten)]
    pub worst: LocalDifference,
}

/// The chosen triangle count and what was tried.
#[derive(Debug, Clone, Serialize)]
pub struct TriangleChoice {
    /// Target number of triangles.
    pub count: Option<usize>,
    /// Weight of errors on the face.
    pub face_weight: f32,
    /// Weight of errors on the hands.
    pub hands_weight: f32,
    /// All that were tried.
    pub tried: Vec<TriedCount>,
}

/// A triangle count that was tried.
#[derive(Debug, Clone, Serialize)]
pub struct TriedCount {
    /// Target number of triangles.
    pub count: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Weight of errors on the face.
    pub face_weight: f32,
    /// Weight of errors on the hands.
    pub hands_weight: f32,
    /// Largest local differences.
    #[serde(flatten)]
    pub local: WorstByPart,
}

/// A representation of the character that can replace the 3D one.
#[derive(Debug, Clone, Serialize)]
pub struct RepresentationReport {
    /// Kind of encoding, such as `vector/smil`.
    pub modality: String,
    /// Size, bytes.
    pub bytes: u64,
    /// Error, pixels.
    pub error_px: f64,
    /// Features that the client must support.
    pub needs: Vec<&'static str>,
}

/// Settings that were tried under a limit.
#[derive(Debug, Clone, Serialize)]
pub struct TriedSettings {
    /// Settings of the file.
    #[serde(flatten)]
    pub settings: FlatSettings,
    /// Size, bytes.
    pub bytes: u64,
    /// Whether the size is within the limit.
    pub fits: bool,
    /// Root mean square error of pixels, levels of 0 to 255, where it was measured.
    pub image_rmse_levels: Option<f64>,
}

impl FlattenReport {
    /// Returns the report of a conversion to a file of a name, under a limit of bytes if there was one.
    pub fn new(
        out: String,
        flat: &Flattened,
        framed: &FramedCharacter<'_>,
        max_bytes: Option<u64>,
    ) -> Self {
        let per = |bytes| flat.per_triangle_and_frame(bytes);
        Self {
            out,
            profile: flat.profile.to_string(),
            bytes: FlatBytes {
                raw: flat.sizes.raw,
                gzip: flat.sizes.gzip,
                brotli: flat.sizes.brotli,
            },
            triangles_of_character: framed.triangles_of_character(),
            triangles: framed.triangles.len(),
            triangles_drawn: flat.triangles_drawn,
            frames: flat.frames,
            fps: flat.fps,
            duration_secs: flat.frames.saturating_sub(1) as f64 / f64::from(flat.fps),
            size_px: framed.size_px(),
            shapes: flat.shapes,
            keys: flat.keys,
            orders: flat.orders,
            bytes_per_triangle_and_frame: BytesPerTriangle {
                raw: per(flat.sizes.raw),
                brotli: per(flat.sizes.brotli),
            },
            settings: FlatSettings::new(&flat.quality),
            error: FlatErrors::new(flat),
            representation: RepresentationReport::new(flat.representation()),
            texture: flat.texture.map(|texture| FlatTexture {
                triangles: texture.triangles,
                size_px: texture.size_px,
                bytes: texture.bytes,
            }),
            triangle_choice: TriangleChoice::new(framed),
            max_bytes,
            bytes_over: flat.bytes_over,
            dropped_detail: dropped(flat).map(DetailDifference::new).collect(),
            warnings: Vec::new(),
            tried: max_bytes.map_or_else(Vec::new, |most| {
                let tried = flat.tried.iter();
                tried.map(|t| TriedSettings::new(t, most)).collect()
            }),
        }
    }
}

/// Painted detail that is dropped visibly.
fn dropped(flat: &Flattened) -> impl Iterator<Item = &DroppedDetail> {
    let all = flat.dropped_detail.iter();
    all.filter(|d| d.worst.delta_e > DETAIL_DELTA_E)
}

impl WorstByPart {
    fn new(local: &LocalDifferences) -> Self {
        let of = |worst: Option<WorstDifference>| worst.as_ref().map(LocalDifference::new);
        Self {
            face: of(local.of(JudgedRegion::Face)),
            rest: of(local.rest()),
        }
    }
}

impl LocalDifference {
    fn new(worst: &WorstDifference) -> Self {
        Self {
            delta_e: worst.delta_e,
            region: worst.region.to_string(),
            x: worst.x,
            y: worst.y,
            frame: worst.frame,
        }
    }
}

impl DetailDifference {
    fn new(detail: &DroppedDetail) -> Self {
        Self {
            mesh: detail.mesh.clone(),
            worst: LocalDifference::new(&detail.worst),
        }
    }
}

impl TriangleChoice {
    /// `None` if the count was given or all triangles are kept.
    fn new(framed: &FramedCharacter<'_>) -> Option<Self> {
        let weights = framed.weights();
        let tried: Vec<TriedCount> = framed.tried().iter().map(TriedCount::new).collect();
        (!tried.is_empty()).then_some(Self {
            count: framed.count(),
            face_weight: weights.face,
            hands_weight: weights.hands,
            tried,
        })
    }
}

impl TriedCount {
    fn new(tried: &TriedTriangles) -> Self {
        Self {
            count: tried.count,
            triangles: tried.triangles,
            face_weight: tried.weights.face,
            hands_weight: tried.weights.hands,
            local: WorstByPart::new(&tried.local),
        }
    }
}

impl FlatSettings {
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

impl FlatErrors {
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
            local: local.as_ref().map(WorstByPart::new),
            stray_pixels_percent: errors.stray_pixels_percent,
            wrong_pixels_percent: errors.wrong_pixels_percent,
            wrong_pixels_percent_depth_sort: errors.wrong_pixels_percent_depth_sort,
        }
    }
}

impl RepresentationReport {
    /// Of an encoding.
    pub fn new(entry: Representation) -> Self {
        Self {
            modality: entry.modality,
            bytes: entry.bytes,
            error_px: entry.error_px,
            needs: entry.needs,
        }
    }
}

impl TriedSettings {
    fn new(trial: &TriedQuality, most: u64) -> Self {
        Self {
            settings: FlatSettings::new(&trial.quality),
            bytes: trial.bytes,
            fits: trial.bytes <= most,
            image_rmse_levels: trial.image.map(|i| i.rmse_levels),
        }
    }
}
