//! The vector graphics of the thesis, as it describes them: the baseline of size ratios.
//!
//! Source: thesis 4.2, 6.2.2; `docs/methods/vector.md` 8.6. Triangles are sorted by depth once, at
//! the neutral frame; whole faces are switched by back-face and frustum culling, never by
//! occlusion; a face has one colour, and Gouraud shading is for stills. The file plays once and
//! stays at its last frame, since the thesis does not specify otherwise. Differs: the figures with
//! the SVG text are lost, so the element wording is ours, chosen so that the sizes are close to the
//! printed ones ([`formula_bytes`]); faces that are in view in no frame are left out.
//!
//! - `document`: head and tail of a file, and its clock
//! - `faces`: culling, painting order and colour of faces
//! - `polygon`, `path`, `gouraud`: the three forms

mod document;
mod faces;
mod gouraud;
mod path;
mod polygon;

use crate::item_buffer::Supersampling;
use crate::picture::{Picture, Rgba};
use crate::planar::reference::reference;
use crate::planar::{PlanarClip, PlanarError, PlanarFrame};
use document::{Clock, Document};
use faces::Faces;

/// Approximate maximum number of bytes written.
const MAX_BYTES: usize = 1 << 30;

/// SVG elements that the thesis uses for a clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ThesisForm {
    /// A `polygon` for each face and frame in view, shown for that frame.
    Polygon,
    /// A `path` for each face, with the absolute coordinates of every frame.
    Path,
    /// One frame with three gradients per face.
    GouraudStill {
        /// Index of the frame.
        frame: usize,
    },
}

impl ThesisForm {
    /// Whether colours vary inside a face.
    pub(crate) fn is_gouraud(self) -> bool {
        matches!(self, Self::GouraudStill { .. })
    }
}

/// Form, and the optimisations of thesis 4.2.3 for [`ThesisForm::Path`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ThesisSvgOptions {
    /// SVG elements that are written.
    pub form: ThesisForm,
    /// Whether coordinates are omitted while a face is hidden.
    pub optimise_hidden: bool,
    /// Whether coordinates are omitted while a face is in view and does not move.
    pub optimise_static: bool,
    /// Frame whose depths give the painting order, and whose light gives the colours of paths.
    pub neutral_frame: usize,
}

impl Default for ThesisSvgOptions {
    fn default() -> Self {
        Self {
            form: ThesisForm::Path,
            optimise_hidden: false,
            optimise_static: false,
            neutral_frame: 0,
        }
    }
}

/// An SVG file in a form of the thesis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ThesisFile {
    /// The SVG.
    pub text: String,
    /// Number of its elements, the root included.
    pub elements: usize,
    /// Number of faces in view in some frame; *nbp* in the thesis.
    pub triangles: usize,
    /// Number of pairs of a face and a frame in view.
    pub shown: usize,
}

/// Size in bytes that the thesis states (6.2.2): `286 nbp nbf` for polygons, `352 nbp + 56 nbp nbf`
/// for paths, 1252 for each face of a Gouraud still.
pub(crate) fn formula_bytes(form: ThesisForm, triangles: usize, frames: usize) -> usize {
    match form {
        ThesisForm::Polygon => 286 * triangles * frames,
        ThesisForm::Path => 352 * triangles + 56 * triangles * frames,
        ThesisForm::GouraudStill { .. } => 1252 * triangles,
    }
}

/// Writes a clip as an SVG in a form of the thesis.
///
/// O(faces x frames).
///
/// # Errors
/// Errors of the clip; [`PlanarError::NothingVisible`] if no face is in view;
/// [`PlanarError::Mismatch`] for a frame that the clip does not have, frames shorter than a
/// millisecond, or a file above a gigabyte.
pub fn thesis(clip: &PlanarClip, options: &ThesisSvgOptions) -> Result<ThesisFile, PlanarError> {
    clip.check()?;
    has_frame(clip, "neutral_frame", options.neutral_frame)?;
    let faces = match options.form {
        ThesisForm::GouraudStill { frame } => {
            has_frame(clip, "form.frame", frame)?;
            Faces::of(clip, frame..frame + 1, options.neutral_frame)?
        }
        _ => Faces::of(clip, 0..clip.frames.len(), options.neutral_frame)?,
    };
    if faces.order.is_empty() {
        return Err(PlanarError::NothingVisible);
    }
    let (triangles, shown) = (faces.order.len(), faces.shown());
    fits(match options.form {
        ThesisForm::Polygon => formula_bytes(options.form, 1, shown),
        form => formula_bytes(form, triangles, clip.frames.len()),
    })?;
    let clock = Clock::new(clip.fps)?;
    let mut document = Document::new(clip.width, clip.height);
    match options.form {
        ThesisForm::Polygon => polygon::write(clip, &faces, clock, document.text()),
        ThesisForm::Path => path::write(clip, &faces, options, clock, document.text()),
        ThesisForm::GouraudStill { frame } => {
            gouraud::write(clip, frame, &faces.order, document.text());
        }
    }
    let (text, elements) = document.end();
    Ok(ThesisFile {
        text,
        elements,
        triangles,
        shown,
    })
}

