//! One list of painted copies that contains the order of every epoch.
//!
//! Source: `docs/methods/vector.md` 4. Each epoch's order is merged into the list so far: the
//! longest part that keeps its relative sequence (longest increasing subsequence after Fredman
//! 1975) uses the existing elements; a triangle that moves gets another copy between its new
//! neighbours. A copy of an earlier epoch is used again where it fits.

use super::painting::Painting;
use crate::planar::drawn::Drawn;
use std::ops::Range;

/// A painted copy of a triangle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Layer {
    /// Index of the triangle.
    pub triangle: u32,
    /// Spans of frames in which it is drawn, ascending and disjoint.
    pub frames: Vec<Range<usize>>,
}

impl Painting {
    /// Returns all copies, back to front. In each frame, those that are drawn are the triangles
    /// drawn in it, in the order of its epoch; triangles that `drawn` lacks are left out.
    pub(crate) fn layers(&self, drawn: &Drawn) -> Vec<Layer> {
        let mut list: Vec<Copy> = Vec::new();
        for (e, epoch) in self.epochs.iter().enumerate() {
            let is_drawn = drawn.mask(&epoch.frames);
            let is_drawn = |t: &u32| is_drawn.get(*t as usize).copied().unwrap_or(false);
            let order: Vec<u32> = epoch.order.iter().copied().filter(is_drawn).collect();
            list = merge(list, &order, e);
        }
        let layer = |copy: Copy| Layer {
            triangle: copy.triangle,
            frames: self.spans(&copy, drawn),
        };
        list.into_iter().map(layer).collect()
    }

    /// Mean number of copies of the triangles that are drawn; 1 if none needs a second.
    pub(crate) fn mean_copies(&self, drawn: &Drawn) -> f64 {
        self.layers(drawn).len() as f64 / drawn.ever().len().max(1) as f64
    }

    fn spans(&self, copy: &Copy, drawn: &Drawn) -> Vec<Range<usize>> {
        let mut spans: Vec<Range<usize>> = Vec::new();
        let frames = copy.epochs.iter().map(|e| self.epochs[*e].frames.clone());
        for f in frames.flatten() {
            if !drawn.get(f, copy.triangle as usize) {
                continue;
            }
            match spans.last_mut() {
                Some(last) if last.end == f => last.end = f + 1,
                _ => spans.push(f..f + 1),
            }
        }
        spans
    }
}

/// A copy of a triangle, and the epochs that use it, ascending.
struct Copy {
    triangle: u32,
    epochs: Vec<usize>,
}

/// Merges an order into the list.
fn merge(list: Vec<Copy>, order: &[u32], epoch: usize) -> Vec<Copy> {
    let kept = kept(&list, order);
    let mut merged = Vec::with_capacity(list.len() + order.len() - kept.len());
    let mut place = 0;
    let mut kept = kept.into_iter().peekable();
    let new = |triangle: &u32| Copy {
        triangle: *triangle,
        epochs: vec![epoch],
    };
    for (i, mut copy) in list.into_iter().enumerate() {
        if let Some((_, at)) = kept.next_if(|(element, _)| *element == i) {
            // New copies are inserted directly before the next element that stays.
            merged.extend(order[place..at].iter().map(new));
            place = at + 1;
            copy.epochs.push(epoch);
        }
        merged.push(copy);
    }
    merged.extend(order[place..].iter().map(new));
    merged
}

/// Longest sequence of list elements in the same relative order as in `order`: pairs of an element
/// and its position in `order`, both ascending.
fn kept(list: &[Copy], order: &[u32]) -> Vec<(usize, usize)> {
    const NONE: usize = usize::MAX;
    let count = order.iter().max().map_or(0, |t| *t as usize + 1);
    let mut place = vec![NONE; count];
    for (p, t) in order.iter().enumerate() {
        place[*t as usize] = p;
    }
    // For each length the candidate with the smallest position, and the predecessor of every
    // candidate.
    let mut ends: Vec<usize> = Vec::new();
    let mut candidates: Vec<(usize, usize, usize)> = Vec::new();
    for (i, copy) in list.iter().enumerate() {
        let p = place.get(copy.triangle as usize).copied().unwrap_or(NONE);
        if p == NONE {
            continue;
        }
        let length = ends.partition_point(|c| candidates[*c].1 < p);
        let before = length.checked_sub(1).map_or(NONE, |l| ends[l]);
        let candidate = candidates.len();
        candidates.push((i, p, before));
        if length == ends.len() {
            ends.push(candidate);
        } else {
            ends[length] = candidate;
        }
    }
    let mut at = ends.last().copied().unwrap_or(NONE);
    let mut kept = Vec::new();
    while at != NONE {
        let (element, p, before) = candidates[at];
        kept.push((element, p));
        at = before;
    }
    kept.reverse();
    kept
}

#[cfg(test)]
mod tests {
    use crate::planar::Drawn;
    use crate::planar::order::{Epoch, Painting};

    fn copies(orders: &[&[u32]]) -> Vec<u32> {
        let mut drawn = Drawn::none(orders.len(), 6);
        let epoch = |(f, order): (usize, &&[u32])| {
            order.iter().for_each(|t| drawn.set(f, *t as usize, true));
            let order = order.to_vec();
            let frames = f..f + 1;
            Epoch { frames, order }
        };
        let epochs = orders.iter().enumerate().map(epoch).collect();
        let layers = Painting { epochs }.layers(&drawn);
        layers.iter().map(|l| l.triangle).collect()
    }

    #[test]
    fn only_what_moves_is_there_twice() {
        assert_eq!(copies(&[&[0, 1, 2, 3], &[0, 1, 2, 3]]), [0, 1, 2, 3]);
        assert_eq!(copies(&[&[0, 1, 2, 3], &[3, 0, 1, 2]]), [3, 0, 1, 2, 3]);
        // Back to the first order: the first copies are used again.
        let there_and_back: &[&[u32]] = &[&[0, 1, 2, 3], &[3, 0, 1, 2], &[0, 1, 2, 3]];
        assert_eq!(copies(there_and_back), [3, 0, 1, 2, 3]);
        // A new triangle goes before those that are painted after it.
        assert_eq!(copies(&[&[0, 2], &[1, 2]]), [0, 1, 2]);
    }
}
