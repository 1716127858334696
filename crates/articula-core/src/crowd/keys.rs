//! Level and source of every character of a section, and the characters sorted by them.

use super::parts::CrowdParts;
use super::sources::Source;
use crate::joint_lods::JointLods;

/// Number of rows of keys, with all sources each. The first rows are the levels; as many follow for
/// characters whose face rests although their level shows morph targets.
const ROWS: usize = 2 * JointLods::MAX_LEVELS;
/// Number of sources, and of rows times sources.
pub(super) const SOURCES: usize = Source::ALL.len();
pub(super) const KEYS: usize = ROWS * SOURCES;

const _: () = assert!(KEYS < u8::MAX as usize, "a key has to fit in a byte");

/// Row of the characters of a level whose face rests although the level shows morph targets. The row of
/// the others is the level itself.
pub(super) const fn rest_row(level: usize) -> usize {
    JointLods::MAX_LEVELS + level
}

/// Level of a key by its index.
#[inline]
pub(super) const fn level_of(key: usize) -> usize {
    key / SOURCES % JointLods::MAX_LEVELS
}

/// Level of a character and source of its pose, or that it is not shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key(u8);

impl Key {
    pub(crate) const HIDDEN: Self = Self(u8::MAX);

    pub(crate) fn new(level: usize, source: Source) -> Self {
        Self((level * SOURCES + source as usize) as u8)
    }

    /// The same with a face at rest, at a level that shows morph targets.
    pub(crate) fn at_rest(self) -> Self {
        Self(self.0 + (JointLods::MAX_LEVELS * SOURCES) as u8)
    }

    /// Row and source as one index, below [`KEYS`]; `None` if the character is not shown.
    #[inline]
    pub(super) fn index(self) -> Option<usize> {
        (self != Self::HIDDEN).then_some(usize::from(self.0))
    }

    /// The source; `None` if the character is not shown.
    #[inline]
    pub(super) fn source(self) -> Option<Source> {
        Some(Source::ALL[self.index()? % SOURCES])
    }

    /// Whether the character is shown by an impostor.
    pub(super) fn is_impostor(self) -> bool {
        self.source() == Some(Source::Impostor)
    }

    /// Error in metres that the source adds to that of the level; impostors have no level.
    pub(super) fn added_metres(self, parts: &CrowdParts, clip: usize) -> f32 {
        let (source, level) = (self.source(), self.level());
        let added = source.zip(level);
        added.map_or(0.0, |(source, level)| {
            source.added_metres(parts, clip, level).unwrap_or(0.0)
        })
    }

    /// The level; `None` if the character is not shown.
    #[inline]
    pub(crate) fn level(self) -> Option<usize> {
        self.index().map(level_of)
    }

    /// Whether the level and the source are those of another key, whatever the faces.
    pub(super) fn has_pose_of(self, other: Self) -> bool {
        let pose = |key: Self| Some(key.index()? % (JointLods::MAX_LEVELS * SOURCES));
        pose(self) == pose(other)
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
            counts: vec![0; rows * SOURCES],
            order: Vec::with_capacity(len),
            is_stirred: false,
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
