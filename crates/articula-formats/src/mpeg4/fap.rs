//! FAP text: facial animation parameters, frame by frame.
//!
//! Source: the format of the reference encoder, versions 2.1 and 2.2 (`docs/formats/mpeg4.md`); the
//! meaning of each parameter is the table of [`articula_core::fap_table`].

use super::parameter_text::{self, Frame, Layout, Reader};
use crate::{Limits, Parsed, ReadError, Warning};
use articula_core::fap_table::{FAP_COUNT, LOW_FAP_COUNT, TABLE};

/// Number of high-level parameters, which come first.
const HIGH: usize = 2;
const VERSIONS: [&str; 2] = ["2.1", "2.2"];
/// First words of the comment that names how blend shapes became parameters.
const BRIDGE: &str = "# articula-bridge ";
/// Greatest length of that name in bytes.
const BRIDGE_LENGTH: usize = 64;
/// Maximum viseme, expression, and weight of either.
const HIGHEST: (i32, i32, i32) = (14, 6, 63);

const LAYOUT: Layout = Layout {
    format: "FAP",
    widths: &[FAP_COUNT],
    fields: |index| match index {
        0 => 4,
        1 => 6,
        _ => 1,
    },
};

/// FAP 1: a blend of two visemes; all fields zero mean none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Viseme {
    /// First viseme, 0 to 14.
    pub select1: u8,
    /// Second viseme, 0 to 14.
    pub select2: u8,
    /// Weight of the first in 63rds; the second has the rest.
    pub blend: u8,
    /// Whether the low-level parameters of the frame define the viseme.
    pub defines: bool,
}

/// FAP 2: a sum of two expressions; all fields zero mean none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FapExpression {
    /// First expression, 0 to 6.
    pub select1: u8,
    /// Intensity of the first in 63rds.
    pub intensity1: u8,
    /// Second expression, 0 to 6.
    pub select2: u8,
    /// Intensity of the second in 63rds.
    pub intensity2: u8,
    /// Whether the low-level parameters first set the neutral face.
    pub init_face: bool,
    /// Whether the low-level parameters of the frame define the expression.
    pub defines: bool,
}

/// Values of all facial animation parameters in one frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FapFrame {
    /// Frame number; ascending, with gaps allowed.
    pub number: u32,
    /// FAP 1.
    pub viseme: Viseme,
    /// FAP 2.
    pub expression: FapExpression,
    /// FAP 3 at index 0 up to FAP 68, each in its unit.
    pub low: [i32; LOW_FAP_COUNT],
}

impl Default for FapFrame {
    fn default() -> Self {
        Self {
            number: 0,
            viseme: Viseme::default(),
            expression: FapExpression::default(),
            low: [0; LOW_FAP_COUNT],
        }
    }
}

impl FapFrame {
    /// Returns whether a parameter (index 0 is FAP 1) differs from the neutral face.
    fn moves(&self, index: usize) -> bool {
        match index {
            0 => self.viseme != Viseme::default(),
            1 => self.expression != FapExpression::default(),
            _ => self.low[index - HIGH] != 0,
        }
    }
}

/// A clip of facial animation parameters, as read from a FAP file.
#[derive(Debug, Clone, PartialEq)]
pub struct FapClip {
    /// Name as given by the header; some writers put a whole path there.
    pub name: String,
    /// Frames per second.
    pub rate_hz: f32,
    /// Parameters that the mask of at least one frame includes; index 0 is FAP 1.
    pub coded: [bool; FAP_COUNT],
    /// The frames, in order of their numbers.
    pub frames: Vec<FapFrame>,
    /// If the parameters were made from blend shapes, the name of the columns by which, from a comment
    /// of the file (`docs/formats/mpeg4.md`).
    pub bridge: Option<String>,
}

impl FapClip {
    /// Returns which parameters are other than neutral in at least one frame; index 0 is FAP 1.
    pub fn moving(&self) -> [bool; FAP_COUNT] {
        std::array::from_fn(|index| self.frames.iter().any(|frame| frame.moves(index)))
    }

    /// Returns the minimum and maximum value of a low-level parameter, by its number (3 to 68);
    /// `None` for any other and without a frame.
    pub fn range(&self, fap: usize) -> Option<(i32, i32)> {
        let index = fap
            .checked_sub(1 + HIGH)
            .filter(|index| *index < LOW_FAP_COUNT)?;
        let values = || self.frames.iter().map(|frame| frame.low[index]);
        Some((values().min()?, values().max()?))
    }
}

/// Value that a parameter has in a frame whose mask omits it: held or neutral.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AbsentPolicy {
    /// It keeps its value: mask types 0 and 1 of the standard.
    #[default]
    Hold,
    /// It is neutral, as the reference encoder assumes.
    Zero,
}

