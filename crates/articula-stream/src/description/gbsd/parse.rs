//! From XML to units and parameters with their bits in the original stream.

use super::names::{self, Tokens};
use crate::description::xml::{Document, Namespace, whole};
use crate::error::StreamError;
use crate::limits::DescriptionLimits;
use std::ops::Range;

/// A field that is written anew.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Parameter {
    /// Its bits in the output, 1 to 64.
    pub(super) width: u32,
    pub(super) value: u64,
    /// The element of the value.
    pub(super) element: usize,
}

/// A `gBSDUnit` or a `Parameter`.
#[derive(Debug)]
pub(super) struct Item {
    /// Its element.
    pub(super) element: usize,
    pub(super) parent: Option<usize>,
    /// Number of the item after the last one within it.
    pub(super) end: usize,
    /// Its bits in the original stream.
    pub(super) bits: Range<u64>,
    /// Bits of the unit of its addresses, 1 or 8.
    pub(super) unit: u64,
    /// Whether it has an address of its own.
    pub(super) is_placed: bool,
    pub(super) parameter: Option<Parameter>,
    /// Bytes that the description itself carries.
    pub(super) carried: Option<Vec<u8>>,
}

/// A description whose items are numbered in their order.
#[derive(Debug)]
pub(super) struct Parsed<'a> {
    pub(super) document: Document<'a>,
    /// The element of the description.
    pub(super) description: usize,
    pub(super) items: Vec<Item>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Absolute,
    Offset,
    Consecutive,
}

#[derive(Debug, Clone, Copy)]
struct Addresses {
    mode: Mode,
    unit: u64,
}

impl<'a> Parsed<'a> {
    pub(super) fn read(bytes: &'a [u8], limits: &DescriptionLimits) -> Result<Self, StreamError> {
        let document = Document::parse(bytes, limits)?;
        let description = description(&document)?;
        let mut parsed = Self {
            document,
            description,
            items: Vec::new(),
        };
        let addresses = Addresses {
            mode: Mode::Absolute,
            unit: 1,
        };
        let addresses = parsed.addresses(description, addresses)?;
        parsed.children(description, None, addresses, 0)?;
        if parsed.items.is_empty() {
            let what = "the description has no gBSDUnit of the namespace of gBSD or of none";
            return Err(parsed.document.bad(description, what));
        }
        Ok(parsed)
    }

