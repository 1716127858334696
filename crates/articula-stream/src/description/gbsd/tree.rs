//! From a description to the map of its stream.

use super::names;
use super::parse::Parsed;
use super::parts;
use super::to_bin::{Holes, to_bin};
use crate::description::xml::{Namespace, whole};
use crate::error::StreamError;
use crate::limits::DescriptionLimits;
use crate::unit::{Field, Meaning, Unit};
use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;

/// What a gBSD says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gbsd {
    /// Map of the stream. Of several units at the top it is one around them, without a name.
    pub unit: Unit,
    /// Where the stream is, as the description says it; not a path to open.
    pub bitstream: Option<String>,
    /// The stream, if the description carries it in hexadecimal form.
    pub payload: Option<Vec<u8>>,
    /// Parameters that no cut rewrites; in the map they are units without parts.
    pub parameters: Vec<FixedParameter>,
    /// Tokens of markers that are no markers of ours, in order.
    pub tokens: Vec<String>,
}

/// A parameter with a value that does not depend on the units of a stream.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FixedParameter {
    /// Its name.
    pub name: String,
    /// Its bits in the stream.
    pub bits: Range<u64>,
    /// Its value, unsigned, the most significant bit first.
    pub value: u64,
}

/// Reads a gBSD.
///
/// Addresses may be in bits or bytes, absolute, relative to the unit around, or consecutive. What a
/// cut must rewrite is told by attributes of the namespace `urn:articula:vh:1`; of descriptions
/// without them, `NoOfBones` counts `BoneMask`, and `Padding` at the end of `BoneSegment` is padding.
/// `docs/formats/gbsd.md` has all that is read.
///
/// # Errors
/// A [`StreamError`] that names line and unit, if the XML cannot be read, exceeds a limit, or units
/// contradict each other ([`Unit::check`]).
pub fn read_gbsd(bytes: &[u8], limits: &DescriptionLimits) -> Result<Gbsd, StreamError> {
    let parsed = Parsed::read(bytes, limits)?;
    let mut reader = Tree {
        parsed: &parsed,
        is_foreign: parsed.is_foreign(),
        ids: HashMap::new(),
        references: Vec::new(),
        count: 0,
        parameters: Vec::new(),
        tokens: Vec::new(),
    };
    let tops: Vec<usize> = parsed.inside(None).collect();
    let mut pending = Vec::new();
    let whole = match tops.as_slice() {
        [top] if parsed.items[*top].parameter.is_none() && !reader.is_filler(*top) => {
            reader.unit(*top, 0, &mut pending)?
        }
        _ => reader.around(&mut pending)?,
    };
    if pending.iter().any(|(_, up)| *up > 0) {
        let what = "a Parameter belongs to a unit beyond the top";
        return Err(parsed.document.bad(parsed.description, what));
    }
    let mut unit = whole;
    reader.resolve(&mut unit)?;
    unit.check()
        .map_err(|e| parsed.document.bad(parsed.description, e.to_string()))?;
    let (parameters, tokens) = (reader.parameters, reader.tokens);
    let payload = payload(&parsed)?;
    let bitstream = parsed
        .document
        .attributes(parsed.description)
        .iter()
        .find(|a| a.namespace == Namespace::Bs1 && a.name.eq_ignore_ascii_case("bitstreamURI"));
    Ok(Gbsd {
        unit,
        bitstream: bitstream.map(|attribute| attribute.value.clone().into_owned()),
        payload,
        parameters,
        tokens,
    })
}

/// The stream that a description carries.
fn payload(parsed: &Parsed<'_>) -> Result<Option<Vec<u8>>, StreamError> {
    let leaves = |(number, item): &(usize, &super::parse::Item)| {
        item.end == number + 1 && item.parameter.is_none() && !item.bits.is_empty()
    };
    let leaves = parsed.items.iter().enumerate().filter(leaves);
    if leaves.clone().all(|(_, item)| item.carried.is_none()) {
        return Ok(None);
    }
    let mut at = 0;
    for (number, item) in parsed.items.iter().enumerate() {
        if item.end > number + 1 || item.bits.is_empty() {
            continue;
        }
        if item.carried.is_none() && item.parameter.is_none() {
            return Err(parsed.bad(number, "has no bytes of its own, but others have"));
        }
        if item.bits.start != at {
            let what = format!(
                "starts at bit {}, expected {at}, as bytes follow each other",
                item.bits.start
            );
            return Err(parsed.bad(number, what));
        }
        at = item.bits.end;
    }
    to_bin(parsed, &[], Holes::Refuse).map(Some)
}

