//! A `path` for each face, with the absolute coordinates of every frame, and its optimisations.
//!
//! Source: thesis 4.2.2 and 4.2.3. The colour is that of the neutral frame.
//!
//! 1. Hidden: the `animate` ends where the face is hidden and another begins where it is shown
//!    again.
//! 2. Static: where a face is in view and does not move, its coordinates are written once, by a
//!    separate `animate` or else by `keyTimes`; by the former if there are more than 200/13 frames
//!    per static sequence (two more tags take 200 bytes, a key time takes 13).

use super::ThesisSvgOptions;
use super::document::{Clock, Outline, put};
use super::faces::{Faces, mean_color};
use crate::planar::PlanarClip;
use std::ops::{Range, RangeInclusive};

/// Frames in which a face does not move, first and last included.
type Still = RangeInclusive<usize>;

/// Minimum number of frames of a static sequence: of two, none could be omitted.
const FEWEST_STILL: usize = 3;

/// Appends all paths in painting order.
pub(super) fn write(
    clip: &PlanarClip,
    faces: &Faces,
    options: &ThesisSvgOptions,
    clock: Clock,
    text: &mut String,
) {
    for face in &faces.order {
        let track = Track {
            clip,
            face: *face,
            clock,
        };
        let spans = faces.spans(*face);
        let stills = if options.optimise_static {
            track.stills(&spans)
        } else {
            Vec::new()
        };
        let data: Vec<Range<usize>> = if options.optimise_hidden {
            spans.clone()
        } else {
            std::iter::once(0..clip.frames.len()).collect()
        };
        let is_first_seen = faces.is_shown(0, *face);
        track.write_head(is_first_seen, data[0].start, options.neutral_frame, text);
        track.write_visibility(&spans, text);
        for span in data {
            track.write_span(&span, &stills, text);
        }
        text.push_str("</path>\n");
    }
}

/// Whether static sequences are merged by `animate` tags, by the rule of thesis 4.2.3.
fn merges_by_tags(frames: usize, stills: usize) -> bool {
    13 * frames > 200 * stills
}

/// A face over time.
struct Track<'a> {
    clip: &'a PlanarClip,
    face: u32,
    clock: Clock,
}

impl Track<'_> {
    fn outline(&self, frame: usize) -> Outline {
        Outline(self.clip.places(frame, self.face as usize))
    }

    /// Static sequences within the spans in which the face is in view, ascending.
    fn stills(&self, spans: &[Range<usize>]) -> Vec<Still> {
        let mut stills = Vec::new();
        for span in spans {
            let mut start = span.start;
            let mut at_start = self.outline(start).to_string();
            for f in span.start + 1..=span.end {
                let here = (f < span.end).then(|| self.outline(f).to_string());
                if here.as_ref() == Some(&at_start) {
                    continue;
                }
                if f - start >= FEWEST_STILL {
                    stills.push(start..=f - 1);
                }
                (start, at_start) = (f, here.unwrap_or_default());
            }
        }
        stills
    }

    fn write_head(&self, is_first_seen: bool, first: usize, neutral: usize, text: &mut String) {
        let (face, outline) = (self.face, self.outline(first));
        let [red, green, blue] = mean_color(self.clip, neutral, face);
        let visibility = if is_first_seen { "visible" } else { "hidden" };
        put(
            text,
            format_args!(
                "<path id=\"face{face}\" d=\"{outline}\" fill=\"rgb({red},{green},{blue})\" \
                 stroke=\"none\" visibility=\"{visibility}\">\n"
            ),
        );
    }

    /// Writes one tag for each span in view and each span hidden.
    fn write_visibility(&self, spans: &[Range<usize>], text: &mut String) {
        let frames = self.clip.frames.len();
        let mut at = 0;
        for span in spans {
            self.write_set("hidden", at..span.start, text);
            self.write_set("visible", span.clone(), text);
            at = span.end;
        }
        self.write_set("hidden", at..frames, text);
    }

    fn write_set(&self, to: &str, span: Range<usize>, text: &mut String) {
        if span.is_empty() {
            return;
        }
        let begin = self.clock.begin(span.start);
        let length = self.clock.between(span.start, span.end);
        put(
            text,
            format_args!(
                "<set attributeName=\"visibility\" attributeType=\"CSS\" to=\"{to}\" \
                 begin=\"{begin}\" dur=\"{length}\" fill=\"freeze\"/>\n"
            ),
        );
    }

    /// Writes the coordinates of a span of frames, with the static sequences in it merged.
    fn write_span(&self, span: &Range<usize>, all_stills: &[Still], text: &mut String) {
        let last = span.end - 1;
        let within = |still: &&Still| span.contains(still.start());
        let stills: Vec<&Still> = all_stills.iter().filter(within).collect();
        if !merges_by_tags(self.clip.frames.len(), all_stills.len()) {
            let is_inside = |f: &usize| {
                let inside = |s: &&&Still| s.start() < f && f < s.end();
                stills.iter().any(|s| inside(&s))
            };
            let keys: Vec<usize> = span.clone().filter(|f| !is_inside(f)).collect();
            return self.write_animate(&keys, text);
        }
        let mut at = span.start;
        for still in stills {
            let (start, end) = (*still.start(), *still.end());
            if at < start {
                self.write_animate(&(at..=start).collect::<Vec<_>>(), text);
            }
            self.write_held(start, end, text);
            at = end;
        }
        // A span of one frame has no motion, but is shown.
        if at < last {
            self.write_animate(&(at..=last).collect::<Vec<_>>(), text);
        } else if span.len() == 1 {
            self.write_held(last, last + 1, text);
        }
    }

    /// Writes an `animate` with a single key.
    fn write_held(&self, start: usize, end: usize, text: &mut String) {
        self.open_animate(start, end, text);
        put(text, format_args!("{}\"/>\n", self.outline(start)));
    }

    /// Writes an `animate` with two or more keys, and `keyTimes` unless they are evenly spaced.
    fn write_animate(&self, keys: &[usize], text: &mut String) {
        let [first, .., last] = keys else {
            if let [only] = keys {
                self.write_held(*only, only + 1, text);
            }
            return;
        };
        self.open_animate(*first, *last, text);
        for (k, frame) in keys.iter().enumerate() {
            let separator = if k == 0 { "" } else { ";" };
            put(text, format_args!("{separator}{}", self.outline(*frame)));
        }
        if last - first + 1 != keys.len() {
            text.push_str("\" keyTimes=\"");
            for (k, frame) in keys.iter().enumerate() {
                let separator = if k == 0 { "" } else { ";" };
                let share = (frame - first) as f64 / (last - first) as f64;
                put(text, format_args!("{separator}{share:.10}"));
            }
        }
        text.push_str("\"/>\n");
    }

    fn open_animate(&self, start: usize, end: usize, text: &mut String) {
        let (begin, length) = (self.clock.begin(start), self.clock.between(start, end));
        put(
            text,
            format_args!(
                "<animate attributeName=\"d\" attributeType=\"XML\" begin=\"{begin}\" \
                 dur=\"{length}\" fill=\"freeze\" values=\""
            ),
        );
    }
}

#[cfg(test)]
mod tests;
