//! How the levels of a frame are chosen.

use super::frame::{CacheUse, Culling, Detail, Frame};
use super::model::CrowdModel;
use crate::visibility::View;

/// What a choice depends on beside clip and tolerance: while it is the same, choices are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mode {
    pub(super) choosing: Choosing,
    pub(super) cache: CacheUse,
    /// Whether tolerances follow from pixels per metre, importance and scale, so that a level holds while
    /// they stay in its range.
    pub(super) keeps: bool,
    /// Whether cells in which nothing can have changed need not be looked at.
    pub(super) skips: bool,
    pub(super) is_culled: bool,
}

/// How levels are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Choosing {
    /// The same level for all.
    Fixed(usize),
    /// The cheapest option within the tolerance, kept while that stays in its range.
    Options,
}

impl Mode {
    /// That of a crowd before its first frame.
    pub(super) const NONE: Self = Self {
        choosing: Choosing::Fixed(0),
        cache: CacheUse::Never,
        keeps: false,
        skips: false,
        is_culled: false,
    };

    pub(super) fn of(model: &CrowdModel, frame: &Frame<'_>) -> Self {
        let views = match frame.culling {
            Culling::Views(views) => views,
            Culling::Off => &[],
        };
        let choosing = match frame.detail {
            Detail::Full => Choosing::Fixed(0),
            Detail::Level(level) => Choosing::Fixed(level.min(model.levels() - 1)),
            Detail::Tolerance { .. } | Detail::Within(_) => Choosing::Options,
        };
        let keeps = !model.has_attention();
        let has_margins = !frame.cull_margin_metres.is_empty();
        Self {
            choosing,
            cache: frame.cache,
            keeps,
            skips: keeps && !has_margins && !views.iter().any(View::has_occlusion),
            is_culled: matches!(frame.culling, Culling::Views(_)),
        }
    }
}
