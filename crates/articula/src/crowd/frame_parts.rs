//! Independent parts of the evaluation of a frame.

use super::cached_draws::{CachedRest, CachedShare};
use super::palettes::split;
use super::share::{PartOf, Rest, Share};
use articula_core::PaletteRows;
use articula_core::batch::Scratch;
use articula_core::crowd::{Crowd, CrowdModel};
use std::ops::Range;

/// An independent part of a frame's evaluation.
#[derive(Debug)]
pub struct FramePart<'a> {
    crowd: &'a Crowd,
    model: &'a CrowdModel,
    batches: Range<usize>,
    rows: PaletteRows<'a>,
    weights: Share<'a, f32>,
    cached: CachedShare<'a>,
    scratch: &'a mut Scratch,
}

impl FramePart<'_> {
    /// Writes its palettes, records, stepped draws and morph target weights; does not allocate.
    pub fn evaluate(&mut self) {
        let (crowd, model) = (self.crowd, self.model);
        let rows = match &mut self.rows {
            PaletteRows::Float(rows) => PaletteRows::Float(rows),
            PaletteRows::Half(rows) => PaletteRows::Half(rows),
        };
        crowd.evaluate(model, self.batches.clone(), rows, self.scratch);
        let sets = self.weights.range.clone();
        crowd.evaluate_morphs(model, sets, self.weights.out);
        self.cached.evaluate(crowd, model);
    }
}

/// Splits a frame into at most one part per scratch memory.
pub(super) struct Parts<'a> {
    pub crowd: &'a Crowd,
    pub model: &'a CrowdModel,
    pub rows: Option<PaletteRows<'a>>,
    pub weights: Rest<'a, f32>,
    /// Number of morph target weights of a character.
    pub targets: usize,
    pub cached: CachedRest<'a>,
    pub scratches: std::slice::IterMut<'a, Scratch>,
    pub first: usize,
    pub count: usize,
}

impl<'a> Iterator for Parts<'a> {
    type Item = FramePart<'a>;

    fn next(&mut self) -> Option<FramePart<'a>> {
        let scratch = self.scratches.next()?;
        let list = self.crowd.draw_list();
        let part = PartOf {
            parts: self.count,
            is_last: self.scratches.len() == 0,
        };
        let mut batches = self.crowd.share_of_batches(self.first, self.count);
        if part.is_last {
            batches.end = list.batches;
        }
        let weights = self.weights.take(list.morph_sets(), self.targets, part);
        let cached = self.cached.take(list, part);
        if batches.is_empty() && weights.range.is_empty() && cached.is_empty() {
            return None;
        }
        self.first = batches.end;
        let matrices = self.crowd.matrices_of(batches.clone()).len();
        let rows = matrices * self.model.parts().form.rows();
        let (rows, rest) = split(self.rows.take()?, rows);
        self.rows = Some(rest);
        Some(FramePart {
            crowd: self.crowd,
            model: self.model,
            batches,
            rows,
            weights,
            cached,
            scratch,
        })
    }
}
