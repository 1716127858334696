//! Evaluation plan of a frame: characters sorted by level and source of their pose, divided into
//! batches, and the palette of each.

use super::keys::{KEYS, KINDS, Kind, SectionKeys, rest_row};
use super::share::Leader;
use crate::joint_lods::JointLods;
use crate::palette::PaletteMap;
use crate::simd::LANES;
use std::ops::Range;

/// One visible character and its palette.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub struct Draw {
    /// Index of the character.
    pub character: u32,
    /// Index of the first matrix of its palette: among all matrices written in this frame, or, of a
    /// step, among those of the cache.
    pub first_matrix: u32,
}

/// One visible character that is shown by an impostor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub struct ImpostorDraw {
    /// Index of the character.
    pub character: u32,
    /// Index of the pose among those of all clips.
    pub pose: u32,
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
    /// Range of [`DrawList::recorded`], and of the records.
    pub records: Range<usize>,
    /// Number of matrices of one palette.
    pub matrices: usize,
}

/// Stepped characters of one level: each shows a cached palette as it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StepGroup {
    /// Level of the characters.
    pub level: usize,
    /// Range of [`DrawList::stepped`], and of their draws.
    pub steps: Range<usize>,
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
    /// the groups; [`Crowd::evaluate_records`](super::Crowd::evaluate_records) writes their records.
    pub recorded: Vec<u32>,
    /// Steps grouped by level; their characters are not among the draws.
    pub step_groups: Vec<StepGroup>,
    /// Characters that show the palette of the model's cache that is nearest in time, in the order of
    /// the groups; [`Crowd::evaluate_steps`](super::Crowd::evaluate_steps) writes their draws.
    pub stepped: Vec<u32>,
    /// Characters that are shown by impostors, which have one size and no levels;
    /// [`Crowd::evaluate_impostors`](super::Crowd::evaluate_impostors) writes their draws.
    pub impostors: Vec<u32>,
    /// Number of batches to evaluate, of up to [`lanes`](crate::batch::BatchEvaluator::lanes) poses
    /// each.
    pub batches: usize,
    /// Number of matrices that all batches write.
    pub matrices: usize,
    /// Number of draws, from the first on, with morph target weights: those of draw `i` are set `i` of
    /// [`Crowd::evaluate_morphs`](super::Crowd::evaluate_morphs). The faces of later draws rest, with
    /// the mesh's default weights, and so do some before the last draw that shows morph targets.
    pub morph_draws: usize,
    /// Number of records, from the first on, with morph target weights: those of record `i` are set
    /// `morph_draws + i`.
    pub morph_records: usize,
    /// Number of steps, from the first on, with morph target weights: those of step `i` are set
    /// `morph_draws + morph_records + i`.
    pub morph_steps: usize,
}

impl DrawList {
    /// Number of sets of morph target weights of the frame.
    pub fn morph_sets(&self) -> usize {
        self.morph_draws + self.morph_records + self.morph_steps
    }

    /// Adds draws to the group of their level, which is the last one.
    fn draw_as(&mut self, level: usize, draws: Range<usize>, matrices: usize) {
        match self.groups.last_mut().filter(|g| g.level == level) {
            Some(group) => group.draws.end = draws.end,
            None => self.groups.push(DrawGroup {
                level,
                draws,
                matrices,
            }),
        }
    }

    /// Adds records to the group of their level, which is the last one.
    fn record_as(&mut self, level: usize, records: Range<usize>, matrices: usize) {
        match self.record_groups.last_mut().filter(|g| g.level == level) {
            Some(group) => group.records.end = records.end,
            None => self.record_groups.push(RecordGroup {
                level,
                records,
                matrices,
            }),
        }
    }

    /// Adds steps to the group of their level, which is the last one.
    fn step_as(&mut self, level: usize, steps: Range<usize>, matrices: usize) {
        match self.step_groups.last_mut().filter(|g| g.level == level) {
            Some(group) => group.steps.end = steps.end,
            None => self.step_groups.push(StepGroup {
                level,
                steps,
                matrices,
            }),
        }
    }

