//! Level and source of every character of a section, and the characters sorted by them.

use crate::joint_lods::JointLods;
use crate::pose_cache::PoseCache;

/// Number of kinds at a level.
pub(super) const KINDS: usize = 7;
/// Number of rows of keys with kinds each. The first rows are the levels; as many follow for characters
/// whose face rests although their level shows morph targets.
const ROWS: usize = 2 * JointLods::MAX_LEVELS;
/// Number of rows times kinds.
pub(super) const KEYS: usize = ROWS * KINDS;

const _: () = assert!(KEYS < u8::MAX as usize, "a key has to fit in a byte");

/// Row of the characters of a level whose face rests although the level shows morph targets. The row of
/// the others is the level itself.
pub(super) const fn rest_row(level: usize) -> usize {
    JointLods::MAX_LEVELS + level
}

/// Source of a character's pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// One clip is evaluated.
    Clip,
    /// Two clips are evaluated and blended.
    Blend,
    /// Two cached palettes are blended.
    Cached,
    /// A shared pose.
    Follow,
    /// The GPU blends two cached palettes.
    Record,
    /// The cached palette nearest in time.
    Step,
    /// An impostor.
    Impostor,
}

/// Level of a character and source of its pose, or that it is not shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key(u8);

impl Key {
    pub(crate) const HIDDEN: Self = Self(u8::MAX);

    pub(crate) fn new(level: usize, kind: Kind) -> Self {
        Self((level * KINDS + kind as usize) as u8)
    }

    /// The same with a face at rest, at a level that shows morph targets.
    pub(crate) fn at_rest(self) -> Self {
        Self(self.0 + (JointLods::MAX_LEVELS * KINDS) as u8)
    }

    /// Row and kind as one index, below [`KEYS`]; `None` if the character is not shown.
    #[inline]
    pub(super) fn index(self) -> Option<usize> {
        (self != Self::HIDDEN).then_some(usize::from(self.0))
    }

    /// Whether the character is shown by an impostor.
    pub(super) fn is_impostor(self) -> bool {
        self.index()
            .is_some_and(|i| i % KINDS == Kind::Impostor as usize)
    }

    /// Error in metres that the source adds to that of the level; impostors have no level.
    pub(super) fn source_metres(self, cache: Option<&PoseCache>, clip: usize) -> f32 {
        let (Some(index), Some(cache)) = (self.index(), cache) else {
            return 0.0;
        };
        let (level, kind) = (index / KINDS % JointLods::MAX_LEVELS, index % KINDS);
        let blended = [Kind::Cached as usize, Kind::Record as usize];
        let found = if kind == Kind::Step as usize {
            cache.step_error_metres(clip, level)
        } else if blended.contains(&kind) {
            cache.error_metres(clip, level)
        } else {
            None
        };
        found.unwrap_or(0.0)
    }

    /// The level; `None` if the character is not shown.
    #[inline]
    pub(crate) fn level(self) -> Option<usize> {
        Some(self.index()? / KINDS % JointLods::MAX_LEVELS)
    }

    /// Whether the level and the source are those of another key, whatever the faces.
    pub(super) fn has_pose_of(self, other: Self) -> bool {
        let pose = |key: Self| Some(key.index()? % (JointLods::MAX_LEVELS * KINDS));
        pose(self) == pose(other)
    }

    /// Whether the character is evaluated alone, at one clip.
    pub(super) fn is_clip(self) -> bool {
        self.index()
            .is_some_and(|i| i % KINDS == Kind::Clip as usize)
    }
}

/// The keys of a section.
#[derive(Debug, Clone)]
pub(crate) struct SectionKeys {
    /// Index of its first character in the crowd.
    first: usize,
    keys: Vec<Key>,
    /// Number of characters of each key of the rows that there are.
    counts: Vec<u16>,
    /// All that are shown, as indices into the crowd, by key and index.
    order: Vec<u32>,
    /// Whether a key has changed since the characters were sorted.
    is_stirred: bool,
    /// The shared pose of each character that follows one.
    leader_of: Vec<u32>,
}

impl SectionKeys {
    /// Bytes of each character.
    pub(super) const BYTES: usize = size_of::<Key>();

    /// Characters `first` to `first + len` of a crowd, none of them shown at any of so many levels, of
    /// which the first `morph_levels` show morph targets.
    pub(super) fn new(first: usize, len: usize, levels: usize, morph_levels: usize) -> Self {
        // Where no level shows morph targets, there are no rows of faces at rest.
        let rows = match morph_levels {
            0 => levels,
            _ => rest_row(morph_levels.min(levels)),
        };
        Self {
            first,
            keys: vec![Key::HIDDEN; len],
            counts: vec![0; rows * KINDS],
            order: Vec::with_capacity(len),
            is_stirred: false,
            leader_of: vec![0; len],
        }
    }

    #[inline]
    pub(super) fn get(&self, character: usize) -> Key {
        self.keys[character]
    }

    #[inline]
    pub(super) fn set(&mut self, character: usize, key: Key) {
        let before = std::mem::replace(&mut self.keys[character], key);
        if before != key {
            if let Some(before) = before.index() {
                self.counts[before] -= 1;
            }
            if let Some(key) = key.index() {
                self.counts[key] += 1;
            }
            self.is_stirred = true;
        }
    }

    /// Sets the shared pose that a character follows.
    pub(super) fn follow(&mut self, character: usize, leader: usize) {
        self.leader_of[character] = leader as u32;
    }

    /// The shared pose that a character of the crowd follows.
    pub(super) fn leader_of(&self, character: u32) -> usize {
        self.leader_of[character as usize - self.first] as usize
    }

    /// Sorts the characters if a key has changed, by counting; returns whether one has.
    pub(super) fn sort(&mut self) -> bool {
        if !std::mem::replace(&mut self.is_stirred, false) {
            return false;
        }
        let mut next = [0_u16; KEYS];
        let mut all = 0;
        for (next, count) in next.iter_mut().zip(&self.counts) {
            *next = all;
            all += count;
        }
        self.order.resize(usize::from(all), 0);
        for (character, key) in self.keys.iter().enumerate() {
            if let Some(key) = key.index() {
                self.order[usize::from(next[key])] = (self.first + character) as u32;
                next[key] += 1;
            }
        }
        true
    }

    /// Number of characters of each key, beginning with the least.
    pub(super) fn counts(&self) -> &[u16] {
        &self.counts
    }

    /// The characters that are shown, by key, as they were last sorted.
    pub(super) fn order(&self) -> &[u32] {
        &self.order
    }
}
