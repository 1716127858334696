//! Samples an animated SVG written by [`super::smil`] or [`super::flipbook`] at a time, as a still
//! SVG.
//!
//! Source: SMIL 3.0 (simple animation: `values`, `keyTimes`, `calcMode` linear and discrete) and
//! SVG 2, as far as the writers of this crate use them; `docs/methods/vector.md` 11. Everything is
//! read from the file's text, so writer and reader check each other. Anything outside of that
//! subset is refused by name.
//!
//! XML is read by the parser that comes with resvg; document types, and so entities, are refused.

use super::path::push_color;
use crate::error::PictureError;
use crate::markup::push_escaped;
use resvg::usvg::roxmltree::{Document, Node, ParsingOptions};
use std::fmt::Write as _;

/// Maximum length of a text, bytes.
const MAX_BYTES: usize = 1 << 28;
/// Maximum number of elements, texts and comments.
const MAX_NODES: u32 = 4_000_000;
/// Maximum nesting of elements.
const MAX_DEPTH: usize = 32;

/// An animated SVG, parsed once and sampled at any time.
#[derive(Debug, Clone, PartialEq)]
pub struct AnimatedSvg {
    parts: Vec<Part>,
    /// Length of the longest animation before it repeats, seconds; 0 without animation.
    pub duration_secs: f64,
}

/// A part of the still SVG, in document order.
#[derive(Debug, Clone, PartialEq)]
enum Part {
    Open(Element),
    Text(String),
    Close(&'static str),
}

#[derive(Debug, Clone, PartialEq)]
struct Element {
    tag: &'static str,
    attributes: Vec<(&'static str, String)>,
    animations: Vec<Animation>,
}

#[derive(Debug, Clone, PartialEq)]
struct Animation {
    attribute: &'static str,
    /// Type of a transform; `None` for other attributes.
    transform: Option<&'static str>,
    /// Whether it is applied before those of the animations that precede it, instead of in their place.
    is_added: bool,
    duration_secs: f64,
    is_discrete: bool,
    /// Key times, 0 to 1.
    times: Vec<f64>,
    values: Values,
}

#[derive(Debug, Clone, PartialEq)]
enum Values {
    /// One word per key.
    Words(Vec<String>),
    /// A colour per key, sRGB levels.
    Colors(Vec<[f64; 3]>),
    /// Texts that differ only in their numbers: the text between them, and a row of numbers for
    /// each key.
    Rows { pattern: Vec<u8>, rows: Vec<f64> },
}

/// Placeholder of a number in a pattern.
const NUMBER: u8 = b'#';

const TAGS: [&str; 8] = [
    "svg",
    "title",
    "g",
    "path",
    "linearGradient",
    "stop",
    "animate",
    "animateTransform",
];

const ATTRIBUTES: [&str; 17] = [
    "width",
    "height",
    "viewBox",
    "id",
    "href",
    "gradientUnits",
    "x1",
    "y1",
    "x2",
    "y2",
    "offset",
    "stop-color",
    "fill",
    "d",
    "display",
    "shape-rendering",
    "transform",
];

/// Types of animated transforms.
const TRANSFORMS: [&str; 4] = ["translate", "rotate", "skewX", "scale"];

impl AnimatedSvg {
    /// Parses the text of an animated SVG.
    ///
    /// # Errors
    /// [`PictureError::Malformed`] for text that violates XML, SVG or SMIL,
    /// [`PictureError::Unsupported`] for anything that the writers of this crate do not write, or
    /// too much of it.
    pub fn read(text: &str) -> Result<Self, PictureError> {
        if text.len() > MAX_BYTES {
            return Err(unsupported(format!(
                "an SVG of more than {MAX_BYTES} bytes"
            )));
        }
        let options = ParsingOptions {
            allow_dtd: false,
            nodes_limit: MAX_NODES,
            ..ParsingOptions::default()
        };
        let document = Document::parse_with_options(text, options)
            .map_err(|e| malformed("XML", e.to_string()))?;
        let mut svg = Self {
            parts: Vec::new(),
            duration_secs: 0.0,
        };
        if document.root_element().tag_name().name() != "svg" {
            return Err(malformed("SVG", "the root element is not <svg>".into()));
        }
        // An explicit stack instead of recursion, for deep nesting.
        let mut open = Vec::new();
        let mut next = Some(document.root_element());
        while let Some(node) = next {
            let opened = svg.enter(node, open.len())?;
            if let (Some(tag), Some(child)) = (opened, node.first_child()) {
                open.push((node, tag));
                next = Some(child);
                continue;
            }
            if let Some(tag) = opened {
                svg.parts.push(Part::Close(tag));
            }
            next = node.next_sibling();
            while next.is_none() {
                let Some((parent, tag)) = open.pop() else {
                    break;
                };
                svg.parts.push(Part::Close(tag));
                if !open.is_empty() {
                    next = parent.next_sibling();
                }
            }
        }
        Ok(svg)
    }

