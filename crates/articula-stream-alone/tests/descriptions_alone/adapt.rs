//! Transformations of descriptions: the numbers of annex B, and agreement with xsltproc, a script
//! in node and the cut.

use crate::annex_b;
use crate::random::bba as random_bba;
use crate::tools::{Judges, LIMITS, canonical, xsltproc_is_here};
use articula_mutate::Dice;
use articula_stream::description::{
    AdaptMode, GbsdOptions, Holes, Selection, adapt_gbsd, gbsd_to_bin, read_gbsd, write_gbsd,
};
use articula_stream::read_index;

fn adapted(text: &str, selection: &Selection, mode: AdaptMode) -> String {
    adapt_gbsd(text.as_bytes(), selection, mode, &LIMITS).unwrap()
}

fn refused(text: &str, selection: &Selection, mode: AdaptMode) -> String {
    adapt_gbsd(text.as_bytes(), selection, mode, &LIMITS)
        .unwrap_err()
        .to_string()
}

/// The number behind the first `attribute="` after `label`.
fn number(text: &str, label: &str, attribute: &str) -> u64 {
    let after = &text[text.find(label).unwrap()..];
    let after = &after[after.find(attribute).unwrap() + attribute.len() + 2..];
    after[..after.find(['"', '<']).unwrap()].parse().unwrap()
}

#[test]
fn the_sample_of_annex_b_keeps_5_10_24_and_35_bones() {
    let stream = annex_b::stream();
    let mut judges = Judges::new("annex_b");
    for prefix in ["g:", ""] {
        let text = annex_b::description(prefix);
        for (level, bones) in annex_b::BONES.into_iter().enumerate() {
            let selection = Selection::of_loa(level as u32);
            let what = format!("{prefix} level {level}");
            let bytes = judges.check(&what, &text, &stream, &selection);
            let found = adapted(&text, &selection, AdaptMode::Conformant);
            assert_eq!(found.matches(":MG4:BoneMask").count(), bones);
            assert_eq!(found.matches(":MG4:BoneValue").count(), bones);
            let count = &found[found.find(":MG4:NoOfBones").unwrap()..];
            let count = &count[count.find("\"b10\">").unwrap() + 6..];
            assert!(count.starts_with(&format!("{bones}<")));
            if level == 3 {
                assert!(bytes == stream && found == text, "level 3 is the input");
                continue;
            }
            let kept = |(i, _): &(usize, u64)| annex_b::levels()[*i] as usize <= level;
            let masks = (0..35).map(|i| if i == 0 { 28 } else { 25 }).enumerate();
            let values = annex_b::value_bits().into_iter().enumerate();
            let sum: u64 = masks
                .filter(kept)
                .chain(values.filter(kept))
                .map(|(_, bits)| bits)
                .sum();
            let padding = (8 - (82 + sum + 1) % 8) % 8;
            assert_eq!(
                number(&found, ":MG4:BoneSegment", "length"),
                sum + 1 + padding
            );
            assert_eq!(
                number(&found, "gBSDUnit start=\"0\"", "length"),
                82 + sum + 1 + padding + 32
            );
            assert_eq!(bytes.len() as u64, (82 + sum + 1 + padding + 32) / 8);
        }
    }
    judges.finish();
}

#[test]
fn the_literal_mode_has_the_faults_of_the_printed_stylesheet() {
    let text = annex_b::description("");
    let found = adapted(&text, &Selection::of_loa(3), AdaptMode::AnnexBLiteral);
    assert_eq!(number(&found, ":MG4:BoneSegment", "length"), 39576);
    assert!(found.contains("length=\"5\"><Value") && found.contains("xsi:type=\"b5\">5</Value>"));
    assert_eq!(number(&found, "gBSDUnit start=\"0\"", "length"), 39688);
    let stream = annex_b::stream();
    let said = gbsd_to_bin(found.as_bytes(), &stream, Holes::Skip, &LIMITS).unwrap_err();
    assert!(said.to_string().contains("renew its padding"), "{said}");
    // The table of bones ends at level 3.
    let found = adapted(&text, &Selection::of_loa(4), AdaptMode::AnnexBLiteral);
    assert!(found.contains("<Value xsi:type=\"b10\"></Value>"));
    // A second token is no number, so that the bone goes.
    let two = text.replacen("marker=\"L:0\"", "marker=\"L:0 R:1\"", 1);
    let found = adapted(&two, &Selection::of_loa(3), AdaptMode::AnnexBLiteral);
    assert_eq!(found.matches(":MG4:BoneMask").count(), 34);
    // In a namespace it changes nothing, which is refused here.
    let said = refused(
        &annex_b::description("g:"),
        &Selection::of_loa(0),
        AdaptMode::AnnexBLiteral,
    );
    assert!(said.contains("without a namespace"), "{said}");
}

