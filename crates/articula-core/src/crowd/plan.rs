//! What has to be evaluated in a frame, sorted into batches, and who shows what.

use crate::joint_lods::JointLods;
use crate::palette::PaletteMap;
use crate::pose_cache::BlendRecord;
use crate::simd::LANES;
use std::ops::Range;

/// Kinds of jobs at a level.
const KINDS: usize = 3;

/// What a job is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// One clip is evaluated.
    Clip,
    /// Two clips are evaluated and blended.
    Blend,
    /// Two cached palettes are blended.
    Cached,
}

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

/// Characters of one level whose palettes the GPU blends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordGroup {
    /// The level.
    pub level: usize,
    /// Its characters among the records.
    pub records: Range<usize>,
    /// Matrices of one palette.
    pub matrices: usize,
}

/// Who is shown in a frame, and where the palettes are.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawList {
    /// Who is shown, by level.
    pub groups: Vec<DrawGroup>,
    /// Who is shown, in the order of the groups.
    pub draws: Vec<Draw>,
    /// Who the GPU blends, by level; beside the draws.
    pub record_groups: Vec<RecordGroup>,
    /// Who the GPU blends, in the order of the groups: two palettes of the model's cache each.
    pub records: Vec<BlendRecord>,
    /// Batches that are to be evaluated, of up to eight poses each.
    pub batches: usize,
    /// Matrices that all batches together write.
    pub matrices: usize,
}

/// Up to eight poses that are evaluated together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Batch {
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
    /// Records as they come, with their levels.
    recorded: Vec<(u8, BlendRecord)>,
    batches: Vec<Batch>,
    drawn: DrawList,
}

impl Plan {
    pub(crate) fn new(characters: usize, levels: usize) -> Self {
        Self {
            characters,
            posers: vec![0; characters * levels * KINDS],
            jobs: vec![0; levels * KINDS],
            followers: vec![(0, 0); characters * levels],
            following: vec![0; levels],
            recorded: Vec::with_capacity(characters),
            batches: Vec::with_capacity(characters / LANES + levels * KINDS),
            drawn: DrawList {
                groups: Vec::with_capacity(levels),
                draws: Vec::with_capacity(characters),
                record_groups: Vec::with_capacity(levels),
                records: Vec::with_capacity(characters),
                batches: 0,
                matrices: 0,
            },
        }
    }

    /// Forgets the frame before.
    pub(crate) fn clear(&mut self) {
        self.jobs.fill(0);
        self.following.fill(0);
        self.recorded.clear();
    }

    /// A character is blended by the GPU.
    #[inline]
    pub(crate) fn record(&mut self, level: usize, record: BlendRecord) {
        self.recorded.push((level as u8, record));
    }

    /// Adds a job; gives its number among those of its level and kind.
    #[inline]
    pub(crate) fn add(&mut self, level: usize, kind: Kind, poser: Poser) -> u32 {
        let key = level * KINDS + kind as usize;
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
        self.drawn.draws.clear();
        self.drawn.groups.clear();
        let mut first_matrix = 0;
        for level in 0..self.following.len() {
            let matrices = palette.len(level);
            let first_draw = self.drawn.draws.len();
            let of_one_clip = first_matrix;
            for key in level * KINDS..(level + 1) * KINDS {
                let posers = &self.posers[key * self.characters..][..self.jobs[key] as usize];
                cut(&mut self.batches, posers.len(), key, first_matrix, matrices);
                for poser in posers {
                    if poser & LEADER == 0 {
                        self.drawn.draws.push(Draw {
                            character: *poser,
                            first_matrix: first_matrix as u32,
                        });
                    }
                    first_matrix += matrices;
                }
            }
            let count = self.following[level] as usize;
            for (character, job) in &self.followers[level * self.characters..][..count] {
                self.drawn.draws.push(Draw {
                    character: *character,
                    first_matrix: (of_one_clip + *job as usize * matrices) as u32,
                });
            }
            if self.drawn.draws.len() > first_draw {
                self.drawn.groups.push(DrawGroup {
                    level,
                    draws: first_draw..self.drawn.draws.len(),
                    matrices,
                });
            }
        }
        self.drawn.batches = self.batches.len();
        self.drawn.matrices = first_matrix;
        self.sort_records(palette);
    }

    fn sort_records(&mut self, palette: &PaletteMap) {
        let mut next = [0usize; JointLods::MAX_LEVELS];
        for (level, _) in &self.recorded {
            next[usize::from(*level)] += 1;
        }
        self.drawn.record_groups.clear();
        let mut first = 0;
        for (level, next) in next.iter_mut().enumerate().take(self.following.len()) {
            let count = std::mem::replace(next, first);
            if count > 0 {
                self.drawn.record_groups.push(RecordGroup {
                    level,
                    records: first..first + count,
                    matrices: palette.len(level),
                });
            }
            first += count;
        }
        self.drawn.records.resize(first, BlendRecord::default());
        for (level, record) in &self.recorded {
            let at = &mut next[usize::from(*level)];
            self.drawn.records[*at] = *record;
            *at += 1;
        }
    }

    pub(crate) fn batches(&self) -> &[Batch] {
        &self.batches
    }

    pub(crate) fn drawn(&self) -> &DrawList {
        &self.drawn
    }

    /// First matrix of a batch, or the number of all after the last.
    pub(crate) fn first_matrix(&self, batch: usize) -> usize {
        let at = self.batches.get(batch);
        at.map_or(self.drawn.matrices, |b| b.first_matrix as usize)
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
    /// Whether cached palettes are blended.
    pub(crate) fn is_cached(&self) -> bool {
        usize::from(self.key) % KINDS == Kind::Cached as usize
    }

    /// Level of its poses.
    pub(crate) fn level(&self) -> usize {
        usize::from(self.key) / KINDS
    }

    /// Number of its poses, 1 to 8.
    pub(crate) fn poses(&self) -> usize {
        usize::from(self.jobs)
    }
}
