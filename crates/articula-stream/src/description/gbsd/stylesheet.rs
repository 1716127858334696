//! The transformation of a description as an XSLT 1.0 stylesheet, for other programs.

use std::fmt::Write;

const TEMPLATE: &str = include_str!("adapt.xslt");

/// The stylesheet that transforms a description as [`super::adapt_gbsd`] does, for any XSLT 1.0
/// processor; [`super::Selection::parameters`] are its parameters.
///
/// Addresses must be absolute and in bits, and names and namespaces in the case of the standard. It
/// stops with a message where no unit is of the namespace of gBSD or of none, a level does not exist
/// or a bone has none.
pub fn stylesheet() -> String {
    TEMPLATE
        .replace("{{BODY}}", &bits("regionMask", 1))
        .replace("{{FACE}}", &bits("faceRegionMask", 0))
        .replace(
            "{{UNITS}}",
            &named(|prefix| format!("{prefix}gBSDUnit"), " | "),
        )
        .replace(
            "{{PARAMETERS}}",
            &named(|prefix| format!("{prefix}Parameter"), " | "),
        )
        .replace(
            "{{VALUES}}",
            &named(|prefix| format!("{prefix}Parameter/{prefix}Value"), " | "),
        )
        .replace("{{UNIT}}", &step("gBSDUnit"))
        .replace("{{PARAMETER}}", &step("Parameter"))
        .replace("{{KEEP}}", &keep())
}

/// A name with the prefix of each namespace of gBSD, and without one. Processors find templates by
/// whole names at once.
fn named(name: impl Fn(&str) -> String, between: &str) -> String {
    ["", "g:", "cd:"].map(name).join(between)
}

/// A step of a path to elements of a name.
fn step(name: &str) -> String {
    let is_it = named(|prefix| format!("self::{prefix}{name}"), " or ");
    format!("*[{is_it}]")
}

/// The numbers of the bits of a mask, from `first` on.
fn bits(mask: &str, first: u32) -> String {
    (0..8).fold(String::new(), |mut out, bit| {
        let power = 1 << bit;
        // Writing to a text cannot fail.
        let _ = writeln!(
            out,
            "  <xsl:if test=\"floor(${mask} div {power}) mod 2 = 1\">{}<xsl:text> </xsl:text></xsl:if>",
            bit + first
        );
        out
    })
}

/// All tokens of a unit, each between spaces.
const MARKERS: &str = "concat(' ', normalize-space(@marker), ' ')";

/// Whether a unit has a token.
fn has(token: &str) -> String {
    format!("contains({MARKERS}, ' {token}:')")
}

/// The text of a token's value.
fn text(token: &str) -> String {
    format!("substring-before(substring-after({MARKERS}, ' {token}:'), ' ')")
}

fn number(token: &str) -> String {
    format!("number({})", text(token))
}

/// A list of words, each between spaces.
fn list(name: &str) -> String {
    format!("concat(' ', normalize-space({name}), ' ')")
}

/// Whether a list has the value of a token.
fn listed(token: &str, list: &str) -> String {
    format!("contains({list}, concat(' ', {}, ' '))", text(token))
}

/// Whether a unit stays by its markers, as [`super::Selection::keeps`].
fn keep() -> String {
    let clauses = body().into_iter().chain(mesh()).chain(face());
    let all: Vec<String> = clauses.map(|clause| format!("({clause})")).collect();
    format!("not(@marker) or {}", all.join(" and "))
}

/// Of a parameter, level and region are those of the face, and the region of a mesh has another
/// numbering.
fn body() -> [String; 4] {
    [
        format!(
            "$nLayersOut = '' or not({}) or {} or {} &lt;= $nLayersOut",
            has("L"),
            has("P"),
            number("L")
        ),
        format!(
            "$regionMask = '' or not({}) or {} or {} or {}",
            has("R"),
            has("P"),
            has("M"),
            listed("R", "$regions")
        ),
        format!(
            "$joints = '' or not({}) or {}",
            has("J"),
            listed("J", &list("$joints"))
        ),
        format!(
            "$tierOut = '' or not({}) or {} &gt;= $tierOut",
            has("T"),
            number("T")
        ),
    ]
}

fn mesh() -> [String; 2] {
    let pairs = list("$meshLevels");
    let region = format!("concat(' ', {}, ':')", text("R"));
    [
        format!(
            "$meshLevelOut = '' or not({}) or {} &gt;= $meshLevelOut",
            has("M"),
            number("M")
        ),
        format!(
            "$meshLevels = '' or not({} and {}) or not(contains({pairs}, {region})) \
             or {} &gt;= number(substring-before(substring-after({pairs}, {region}), ' '))",
            has("M"),
            has("R"),
            number("M")
        ),
    ]
}

fn face() -> [String; 5] {
    let levels = |loa: &str, region: &str| {
        format!(
            "{} &lt;= number(substring($faceLevels, {} + 1, 1))",
            number(loa),
            number(region)
        )
    };
    [
        format!(
            "$fapsOut = '' or not({}) or {}",
            has("P"),
            listed("P", &list("$fapsOut"))
        ),
        format!(
            "$faceRegionMask = '' or not({}) or not({}) or {}",
            has("P"),
            has("R"),
            listed("R", "$faceRegions")
        ),
        format!(
            "$faceRegionMask = '' or {} or not({}) or {}",
            has("P"),
            has("FR"),
            listed("FR", "$faceRegions")
        ),
        format!(
            "$faceLevels = '' or not({} and {} and {}) or {}",
            has("P"),
            has("L"),
            has("R"),
            levels("L", "R")
        ),
        format!(
            "$faceLevels = '' or {} or not({} and {}) or {}",
            has("P"),
            has("FL"),
            has("FR"),
            levels("FL", "FR")
        ),
    ]
}
