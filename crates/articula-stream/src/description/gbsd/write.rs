//! From a map to its gBSD.

use super::names::{self, ACCESS_UNIT, Family};
use super::parts;
use crate::coding::Coding;
use crate::description::xml::escape;
use crate::unit::{Field, Marker, Meaning, Unit};
use articula_core::Mismatch;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::Range;

/// What a gBSD says besides the map.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct GbsdOptions {
    /// Where the stream is, relative to the description.
    pub bitstream: Option<String>,
}

/// Depth down to which elements have a line of their own: an access unit is one line.
const LINES: usize = 2;

/// Writes a map as a gBSD in bits from the start of the stream. Every bit of the stream is in one
/// unit without parts or in one parameter, so that any program of the standard can write it anew.
///
/// [`read_gbsd`](super::read_gbsd) gives the map back, with the fields of a unit in rising order.
///
/// # Errors
/// A [`Mismatch`] if the map contradicts itself ([`Unit::check`]), fields overlap each other or the
/// edge of a unit, a field counts the bytes of a unit that does not exist, padding has parts, or a
/// name has characters that XML cannot hold.
pub fn write_gbsd(map: &Unit, options: &GbsdOptions) -> Result<String, Mismatch> {
    map.check()?;
    let mut named = BTreeMap::new();
    let mut units = 0;
    map.visit(&mut |unit| {
        units += 1;
        for field in &unit.fields {
            if let Meaning::BytesOf(number) = field.meaning {
                named.insert(number, field.name.as_ref());
            }
        }
    });
    if let Some((number, name)) = named.iter().next_back()
        && *number >= units
    {
        let what = format!("there is no unit {number}");
        return Err(Mismatch::new(*name, what));
    }
    let mut writer = Writer {
        family: Family::of(map),
        named,
        number: 0,
        out: String::from(HEAD),
    };
    if let Some(uri) = &options.bitstream {
        writer.attribute("bs1:bitstreamURI", uri)?;
    }
    writer.out.push_str(" vh:tree=\"1\">\n");
    writer.unit(map, Vec::new(), 0)?;
    writer.out.push_str("</dia:Description>\n</dia:DIA>\n");
    Ok(writer.out)
}

const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
    <dia:DIA xmlns:dia=\"urn:mpeg:mpeg21:2003:01-DIA-NS\" \
    xmlns=\"urn:mpeg:mpeg21:2003:01-DIA-gBSD-NS\" \
    xmlns:bs1=\"urn:mpeg:mpeg21:2003:01-DIA-BSDL1-NS\" xmlns:vh=\"urn:articula:vh:1\" \
    xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\n\
    <dia:Description xsi:type=\"gBSDType\" addressUnit=\"bit\" addressMode=\"Absolute\"";

struct Writer<'a> {
    family: Family,
    /// Units whose bytes a field counts, with the name of one.
    named: BTreeMap<u32, &'a str>,
    /// Number of the next unit.
    number: u32,
    out: String,
}

/// A field and the number of units between it and the unit that has it.
type Carried<'a> = (&'a Field, usize);

impl<'a> Writer<'a> {
    fn attribute(&mut self, name: &str, value: &str) -> Result<(), Mismatch> {
        let is_text = |c: char| !matches!(c, '\0'..='\x08' | '\x0b' | '\x0c' | '\x0e'..='\x1f' | '\u{fffe}' | '\u{ffff}');
        if !value.chars().all(is_text) {
            let what = "a character that XML cannot hold";
            return Err(Mismatch::new(value.escape_debug().to_string(), what));
        }
        // Writing to a text cannot fail.
        let _ = write!(self.out, " {name}=\"{}\"", escape(value));
        Ok(())
    }

    fn place(&mut self, bits: &Range<u64>) {
        let _ = write!(
            self.out,
            " start=\"{}\" length=\"{}\"",
            bits.start,
            bits.end - bits.start
        );
    }

    fn markers(&mut self, markers: &[Marker]) -> Result<(), Mismatch> {
        if markers.is_empty() {
            return Ok(());
        }
        self.attribute("marker", &names::tokens(markers))
    }

    fn line(&mut self, depth: usize) {
        if depth <= LINES {
            self.out.push('\n');
        }
    }

    /// Attributes of ours at a unit: its number if a field counts its bytes.
    fn own(&mut self) {
        if self.named.contains_key(&self.number) {
            let _ = write!(self.out, " vh:id=\"u{}\"", self.number);
        }
        self.number += 1;
    }

    fn filler(&mut self, bits: Range<u64>, depth: usize) {
        if !bits.is_empty() {
            self.out.push_str("<gBSDUnit");
            self.place(&bits);
            self.out.push_str("/>");
            self.line(depth);
        }
    }

