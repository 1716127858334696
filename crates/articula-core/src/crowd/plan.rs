//! Evaluation plan of a frame: characters sorted by level and source of their pose, divided into
//! batches, and the palette of each.

use super::draws::Draw;
use super::keys::{KEYS, SOURCES, SectionKeys, level_of, rest_row};
use super::sources::{DrawKind, Source};
use crate::palette::PaletteMap;
use crate::simd::LANES;
use std::ops::Range;

/// Number of kinds of draws.
const KINDS: usize = DrawKind::ALL.len();

/// Draws of one kind and level: their characters have the same mesh and palettes of the same length.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DrawGroup {
    /// What a renderer reads of each.
    pub kind: DrawKind,
    /// Level of the characters; of impostors, which have none, the coarsest.
    pub level: usize,
    /// Range of [`DrawList::characters`] of the kind, and of its draws.
    pub range: Range<usize>,
    /// Number of matrices of one palette.
    pub matrices: usize,
}

/// Visible characters of a frame, and where their palettes are.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawList {
    /// Draws grouped by level, and within a level by kind.
    pub groups: Vec<DrawGroup>,
    /// Draws of kind [`DrawKind::Palette`], in the order of the groups.
    /// [`Crowd::evaluate_draws`](super::Crowd::evaluate_draws) writes those of the other kinds.
    pub draws: Vec<Draw>,
    /// Number of batches to evaluate, of up to [`lanes`](crate::batch::BatchEvaluator::lanes) poses
    /// each.
    pub batches: usize,
    /// Number of matrices that all batches write.
    pub matrices: usize,
    characters: [Vec<u32>; KINDS],
    with_morphs: [usize; KINDS],
}

impl DrawList {
    fn new(characters: usize, levels: usize) -> Self {
        Self {
            groups: Vec::with_capacity(levels * KINDS),
            draws: Vec::with_capacity(characters),
            batches: 0,
            matrices: 0,
            characters: [(); KINDS].map(|()| Vec::with_capacity(characters)),
            with_morphs: [0; KINDS],
        }
    }

    /// Groups of one kind, finest level first.
    pub fn groups_of(&self, kind: DrawKind) -> impl Iterator<Item = &DrawGroup> {
        self.groups.iter().filter(move |g| g.kind == kind)
    }

    /// Characters that are drawn as one kind, in the order of the groups.
    pub fn characters(&self, kind: DrawKind) -> &[u32] {
        &self.characters[kind as usize]
    }

    /// Number of draws of a kind, from the first on, with morph target weights: those of draw `i` are set
    /// [`first_morph_set`](Self::first_morph_set)` + i` of
    /// [`Crowd::evaluate_morphs`](super::Crowd::evaluate_morphs). The faces of later draws rest, with
    /// the mesh's default weights, and so do some before the last draw that shows morph targets.
    pub fn with_morphs(&self, kind: DrawKind) -> usize {
        self.with_morphs[kind as usize]
    }

    /// Index of the set of morph target weights of the first draw of a kind.
    pub fn first_morph_set(&self, kind: DrawKind) -> usize {
        self.with_morphs[..kind as usize].iter().sum()
    }

    /// Number of sets of morph target weights of the frame.
    pub fn morph_sets(&self) -> usize {
        self.with_morphs.iter().sum()
    }

    /// Characters with a set of morph target weights, in the order of the sets.
    pub(super) fn with_sets(&self) -> impl Iterator<Item = u32> {
        let lists = self.characters.iter().zip(self.with_morphs);
        lists.flat_map(|(characters, with_morphs)| characters[..with_morphs].iter().copied())
    }

    /// Character of a set of morph target weights.
    pub(crate) fn character_of(&self, mut set: usize) -> usize {
        for (characters, with_morphs) in self.characters.iter().zip(self.with_morphs) {
            if set < with_morphs {
                return characters[set] as usize;
            }
            set -= with_morphs;
        }
        unreachable!("the caller checks that the set is one of the frame")
    }

