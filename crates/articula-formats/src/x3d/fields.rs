//! Typed field values: numbers, rotations, strings, nodes.
//!
//! Source: ISO/IEC 19775-1, clause 5 (field types); ISO/IEC 19776-1, clause 5 and 19776-2, clause 5
//! (their encoding).

use super::names::token;
use super::scene::{NodeId, X3dScene, shortened};
use crate::error::ReadError;
use crate::limits::Limits;
use crate::notes::Notes;
use articula_core::LibmQuat;
use glam::{DQuat, DVec3};
use std::borrow::Cow;

/// Larger numbers are meaningless for a character and would overflow in products.
const LARGEST: f64 = 1e9;

/// Maximum number of characters of a name; the rest is cut off.
const LONGEST_NAME: usize = 256;

/// A scene being converted to a character.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    pub(super) scene: &'a X3dScene<'a>,
    pub(super) limits: &'a Limits,
    pub(super) notes: Notes,
    /// Elements decoded so far, in all arrays together.
    spent: u64,
    /// Nodes visited so far; `USE` can reference one node any number of times.
    visited: u64,
}

impl<'a> Reader<'a> {
    pub(super) fn new(scene: &'a X3dScene<'a>, limits: &'a Limits, notes: Notes) -> Self {
        Self {
            scene,
            limits,
            notes,
            spent: 0,
            visited: 0,
        }
    }

    /// Counts `elements` against the limit before they are allocated.
    pub(super) fn charge(&mut self, id: NodeId, elements: usize) -> Result<(), ReadError> {
        self.spent = self.spent.saturating_add(elements as u64);
        if self.spent <= self.limits.elements {
            return Ok(());
        }
        let (found, limit) = (self.spent, self.limits.elements);
        Limits::check(self.scene.at(id), "decoded elements", found, limit)
    }

    /// Counts one step of a graph traversal against the limit, so that it ends.
    pub(super) fn visit(&mut self, id: NodeId, depth: usize) -> Result<(), ReadError> {
        self.visited += 1;
        let (limits, depth) = (self.limits, depth as u64);
        // A node is visited a few times at most unless USE multiplies it.
        let most = limits.nodes.saturating_mul(16);
        if self.visited <= most && depth <= limits.depth {
            return Ok(());
        }
        let at = self.scene.at(id);
        Limits::check(&at, "visits of nodes", self.visited, most)?;
        Limits::check(&at, "levels of nesting", depth, limits.depth)
    }

    pub(super) fn warn(&mut self, id: NodeId, what: impl Into<String>) {
        let at = self.scene.at(id);
        self.notes.add(at, what);
    }

    pub(super) fn malformed(&self, id: NodeId, what: impl Into<String>) -> ReadError {
        ReadError::malformed(self.scene.at(id), what)
    }