    fn unit(
        &mut self,
        unit: &'a Unit,
        carried: Vec<Carried<'a>>,
        depth: usize,
    ) -> Result<(), Mismatch> {
        let own = unit.fields.iter().map(|field| (field, 0));
        let mut fields: Vec<Carried<'a>> = carried.into_iter().chain(own).collect();
        if unit.padding {
            return self.padding(unit, &fields, depth);
        }
        self.out.push_str("<gBSDUnit");
        let is_access_unit = unit.marker(ACCESS_UNIT).is_some();
        // As in annex B, the marker is the name of an access unit.
        if self.family != Family::Abp1 || unit.label != "AccessUnit" || !is_access_unit {
            let label = match unit.label.as_ref() {
                "" => "".into(),
                label => self.family.written(label),
            };
            self.attribute("syntacticalLabel", &label)?;
        }
        self.place(&unit.bits);
        self.markers(&unit.markers)?;
        self.own();
        if fields.is_empty() && unit.children.is_empty() {
            self.out.push_str("/>");
            self.line(depth);
            return Ok(());
        }
        self.out.push('>');
        self.line(depth + 1);
        fields.sort_by_key(|(field, _)| field.bits.start);
        let mut at = unit.bits.start;
        let mut fields = fields.into_iter().peekable();
        for child in &unit.children {
            while let Some((field, up)) = fields.next_if(|(f, _)| f.bits.start < child.bits.start) {
                at = self.field(field, up, at, depth + 1)?;
            }
            let mut inner = Vec::new();
            while let Some((field, up)) = fields.next_if(|(f, _)| f.bits.start < child.bits.end) {
                inner.push((field, up + 1));
            }
            if at > child.bits.start {
                return Err(Mismatch::new(
                    child.label.as_ref(),
                    "a field lies across its edge",
                ));
            }
            self.filler(at..child.bits.start, depth + 1);
            self.unit(child, inner, depth + 1)?;
            at = child.bits.end;
        }
        for (field, up) in fields {
            at = self.field(field, up, at, depth + 1)?;
        }
        if at > unit.bits.end {
            return Err(Mismatch::new(
                unit.label.as_ref(),
                "a field lies across its edge",
            ));
        }
        self.filler(at..unit.bits.end, depth + 1);
        self.out.push_str("</gBSDUnit>");
        self.line(depth);
        Ok(())
    }

    fn padding(
        &mut self,
        unit: &Unit,
        fields: &[Carried<'_>],
        depth: usize,
    ) -> Result<(), Mismatch> {
        if !unit.children.is_empty() || !fields.is_empty() {
            return Err(Mismatch::new(
                unit.label.as_ref(),
                "padding with parts or fields",
            ));
        }
        let count = unit.bits.end - unit.bits.start;
        let label = match unit.label.as_ref() {
            "" => "".into(),
            label => self.family.written(label),
        };
        let (element, attribute) = match count {
            0 => ("<gBSDUnit", "syntacticalLabel"),
            _ => ("<Parameter", "name"),
        };
        self.out.push_str(element);
        self.attribute(attribute, &label)?;
        self.place(&unit.bits);
        self.markers(&unit.markers)?;
        self.out.push_str(" vh:padding=\"true\"");
        self.own();
        if count == 0 {
            self.out.push_str("/>");
        } else {
            self.value(count, count);
        }
        self.line(depth);
        Ok(())
    }

    fn value(&mut self, width: u64, value: u64) {
        let _ = write!(
            self.out,
            "><Value xsi:type=\"b{width}\">{value}</Value></Parameter>"
        );
    }

    /// Writes a field after the bits from `at`, and returns its end.
    fn field(&mut self, field: &Field, up: usize, at: u64, depth: usize) -> Result<u64, Mismatch> {
        if field.bits.start < at {
            let what = "lies across another field or the edge of a unit";
            return Err(Mismatch::new(field.name.as_ref(), what));
        }
        self.filler(at..field.bits.start, depth);
        let name = self.family.written(&field.name).into_owned();
        let widths = parts::widths(field.coding, field.bits.end - field.bits.start);
        // The map is checked, so that the number fits.
        let values = parts::split(field.coding, field.value, &widths).unwrap_or_default();
        let mut start = field.bits.start;
        for (number, (width, value)) in widths.iter().zip(values).enumerate() {
            let bits = start..start + u64::from(*width);
            start = bits.end;
            self.out.push_str("<Parameter");
            self.attribute("name", &name)?;
            self.place(&bits);
            if number > 0 {
                let _ = write!(self.out, " vh:part=\"{number}\"");
            } else {
                self.meaning(field, up, widths.len())?;
            }
            self.value(u64::from(*width), value);
            self.line(depth);
        }
        Ok(field.bits.end)
    }

    fn meaning(&mut self, field: &Field, up: usize, count: usize) -> Result<(), Mismatch> {
        match &field.meaning {
            Meaning::BytesAfter => self.out.push_str(" vh:bytesAfter=\"true\""),
            Meaning::BytesOf(number) => {
                let _ = write!(self.out, " vh:bytesOf=\"u{number}\"");
            }
            Meaning::CountOf(label) => {
                let label = self.family.written(label).into_owned();
                self.attribute("vh:counts", &label)?;
            }
        }
        if up > 0 {
            let _ = write!(self.out, " vh:up=\"{up}\"");
        }
        if field.coding == Coding::BigEndian && count == 1 {
            return Ok(());
        }
        let coding = parts::name(field.coding);
        let _ = write!(self.out, " vh:coding=\"{coding}\" vh:parts=\"{count}\"");
        Ok(())
    }
}
