//! Preferences of regions, levels of articulation and levels of parts, as limits or as wishes.
//!
//! Source: thesis 3.2 (user preferences are part of the context). A limit holds; a wish holds as far
//! as the budget allows and never breaks a limit.

use super::part::{Part, PartKind, PartOption};

/// What an option must be like. An option that does not say its level of articulation or its
/// regions meets any rule about them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// The level is this or coarser.
    FinestLevel(u32),
    /// The level is this or finer.
    CoarsestLevel(u32),
    /// The level of articulation, by H-Anim's numbers, is at most this.
    LoaAtMost(u32),
    /// The level of articulation is at least this.
    LoaAtLeast(u32),
    /// Only regions of these bits.
    RegionsWithin(u32),
    /// At least the regions of these bits.
    RegionsWith(u32),
}

impl Rule {
    /// Returns whether an option meets the rule.
    pub fn allows(&self, option: &PartOption) -> bool {
        match *self {
            Self::FinestLevel(finest) => option.level >= finest,
            Self::CoarsestLevel(coarsest) => option.level <= coarsest,
            Self::LoaAtMost(most) => option.loa.is_none_or(|loa| loa <= most),
            Self::LoaAtLeast(least) => option.loa.is_none_or(|loa| loa >= least),
            Self::RegionsWithin(mask) => option.regions.is_none_or(|r| r & !mask == 0),
            Self::RegionsWith(mask) => option.regions.is_none_or(|r| r & mask == mask),
        }
    }
}

/// Who asks for a rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LimitSource {
    /// What can be seen from here.
    View,
    /// What the user allows.
    User,
}

/// A rule for the parts of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preference {
    /// Kind of the parts.
    pub part: PartKind,
    /// What their options must be like.
    pub rule: Rule,
    /// Who asks for it.
    pub source: LimitSource,
    /// Whether the rule gives way to budget and limits.
    pub is_wish: bool,
}

impl Preference {
    /// Returns the options that remain of those allowed, for each part; `None` if a part of the kind
    /// would have none.
    pub(super) fn narrow(&self, parts: &[Part], allowed: &[Vec<usize>]) -> Option<Vec<Vec<usize>>> {
        let of_part = |(part, allowed): (&Part, &Vec<usize>)| {
            if part.kind != self.part {
                return Some(allowed.clone());
            }
            let meets = |option: &usize| self.rule.allows(&part.options[*option]);
            let left: Vec<usize> = allowed.iter().copied().filter(meets).collect();
            (!left.is_empty()).then_some(left)
        };
        parts.iter().zip(allowed).map(of_part).collect()
    }
}
