//! The transformation of a description: units that a selection does not keep are removed, counts,
//! lengths and padding are renewed; all other text stays as it is.
//!
//! Source: ISO/IEC 21000-7 (transformation of a description), thesis 3.1.1 and annex B.

use super::edits::{Edit, apply, close_of};
use super::literal;
use super::names;
use super::parse::{Item, Parsed};
use super::parts;
use super::selection::Selection;
use crate::description::xml::{Namespace, escape, whole};
use crate::error::StreamError;
use crate::limits::DescriptionLimits;
use crate::unit::Marker;
use std::collections::HashMap;
use std::fmt::Write;
use std::ops::Range;

/// By which rules a description is transformed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AdaptMode {
    /// Numbers that make the result a valid stream, in units of the namespace of gBSD or of none.
    #[default]
    Conformant,
    /// As the stylesheet printed in annex B does, with its faults (`docs/formats/gbsd.md`): to
    /// compare with it. The streams are not valid.
    AnnexBLiteral,
}

/// Transforms a description so that [`super::gbsd_to_bin()`] writes of the original stream what the
/// selection keeps. `start` values do not change: they are places in the original.
///
/// Time is linear in the text. The result is that of the [stylesheet](super::stylesheet()).
///
/// # Errors
/// A [`StreamError`] that names line and unit, for XML that cannot be read, a level that does not
/// exist, a bone without a level, masks and values of a `BoneSegment` that disagree, a number that
/// must be rewritten but was removed or does not fit, and units without `start`.
pub fn adapt_gbsd(
    description: &[u8],
    selection: &Selection,
    mode: AdaptMode,
    limits: &DescriptionLimits,
) -> Result<String, StreamError> {
    if mode == AdaptMode::AnnexBLiteral {
        return literal::adapt(description, selection, limits);
    }
    selection.check()?;
    let parsed = Parsed::read(description, limits)?;
    let mut plan = Plan::new(&parsed, selection)?;
    plan.check_bones()?;
    plan.places()?;
    plan.edits()?;
    Ok(apply(parsed.document.source, plan.edits))
}

struct Plan<'a> {
    parsed: &'a Parsed<'a>,
    /// Whether each item stays.
    kept: Vec<bool>,
    padding: Vec<bool>,
    /// Where each item begins and ends in the output, in bits.
    places: Vec<Range<u64>>,
    /// Bits of the padding to add at the end of a unit, if it had none.
    added: HashMap<usize, u64>,
    /// Units whose bytes a parameter counts.
    ids: HashMap<&'a str, usize>,
    edits: Vec<Edit>,
}

impl<'a> Plan<'a> {
    fn new(parsed: &'a Parsed<'a>, selection: &Selection) -> Result<Self, StreamError> {
        let is_foreign = parsed.is_foreign();
        let has_one_top = parsed.inside(None).nth(1).is_none();
        let count = parsed.items.len();
        let mut plan = Self {
            parsed,
            kept: Vec::with_capacity(count),
            padding: Vec::with_capacity(count),
            places: vec![0..0; count],
            added: HashMap::new(),
            ids: HashMap::new(),
            edits: Vec::new(),
        };
        for (number, item) in parsed.items.iter().enumerate() {
            if !item.is_placed || item.carried.is_some() {
                let what =
                    "has no start, or bytes of its own; write the description with addresses";
                return Err(parsed.bad(number, what));
            }
            if let Some(id) = parsed.own(number, "id") {
                plan.ids.insert(id, number);
            }
            let label = parsed.label(number).unwrap_or_default();
            let is_padding = parsed.own(number, "padding").is_some()
                || is_foreign && item.parameter.is_some() && names::read(label) == "Padding";
            plan.padding.push(is_padding);
            let tokens = parsed.tokens(number, 0);
            if let Some(token) = tokens.malformed {
                return Err(parsed.bad(number, format!("marker {token}, expected a number in it")));
            }
            let is_bone = matches!(names::read(label).as_ref(), "BoneMask" | "BoneValue");
            if is_bone && selection.body_loa.is_some() && level(&tokens.markers).is_none() {
                return Err(parsed.bad(number, "expected a marker L: with a level"));
            }
            let within = item.parent.is_none_or(|parent| plan.kept[parent]);
            let is_top = item.parent.is_none() && has_one_top;
            plan.kept
                .push(within && (is_top || selection.keeps_markers(&tokens.markers)));
        }
        Ok(plan)
    }

