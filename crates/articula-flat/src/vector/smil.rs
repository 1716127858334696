//! Writes a [`KeyedClip`] as one animated SVG file without script.
//!
//! Source: `docs/methods/vector.md` 8.1 (SVG 1.1 and SVG 2 with SMIL 3.0 animation). A shape is one
//! `path` with an animated `d`; a gradient references a shared ramp and has its own line. Rules for
//! compatibility with renderers: `fill` is never animated between gradients, switching is always
//! `calcMode="discrete"`, linear key times run from 0 to 1.
//!
//! Bytes are saved where that changes no pixel: a closed outline needs no `z` to be filled, lines
//! after `m` need no `l`, an outline begins at the corner that gives the shortest text, and a
//! moving shape is hidden by jumping to an outline without area (two keys at one time) where that
//! is shorter than switching `display`.
//!
//! Renderers without animation show the first frame: attributes hold its state, and shapes that are
//! hidden then have no outline in it.

use super::path::{fixed, push_color, push_id, push_outlines};
use super::smil_motion::{fixed_numbers, transforms};
use super::svg_text::{Clock, push_title};
use crate::planar::PlanarError;
use crate::planar::keyed_clip::{
    BOX, GRID, KeyedClip, KeyedPaint, KeyedShape, KeyedTrack, LineUnits,
};
use crate::planar::keyed_motion::KeyedMotion;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::Range;

/// Maximum number of points of an outline for which every start is tried.
const MAX_TURNED_POINTS: usize = 16;

/// Returns the SVG text of a clip; `name` becomes its title (none if it is empty).
///
/// O(keys).
///
/// # Errors
/// [`PlanarError::Mismatch`] if the clip is invalid.
pub(crate) fn smil(clip: &KeyedClip, name: &str) -> Result<String, PlanarError> {
    clip.check()?;
    let mut writer = SvgWriter::new(clip, name);
    let same = |a: &KeyedShape, b: &KeyedShape| a.motion == b.motion;
    for run in clip.shapes.chunk_by(same) {
        let motion = run[0].motion.map(|m| &clip.motions[m as usize]);
        if let Some(motion) = motion {
            writer.begin_motion(motion);
        }
        for shape in run {
            writer.shape(shape);
        }
        if motion.is_some() {
            writer.end_group();
        }
    }
    Ok(writer.finish())
}

/// Writes an SVG file, shape by shape.
pub(super) struct SvgWriter<'a> {
    /// The file so far, without the gradients of shapes.
    out: String,
    /// Length of the text before the gradients of shapes.
    head: usize,
    /// Gradients of shapes, those that move last, each kind by its colours: equal things near each other are packed best.
    gradients: BTreeMap<(bool, Colors, u32), String>,
    clock: Clock,
    /// Gradients already written, by ramp and line, or stops and line.
    known: BTreeMap<GradientKey<'a>, u32>,
    next_id: u32,
    lines: LineUnits,
}

/// Key of equal gradients; a shape that is hidden at first omits the first state of its gradient,
/// so that one is not shared.
type GradientKey<'a> = (Colors, &'a KeyedTrack, bool);

/// Source of a gradient's colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Colors {
    Ramp(u32),
    Own([[u8; 3]; 2]),
}

