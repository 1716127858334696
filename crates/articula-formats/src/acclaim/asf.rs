//! Parser of skeleton files: sections, the root, the bones and the hierarchy.

use crate::error::ReadError;
use crate::limits::Limits;
use crate::notes::Notes;
use crate::words::{number, shortened};
use articula_core::LibmQuat;
use glam::{Quat, Vec3};

/// Maximum number of degrees of freedom of one bone: three rotations, three translations and a
/// length are the most that is meaningful.
const MAX_DOFS: usize = 9;

/// Prefix of the root joint's name in the documentation section of written files.
pub(super) const ROOT_NAME: &str = "root joint:";

/// Target of one value of a motion; the number is the axis, 0 to 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dof {
    Shift(usize),
    Turn(usize),
    /// Length of the bone; ignored.
    Stretch,
}

/// Angles about x, y and z in the file's unit, and the order of the axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Angles {
    pub(super) values: Vec3,
    pub(super) order: Vec<usize>,
}

impl Angles {
    /// Returns the rotation: the first axis of the order turns first, about fixed axes.
    pub(super) fn rotation(&self, radians: f32) -> Quat {
        let turn = |&axis: &usize| (axis, self.values[axis] * radians);
        turned(self.order.iter().map(turn))
    }
}

/// Returns the product of successive turns about fixed axes.
pub(super) fn turned(turns: impl Iterator<Item = (usize, f32)>) -> Quat {
    let one = |(axis, angle): (usize, f32)| Quat::libm_axis_angle(Vec3::AXES[axis], angle);
    let all = turns.fold(Quat::IDENTITY, |before, turn| one(turn) * before);
    all.normalize()
}

/// A bone as in the file, in the file's units.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Bone {
    pub(super) name: String,
    pub(super) line: usize,
    pub(super) direction: Vec3,
    pub(super) length: f32,
    pub(super) axis: Angles,
    pub(super) dofs: Vec<Dof>,
}

/// A line of the hierarchy: a bone and those that start at its end.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Link {
    pub(super) line: usize,
    pub(super) parent: String,
    pub(super) children: Vec<String>,
}

/// The content of a skeleton file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SkeletonText {
    pub(super) name: String,
    /// Name of the root joint; the format itself calls every root `root`.
    pub(super) root_name: String,
    /// `length` of the units section: usually file units per inch.
    pub(super) length: f32,
    /// Whether angles are in degrees; a motion file may override it for itself.
    pub(super) degrees: bool,
    pub(super) root_dofs: Vec<Dof>,
    pub(super) root_place: Vec3,
    pub(super) root_orientation: Angles,
    pub(super) bones: Vec<Bone>,
    pub(super) links: Vec<Link>,
}

impl Default for SkeletonText {
    fn default() -> Self {
        use Dof::{Shift, Turn};
        Self {
            name: String::new(),
            root_name: "root".to_owned(),
            length: 1.0,
            degrees: true,
            root_dofs: [Shift(0), Shift(1), Shift(2), Turn(0), Turn(1), Turn(2)].to_vec(),
            root_place: Vec3::ZERO,
            root_orientation: Angles {
                values: Vec3::ZERO,
                order: vec![0, 1, 2],
            },
            bones: Vec::new(),
            links: Vec::new(),
        }
    }
}

/// Splits a line into words: comments are removed, commas and parentheses count as spaces.
pub(super) fn words(line: &str) -> Vec<&str> {
    let line = line.split('#').next().unwrap_or_default();
    let gap = |c: char| c.is_whitespace() || matches!(c, ',' | '(' | ')');
    line.split(gap).filter(|w| !w.is_empty()).collect()
}

/// Formats a position in the skeleton file for error messages.
pub(super) fn at(line: usize) -> String {
    format!("asf line {line}")
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Section {
    Head,
    Units,
    Documentation,
    Root,
    Bones,
    Hierarchy,
    /// Ignored section.
    Other,
}

struct Parser<'a> {
    limits: &'a Limits,
    section: Section,
    text: SkeletonText,
    /// Whether a section was found that only a skeleton file has.
    has_figure: bool,
    /// The bone between `begin` and `end`.
    open: Option<Bone>,
    /// Whether lines that start with a number continue the limits.
    in_limits: bool,
    notes: &'a mut Notes,
}

