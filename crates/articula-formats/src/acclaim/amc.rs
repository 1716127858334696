//! Parser of motion files: per frame, the values of each bone that moves.

use super::asf::{Dof, SkeletonText, words};
use super::hierarchy::Hierarchy;
use crate::damage::{Damage, hold};
use crate::error::ReadError;
use crate::limits::Limits;
use crate::notes::Notes;
use crate::units::MAX_NUMBER;
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
    /// Returns the slot of a bone's name; `None` for one outside of the hierarchy.
    fn slot(&self, line: usize, name: &str) -> Result<Option<usize>, ReadError> {
        let is_root = name.eq_ignore_ascii_case("root");
        let slot = self.tree.names.get(name).copied();
        slot.or(is_root.then_some(Some(0))).ok_or_else(|| {
            let name = shortened(name);
            let what = format!(
                "the skeleton has no bone \"{name}\"; use the .asf file that belongs to this \
                 motion"
            );
            ReadError::malformed(at(line), what)
        })
    }

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
    let mut rows = Rows::default();
    let last_line = text.trim_end().lines().count();
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
            rows.new_frame();
            let frame = first.parse::<u64>().ok();
            if frame != expected && motion.frames > 1 && !skipped {
                skipped = true;
                let what =
                    "the frame numbers are not consecutive; the frames are read in file order";
                notes.add(at(line), what);
            }
            expected = frame.and_then(|f| f.checked_add(1));
        } else {
            match bones.slot(line, first) {
                // A bone outside of the hierarchy was already reported.
                Ok(None) => {}
                Ok(Some(slot)) => rows.read(&mut motion, (line, slot), first, rest, bones)?,
                // The file ends within a name.
                Err(error) if line == last_line => rows.damaged(error),
                Err(error) => return Err(error),
            }
            let elements = motion.values.len() as u64;
            Limits::check(at(line), "key values", elements, limits.elements)?;
        }
    }
    rows.finish(&mut motion, bones, notes)?;
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
}

/// Reader of the rows, which knows how complete the frames are.
#[derive(Default)]
struct Rows {
    damage: Damage,
    all: usize,
    /// Rows of the current frame: all, and those that were read.
    in_frame: usize,
    read_in_frame: usize,
    /// Number of rows of each frame before, if they have the same.
    usual: Option<usize>,
    frames: usize,
}

impl Rows {
    fn new_frame(&mut self) {
        match self.frames {
            0 => {}
            1 => self.usual = Some(self.in_frame),
            _ => self.usual = self.usual.filter(|usual| *usual == self.in_frame),
        }
        self.frames += 1;
        (self.in_frame, self.read_in_frame) = (0, 0);
    }

    fn damaged(&mut self, error: ReadError) {
        self.all += 1;
        self.in_frame += 1;
        self.damage.row(error);
    }

    /// Reads the row of a slot; a damaged one is noted.
    fn read(
        &mut self,
        motion: &mut MotionText,
        (line, slot): (usize, usize),
        name: &str,
        words: &[&str],
        bones: Bones<'_>,
    ) -> Result<(), ReadError> {
        let Some(frame) = motion.frames.checked_sub(1) else {
            let what = "values of a bone found, the number of the first frame expected";
            return Err(ReadError::malformed(at(line), what));
        };
        let first_value = motion.values.len();
        let dofs = bones.dofs(slot);
        let found = if words.len() != dofs.len() {
            let what = format!(
                "{} values of \"{}\" found, {} expected (its degrees of freedom in the .asf)",
                words.len(),
                shortened(name),
                dofs.len()
            );
            Err(ReadError::malformed(at(line), what))
        } else if motion.rows[slot].last().is_some_and(|r| r.frame == frame) {
            let what = format!("\"{}\" occurs twice in one frame", shortened(name));
            Err(ReadError::malformed(at(line), what))
        } else {
            let words = words.iter().copied();
            self.damage
                .values(|_| at(line), MAX_NUMBER, words, &mut motion.values)
        };
        match found {
            Err(error) => self.damaged(error),
            Ok(()) => {
                motion.rows[slot].push(Row { frame, first_value });
                self.all += 1;
                self.in_frame += 1;
                self.read_in_frame += 1;
            }
        }
        Ok(())
    }

    /// Leaves out a last frame that lacks bones, and holds what could not be read.
    fn finish(
        self,
        motion: &mut MotionText,
        bones: Bones<'_>,
        notes: &mut Notes,
    ) -> Result<(), ReadError> {
        let has_values = self.damage.has_values();
        let fate = "the row is left out, and the bone holds";
        self.damage.told(self.all, fate, |odd| notes.push(odd))?;
        if let Some(usual) = self.usual.filter(|usual| self.read_in_frame < *usual) {
            motion.frames -= 1;
            for rows in &mut motion.rows {
                rows.retain(|row| row.frame < motion.frames);
            }
            let found = self.read_in_frame;
            let what = format!(
                "the last frame has {found} rows of {usual}, as a file that was cut; it is left out"
            );
            notes.add("amc", what);
        }
        for (slot, rows) in motion.rows.iter().enumerate().filter(|_| has_values) {
            for dof in 0..bones.dofs(slot).len() {
                let places = rows.iter().map(|row| row.first_value + dof);
                hold(&mut motion.values, places);
            }
        }
        Ok(())
    }
}