    /// Checks that each segment keeps the values of the bones whose masks it keeps.
    fn check_bones(&self) -> Result<(), StreamError> {
        let parsed = self.parsed;
        for (number, item) in parsed.items.iter().enumerate() {
            let is_segment = item.end > number + 1
                && names::read(parsed.label(number).unwrap_or_default()) == "BoneSegment";
            if !is_segment || !self.kept[number] {
                continue;
            }
            let levels = |label: &str| {
                let inside = (number + 1..item.end).filter(|i| self.kept[*i]);
                let named =
                    inside.filter(|i| names::read(parsed.label(*i).unwrap_or_default()) == label);
                named
                    .map(|i| parsed.tokens(i, 0).markers)
                    .collect::<Vec<_>>()
            };
            let (masks, values) = (levels("BoneMask"), levels("BoneValue"));
            if masks != values {
                let what = format!(
                    "{} masks and {} values that stay, with other markers",
                    masks.len(),
                    values.len()
                );
                return Err(parsed.bad(number, what));
            }
        }
        Ok(())
    }

    /// Lays the output out.
    fn places(&mut self) -> Result<(), StreamError> {
        let mut at = 0;
        let tops: Vec<usize> = self.parsed.inside(None).collect();
        for top in tops {
            at = self.place(top, at);
        }
        if at.is_multiple_of(8) {
            return Ok(());
        }
        let what = format!("gives a stream of {at} bits, expected whole bytes");
        Err(self.parsed.document.bad(self.parsed.description, what))
    }

    fn place(&mut self, number: usize, start: u64) -> u64 {
        let item = &self.parsed.items[number];
        let mut end = start;
        if self.kept[number] {
            if self.padding[number] {
                end += padding_at(start);
            } else if let Some(parameter) = &item.parameter {
                end += u64::from(parameter.width);
            } else if item.end == number + 1 {
                end += item.bits.end - item.bits.start;
            } else {
                let mut is_padded = false;
                let inside: Vec<usize> = self.parsed.inside(Some(number)).collect();
                for child in inside {
                    is_padded |= self.padding[child];
                    end = self.place(child, end);
                }
                let label = self.parsed.label(number).unwrap_or_default();
                let is_open = self.parsed.is_foreign() && names::read(label) == "BoneSegment";
                if is_open && !is_padded && padding_at(end) > 0 {
                    self.added.insert(number, padding_at(end));
                    end += padding_at(end);
                }
            }
        }
        self.places[number] = start..end;
        end
    }

    fn edits(&mut self) -> Result<(), StreamError> {
        let parsed = self.parsed;
        let mut number = 0;
        while let Some(item) = parsed.items.get(number) {
            if !self.kept[number] {
                self.check_removed(number..item.end)?;
                let text = self.emptied(number);
                self.edits
                    .push((parsed.document.elements[item.element].span.clone(), text));
                number = item.end;
                continue;
            }
            let length = self.places[number].end - self.places[number].start;
            if self.padding[number] {
                self.renew_padding(number, item, length);
            } else if let Some(value) = self.value(number)? {
                self.set_value(number, value)?;
            } else if item.end > number + 1 {
                self.set_length(number, item, length)?;
                if let Some(count) = self.added.get(&number) {
                    let element = &parsed.document.elements[item.element];
                    let attributes = format!(
                        " name=\":MG4:Padding\" start=\"{}\" length=\"{count}\"",
                        item.bits.end / item.unit
                    );
                    let text = self.padding_element(element.prefix, &attributes, *count);
                    let close = close_of(parsed.document.source, &element.span);
                    self.edits.push((close..close, text));
                }
            }
            number += 1;
        }
        Ok(())
    }

