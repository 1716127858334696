//! The sample of annex B: an access unit of 35 bones in 39688 bits.

use std::fmt::Write;

/// Bits of the whole.
pub(crate) const BITS: u64 = 39688;
/// Bones up to each level.
pub(crate) const BONES: [usize; 4] = [5, 10, 24, 35];

/// The level of each bone: the first three and the last two are those of the annex, the others
/// make up the counts.
pub(crate) fn levels() -> Vec<u32> {
    let mut levels = vec![0, 2];
    let mut left = [4, 5, 12, 10];
    for level in [1, 0, 3, 2].into_iter().cycle() {
        if levels.len() == 33 {
            break;
        }
        if left[level] > 0 {
            left[level] -= 1;
            levels.push(level as u32);
        }
    }
    levels.extend([3, 2]);
    levels
}

/// Bits of the values: the printed ones where they are printed, 38693 together.
pub(crate) fn value_bits() -> Vec<u64> {
    let mut bits = vec![3420, 100];
    bits.extend((0..30).map(|i| 1000 + 7 * (i % 5)));
    bits.push(812);
    bits.push(1901);
    let rest = 38693 - bits.iter().sum::<u64>();
    bits.insert(2, rest);
    bits
}

/// The stream: its number of bones is 35, its padding 2, all other bits are any.
pub(crate) fn stream() -> Vec<u8> {
    let mut bytes: Vec<u8> = (0..BITS / 8).map(|i| (i * 151 + i / 7) as u8).collect();
    let mut set = |bits: std::ops::Range<u64>, value: u64| {
        for (place, bit) in bits.rev().enumerate() {
            let mask = 1 << (7 - bit % 8);
            let byte = &mut bytes[(bit / 8) as usize];
            *byte = if value >> place & 1 == 1 {
                *byte | mask
            } else {
                *byte & !mask
            };
        }
    };
    set(49..54, 0);
    set(54..59, 1);
    set(59..62, 0);
    set(62..72, 35);
    set(72..82, 0);
    set(39654..39656, 2);
    bytes
}

/// The description, with the prefix that the elements of gBSD have (`g:`), or without a namespace.
pub(crate) fn description(prefix: &str) -> String {
    let mut out = String::from(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<dia:DIA xmlns:g=\"urn:mpeg:mpeg21:2003:01-DIA-gBSD-NS\" \
         xmlns:dia=\"urn:mpeg:mpeg21:2003:01-DIA-NS\" xmlns:bsdl-1=\"urn:mpeg:mpeg21:2003:01-DIA-BSDL1-NS\" \
         xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\n<dia:Description xsi:type=\"gBSDType\" \
         addressUnit=\"bit\" addressMode=\"Absolute\" bsdl-1:bitstreamURI=\".\\sequ.raw\">\n",
    );
    let p = prefix;
    writeln!(
        out,
        "<{p}gBSDUnit start=\"0\" length=\"39688\" marker=\"access_unit\">"
    )
    .unwrap();
    writeln!(
        out,
        "<{p}gBSDUnit syntacticalLabel=\":MG4:BBAPlane\" start=\"0\" length=\"49\"/>"
    )
    .unwrap();
    writeln!(
        out,
        "<{p}gBSDUnit syntacticalLabel=\":MG4:MainHeader\" start=\"49\" length=\"33\">"
    )
    .unwrap();
    let header = [
        ("NoOfInterpolatedFrames", 49, 5, 0),
        ("QuantizationValue", 54, 5, 1),
        ("Pow2Quantizer", 59, 3, 0),
        ("NoOfBones", 62, 10, 35),
        ("NoOfMuscles", 72, 10, 0),
    ];
    let parameter = |out: &mut String, name: &str, start: u64, bits: u64, value: u64| {
        writeln!(
            out,
            "<{p}Parameter name=\":MG4:{name}\" start=\"{start}\" length=\"{bits}\">\
             <{p}Value xsi:type=\"b{bits}\">{value}</{p}Value></{p}Parameter>"
        )
        .unwrap();
    };
    for (name, start, bits, value) in header {
        parameter(&mut out, name, start, bits, value);
    }
    writeln!(out, "</{p}gBSDUnit>").unwrap();
    writeln!(
        out,
        "<{p}gBSDUnit syntacticalLabel=\":MG4:BoneSegment\" start=\"82\" length=\"39574\">"
    )
    .unwrap();
    let mut at = 82;
    let mut unit = |out: &mut String, label: &str, bits: u64, marker: &str| {
        writeln!(
            out,
            "  <{p}gBSDUnit syntacticalLabel=\":MG4:{label}\" start=\"{at}\" length=\"{bits}\" marker=\"{marker}\"/>"
        )
        .unwrap();
        at += bits;
    };
    for (bone, level) in levels().into_iter().enumerate() {
        let bits = if bone == 0 { 28 } else { 25 };
        unit(&mut out, "BoneMask", bits, &format!("L:{level}"));
    }
    unit(&mut out, "BBACodingType", 1, "codingType");
    for (bits, level) in value_bits().into_iter().zip(levels()) {
        unit(&mut out, "BoneValue", bits, &format!("L:{level}"));
    }
    parameter(&mut out, "Padding", 39654, 2, 2);
    writeln!(out, "</{p}gBSDUnit>").unwrap();
    writeln!(
        out,
        "<{p}gBSDUnit syntacticalLabel=\":MG4:BBAPlaneEnd\" start=\"39656\" length=\"32\"/>"
    )
    .unwrap();
    writeln!(
        out,
        "</{p}gBSDUnit>\n<!-- the other access units -->\n</dia:Description></dia:DIA>"
    )
    .unwrap();
    out
}

#[test]
fn the_sample_has_the_printed_places() {
    let levels = levels();
    for (level, count) in BONES.into_iter().enumerate() {
        let kept = levels.iter().filter(|l| **l as usize <= level).count();
        assert_eq!(kept, count, "level {level}");
    }
    assert_eq!(value_bits().iter().sum::<u64>(), 39654 - 961);
    assert_eq!(82 + 28 + 34 * 25, 960);
}