/// Returns what a file of flat faces shows at a time in frames, as still SVG: for readers without
/// animation, such as [`super::raster`]. Paths are interpolated between frames, polygons switch.
///
/// # Errors
/// As [`thesis`].
pub(crate) fn thesis_frame(
    clip: &PlanarClip,
    options: &ThesisSvgOptions,
    moment: f64,
) -> Result<String, PlanarError> {
    clip.check()?;
    // A negative or non-finite time becomes a frame that does not exist.
    let frame = if moment >= 0.0 { moment } else { f64::MAX } as usize;
    has_frame(clip, "moment", frame)?;
    let next = (frame + 1).min(clip.frames.len() - 1);
    let faces = Faces::of(clip, frame..next + 1, options.neutral_frame)?;
    let is_path = options.form == ThesisForm::Path;
    let color_frame = if is_path {
        options.neutral_frame
    } else {
        frame
    };
    let share = if is_path { moment.fract() as f32 } else { 0.0 };
    let mut document = Document::new(clip.width, clip.height);
    for face in faces.order.iter().filter(|t| faces.is_shown(frame, **t)) {
        let (mut corners, to) = (
            clip.places(frame, *face as usize),
            clip.places(next, *face as usize),
        );
        if !options.optimise_hidden || faces.is_shown(next, *face) {
            corners = [0, 1, 2].map(|k| corners[k].lerp(to[k], share));
        }
        let color = faces::mean_color(clip, color_frame, *face);
        polygon::write_still(*face, corners, color, document.text());
    }
    Ok(document.end().0)
}

/// Returns what a Gouraud still shows: faces in the thesis' order, coloured by barycentric weights.
/// Computed from the clip, since not every reader of SVG supports the filters of the file.
///
/// # Errors
/// As [`thesis`], and [`PlanarError::Picture`] if the picture is too large.
pub(crate) fn thesis_gouraud_picture(
    clip: &PlanarClip,
    frame: usize,
    options: &ThesisSvgOptions,
    background: Rgba,
) -> Result<Picture, PlanarError> {
    clip.check()?;
    has_frame(clip, "form.frame", frame)?;
    let faces = Faces::of(clip, frame..frame + 1, options.neutral_frame)?;
    let from = &clip.frames[frame];
    let mut only = PlanarFrame::default();
    let mut painted = PlanarClip {
        frames: Vec::new(),
        triangles: Vec::new(),
        surface: Vec::new(),
        part: Vec::new(),
        albedo: Vec::new(),
        texture: None,
        ..clip.clone()
    };
    // Later faces are nearer, so that the depth buffer shows the painting order.
    for (rank, face) in (1..).zip(&faces.order) {
        let first = only.xy.len() as u32;
        for v in clip.triangles[*face as usize].map(|v| v as usize) {
            only.xy.push(from.xy[v]);
            only.nearness.push(rank as f32);
            only.light.push(from.light[v]);
            painted.albedo.push(clip.albedo[v]);
        }
        painted.triangles.push([first, first + 1, first + 2]);
        painted.surface.push(clip.surface[*face as usize]);
        painted.part.push(clip.part[*face as usize]);
    }
    painted.frames.push(only);
    Ok(reference(&painted, 0, Supersampling::Four, background)?)
}

fn has_frame(clip: &PlanarClip, at: &'static str, frame: usize) -> Result<(), PlanarError> {
    let frames = clip.frames.len();
    if frame < frames {
        return Ok(());
    }
    let what = format!("frame {frame} is out of range: the clip has {frames} frames");
    Err(PlanarError::Mismatch { at, what })
}

fn fits(bytes: usize) -> Result<(), PlanarError> {
    if bytes <= MAX_BYTES {
        return Ok(());
    }
    let what = format!(
        "the file in the format of the thesis would take about {bytes} bytes, the limit is \
         {MAX_BYTES}; choose fewer triangles or frames"
    );
    Err(PlanarError::Mismatch { at: "clip", what })
}

#[cfg(test)]
mod tests;