    /// Has all draws, records and steps so far show morph targets, if any of this level does.
    fn show_morphs(&mut self, level: usize) {
        if let Some(group) = self.groups.last().filter(|g| g.level == level) {
            self.morph_draws = group.draws.end;
        }
        if let Some(group) = self.record_groups.last().filter(|g| g.level == level) {
            self.morph_records = group.records.end;
        }
        if let Some(group) = self.step_groups.last().filter(|g| g.level == level) {
            self.morph_steps = group.steps.end;
        }
    }

    /// Character of a set of morph target weights.
    pub(crate) fn character_of(&self, set: usize) -> usize {
        let character = if let Some(draw) = self.draws[..self.morph_draws].get(set) {
            draw.character
        } else {
            let set = set - self.morph_draws;
            let record = self.recorded[..self.morph_records].get(set);
            *record.unwrap_or_else(|| &self.stepped[set - self.morph_records])
        };
        character as usize
    }
}

/// Poses that are evaluated together, up to as many as the backend has lanes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Batch {
    /// Index of the first among the draws, or among the shared poses by level.
    first: u32,
    first_matrix: u32,
    poses: u8,
    level: u8,
    jobs: Jobs,
}

/// Kind of the poses of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Jobs {
    /// Evaluated for one character each.
    Own,
    /// Blended from cached ones, for one character each.
    Cached,
    /// Evaluated for several characters.
    Shared,
}

/// Pose that a batch evaluates: that of one character, or a shared one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Poser {
    Character(usize),
    Leader(usize),
}

/// Numbers of characters and poses of one level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct LevelCounts {
    /// Poses evaluated for one character, those that blend two clips included.
    pub(crate) own: usize,
    pub(crate) blended: usize,
    /// Poses evaluated for several characters, and these characters.
    pub(crate) leaders: usize,
    pub(crate) followers: usize,
    /// Palettes blended from cached ones, records of such blends, and cached palettes shown as they
    /// are.
    pub(crate) cached: usize,
    pub(crate) recorded: usize,
    pub(crate) stepped: usize,
    /// Characters shown by impostors.
    pub(crate) impostors: usize,
}

/// Where the next character of one level and source goes.
#[derive(Debug, Clone, Copy, Default)]
struct Slot {
    at: u32,
    matrix: u32,
    /// Matrices of a palette.
    step: u32,
}

/// The places of a plan while it is made.
struct Room {
    /// For each level and source the number of its characters, then where the next one goes.
    slots: [Slot; KEYS],
    /// The same of shared poses: numbers by level, and where the next one goes.
    leaders: [usize; JointLods::MAX_LEVELS],
    leader_slots: [Slot; JointLods::MAX_LEVELS],
    /// Draws, records, steps, impostors, matrices and shared poses that have a place.
    draws: usize,
    records: usize,
    steps: usize,
    impostors: usize,
    matrices: usize,
    shared: usize,
    /// Most poses of a batch.
    lanes: usize,
}

impl Room {
    fn counted<'a>(
        sections: impl Iterator<Item = &'a SectionKeys>,
        leaders: &[Leader],
        lanes: usize,
    ) -> Self {
        let mut room = Self {
            slots: [Slot::default(); KEYS],
            leaders: [0; JointLods::MAX_LEVELS],
            leader_slots: [Slot::default(); JointLods::MAX_LEVELS],
            draws: 0,
            records: 0,
            steps: 0,
            impostors: 0,
            matrices: 0,
            shared: 0,
            lanes,
        };
        for section in sections {
            for (slot, count) in room.slots.iter_mut().zip(section.counts()) {
                slot.at += u32::from(*count);
            }
        }
        for leader in leaders {
            room.leaders[usize::from(leader.level)] += 1;
        }
        room
    }

    /// Adds batches like `batch` for so many poses, from a first pose on, with palettes of so many
    /// matrices, each of as many poses as there are lanes at most.
    fn cut(
        &self,
        batches: &mut Vec<Batch>,
        batch: Batch,
        (first_pose, poses): (usize, usize),
        matrices: usize,
    ) {
        for first in (0..poses).step_by(self.lanes) {
            batches.push(Batch {
                first: (first_pose + first) as u32,
                first_matrix: (self.matrices + first * matrices) as u32,
                poses: (poses - first).min(self.lanes) as u8,
                ..batch
            });
        }
    }
}

