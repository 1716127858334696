//! What has to be evaluated in a frame, sorted into batches, and who shows what.

use crate::palette::PaletteMap;
use crate::simd::LANES;
use std::ops::Range;

/// No job: the character is not shown.
const NONE: u32 = u32::MAX;

/// One character that is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Draw {
    /// Index of the character.
    pub character: u32,
    /// Its palette: index of the first matrix among all that are written in this frame.
    pub first_matrix: u32,
}

/// Characters of one level: they have the same mesh and palettes of the same length.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DrawGroup {
    /// The level.
    pub level: usize,
    /// Its characters among the draws.
    pub draws: Range<usize>,
    /// Matrices of one palette.
    pub matrices: usize,
}

/// Up to eight poses that are evaluated together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Batch {
    pub(crate) first_job: u32,
    pub(crate) first_matrix: u32,
    pub(crate) jobs: u8,
    pub(crate) level: u8,
}

/// Who a job evaluates: a character, or a leader of many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Poser {
    Character(usize),
    Leader(usize),
}

const LEADER: u32 = 1 << 31;

/// The plan of one frame.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// Level and kind of each job: `2 * level`, one more for a cross-fade.
    keys: Vec<u8>,
    posers: Vec<u32>,
    /// Level and job of each character.
    shown: Vec<(u8, u32)>,
    sorted: Vec<u32>,
    matrix_of: Vec<u32>,
    batches: Vec<Batch>,
    draws: Vec<Draw>,
    groups: Vec<DrawGroup>,
    matrices: usize,
}

impl Plan {
    pub(crate) fn new(characters: usize, levels: usize) -> Self {
        Self {
            keys: Vec::with_capacity(characters),
            posers: Vec::with_capacity(characters),
            shown: Vec::with_capacity(characters),
            sorted: Vec::with_capacity(characters),
            matrix_of: Vec::with_capacity(characters),
            batches: Vec::with_capacity(characters / LANES + 2 * levels),
            draws: Vec::with_capacity(characters),
            groups: Vec::with_capacity(levels),
            matrices: 0,
        }
    }

    /// Forgets the frame before.
    pub(crate) fn clear(&mut self) {
        self.keys.clear();
        self.posers.clear();
        self.shown.clear();
    }

    /// The next character is not shown.
    #[inline]
    pub(crate) fn hide(&mut self) {
        self.shown.push((0, NONE));
    }

    /// The next character shows what a job gives.
    #[inline]
    pub(crate) fn show(&mut self, level: usize, job: u32) {
        self.shown.push((level as u8, job));
    }

    /// Adds a job; gives its number.
    #[inline]
    pub(crate) fn add(&mut self, level: usize, fading: bool, poser: Poser) -> u32 {
        self.keys.push(level as u8 * 2 + u8::from(fading));
        self.posers.push(match poser {
            Poser::Character(c) => c as u32,
            Poser::Leader(l) => l as u32 | LEADER,
        });
        self.keys.len() as u32 - 1
    }

    /// Sorts jobs into batches of one level and kind, and characters into groups of one level.
    pub(crate) fn sort(&mut self, palette: &PaletteMap, levels: usize) {
        let mut counts = [0u32; 2 * crate::ladder::MAX_LEVELS];
        for key in &self.keys {
            counts[usize::from(*key)] += 1;
        }
        let mut next_job = counts;
        let (mut first_job, mut first_matrix) = (0, 0);
        let mut matrix_from = [0u32; 2 * crate::ladder::MAX_LEVELS];
        self.batches.clear();
        for key in 0..2 * levels {
            let count = counts[key];
            let matrices = palette.len(key / 2) as u32;
            next_job[key] = first_job;
            matrix_from[key] = first_matrix;
            for done in (0..count).step_by(LANES) {
                self.batches.push(Batch {
                    first_job: first_job + done,
                    first_matrix: first_matrix + done * matrices,
                    jobs: (count - done).min(LANES as u32) as u8,
                    level: (key / 2) as u8,
                });
            }
            first_job += count;
            first_matrix += count * matrices;
        }
        self.matrices = first_matrix as usize;
        let start = next_job;
        self.sorted.resize(self.keys.len(), 0);
        self.matrix_of.resize(self.keys.len(), 0);
        for (job, key) in self.keys.iter().enumerate() {
            let key = usize::from(*key);
            let at = next_job[key];
            next_job[key] += 1;
            self.sorted[at as usize] = self.posers[job];
            let matrices = palette.len(key / 2) as u32;
            self.matrix_of[job] = matrix_from[key] + (at - start[key]) * matrices;
        }
        self.group(palette, levels);
    }

    fn group(&mut self, palette: &PaletteMap, levels: usize) {
        let mut next = [0usize; crate::ladder::MAX_LEVELS];
        for (level, job) in &self.shown {
            next[usize::from(*level)] += usize::from(*job != NONE);
        }
        self.groups.clear();
        let mut first = 0;
        for (level, next) in next.iter_mut().enumerate().take(levels) {
            let count = std::mem::replace(next, first);
            if count > 0 {
                self.groups.push(DrawGroup {
                    level,
                    draws: first..first + count,
                    matrices: palette.len(level),
                });
            }
            first += count;
        }
        let nobody = Draw {
            character: 0,
            first_matrix: 0,
        };
        self.draws.resize(first, nobody);
        for (character, (level, job)) in self.shown.iter().enumerate() {
            if *job != NONE {
                let at = &mut next[usize::from(*level)];
                self.draws[*at] = Draw {
                    character: character as u32,
                    first_matrix: self.matrix_of[*job as usize],
                };
                *at += 1;
            }
        }
    }

    pub(crate) fn batches(&self) -> &[Batch] {
        &self.batches
    }

    pub(crate) fn draws(&self) -> &[Draw] {
        &self.draws
    }

    pub(crate) fn groups(&self) -> &[DrawGroup] {
        &self.groups
    }

    pub(crate) fn matrices(&self) -> usize {
        self.matrices
    }

    /// First matrix of a batch, or the number of all after the last.
    pub(crate) fn first_matrix(&self, batch: usize) -> usize {
        let at = self.batches.get(batch);
        at.map_or(self.matrices, |b| b.first_matrix as usize)
    }

    /// Who the jobs of a batch evaluate.
    pub(crate) fn posers(&self, batch: &Batch) -> impl Iterator<Item = Poser> + '_ {
        let first = batch.first_job as usize;
        let posers = &self.sorted[first..first + usize::from(batch.jobs)];
        posers.iter().map(|&p| match p & LEADER {
            0 => Poser::Character(p as usize),
            _ => Poser::Leader((p & !LEADER) as usize),
        })
    }
}
