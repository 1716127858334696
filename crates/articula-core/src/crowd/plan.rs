//! Evaluation plan of a frame: poses sorted into batches, and the palette of each character.

use crate::joint_lods::JointLods;
use crate::palette::PaletteMap;
use crate::pose_cache::BlendRecord;
use crate::simd::LANES;
use std::ops::Range;

/// Number of kinds of jobs at a level.
const KINDS: usize = 3;

/// Kind of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// One clip is evaluated.
    Clip,
    /// Two clips are evaluated and blended.
    Blend,
    /// Two cached palettes are blended.
    Cached,
}

/// One visible character and its palette.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Draw {
    /// Index of the character.
    pub character: u32,
    /// Index of the first matrix of its palette, among all matrices written in this frame.
    pub first_matrix: u32,
}

/// Draws of one level: their characters have the same mesh and palettes of the same length.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DrawGroup {
    /// Level of the characters.
    pub level: usize,
    /// Range of [`DrawList::draws`].
    pub draws: Range<usize>,
    /// Number of matrices of one palette.
    pub matrices: usize,
}

/// Blend records of one level: for characters whose palettes the GPU blends from cached ones.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordGroup {
    /// Level of the characters.
    pub level: usize,
    /// Range of [`DrawList::records`].
    pub records: Range<usize>,
    /// Number of matrices of one palette.
    pub matrices: usize,
}

/// Visible characters of a frame, and where their palettes are.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawList {
    /// Draws grouped by level.
    pub groups: Vec<DrawGroup>,
    /// Visible characters with an evaluated palette, in the order of the groups.
    pub draws: Vec<Draw>,
    /// Records grouped by level; their characters are not among the draws.
    pub record_groups: Vec<RecordGroup>,
    /// Characters that the GPU blends, each from two palettes of the model's cache, in the order of
    /// the groups.
    pub records: Vec<BlendRecord>,
    /// Number of batches to evaluate, of up to eight poses each.
    pub batches: usize,
    /// Number of matrices that all batches write.
    pub matrices: usize,
    /// Number of draws, from the first on, whose level shows morph targets: the weights of draw `i`
    /// are set `i` of [`Crowd::evaluate_morphs`](super::Crowd::evaluate_morphs). The faces of later
    /// draws rest, with the mesh's default weights.
    pub morph_draws: usize,
    /// Number of records, from the first on, whose level shows morph targets: the weights of record
    /// `i` are set `morph_draws + i`.
    pub morph_records: usize,
}

impl DrawList {
    /// Number of sets of morph target weights of the frame, one for each character whose level
    /// shows them.
    pub fn morph_sets(&self) -> usize {
        self.morph_draws + self.morph_records
    }

    /// Character of a set of morph target weights.
    pub(crate) fn character_of(&self, set: usize) -> usize {
        let draw = self.draws[..self.morph_draws].get(set);
        let record = || self.records[set - self.morph_draws].character;
        draw.map_or_else(record, |d| d.character) as usize
    }
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

/// Pose that a job evaluates: that of one character, or a shared one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Poser {
    Character(usize),
    Leader(usize),
}

const LEADER: u32 = 1 << 31;

/// The plan of one frame. Jobs and characters that share a pose are listed by level as they are
/// added, so nothing has to be sorted.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    characters: usize,
    /// Poses to evaluate, `characters` entries for each level and kind.
    posers: Vec<u32>,
    jobs: Vec<u32>,
    /// Characters that share a pose and the job of their level that evaluates it, `characters`
    /// entries for each level.
    followers: Vec<(u32, u32)>,
    following: Vec<u32>,
    /// Records in the order added, with their levels.
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
                morph_draws: 0,
                morph_records: 0,
            },
        }
    }

    /// Clears the plan of the frame before.
    pub(crate) fn clear(&mut self) {
        self.jobs.fill(0);
        self.following.fill(0);
        self.recorded.clear();
    }

    /// Adds a character that the GPU blends.
    #[inline]
    pub(crate) fn record(&mut self, level: usize, record: BlendRecord) {
        self.recorded.push((level as u8, record));
    }

    /// Adds a job; returns its index among those of its level and kind.
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

    /// Adds a character that shows the pose of a [`Kind::Clip`] job of its level.
    #[inline]
    pub(crate) fn follow(&mut self, level: usize, character: usize, job: u32) {
        let at = self.following[level] as usize;
        self.following[level] += 1;
        self.followers[level * self.characters + at] = (character as u32, job);
    }

    /// Divides the jobs into batches of one level and kind, and fills the draw list. The first
    /// `morph_levels` levels show morph targets.
    pub(crate) fn finish(&mut self, palette: &PaletteMap, morph_levels: usize) {
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
        let drawn = &mut self.drawn;
        let groups = drawn.groups.iter().filter(|g| g.level < morph_levels);
        drawn.morph_draws = groups.map(|g| g.draws.len()).sum();
        let groups = drawn.record_groups.iter();
        let groups = groups.filter(|g| g.level < morph_levels);
        drawn.morph_records = groups.map(|g| g.records.len()).sum();
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

    pub(crate) fn draw_list(&self) -> &DrawList {
        &self.drawn
    }

    /// Index of the first matrix of a batch, or the number of all matrices beyond the last one.
    pub(crate) fn first_matrix(&self, batch: usize) -> usize {
        let at = self.batches.get(batch);
        at.map_or(self.drawn.matrices, |b| b.first_matrix as usize)
    }

    /// Poses that a batch evaluates.
    pub(crate) fn posers(&self, batch: &Batch) -> impl Iterator<Item = Poser> + '_ {
        let first = usize::from(batch.key) * self.characters + batch.first_job as usize;
        let posers = &self.posers[first..first + usize::from(batch.jobs)];
        posers.iter().map(|&p| match p & LEADER {
            0 => Poser::Character(p as usize),
            _ => Poser::Leader((p & !LEADER) as usize),
        })
    }
}