    /// Removes all groups.
    fn clear(&mut self) {
        self.groups.clear();
        self.with_morphs = [0; KINDS];
    }

    /// Adds draws to the group of their kind and level.
    fn add(&mut self, group: DrawGroup) {
        let groups = self.groups.iter_mut().rev();
        let mut of_level = groups.take_while(|g| g.level == group.level);
        match of_level.find(|g| g.kind == group.kind) {
            Some(known) => known.range.end = group.range.end,
            None => self.groups.push(group),
        }
    }

    /// Has all draws so far show morph targets, but for impostors, if any of this level does.
    fn show_morphs(&mut self, level: usize) {
        let of_level = self.groups.iter().rev().take_while(|g| g.level == level);
        for group in of_level.filter(|g| g.kind != DrawKind::Impostor) {
            self.with_morphs[group.kind as usize] = group.range.end;
        }
    }
}

/// Poses that are evaluated together, up to as many as the backend has lanes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Batch {
    /// Index of the first among the draws.
    first: u32,
    first_matrix: u32,
    poses: u8,
    level: u8,
    is_cached: bool,
}

/// Where the next character of one level and source goes.
#[derive(Debug, Clone, Copy, Default)]
struct Slot {
    at: u32,
    matrix: u32,
}

/// The places of a plan while it is made.
struct Room {
    /// For each level and source the number of its characters, then where the next one goes.
    slots: [Slot; KEYS],
    /// Draws of each kind, and matrices, that have a place.
    draws: [usize; KINDS],
    matrices: usize,
    /// Most poses of a batch.
    lanes: usize,
}

impl Room {
    fn counted<'a>(sections: impl Iterator<Item = &'a SectionKeys>, lanes: usize) -> Self {
        let mut room = Self {
            slots: [Slot::default(); KEYS],
            draws: [0; KINDS],
            matrices: 0,
            lanes,
        };
        for section in sections {
            for (slot, count) in room.slots.iter_mut().zip(section.counts()) {
                slot.at += u32::from(*count);
            }
        }
        room
    }

    /// Adds batches for the next poses of a level, with palettes of so many matrices, each of as many
    /// poses as there are lanes at most.
    fn cut(
        &self,
        batches: &mut Vec<Batch>,
        (level, is_cached): (usize, bool),
        poses: usize,
        matrices: usize,
    ) {
        for first in (0..poses).step_by(self.lanes) {
            batches.push(Batch {
                first: (self.draws[DrawKind::Palette as usize] + first) as u32,
                first_matrix: (self.matrices + first * matrices) as u32,
                poses: (poses - first).min(self.lanes) as u8,
                level: level as u8,
                is_cached,
            });
        }
    }
}

/// Characters of one row of keys and one kind of draw that is found anew in each frame. They are in the
/// order of the sections; a group of a level has up to two runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) kind: DrawKind,
    pub(crate) level: usize,
    /// Range of their list.
    pub(crate) at: Range<usize>,
}

/// The plan of one frame.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// Number of characters of each level by source.
    counts: Vec<[usize; SOURCES]>,
    batches: Vec<Batch>,
    runs: Vec<Run>,
    drawn: DrawList,
}

impl Plan {
    pub(crate) fn new(characters: usize, levels: usize) -> Self {
        Self {
            counts: vec![[0; SOURCES]; levels],
            batches: Vec::with_capacity(characters / LANES + 2 * levels * SOURCES),
            runs: Vec::with_capacity(2 * levels * KINDS),
            drawn: DrawList::new(characters, levels),
        }
    }