/// A stylesheet with the rules of the printed one, in its own words.
const LITERAL: &str = r#"<xsl:stylesheet version="1.0" xmlns:xsl="http://www.w3.org/1999/XSL/Transform"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
<xsl:param name="nLayersOut" select="3"/>
<xsl:template match="node()|@*" priority="-1"><xsl:copy><xsl:apply-templates select="@*|node()"/></xsl:copy></xsl:template>
<xsl:template match="Parameter[@name=':MG4:Padding']"/>
<xsl:template match="gBSDUnit[contains(':MG4:BoneMask :MG4:BoneValue', string(@syntacticalLabel))][@syntacticalLabel]">
  <xsl:if test="number(substring-after(@marker, 'L:')) &lt;= $nLayersOut"><xsl:copy-of select="."/></xsl:if></xsl:template>
<xsl:template match="Parameter[@name=':MG4:NoOfBones']/Value"><xsl:copy><xsl:copy-of select="@*"/>
  <xsl:value-of select="substring('  5 10 24 35', 3 * $nLayersOut + 1, 3 * number($nLayersOut &lt; 4))"/></xsl:copy></xsl:template>
<xsl:template match="gBSDUnit[@syntacticalLabel=':MG4:BoneSegment']">
  <xsl:variable name="s" select="sum(.//gBSDUnit[@syntacticalLabel=':MG4:BoneMask' or @syntacticalLabel=':MG4:BoneValue'][number(substring-after(@marker, 'L:')) &lt;= $nLayersOut]/@length)"/>
  <xsl:variable name="p" select="8 - $s mod 8"/>
  <xsl:copy><xsl:copy-of select="@*"/><xsl:attribute name="length"><xsl:value-of select="8 * ceiling($s div 8)"/></xsl:attribute>
    <xsl:apply-templates select="node()"/>
    <xsl:if test="$p &lt; 8"><Parameter xmlns="urn:mpeg:mpeg21:2003:01-DIA-gBSD-NS" name="{*/@name}" start="{Parameter[@name=':MG4:Padding']/@start}" length="{$p}">
      <Value xsi:type="b{$p}"><xsl:value-of select="$p"/></Value></Parameter></xsl:if></xsl:copy></xsl:template>
</xsl:stylesheet>"#;

#[test]
fn the_literal_mode_is_that_of_xsltproc() {
    if !xsltproc_is_here() {
        return;
    }
    let judges = Judges::new("literal");
    let folder = std::path::PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("literal");
    std::fs::write(folder.join("literal.xslt"), LITERAL).unwrap();
    let mut dice = Dice::new(7);
    let mut texts = vec![annex_b::description("")];
    texts.extend((0..20).map(|_| random_bba(&mut dice, "").0));
    let squeezed = |text: &str| -> Vec<String> {
        let all = canonical(text).into_iter();
        all.map(|t| {
            t.trim_matches(|c: char| c.is_whitespace() || c == '"')
                .trim()
                .to_owned()
        })
        .filter(|t| !t.is_empty())
        .collect()
    };
    let descriptions: Vec<&str> = texts.iter().map(String::as_str).collect();
    for level in 0..5 {
        let selection = Selection::of_loa(level);
        let others = judges.xslt("literal.xslt", &descriptions, &selection.parameters());
        for (text, other) in texts.iter().zip(others.unwrap()) {
            let native = adapted(text, &selection, AdaptMode::AnnexBLiteral);
            assert_eq!(squeezed(&native), squeezed(&other), "level {level}");
        }
    }
}