impl<'a> SvgWriter<'a> {
    /// Begins a file with the clip's size, title and ramps.
    pub(super) fn new(clip: &KeyedClip, name: &str) -> Self {
        let (width, height) = (i64::from(clip.width), i64::from(clip.height));
        let grid = i64::from(GRID);
        let mut out = String::new();
        // Writing into a String cannot fail.
        let _ = write!(
            out,
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {} {}">"#,
            width * grid,
            height * grid
        );
        push_title(&mut out, name);
        let units = units_of(clip.lines);
        for (ramp, color) in (0..).zip(&clip.ramps) {
            let id = id_of(ramp);
            let _ = write!(
                out,
                r#"<linearGradient id="{id}"{units}><stop/><stop offset="1" stop-color=""#
            );
            push_color(&mut out, *color);
            out.push_str(r#""/></linearGradient>"#);
        }
        Self {
            head: out.len(),
            out,
            gradients: BTreeMap::new(),
            clock: Clock::new(clip.frames, clip.fps),
            known: BTreeMap::new(),
            lines: clip.lines,
            next_id: clip.ramps.len() as u32,
        }
    }

    /// Ends the file.
    pub(super) fn finish(mut self) -> String {
        let gradients = self.gradients.into_values().collect::<String>();
        self.out.insert_str(self.head, &gradients);
        self.out + "</svg>"
    }

    /// Begins a group with attributes, shown in spans of half frames only.
    pub(super) fn begin_group(&mut self, attributes: &str, shown: &[Range<u32>]) {
        let display = self.display(shown);
        let _ = write!(self.out, "<g{attributes}>{display}");
    }

    /// Begins a group that follows a motion.
    fn begin_motion(&mut self, motion: &KeyedMotion) {
        let parts = transforms(motion);
        self.out.push_str(r#"<g transform=""#);
        for (kind, track, unit) in &parts {
            let first = fixed_numbers(track.key(0), *unit);
            let _ = write!(self.out, "{kind}({first})");
        }
        self.out.push_str(r#"">"#);
        for (i, (kind, track, unit)) in parts.iter().enumerate() {
            let key = |k: usize| (2 * track.frames[k], fixed_numbers(track.key(k), *unit));
            let mut keys: Vec<(u32, String)> = (0..track.len()).map(key).collect();
            if track.is_still() {
                keys.push((self.clock.end(), keys[0].1.clone()));
            }
            // The first replaces the attribute, the others are applied before it.
            let sum = if i > 0 { r#" additive="sum""# } else { "" };
            let begin = format!(
                r#"<animateTransform attributeName="transform" type="{kind}"{sum}{}"#,
                self.timing()
            );
            self.out += &self.values(begin, &keys);
        }
    }

    /// Ends a group.
    pub(super) fn end_group(&mut self) {
        self.out.push_str("</g>");
    }

    /// Writes one shape, over those before it.
    pub(super) fn shape(&mut self, shape: &'a KeyedShape) {
        let Some(first) = shape.shown.first() else {
            return;
        };
        let is_shown_first = first.start == 0;
        self.open_path(&shape.paint, is_shown_first);
        let outline = turned(shape);
        let (first, mut animates) = self.outline(shape, &outline, is_shown_first);
        self.out.push_str(&first);
        if let KeyedPaint::Changing(color) = &shape.paint {
            animates += &self.color(color);
        }
        if animates.is_empty() {
            self.out.push_str("/>");
        } else {
            let _ = write!(self.out, ">{animates}</path>");
        }
    }

    /// Writes the first state of a shape, regardless of when it is shown.
    pub(super) fn still_shape(&mut self, shape: &'a KeyedShape) {
        self.open_path(&shape.paint, true);
        let path = path_of(turned(shape).key(0), &shape.further_outlines);
        let _ = write!(self.out, r#" d="{path}"/>"#);
    }

    fn open_path(&mut self, paint: &'a KeyedPaint, is_shown_first: bool) {
        let gradient = self.gradient(paint, is_shown_first);
        self.out.push_str("<path");
        match (paint, gradient) {
            // Black is the default fill.
            (KeyedPaint::Flat([0, 0, 0]), _) => {}
            (KeyedPaint::Flat(color), _) => {
                let _ = write!(self.out, r#" fill="{}""#, color_text(*color));
            }
            (KeyedPaint::Changing(_), _) if !is_shown_first => {}
            (KeyedPaint::Changing(color), _) => {
                let first = color_text(levels_of(color.key(0)));
                let _ = write!(self.out, r#" fill="{first}""#);
            }
            (_, id) => {
                let _ = write!(self.out, r##" fill="url(#{})""##, id_of(id.unwrap_or(0)));
            }
        }
    }

    /// Writes the first outline as attributes, and the animations of outline and display.
    fn outline(
        &self,
        shape: &KeyedShape,
        outline: &KeyedTrack,
        is_shown_first: bool,
    ) -> (String, String) {
        let starts = &shape.further_outlines;
        let path = |values: &[i32]| path_of(values, starts);
        let is_always =
            shape.shown.len() == 1 && is_shown_first && { shape.shown[0].end > self.clock.end() };
        let at_first = || format!(r#" d="{}""#, path(&rounded(outline, 0)));
        if outline.is_still() {
            let mut first = at_first();
            if !is_shown_first {
                first.push_str(r#" display="none""#);
            }
            let switch = if is_always {
                String::new()
            } else {
                self.display(&shape.shown)
            };
            return (first, switch);
        }
        let first = if is_shown_first {
            at_first()
        } else {
            String::new()
        };
        let keys = outline.frames.iter().enumerate();
        let plain: Vec<(u32, String)> = keys.map(|(k, f)| (2 * f, path(outline.key(k)))).collect();
        let moving = self.animate("d", &plain);
        if is_always {
            return (first, moving);
        }
        let switched = moving + &self.display(&shape.shown);
        let jumping = self.animate("d", &self.jumps(shape, outline));
        if jumping.len() <= switched.len() {
            (first, jumping)
        } else {
            (first, switched)
        }
    }

    /// Keys of an outline that has no area while it is hidden.
    fn jumps(&self, shape: &KeyedShape, outline: &KeyedTrack) -> Vec<(u32, String)> {
        let starts = &shape.further_outlines;
        let hidden = path_of(&vec![0; outline.width], starts);
        let value = |half: u32| path_of(&rounded(outline, half), starts);
        let end = self.clock.end();
        let mut keys = Vec::new();
        let begins_hidden = shape.shown.first().is_some_and(|s| s.start > 0);
        if begins_hidden {
            keys.push((0, hidden.clone()));
        }
        for span in &shape.shown {
            if span.start > 0 {
                keys.push((span.start, hidden.clone()));
            }
            keys.push((span.start, value(span.start)));
            let inside = outline.frames.iter().map(|f| 2 * f);
            let inside = inside.filter(|half| *half > span.start && *half < span.end);
            keys.extend(inside.map(|half| (half, value(half))));
            if span.end <= end {
                keys.push((span.end, value(span.end)));
                keys.push((span.end, hidden.clone()));
            }
        }
        if keys.last().is_some_and(|(half, _)| *half < end) {
            keys.push((end, hidden));
        }
        keys
    }

    /// One linear animation.
    fn animate(&self, attribute: &str, keys: &[(u32, String)]) -> String {
        self.values(self.begin(attribute), keys)
    }

    /// Adds the keys to the beginning of a linear animation, and ends it.
    fn values(&self, begin: String, keys: &[(u32, String)]) -> String {
        let mut out = begin;
        out.push_str(r#" values=""#);
        for (k, (_, value)) in keys.iter().enumerate() {
            out.push_str(if k > 0 { ";" } else { "" });
            out.push_str(value);
        }
        // Without key times the keys are evenly spaced.
        let steps = keys.len() as u64 - 1;
        let even = |(k, (half, _)): (usize, &(u32, String))| {
            u64::from(*half) * steps == k as u64 * u64::from(self.clock.end())
        };
        if !keys.iter().enumerate().all(even) {
            out.push_str(r#"" keyTimes=""#);
            for (k, (half, _)) in keys.iter().enumerate() {
                out.push_str(if k > 0 { ";" } else { "" });
                self.clock.push_time(&mut out, *half);
            }
        }
        out.push_str(r#""/>"#);
        out
    }

    fn begin(&self, attribute: &str) -> String {
        format!(r#"<animate attributeName="{attribute}"{}"#, self.timing())
    }

    fn timing(&self) -> String {
        format!(r#" dur="{}" repeatCount="indefinite""#, self.clock.dur())
    }

    /// Animation that shows something in spans of half frames only.
    fn display(&self, shown: &[Range<u32>]) -> String {
        let mut out = self.begin("display");
        out.push_str(r#" calcMode="discrete" values=""#);
        let mut times = String::from("0");
        if shown.first().is_some_and(|s| s.start > 0) {
            out.push_str("none;");
            times.push(';');
            self.clock.push_time(&mut times, shown[0].start);
        }
        for (i, span) in shown.iter().enumerate() {
            if i > 0 {
                out.push(';');
                times.push(';');
                self.clock.push_time(&mut times, span.start);
            }
            out.push_str("inline");
            if span.end <= self.clock.end() {
                out.push_str(";none");
                times.push(';');
                self.clock.push_time(&mut times, span.end);
            }
        }
        let _ = write!(out, r#"" keyTimes="{times}"/>"#);
        out
    }

    /// Writes a shape's gradient unless an equal one exists; returns its id.
    fn gradient(&mut self, paint: &'a KeyedPaint, is_shown_first: bool) -> Option<u32> {
        let (colors, line) = match paint {
            KeyedPaint::Flat(_) | KeyedPaint::Changing(_) => return None,
            KeyedPaint::Ramp { ramp, line } => (Colors::Ramp(*ramp), line),
            KeyedPaint::Own { stops, line } => (Colors::Own(*stops), line),
        };
        let key = (colors, line, is_shown_first);
        if let Some(id) = self.known.get(&key) {
            return Some(*id);
        }
        let id = self.next_id;
        self.next_id += 1;
        self.known.insert(key, id);
        let mut out = format!(r#"<linearGradient id="{}""#, id_of(id));
        let stops = match colors {
            Colors::Ramp(ramp) => {
                let _ = write!(out, r##" href="#{}""##, id_of(ramp));
                String::new()
            }
            Colors::Own([from, to]) => {
                out.push_str(units_of(self.lines));
                let mut stops = String::from(r#"<stop stop-color=""#);
                push_color(&mut stops, from);
                stops.push_str(r#""/><stop offset="1" stop-color=""#);
                push_color(&mut stops, to);
                stops.push_str(r#""/>"#);
                stops
            }
        };
        let (first, animates) = self.line(line, is_shown_first);
        out.push_str(&first);
        if stops.is_empty() && animates.is_empty() {
            out.push_str("/>");
        } else {
            let _ = write!(out, ">{stops}{animates}</linearGradient>");
        }
        let key = (!animates.is_empty(), colors, id);
        self.gradients.insert(key, out);
        Some(id)
    }

    /// A number of a line in its units.
    fn number(&self, number: i32) -> String {
        match self.lines {
            LineUnits::Grid => number.to_string(),
            LineUnits::Box => decimal(number),
        }
    }

    /// Value of 100 % of the width, if it is a number in these units.
    fn whole(&self) -> Option<i32> {
        (self.lines == LineUnits::Box).then_some(BOX)
    }

    /// Animation of a colour.
    fn color(&self, color: &KeyedTrack) -> String {
        let key = |k: usize| (2 * color.frames[k], color_text(levels_of(color.key(k))));
        let keys: Vec<(u32, String)> = (0..color.len()).map(key).collect();
        self.animate("fill", &keys)
    }

    /// A gradient's line as attributes, and its animations.
    fn line(&self, line: &KeyedTrack, is_shown_first: bool) -> (String, String) {
        let (mut told, mut animates) = (String::new(), String::new());
        for (i, name) in ["x1", "y1", "x2", "y2"].into_iter().enumerate() {
            let keys = needed_keys(line, i);
            // x1, y1 and y2 default to 0, x2 to the whole width.
            let first = line.values[i];
            let usual = if i == 2 { self.whole() } else { Some(0) };
            let is_told = Some(first) != usual && (is_shown_first || keys.len() == 1);
            if is_told {
                let _ = write!(told, r#" {name}="{}""#, self.number(first));
            }
            if keys.len() > 1 {
                let text = |k: &usize| (2 * line.frames[*k], self.number(line.key(*k)[i]));
                let keys: Vec<(u32, String)> = keys.iter().map(text).collect();
                animates += &self.animate(name, &keys);
            }
        }
        (told, animates)
    }
}

/// Levels of a key of a colour; they are within 0 to 255.
fn levels_of(key: &[i32]) -> [u8; 3] {
    std::array::from_fn(|channel| key[channel] as u8)
}

fn color_text(color: [u8; 3]) -> String {
    let mut text = String::new();
    push_color(&mut text, color);
    text
}

/// Keys of one number of a track, without those that lie exactly between their neighbours; one key
/// if it is constant.
fn needed_keys(track: &KeyedTrack, number: usize) -> Vec<usize> {
    let at = |k: usize| i64::from(track.key(k)[number]);
    let frame = |k: usize| i64::from(track.frames[k]);
    if (1..track.len()).all(|k| at(k) == at(0)) {
        return vec![0];
    }
    let mut kept: Vec<usize> = vec![0];
    for k in 1..track.len() - 1 {
        let before = kept[kept.len() - 1];
        let run = (at(k) - at(before)) * (frame(k + 1) - frame(k));
        let next = (at(k + 1) - at(k)) * (frame(k) - frame(before));
        // All between `before` and `k` lie on one line, so one comparison is enough.
        if run != next {
            kept.push(k);
        }
    }
    kept.push(track.len() - 1);
    kept
}

/// Numbers of a track at a time in half frames, on the grid.
fn rounded(track: &KeyedTrack, half: u32) -> Vec<i32> {
    let values = track.at(f64::from(half) / 2.0);
    values.into_iter().map(|v| v.round() as i32).collect()
}

/// Attribute for the units of a gradient's line; empty for the default.
fn units_of(lines: LineUnits) -> &'static str {
    match lines {
        LineUnits::Grid => r#" gradientUnits="userSpaceOnUse""#,
        LineUnits::Box => "",
    }
}

/// Thousandths as the shortest decimal number.
fn decimal(thousandths: i32) -> String {
    fixed(thousandths, f64::from(BOX))
}

/// Path data of outlines.
fn path_of(points: &[i32], further_outlines: &[u32]) -> String {
    let mut out = String::new();
    push_outlines(&mut out, points, further_outlines);
    out
}

/// The `index`th id.
fn id_of(index: u32) -> String {
    let mut out = String::new();
    push_id(&mut out, index as usize);
    out
}

/// The outline with the start point and direction that make its text shortest.
fn turned(shape: &KeyedShape) -> KeyedTrack {
    let track = &shape.outline;
    let points = track.width / 2;
    if !shape.further_outlines.is_empty() || points > MAX_TURNED_POINTS {
        return track.clone();
    }
    let mut best: Option<(usize, KeyedTrack)> = None;
    for start in 0..points {
        for is_back in [false, true] {
            let source = |p: usize| {
                let step = if is_back { points - p } else { p };
                2 * ((start + step) % points)
            };
            let place = |key: &[i32], p: usize| [key[source(p)], key[source(p) + 1]];
            let mut values = Vec::with_capacity(track.values.len());
            for k in 0..track.len() {
                let key = track.key(k);
                values.extend((0..points).flat_map(|p| place(key, p)));
            }
            let turned = KeyedTrack {
                values,
                ..track.clone()
            };
            let length = |k: usize| path_of(turned.key(k), &[]).len();
            let length = (0..turned.len()).map(length).sum();
            if best.as_ref().is_none_or(|(least, _)| length < *least) {
                best = Some((length, turned));
            }
        }
    }
    best.map_or_else(|| track.clone(), |(_, turned)| turned)
}

#[cfg(test)]
mod tests;
