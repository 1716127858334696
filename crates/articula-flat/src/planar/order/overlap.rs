//! Overlap sets: the sets of triangles that cover each other at a sample, with counts.
//!
//! Source: `docs/methods/vector.md` 4, steps 1 and 4. Whole sets are kept instead of pairs. A
//! sample is correct if the triangle that owns it is painted last of its set, so the number of
//! wrong samples of any order is exact, without painting again.

use super::painting::Painting;
use crate::item_buffer::{Faces, ItemBuffer, Supersampling};
use crate::planar::clip::PlanarClip;
use crate::planar::drawn::{Drawn, draw_frame};
use crate::planar::error::PlanarError;
use std::collections::HashMap;
use std::ops::Range;

/// Samples per pixel; the same as for [`Drawn`], so that every owner is drawn.
const SAMPLES: Supersampling = Supersampling::Two;
/// Maximum number of distinct sets of a clip.
const MAX_SETS: usize = 1 << 22;

/// Sets of drawn triangles that overlap in a clip, with their sample counts in each frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Overlaps {
    /// Index of each set's first member, and the end.
    starts: Vec<usize>,
    /// Members of all sets, the owner of the sample first.
    members: Vec<u32>,
    frames: Vec<FrameOverlaps>,
}

/// Sample counts of one frame.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct FrameOverlaps {
    /// Sets and their sample counts.
    counts: Vec<(u32, u32)>,
    /// Samples that are wrong in every order: the owner is not drawn, or nothing owns them and
    /// something is drawn.
    lost: u32,
    /// Samples that some triangle owns.
    object: u32,
}

/// Wrong samples of a painting, frame by frame.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct WrongPixels {
    /// For each frame the samples that show a triangle other than the nearest, and the samples of
    /// the character. There are four samples in a pixel.
    pub per_frame: Vec<(u32, u32)>,
}

impl WrongPixels {
    /// Fraction of the character that is wrong, mean over the frames, percent.
    pub(crate) fn percent_mean(&self) -> f64 {
        let share = |(wrong, object): &(u32, u32)| f64::from(*wrong) / f64::from((*object).max(1));
        let sum: f64 = self.per_frame.iter().map(share).sum();
        100.0 * sum / self.per_frame.len().max(1) as f64
    }

    /// Fraction of the character's samples that are wrong, over all frames together.
    pub(crate) fn share(&self) -> f64 {
        let sum = |of: fn(&(u32, u32)) -> u32| -> u64 {
            self.per_frame.iter().map(|f| u64::from(of(f))).sum()
        };
        sum(|f| f.0) as f64 / sum(|f| f.1).max(1) as f64
    }
}

/// Counts the samples that a painting shows wrong, frame by frame.
///
/// # Errors
/// Errors of the clip, or [`PlanarError::Mismatch`] if `drawn` belongs to another one.
#[cfg(test)]
pub(crate) fn wrong_pixels(
    clip: &PlanarClip,
    drawn: &Drawn,
    painting: &Painting,
) -> Result<WrongPixels, PlanarError> {
    Ok(Overlaps::of(clip, drawn)?.wrong(painting))
}

impl Overlaps {
    /// Collects the sets by rasterising every frame.
    ///
    /// O(frames x samples covered).
    ///
    /// # Errors
    /// Errors of the clip, [`PlanarError::Mismatch`] if `drawn` belongs to another one,
    /// [`PlanarError::TooManyOverlaps`].
    pub(crate) fn of(clip: &PlanarClip, drawn: &Drawn) -> Result<Self, PlanarError> {
        clip.check()?;
        drawn.fits(clip)?;
        let mut buffer = ItemBuffer::new(clip.width, clip.height, SAMPLES)?;
        let mut sets = Sets::new(clip.triangles.len());
        let mut frames = Vec::new();
        for f in 0..clip.frames.len() {
            draw_frame(clip, f, &mut buffer);
            frames.push(sets.frame(clip, drawn, f, &buffer)?);
        }
        Ok(sets.finish(frames))
    }

    /// Number of distinct sets.
    pub(crate) fn sets(&self) -> usize {
        self.starts.len() - 1
    }

    /// Triangles of a set; the first owns the sample, the others have to be painted before it.
    pub(crate) fn members(&self, set: usize) -> &[u32] {
        &self.members[self.starts[set]..self.starts[set + 1]]
    }

    /// Sets of a frame with their sample counts.
    pub(crate) fn counts(&self, frame: usize) -> &[(u32, u32)] {
        &self.frames[frame].counts
    }

