//! The transformation of a description as an XSLT 1.0 stylesheet, for other programs.

use std::fmt::Write;

const TEMPLATE: &str = include_str!("adapt.xslt");

/// The stylesheet that transforms a description as [`super::adapt_gbsd`] does, for any XSLT 1.0
/// processor; [`super::Selection::parameters`] are its parameters.
///
/// Addresses must be absolute and in bits, and names in the case of the standard. It stops with a
/// message where no unit is of the namespace of gBSD or of none, a level does not exist or a bone
/// has none.
pub fn stylesheet() -> String {
    let element = |name: &str| format!("*[local-name()='{name}'][{}]", namespaces());
    TEMPLATE
        .replace("{{BODY}}", &bits("regionMask", 1))
        .replace("{{FACE}}", &bits("faceRegionMask", 0))
        .replace("{{UNIT}}", &element("gBSDUnit"))
        .replace("{{PARAMETER}}", &element("Parameter"))
        .replace(
            "{{VALUE}}",
            "*[local-name()='Parameter']/*[local-name()='Value']",
        )
        .replace("{{KEEP}}", &keep())
}

/// Whether the namespace is that of gBSD, in any case, or none.
fn namespaces() -> String {
    let (upper, lower) = ("ABCDEFGHIJKLMNOPQRSTUVWXYZ", "abcdefghijklmnopqrstuvwxyz");
    let known = "||urn:mpeg:mpeg21:2003:01-dia-gbsd-ns|urn:mpeg:mpeg21:dia:schema:gbsd:2003|";
    format!(
        "contains('{known}', concat('|', translate(namespace-uri(), '{upper}', '{lower}'), '|'))"
    )
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

/// Whether a unit stays by its markers, as [`super::Selection::keeps`].
fn keep() -> String {
    let markers = "concat(' ', normalize-space(@marker), ' ')";
    let has = |token: &str| format!("contains({markers}, ' {token}:')");
    let text =
        |token: &str| format!("substring-before(substring-after({markers}, ' {token}:'), ' ')");
    let number = |token: &str| format!("number({})", text(token));
    let listed =
        |token: &str, list: &str| format!("contains({list}, concat(' ', {}, ' '))", text(token));
    let list = |name: &str| format!("concat(' ', normalize-space({name}), ' ')");
    // Of a parameter, level and region are those of the face.
    let levels = |loa: &str, region: &str| {
        format!(
            "{} &lt;= number(substring($faceLevels, {} + 1, 1))",
            number(loa),
            number(region)
        )
    };
    let clauses = [
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
        format!(
            "$meshLevelOut = '' or not({}) or {} &gt;= $meshLevelOut",
            has("M"),
            number("M")
        ),
        format!(
            "$meshLevels = '' or not({has_m} and {has_r}) or not(contains({pairs}, {region})) or {level} &gt;= number(substring-before(substring-after({pairs}, {region}), ' '))",
            has_m = has("M"),
            has_r = has("R"),
            pairs = list("$meshLevels"),
            region = format_args!("concat(' ', {}, ':')", text("R")),
            level = number("M")
        ),
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
    ];
    let all: Vec<String> = clauses.iter().map(|clause| format!("({clause})")).collect();
    format!("not(@marker) or {}", all.join(" and "))
}
