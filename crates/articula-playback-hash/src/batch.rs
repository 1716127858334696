//! Palettes of batches, in every form and storage, by the fastest instruction set of the platform.

use crate::fnv::Fnv;
use articula_core::batch::{BatchEvaluator, BatchPose};
use articula_core::{
    Backend, Clip, ClipSet, ClipStorage, JointLods, Mismatch, PaletteForm, PaletteMap, PaletteRows,
    Rig,
};

/// Characters of each form and storage.
const CHARACTERS: usize = 160;

pub(crate) fn evaluate(rig: &Rig, clips: &[Clip], sum: &mut Fnv) -> Result<(), Mismatch> {
    for storage in [ClipStorage::Float, ClipStorage::Short] {
        let set = ClipSet::new(rig, JointLods::whole(rig)?, clips, storage)?;
        let map = PaletteMap::joints(set.joint_lods());
        for form in [
            PaletteForm::Matrix,
            PaletteForm::HalfMatrix,
            PaletteForm::Rigid,
            PaletteForm::HalfRigid,
        ] {
            let evaluator = BatchEvaluator::new(&set, &map, form, Backend::best())?;
            let mut scratch = evaluator.scratch();
            // Palettes do not depend on how many are evaluated together.
            let lanes = evaluator.lanes();
            let all: Vec<BatchPose> = (0..CHARACTERS).map(|c| pose(&set, c)).collect();
            for shown in all.chunks(lanes) {
                let rows = shown.len() * evaluator.rows(0);
                if form.is_half() {
                    let mut halves = vec![[0; 4]; rows];
                    let out = PaletteRows::Half(&mut halves);
                    evaluator.evaluate(0, shown, out, &mut scratch);
                    let numbers = halves.as_flattened().iter();
                    numbers.for_each(|half| sum.bytes(&half.to_le_bytes()));
                } else {
                    let mut floats = vec![[0.0; 4]; rows];
                    let out = PaletteRows::Float(&mut floats);
                    evaluator.evaluate(0, shown, out, &mut scratch);
                    sum.floats(floats.as_flattened());
                }
            }
        }
    }
    Ok(())
}

/// A time of its own for each character; every third one fades between the clips.
fn pose(set: &ClipSet, character: usize) -> BatchPose {
    let secs = (character * 29 % 128) as f32 / 64.0;
    BatchPose {
        from: set.cursor(character % 2, secs),
        to: set.cursor(1 - character % 2, 2.0 - secs),
        fade: if character.is_multiple_of(3) {
            (character % 16) as f32 / 16.0
        } else {
            0.0
        },
    }
}
