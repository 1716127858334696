//! What has to be evaluated in a frame, sorted into batches, and who shows what.

use crate::palette::PaletteMap;
use crate::simd::LANES;
use std::ops::Range;

/// Kinds of jobs at a level: one clip, and two that are blended.
const KINDS: usize = 2;

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
    first_job: u32,
    first_matrix: u32,
    jobs: u8,
    /// Level and kind.
    key: u8,
}

/// Who a job evaluates: a character, or a leader of many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Poser {
    Character(usize),
    Leader(usize),
}

const LEADER: u32 = 1 << 31;

/// The plan of one frame. Jobs and followers are listed by level as they come, so nothing has to
/// be sorted.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    characters: usize,
    /// Who poses, `characters` entries for each level and kind.
    posers: Vec<u32>,
    jobs: Vec<u32>,
    /// Who follows which job of its level, `characters` entries for each level.
    followers: Vec<(u32, u32)>,
    following: Vec<u32>,
    batches: Vec<Batch>,
    draws: Vec<Draw>,
    groups: Vec<DrawGroup>,
    matrices: usize,
}

impl Plan {
    pub(crate) fn new(characters: usize, levels: usize) -> Self {
        Self {
            characters,
            posers: vec![0; characters * levels * KINDS],
            jobs: vec![0; levels * KINDS],
            followers: vec![(0, 0); characters * levels],
            following: vec![0; levels],
            batches: Vec::with_capacity(characters / LANES + levels * KINDS),
            draws: Vec::with_capacity(characters),
            groups: Vec::with_capacity(levels),
            matrices: 0,
        }
    }

    /// Forgets the frame before.
    pub(crate) fn clear(&mut self) {
        self.jobs.fill(0);
        self.following.fill(0);
    }

    /// Adds a job; gives its number among those of its level and kind.
    #[inline]
    pub(crate) fn add(&mut self, level: usize, fading: bool, poser: Poser) -> u32 {
        let key = level * KINDS + usize::from(fading);
        let at = self.jobs[key];
        self.jobs[key] += 1;
        self.posers[key * self.characters + at as usize] = match poser {
            Poser::Character(c) => c as u32,
            Poser::Leader(l) => l as u32 | LEADER,
        };
        at
    }

    /// A character shows what a job of one clip at its level gives.
    #[inline]
    pub(crate) fn follow(&mut self, level: usize, character: usize, job: u32) {
        let at = self.following[level] as usize;
        self.following[level] += 1;
        self.followers[level * self.characters + at] = (character as u32, job);
    }

    /// Cuts the jobs into batches of one level and kind, and says who shows what.
    pub(crate) fn finish(&mut self, palette: &PaletteMap) {
        self.batches.clear();
        self.draws.clear();
        self.groups.clear();
        let mut first_matrix = 0;
        for level in 0..self.following.len() {
            let matrices = palette.len(level);
            let first_draw = self.draws.len();
            let of_one_clip = first_matrix;
            for key in level * KINDS..(level + 1) * KINDS {
                let posers = &self.posers[key * self.characters..][..self.jobs[key] as usize];
                cut(&mut self.batches, posers.len(), key, first_matrix, matrices);
                for poser in posers {
                    if poser & LEADER == 0 {
                        self.draws.push(Draw {
                            character: *poser,
                            first_matrix: first_matrix as u32,
                        });
                    }
                    first_matrix += matrices;
                }
            }
            let count = self.following[level] as usize;
            for (character, job) in &self.followers[level * self.characters..][..count] {
                self.draws.push(Draw {
                    character: *character,
                    first_matrix: (of_one_clip + *job as usize * matrices) as u32,
                });
            }
            if self.draws.len() > first_draw {
                self.groups.push(DrawGroup {
                    level,
                    draws: first_draw..self.draws.len(),
                    matrices,
                });
            }
        }
        self.matrices = first_matrix;
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
        let first = usize::from(batch.key) * self.characters + batch.first_job as usize;
        let posers = &self.posers[first..first + usize::from(batch.jobs)];
        posers.iter().map(|&p| match p & LEADER {
            0 => Poser::Character(p as usize),
            _ => Poser::Leader((p & !LEADER) as usize),
        })
    }
}

/// Batches of jobs of one level and kind.
fn cut(batches: &mut Vec<Batch>, jobs: usize, key: usize, first_matrix: usize, matrices: usize) {
    for first in (0..jobs).step_by(LANES) {
        batches.push(Batch {
            first_job: first as u32,
            first_matrix: (first_matrix + first * matrices) as u32,
            jobs: (jobs - first).min(LANES) as u8,
            key: key as u8,
        });
    }
}

impl Batch {
    /// Level of its poses.
    pub fn level(&self) -> usize {
        usize::from(self.key) / KINDS
    }

    /// Number of its poses, 1 to 8.
    pub fn poses(&self) -> usize {
        usize::from(self.jobs)
    }
}