    /// Joins the characters of the sections, each sorted by level and source, with up to `lanes` poses
    /// in a batch. The first `morph_levels` levels show morph targets. O(characters).
    pub(crate) fn make<'a>(
        &mut self,
        sections: impl Iterator<Item = &'a SectionKeys> + Clone,
        palette: &PaletteMap,
        lanes: usize,
        morph_levels: usize,
    ) {
        let mut room = Room::counted(sections.clone(), lanes);
        self.batches.clear();
        self.runs.clear();
        self.drawn.clear();
        for level in 0..self.counts.len() {
            self.counts[level] = [0; SOURCES];
            self.lay_out(level, level, palette.len(level), &mut room);
            if level < morph_levels {
                self.drawn.show_morphs(level);
                self.lay_out(level, rest_row(level), palette.len(level), &mut room);
            }
        }
        self.place(sections, &mut room, palette);
        self.drawn.batches = self.batches.len();
        self.drawn.matrices = room.matrices;
    }

    /// Gives the characters of a row of keys, whose palettes have so many matrices, their places behind
    /// those of the rows before. The row is of a level with faces as they are shown, or at rest.
    fn lay_out(&mut self, level: usize, row: usize, matrices: usize, room: &mut Room) {
        for source in Source::ALL {
            let kind = source.draws();
            let slot = &mut room.slots[row * SOURCES + source as usize];
            let count = slot.at as usize;
            let first = room.draws[kind as usize];
            *slot = Slot {
                at: first as u32,
                matrix: room.matrices as u32,
            };
            if count == 0 {
                continue;
            }
            self.counts[level][source as usize] += count;
            let range = first..first + count;
            if kind == DrawKind::Palette {
                let poses = (level, source == Source::Cached);
                room.cut(&mut self.batches, poses, count, matrices);
                room.matrices += count * matrices;
            } else {
                self.runs.push(Run {
                    kind,
                    level,
                    at: range.clone(),
                });
            }
            room.draws[kind as usize] += count;
            self.drawn.add(DrawGroup {
                kind,
                level,
                range,
                matrices,
            });
        }
    }

    /// Puts the characters of every section into their places.
    fn place<'a>(
        &mut self,
        sections: impl Iterator<Item = &'a SectionKeys>,
        room: &mut Room,
        palette: &PaletteMap,
    ) {
        for (characters, count) in self.drawn.characters.iter_mut().zip(room.draws) {
            characters.resize(count, 0);
        }
        let palettes = room.draws[DrawKind::Palette as usize];
        self.drawn.draws.resize(palettes, Draw::default());
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
                let kind = Source::ALL[key % SOURCES].draws();
                self.drawn.characters[kind as usize][places.clone()].copy_from_slice(characters);
                if kind != DrawKind::Palette {
                    continue;
                }
                let step = palette.len(level_of(key)) as u32;
                for (draw, character) in self.drawn.draws[places].iter_mut().zip(characters) {
                    *draw = Draw {
                        character: *character,
                        first_matrix: slot.matrix,
                    };
                    slot.matrix += step;
                }
            }
        }
    }

    pub(crate) fn batches(&self) -> &[Batch] {
        &self.batches
    }

    pub(crate) fn draw_list(&self) -> &DrawList {
        &self.drawn
    }

    /// Runs of one kind of draws that are found anew in each frame.
    pub(crate) fn runs(&self, kind: DrawKind) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(move |run| run.kind == kind)
    }

    /// Number of characters of each level by source.
    pub(crate) fn counts(&self) -> &[[usize; SOURCES]] {
        &self.counts
    }

    /// Index of the first matrix of a batch, or the number of all matrices beyond the last one.
    pub(crate) fn first_matrix(&self, batch: usize) -> usize {
        let at = self.batches.get(batch);
        at.map_or(self.drawn.matrices, |b| b.first_matrix as usize)
    }

    /// Characters whose poses a batch evaluates.
    pub(crate) fn posed(&self, batch: &Batch) -> impl Iterator<Item = usize> + '_ {
        let at = batch.first as usize..batch.first as usize + batch.poses();
        self.drawn.draws[at].iter().map(|d| d.character as usize)
    }
}