    /// The numbers of the items in an item, or at the top.
    pub(super) fn inside(&self, of: Option<usize>) -> impl Iterator<Item = usize> + '_ {
        let (mut next, end) = match of {
            Some(item) => (item + 1, self.items[item].end),
            None => (0, self.items.len()),
        };
        std::iter::from_fn(move || {
            let here = next;
            (here < end).then(|| {
                next = self.items[here].end;
                here
            })
        })
    }

    /// The name in the description of a unit or parameter; `None` if it has none.
    pub(super) fn label(&self, item: usize) -> Option<&str> {
        let attribute = if self.items[item].parameter.is_some() {
            "name"
        } else {
            "syntacticalLabel"
        };
        self.document.value(self.items[item].element, attribute)
    }

    pub(super) fn tokens(&self, item: usize, ordinal: u32) -> Tokens {
        let text = self.document.value(self.items[item].element, "marker");
        text.map_or_else(Tokens::default, |text| names::markers(text, ordinal))
    }

    /// The value of an attribute of our namespace.
    pub(super) fn own(&self, item: usize, name: &str) -> Option<&str> {
        let element = self.items[item].element;
        let found = self.document.attribute(element, Namespace::Vh, name);
        found.map(|attribute| attribute.value.as_ref())
    }

    /// Whether the description comes from another program.
    pub(super) fn is_foreign(&self) -> bool {
        let own = self
            .document
            .attribute(self.description, Namespace::Vh, "tree");
        own.is_none()
    }

    /// An error at an item, with its name.
    pub(super) fn bad(&self, item: usize, what: impl std::fmt::Display) -> StreamError {
        let label = self.label(item).unwrap_or_default();
        let element = self.items[item].element;
        let name = self.document.elements[element].name;
        let what = format!("{name} {item} \"{label}\": {what}");
        self.document.bad(element, what)
    }

    fn addresses(&self, element: usize, outer: Addresses) -> Result<Addresses, StreamError> {
        let mut addresses = outer;
        let document = &self.document;
        if let Some(unit) = document.value(element, "addressUnit") {
            addresses.unit = match unit.trim().to_ascii_lowercase().as_str() {
                "bit" => 1,
                "byte" => 8,
                other => {
                    let what = format!("addresses in {other}, expected bit or byte");
                    return Err(document.bad(element, what));
                }
            };
        }
        if let Some(mode) = document.value(element, "addressMode") {
            addresses.mode = match mode.trim().to_ascii_lowercase().as_str() {
                "absolute" => Mode::Absolute,
                "offset" => Mode::Offset,
                "consecutive" => Mode::Consecutive,
                other => {
                    let what =
                        format!("address mode {other}, expected Absolute, Offset or Consecutive");
                    return Err(document.bad(element, what));
                }
            };
        }
        Ok(addresses)
    }

    /// Reads the items in an element and returns the end of the last one.
    fn children(
        &mut self,
        element: usize,
        parent: Option<usize>,
        addresses: Addresses,
        start: u64,
    ) -> Result<u64, StreamError> {
        let mut at = start;
        let children: Vec<usize> = self.document.children(element).collect();
        for child in children {
            let namespace = self.document.elements[child].namespace;
            if !matches!(namespace, Namespace::Gbsd | Namespace::Absent) {
                continue;
            }
            if self.document.is(child, "gBSDUnit") || self.document.is(child, "Parameter") {
                at = self.item(child, parent, addresses, start, at)?;
            } else if !self.document.is(child, "Header") {
                let name = self.document.elements[child].name;
                let what = format!("<{name}>, expected gBSDUnit, Parameter or Header");
                return Err(self.document.bad(child, what));
            }
        }
        Ok(at)
    }

    fn item(
        &mut self,
        element: usize,
        parent: Option<usize>,
        outer: Addresses,
        parent_start: u64,
        before: u64,
    ) -> Result<u64, StreamError> {
        let addresses = self.addresses(element, outer)?;
        let given = self.address(element, "start", addresses)?;
        let too_far = |this: &Self| this.document.bad(element, "an address beyond 2^62 bits");
        let start = match (addresses.mode, given) {
            (_, None) => before,
            (Mode::Absolute, Some(start)) => start,
            (Mode::Offset, Some(start)) => {
                bounded(parent_start.checked_add(start)).ok_or_else(|| too_far(self))?
            }
            (Mode::Consecutive, Some(start)) if start == before => start,
            (Mode::Consecutive, Some(_)) => {
                let what = "a start in address mode Consecutive, which has none";
                return Err(self.document.bad(element, what));
            }
        };
        let length = self.address(element, "length", addresses)?;
        let number = self.items.len();
        let parameter = if self.document.is(element, "Parameter") {
            Some(self.parameter(element, length)?)
        } else {
            None
        };
        let is_parameter = parameter.is_some();
        let width = parameter.as_ref().map(|p| u64::from(p.width));
        self.items.push(Item {
            element,
            parent,
            end: number + 1,
            bits: start..start,
            unit: addresses.unit,
            is_placed: given.is_some(),
            parameter,
            carried: None,
        });
        let inner_end = if is_parameter {
            start
        } else {
            self.children(element, Some(number), addresses, start)?
        };
        let is_leaf = self.items.len() == number + 1 && !is_parameter;
        let text = self.document.text(element);
        let carried = if is_leaf && !text.is_empty() {
            Some(hex(text).ok_or_else(|| {
                let what = "text in a gBSDUnit, expected bytes in hexadecimal form";
                self.document.bad(element, what)
            })?)
        } else {
            None
        };
        let told = length.or(width);
        let length = match (&carried, told) {
            (Some(bytes), told) => {
                let bits = 8 * bytes.len() as u64;
                let length = told.unwrap_or(bits);
                if length.div_ceil(8) * 8 != bits {
                    let what = format!("{} bytes for a length of {length} bits", bytes.len());
                    return Err(self.document.bad(element, what));
                }
                length
            }
            (None, Some(length)) => length,
            (None, None) if !is_leaf => inner_end.saturating_sub(start),
            (None, None) => return Err(self.document.bad(element, "a unit without a length")),
        };
        let end = bounded(start.checked_add(length)).ok_or_else(|| too_far(self))?;
        let items = self.items.len();
        let item = &mut self.items[number];
        item.bits = start..end;
        item.end = items;
        item.carried = carried;
        Ok(end)
    }

    /// An address in bits.
    fn address(
        &self,
        element: usize,
        name: &str,
        addresses: Addresses,
    ) -> Result<Option<u64>, StreamError> {
        let Some(text) = self.document.value(element, name) else {
            return Ok(None);
        };
        let found = whole(text).and_then(|number| number.checked_mul(addresses.unit));
        match bounded(found) {
            Some(bits) => Ok(Some(bits)),
            None => {
                let what = format!("{name} {text}, expected a whole number below 2^62 bits");
                Err(self.document.bad(element, what))
            }
        }
    }

    fn parameter(&self, element: usize, length: Option<u64>) -> Result<Parameter, StreamError> {
        let document = &self.document;
        let bad = |what: String| document.bad(element, what);
        let mut values = document
            .children(element)
            .filter(|c| document.is(*c, "Value"));
        let (Some(value), None) = (values.next(), values.next()) else {
            return Err(bad("a Parameter has one Value".into()));
        };
        let kind = document.kind(value).unwrap_or_default();
        let width = kind.strip_prefix(['b', 'B']).and_then(whole);
        let width = width.filter(|width| (1..=64).contains(width));
        let width =
            width.ok_or_else(|| bad(format!("a Value of type \"{kind}\", expected b1 to b64")))?;
        if length.is_some_and(|length| length != width) {
            let what = format!("a length other than the {width} bits of its Value");
            return Err(bad(what));
        }
        let text = document.text(value);
        let number = whole(text).filter(|number| width == 64 || number >> width == 0);
        let number = number.ok_or_else(|| {
            bad(format!(
                "a Value of \"{text}\", expected a number of {width} bits"
            ))
        })?;
        Ok(Parameter {
            width: width as u32,
            value: number,
            element: value,
        })
    }
}

