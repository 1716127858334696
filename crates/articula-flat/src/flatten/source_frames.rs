//! Pictures of the character itself, all triangles and textures included, and the largest local
//! difference from them.
//!
//! Source: `docs/methods/vector.md` 9. The reference pictures of [`super::ReferenceFrames`] show
//! the simplified character, so they do not show what simplification and vertex colours lost.

use crate::compare::same_size;
use crate::item_buffer::Supersampling;
use crate::local_difference::{
    JudgedRegion, LocalDifferences, WorstDifference, extended, local_differences, reach_px,
    sigma_px,
};
use crate::picture::{Picture, Rgba};
use crate::planar::reference::reference;
use crate::planar::source_picture::SourcePainter;
use crate::planar::{BakeOptions, PlanarClip, PlanarError, PlanarSubject, Shading};

/// Background of the compared pictures.
pub(super) const BACKGROUND: Rgba = [255; 4];
/// Samples per pixel of the pictures of a clip.
const SAMPLES: Supersampling = Supersampling::Four;

/// Factor on the width of the Gaussian where bodies are judged, which have no details like a mouth.
const COARSER: f32 = 1.3;

/// Pictures of a character at some times of its clip, with the region that each pixel shows.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceFrames {
    frames: Vec<SourceFrame>,
    sigma_px: f32,
}

#[derive(Debug, Clone, PartialEq)]
struct SourceFrame {
    frame: f64,
    picture: Picture,
    regions: Vec<Option<JudgedRegion>>,
}

/// A time of the clip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SourceTime {
    /// Number of the frame; fractional between two frames.
    pub frame: f64,
    /// Time in seconds of the clip.
    pub secs: f64,
}

/// Painted detail that vertex colours do not show.
#[derive(Debug, Clone, PartialEq)]
pub struct DroppedDetail {
    /// Name of the mesh that shows it.
    pub mesh: String,
    /// The largest local difference between texture and vertex colours on the same triangles.
    pub worst: WorstDifference,
}

impl SourceFrames {
    /// Draws the subject at some times; `regions` has one value for each vertex of the mesh, or is
    /// empty if all of it is [`JudgedRegion::Body`].
    ///
    /// O(times x (vertices + samples covered)).
    ///
    /// # Errors
    /// [`PlanarError::Mismatch`] if `regions` does not belong to the mesh;
    /// [`PlanarError::Picture`] if the camera's picture is too large.
    pub fn new(
        subject: &PlanarSubject<'_>,
        regions: &[JudgedRegion],
        times: &[SourceTime],
        options: &BakeOptions,
    ) -> Result<Self, PlanarError> {
        let vertices = subject.mesh.len();
        if !regions.is_empty() && regions.len() != vertices {
            let found = regions.len();
            return Err(PlanarError::Mismatch {
                at: "regions",
                what: format!("{found} values, the mesh has {vertices} vertices"),
            });
        }
        let mut painter = SourcePainter::new(subject, options)?;
        let mut frames = Vec::with_capacity(times.len());
        let mut tallest = 0;
        for time in times {
            painter.pose(time.secs);
            let picture = painter.textured(BACKGROUND)?;
            let of = |t: Option<u32>| Some(region_of(regions, &subject.triangles[t? as usize]));
            let shown: Vec<_> = painter.triangles().into_iter().map(of).collect();
            tallest = tallest.max(height_of(&shown, picture.width()));
            frames.push(SourceFrame {
                frame: time.frame,
                picture,
                regions: shown,
            });
        }
        let sigma_px = sigma_px(tallest);
        for frame in &mut frames {
            let shown = std::mem::take(&mut frame.regions);
            let width = frame.picture.width() as usize;
            frame.regions = extended(shown, width, reach_px(sigma_px));
        }
        Ok(Self { frames, sigma_px })
    }

    /// Index of a time by its number of the frame.
    pub(super) fn at(&self, frame: f64) -> Option<usize> {
        self.frames.iter().position(|f| f.frame == frame)
    }

