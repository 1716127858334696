//! Parser of the first half of a BVH file: joints, offsets and channels.

use crate::error::{ReadError, Warning};
use crate::limits::Limits;
use crate::words::number;
use glam::Vec3;

/// Maximum number of channels of one joint: position, rotation and scale.
const MAX_CHANNELS: usize = 9;

/// Target of one value of a frame; the number is the axis, 0 to 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Channel {
    Position(usize),
    Rotation(usize),
}

/// A joint as in the file, in the file's units and axes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RawJoint {
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    pub(super) offset: Vec3,
    pub(super) channels: Vec<Channel>,
}

/// The hierarchy of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Hierarchy {
    pub(super) joints: Vec<RawJoint>,
    pub(super) end_sites: Vec<(usize, Vec3)>,
    /// Line number of `MOTION`, counted from 1, if present.
    pub(super) motion_line: Option<usize>,
}

/// Owner of an open brace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Block {
    Joint(usize),
    EndSite(usize),
}

struct Parser<'a> {
    limits: &'a Limits,
    hierarchy: Hierarchy,
    warnings: Vec<Warning>,
    open: Vec<Block>,
    /// Declared block whose brace has not been read yet.
    pending: Option<Block>,
}

/// Reads up to and including the line `MOTION`, or to the end of the file.
pub(super) fn parse(text: &str, limits: &Limits) -> Result<(Hierarchy, Vec<Warning>), ReadError> {
    let mut parser = Parser {
        limits,
        hierarchy: Hierarchy::default(),
        warnings: Vec::new(),
        open: Vec::new(),
        pending: None,
    };
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        let spaced = line.replace('{', " { ").replace('}', " } ");
        let words: Vec<&str> = spaced.split_whitespace().collect();
        if words
            .first()
            .is_some_and(|w| w.eq_ignore_ascii_case("motion"))
        {
            parser.hierarchy.motion_line = Some(number);
            break;
        }
        parser.line(number, &words)?;
    }
    parser.finish()
}

/// Formats a position in the file for error messages.
pub(super) fn at(line: usize) -> String {
    format!("line {line}")
}

