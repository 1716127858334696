//! gBSD: round trips, the sample of annex B, addresses, carried bytes and streams made from them.

use crate::tools::LIMITS;
use crate::{annex_b, random};
use articula_mutate::Dice;
use articula_stream::description::{GbsdOptions, Holes, gbsd_to_bin, read_gbsd, write_gbsd};
use articula_stream::{CutRule, Meaning, Unit, cut, read_index};
use proptest::prelude::*;

fn written(map: &Unit) -> String {
    write_gbsd(map, &GbsdOptions::default()).unwrap()
}

fn read(text: &str) -> Unit {
    read_gbsd(text.as_bytes(), &LIMITS).unwrap().unit
}

proptest! {
    #[test]
    fn any_map_comes_back_and_describes_the_whole_stream(seed: u64, bytes in 0u64..200) {
        let mut dice = Dice::new(seed);
        let map = random::map(&mut dice, bytes);
        map.check().unwrap();
        let text = written(&map);
        let found = read_gbsd(text.as_bytes(), &LIMITS).unwrap();
        prop_assert_eq!(&found.unit, &map);
        prop_assert_eq!(found.payload, None);
        prop_assert!(found.parameters.is_empty() && found.tokens.is_empty());
        // Numbers of the map instead of those of the stream, all else as it was.
        let mut stream: Vec<u8> = (0..bytes).map(|_| dice.roll(256) as u8).collect();
        let whole = gbsd_to_bin(text.as_bytes(), &stream, Holes::Refuse, &LIMITS);
        let mut is_possible = true;
        map.visit(&mut |unit| {
            for field in &unit.fields {
                field.coding.write(&mut stream, &field.bits, field.value).unwrap();
            }
            if unit.padding {
                let bits = unit.bits.end - unit.bits.start;
                for (place, bit) in unit.bits.clone().rev().enumerate() {
                    let mask = 1 << (7 - bit % 8);
                    let byte = &mut stream[(bit / 8) as usize];
                    *byte = if bits >> place & 1 == 1 { *byte | mask } else { *byte & !mask };
                }
            }
            is_possible &= unit.marker("access_unit").is_none() || unit.bits.end.is_multiple_of(8);
        });
        prop_assert_eq!(whole.ok(), is_possible.then_some(stream));
    }
}

#[test]
fn a_stored_map_comes_back() {
    for (stream, index) in [
        (
            &include_bytes!("../../../articula-stream/tests/golden/walk.abp")[..],
            &include_bytes!("../../../articula-stream/tests/golden/walk.auix")[..],
        ),
        (
            include_bytes!("../../../articula-stream/tests/golden/wave.abp"),
            include_bytes!("../../../articula-stream/tests/golden/wave.auix"),
        ),
    ] {
        let map = read_index(index).unwrap();
        let text = written(&map);
        assert_eq!(read(&text), map);
        let found = gbsd_to_bin(text.as_bytes(), stream, Holes::Refuse, &LIMITS);
        assert_eq!(found.unwrap(), stream);
    }
}

#[test]
fn the_sample_of_annex_b_is_a_map_that_can_be_cut() {
    let stream = annex_b::stream();
    for prefix in ["g:", ""] {
        let text = annex_b::description(prefix);
        let found = read_gbsd(text.as_bytes(), &LIMITS).unwrap();
        assert_eq!(found.bitstream.as_deref(), Some(".\\sequ.raw"));
        assert_eq!(found.tokens, ["codingType"]);
        let fixed: Vec<_> = found
            .parameters
            .iter()
            .map(|p| (p.bits.start, p.value))
            .collect();
        assert_eq!(fixed, [(49, 0), (54, 1), (59, 0), (72, 0)]);
        let map = found.unit;
        assert_eq!(
            (map.label.as_ref(), map.bits.clone()),
            ("AccessUnit", 0..annex_b::BITS)
        );
        let count = &map.fields[0];
        assert_eq!((count.bits.clone(), count.value), (62..72, 35));
        assert_eq!(count.meaning, Meaning::CountOf("BoneMask".into()));
        map.check_values(&stream).unwrap();
        assert_eq!(
            gbsd_to_bin(text.as_bytes(), &stream, Holes::Refuse, &LIMITS).unwrap(),
            stream
        );
        for (level, bones) in annex_b::BONES.into_iter().enumerate() {
            let rule = CutRule::default().at_most("loa", level as u32);
            let part = cut(&stream, &map, |unit| rule.keeps(unit)).unwrap();
            assert_eq!(part.unit.fields[0].value, bones as u64);
            assert_eq!(part.bytes == stream, level == 3);
            // What was cut is described again, with annex B's names, and read back.
            let again = written(&part.unit);
            assert!(again.contains("name=\":MG4:NoOfBones\""));
            assert_eq!(read(&again), part.unit);
        }
    }
}

#[test]
fn names_of_the_scan_are_read_in_lower_case() {
    let text = annex_b::description("");
    let lower = text
        .to_lowercase()
        .replace("<parameter", "<Parameter")
        .replace("</parameter", "</Parameter");
    assert_eq!(read(&lower), read(&text));
}

/// A description with the attributes and content of its Description.
fn of(attributes: &str, content: &str) -> String {
    format!(
        "<DIA xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\"><Description xsi:type=\"gBSDType\" \
         {attributes}>{content}</Description></DIA>"
    )
}

