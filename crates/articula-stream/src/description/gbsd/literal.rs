//! The transformation that the stylesheet printed in annex B of the thesis makes, with its faults.

use super::edits::{Edit, apply, close_of};
use super::selection::Selection;
use crate::description::xml::{Document, Namespace, escape};
use crate::error::StreamError;
use crate::limits::DescriptionLimits;

/// Number of bones of each level, as printed.
const BONES: [&str; 4] = ["5", "10", "24", "35"];

/// Level of all, the default of the stylesheet.
const LEVEL: u32 = 3;

pub(super) fn adapt(
    bytes: &[u8],
    selection: &Selection,
    limits: &DescriptionLimits,
) -> Result<String, StreamError> {
    let document = Document::parse(bytes, limits)?;
    let most = f64::from(selection.body_loa.unwrap_or(LEVEL));
    let bones = BONES.get(most as usize).copied().unwrap_or_default();
    let mut edits: Vec<Edit> = Vec::new();
    let mut has_segment = false;
    for number in 0..document.elements.len() {
        let element = &document.elements[number];
        if element.namespace != Namespace::Absent {
            continue;
        }
        let label = document
            .value(number, "syntacticalLabel")
            .unwrap_or_default();
        let name = document.value(number, "name").unwrap_or_default();
        match (element.name, label, name) {
            ("gBSDUnit", ":MG4:BoneSegment", _) => {
                has_segment = true;
                segment(&document, number, most, &mut edits);
            }
            ("gBSDUnit", ":MG4:BoneMask" | ":MG4:BoneValue", _)
                if !stays(&document, number, most) =>
            {
                edits.push((element.span.clone(), String::new()));
            }
            ("Parameter", _, ":MG4:NoOfBones") => {
                if let Some(value) = document.child(number, "Value") {
                    let value = &document.elements[value];
                    let close = close_of(document.source, &value.span);
                    edits.push((value.tag.end..close, bones.to_owned()));
                }
            }
            ("Parameter", _, ":MG4:Padding") => edits.push((element.span.clone(), String::new())),
            _ => {}
        }
    }
    if !has_segment {
        let what = "no BoneSegment without a namespace, which is all that the printed stylesheet \
                    changes; use the conformant mode";
        return Err(document.bad(0, what));
    }
    Ok(apply(document.source, edits))
}

/// Whether the marker, after its first `L:`, is a number up to the level.
fn stays(document: &Document<'_>, number: usize, most: f64) -> bool {
    let marker = document.value(number, "marker").unwrap_or_default();
    let after = marker.split_once("L:").map_or("", |(_, after)| after);
    xpath_number(after) <= most
}

fn segment(document: &Document<'_>, number: usize, most: f64, edits: &mut Vec<Edit>) {
    let element = &document.elements[number];
    let mut sum = 0.0;
    for inner in number + 1..element.end {
        let is_plain = document.elements[inner].namespace == Namespace::Absent;
        let label = document
            .value(inner, "syntacticalLabel")
            .unwrap_or_default();
        let is_bone = matches!(label, ":MG4:BoneMask" | ":MG4:BoneValue");
        if is_plain
            && document.elements[inner].name == "gBSDUnit"
            && is_bone
            && stays(document, inner, most)
        {
            sum += xpath_number(document.value(inner, "length").unwrap_or_default());
        }
    }
    let padding = 8.0 - sum % 8.0;
    if let Some(length) = document.attribute(number, Namespace::Absent, "length") {
        edits.push((
            length.place.clone(),
            format!("{}", (sum / 8.0).ceil() * 8.0),
        ));
    }
    if !(padding > 0.0 && padding < 8.0) {
        return;
    }
    let named = document
        .children(number)
        .find_map(|child| document.value(child, "name"));
    let old = document.children(number).find(|child| {
        let element = &document.elements[*child];
        element.namespace == Namespace::Absent
            && element.name == "Parameter"
            && document.value(*child, "name") == Some(":MG4:Padding")
    });
    let start = old.and_then(|old| document.value(old, "start"));
    let text = format!(
        "<Parameter xmlns=\"urn:mpeg:mpeg21:2003:01-DIA-gBSD-NS\" name=\"{}\" start=\"{}\" \
         length=\"{padding}\"><Value xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
         xsi:type=\"b{padding}\">{padding}</Value></Parameter>",
        escape(named.unwrap_or_default()),
        escape(start.unwrap_or_default())
    );
    let close = close_of(document.source, &element.span);
    edits.push((close..close, text));
}

/// A number as XPath reads one: digits and a point, perhaps after a minus sign; else none.
fn xpath_number(text: &str) -> f64 {
    let text = text.trim_matches([' ', '\t', '\r', '\n']);
    let digits = text.strip_prefix('-').unwrap_or(text);
    let is_plain = digits
        .bytes()
        .all(|byte| byte.is_ascii_digit() || byte == b'.')
        && digits.bytes().any(|byte| byte.is_ascii_digit());
    let number = is_plain.then(|| text.parse().ok()).flatten();
    number.unwrap_or(f64::NAN)
}