    /// Number of frames.
    pub(crate) fn frames(&self) -> usize {
        self.frames.len()
    }

    /// Samples of the character over some frames.
    pub(crate) fn object(&self, frames: &Range<usize>) -> u64 {
        let of = |f: &FrameOverlaps| u64::from(f.object);
        self.frames[frames.clone()].iter().map(of).sum()
    }

    /// Samples of every set over some frames, ascending by set; sets without samples are left out.
    pub(crate) fn sum(&self, frames: &Range<usize>) -> Vec<(u32, u64)> {
        let all = self.frames[frames.clone()].iter().flat_map(|f| &f.counts);
        let mut sum: Vec<(u32, u64)> = all.map(|(set, n)| (*set, u64::from(*n))).collect();
        sum.sort_unstable_by_key(|(set, _)| *set);
        sum.dedup_by(|next, kept| {
            let is_same = next.0 == kept.0;
            if is_same {
                kept.1 += next.1;
            }
            is_same
        });
        sum
    }

    /// Counts the samples that a painting shows wrong, frame by frame.
    pub(crate) fn wrong(&self, painting: &Painting) -> WrongPixels {
        let mut per_frame = vec![(0, 0); self.frames.len()];
        for epoch in &painting.epochs {
            let places = Places::of(&epoch.order);
            for f in epoch.frames.clone().filter(|f| *f < self.frames.len()) {
                let frame = &self.frames[f];
                let is_wrong = |(set, _): &&(u32, u32)| self.is_wrong(*set, &places);
                let counts = frame.counts.iter().filter(is_wrong);
                let wrong: u32 = counts.map(|(_, n)| *n).sum();
                per_frame[f] = (wrong + frame.lost, frame.object);
            }
        }
        WrongPixels { per_frame }
    }

    /// Samples that an order shows wrong over some frames, excluding those that are wrong in every
    /// order.
    pub(super) fn wrong_within(&self, frames: &Range<usize>, order: &[u32]) -> u64 {
        let places = Places::of(order);
        let all = self.frames[frames.clone()].iter().flat_map(|f| &f.counts);
        let wrong = all.filter(|(set, _)| self.is_wrong(*set, &places));
        wrong.map(|(_, n)| u64::from(*n)).sum()
    }

    fn is_wrong(&self, set: u32, places: &Places) -> bool {
        let members = self.members(set as usize);
        let owner = places.get(members[0]);
        members[1..].iter().any(|t| places.get(*t) > owner)
    }
}

/// Position of each triangle in an order.
pub(super) struct Places(Vec<u32>);

impl Places {
    pub(super) fn of(order: &[u32]) -> Self {
        let count = order.iter().max().map_or(0, |t| *t as usize + 1);
        let mut places = vec![0; count];
        for (place, t) in order.iter().enumerate() {
            places[*t as usize] = place as u32 + 1;
        }
        Self(places)
    }

    /// Position of a triangle; 0 if it is not in the order.
    pub(super) fn get(&self, triangle: u32) -> u32 {
        self.0.get(triangle as usize).copied().unwrap_or(0)
    }
}

/// Sets during construction: a tree whose path from a root (the owner) lists the members.
struct Sets {
    triangles: u32,
    /// Parent and last member of each set; a root is its own parent.
    nodes: Vec<(u32, u32)>,
    owner: Vec<u32>,
    known: HashMap<(u32, u32), u32>,
    /// Child for the current triangle, and the walk for which it is valid.
    memo: Vec<(u32, u32)>,
    walks: u32,
    state: Vec<u32>,
    tally: Vec<u32>,
}

impl Sets {
    fn new(triangles: usize) -> Self {
        // Two more roots: samples that nothing owns, and those that are already lost.
        let roots = triangles as u32 + 2;
        Self {
            triangles: triangles as u32,
            nodes: (0..roots).map(|t| (t, t)).collect(),
            owner: (0..roots).collect(),
            known: HashMap::new(),
            memo: vec![(0, 0); roots as usize],
            walks: 0,
            state: Vec::new(),
            tally: vec![0; roots as usize],
        }
    }

    fn blank(&self) -> u32 {
        self.triangles
    }

    fn lost(&self) -> u32 {
        self.triangles + 1
    }

