//! Morph targets that a crowd shows: characters by morph level, and bytes of their weights.

use super::asset::CrowdAsset;
use super::player::CrowdPlayer;
use articula_core::crowd::DrawKind;
use serde::Serialize;

/// Morph target weights written in a frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct MorphUse {
    /// Characters whose weights are written, on average over frames.
    pub characters: f64,
    /// Bytes of the weights of the largest frame.
    pub bytes: usize,
    /// The morph levels, those first that show most targets; empty if no clip moves a morph target.
    pub levels: Vec<MorphLevelUse>,
}

/// Use of one morph level, or of those of several characters that show as many targets.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MorphLevelUse {
    /// Number of morph targets that the level shows.
    pub targets: usize,
    /// Visible characters, on average over frames; those whose level has no morph targets count as
    /// showing none.
    pub characters: f64,
    /// Greatest error of the morph level over the clips, millimetres.
    pub error_mm: f32,
}

impl MorphUse {
    /// The use of all characters of a cast; `bytes` are those of the largest frame.
    pub(super) fn of(cast: impl Iterator<Item = Self>, bytes: usize) -> Self {
        let mut all = Self {
            bytes,
            ..Self::default()
        };
        for character in cast {
            all.characters += character.characters;
            for level in character.levels {
                let mut known = all.levels.iter_mut();
                match known.find(|l| l.targets == level.targets) {
                    Some(known) => {
                        known.characters += level.characters;
                        known.error_mm = known.error_mm.max(level.error_mm);
                    }
                    None => all.levels.push(level),
                }
            }
        }
        all.levels.sort_by_key(|l| std::cmp::Reverse(l.targets));
        all
    }
}

/// Sums over the frames of the crowd of one character.
#[derive(Debug)]
pub(super) struct MorphTally {
    frames: usize,
    sets: usize,
    /// Characters of each morph level, and those whose level shows no morph targets.
    levels: Vec<usize>,
    at_rest: usize,
}

impl MorphTally {
    pub(super) fn new(asset: &CrowdAsset) -> Self {
        let morphs = asset.model().parts().morphs.as_ref();
        Self {
            frames: 0,
            sets: 0,
            levels: vec![0; morphs.map_or(0, |m| m.lods().levels())],
            at_rest: 0,
        }
    }

    /// Adds an evaluated frame.
    pub(super) fn add(&mut self, player: &CrowdPlayer) {
        let (crowd, model) = (player.crowd(), player.asset().model());
        self.frames += 1;
        self.sets += crowd.draw_list().morph_sets();
        if self.levels.is_empty() {
            return;
        }
        let list = crowd.draw_list();
        let meshes = [DrawKind::Palette, DrawKind::Record, DrawKind::Step];
        for character in meshes.into_iter().flat_map(|kind| list.characters(kind)) {
            match crowd.morph_level(model, *character as usize) {
                Some(level) => self.levels[level] += 1,
                None => self.at_rest += 1,
            }
        }
    }

    /// Means over the frames, without bytes.
    pub(super) fn means(&self, asset: &CrowdAsset) -> MorphUse {
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
            bytes: 0,
            levels,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_of_several_characters_by_targets_shown() {
        let of = |characters: f64, levels: &[(usize, f64, f32)]| MorphUse {
            characters,
            bytes: 0,
            levels: levels
                .iter()
                .map(|&(targets, characters, error_mm)| MorphLevelUse {
                    targets,
                    characters,
                    error_mm,
                })
                .collect(),
        };
        let cast = [
            of(3.0, &[(17, 1.0, 0.0), (4, 2.0, 1.0), (0, 5.0, 3.0)]),
            of(0.0, &[]),
            of(4.5, &[(9, 4.5, 0.0), (0, 1.5, 7.0)]),
        ];
        let all = MorphUse::of(cast.into_iter(), 96);
        assert_eq!((all.characters, all.bytes), (7.5, 96));
        let shown = all.levels.iter().map(|l| (l.targets, l.characters));
        assert_eq!(
            shown.collect::<Vec<_>>(),
            [(17, 1.0), (9, 4.5), (4, 2.0), (0, 6.5)]
        );
        assert_eq!(all.levels[3].error_mm, 7.0);
    }
}
