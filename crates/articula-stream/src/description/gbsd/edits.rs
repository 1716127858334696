//! Edits of a text by places.

use std::ops::Range;

/// A place of the text and what stands there instead.
pub(super) type Edit = (Range<usize>, String);

/// Puts edits into a text; those that lie in others, which come before them, are left out.
pub(super) fn apply(source: &str, mut edits: Vec<Edit>) -> String {
    edits.sort_by_key(|(place, _)| place.start);
    let mut out = String::with_capacity(source.len());
    let mut at = 0;
    for (place, text) in edits {
        if place.start >= at {
            out.push_str(&source[at..place.start]);
            out.push_str(&text);
            at = place.end;
        }
    }
    out.push_str(&source[at..]);
    out
}

/// Where the end tag of an element begins.
pub(super) fn close_of(source: &str, span: &Range<usize>) -> usize {
    source[span.clone()]
        .rfind("</")
        .map_or(span.end, |at| span.start + at)
}
