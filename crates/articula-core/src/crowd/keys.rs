//! Level and source of every character of a section, and the characters sorted by them.

use crate::joint_lods::JointLods;

/// Number of kinds at a level.
pub(super) const KINDS: usize = 5;
/// Rows of keys at a level: of characters that show morph targets or have none, and of those whose
/// face rests although the level shows it.
pub(super) const FACES: usize = 2;
/// Number of levels times faces times kinds.
pub(super) const KEYS: usize = FACES * KINDS * JointLods::MAX_LEVELS;

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
}

/// Level of a character and source of its pose, or that it is not shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Key(u8);

impl Key {
    pub(crate) const HIDDEN: Self = Self(u8::MAX);

    pub(crate) fn new(level: usize, kind: Kind) -> Self {
        Self((level * FACES * KINDS + kind as usize) as u8)
    }

    /// The same with a face at rest, at a level that shows morph targets.
    pub(crate) fn at_rest(self) -> Self {
        Self(self.0 + KINDS as u8)
    }

    /// Level, face and kind as one index, below [`KEYS`]; `None` if the character is not shown.
    #[inline]
    pub(super) fn index(self) -> Option<usize> {
        (self != Self::HIDDEN).then_some(usize::from(self.0))
    }

    /// The level; `None` if the character is not shown.
    #[inline]
    pub(crate) fn level(self) -> Option<usize> {
        Some(self.index()? / KINDS / FACES)
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
    /// Number of characters of each key of the levels that there are.
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

    /// Characters `first` to `first + len` of a crowd, none of them shown at any of so many levels.
    pub(super) fn new(first: usize, len: usize, levels: usize) -> Self {
        Self {
            first,
            keys: vec![Key::HIDDEN; len],
            counts: vec![0; levels * FACES * KINDS],
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
        let mut next = [0; KEYS];
        let mut all = 0;
        for (next, count) in next.iter_mut().zip(&self.counts) {
            *next = all;
            all += usize::from(*count);
        }
        self.order.resize(all, 0);
        for (character, key) in self.keys.iter().enumerate() {
            if let Some(key) = key.index() {
                self.order[next[key]] = (self.first + character) as u32;
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