#[test]
fn random_descriptions_are_transformed_as_by_xsltproc() {
    let mut judges = Judges::new("random_bba");
    let mut dice = Dice::new(21);
    for case in 0..60 {
        let prefix = dice.of(&["", "g:"]);
        let (text, stream) = random_bba(&mut dice, prefix);
        let level = dice.roll(6) as u32;
        let what = format!("case {case}, level {level}");
        let selection = Selection::of_loa(level);
        let foreign = judges.check(&what, &text, &stream, &selection);
        // The same as a description of ours.
        let map = read_gbsd(text.as_bytes(), &LIMITS).unwrap().unit;
        let own = write_gbsd(&map, &GbsdOptions::default()).unwrap();
        assert_eq!(judges.check(&what, &own, &stream, &selection), foreign);
        let all = judges.check(&what, &own, &stream, &Selection::default());
        assert_eq!(all, stream);
        // Cutting twice is cutting once.
        let part = articula_stream::cut(&stream, &map, |unit| selection.keeps(unit)).unwrap();
        let again = write_gbsd(&part.unit, &GbsdOptions::default()).unwrap();
        let lower = Selection::of_loa(level / 2);
        let twice = judges.check(&what, &again, &part.bytes, &lower);
        assert_eq!(twice, judges.check(&what, &own, &stream, &lower));
    }
    judges.finish();
}

#[test]
fn a_stored_stream_is_cut_by_its_description() {
    let stream: &[u8] = include_bytes!("../../../articula-stream/tests/golden/walk.abp");
    let map = read_index(include_bytes!(
        "../../../articula-stream/tests/golden/walk.auix"
    ))
    .unwrap();
    let text = write_gbsd(&map, &GbsdOptions::default()).unwrap();
    let mut judges = Judges::new("stored");
    for selection in [
        Selection::of_loa(1),
        Selection {
            tier: Some(2),
            ..Selection::default()
        },
        Selection {
            tier: Some(1),
            body_regions: Some(0b11_0110),
            ..Selection::of_loa(2)
        },
        Selection {
            joints: Some(vec![3, 14, 15]),
            ..Selection::default()
        },
        Selection {
            joints: Some(vec![]),
            ..Selection::default()
        },
    ] {
        judges.check(&format!("{selection:?}"), &text, stream, &selection);
    }
    judges.finish();
}

#[test]
fn what_cannot_be_transformed_says_why() {
    let text = annex_b::description("g:");
    let conformant = |text: &str| refused(text, &Selection::of_loa(1), AdaptMode::Conformant);
    let said = refused(&text, &Selection::of_loa(6), AdaptMode::Conformant);
    assert!(said.contains("level out of range"), "{said}");
    let without = text.replacen(" marker=\"L:2\"", "", 1);
    let said = conformant(&without);
    assert!(
        said.starts_with("line 15: gBSDUnit 10 \":MG4:BoneMask\": expected a marker"),
        "{said}"
    );
    let malformed = conformant(&text.replacen("L:2", "L:two", 1));
    assert!(malformed.contains("marker L:two"), "{malformed}");
    let other = conformant(&text.replacen("L:2", "L:1", 1));
    assert!(other.contains("11 masks and 10 values"), "{other}");
    let none = conformant(&text.replace("DIA-gBSD-NS", "other"));
    assert!(none.contains("no gBSDUnit"), "{none}");
    let consecutive = text
        .replace("Absolute", "Consecutive")
        .replace("start=", "was=");
    let said = conformant(&consecutive);
    assert!(
        said.contains("write the description with addresses"),
        "{said}"
    );
    if xsltproc_is_here() {
        let judges = Judges::new("refusals");
        let refuses = |text: &str, level| {
            let parameters = Selection::of_loa(level).parameters();
            judges.xslt("sheet.xslt", &[text], &parameters).is_err()
        };
        for text in [
            &without,
            &text.replacen("L:2", "L:1", 1),
            &text.replace("DIA-gBSD-NS", "other"),
            &consecutive,
        ] {
            assert!(refuses(text, 1));
        }
        assert!(refuses(&text, 6));
    }
}