#[test]
fn addresses_of_all_modes_are_the_same() {
    let absolute = of(
        "addressUnit=\"bit\" addressMode=\"Absolute\"",
        "<gBSDUnit syntacticalLabel=\"w\" start=\"8\" length=\"40\"><gBSDUnit syntacticalLabel=\"a\" start=\"8\" length=\"16\"/>\
         <gBSDUnit syntacticalLabel=\"b\" start=\"24\" length=\"24\"><gBSDUnit syntacticalLabel=\"c\" start=\"32\" length=\"8\"/></gBSDUnit></gBSDUnit>",
    );
    let offset = of(
        "addressUnit=\"byte\" addressMode=\"Offset\"",
        "<gBSDUnit syntacticalLabel=\"w\" start=\"1\" length=\"5\"><gBSDUnit syntacticalLabel=\"a\" start=\"0\" length=\"2\"/>\
         <gBSDUnit syntacticalLabel=\"b\" start=\"2\" length=\"3\"><gBSDUnit addressUnit=\"bit\" syntacticalLabel=\"c\" start=\"8\" length=\"8\"/></gBSDUnit></gBSDUnit>",
    );
    let consecutive = of(
        "addressUnit=\"byte\" addressMode=\"absolute\"",
        "<gBSDUnit syntacticalLabel=\"w\" start=\"1\" length=\"5\"><gBSDUnit addressMode=\"Consecutive\" syntacticalLabel=\"a\" length=\"2\"/>\
         <gBSDUnit addressMode=\"Consecutive\" syntacticalLabel=\"b\" length=\"3\"><gBSDUnit length=\"1\"/><gBSDUnit syntacticalLabel=\"c\" length=\"1\"/></gBSDUnit></gBSDUnit>",
    );
    assert_eq!(read(&absolute), read(&offset));
    assert_eq!(read(&absolute), read(&consecutive));
    let cd_stage = absolute.replace(
        "<DIA",
        "<DIA xmlns=\"urn:mpeg:mpeg21:dia:schema:gBSD:2003\"",
    );
    assert_eq!(read(&absolute), read(&cd_stage));
}

#[test]
fn bytes_in_the_description_are_the_stream() {
    let text = of(
        "addressUnit=\"byte\" addressMode=\"Consecutive\"",
        "<gBSDUnit syntacticalLabel=\"w\"><gBSDUnit syntacticalLabel=\"a\" marker=\"L:1\">0a0B\n 0c</gBSDUnit>\
         <Parameter name=\"n\"><Value xsi:type=\"b8\">13</Value></Parameter><gBSDUnit>0e</gBSDUnit></gBSDUnit>",
    );
    let found = read_gbsd(text.as_bytes(), &LIMITS).unwrap();
    assert_eq!(found.payload.unwrap(), [10, 11, 12, 13, 14]);
    assert_eq!(found.unit.bits, 0..40);
    assert_eq!(found.unit.children[0].bits, 0..24);
    assert_eq!(found.unit.children[0].marker("loa"), Some(1));
    assert_eq!(
        gbsd_to_bin(text.as_bytes(), &[], Holes::Refuse, &LIMITS).unwrap(),
        [10, 11, 12, 13, 14]
    );
    let odd = text.replace("0e<", "0<");
    assert!(read_gbsd(odd.as_bytes(), &LIMITS).is_err());
    let mixed = text.replace(">0e</gBSDUnit>", " length=\"1\"/>");
    let said = read_gbsd(mixed.as_bytes(), &LIMITS)
        .unwrap_err()
        .to_string();
    assert!(said.contains("no bytes of its own"), "{said}");
}

#[test]
fn streams_are_made_of_leaves_and_values() {
    let stream = [1, 2, 3, 4, 5];
    let bin =
        |content: &str, holes| gbsd_to_bin(of("", content).as_bytes(), &stream, holes, &LIMITS);
    let parts = "<gBSDUnit start=\"0\" length=\"40\"><gBSDUnit start=\"0\" length=\"8\"/>\
                 <Parameter start=\"8\" length=\"8\"><Value xsi:type=\"b8\">200</Value></Parameter>\
                 <gBSDUnit start=\"24\" length=\"8\"/></gBSDUnit>";
    assert_eq!(bin(parts, Holes::Skip).unwrap(), [1, 200, 4]);
    assert_eq!(bin(parts, Holes::Copy).unwrap(), [1, 200, 3, 4, 5]);
    let refused = |content: &str, holes| bin(content, holes).unwrap_err().to_string();
    assert!(refused(parts, Holes::Refuse).contains("16..24"));
    let beyond = refused(
        "<gBSDUnit syntacticalLabel=\"x\" start=\"32\" length=\"16\"/>",
        Holes::Skip,
    );
    assert_eq!(
        beyond,
        "line 1: gBSDUnit 0 \"x\": bits 32..48 are beyond the stream of 40 bits"
    );
    let twice = "<gBSDUnit start=\"0\" length=\"16\"/><gBSDUnit start=\"8\" length=\"8\"/>";
    assert!(refused(twice, Holes::Skip).contains("begin before 16"));
    let odd = "<gBSDUnit start=\"0\" length=\"3\"/>";
    assert!(refused(odd, Holes::Skip).contains("3 bits, expected whole bytes"));
    let odd = "<gBSDUnit start=\"0\" length=\"3\" marker=\"access_unit\"/><gBSDUnit start=\"3\" length=\"5\"/>";
    assert!(refused(odd, Holes::Skip).contains("renew its padding"));
    let wide = "<Parameter><Value xsi:type=\"b3\">8</Value></Parameter>";
    assert!(refused(wide, Holes::Skip).contains("a number of 3 bits"));
    for number in [
        "-1",
        "1.5",
        "",
        "0x1",
        "99999999999999999999",
        "4611686018427387904",
    ] {
        let negative = format!("<gBSDUnit start=\"{number}\" length=\"8\"/>");
        assert!(refused(&negative, Holes::Skip).contains("expected a whole number"));
    }
    let overflow = "<gBSDUnit start=\"4611686018427387903\" length=\"4611686018427387903\"/>";
    assert!(refused(overflow, Holes::Skip).contains("beyond 2^62"));
}