impl Parser<'_> {
    fn line(&mut self, line: usize, words: &[&str]) -> Result<(), ReadError> {
        let mut rest = words;
        while let Some((first, after)) = rest.split_first() {
            let keyword = first.to_ascii_lowercase();
            rest = match keyword.as_str() {
                "hierarchy" => after,
                "root" | "joint" => self.joint(line, &keyword, after)?,
                "end" => self.end_site(line, after)?,
                "{" => self.opened(line, after)?,
                "}" => self.closed(line, after)?,
                "offset" => self.offset(line, after)?,
                "channels" => self.channels(line, after)?,
                _ => {
                    let what = format!(
                        "\"{first}\" found; ROOT, JOINT, End Site, OFFSET, CHANNELS, a brace or MOTION expected"
                    );
                    return Err(ReadError::malformed(at(line), what));
                }
            };
        }
        Ok(())
    }

    /// Parses a joint. Its name extends to the brace or the end of the line, since some writers put
    /// spaces in it.
    fn joint<'w>(
        &mut self,
        line: usize,
        keyword: &str,
        after: &'w [&'w str],
    ) -> Result<&'w [&'w str], ReadError> {
        let parent = match (self.open.last(), keyword) {
            (None, "root") => None,
            (Some(Block::Joint(parent)), "joint") => Some(*parent),
            (None, _) => return Err(ReadError::malformed(at(line), "JOINT outside of a ROOT")),
            (Some(Block::EndSite(_)), _) => {
                return Err(ReadError::malformed(
                    at(line),
                    "JOINT inside of an End Site",
                ));
            }
            (Some(_), _) => return Err(ReadError::malformed(at(line), "ROOT inside of a joint")),
        };
        self.nothing_pending(line)?;
        let count = self.hierarchy.joints.len() as u64 + 1;
        Limits::check(at(line), "joints", count, self.limits.nodes)?;
        let length = after.iter().position(|w| *w == "{").unwrap_or(after.len());
        if length == 0 {
            self.warnings
                .push(Warning::new(at(line), "a joint has no name"));
        }
        self.pending = Some(Block::Joint(self.hierarchy.joints.len()));
        self.hierarchy.joints.push(RawJoint {
            name: after[..length].join(" "),
            parent,
            offset: Vec3::ZERO,
            channels: Vec::new(),
        });
        Ok(&after[length..])
    }

    fn end_site<'w>(
        &mut self,
        line: usize,
        after: &'w [&'w str],
    ) -> Result<&'w [&'w str], ReadError> {
        self.nothing_pending(line)?;
        let Some(Block::Joint(joint)) = self.open.last() else {
            return Err(ReadError::malformed(
                at(line),
                "End Site outside of a joint",
            ));
        };
        self.pending = Some(Block::EndSite(self.hierarchy.end_sites.len()));
        self.hierarchy.end_sites.push((*joint, Vec3::ZERO));
        let length = after.iter().position(|w| *w == "{").unwrap_or(after.len());
        Ok(&after[length..])
    }

    fn nothing_pending(&self, line: usize) -> Result<(), ReadError> {
        match self.pending {
            None => Ok(()),
            Some(_) => Err(ReadError::malformed(
                at(line),
                "the joint above has no \"{\"",
            )),
        }
    }

    fn opened<'w>(
        &mut self,
        line: usize,
        after: &'w [&'w str],
    ) -> Result<&'w [&'w str], ReadError> {
        let block = self.pending.take();
        let block = block.ok_or_else(|| ReadError::malformed(at(line), "\"{\" without a joint"))?;
        self.open.push(block);
        let depth = self.open.len() as u64;
        Limits::check(at(line), "nested joints", depth, self.limits.depth)?;
        Ok(after)
    }

    fn closed<'w>(
        &mut self,
        line: usize,
        after: &'w [&'w str],
    ) -> Result<&'w [&'w str], ReadError> {
        self.nothing_pending(line)?;
        let open = self.open.pop();
        open.ok_or_else(|| ReadError::malformed(at(line), "\"}\" without a \"{\""))?;
        Ok(after)
    }

    fn offset<'w>(
        &mut self,
        line: usize,
        after: &'w [&'w str],
    ) -> Result<&'w [&'w str], ReadError> {
        if after.len() < 3 {
            let what = format!("OFFSET has {} numbers, 3 expected", after.len());
            return Err(ReadError::malformed(at(line), what));
        }
        let mut offset = [0.0; 3];
        for (value, word) in offset.iter_mut().zip(after) {
            *value = number(at(line), word)?;
        }
        let offset = Vec3::from_array(offset);
        match self.open.last() {
            Some(Block::Joint(joint)) => self.hierarchy.joints[*joint].offset = offset,
            Some(Block::EndSite(site)) => self.hierarchy.end_sites[*site].1 = offset,
            None => return Err(ReadError::malformed(at(line), "OFFSET outside of a joint")),
        }
        Ok(&after[3..])
    }

    fn channels<'w>(
        &mut self,
        line: usize,
        after: &'w [&'w str],
    ) -> Result<&'w [&'w str], ReadError> {
        let Some(Block::Joint(joint)) = self.open.last() else {
            return Err(ReadError::malformed(
                at(line),
                "CHANNELS outside of a joint",
            ));
        };
        let word = after.first().copied().unwrap_or_default();
        let count = word.parse::<usize>().ok().filter(|c| *c <= MAX_CHANNELS);
        let count = count.ok_or_else(|| {
            let what =
                format!("CHANNELS \"{word}\" found, a count of 0 to {MAX_CHANNELS} expected");
            ReadError::malformed(at(line), what)
        })?;
        let names = &after[1..];
        if names.len() < count {
            let what = format!("CHANNELS declares {count} channels, {} found", names.len());
            return Err(ReadError::malformed(at(line), what));
        }
        let channels = names[..count].iter().map(|name| channel(line, name));
        let channels = channels.collect::<Result<Vec<_>, _>>()?;
        self.hierarchy.joints[*joint].channels = channels;
        Ok(&names[count..])
    }

    fn finish(mut self) -> Result<(Hierarchy, Vec<Warning>), ReadError> {
        if self.hierarchy.joints.is_empty() {
            let what = "no ROOT found; is this a BVH file?";
            return Err(ReadError::malformed("line 1", what));
        }
        let end = self
            .hierarchy
            .motion_line
            .map_or("end of file".to_owned(), at);
        if let Some(Block::Joint(joint)) = self.open.last().or(self.pending.as_ref()) {
            let name = &self.hierarchy.joints[*joint].name;
            return Err(ReadError::malformed(
                end,
                format!("the joint \"{name}\" is not closed"),
            ));
        }
        if !self.open.is_empty() || self.pending.is_some() {
            return Err(ReadError::malformed(end, "an End Site is not closed"));
        }
        if self.hierarchy.motion_line.is_none() {
            self.warnings.push(Warning::new(
                end,
                "the file has no MOTION section; the figure is read without a clip",
            ));
        }
        Ok((self.hierarchy, self.warnings))
    }
}

fn channel(line: usize, name: &str) -> Result<Channel, ReadError> {
    let lower = name.to_ascii_lowercase();
    let axis = match lower.bytes().next() {
        Some(b'x') => Some(0),
        Some(b'y') => Some(1),
        Some(b'z') => Some(2),
        _ => None,
    };
    match (axis, lower.get(1..)) {
        (Some(axis), Some("position")) => Ok(Channel::Position(axis)),
        (Some(axis), Some("rotation")) => Ok(Channel::Rotation(axis)),
        _ => {
            let what = format!("channel \"{name}\" found; [XYZ]position or [XYZ]rotation expected");
            Err(ReadError::malformed(at(line), what))
        }
    }
}