/// Reads a whole skeleton file.
pub(super) fn parse(
    text: &str,
    limits: &Limits,
    notes: &mut Notes,
) -> Result<SkeletonText, ReadError> {
    let mut parser = Parser {
        limits,
        section: Section::Head,
        text: SkeletonText::default(),
        has_figure: false,
        open: None,
        in_limits: false,
        notes,
    };
    for (index, line) in text.lines().enumerate() {
        let words = words(line);
        if let Some(first) = words.first() {
            parser.line(index + 1, first, &words[1..])?;
        }
    }
    if let Some(bone) = &parser.open {
        return Err(ReadError::malformed(
            at(bone.line),
            "this \"begin\" has no \"end\"",
        ));
    }
    if !parser.has_figure {
        let what = "no :root and no :bonedata found; is this an ASF file?";
        return Err(ReadError::malformed("asf line 1", what));
    }
    Ok(parser.text)
}

impl Parser<'_> {
    fn line(&mut self, line: usize, first: &str, rest: &[&str]) -> Result<(), ReadError> {
        if let Some(keyword) = first.strip_prefix(':') {
            return self.keyword(line, keyword, rest);
        }
        match self.section {
            Section::Head => {
                let what = format!(
                    "\"{}\" found, a keyword such as :root expected; is this an ASF file?",
                    shortened(first)
                );
                Err(ReadError::malformed(at(line), what))
            }
            Section::Units => self.unit(line, first, rest),
            Section::Documentation => {
                let said = format!("{first} {}", rest.join(" "));
                if let Some(name) = said.strip_prefix(ROOT_NAME).map(str::trim)
                    && !name.is_empty()
                {
                    self.text.root_name = name.to_owned();
                }
                Ok(())
            }
            Section::Root => self.root(line, first, rest),
            Section::Bones => self.bone(line, first, rest),
            Section::Hierarchy => self.link(line, first, rest),
            Section::Other => Ok(()),
        }
    }

    fn keyword(&mut self, line: usize, keyword: &str, rest: &[&str]) -> Result<(), ReadError> {
        if let Some(bone) = &self.open {
            let what = format!(
                "\":{}\" found, \"end\" of the bone expected; it begins at line {}",
                shortened(keyword),
                bone.line
            );
            return Err(ReadError::malformed(at(line), what));
        }
        self.section = match keyword.to_ascii_lowercase().as_str() {
            "version" => Section::Head,
            "name" => {
                self.text.name = rest.join(" ");
                Section::Head
            }
            "units" => Section::Units,
            "documentation" => Section::Documentation,
            "root" => Section::Root,
            "bonedata" => Section::Bones,
            "hierarchy" => Section::Hierarchy,
            "skin" => Section::Other,
            _ => {
                let what = format!("unknown keyword \":{}\"; ignored", shortened(keyword));
                self.notes.add(at(line), what);
                Section::Other
            }
        };
        self.has_figure |= matches!(self.section, Section::Root | Section::Bones);
        Ok(())
    }

    fn unit(&mut self, line: usize, first: &str, rest: &[&str]) -> Result<(), ReadError> {
        let value = rest.first().copied().unwrap_or_default();
        match first.to_ascii_lowercase().as_str() {
            "length" => {
                let length = number(at(line), value)?;
                if length <= 0.0 {
                    let what = format!("length {length} found, more than 0 expected");
                    return Err(ReadError::malformed(at(line), what));
                }
                self.text.length = length;
            }
            "angle" => match value.to_ascii_lowercase().get(..3) {
                Some("deg") => self.text.degrees = true,
                Some("rad") => self.text.degrees = false,
                _ => {
                    let what = format!("angle \"{}\" found, deg or rad expected", shortened(value));
                    return Err(ReadError::malformed(at(line), what));
                }
            },
            // The mass is not used.
            _ => {}
        }
        Ok(())
    }

    fn root(&mut self, line: usize, first: &str, rest: &[&str]) -> Result<(), ReadError> {
        match first.to_ascii_lowercase().as_str() {
            "order" => self.text.root_dofs = dofs(line, rest)?,
            "axis" => {
                let word = rest.first().copied().unwrap_or_default();
                self.text.root_orientation.order = order(line, word)?;
            }
            "position" => self.text.root_place = triple(line, first, rest)?,
            "orientation" => self.text.root_orientation.values = triple(line, first, rest)?,
            _ => self.unknown(line, first, "the root"),
        }
        Ok(())
    }

    fn bone(&mut self, line: usize, first: &str, rest: &[&str]) -> Result<(), ReadError> {
        let keyword = first.to_ascii_lowercase();
        let Some(bone) = &mut self.open else {
            if keyword != "begin" {
                let what = format!("\"{}\" found, \"begin\" expected", shortened(first));
                return Err(ReadError::malformed(at(line), what));
            }
            let count = self.text.bones.len() as u64 + 2;
            Limits::check(at(line), "bones", count, self.limits.nodes)?;
            self.in_limits = false;
            self.open = Some(Bone {
                line,
                ..Bone::default()
            });
            return Ok(());
        };
        let in_limits = std::mem::replace(&mut self.in_limits, keyword == "limits");
        match keyword.as_str() {
            "end" => {
                if bone.name.is_empty() {
                    let what = format!("the bone that begins at line {} has no name", bone.line);
                    return Err(ReadError::malformed(at(line), what));
                }
                self.text.bones.extend(self.open.take());
            }
            "name" => bone.name = rest.join(" "),
            "direction" => bone.direction = triple(line, first, rest)?,
            "length" => {
                bone.length = number(at(line), rest.first().copied().unwrap_or_default())?;
            }
            "axis" => {
                bone.axis = Angles {
                    values: triple(line, first, rest)?,
                    order: order(line, rest.get(3).copied().unwrap_or("XYZ"))?,
                }
            }
            "dof" => bone.dofs = dofs(line, rest)?,
            "id" | "limits" | "bodymass" | "cofmass" => {}
            // A limit may be infinite, so it is treated as a word.
            _ if in_limits && first.parse::<f32>().is_ok() => self.in_limits = true,
            _ => self.unknown(line, first, "the bone"),
        }
        Ok(())
    }

    fn link(&mut self, line: usize, first: &str, rest: &[&str]) -> Result<(), ReadError> {
        if rest.is_empty() && matches!(first.to_ascii_lowercase().as_str(), "begin" | "end") {
            return Ok(());
        }
        self.text.links.push(Link {
            line,
            parent: first.to_owned(),
            children: rest.iter().map(|&w| w.to_owned()).collect(),
        });
        Ok(())
    }

    fn unknown(&mut self, line: usize, word: &str, of: &str) {
        let what = format!("unknown property \"{}\" of {of}; ignored", shortened(word));
        self.notes.add(at(line), what);
    }
}

