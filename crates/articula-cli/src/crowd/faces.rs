//! Morph targets that a crowd shows: characters by morph level, and bytes of their weights.

use articula::crowd::{CrowdAsset, CrowdPlayer};
use serde::Serialize;

/// Morph target weights written in a frame.
#[derive(Debug, Clone, Default, Serialize)]
pub(crate) struct MorphUse {
    /// Characters whose weights are written, on average over frames.
    pub(crate) characters: f64,
    /// Bytes of the weights of the largest frame.
    pub(crate) bytes: usize,
    /// The morph levels, finest first; empty if no clip moves a morph target.
    pub(crate) levels: Vec<MorphLevelUse>,
}

/// Use of one morph level.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct MorphLevelUse {
    /// Number of morph targets that the level shows.
    pub(crate) targets: usize,
    /// Visible characters, on average over frames; those whose level has no morph targets count as
    /// showing none.
    pub(crate) characters: f64,
    /// Greatest error of the morph level over the clips, millimetres.
    pub(crate) error_mm: f32,
}

impl MorphUse {
    /// Formats the number of characters by targets shown.
    pub(crate) fn by_level(&self) -> String {
        let levels = self.levels.iter();
        let each = levels.map(|l| format!("{:.0} of {}", l.characters, l.targets));
        each.collect::<Vec<_>>().join(", ")
    }
}

/// Sums over frames.
#[derive(Debug)]
pub(crate) struct MorphTally {
    frames: usize,
    sets: usize,
    bytes: usize,
    /// Characters of each morph level, and those whose level shows no morph targets.
    levels: Vec<usize>,
    at_rest: usize,
}

impl MorphTally {
    pub(crate) fn new(asset: &CrowdAsset) -> Self {
        let morphs = asset.model().parts().morphs.as_ref();
        Self {
            frames: 0,
            sets: 0,
            bytes: 0,
            levels: vec![0; morphs.map_or(0, |m| m.lods().levels())],
            at_rest: 0,
        }
    }

    /// Adds an evaluated frame.
    pub(crate) fn add(&mut self, player: &CrowdPlayer) {
        let (crowd, model) = (player.crowd(), player.asset().model());
        self.frames += 1;
        self.sets += crowd.draw_list().morph_sets();
        self.bytes = self.bytes.max(size_of_val(player.morph_weights()));
        if self.levels.is_empty() {
            return;
        }
        let list = crowd.draw_list();
        let drawn = list.draws.iter().map(|d| d.character);
        for character in drawn.chain(list.recorded.iter().copied()) {
            match crowd.morph_level(model, character as usize) {
                Some(level) => self.levels[level] += 1,
                None => self.at_rest += 1,
            }
        }
    }

    /// Means over the frames.
    pub(crate) fn sums(&self, asset: &CrowdAsset) -> MorphUse {
        let mean = |count: usize| count as f64 / self.frames.max(1) as f64;
        let clips = asset.clips().len();
        let lods = asset.model().parts().morphs.as_ref().map(|m| m.lods());
        let levels = lods.map_or_else(Vec::new, |lods| {
            let error = |level: usize| {
                let errors = (0..clips).map(|clip| lods.errors_metres(clip)[level]);
                errors.fold(0.0, f32::max)
            };
            let each = self.levels.iter().enumerate();
            let mut levels: Vec<MorphLevelUse> = each
                .map(|(level, characters)| MorphLevelUse {
                    targets: lods.count(level),
                    characters: mean(*characters),
                    error_mm: 1e3 * error(level),
                })
                .collect();
            if let Some(last) = levels.last_mut().filter(|l| l.targets == 0) {
                last.characters += mean(self.at_rest);
            }
            levels
        });
        MorphUse {
            characters: mean(self.sets),
            bytes: self.bytes,
            levels,
        }
    }
}
