//! Evaluation of a planned frame: palettes, records, draws of cached palettes and morph target weights
//! of any part of it.

use super::attachment::attachment;
use super::character_state::ClipState;
use super::draws::CachedDraw;
use super::model::CrowdModel;
use super::plan::{Batch, DrawList};
use super::section::SECTION;
use super::tick::Crowd;
use crate::batch::{BatchPose, MAX_LANES, Scratch};
use crate::blend_record::BlendRecord;
use crate::palette::PaletteRows;
use glam::Affine3A;
use std::ops::Range;

impl Crowd {
    /// Model-from-joint matrix of a joint at full detail, whatever the level and visibility of the
    /// character. O(depth); does not allocate.
    ///
    /// # Panics
    /// If there is no such character or joint.
    pub fn attachment(&self, model: &CrowdModel, character: usize, joint: usize) -> Affine3A {
        let shown = self.state(character).shown(&model.parts().clips);
        attachment(&model.parts().clips, &shown, joint)
    }

    /// Draw list of the last tick: the visible characters by level, and where their palettes are.
    pub fn draw_list(&self) -> &DrawList {
        self.plan.draw_list()
    }

    /// Range of matrices that a range of batches writes, among all matrices of the frame.
    ///
    /// # Panics
    /// If the range ends beyond the batches.
    pub fn matrices_of(&self, batches: Range<usize>) -> Range<usize> {
        assert!(
            batches.end <= self.draw_list().batches,
            "the range of batches is out of bounds"
        );
        self.plan.first_matrix(batches.start)..self.plan.first_matrix(batches.end)
    }

    /// Returns the batches from `first` on that write about `1 / parts` of all matrices, for
    /// distribution over threads. Empty when no batches are left.
    pub fn share_of_batches(&self, first: usize, parts: usize) -> Range<usize> {
        let count = self.draw_list().batches;
        let aim = self.plan.first_matrix(first) + self.draw_list().matrices.div_ceil(parts.max(1));
        let mut end = (first + 1).min(count);
        while end < count && self.plan.first_matrix(end) < aim {
            end += 1;
        }
        first.min(count)..end
    }

    /// Writes the palettes of a range of batches. Ranges are independent: the bytes are the same in
    /// whatever order and on whatever threads they are evaluated.
    ///
    /// O(joints of the batches); does not allocate.
    ///
    /// # Panics
    /// If `out` does not have the rows of [`Crowd::matrices_of`] this range, in the form of the
    /// model, or `scratch` is not of the model's evaluator.
    pub fn evaluate(
        &self,
        model: &CrowdModel,
        batches: Range<usize>,
        mut out: PaletteRows<'_>,
        scratch: &mut Scratch,
    ) {
        let evaluator = model.evaluator();
        let rows = model.parts().form.rows();
        let first = self.matrices_of(batches.clone());
        assert_eq!(
            out.len(),
            first.len() * rows,
            "the output must hold every palette"
        );
        let first = first.start;
        for at in batches {
            let batch = self.plan.batches()[at];
            let matrices = self.matrices_of(at..at + 1);
            let part = (matrices.start - first) * rows..(matrices.end - first) * rows;
            if batch.is_cached() {
                self.blend(model, &batch, out.part(part));
                continue;
            }
            let mut shown = [BatchPose::from(model.parts().clips.cursor(0, 0.0)); MAX_LANES];
            for (shown, character) in shown.iter_mut().zip(self.plan.posed(&batch)) {
                *shown = self.state(character).shown(&model.parts().clips);
            }
            let shown = &shown[..batch.poses()];
            evaluator.evaluate(batch.level(), shown, out.part(part), scratch);
        }
    }