fn bounded(bits: Option<u64>) -> Option<u64> {
    bits.filter(|bits| *bits < 1 << 62)
}

/// The element of a description of a bitstream.
fn description(document: &Document<'_>) -> Result<usize, StreamError> {
    let all = (0..document.elements.len()).filter(|e| document.is(*e, "Description"));
    let is_gbsd = |e: &usize| {
        let kind = document.kind(*e);
        kind.is_some_and(|kind| kind.eq_ignore_ascii_case("gBSDType"))
            || kind.is_none() && document.child(*e, "gBSDUnit").is_some()
    };
    let found = all.clone().find(is_gbsd);
    found.ok_or_else(|| document.bad(0, "expected a Description of type gBSDType"))
}

/// Bytes in hexadecimal form; white space between digits is nothing.
fn hex(text: &str) -> Option<Vec<u8>> {
    let digits = text.bytes().filter(|byte| !byte.is_ascii_whitespace());
    let mut bytes = Vec::with_capacity(text.len() / 2);
    let mut high = None;
    for byte in digits {
        let digit = char::from(byte).to_digit(16)?;
        high = match high {
            None => Some(digit),
            Some(high) => {
                bytes.push((16 * high + digit) as u8);
                None
            }
        };
    }
    high.is_none().then_some(bytes)
}