struct Tree<'a> {
    parsed: &'a Parsed<'a>,
    is_foreign: bool,
    /// Numbers of units that have a name for fields.
    ids: HashMap<&'a str, u32>,
    /// Names of units in fields, whose meaning holds the place in this list until all are read.
    references: Vec<(usize, &'a str)>,
    /// Number of the next unit.
    count: u32,
    parameters: Vec<FixedParameter>,
    tokens: Vec<String>,
}

/// Fields that wait for the unit that has them, with the number of units in between.
type Pending = Vec<(Field, usize)>;

impl<'a> Tree<'a> {
    /// A unit without a name only fills bits that no other has.
    fn is_filler(&self, item: usize) -> bool {
        let here = &self.parsed.items[item];
        here.end == item + 1
            && here.parameter.is_none()
            && self.parsed.label(item).is_none()
            && self.parsed.document.value(here.element, "marker").is_none()
            && self.parsed.own(item, "id").is_none()
    }

    fn open(&mut self, item: Option<usize>) {
        let id = item.and_then(|item| self.parsed.own(item, "id"));
        if let Some(id) = id {
            self.ids.insert(id, self.count);
        }
        self.count += 1;
    }

    fn around(&mut self, pending: &mut Pending) -> Result<Unit, StreamError> {
        self.open(None);
        let tops = || {
            self.parsed
                .inside(None)
                .map(|top| &self.parsed.items[top].bits)
        };
        let start = tops().map(|bits| bits.start).min().unwrap_or(0);
        let end = tops().map(|bits| bits.end).max().unwrap_or(0);
        let mut unit = Unit {
            bits: start..end,
            ..Unit::of_bytes("", 0..0)
        };
        self.parts(None, &mut unit, pending)?;
        Ok(unit)
    }

    fn unit(
        &mut self,
        item: usize,
        ordinal: u32,
        pending: &mut Pending,
    ) -> Result<Unit, StreamError> {
        self.open(Some(item));
        let parsed = self.parsed;
        let tokens = parsed.tokens(item, ordinal);
        if let Some(token) = tokens.malformed {
            return Err(parsed.bad(item, format!("marker {token}, expected a number in it")));
        }
        self.tokens.extend(tokens.other);
        let label = match parsed.label(item) {
            Some(label) => names::read_owned(label),
            None if tokens.is_access_unit => Cow::Borrowed("AccessUnit"),
            None => Cow::Borrowed(""),
        };
        let mut unit = Unit {
            bits: parsed.items[item].bits.clone(),
            markers: tokens.markers,
            padding: parsed.own(item, "padding").is_some(),
            ..Unit::of_bytes(label, 0..0)
        };
        self.parts(Some(item), &mut unit, pending)?;
        Ok(unit)
    }

    fn parts(
        &mut self,
        of: Option<usize>,
        unit: &mut Unit,
        pending: &mut Pending,
    ) -> Result<(), StreamError> {
        let mut inner = Pending::new();
        let mut access_units = 0;
        let parsed = self.parsed;
        let items: Vec<usize> = parsed.inside(of).collect();
        let mut next = 0;
        while let Some(&item) = items.get(next) {
            next += 1;
            if parsed.items[item].parameter.is_none() {
                if !self.is_filler(item) {
                    let child = self.unit(item, access_units, &mut inner)?;
                    access_units += u32::from(child.marker(names::ACCESS_UNIT).is_some());
                    unit.children.push(child);
                }
                continue;
            }
            let (padding, meaning) = (self.is_padding(item)?, self.meaning(item, &unit.label)?);
            if let Some((meaning, up)) = meaning {
                let (field, parts) = self.field(&items[next - 1..], meaning)?;
                next += parts - 1;
                inner.push((field, up + 1));
            } else {
                self.open(Some(item));
                unit.children.push(self.fixed(item, padding)?);
            }
        }
        let padded = unit.children.iter().any(|child| child.padding);
        if self.is_foreign && unit.label == "BoneSegment" && !padded {
            self.open(None);
            unit.children.push(Unit {
                bits: unit.bits.end..unit.bits.end,
                padding: true,
                ..Unit::of_bytes("Padding", 0..0)
            });
        }
        for (field, up) in inner {
            if up <= 1 {
                unit.fields.push(field);
            } else {
                pending.push((field, up - 1));
            }
        }
        Ok(())
    }