/// Adds the batches of the jobs of one level and kind.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_set::JointSet;
    use crate::rig::tests::rig_of;
    use glam::Vec3;

    #[test]
    fn a_plan_by_hand() {
        let rig = rig_of(&[
            (None, Vec3::ZERO, 0),
            (Some(0), Vec3::Y, 0),
            (Some(1), Vec3::Y, 0),
        ]);
        // Three matrices at the first level, one at the second.
        let sets = [JointSet::first(1)];
        let joint_lods = JointLods::of_sets(&rig, &sets, rig.rest_pose()).unwrap();
        let palette = PaletteMap::joints(&joint_lods);
        let mut plan = Plan::new(30, 2);
        for _ in 0..2 {
            plan.clear();
            for character in 10..19 {
                plan.add(1, Kind::Clip, Poser::Character(character));
            }
            assert_eq!(plan.add(0, Kind::Clip, Poser::Character(5)), 0);
            assert_eq!(plan.add(0, Kind::Blend, Poser::Character(7)), 0);
            let job = plan.add(0, Kind::Clip, Poser::Leader(4));
            assert_eq!(job, 1);
            plan.follow(0, 8, job);
            plan.follow(0, 9, job);
            plan.add(1, Kind::Cached, Poser::Character(20));
            let record = |character| BlendRecord {
                character,
                ..BlendRecord::default()
            };
            plan.record(1, record(21));
            plan.record(0, record(22));
            plan.record(1, record(23));
            // Without levels that show morph targets, with the first one, and with all.
            for (levels, sets) in [(0, (0, 0)), (2, (14, 3)), (1, (4, 1))] {
                plan.finish(&palette, levels);
                let list = plan.draw_list();
                assert_eq!((list.morph_draws, list.morph_records), sets);
            }
            let list = plan.draw_list();
            let characters: Vec<usize> = (0..5).map(|set| list.character_of(set)).collect();
            assert_eq!(characters, [5, 7, 8, 9, 22]);
            // At the first level the matrices of clips, then of blends; shared poses are no draws.
            let mut expected = vec![(5, 0), (7, 6), (8, 3), (9, 3)];
            expected.extend((0..10).map(|i| (if i < 9 { 10 + i } else { 20 }, 9 + i)));
            let draws = list.draws.iter().map(|d| (d.character, d.first_matrix));
            assert_eq!(draws.collect::<Vec<_>>(), expected);
            let groups = list.groups.iter();
            let groups = groups.map(|g| (g.level, g.draws.clone(), g.matrices));
            assert_eq!(groups.collect::<Vec<_>>(), [(0, 0..4, 3), (1, 4..14, 1)]);
            assert_eq!((list.batches, list.matrices), (5, 19));
            let records: Vec<u32> = list.records.iter().map(|r| r.character).collect();
            assert_eq!(records, [22, 21, 23]);
            let groups = list.record_groups.iter();
            let groups = groups.map(|g| (g.level, g.records.clone(), g.matrices));
            assert_eq!(groups.collect::<Vec<_>>(), [(0, 0..1, 3), (1, 1..3, 1)]);
            let batches = plan.batches().iter();
            let batches = batches.map(|b| (b.level(), b.poses(), b.is_cached()));
            let expected = [(0, 2, false), (0, 1, false), (1, 8, false), (1, 1, false)];
            let expected: Vec<_> = expected.into_iter().chain([(1, 1, true)]).collect();
            assert_eq!(batches.collect::<Vec<_>>(), expected);
            let first: Vec<usize> = (0..7).map(|b| plan.first_matrix(b)).collect();
            assert_eq!(first, [0, 6, 9, 17, 18, 19, 19]);
            let posers: Vec<Poser> = plan.posers(&plan.batches()[0]).collect();
            assert_eq!(posers, [Poser::Character(5), Poser::Leader(4)]);
            let posers: Vec<Poser> = plan.posers(&plan.batches()[3]).collect();
            assert_eq!(posers, [Poser::Character(18)]);
        }
    }
}