/// Records or steps of one row of keys, which are in the order of the sections. A group of a level has
/// up to two.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) level: usize,
    /// Range of their list.
    pub(crate) at: Range<usize>,
}

/// The plan of one frame.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    counts: Vec<LevelCounts>,
    /// Shared poses by level, and the first matrix of each in the order of the shared poses.
    leaders: Vec<u32>,
    leader_matrices: Vec<u32>,
    batches: Vec<Batch>,
    record_runs: Vec<Run>,
    step_runs: Vec<Run>,
    drawn: DrawList,
}

impl Plan {
    pub(crate) fn new(characters: usize, levels: usize) -> Self {
        Self {
            counts: vec![LevelCounts::default(); levels],
            leaders: Vec::with_capacity(characters),
            leader_matrices: Vec::with_capacity(characters),
            batches: Vec::with_capacity(characters / LANES + 2 * levels * KINDS),
            record_runs: Vec::with_capacity(2 * levels),
            step_runs: Vec::with_capacity(2 * levels),
            drawn: DrawList {
                groups: Vec::with_capacity(levels),
                draws: Vec::with_capacity(characters),
                record_groups: Vec::with_capacity(levels),
                recorded: Vec::with_capacity(characters),
                step_groups: Vec::with_capacity(levels),
                stepped: Vec::with_capacity(characters),
                impostors: Vec::with_capacity(characters),
                batches: 0,
                matrices: 0,
                morph_draws: 0,
                morph_records: 0,
                morph_steps: 0,
            },
        }
    }