/// Reads a FAP file.
///
/// # Errors
/// [`ReadError`] with the line, if the text does not have this format or exceeds the limits.
pub fn read(
    bytes: &[u8],
    absent: AbsentPolicy,
    limits: &Limits,
) -> Result<Parsed<FapClip>, ReadError> {
    let (mut reader, header) = Reader::new(bytes, &LAYOUT, limits)?;
    parameter_text::check_version(&header, &VERSIONS, &mut reader.warnings);
    let mut clip = FapClip {
        name: header.name,
        rate_hz: header.rate_hz,
        coded: [false; FAP_COUNT],
        frames: Vec::new(),
        bridge: bridge(bytes),
    };
    let (mut raw, mut face) = (Frame::default(), FapFrame::default());
    while reader.next(&mut raw)? {
        if absent == AbsentPolicy::Zero {
            face = FapFrame::default();
        }
        face.number = raw.number;
        apply(&raw, &mut face)?;
        for (coded, set) in clip.coded.iter_mut().zip(&raw.mask) {
            *coded |= set;
        }
        clip.frames.push(face.clone());
    }
    let mut warnings = reader.warnings;
    warnings.extend(one_way(&clip));
    Ok(Parsed {
        value: clip,
        warnings,
    })
}

/// The name in the first comment that has one, if it consists of letters, digits and hyphens.
fn bridge(bytes: &[u8]) -> Option<String> {
    let mut lines = bytes.split(|b| matches!(b, b'\n' | b'\r'));
    let name = lines.find_map(|line| line.strip_prefix(BRIDGE.as_bytes()))?;
    let name = name.trim_ascii();
    let is_name = (1..=BRIDGE_LENGTH).contains(&name.len())
        && name.iter().all(|b| b.is_ascii_alphanumeric() || *b == b'-');
    is_name.then(|| String::from_utf8_lossy(name).into_owned())
}

/// Applies the values of a frame to the face.
fn apply(raw: &Frame, face: &mut FapFrame) -> Result<(), ReadError> {
    let mut fields = raw.fields.iter().copied();
    let mut next = |highest: i32, what: &str| {
        let value = fields.next().unwrap_or(0);
        let small = u8::try_from(value).ok().filter(|_| value <= highest);
        small.ok_or_else(|| {
            let what = format!("{what} {value} found, 0 to {highest} expected");
            ReadError::malformed(format!("line {}", raw.line), what)
        })
    };
    let (viseme, expression, weight) = HIGHEST;
    if raw.mask[0] {
        face.viseme = Viseme {
            select1: next(viseme, "viseme")?,
            select2: next(viseme, "viseme")?,
            blend: next(weight, "viseme blend")?,
            defines: next(1, "viseme_def")? == 1,
        };
    }
    if raw.mask[1] {
        face.expression = FapExpression {
            select1: next(expression, "expression")?,
            intensity1: next(weight, "expression intensity")?,
            select2: next(expression, "expression")?,
            intensity2: next(weight, "expression intensity")?,
            init_face: next(1, "init_face")? == 1,
            defines: next(1, "expression_def")? == 1,
        };
    }
    for (value, set) in face.low.iter_mut().zip(&raw.mask[HIGH..]) {
        if *set {
            *value = fields.next().unwrap_or(0);
        }
    }
    Ok(())
}

/// Returns warnings for negative values of unidirectional parameters.
fn one_way(clip: &FapClip) -> Vec<Warning> {
    let goes_back = |&(index, fap): &(usize, &articula_core::fap_table::Fap)| {
        let one_way = fap.action.is_some_and(|action| !action.two_sided);
        one_way && clip.range(index + 1).is_some_and(|(low, _)| low < 0)
    };
    let found = TABLE.iter().enumerate().filter(goes_back);
    found
        .map(|(index, fap)| {
            let what = "has negative values, which are undefined; kept unchanged";
            Warning::new(format!("FAP {} {}", index + 1, fap.name), what)
        })
        .collect()
}

/// Writes a FAP file, version 2.1; the mask of every frame includes all parameters that move in the
/// clip.
pub fn write(clip: &FapClip) -> Vec<u8> {
    let mask = clip.moving();
    let line = parameter_text::mask_line(&mask);
    let mut text = String::new();
    parameter_text::write_header(
        &mut text,
        VERSIONS[0],
        &clip.name,
        clip.rate_hz,
        clip.frames.len(),
    );
    if let Some(name) = &clip.bridge {
        text.extend([BRIDGE, name, "\n"]);
    }
    for frame in &clip.frames {
        parameter_text::write_frame(&mut text, &line, frame.number, fields(frame, &mask));
    }
    text.into_bytes()
}

fn fields(frame: &FapFrame, mask: &[bool; FAP_COUNT]) -> Vec<i32> {
    let mut fields: Vec<i32> = Vec::new();
    if mask[0] {
        let v = frame.viseme;
        let all = [v.select1, v.select2, v.blend, v.defines.into()];
        fields.extend(all.map(i32::from));
    }
    if mask[1] {
        let e = frame.expression;
        let first = [e.select1, e.intensity1, e.select2, e.intensity2];
        fields.extend(first.map(i32::from));
        fields.extend([e.init_face, e.defines].map(i32::from));
    }
    let low = frame.low.iter().zip(&mask[HIGH..]);
    fields.extend(low.filter(|(_, set)| **set).map(|(value, _)| value));
    fields
}