    pub(super) fn kind(&self, id: NodeId) -> &'a str {
        &self.scene.nodes[id].kind
    }

    /// Returns the text of a field, if present.
    pub(super) fn text(&self, id: NodeId, field: &str) -> Option<&'a str> {
        self.scene.nodes[id].text(field)
    }

    /// Returns the name of a node: its name field, else its `DEF`.
    pub(super) fn name(&self, id: NodeId) -> String {
        let own = self.text(id, "name").map(str::trim).unwrap_or("");
        let name = if own.is_empty() {
            self.scene.nodes[id].def.as_ref()
        } else {
            own
        };
        shortened_name(name)
    }

    /// Returns the original spelling of a name: the description, if it differs from the name only
    /// by characters that names may not contain.
    pub(super) fn spelled_name(&self, id: NodeId) -> String {
        let name = self.name(id);
        let description = self.text(id, "description").unwrap_or("").trim();
        if description.is_empty() || description.len() > 4 * LONGEST_NAME {
            return name;
        }
        // A number may follow a name that was already used.
        let behind = name.strip_prefix(token(description).as_str());
        let number = behind.map(|rest| rest.strip_prefix('_').unwrap_or(rest));
        let same = number.is_some_and(|n| n.bytes().all(|b| b.is_ascii_digit()));
        if same {
            shortened_name(description)
        } else {
            name
        }
    }

    pub(super) fn flag(&self, id: NodeId, field: &str, usual: bool) -> bool {
        match self.text(id, field).map(str::trim) {
            Some("true" | "TRUE") => true,
            Some("false" | "FALSE") => false,
            _ => usual,
        }
    }

    /// Returns the first node in a field.
    pub(super) fn node(&self, id: NodeId, field: &str) -> Option<NodeId> {
        self.scene.nodes[id].nodes(field).next()
    }

    /// Returns the nodes in a field.
    pub(super) fn nodes(&self, id: NodeId, field: &str) -> Vec<NodeId> {
        self.scene.nodes[id].nodes(field).collect()
    }

    /// Reads any number of numbers.
    pub(super) fn numbers(&mut self, id: NodeId, field: &str) -> Result<Vec<f64>, ReadError> {
        let Some(text) = self.text(id, field) else {
            return Ok(Vec::new());
        };
        let mut numbers = Vec::new();
        for word in words(text) {
            let number = word.parse::<f64>().ok().filter(|n| n.abs() <= LARGEST);
            let Some(number) = number else {
                let word = shortened(word);
                let what = format!("{field}: \"{word}\" found, a number up to 1e9 expected");
                return Err(self.malformed(id, what));
            };
            numbers.push(number);
        }
        self.charge(id, numbers.len())?;
        Ok(numbers)
    }

    /// Reads any number of integers; invalid indices become -1.
    pub(super) fn indices(&mut self, id: NodeId, field: &str) -> Result<Vec<i64>, ReadError> {
        let Some(text) = self.text(id, field) else {
            return Ok(Vec::new());
        };
        let mut list = Vec::new();
        for word in words(text) {
            let hexadecimal = word.strip_prefix("0x").or_else(|| word.strip_prefix("0X"));
            let number = match hexadecimal {
                Some(digits) => i64::from_str_radix(digits, 16).ok(),
                None => word.parse::<i32>().ok().map(i64::from),
            };
            let Some(number) = number else {
                let word = shortened(word);
                let what = format!("{field}: \"{word}\" found, a whole number expected");
                return Err(self.malformed(id, what));
            };
            list.push(number);
        }
        self.charge(id, list.len())?;
        Ok(list)
    }

    /// Reads tuples of numbers; an incomplete last one is left out with a warning.
    pub(super) fn tuples<const N: usize>(
        &mut self,
        id: NodeId,
        field: &str,
    ) -> Result<Vec<[f64; N]>, ReadError> {
        let numbers = self.numbers(id, field)?;
        let (tuples, rest) = numbers.as_chunks::<N>();
        if !rest.is_empty() {
            let what = format!(
                "{field}: {} numbers found, a multiple of {N} expected",
                numbers.len()
            );
            self.warn(id, what);
        }
        Ok(tuples.to_vec())
    }

    /// Reads exactly the number of values of the field's type.
    fn tuple<const N: usize>(
        &mut self,
        id: NodeId,
        field: &str,
    ) -> Result<Option<[f64; N]>, ReadError> {
        if self.text(id, field).is_none_or(|t| t.trim().is_empty()) {
            return Ok(None);
        }
        let numbers = self.numbers(id, field)?;
        let found = numbers.len();
        match <[f64; N]>::try_from(numbers) {
            Ok(tuple) => Ok(Some(tuple)),
            Err(_) => {
                let what = format!("{field}: {found} numbers found, {N} expected");
                Err(self.malformed(id, what))
            }
        }
    }

    pub(super) fn number(&mut self, id: NodeId, field: &str, usual: f64) -> Result<f64, ReadError> {
        Ok(self.tuple::<1>(id, field)?.map_or(usual, |[n]| n))
    }

    pub(super) fn vector(
        &mut self,
        id: NodeId,
        field: &str,
        usual: DVec3,
    ) -> Result<DVec3, ReadError> {
        Ok(self.tuple(id, field)?.map_or(usual, DVec3::from_array))
    }

    pub(super) fn rotation(&mut self, id: NodeId, field: &str) -> Result<DQuat, ReadError> {
        let given = self.tuple(id, field)?;
        Ok(given.map_or(DQuat::IDENTITY, |r| self.turn(r)))
    }

    /// Returns the rotation of an axis and an angle; the identity for a zero axis.
    pub(super) fn turn(&self, [x, y, z, angle]: [f64; 4]) -> DQuat {
        let axis = DVec3::new(x, y, z).normalize_or_zero();
        if axis == DVec3::ZERO {
            return DQuat::IDENTITY;
        }
        DQuat::libm_axis_angle(axis, angle * self.scene.radians)
    }

    /// Reads the strings of a field that may hold several.
    pub(super) fn strings(&mut self, id: NodeId, field: &str) -> Result<Vec<String>, ReadError> {
        let list = self.text(id, field).map(quoted_strings).unwrap_or_default();
        self.charge(id, list.iter().map(String::len).sum())?;
        Ok(list)
    }
}

/// Splits numbers at blanks and commas; a `#` begins a comment (classic encoding).
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    let plain = text.split_inclusive(['\n', '\r']).map(|line| {
        let end = line.find('#').unwrap_or(line.len());
        &line[..end]
    });
    plain.flat_map(|line| {
        line.split(|c: char| c.is_whitespace() || c == ',')
            .filter(|word| !word.is_empty())
    })
}

/// Splits `"a" "b"` into two strings; text without quotation marks is one string.
fn quoted_strings(text: &str) -> Vec<String> {
    if !text.trim_start().starts_with('"') {
        return match text.trim() {
            "" => Vec::new(),
            plain => vec![plain.to_owned()],
        };
    }
    let mut list = Vec::new();
    let mut chars = text.chars();
    while chars.by_ref().any(|c| c == '"') {
        let mut string = String::new();
        while let Some(c) = chars.next().filter(|c| *c != '"') {
            string.extend(if c == '\\' { chars.next() } else { Some(c) });
        }
        list.push(string);
    }
    list
}

/// Bounds the length of a name, which is unlimited in a file.
fn shortened_name(name: &str) -> String {
    let end = name.char_indices().nth(LONGEST_NAME);
    name[..end.map_or(name.len(), |(i, _)| i)].to_owned()
}

/// Folds the case of a name: H-Anim names differ in case only by mistake.
pub(super) fn folded(name: &str) -> Cow<'_, str> {
    if name.bytes().any(|b| b.is_ascii_uppercase()) {
        return Cow::Owned(name.to_ascii_lowercase());
    }
    Cow::Borrowed(name)
}
