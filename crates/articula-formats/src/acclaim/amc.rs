//! Parser of motion files: per frame, the values of each bone that moves.

use super::asf::{Dof, SkeletonText, words};
use super::hierarchy::Hierarchy;
use crate::error::ReadError;
use crate::limits::Limits;
use crate::notes::Notes;
use crate::words::{FRAME_TIMES_SECS, MAX_FRAMES, number, shortened};

/// Keyword of the rate, in files that state it.
pub(super) const RATE: &str = "samples-per-second";

/// Values of one bone in one frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Row {
    pub(super) frame: usize,
    /// Index of the first one among the motion's values.
    pub(super) first_value: usize,
}

/// The content of a motion file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct MotionText {
    pub(super) rate_hz: Option<f32>,
    /// Whether angles are in degrees, if the file states it.
    pub(super) degrees: Option<bool>,
    pub(super) frames: usize,
    /// Rows of every slot of the hierarchy, by ascending frame. A frame without a row holds the
    /// last one.
    pub(super) rows: Vec<Vec<Row>>,
    pub(super) values: Vec<f32>,
}

/// The bones that a motion drives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bones<'a> {
    pub(super) text: &'a SkeletonText,
    pub(super) tree: &'a Hierarchy,
}

impl<'a> Bones<'a> {
    /// Returns the degrees of freedom of a slot.
    pub(super) fn dofs(&self, slot: usize) -> &'a [Dof] {
        match self.tree.bones[slot] {
            None => &self.text.root_dofs,
            Some(bone) => &self.text.bones[bone].dofs,
        }
    }
}

/// Formats a position in the motion file for error messages.
fn at(line: usize) -> String {
    format!("amc line {line}")
}

/// Reads a whole motion file.
pub(super) fn parse(
    text: &str,
    bones: Bones<'_>,
    limits: &Limits,
    notes: &mut Notes,
) -> Result<MotionText, ReadError> {
    let mut motion = MotionText {
        rows: vec![Vec::new(); bones.tree.bones.len()],
        ..MotionText::default()
    };
    let mut expected = None;
    let mut skipped = false;
    for (index, text) in text.lines().enumerate() {
        let line = index + 1;
        if let Some((_, comment)) = text.split_once('#') {
            motion.comment(line, comment)?;
        }
        let words = words(text);
        let Some((&first, rest)) = words.split_first() else {
            continue;
        };
        if let Some(keyword) = first.strip_prefix(':') {
            motion.keyword(line, keyword, rest, notes)?;
        } else if rest.is_empty() && first.bytes().all(|b| b.is_ascii_digit()) {
            let frames = motion.frames as u64 + 1;
            Limits::check(at(line), "frames", frames, limits.frames.min(MAX_FRAMES))?;
            motion.frames += 1;
            let frame = first.parse::<u64>().ok();
            if frame != expected && motion.frames > 1 && !skipped {
                skipped = true;
                let what =
                    "the frame numbers are not consecutive; the frames are read in file order";
                notes.add(at(line), what);
            }
            expected = frame.and_then(|f| f.checked_add(1));
        } else {
            motion.row(line, first, rest, bones)?;
            let elements = motion.values.len() as u64;
            Limits::check(at(line), "key values", elements, limits.elements)?;
        }
    }
    if motion.frames == 0 {
        notes.add(
            "amc",
            "the file has no frame; the figure is read without a clip",
        );
    }
    Ok(motion)
}

impl MotionText {
    /// Reads the rate from a comment, where some writers put it because the format has no field for
    /// it.
    fn comment(&mut self, line: usize, comment: &str) -> Result<(), ReadError> {
        let mut words = comment.split_whitespace();
        let first = words.next().unwrap_or_default().trim_start_matches(':');
        if !first.eq_ignore_ascii_case(RATE) {
            return Ok(());
        }
        self.rate(line, words.next().unwrap_or_default())
    }

    fn keyword(
        &mut self,
        line: usize,
        keyword: &str,
        rest: &[&str],
        notes: &mut Notes,
    ) -> Result<(), ReadError> {
        match keyword.to_ascii_lowercase().as_str() {
            "degrees" => self.degrees = Some(true),
            "radians" => self.degrees = Some(false),
            "fully-specified" => {}
            RATE => self.rate(line, rest.first().copied().unwrap_or_default())?,
            _ => {
                let what = format!("unknown keyword \":{}\"; ignored", shortened(keyword));
                notes.add(at(line), what);
            }
        }
        Ok(())
    }

    fn rate(&mut self, line: usize, word: &str) -> Result<(), ReadError> {
        let rate_hz = number(at(line), word)?;
        if !FRAME_TIMES_SECS.contains(&rate_hz.recip()) {
            let what = format!("{rate_hz} frames per second found, more than 0 expected");
            return Err(ReadError::malformed(at(line), what));
        }
        self.rate_hz = Some(rate_hz);
        Ok(())
    }

    fn row(
        &mut self,
        line: usize,
        name: &str,
        words: &[&str],
        bones: Bones<'_>,
    ) -> Result<(), ReadError> {
        let is_root = name.eq_ignore_ascii_case("root");
        let slot = bones.tree.names.get(name).copied();
        let Some(slot) = slot.or(is_root.then_some(Some(0))) else {
            let name = shortened(name);
            let what = format!(
                "the skeleton has no bone \"{name}\"; use the .asf file that belongs to this \
                 motion"
            );
            return Err(ReadError::malformed(at(line), what));
        };
        // A bone outside of the hierarchy was already reported.
        let Some(slot) = slot else { return Ok(()) };
        let Some(frame) = self.frames.checked_sub(1) else {
            let what = "values of a bone found, the number of the first frame expected";
            return Err(ReadError::malformed(at(line), what));
        };
        let dofs = bones.dofs(slot);
        if words.len() != dofs.len() {
            let what = format!(
                "{} values of \"{}\" found, {} expected (its degrees of freedom in the .asf)",
                words.len(),
                shortened(name),
                dofs.len()
            );
            return Err(ReadError::malformed(at(line), what));
        }
        if self.rows[slot].last().is_some_and(|r| r.frame == frame) {
            let what = format!("\"{}\" occurs twice in one frame", shortened(name));
            return Err(ReadError::malformed(at(line), what));
        }
        self.rows[slot].push(Row {
            frame,
            first_value: self.values.len(),
        });
        for word in words {
            self.values
                .push(number(format_args!("amc line {line}"), word)?);
        }
        Ok(())
    }
}