    /// Writes the morph target weights of a range of sets, for each as many as the mesh has targets
    /// ([`MorphClips::targets`](super::MorphClips::targets)), at the character's own times: a
    /// character with a cached pose has its own face. Targets that its morph level leaves
    /// out have their default weights. Ranges are independent, as of [`Crowd::evaluate`].
    ///
    /// O(targets of the sets); does not allocate.
    ///
    /// # Panics
    /// If the range ends beyond [`DrawList::morph_sets`], or `out` does not have the weights of these
    /// sets.
    pub fn evaluate_morphs(&self, model: &CrowdModel, sets: Range<usize>, out: &mut [f32]) {
        let (_, targets) = model.morphs();
        assert!(
            sets.end <= self.draw_list().morph_sets(),
            "the range of morph sets is out of bounds"
        );
        assert_eq!(
            out.len(),
            sets.len() * targets,
            "the output must hold the weights of every set"
        );
        let Some(morphs) = model.parts().morphs.as_ref().filter(|_| targets > 0) else {
            return;
        };
        for (set, out) in sets.zip(out.chunks_exact_mut(targets)) {
            let character = self.draw_list().character_of(set);
            let (section, character) = self.at(character);
            let level = section.morphs.get(character);
            morphs.sample(&section.clocks.state(character), level, out);
        }
    }

    /// Writes a range of the draws of a kind that is not [`DrawKind::Palette`](super::DrawKind::Palette):
    /// for each of its [characters](DrawList::characters) what a renderer reads at the character's time.
    /// Ranges are independent, as of [`Crowd::evaluate`].
    ///
    /// O(draws); does not allocate.
    ///
    /// # Panics
    /// If the range ends beyond the list, or `out` does not have its length.
    pub fn evaluate_draws<D: CachedDraw>(
        &self,
        model: &CrowdModel,
        range: Range<usize>,
        out: &mut [D],
    ) {
        let list = self.draw_list().characters(D::KIND);
        assert_eq!(
            out.len(),
            list[range.clone()].len(),
            "the output must hold every draw"
        );
        for run in self.plan.runs(D::KIND) {
            let of = (list, run.at.clone());
            self.for_cached(of, &range, out, |character, state| {
                D::at(model, run.level, state, character)
            });
        }
    }

    /// Writes something for each character of a run of a list that lies in a range of the list.
    /// `out` is of that range.
    #[inline]
    fn for_cached<T>(
        &self,
        (list, run): (&[u32], Range<usize>),
        range: &Range<usize>,
        out: &mut [T],
        write: impl Fn(u32, ClipState) -> T,
    ) {
        let part = run.start.max(range.start)..run.end.min(range.end);
        if part.is_empty() {
            return;
        }
        let (mut rest, start) = (&list[part.clone()], range.start);
        let mut out = out[part.start - start..part.end - start].iter_mut();
        while let Some(&first) = rest.first() {
            // A run is in the order of the sections.
            let section = first as usize / SECTION;
            let end = rest.partition_point(|c| *c as usize / SECTION <= section);
            let (characters, others) = rest.split_at(end);
            rest = others;
            let clocks = &self.sections[section].clocks;
            for (&character, out) in characters.iter().zip(&mut out) {
                *out = write(
                    character,
                    clocks.from(character as usize - section * SECTION),
                );
            }
        }
    }

    /// Blends cached palettes.
    fn blend(&self, model: &CrowdModel, batch: &Batch, out: PaletteRows<'_>) {
        let Some(cache) = model.parts().cache.as_ref() else {
            return;
        };
        let mut records = [BlendRecord::default(); MAX_LANES];
        for (record, character) in records.iter_mut().zip(self.plan.posed(batch)) {
            let state = self.clip_state(character);
            let located = cache.locate(state.clip(), batch.level(), state.secs);
            *record = located.unwrap_or_default();
        }
        let records = &records[..batch.poses()];
        cache.blend(batch.level(), records, model.parts().backend, out);
    }

    /// State of the first clip of a character.
    #[inline]
    fn clip_state(&self, character: usize) -> ClipState {
        let (section, character) = self.at(character);
        section.clocks.from(character)
    }
}
