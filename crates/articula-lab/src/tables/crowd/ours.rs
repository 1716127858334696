//! Articula's evaluators as contestants: the batched one in every form, and the plain path.

use super::Bench;
use crate::measure::Contestant;
use anyhow::Result;
use articula_core::batch::{BatchEvaluator, BatchPose, MAX_LANES, Scratch};
use articula_core::{
    Backend, ClipSet, ModelPose, PaletteForm, PaletteMap, PaletteRows, Wrap, local_to_model, sample,
};
use std::hint::black_box;

/// Memory for the palettes of a crowd.
enum Palettes {
    Float(Vec<[f32; 4]>),
    Half(Vec<[u16; 4]>),
}

impl Palettes {
    fn new(form: PaletteForm, rows: usize) -> Self {
        if form.is_half() {
            Self::Half(vec![[0; 4]; rows])
        } else {
            Self::Float(vec![[0.0; 4]; rows])
        }
    }

    fn all(&mut self) -> PaletteRows<'_> {
        match self {
            Self::Float(rows) => PaletteRows::Float(rows),
            Self::Half(rows) => PaletteRows::Half(rows),
        }
    }
}

/// Inputs of a batched contestant.
#[derive(Clone, Copy)]
pub(super) struct Batched<'a> {
    pub(super) clips: &'a ClipSet,
    pub(super) map: &'a PaletteMap,
    /// Index of the clip.
    pub(super) clip: usize,
    pub(super) level: usize,
}

impl<'a> Batched<'a> {
    /// Writes the palettes of all characters.
    pub(super) fn stored(
        self,
        name: &str,
        form: PaletteForm,
        count: usize,
    ) -> Result<Contestant<'a>> {
        let evaluator = BatchEvaluator::new(self.clips, self.map, form, Backend::best())?;
        let mut scratch = evaluator.scratch();
        let (lanes, rows) = (evaluator.lanes(), evaluator.rows(self.level));
        let mut palettes = Palettes::new(form, count * rows);
        let frame = move |secs: &[f32]| {
            for (batch, times) in secs.chunks(lanes).enumerate() {
                let (shown, from) = (self.shown(times), batch * lanes * rows);
                let mut all = palettes.all();
                let out = all.part(from..from + times.len() * rows);
                evaluator.evaluate(self.level, &shown[..times.len()], out, &mut scratch);
            }
            black_box(&mut palettes.all());
        };
        Ok(Contestant {
            name: name.to_owned(),
            frame: Box::new(frame),
        })
    }

    /// Leaves the matrices of each batch in lanes, for a consumer.
    pub(super) fn tiles(self, name: &str) -> Result<Contestant<'a>> {
        let form = PaletteForm::Matrix;
        let evaluator = BatchEvaluator::new(self.clips, self.map, form, Backend::best())?;
        let mut scratch: Scratch = evaluator.scratch();
        let frame = move |secs: &[f32]| {
            for times in secs.chunks(evaluator.lanes()) {
                let shown = self.shown(times);
                black_box(evaluator.tile(self.level, &shown[..times.len()], &mut scratch));
            }
        };
        Ok(Contestant {
            name: name.to_owned(),
            frame: Box::new(frame),
        })
    }

    fn shown(&self, times: &[f32]) -> [BatchPose; MAX_LANES] {
        let at = |i: usize| times[i.min(times.len() - 1)];
        std::array::from_fn(|i| self.clips.cursor(self.clip, at(i)).into())
    }
}

/// The plain path, character by character, each with its own matrices.
pub(super) fn plain<'a>(bench: &'a Bench, count: usize) -> Contestant<'a> {
    let (rig, clip) = (&bench.asset.rig, bench.clip());
    let all = rig.all();
    let mut local = rig.rest_pose().clone();
    let mut models = vec![ModelPose::new(rig.len()); count];
    let frame = move |secs: &[f32]| {
        for (secs, model) in secs.iter().zip(&mut models) {
            sample(clip, f64::from(*secs), Wrap::Clamp, &all, &mut local);
            local_to_model(rig, &local, model);
        }
        black_box(&mut models);
    };
    Contestant {
        name: "ours, plain path".to_owned(),
        frame: Box::new(frame),
    }
}
