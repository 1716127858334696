//! Random maps that a description can hold.

use articula_mutate::Dice;
use articula_stream::{Coding, Field, Marker, Meaning, Unit};
use std::fmt::Write;
use std::ops::Range;

const NAMES: &[&str] = &[
    "",
    "unit",
    "BoneMask",
    "bonemask",
    "BoneSegment",
    "AccessUnit",
    ":MG4:Padding",
    ":x:y",
    "a b",
    "<&\"'\n>",
    "ü→",
];
const SCHEMES: &[&str] = &[
    "loa",
    "region",
    "tier",
    "level",
    "L",
    "a:b c",
    "access_unit",
    "",
];

/// A map of the bits of a stream with `bytes` bytes, whose values are any.
pub(crate) fn map(dice: &mut Dice, bytes: u64) -> Unit {
    let mut map = unit(dice, 0..8 * bytes, 0);
    let roots = ["ABP-1", "AFP-1", "abp2", "afp2", "mesh stream", "whole", ""];
    map.label = dice.of(&roots).into();
    map.padding = false;
    let mut count = 0;
    map.visit(&mut |_| count += 1);
    name_units(&mut map, dice, count);
    map
}

fn unit(dice: &mut Dice, bits: Range<u64>, depth: u32) -> Unit {
    let mut unit = Unit {
        label: dice.of(NAMES).into(),
        ..Unit::of_bytes("", 0..0)
    };
    for _ in 0..dice.roll(3) {
        let scheme = dice.of(SCHEMES).into();
        let value = dice.roll(1 << 32) as u32 >> dice.roll(32);
        unit.markers.push(Marker { scheme, value });
    }
    let length = bits.end - bits.start;
    unit.bits = bits.clone();
    unit.padding = length < 8 && dice.roll(4) == 0;
    if unit.padding || depth > 4 {
        return unit;
    }
    let mut at = bits.start;
    for _ in 0..dice.roll(6) {
        let start = at + dice.roll((bits.end - at) as usize / 4 + 1) as u64;
        let end = start + dice.roll((bits.end - start) as usize / 2 + 1) as u64;
        let field = field(dice, start, bits.end).filter(|_| dice.roll(3) == 0);
        if let Some(field) = field {
            at = field.bits.end;
            unit.fields.push(field);
        } else {
            at = end;
            unit.children.push(self::unit(dice, start..end, depth + 1));
        }
    }
    unit
}

fn field(dice: &mut Dice, start: u64, end: u64) -> Option<Field> {
    let coding = dice.of(&[Coding::BigEndian, Coding::LittleEndian, Coding::Varint]);
    let (start, bits) = match coding {
        Coding::BigEndian => (start, 1 + dice.roll(64) as u64),
        Coding::LittleEndian => (start.div_ceil(8) * 8, 8 + 8 * dice.roll(8) as u64),
        Coding::Varint => (start.div_ceil(8) * 8, 8 + 8 * dice.roll(9) as u64),
    };
    let value_bits = if coding == Coding::Varint {
        bits / 8 * 7
    } else {
        bits
    };
    let value = (dice.roll(usize::MAX) as u64) << 1 | dice.roll(2) as u64;
    let meaning = match dice.roll(3) {
        0 => Meaning::BytesAfter,
        1 => Meaning::BytesOf(0),
        _ => Meaning::CountOf(dice.of(NAMES).into()),
    };
    (start + bits <= end).then(|| Field {
        name: dice.of(NAMES).into(),
        bits: start..start + bits,
        value: value & (u64::MAX >> (64 - value_bits)),
        coding,
        meaning,
    })
}

/// Lets fields name any unit.
fn name_units(unit: &mut Unit, dice: &mut Dice, count: usize) {
    for field in &mut unit.fields {
        if let Meaning::BytesOf(number) = &mut field.meaning {
            *number = dice.roll(count) as u32;
        }
    }
    for child in &mut unit.children {
        name_units(child, dice, count);
    }
}