    /// Joins the characters of the sections, each sorted by level and source, with up to `lanes` poses
    /// in a batch. The first `morph_levels` levels show morph targets. O(characters).
    pub(crate) fn make<'a>(
        &mut self,
        sections: impl Iterator<Item = &'a SectionKeys> + Clone,
        leaders: &[Leader],
        palette: &PaletteMap,
        lanes: usize,
        morph_levels: usize,
    ) {
        let mut room = Room::counted(sections.clone(), leaders, lanes);
        self.batches.clear();
        self.drawn.groups.clear();
        self.drawn.record_groups.clear();
        self.drawn.step_groups.clear();
        self.record_runs.clear();
        self.step_runs.clear();
        self.drawn.morph_draws = 0;
        self.drawn.morph_records = 0;
        self.drawn.morph_steps = 0;
        for level in 0..self.counts.len() {
            self.counts[level] = LevelCounts::default();
            self.lay_out(level, level, palette.len(level), &mut room);
            if level < morph_levels {
                self.drawn.show_morphs(level);
                self.lay_out(level, rest_row(level), palette.len(level), &mut room);
            }
        }
        self.place_leaders(leaders, &mut room.leader_slots);
        self.place(sections, &mut room);
        self.drawn.batches = self.batches.len();
        self.drawn.matrices = room.matrices;
    }

    /// Gives the characters and poses of a row of keys, whose palettes have so many matrices, their
    /// places behind those of the rows before. The row is of a level with faces as they are shown, or
    /// at rest.
    fn lay_out(&mut self, level: usize, row: usize, matrices: usize, room: &mut Room) {
        let counts = [0, 1, 2, 3, 4, 5, 6].map(|kind| room.slots[row * KINDS + kind].at as usize);
        let [clip, blend, cached, follow, record, step, impostors] = counts;
        // Shared poses are those of the level, whatever the faces.
        let has_leaders = row == level;
        let leaders = if has_leaders { room.leaders[level] } else { 0 };
        let sums = &mut self.counts[level];
        sums.own += clip + blend;
        sums.blended += blend;
        sums.leaders += leaders;
        sums.followers += follow;
        sums.cached += cached;
        sums.recorded += record;
        sums.stepped += step;
        sums.impostors += impostors;
        let mut batch = Batch {
            first: 0,
            first_matrix: 0,
            poses: 0,
            level: level as u8,
            jobs: Jobs::Own,
        };
        let first_draw = room.draws;
        for (kind, count) in [
            (Kind::Clip, clip),
            (Kind::Blend, blend),
            (Kind::Cached, cached),
        ] {
            room.slots[row * KINDS + kind as usize] = Slot {
                at: room.draws as u32,
                matrix: room.matrices as u32,
                step: matrices as u32,
            };
            batch.jobs = match kind {
                Kind::Cached => Jobs::Cached,
                _ => Jobs::Own,
            };
            room.cut(&mut self.batches, batch, (room.draws, count), matrices);
            room.draws += count;
            room.matrices += count * matrices;
        }
        batch.jobs = Jobs::Shared;
        room.cut(&mut self.batches, batch, (room.shared, leaders), matrices);
        if has_leaders {
            room.leader_slots[level] = Slot {
                at: room.shared as u32,
                matrix: room.matrices as u32,
                step: matrices as u32,
            };
        }
        room.shared += leaders;
        room.matrices += leaders * matrices;
        room.slots[row * KINDS + Kind::Follow as usize].at = room.draws as u32;
        room.draws += follow;
        if room.draws > first_draw {
            self.drawn.draw_as(level, first_draw..room.draws, matrices);
        }
        room.slots[row * KINDS + Kind::Record as usize].at = room.records as u32;
        if record > 0 {
            let records = room.records..room.records + record;
            self.record_runs.push(Run {
                level,
                at: records.clone(),
            });
            self.drawn.record_as(level, records, matrices);
        }
        room.records += record;
        room.slots[row * KINDS + Kind::Step as usize].at = room.steps as u32;
        if step > 0 {
            let steps = room.steps..room.steps + step;
            self.step_runs.push(Run {
                level,
                at: steps.clone(),
            });
            self.drawn.step_as(level, steps, matrices);
        }
        room.steps += step;
        room.slots[row * KINDS + Kind::Impostor as usize].at = room.impostors as u32;
        room.impostors += impostors;
    }

    /// Puts the characters of every section into their places.
    fn place<'a>(&mut self, sections: impl Iterator<Item = &'a SectionKeys>, room: &mut Room) {
        self.drawn.draws.resize(room.draws, Draw::default());
        self.drawn.recorded.resize(room.records, 0);
        self.drawn.stepped.resize(room.steps, 0);
        self.drawn.impostors.resize(room.impostors, 0);
        for section in sections {
            let mut rest = section.order();
            let counts = section.counts().iter().enumerate();
            for (key, count) in counts.filter(|(_, count)| **count > 0) {
                let Some((characters, others)) = rest.split_at_checked(usize::from(*count)) else {
                    break;
                };
                rest = others;
                let slot = &mut room.slots[key];
                let places = slot.at as usize..slot.at as usize + characters.len();
                slot.at += characters.len() as u32;
                let kind = key % KINDS;
                if kind == Kind::Record as usize {
                    self.drawn.recorded[places].copy_from_slice(characters);
                    continue;
                }
                if kind == Kind::Step as usize {
                    self.drawn.stepped[places].copy_from_slice(characters);
                    continue;
                }
                if kind == Kind::Impostor as usize {
                    self.drawn.impostors[places].copy_from_slice(characters);
                    continue;
                }
                let is_own = kind != Kind::Follow as usize;
                for (draw, character) in self.drawn.draws[places].iter_mut().zip(characters) {
                    let first_matrix = if is_own {
                        let next = slot.matrix + slot.step;
                        std::mem::replace(&mut slot.matrix, next)
                    } else {
                        self.leader_matrices[section.leader_of(*character)]
                    };
                    *draw = Draw {
                        character: *character,
                        first_matrix,
                    };
                }
            }
        }
    }

    /// Sorts the shared poses by level.
    fn place_leaders(&mut self, leaders: &[Leader], next: &mut [Slot]) {
        self.leaders.resize(leaders.len(), 0);
        self.leader_matrices.clear();
        for (leader, of) in leaders.iter().enumerate() {
            let slot = &mut next[usize::from(of.level)];
            self.leaders[slot.at as usize] = leader as u32;
            self.leader_matrices.push(slot.matrix);
            slot.at += 1;
            slot.matrix += slot.step;
        }
    }

    pub(crate) fn batches(&self) -> &[Batch] {
        &self.batches
    }

    pub(crate) fn draw_list(&self) -> &DrawList {
        &self.drawn
    }

    /// Records by level and face.
    pub(crate) fn record_runs(&self) -> &[Run] {
        &self.record_runs
    }

    /// Steps by level and face.
    pub(crate) fn step_runs(&self) -> &[Run] {
        &self.step_runs
    }

    /// Numbers of characters and poses by level.
    pub(crate) fn counts(&self) -> &[LevelCounts] {
        &self.counts
    }

    /// Index of the first matrix of a batch, or the number of all matrices beyond the last one.
    pub(crate) fn first_matrix(&self, batch: usize) -> usize {
        let at = self.batches.get(batch);
        at.map_or(self.drawn.matrices, |b| b.first_matrix as usize)
    }

    /// Poses that a batch evaluates.
    pub(crate) fn posers(&self, batch: &Batch) -> impl Iterator<Item = Poser> + '_ {
        let at = batch.first as usize..batch.first as usize + batch.poses();
        let is_shared = batch.jobs == Jobs::Shared;
        at.map(move |i| {
            if is_shared {
                Poser::Leader(self.leaders[i] as usize)
            } else {
                Poser::Character(self.drawn.draws[i].character as usize)
            }
        })
    }
}