impl Batch {
    /// Whether cached palettes are blended.
    pub(crate) fn is_cached(&self) -> bool {
        self.is_cached
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
    use crate::joint_lods::JointLods;
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
        for (characters, level, source) in [
            (10..19, 1, Source::Clip),
            (5..6, 0, Source::Clip),
            (7..8, 0, Source::Blend),
            (8..10, 0, Source::Cached),
            (20..21, 1, Source::Cached),
            (21..22, 1, Source::Record),
            (22..23, 0, Source::Record),
            (69..70, 1, Source::Record),
            (3..5, 0, Source::Step),
            (30..32, 1, Source::Step),
            (40..41, 1, Source::Impostor),
            (67..69, 1, Source::Impostor),
        ] {
            for character in characters {
                let [first, second] = &mut sections;
                match character {
                    0..16 => first.set(character, Key::new(level, source)),
                    _ => second.set(character - 16, Key::new(level, source)),
                }
            }
        }
        sections
    }

    /// Levels, ranges and matrices of the groups of a kind.
    fn groups(list: &DrawList, kind: DrawKind) -> Vec<(usize, Range<usize>, usize)> {
        let groups = list.groups_of(kind);
        groups
            .map(|g| (g.level, g.range.clone(), g.matrices))
            .collect()
    }

    /// Numbers of palettes, records, steps and impostors with morph target weights.
    fn with_morphs(list: &DrawList) -> [usize; KINDS] {
        DrawKind::ALL.map(|kind| list.with_morphs(kind))
    }

    #[test]
    fn a_plan_by_hand() {
        use DrawKind::{Impostor, Palette, Record, Step};
        let (palette, mut sections) = (palette(), sections());
        assert!(sections.iter_mut().all(SectionKeys::sort));
        assert!(!sections.iter_mut().any(SectionKeys::sort));
        let mut plan = Plan::new(70, 2);
        for _ in 0..2 {
            // Without levels that show morph targets, with the first one, and with all.
            for (levels, sets) in [(0, [0; 4]), (2, [14, 3, 4, 0]), (1, [4, 1, 2, 0])] {
                plan.make(sections.iter(), &palette, LANES, levels);
                let list = plan.draw_list();
                assert_eq!(with_morphs(list), sets);
                assert_eq!(list.morph_sets(), sets.iter().sum());
                assert_eq!(list.first_morph_set(Step), sets[0] + sets[1]);
            }
            let list = plan.draw_list();
            let characters: Vec<usize> = (0..7).map(|set| list.character_of(set)).collect();
            assert_eq!(characters, [5, 7, 8, 9, 22, 3, 4]);
            // At the first level the matrices of clips, of blends and of cached poses.
            let mut expected = vec![(5, 0), (7, 3), (8, 6), (9, 9)];
            expected.extend((0..10).map(|i| (if i < 9 { 10 + i } else { 20 }, 12 + i)));
            let draws = list.draws.iter().map(|d| (d.character, d.first_matrix));
            assert_eq!(draws.collect::<Vec<_>>(), expected);
            let characters = list.draws.iter().map(|d| d.character);
            assert!(characters.eq(list.characters(Palette).iter().copied()));
            assert_eq!(groups(list, Palette), [(0, 0..4, 3), (1, 4..14, 1)]);
            assert_eq!((list.batches, list.matrices), (6, 22));
            assert_eq!(list.characters(Record), [22, 21, 69]);
            assert_eq!(groups(list, Record), [(0, 0..1, 3), (1, 1..3, 1)]);
            assert_eq!(list.characters(Step), [3, 4, 30, 31]);
            assert_eq!(groups(list, Step), [(0, 0..2, 3), (1, 2..4, 1)]);
            assert_eq!(list.characters(Impostor), [40, 67, 68]);
            assert_eq!(groups(list, Impostor), [(1, 0..3, 1)]);
            let batches = plan.batches().iter();
            let batches = batches.map(|b| (b.level(), b.poses(), b.is_cached()));
            let mut expected = vec![(0, 1, false), (0, 1, false), (0, 2, true)];
            expected.extend([(1, 8, false), (1, 1, false), (1, 1, true)]);
            assert_eq!(batches.collect::<Vec<_>>(), expected);
            let first: Vec<usize> = (0..8).map(|b| plan.first_matrix(b)).collect();
            assert_eq!(first, [0, 3, 6, 12, 20, 21, 22, 22]);
            let posed = |b: usize| plan.posed(&plan.batches()[b]).collect::<Vec<_>>();
            assert_eq!(
                [posed(1), posed(2), posed(4)],
                [vec![7], vec![8, 9], vec![18]]
            );
            // By source: clip, blend, cached, record, step, impostor.
            assert_eq!(plan.counts(), [[1, 1, 2, 1, 2, 0], [9, 0, 1, 2, 2, 3]]);
        }
        // Where there are sixteen lanes, nine poses are one batch.
        plan.make(sections.iter(), &palette, WIDE, 0);
        let poses: Vec<usize> = plan.batches().iter().map(Batch::poses).collect();
        assert_eq!(poses, [1, 1, 2, 9, 1]);
        let first: Vec<usize> = (0..5).map(|b| plan.first_matrix(b)).collect();
        assert_eq!(first, [0, 3, 6, 12, 21]);
        // Who is hidden is in no list.
        for character in 0..16 {
            sections[0].set(character, Key::HIDDEN);
        }
        sections[0].sort();
        plan.make(sections.iter(), &palette, LANES, 0);
        let list = plan.draw_list();
        assert_eq!(list.characters(Palette), [16, 17, 18, 20]);
        assert_eq!(list.characters(Record), [22, 21, 69]);
        assert_eq!(list.characters(Step), [30, 31]);
        assert_eq!(list.characters(Impostor), [40, 67, 68]);
    }