    /// Checks that no removed parameter belongs to a unit that stays.
    fn check_removed(&self, items: Range<usize>) -> Result<(), StreamError> {
        for number in items {
            if self.parsed.items[number].parameter.is_none() {
                continue;
            }
            let owner = self.owner(number);
            let counts = ["counts", "bytesOf", "bytesAfter"];
            let is_field = counts
                .iter()
                .any(|name| self.parsed.own(number, name).is_some());
            if is_field && owner.is_none_or(|owner| self.kept[owner]) {
                let what = "the number is in a unit that was removed";
                return Err(self.parsed.bad(number, what));
            }
        }
        Ok(())
    }

    /// The unit that has a parameter; `None` for the description.
    fn owner(&self, number: usize) -> Option<usize> {
        let parsed = self.parsed;
        let label = parsed.label(number).unwrap_or_default();
        let mut owner = parsed.items[number].parent;
        let up = match parsed.own(number, "up") {
            Some(text) => whole(text).unwrap_or(0),
            None if parsed.is_foreign() && names::read(label) == "NoOfBones" => {
                let around = owner.and_then(|owner| parsed.label(owner));
                u64::from(around.is_some_and(|label| names::read(label) == "MainHeader"))
            }
            None => 0,
        };
        for _ in 0..up {
            owner = owner.and_then(|owner| parsed.items[owner].parent);
        }
        owner
    }

    /// The new value of a parameter, if it counts something.
    fn value(&self, number: usize) -> Result<Option<u64>, StreamError> {
        let parsed = self.parsed;
        if parsed.items[number].parameter.is_none() {
            return Ok(None);
        }
        let owner = self.owner(number);
        let inside = match owner {
            Some(owner) => owner..parsed.items[owner].end,
            None => 0..parsed.items.len(),
        };
        let label = parsed.label(number).unwrap_or_default();
        let is_bones = parsed.is_foreign() && names::read(label) == "NoOfBones";
        let counts = parsed
            .own(number, "counts")
            .or(is_bones.then_some(":MG4:BoneMask"));
        if let Some(counted) = counts {
            let is_unit = |i: usize| parsed.items[i].parameter.is_none() || self.padding[i];
            let is_it = |i: &usize| {
                self.kept[*i]
                    && is_unit(*i)
                    && parsed
                        .label(*i)
                        .is_some_and(|l| l.eq_ignore_ascii_case(counted))
            };
            return Ok(Some(inside.filter(is_it).count() as u64));
        }
        if let Some(id) = parsed.own(number, "bytesOf") {
            let unit = self.ids.get(id);
            let unit = unit
                .ok_or_else(|| parsed.bad(number, format!("there is no unit with vh:id {id}")))?;
            let bits = self.places[*unit].end - self.places[*unit].start;
            return Ok(Some(bits.div_ceil(8)));
        }
        if parsed.own(number, "bytesAfter").is_some() {
            let end = match owner {
                Some(owner) => self.places[owner].end,
                None => self.places.last().map_or(0, |place| place.end),
            };
            let last = self.places[number + self.parts(number)? - 1].end;
            return Ok(Some(end.saturating_sub(last) / 8));
        }
        Ok(None)
    }

    /// Number of parameters that hold a number.
    fn parts(&self, number: usize) -> Result<usize, StreamError> {
        let parsed = self.parsed;
        let Some(text) = parsed.own(number, "parts") else {
            return Ok(1);
        };
        let parts = whole(text)
            .filter(|parts| (1..=9).contains(parts))
            .map(|p| p as usize);
        let are_there = |parts: &usize| {
            let items = parsed.items.get(number..number + parts);
            items.is_some_and(|items| items.iter().all(|item| item.parameter.is_some()))
        };
        let wrong = || parsed.bad(number, "vh:parts, expected the number of its Parameters");
        parts.filter(are_there).ok_or_else(wrong)
    }

    fn set_value(&mut self, number: usize, value: u64) -> Result<(), StreamError> {
        let parsed = self.parsed;
        let items = &parsed.items[number..number + self.parts(number)?];
        let widths: Vec<u32> = items
            .iter()
            .flat_map(|i| &i.parameter)
            .map(|p| p.width)
            .collect();
        let coding = parts::coding(parsed.own(number, "coding"));
        let values = coding.and_then(|coding| parts::split(coding, value, &widths));
        let values = values.ok_or_else(|| {
            let what = format!("{value} does not fit in its {widths:?} bits");
            parsed.bad(number, what)
        })?;
        for (item, value) in items.iter().zip(values) {
            let Some(parameter) = item.parameter.as_ref().filter(|p| p.value != value) else {
                continue;
            };
            let element = &parsed.document.elements[parameter.element];
            let close = close_of(parsed.document.source, &element.span);
            self.edits.push((element.tag.end..close, value.to_string()));
        }
        Ok(())
    }

