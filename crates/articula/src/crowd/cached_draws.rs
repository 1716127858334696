//! What a frame writes of the characters that have no palette of their own: one list for each kind of
//! [`CachedDraw`].

use super::share::{PartOf, Rest, Share};
use articula_core::BlendRecord;
use articula_core::crowd::{CachedDraw, Crowd, CrowdModel, Draw, DrawList, ImpostorDraw};

/// Source of a character's shown pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PoseSource {
    /// The palettes of the frame: index of its first matrix.
    Written(usize),
    /// A record of the pose cache, which the GPU blends.
    Record(BlendRecord),
    /// A palette of the pose cache as it is: index of its first matrix.
    Stepped(u32),
}

/// Space for the draws of all characters.
#[derive(Debug)]
pub(super) struct CachedDraws {
    /// Of records and steps; empty without a cache.
    records: Vec<BlendRecord>,
    steps: Vec<Draw>,
    /// Empty without impostors.
    impostors: Vec<ImpostorDraw>,
}

impl CachedDraws {
    pub(super) fn new(model: &CrowdModel, characters: usize) -> Self {
        let parts = model.parts();
        let cached = parts.cache.as_ref().map_or(0, |_| characters);
        let impostors = parts.impostors.as_ref().map_or(0, |_| characters);
        Self {
            records: vec![BlendRecord::default(); cached],
            steps: vec![Draw::default(); cached],
            impostors: vec![ImpostorDraw::default(); impostors],
        }
    }

    /// Returns the blend records of a frame.
    pub(super) fn records(&self, list: &DrawList) -> &[BlendRecord] {
        written(&self.records, list)
    }

    /// Returns the draws that show the nearest cached palette.
    pub(super) fn steps(&self, list: &DrawList) -> &[Draw] {
        written(&self.steps, list)
    }

    /// Returns the draws of impostors.
    pub(super) fn impostors(&self, list: &DrawList) -> &[ImpostorDraw] {
        written(&self.impostors, list)
    }

    /// Returns the characters that show palettes of the cache, with their sources.
    pub(super) fn sources(&self, list: &DrawList) -> impl Iterator<Item = (u32, PoseSource)> {
        let records = self.records(list).iter();
        let steps = self.steps(list).iter();
        records
            .map(|r| (r.character, PoseSource::Record(*r)))
            .chain(steps.map(|s| (s.character, PoseSource::Stepped(s.first_matrix))))
    }

    /// Returns all that a frame has written, for a hash.
    pub(super) fn words(&self, list: &DrawList) -> impl Iterator<Item = u64> {
        let pair = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
        let records = self.records(list).iter().flat_map(|r| {
            let bytes = r.to_le_bytes();
            let (words, _) = bytes.as_chunks::<8>();
            [words[0], words[1]].map(u64::from_le_bytes)
        });
        let steps = self.steps(list).iter();
        let impostors = self.impostors(list).iter();
        records
            .chain(steps.map(move |s| pair(s.character, s.first_matrix)))
            .chain(impostors.map(move |d| pair(d.character, d.pose)))
    }

    /// Returns what the parts of a frame take their shares of.
    pub(super) fn rest(&mut self) -> CachedRest<'_> {
        CachedRest {
            records: Rest::of(&mut self.records),
            steps: Rest::of(&mut self.steps),
            impostors: Rest::of(&mut self.impostors),
        }
    }
}

/// The draws that a frame has written, of the space for all characters.
fn written<'a, D: CachedDraw>(all: &'a [D], list: &DrawList) -> &'a [D] {
    &all[..list.characters(D::KIND).len()]
}

/// Lists of which parts take their shares.
pub(super) struct CachedRest<'a> {
    records: Rest<'a, BlendRecord>,
    steps: Rest<'a, Draw>,
    impostors: Rest<'a, ImpostorDraw>,
}

impl<'a> CachedRest<'a> {
    pub(super) fn take(&mut self, list: &DrawList, part: PartOf) -> CachedShare<'a> {
        CachedShare {
            records: taken(&mut self.records, list, part),
            steps: taken(&mut self.steps, list, part),
            impostors: taken(&mut self.impostors, list, part),
        }
    }
}

fn taken<'a, D: CachedDraw>(rest: &mut Rest<'a, D>, list: &DrawList, part: PartOf) -> Share<'a, D> {
    rest.take(list.characters(D::KIND).len(), 1, part)
}

/// The draws of one part of a frame.
#[derive(Debug)]
pub(super) struct CachedShare<'a> {
    records: Share<'a, BlendRecord>,
    steps: Share<'a, Draw>,
    impostors: Share<'a, ImpostorDraw>,
}

impl CachedShare<'_> {
    pub(super) fn is_empty(&self) -> bool {
        let Self {
            records,
            steps,
            impostors,
        } = self;
        let ranges = [&records.range, &steps.range, &impostors.range];
        ranges.iter().all(|range| range.is_empty())
    }

    pub(super) fn evaluate(&mut self, crowd: &Crowd, model: &CrowdModel) {
        evaluate(&mut self.records, crowd, model);
        evaluate(&mut self.steps, crowd, model);
        evaluate(&mut self.impostors, crowd, model);
    }
}

fn evaluate<D: CachedDraw>(share: &mut Share<'_, D>, crowd: &Crowd, model: &CrowdModel) {
    crowd.evaluate_draws(model, share.range.clone(), share.out);
}