    #[test]
    fn faces_at_rest_come_last_in_their_level() {
        use DrawKind::{Palette, Record, Step};
        let (palette, mut sections) = (palette(), sections());
        // Those that blend and show a cached pose, a record and one of two steps of each level.
        let [first, second] = &mut sections;
        for character in [4, 7, 8] {
            first.set(character, first.get(character).at_rest());
        }
        for character in [21, 30] {
            second.set(character - 16, second.get(character - 16).at_rest());
        }
        second.set(0, Key::new(0, Source::Step));
        assert_eq!(first.get(4).level(), Some(0));
        assert_eq!(second.get(5).level(), Some(1));
        assert!(sections.iter_mut().all(SectionKeys::sort));
        let mut plan = Plan::new(70, 2);
        for _ in 0..2 {
            plan.make(sections.iter(), &palette, LANES, 2);
            let list = plan.draw_list();
            let draws = list.draws.iter().map(|d| (d.character, d.first_matrix));
            let expected = [(5, 0), (9, 3), (7, 6), (8, 9), (10, 12)];
            assert_eq!(draws.take(5).collect::<Vec<_>>(), expected);
            assert_eq!(groups(list, Palette), [(0, 0..4, 3), (1, 4..13, 1)]);
            assert_eq!(list.characters(Record), [22, 69, 21]);
            assert_eq!(list.characters(Step), [3, 16, 4, 31, 30]);
            assert_eq!(groups(list, Step), [(0, 0..3, 3), (1, 3..5, 1)]);
            let runs = |kind| plan.runs(kind).map(|r| r.at.clone()).collect::<Vec<_>>();
            assert_eq!(runs(Record), [0..1, 1..2, 2..3]);
            assert_eq!(runs(Step), [0..2, 2..3, 3..4, 4..5]);
            // Up to the last of each list that shows morph targets.
            assert_eq!(with_morphs(list), [13, 2, 4, 0]);
            let characters: Vec<usize> = (12..19).map(|set| list.character_of(set)).collect();
            assert_eq!(characters, [20, 22, 69, 3, 16, 4, 31]);
            assert_eq!(plan.counts()[0], [1, 1, 2, 1, 3, 0]);
        }
        // Without levels that show morph targets there is no room for faces at rest.
        let counts = SectionKeys::new(0, 1, 3, 0).counts().len();
        assert_eq!(counts, 3 * SOURCES);
    }
}