    /// Differences of a picture at one of the times.
    ///
    /// # Errors
    /// [`PlanarError::Picture`] if it has another size.
    pub(super) fn compare(
        &self,
        index: usize,
        shown: &Picture,
    ) -> Result<LocalDifferences, PlanarError> {
        let frame = &self.frames[index];
        same_size(&frame.picture, shown)?;
        let of = |regions: &[JudgedRegion], sigma_px: f32| {
            let is_judged = |held: &Option<JudgedRegion>| held.filter(|r| regions.contains(r));
            let judged: Vec<_> = frame.regions.iter().map(is_judged).collect();
            local_differences(&frame.picture, shown, &judged, sigma_px, frame.frame)
        };
        let mut all = of(&[JudgedRegion::Face, JudgedRegion::Hands], self.sigma_px);
        all.add(&of(&[JudgedRegion::Body], COARSER * self.sigma_px));
        Ok(all)
    }

    /// Returns the largest local differences of a clip with one frame for each of the times, shown
    /// with one gradient for each triangle: the least difference that any file of it has.
    ///
    /// O(times x pixels).
    ///
    /// # Errors
    /// [`PlanarError::Mismatch`] for another number of frames; [`PlanarError::Picture`] for
    /// another size of the picture.
    pub fn judge(&self, clip: &PlanarClip) -> Result<LocalDifferences, PlanarError> {
        if clip.frames.len() != self.frames.len() {
            let (found, expected) = (clip.frames.len(), self.frames.len());
            return Err(PlanarError::Mismatch {
                at: "frames",
                what: format!("the clip has {found} frames, expected {expected}"),
            });
        }
        let mut all = LocalDifferences::default();
        for f in 0..self.frames.len() {
            all.add(&self.compare(f, &reference(clip, f, SAMPLES, BACKGROUND)?)?);
        }
        Ok(all)
    }
}

/// Returns the painted detail that vertex colours do not show on the triangles of a subject, for
/// each region; empty without textures. The triangles are the same in both pictures, so that only
/// colour is compared; `times` and `regions` as for [`SourceFrames::new`].
///
/// # Errors
/// As [`SourceFrames::new`].
pub fn dropped_detail(
    subject: &PlanarSubject<'_>,
    regions: &[JudgedRegion],
    times: &[SourceTime],
    options: &BakeOptions,
    shading: Shading,
) -> Result<Vec<DroppedDetail>, PlanarError> {
    let materials = &subject.appearance.materials;
    if !materials
        .iter()
        .any(|m| subject.appearance.detail_of(m).is_some())
    {
        return Ok(Vec::new());
    }
    let textured = SourceFrames::new(subject, regions, times, options)?;
    let mut painter = SourcePainter::new(subject, options)?;
    let mut found: Vec<DroppedDetail> = Vec::new();
    for (f, time) in times.iter().enumerate() {
        painter.pose(time.secs);
        let plain = painter.untextured(shading, BACKGROUND)?;
        let differences = textured.compare(f, &plain)?;
        let regions = [JudgedRegion::Face, JudgedRegion::Hands, JudgedRegion::Body];
        for worst in regions.into_iter().filter_map(|r| differences.of(r)) {
            let known = found.iter_mut().find(|d| d.worst.region == worst.region);
            if known
                .as_ref()
                .is_some_and(|d| d.worst.delta_e >= worst.delta_e)
            {
                continue;
            }
            let mesh = painter.mesh_at(worst.x, worst.y).unwrap_or_default();
            let new = DroppedDetail { mesh, worst };
            match known {
                Some(known) => *known = new,
                None => found.push(new),
            }
        }
    }
    Ok(found)
}

/// Region of most corners of a triangle.
fn region_of(regions: &[JudgedRegion], triangle: &[u32; 3]) -> JudgedRegion {
    let mut all = triangle.map(|v| regions.get(v as usize).copied().unwrap_or_default());
    all.sort_unstable();
    all[1]
}

fn height_of(shown: &[Option<JudgedRegion>], width: u32) -> u32 {
    let width = width.max(1) as usize;
    let first = shown.iter().position(Option::is_some);
    let last = shown.iter().rposition(Option::is_some);
    first
        .zip(last)
        .map_or(0, |(first, last)| (last / width - first / width + 1) as u32)
}