    /// A parameter as a unit without parts.
    fn fixed(&mut self, item: usize, padding: bool) -> Result<Unit, StreamError> {
        let parsed = self.parsed;
        let here = &parsed.items[item];
        let name = parsed.label(item).unwrap_or_default();
        if let (false, Some(parameter)) = (padding, &here.parameter) {
            self.parameters.push(FixedParameter {
                name: name.to_owned(),
                bits: here.bits.clone(),
                value: parameter.value,
            });
        }
        let tokens = parsed.tokens(item, 0);
        if let Some(token) = tokens.malformed {
            return Err(parsed.bad(item, format!("marker {token}, expected a number in it")));
        }
        Ok(Unit {
            bits: here.bits.clone(),
            markers: tokens.markers,
            padding,
            ..Unit::of_bytes(names::read_owned(name), 0..0)
        })
    }

    fn is_padding(&self, item: usize) -> Result<bool, StreamError> {
        let parsed = self.parsed;
        let is_named = || names::read(parsed.label(item).unwrap_or_default()) == "Padding";
        let is_it = parsed.own(item, "padding").is_some() || self.is_foreign && is_named();
        let parameter = parsed.items[item].parameter.as_ref();
        match parameter {
            Some(p) if is_it && (p.width > 7 || p.value != u64::from(p.width)) => {
                let what = format!(
                    "padding of {} bits with the value {}, expected its bits, up to 7",
                    p.width, p.value
                );
                Err(parsed.bad(item, what))
            }
            _ => Ok(is_it),
        }
    }

    /// What a parameter counts, and the number of units between it and the unit that has it.
    fn meaning(
        &mut self,
        item: usize,
        within: &str,
    ) -> Result<Option<(Meaning, usize)>, StreamError> {
        let parsed = self.parsed;
        let up = match parsed.own(item, "up") {
            None => 0,
            Some(text) => whole(text)
                .filter(|up| *up <= 64)
                .ok_or_else(|| parsed.bad(item, format!("vh:up {text}, expected 0 to 64")))?,
        };
        let counts = parsed.own(item, "counts");
        let meaning = if let Some(label) = counts {
            Meaning::CountOf(names::read_owned(label))
        } else if let Some(id) = parsed.own(item, "bytesOf") {
            self.references.push((item, id));
            Meaning::BytesOf(self.references.len() as u32 - 1)
        } else if parsed.own(item, "bytesAfter").is_some() {
            Meaning::BytesAfter
        } else if self.is_foreign
            && names::read(parsed.label(item).unwrap_or_default()) == "NoOfBones"
        {
            let up = usize::from(within == "MainHeader");
            return Ok(Some((Meaning::CountOf("BoneMask".into()), up)));
        } else {
            return Ok(None);
        };
        Ok(Some((meaning, up as usize)))
    }

    /// The field of the first of some parameters, and the number of those that are its parts.
    fn field(&self, items: &[usize], meaning: Meaning) -> Result<(Field, usize), StreamError> {
        let parsed = self.parsed;
        let first = items[0];
        let count = parsed.own(first, "parts").map_or(Some(1), whole);
        let count = count.filter(|count| (1..=9).contains(count));
        let items = count
            .and_then(|count| items.get(..count as usize))
            .ok_or_else(|| parsed.bad(first, "vh:parts, expected the number of its Parameters"))?;
        let mut found = Vec::with_capacity(items.len());
        let mut end = parsed.items[first].bits.start;
        for item in items {
            let here = &parsed.items[*item];
            match &here.parameter {
                Some(parameter) if here.bits.start == end => {
                    end = here.bits.end;
                    found.push((parameter.width, parameter.value));
                }
                _ => {
                    return Err(
                        parsed.bad(*item, "expected a further part of the number before it")
                    );
                }
            }
        }
        let told = parsed.own(first, "coding");
        let coding = parts::coding(told).ok_or_else(|| {
            let told = told.unwrap_or_default();
            let what = format!("vh:coding {told}, expected bigEndian, littleEndian or varint");
            parsed.bad(first, what)
        })?;
        let field = Field {
            name: names::read_owned(parsed.label(first).unwrap_or_default()),
            bits: parsed.items[first].bits.start..end,
            value: parts::join(coding, &found)
                .ok_or_else(|| parsed.bad(first, format!("parts that are no {coding:?} number")))?,
            coding,
            meaning,
        };
        Ok((field, items.len()))
    }

    /// Puts numbers of units in the place of their names.
    fn resolve(&self, unit: &mut Unit) -> Result<(), StreamError> {
        for field in &mut unit.fields {
            if let Meaning::BytesOf(reference) = &mut field.meaning {
                let (item, id) = self.references[*reference as usize];
                let found = self.ids.get(id).copied();
                *reference = found.ok_or_else(|| {
                    self.parsed
                        .bad(item, format!("there is no unit with vh:id {id}"))
                })?;
            }
        }
        unit.children
            .iter_mut()
            .try_for_each(|child| self.resolve(child))
    }
}