impl Batch {
    /// Whether cached palettes are blended.
    pub(crate) fn is_cached(&self) -> bool {
        self.jobs == Jobs::Cached
    }

    /// Level of its poses.
    pub(crate) fn level(&self) -> usize {
        usize::from(self.level)
    }

    /// Number of its poses, 1 to 16.
    pub(crate) fn poses(&self) -> usize {
        usize::from(self.poses)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crowd::keys::Key;
    use crate::joint_set::JointSet;
    use crate::rig::tests::rig_of;
    use crate::simd::WIDE;
    use glam::Vec3;

    /// Three matrices at the first level, one at the second.
    fn palette() -> PaletteMap {
        let rig = rig_of(&[
            (None, Vec3::ZERO, 0),
            (Some(0), Vec3::Y, 0),
            (Some(1), Vec3::Y, 0),
        ]);
        let sets = [JointSet::first(1)];
        PaletteMap::joints(&JointLods::of_sets(&rig, &sets, rig.rest_pose()).unwrap())
    }

    /// Two sections with characters at two levels, from every source.
    fn sections() -> [SectionKeys; 2] {
        let mut sections = [
            SectionKeys::new(0, 16, 2, 2),
            SectionKeys::new(16, 54, 2, 2),
        ];
        for (characters, level, kind) in [
            (10..19, 1, Kind::Clip),
            (5..6, 0, Kind::Clip),
            (7..8, 0, Kind::Blend),
            (8..10, 0, Kind::Follow),
            (20..21, 1, Kind::Cached),
            (21..22, 1, Kind::Record),
            (22..23, 0, Kind::Record),
            (69..70, 1, Kind::Record),
            (3..5, 0, Kind::Step),
            (30..32, 1, Kind::Step),
            (40..41, 1, Kind::Impostor),
            (67..69, 1, Kind::Impostor),
        ] {
            for character in characters {
                let [first, second] = &mut sections;
                match character {
                    0..16 => first.set(character, Key::new(level, kind)),
                    _ => second.set(character - 16, Key::new(level, kind)),
                }
            }
        }
        sections
    }

    #[test]
    fn a_plan_by_hand() {
        let (palette, mut sections) = (palette(), sections());
        // One more shared pose than is used, and of another level.
        let leaders = [1, 0].map(|level| Leader {
            clip: 0,
            level,
            secs: 0.0,
        });
        sections[0].follow(8, 1);
        sections[0].follow(9, 1);
        assert!(sections.iter_mut().all(SectionKeys::sort));
        assert!(!sections.iter_mut().any(SectionKeys::sort));
        let mut plan = Plan::new(70, 2);
        for _ in 0..2 {
            // Without levels that show morph targets, with the first one, and with all.
            for (levels, sets) in [(0, (0, 0, 0)), (2, (14, 3, 4)), (1, (4, 1, 2))] {
                plan.make(sections.iter(), &leaders, &palette, LANES, levels);
                let list = plan.draw_list();
                let found = (list.morph_draws, list.morph_records, list.morph_steps);
                assert_eq!(found, sets);
                assert_eq!(list.morph_sets(), sets.0 + sets.1 + sets.2);
            }
            let list = plan.draw_list();
            let characters: Vec<usize> = (0..7).map(|set| list.character_of(set)).collect();
            assert_eq!(characters, [5, 7, 8, 9, 22, 3, 4]);
            // At the first level the matrices of clips, of blends and of shared poses.
            let mut expected = vec![(5, 0), (7, 3), (8, 6), (9, 6)];
            expected.extend((0..10).map(|i| (if i < 9 { 10 + i } else { 20 }, 9 + i)));
            let draws = list.draws.iter().map(|d| (d.character, d.first_matrix));
            assert_eq!(draws.collect::<Vec<_>>(), expected);
            let groups = list.groups.iter();
            let groups = groups.map(|g| (g.level, g.draws.clone(), g.matrices));
            assert_eq!(groups.collect::<Vec<_>>(), [(0, 0..4, 3), (1, 4..14, 1)]);
            assert_eq!((list.batches, list.matrices), (7, 20));
            assert_eq!(list.recorded, [22, 21, 69]);
            let groups = list.record_groups.iter();
            let groups = groups.map(|g| (g.level, g.records.clone(), g.matrices));
            assert_eq!(groups.collect::<Vec<_>>(), [(0, 0..1, 3), (1, 1..3, 1)]);
            assert_eq!(list.stepped, [3, 4, 30, 31]);
            assert_eq!(list.impostors, [40, 67, 68]);
            let groups = list.step_groups.iter();
            let groups = groups.map(|g| (g.level, g.steps.clone(), g.matrices));
            assert_eq!(groups.collect::<Vec<_>>(), [(0, 0..2, 3), (1, 2..4, 1)]);
            let batches = plan.batches().iter();
            let batches = batches.map(|b| (b.level(), b.poses(), b.is_cached()));
            let mut expected = vec![(0, 1, false); 3];
            expected.extend([(1, 8, false), (1, 1, false), (1, 1, true), (1, 1, false)]);
            assert_eq!(batches.collect::<Vec<_>>(), expected);
            let first: Vec<usize> = (0..9).map(|b| plan.first_matrix(b)).collect();
            assert_eq!(first, [0, 3, 6, 9, 17, 18, 19, 20, 20]);
            let posers = |b: usize| plan.posers(&plan.batches()[b]).collect::<Vec<_>>();
            assert_eq!(posers(1), [Poser::Character(7)]);
            assert_eq!(posers(2), [Poser::Leader(1)]);
            assert_eq!(posers(4), [Poser::Character(18)]);
            assert_eq!(posers(6), [Poser::Leader(0)]);
            let counts = LevelCounts {
                own: 2,
                blended: 1,
                leaders: 1,
                followers: 2,
                cached: 0,
                recorded: 1,
                stepped: 2,
                impostors: 0,
            };
            assert_eq!(plan.counts()[0], counts);
        }
        // Where there are sixteen lanes, nine poses are one batch.
        plan.make(sections.iter(), &leaders, &palette, WIDE, 0);
        let poses: Vec<usize> = plan.batches().iter().map(Batch::poses).collect();
        assert_eq!(poses, [1, 1, 1, 9, 1, 1]);
        let first: Vec<usize> = (0..6).map(|b| plan.first_matrix(b)).collect();
        assert_eq!(first, [0, 3, 6, 9, 18, 19]);
        // Who is hidden is in no list.
        for character in 0..16 {
            sections[0].set(character, Key::HIDDEN);
        }
        sections[0].sort();
        plan.make(sections.iter(), &[], &palette, LANES, 0);
        let characters = plan.draw_list().draws.iter().map(|d| d.character);
        assert_eq!(characters.collect::<Vec<_>>(), [16, 17, 18, 20]);
        assert_eq!(plan.draw_list().recorded, [22, 21, 69]);
        assert_eq!(plan.draw_list().stepped, [30, 31]);
        assert_eq!(plan.draw_list().impostors, [40, 67, 68]);
    }

    #[test]
    fn faces_at_rest_come_last_in_their_level() {
        let (palette, mut sections) = (palette(), sections());
        // Those that blend and follow, a record and one of two steps of each level.
        let [first, second] = &mut sections;
        for character in [4, 7, 8] {
            first.set(character, first.get(character).at_rest());
        }
        for character in [21, 30] {
            second.set(character - 16, second.get(character - 16).at_rest());
        }
        second.set(0, Key::new(0, Kind::Step));
        assert_eq!(first.get(4).level(), Some(0));
        assert_eq!(second.get(5).level(), Some(1));
        assert!(sections.iter_mut().all(SectionKeys::sort));
        let leaders = [Leader {
            clip: 0,
            level: 0,
            secs: 0.0,
        }];
        let mut plan = Plan::new(70, 2);
        for _ in 0..2 {
            plan.make(sections.iter(), &leaders, &palette, LANES, 2);
            let list = plan.draw_list();
            let draws = list.draws.iter().map(|d| (d.character, d.first_matrix));
            // The shared pose is that of both faces; its matrices come before those at rest.
            let expected = [(5, 0), (9, 3), (7, 6), (8, 3), (10, 9)];
            assert_eq!(draws.take(5).collect::<Vec<_>>(), expected);
            let groups = list.groups.iter().map(|g| (g.level, g.draws.clone()));
            assert_eq!(groups.collect::<Vec<_>>(), [(0, 0..4), (1, 4..13)]);
            assert_eq!(list.recorded, [22, 69, 21]);
            assert_eq!(list.stepped, [3, 16, 4, 31, 30]);
            let groups = list.step_groups.iter();
            let groups = groups.map(|g| (g.level, g.steps.clone()));
            assert_eq!(groups.collect::<Vec<_>>(), [(0, 0..3), (1, 3..5)]);
            let of = |runs: &[Run]| runs.iter().map(|r| r.at.clone()).collect::<Vec<_>>();
            assert_eq!(of(plan.record_runs()), [0..1, 1..2, 2..3]);
            assert_eq!(of(plan.step_runs()), [0..2, 2..3, 3..4, 4..5]);
            // Up to the last of each list that shows morph targets.
            let sets = (list.morph_draws, list.morph_records, list.morph_steps);
            assert_eq!(sets, (13, 2, 4));
            let characters: Vec<usize> = (12..19).map(|set| list.character_of(set)).collect();
            assert_eq!(characters, [20, 22, 69, 3, 16, 4, 31]);
            let counts = plan.counts()[0];
            assert_eq!((counts.own, counts.blended, counts.followers), (2, 1, 2));
            assert_eq!((counts.recorded, counts.stepped), (1, 3));
        }
        // Without levels that show morph targets there is no room for faces at rest.
        assert_eq!(SectionKeys::new(0, 1, 3, 0).counts().len(), 3 * KINDS);
    }
}