/// A random description of BBA access units as annex B has them, whose elements have a prefix, and a
/// stream for it.
pub(crate) fn bba(dice: &mut Dice, prefix: &str) -> (String, Vec<u8>) {
    let mut out = String::from(
        "<DIA xmlns:g=\"urn:mpeg:mpeg21:dia:schema:gBSD:2003\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\
         <Description xsi:type=\"gBSDType\" addressUnit=\"bit\" addressMode=\"Absolute\">\n",
    );
    let mut bits = Vec::<u8>::new();
    for _ in 0..1 + dice.roll(5) {
        access_unit(dice, prefix, &mut out, &mut bits);
    }
    out.push_str("</Description></DIA>");
    let bytes = bits
        .chunks(8)
        .map(|eight| eight.iter().fold(0, |byte, bit| byte << 1 | bit));
    (out, bytes.collect())
}

fn access_unit(dice: &mut Dice, p: &str, out: &mut String, bits: &mut Vec<u8>) {
    let start = bits.len() as u64;
    let segment = start + 82;
    let (inner, bones, padding, end) = bone_segment(dice, p, segment);
    writeln!(
        out,
        "<{p}gBSDUnit start=\"{start}\" length=\"{}\" marker=\"access_unit\"><{p}gBSDUnit syntacticalLabel=\":MG4:BBAPlane\" \
         start=\"{start}\" length=\"49\"/><{p}gBSDUnit syntacticalLabel=\":MG4:MainHeader\" start=\"{}\" length=\"33\">\
         <{p}gBSDUnit start=\"{}\" length=\"13\"/><{p}Parameter name=\":MG4:NoOfBones\" start=\"{}\" length=\"10\">\
         <{p}Value xsi:type=\"b10\"> {bones}</{p}Value></{p}Parameter><{p}gBSDUnit start=\"{}\" length=\"10\"/></{p}gBSDUnit>\n\
         <{p}gBSDUnit syntacticalLabel=\":MG4:BoneSegment\" start=\"{segment}\" length=\"{}\">{inner}</{p}gBSDUnit>\
         <{p}gBSDUnit syntacticalLabel=\":MG4:BBAPlaneEnd\" start=\"{end}\" length=\"32\"/></{p}gBSDUnit>",
        end + 32 - start,
        start + 49,
        start + 49,
        start + 62,
        start + 72,
        end - segment
    )
    .unwrap();
    bits.extend((start..end + 32).map(|_| dice.roll(2) as u8));
    let mut set = |from: u64, count: u64, value: u64| {
        for place in 0..count {
            bits[(from + count - 1 - place) as usize] = (value >> place & 1) as u8;
        }
    };
    set(start + 62, 10, bones);
    set(end - padding, padding, padding);
}

/// The content of a segment from a bit on, its number of bones, bits of padding, and end.
fn bone_segment(dice: &mut Dice, p: &str, start: u64) -> (String, u64, u64, u64) {
    let levels: Vec<usize> = (0..1 + dice.roll(30)).map(|_| dice.roll(6)).collect();
    let (mut out, mut at) = (String::new(), start);
    let mut unit = |dice: &mut Dice, label: &str, length: u64, marker: &str| {
        let mut attributes = [
            format!(" syntacticalLabel=\":MG4:{label}\""),
            format!(" start='{at}'"),
            format!(" length=\"{length}\""),
            format!(" marker=\"{marker}\""),
        ];
        attributes.swap(0, dice.roll(4));
        attributes.swap(1, dice.roll(4));
        writeln!(out, "<{p}gBSDUnit{}/>", attributes.concat()).unwrap();
        if dice.roll(5) == 0 {
            out.push_str("<!-- L:0 <gBSDUnit/> -->");
        }
        at += length;
    };
    for level in &levels {
        let length = 1 + dice.roll(40) as u64;
        unit(dice, "BoneMask", length, &format!("L:{level}"));
    }
    unit(dice, "BBACodingType", 1, "codingType");
    for level in &levels {
        let length = 1 + dice.roll(400) as u64;
        unit(dice, "BoneValue", length, &format!(" L:{level}"));
    }
    let padding = (8 - at % 8) % 8;
    if padding > 0 {
        write!(
            out,
            "<{p}Parameter name=\":MG4:Padding\" start=\"{at}\" length=\"{padding}\"><{p}Value xsi:type=\"b{padding}\">\
             <![CDATA[{padding}]]></{p}Value></{p}Parameter>"
        )
        .unwrap();
    }
    (out, levels.len() as u64, padding, at + padding)
}