    fn frame(
        &mut self,
        clip: &PlanarClip,
        drawn: &Drawn,
        f: usize,
        buffer: &ItemBuffer,
    ) -> Result<FrameOverlaps, PlanarError> {
        let mut frame = FrameOverlaps::default();
        self.start(drawn, f, buffer, &mut frame);
        let width = buffer.sample_size().0;
        let mut state = std::mem::take(&mut self.state);
        for t in (0..self.triangles).filter(|t| drawn.get(f, *t as usize)) {
            self.walks += 1;
            let mut last = (u32::MAX, 0);
            buffer.visit(clip.corners(f, t as usize), Faces::Both, |x, y| {
                let at = &mut state[y as usize * width as usize + x as usize];
                if *at != last.0 {
                    last = (*at, self.with(*at, t));
                }
                *at = last.1;
            });
            if self.nodes.len() > MAX_SETS {
                return Err(PlanarError::TooManyOverlaps { most: MAX_SETS });
            }
        }
        let (blank, lost) = (self.blank(), self.lost());
        let mut seen = Vec::new();
        for set in &state {
            if *set != blank {
                let n = &mut self.tally[*set as usize];
                if *n == 0 {
                    seen.push(*set);
                }
                *n += 1;
            }
        }
        self.state = state;
        frame.lost = self.tally[lost as usize];
        seen.sort_unstable();
        for set in seen {
            let n = std::mem::take(&mut self.tally[set as usize]);
            if set > lost {
                frame.counts.push((set, n));
            }
        }
        Ok(frame)
    }

    /// Begins a frame with the owners of its samples.
    fn start(&mut self, drawn: &Drawn, f: usize, buffer: &ItemBuffer, frame: &mut FrameOverlaps) {
        let (width, height) = buffer.sample_size();
        let (blank, lost) = (self.blank(), self.lost());
        self.state.clear();
        for y in 0..height {
            for x in 0..width {
                let item = buffer.item(x, y);
                frame.object += u32::from(item.is_some());
                self.state.push(match item {
                    None => blank,
                    Some(t) if drawn.get(f, t as usize) => t,
                    Some(_) => lost,
                });
            }
        }
    }

    /// The set that results from adding a triangle to a set.
    fn with(&mut self, set: u32, triangle: u32) -> u32 {
        let owner = self.owner[set as usize];
        if owner == triangle {
            return set;
        }
        if owner >= self.triangles {
            return self.lost();
        }
        let memo = self.memo[set as usize];
        if memo.1 == self.walks {
            return memo.0;
        }
        let next = self.nodes.len() as u32;
        let child = *self.known.entry((set, triangle)).or_insert(next);
        if child == next {
            self.nodes.push((set, triangle));
            self.owner.push(owner);
            self.memo.push((0, 0));
            self.tally.push(0);
        }
        self.memo[set as usize] = (child, self.walks);
        child
    }

    /// Numbers the sets in which samples ended, consecutively.
    fn finish(self, mut frames: Vec<FrameOverlaps>) -> Overlaps {
        const NONE: u32 = u32::MAX;
        let mut number = vec![NONE; self.nodes.len()];
        let (mut starts, mut members) = (vec![0], Vec::new());
        for (set, _) in frames.iter_mut().flat_map(|f| &mut f.counts) {
            let mut at = *set;
            if number[at as usize] == NONE {
                number[at as usize] = starts.len() as u32 - 1;
                let first = members.len();
                while self.nodes[at as usize].0 != at {
                    members.push(self.nodes[at as usize].1);
                    at = self.nodes[at as usize].0;
                }
                members.push(at);
                members[first..].reverse();
                starts.push(members.len());
            }
            *set = number[*set as usize];
        }
        Overlaps {
            starts,
            members,
            frames,
        }
    }
}

#[cfg(test)]
impl Overlaps {
    /// Builds overlaps from frames of sets, owner first, with their sample counts.
    pub(super) fn by_hand(frames: &[&[(&[u32], u32)]]) -> Self {
        let (mut starts, mut members) = (vec![0], Vec::new());
        let mut add = |(set, n): &(&[u32], u32)| {
            members.extend_from_slice(set);
            starts.push(members.len());
            (starts.len() as u32 - 2, *n)
        };
        let mut frame = |sets: &&[(&[u32], u32)]| FrameOverlaps {
            counts: sets.iter().map(&mut add).collect(),
            lost: 0,
            object: sets.iter().map(|(_, n)| n).sum(),
        };
        let frames = frames.iter().map(&mut frame).collect();
        Self {
            starts,
            members,
            frames,
        }
    }
}