fn triple(line: usize, keyword: &str, words: &[&str]) -> Result<Vec3, ReadError> {
    if words.len() < 3 {
        let what = format!("{keyword} has {} numbers, 3 expected", words.len());
        return Err(ReadError::malformed(at(line), what));
    }
    let mut triple = Vec3::ZERO;
    for (axis, word) in words[..3].iter().enumerate() {
        triple[axis] = number(at(line), word)?;
    }
    Ok(triple)
}

/// Parses an order of axes such as `XYZ`.
fn order(line: usize, word: &str) -> Result<Vec<usize>, ReadError> {
    let axis = |c: char| "xyz".find(c.to_ascii_lowercase());
    let order: Option<Vec<usize>> = word.chars().take(4).map(axis).collect();
    let order = order.filter(|o| (1..=3).contains(&o.len()));
    order.ok_or_else(|| {
        let what = format!(
            "axis order \"{}\" found, one such as XYZ expected",
            shortened(word)
        );
        ReadError::malformed(at(line), what)
    })
}

fn dofs(line: usize, words: &[&str]) -> Result<Vec<Dof>, ReadError> {
    if words.len() > MAX_DOFS {
        let what = format!(
            "{} degrees of freedom found, at most {MAX_DOFS} expected",
            words.len()
        );
        return Err(ReadError::malformed(at(line), what));
    }
    let dof = |word: &&str| match word.to_ascii_lowercase().as_str() {
        "tx" => Ok(Dof::Shift(0)),
        "ty" => Ok(Dof::Shift(1)),
        "tz" => Ok(Dof::Shift(2)),
        "rx" => Ok(Dof::Turn(0)),
        "ry" => Ok(Dof::Turn(1)),
        "rz" => Ok(Dof::Turn(2)),
        "l" => Ok(Dof::Stretch),
        _ => {
            let what = format!(
                "\"{}\" found, tx, ty, tz, rx, ry, rz or l expected",
                shortened(word)
            );
            Err(ReadError::malformed(at(line), what))
        }
    };
    words.iter().map(dof).collect()
}
