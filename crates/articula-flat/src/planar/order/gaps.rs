//! Short gaps that are better left empty.
//!
//! [`Drawn::of`] draws hidden triangles in short gaps, which is free as long as something covers
//! them. Where no order hides such a triangle, it is not drawn: a switch costs a few bytes, wrong
//! pixels are visible.

use super::overlap::{Overlaps, Places};
use super::painting::Painting;
use crate::planar::drawn::Drawn;
use std::collections::BTreeMap;
use std::ops::Range;

/// Samples over a whole gap that may be wrong: one pixel.
const HARMLESS: u64 = 4;

/// Removes from `filled` the gaps in which a triangle that is not `seen` would cover a visible one.
/// `overlaps` are those of `filled`.
pub(super) fn without_harm(
    overlaps: &Overlaps,
    painting: &Painting,
    seen: &Drawn,
    filled: &Drawn,
) -> Drawn {
    let mut harm: BTreeMap<(u32, usize), u64> = BTreeMap::new();
    for epoch in &painting.epochs {
        let places = Places::of(&epoch.order);
        for f in epoch.frames.clone() {
            for (set, n) in overlaps.counts(f) {
                let members = overlaps.members(*set as usize);
                let owner = places.get(members[0]);
                let above = || members[1..].iter().filter(|t| places.get(**t) > owner);
                // Samples that are wrong in any case are not attributed to the gap.
                if above().any(|t| seen.get(f, *t as usize)) {
                    continue;
                }
                for t in above() {
                    *harm.entry((*t, f)).or_default() += u64::from(*n);
                }
            }
        }
    }
    let mut drawn = filled.clone();
    for t in 0..filled.triangles() {
        for gap in gaps(seen, filled, t) {
            let of = |f: usize| harm.get(&(t as u32, f)).copied().unwrap_or(0);
            if gap.clone().map(of).sum::<u64>() > HARMLESS {
                gap.for_each(|f| drawn.set(f, t, false));
            }
        }
    }
    drawn
}

/// Spans in which a triangle is drawn without being visible.
fn gaps(seen: &Drawn, filled: &Drawn, triangle: usize) -> Vec<Range<usize>> {
    let mut gaps: Vec<Range<usize>> = Vec::new();
    let is_gap = |f: &usize| filled.get(*f, triangle) && !seen.get(*f, triangle);
    for f in (0..filled.frames()).filter(is_gap) {
        match gaps.last_mut() {
            Some(last) if last.end == f => last.end = f + 1,
            _ => gaps.push(f..f + 1),
        }
    }
    gaps
}