    fn set_length(&mut self, number: usize, item: &Item, length: u64) -> Result<(), StreamError> {
        let parsed = self.parsed;
        if !length.is_multiple_of(item.unit) {
            let what = format!("a new length of {length} bits, expected whole bytes");
            return Err(parsed.bad(number, what));
        }
        let attribute = parsed
            .document
            .attribute(item.element, Namespace::Absent, "length");
        let text = (length / item.unit).to_string();
        if let Some(attribute) = attribute.filter(|attribute| attribute.value != text) {
            self.edits.push((attribute.place.clone(), text));
        }
        Ok(())
    }

    /// Writes padding anew: a parameter, or a unit without bits where there is nothing to pad but a
    /// later cut may have to.
    fn renew_padding(&mut self, number: usize, item: &Item, count: u64) {
        let parsed = self.parsed;
        let document = &parsed.document;
        if item.parameter.as_ref().map_or(0, |p| u64::from(p.width)) == count {
            return;
        }
        let element = &document.elements[item.element];
        let (name, old) = match count {
            0 => ("syntacticalLabel", "name"),
            _ => ("name", "syntacticalLabel"),
        };
        let mut attributes = String::new();
        for attribute in document.attributes(item.element) {
            let plain = attribute.namespace == Namespace::Absent;
            let (key, value) = match attribute.name {
                key if plain && key == old => (name, attribute.value.as_ref()),
                "length" if plain => ("length", &*count.to_string()),
                _ => (attribute.key, attribute.value.as_ref()),
            };
            // Writing to a text cannot fail.
            let _ = write!(attributes, " {key}=\"{}\"", escape(value));
        }
        let text = match count {
            // Of descriptions of other programs, padding of no bits is left out.
            0 if parsed.own(number, "padding").is_none() => String::new(),
            0 => format!("<{}gBSDUnit{attributes}/>", element.prefix),
            _ => self.padding_element(element.prefix, &attributes, count),
        };
        self.edits.push((element.span.clone(), text));
    }

    fn padding_element(&self, prefix: &str, attributes: &str, count: u64) -> String {
        let root = self.parsed.document.elements[0].tag.clone();
        let is_declared = self.parsed.document.source[root].contains("xmlns:xsi=");
        let declared = if is_declared {
            ""
        } else {
            " xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\""
        };
        format!(
            "<{prefix}Parameter{attributes}><{prefix}Value{declared} xsi:type=\"b{count}\">{count}\
             </{prefix}Value></{prefix}Parameter>"
        )
    }

    /// What is left of a removed unit: units whose bytes a parameter counts stay, empty.
    fn emptied(&self, number: usize) -> String {
        let parsed = self.parsed;
        if self.ids.is_empty() {
            return String::new();
        }
        let mut inner = String::new();
        for child in parsed.inside(Some(number)) {
            inner.push_str(&self.emptied(child));
        }
        let item = &parsed.items[number];
        if item.parameter.is_some() || parsed.own(number, "id").is_none() {
            return inner;
        }
        let element = &parsed.document.elements[item.element];
        let mut out = format!("<{}{}", element.prefix, element.name);
        for attribute in parsed.document.attributes(item.element) {
            let is_length = attribute.key.eq_ignore_ascii_case("length");
            let value = if is_length {
                "0"
            } else {
                attribute.value.as_ref()
            };
            let _ = write!(out, " {}=\"{}\"", attribute.key, escape(value));
        }
        if inner.is_empty() {
            return out + "/>";
        }
        out + ">" + &inner + "</" + element.prefix + element.name + ">"
    }
}

fn level(markers: &[Marker]) -> Option<u32> {
    let found = markers.iter().find(|marker| marker.scheme == "loa");
    found.map(|marker| marker.value)
}

fn padding_at(bit: u64) -> u64 {
    (8 - bit % 8) % 8
}