    /// Returns the state at a time as a still SVG. Animations repeat forever, so their end shows
    /// their beginning.
    ///
    /// O(size of the file).
    ///
    /// # Errors
    /// [`PictureError::Mismatch`] for a time that is negative or not finite.
    pub fn at(&self, secs: f64) -> Result<String, PictureError> {
        if !secs.is_finite() || secs < 0.0 {
            return Err(PictureError::Mismatch {
                at: "secs",
                what: format!("{secs} s, expected 0 or more"),
            });
        }
        let mut out = String::new();
        for (p, part) in self.parts.iter().enumerate() {
            match part {
                Part::Open(element) => {
                    element.write(secs, &mut out);
                    let is_empty = matches!(self.parts.get(p + 1), Some(Part::Close(_)));
                    out.push_str(if is_empty { "/>" } else { ">" });
                }
                Part::Text(text) => push_escaped(&mut out, text),
                Part::Close(tag) => {
                    let is_empty = p > 0 && matches!(self.parts[p - 1], Part::Open(_));
                    if !is_empty {
                        // Writing into a String cannot fail.
                        let _ = write!(out, "</{tag}>");
                    }
                }
            }
        }
        Ok(out)
    }

    /// Reads one node; returns its tag if it is an element that stays open.
    fn enter(
        &mut self,
        node: Node<'_, '_>,
        depth: usize,
    ) -> Result<Option<&'static str>, PictureError> {
        if depth >= MAX_DEPTH {
            return Err(unsupported(format!("nesting deeper than {MAX_DEPTH}")));
        }
        if let (true, Some(text)) = (node.is_text(), node.text()) {
            let is_title = matches!(self.parts.last(), Some(Part::Open(e)) if e.tag == "title");
            if is_title {
                self.parts.push(Part::Text(text.to_owned()));
            } else if !text.trim().is_empty() {
                return Err(unsupported("text outside the title".to_owned()));
            }
            return Ok(None);
        }
        if !node.is_element() {
            return Ok(None);
        }
        let found = node.tag_name();
        let is_svg = found.namespace() == Some("http://www.w3.org/2000/svg");
        let known = TAGS.into_iter().find(|tag| is_svg && *tag == found.name());
        let Some(tag) = known else {
            return Err(unsupported(format!(
                "the element {}",
                shortened(found.name())
            )));
        };
        if tag.starts_with("animate") {
            // Already read with its parent.
            return Ok(None);
        }
        let attributes = node.attributes().map(|a| {
            let known = ATTRIBUTES.into_iter().find(|name| *name == a.name());
            match known {
                Some(name) if a.namespace().is_none() => Ok((name, a.value().to_owned())),
                _ => Err(unsupported(format!(
                    "the attribute {}",
                    shortened(a.name())
                ))),
            }
        });
        let animations = self.animations(node)?;
        self.parts.push(Part::Open(Element {
            tag,
            attributes: attributes.collect::<Result<_, _>>()?,
            animations,
        }));
        Ok(Some(tag))
    }
    fn animations(&mut self, node: Node<'_, '_>) -> Result<Vec<Animation>, PictureError> {
        let mut animations = Vec::new();
        let is_animate =
            |n: &Node<'_, '_>| n.is_element() && n.tag_name().name().starts_with("animate");
        for child in node.children().filter(is_animate) {
            let animation = Animation::read(child)?;
            self.duration_secs = self.duration_secs.max(animation.duration_secs);
            let is_first = !animations
                .iter()
                .any(|a: &Animation| a.attribute == animation.attribute);
            if is_first && animation.is_added {
                return Err(unsupported(
                    "additive \"sum\" of the first animation of a transform".to_owned(),
                ));
            }
            animations.push(animation);
        }
        Ok(animations)
    }
}

impl Element {
    /// The opening tag without its end.
    fn write(&self, secs: f64, out: &mut String) {
        out.push('<');
        out.push_str(self.tag);
        if self.tag == "svg" {
            out.push_str(r#" xmlns="http://www.w3.org/2000/svg""#);
        }
        let attribute = |out: &mut String, name: &str, value: &str| {
            let _ = write!(out, r#" {name}=""#);
            push_escaped(out, value);
            out.push('"');
        };
        let is_moved = |name: &str| self.animations.iter().any(|a| a.attribute == name);
        for (name, value) in self.attributes.iter().filter(|(name, _)| !is_moved(name)) {
            attribute(out, name, value);
        }
        for (a, animation) in self.animations.iter().enumerate() {
            // The last animation of an attribute wins, with what is added to it.
            let mut later = self.animations[a + 1..]
                .iter()
                .filter(|l| l.attribute == animation.attribute);
            if animation.is_added || later.clone().any(|l| !l.is_added) {
                continue;
            }
            let first = animation.at(secs);
            let value = later.by_ref().fold(first, |value, l| value + &l.at(secs));
            attribute(out, animation.attribute, &value);
        }
    }
}

impl Animation {
    fn read(node: Node<'_, '_>) -> Result<Self, PictureError> {
        let (mut name, mut dur, mut repeat, mut mode) = ("", "", "", "linear");
        let (mut values, mut times) = ("", None);
        let (mut kind, mut additive) = (None, "replace");
        let is_transform = node.tag_name().name() == "animateTransform";
        for attribute in node.attributes() {
            let value = attribute.value();
            match attribute.name() {
                "attributeName" => name = value,
                "dur" => dur = value,
                "repeatCount" => repeat = value,
                "calcMode" => mode = value,
                "values" => values = value,
                "keyTimes" => times = Some(value),
                "type" if is_transform => kind = TRANSFORMS.into_iter().find(|k| *k == value),
                "additive" if is_transform => additive = value,
                other => {
                    return Err(unsupported(format!(
                        "the attribute {} of <animate>",
                        shortened(other)
                    )));
                }
            }
        }
        let known: &[&'static str] = if is_transform {
            &["transform"]
        } else {
            &["d", "display", "fill", "x1", "y1", "x2", "y2"]
        };
        if is_transform && kind.is_none() {
            return Err(unsupported("a transform of another type".to_owned()));
        }
        let is_added = match additive {
            "sum" => true,
            "replace" => false,
            other => return Err(unsupported(format!("additive {:?}", shortened(other)))),
        };
        let Some(attribute) = known.iter().copied().find(|k| *k == name) else {
            return Err(unsupported(format!("animation of {:?}", shortened(name))));
        };
        if repeat != "indefinite" {
            return Err(unsupported(
                "an animation that does not repeat indefinitely".to_owned(),
            ));
        }
        let is_discrete = match mode {
            "discrete" if !is_transform => true,
            "linear" if attribute != "display" => false,
            _ => return Err(unsupported(format!("calcMode {mode:?} on {attribute}"))),
        };
        let duration = dur.strip_suffix('s').unwrap_or(dur);
        let duration_secs = number(duration).filter(|d| *d > 0.0);
        let duration_secs =
            duration_secs.ok_or_else(|| malformed("dur", format!("{:?}", shortened(dur))))?;
        let values = Values::read(values, attribute, is_discrete)?;
        let times = key_times(times, values.keys(), is_discrete)?;
        if matches!(kind, Some("rotate" | "skewX")) && values.width() != 1 {
            return Err(malformed("values", "more than an angle".to_owned()));
        }
        Ok(Self {
            attribute,
            transform: kind,
            is_added,
            duration_secs,
            is_discrete,
            times,
            values,
        })
    }

    /// Value of the attribute, or of its part.
    fn at(&self, secs: f64) -> String {
        let value = self.value(secs);
        match self.transform {
            Some(kind) => format!("{kind}({value})"),
            None => value,
        }
    }

    fn value(&self, secs: f64) -> String {
        let share = secs % self.duration_secs / self.duration_secs;
        // Of several keys at the same time the last one applies.
        let after = self.times.partition_point(|t| *t <= share);
        let key = after.saturating_sub(1);
        if self.is_discrete || after == self.times.len() {
            return self.values.between(key, key, 0.0);
        }
        let (from, to) = (self.times[key], self.times[after]);
        self.values
            .between(key, after, (share - from) / (to - from))
    }
}

/// Times of keys: ascending from 0, to 1 unless the values are discrete.
fn key_times(text: Option<&str>, keys: usize, is_discrete: bool) -> Result<Vec<f64>, PictureError> {
    let Some(text) = text else {
        let steps = if is_discrete { keys } else { keys - 1 };
        return Ok((0..keys).map(|k| k as f64 / steps.max(1) as f64).collect());
    };
    let refuse = |what: String| malformed("keyTimes", what);
    let mut times = Vec::new();
    for time in text.split(';') {
        let found = number(time.trim()).filter(|t| (0.0..=1.0).contains(t));
        times.push(found.ok_or_else(|| refuse(format!("{:?}", shortened(time))))?);
    }
    if times.len() != keys {
        return Err(refuse(format!(
            "{} key times for {keys} values",
            times.len()
        )));
    }
    let rises = times.windows(2).all(|pair| pair[0] <= pair[1]);
    let is_whole = is_discrete || times[keys - 1] == 1.0;
    if times[0] != 0.0 || !rises || !is_whole {
        return Err(refuse("the key times must rise from 0 to 1".to_owned()));
    }
    Ok(times)
}

impl Values {
    fn read(text: &str, attribute: &str, is_discrete: bool) -> Result<Self, PictureError> {
        if text.is_empty() {
            return Err(malformed("values", "none".to_owned()));
        }
        if is_discrete {
            return Ok(Self::Words(text.split(';').map(str::to_owned).collect()));
        }
        if attribute == "fill" {
            let read = |text: &str| {
                let refuse = || malformed("values", format!("{:?}", shortened(text)));
                color(text.trim()).ok_or_else(refuse)
            };
            return Ok(Self::Colors(
                text.split(';').map(read).collect::<Result<_, _>>()?,
            ));
        }
        let mut first: Option<Vec<u8>> = None;
        let mut rows = Vec::new();
        for value in text.split(';') {
            let pattern = if attribute == "d" {
                path_numbers(value, &mut rows)
            } else if attribute == "transform" {
                list_numbers(value, &mut rows)
            } else {
                number(value.trim()).map(|v| {
                    rows.push(v);
                    vec![NUMBER]
                })
            };
            let refuse = || malformed("values", format!("{:?}", shortened(value)));
            let pattern = pattern.ok_or_else(refuse)?;
            if first.get_or_insert_with(|| pattern.clone()) != &pattern {
                return Err(malformed(
                    "values",
                    "the animated paths have different commands".to_owned(),
                ));
            }
        }
        let pattern = first.unwrap_or_default();
        Ok(Self::Rows { pattern, rows })
    }

    /// Number of numbers in a value.
    fn width(&self) -> usize {
        match self {
            Self::Words(_) | Self::Colors(_) => 0,
            Self::Rows { pattern, .. } => width(pattern),
        }
    }

    fn keys(&self) -> usize {
        match self {
            Self::Words(words) => words.len(),
            Self::Colors(colors) => colors.len(),
            Self::Rows { pattern, rows } => rows.len() / width(pattern),
        }
    }

    /// Interpolates between two keys by the fraction `share`.
    fn between(&self, from: usize, to: usize, share: f64) -> String {
        let (pattern, rows) = match self {
            Self::Words(words) => return words[from].clone(),
            Self::Colors(colors) => {
                let level = |c: usize| {
                    let [a, b] = [from, to].map(|key| colors[key][c]);
                    (a + (b - a) * share).round() as u8
                };
                let mut text = String::new();
                push_color(&mut text, [level(0), level(1), level(2)]);
                return text;
            }
            Self::Rows { pattern, rows } => (pattern, rows),
        };
        let width = width(pattern);
        let row = |key: usize| &rows[key * width..(key + 1) * width];
        let mut numbers = row(from)
            .iter()
            .zip(row(to))
            .map(|(a, b)| a + (b - a) * share);
        let mut out = String::new();
        for part in pattern {
            if *part != NUMBER {
                out.push(char::from(*part));
                continue;
            }
            // A ten-thousandth of a grid step is far below what is visible.
            let value = numbers.next().unwrap_or_default();
            let text = ((value * 1e4).round() / 1e4).to_string();
            if out.ends_with(|c: char| c.is_ascii_digit()) && !text.starts_with('-') {
                out.push(' ');
            }
            out.push_str(&text);
        }
        out
    }
}

/// Levels of a colour in the form `#rgb` or `#rrggbb`.
fn color(text: &str) -> Option<[f64; 3]> {
    let digits = text.strip_prefix('#')?;
    if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let width = match digits.len() {
        3 => 1,
        6 => 2,
        _ => return None,
    };
    let level = |channel: usize| {
        let part = &digits[channel * width..(channel + 1) * width];
        let level = u8::from_str_radix(part, 16).ok()?;
        Some(f64::from(level) * if width == 1 { 17.0 } else { 1.0 })
    };
    Some([level(0)?, level(1)?, level(2)?])
}

/// Numbers per row.
fn width(pattern: &[u8]) -> usize {
    pattern.iter().filter(|p| **p == NUMBER).count().max(1)
}

/// Splits relative path data into commands and numbers; `None` for other path data.
fn path_numbers(text: &str, numbers: &mut Vec<f64>) -> Option<Vec<u8>> {
    let bytes = text.as_bytes();
    let mut pattern = Vec::new();
    let mut pending = 0;
    let mut at = 0;
    while at < bytes.len() {
        match bytes[at] {
            b' ' | b',' | b'\n' | b'\t' | b'\r' => at += 1,
            command @ (b'm' | b'l' | b'z') => {
                // A path begins with a move, and a command takes all its numbers.
                let begins = !pattern.is_empty() || command == b'm';
                if pending % 2 != 0 || !begins || needs_numbers(&pattern) {
                    return None;
                }
                pattern.push(command);
                pending = 0;
                at += 1;
            }
            _ => {
                let end = number_end(bytes, at);
                numbers.push(number(text.get(at..end)?)?);
                let is_after_line = !matches!(pattern.last(), None | Some(b'z'));
                if !is_after_line {
                    return None;
                }
                pattern.push(NUMBER);
                pending += 1;
                at = end;
            }
        }
    }
    let is_whole = pending % 2 == 0 && !pattern.is_empty() && !needs_numbers(&pattern);
    is_whole.then_some(pattern)
}

/// Splits a list of one or two numbers; `None` for other texts.
fn list_numbers(text: &str, numbers: &mut Vec<f64>) -> Option<Vec<u8>> {
    let bytes = text.as_bytes();
    let (mut pattern, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        if bytes[at] == b' ' {
            at += 1;
            continue;
        }
        let end = number_end(bytes, at);
        numbers.push(number(text.get(at..end)?)?);
        pattern.push(NUMBER);
        at = end;
    }
    (1..=2).contains(&pattern.len()).then_some(pattern)
}

fn needs_numbers(pattern: &[u8]) -> bool {
    matches!(pattern.last(), Some(b'm' | b'l'))
}

/// End of the number that begins at `at`; at least one byte later.
fn number_end(bytes: &[u8], at: usize) -> usize {
    let mut end = at + 1;
    let mut has_point = bytes[at] == b'.';
    while let Some(byte) = bytes.get(end) {
        match byte {
            b'0'..=b'9' => {}
            b'.' if !has_point => has_point = true,
            _ => break,
        }
        end += 1;
    }
    end
}

/// A plain decimal number.
fn number(text: &str) -> Option<f64> {
    let is_plain = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
    if text.is_empty() || !text.chars().all(is_plain) {
        return None;
    }
    text.parse().ok().filter(|v: &f64| v.is_finite())
}

fn malformed(at: &'static str, what: String) -> PictureError {
    PictureError::Malformed { at, what }
}

fn unsupported(what: String) -> PictureError {
    let mend = "choose a file that flatten wrote with the profile smil or flipbook".to_owned();
    PictureError::Unsupported { what, mend }
}

/// Beginning of a text from a file, for messages.
fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}

#[cfg(test)]
mod tests;
