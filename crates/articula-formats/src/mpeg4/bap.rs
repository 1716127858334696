//! BAP text: body animation parameters, frame by frame, and the body that they drive.
//!
//! Source: the format of the reference encoder, versions 3.1 and 3.2 (`docs/formats/mpeg4.md`). The
//! standard defines 186 parameters; 110 more are extensions with an application-defined meaning.

use super::parameter_text::{self, Frame, Layout, Reader};
use crate::{Limits, Parsed, ReadError, Warning};

pub use super::bap_body::{character, figure};
pub use super::bap_sample::{BapError, BapResidual, SampledBap, sample};
pub(super) use super::bap_table::{BAPS, Motion, TABLE};
pub use super::fap::AbsentPolicy;

/// Number of parameters with extensions.
const WITH_EXTENSIONS: usize = 296;
const VERSIONS: [&str; 2] = ["3.1", "3.2"];

const LAYOUT: Layout = Layout {
    format: "BAP",
    widths: &[BAPS, WITH_EXTENSIONS],
    fields: |_| 1,
};

/// Values of all body animation parameters in one frame.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct BapFrame {
    /// Frame number; ascending, with gaps allowed.
    pub number: u32,
    /// BAP 1 at index 0, and so on: 186 values or, with extensions, 296. Rotations are in 1e-5 rad,
    /// translations in millimetres.
    pub values: Vec<i32>,
}

/// A clip of body animation parameters, as read from a BAP file.
#[derive(Debug, Clone, PartialEq)]
pub struct BapClip {
    /// Name as given by the header.
    pub name: String,
    /// Frames per second.
    pub rate_hz: f32,
    /// Parameters that the mask of at least one frame includes; same length as a frame's values.
    pub coded: Vec<bool>,
    /// The frames, in order of their numbers; all have the same number of values.
    pub frames: Vec<BapFrame>,
}

impl BapClip {
    /// Returns which parameters are other than 0 in at least one frame; same length as a frame's
    /// values.
    pub(super) fn moving(&self) -> Vec<bool> {
        let mut moving = vec![false; self.coded.len()];
        for frame in &self.frames {
            for (moves, value) in moving.iter_mut().zip(&frame.values) {
                *moves |= *value != 0;
            }
        }
        moving
    }
}

/// Reads a BAP file.
///
/// # Errors
/// [`ReadError`] with the line, if the text does not have this format or exceeds the limits.
pub fn read(
    bytes: &[u8],
    absent: AbsentPolicy,
    limits: &Limits,
) -> Result<Parsed<BapClip>, ReadError> {
    let (mut reader, header) = Reader::new(bytes, &LAYOUT, limits)?;
    parameter_text::check_version(&header, &VERSIONS, &mut reader.warnings);
    let mut clip = BapClip {
        name: header.name,
        rate_hz: header.rate_hz,
        coded: vec![false; BAPS],
        frames: Vec::new(),
    };
    let (mut raw, mut body) = (Frame::default(), BapFrame::default());
    while reader.next(&mut raw)? {
        if clip.frames.is_empty() {
            clip.coded = vec![false; raw.mask.len()];
            body.values = vec![0; raw.mask.len()];
        }
        if absent == AbsentPolicy::Zero {
            body.values.fill(0);
        }
        body.number = raw.number;
        let mut fields = raw.fields.iter();
        for (index, set) in raw.mask.iter().enumerate() {
            if *set {
                clip.coded[index] = true;
                body.values[index] = fields.next().copied().unwrap_or(0);
            }
        }
        clip.frames.push(body.clone());
    }
    let mut warnings = reader.warnings;
    let extensions = clip.moving().iter().skip(BAPS).filter(|m| **m).count();
    if extensions > 0 {
        let what = format!(
            "{extensions} of the extension parameters 187 to {WITH_EXTENSIONS} are animated; they \
             are kept, but no joint uses them"
        );
        warnings.push(Warning::new("values", what));
    }
    Ok(Parsed {
        value: clip,
        warnings,
    })
}

/// Writes a BAP file; the mask of every frame includes all parameters that move in the clip.
/// Version 3.2 if an extension moves, else 3.1.
pub fn write(clip: &BapClip) -> Vec<u8> {
    let mut mask = clip.moving();
    let extended = mask.iter().skip(BAPS).any(|moves| *moves);
    let (version, width) = if extended {
        (VERSIONS[1], WITH_EXTENSIONS)
    } else {
        (VERSIONS[0], BAPS)
    };
    mask.resize(width, false);
    let line = parameter_text::mask_line(&mask);
    let mut text = String::new();
    let frames = clip.frames.len();
    parameter_text::write_header(&mut text, version, &clip.name, clip.rate_hz, frames);
    for frame in &clip.frames {
        let set = frame.values.iter().zip(&mask).filter(|(_, set)| **set);
        let values = set.map(|(value, _)| *value);
        parameter_text::write_frame(&mut text, &line, frame.number, values);
    }
    text.into_bytes()
}
