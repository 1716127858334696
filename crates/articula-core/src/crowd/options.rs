//! Options of a character: levels with the source of the pose and the morph level, each with its
//! error and its cost.
//!
//! Source: `docs/methods/runtime.md` 4.1. The lists are made with the model, finest first. An option
//! that costs the frame as much as one with no greater error is left out, so along a list the error rises
//! and the cost of the frame falls, and the cheapest option within a tolerance is the last one within it.

use super::frame::CacheUse;
use super::parts::CrowdParts;
use super::sources::{FACES, KINDS, Source};

/// Nanoseconds of a set of morph target weights, on the machine of `docs/methods/runtime.md` part 1, and
/// of each target in it that is shown.
const MORPH_SET_NS: f32 = 20.0;
const MORPH_NS: f32 = 1.5;
/// What a triangle counts beside nanoseconds of this processor: a weight between what is posed and what is
/// drawn, by which a cached pose of a fine mesh costs more than a blended one of a coarse mesh.
const TRIANGLE_NS: f32 = 0.05;
/// What a level is preferred by before a finer one of equal cost, which differs in the mesh alone.
const MESH_NS: f32 = 1e-3;

/// What options are chosen by: the time of the processor, alone or with what is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CostOf {
    Frame,
    Processor,
}

/// One way to show a character.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DetailOption {
    pub(crate) level: u8,
    pub(crate) source: Source,
    /// Morph level; 0 at levels that show no morph targets.
    pub(crate) morphs: u8,
    /// Error of the level, of the source and of the morph level together, metres.
    pub(crate) error_metres: f32,
    /// Expected nanoseconds of this processor, by kind of work.
    pub(crate) costs_ns: [f32; KINDS],
    /// Their sum with what the renderer draws: by it options are chosen.
    pub(crate) frame_ns: f32,
}

/// Options of every clip for one use of the cache.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OptionLists {
    /// All lists, one after the other.
    options: Vec<DetailOption>,
    /// Index of the first option of each clip, and the number of all.
    first: Vec<u32>,
}

impl OptionLists {
    /// Lists the options of all clips. `errors` are those of the levels, for each clip as many.
    pub(crate) fn new(
        parts: &CrowdParts,
        errors: &[f32],
        cache_use: CacheUse,
        cost: CostOf,
    ) -> Self {
        let levels = parts.clips.joint_lods().levels();
        let mut lists = Self {
            options: Vec::new(),
            first: vec![0],
        };
        for (clip, errors) in errors.chunks(levels).enumerate() {
            let all = (0..levels).flat_map(|level| {
                let sources = Source::of_levels(cache_use).iter().copied();
                sources.filter_map(move |source| {
                    let added = source.added_metres(parts, clip, level)?;
                    let cost_ns = source.cost_ns(parts, level);
                    Some(DetailOption {
                        level: level as u8,
                        source,
                        morphs: 0,
                        error_metres: errors[level] + added,
                        costs_ns: of_kind(source.kind(), cost_ns),
                        frame_ns: cost_ns + cost.drawn_ns(parts, level),
                    })
                })
            });
            let mut all = with_morph_levels(parts, clip, all.collect());
            all.extend(impostor(parts, cache_use, clip, levels));
            let mut kept = undominated(all);
            // A character keeps its option in a byte.
            kept.truncate(usize::from(u8::MAX));
            lists.options.extend(kept);
            lists.first.push(lists.options.len() as u32);
        }
        lists
    }

    /// Options of a clip, finest first.
    #[inline]
    pub(crate) fn of(&self, clip: usize) -> &[DetailOption] {
        &self.options[self.first[clip] as usize..self.first[clip + 1] as usize]
    }
}

/// The options of which none else is as cheap with no greater error, by rising error.
fn undominated(mut all: Vec<DetailOption>) -> Vec<DetailOption> {
    all.sort_by(|a, b| {
        let by_error = a.error_metres.total_cmp(&b.error_metres);
        by_error.then(a.frame_ns.total_cmp(&b.frame_ns))
    });
    let mut least_ns = f32::INFINITY;
    all.retain(|option| {
        let is_cheaper = option.frame_ns < least_ns;
        least_ns = least_ns.min(option.frame_ns);
        is_cheaper
    });
    // Of equal errors the cheapest came first, so errors rise.
    all
}

/// Each option of a clip at every morph level, where its level shows morph targets.
///
/// Errors are added: the maximum over vertices of both together is at most the sum of the maxima, and
/// so is half of it; the percentile is, as far as faces and bodies err at different vertices.
fn with_morph_levels(
    parts: &CrowdParts,
    clip: usize,
    options: Vec<DetailOption>,
) -> Vec<DetailOption> {
    let Some(morphs) = &parts.morphs else {
        return options;
    };
    let errors = morphs.lods().errors_metres(clip);
    let at_each = options.into_iter().flat_map(|option| {
        let shows = usize::from(option.level) < morphs.levels();
        let errors = if shows { errors } else { &[0.0][..] };
        let level = usize::from(option.level);
        let each = errors.iter().enumerate();
        each.map(move |(morph_level, error)| {
            let face_ns = morphs_ns(parts, level, morph_level);
            let mut costs_ns = option.costs_ns;
            costs_ns[FACES] = face_ns;
            DetailOption {
                morphs: morph_level as u8,
                error_metres: option.error_metres + error,
                costs_ns,
                frame_ns: option.frame_ns + face_ns,
                ..option
            }
        })
    });
    at_each.collect()
}

/// Nanoseconds of one kind of work.
fn of_kind(kind: usize, ns: f32) -> [f32; KINDS] {
    let mut costs = [0.0; KINDS];
    costs[kind] = ns;
    costs
}

impl CostOf {
    /// What drawing a level counts.
    fn drawn_ns(self, parts: &CrowdParts, level: usize) -> f32 {
        let levels = parts.clips.joint_lods().levels();
        let triangles = match self {
            Self::Frame => parts.triangles.get(level).copied().unwrap_or(0),
            Self::Processor => 0,
        };
        TRIANGLE_NS * triangles as f32 + MESH_NS * (levels - level) as f32
    }
}

/// Nanoseconds of the morph target weights of a level at a morph level.
pub(crate) fn morphs_ns(parts: &CrowdParts, level: usize, morph_level: usize) -> f32 {
    let morphs = parts.morphs.as_ref().filter(|m| level < m.levels());
    match morphs.map_or(0, |m| m.lods().count(morph_level)) {
        0 => 0.0,
        shown => MORPH_SET_NS + MORPH_NS * shown as f32,
    }
}

/// An impostor, if the clip has one. It counts as of the coarsest level with a face at rest, and is
/// preferred before its cached poses, which have more vertices.
fn impostor(
    parts: &CrowdParts,
    cache_use: CacheUse,
    clip: usize,
    levels: usize,
) -> Option<DetailOption> {
    let impostors = parts.impostors.as_ref();
    let impostors = impostors.filter(|_| cache_use != CacheUse::Never)?;
    let level = levels - 1;
    let morphs = parts.morphs.as_ref();
    let faces = morphs.map_or(&[][..], |m| m.lods().errors_metres(clip));
    let shows = morphs.is_some_and(|m| level < m.levels());
    let cost_ns = Source::Impostor.cost_ns(parts, level);
    Some(DetailOption {
        level: level as u8,
        source: Source::Impostor,
        // The last morph level shows no target.
        morphs: if shows { faces.len() as u8 - 1 } else { 0 },
        error_metres: impostors.error_metres(clip)? + faces.last().copied().unwrap_or(0.0),
        costs_ns: of_kind(Source::Impostor.kind(), cost_ns),
        frame_ns: cost_ns,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn option((error_metres, cost_ns): (f32, f32)) -> DetailOption {
        DetailOption {
            level: 0,
            source: Source::Clip,
            morphs: 0,
            error_metres,
            costs_ns: of_kind(0, cost_ns),
            frame_ns: cost_ns,
        }
    }

    #[test]
    fn dominated_options_by_hand() {
        let all = [
            (0.0, 9.0),
            (2.0, 5.0),
            (1.0, 5.0),
            (0.0, 8.0),
            (3.0, 5.5),
            (4.0, 1.0),
        ];
        let kept = undominated(all.map(option).to_vec());
        let expected = [(0.0, 8.0), (1.0, 5.0), (4.0, 1.0)].map(option);
        assert_eq!(kept, expected);
    }

    proptest! {
        /// For any tolerance the last option within it is as cheap as any.
        #[test]
        fn the_cheapest_within_a_tolerance_is_the_last(
            all in prop::collection::vec((0.0f32..9.0, 0.0f32..9.0), 0..20),
            tolerance in 0.0f32..9.0,
        ) {
            let all: Vec<_> = all.into_iter().map(option).collect();
            let kept = undominated(all.clone());
            for pair in kept.windows(2) {
                prop_assert!(pair[0].error_metres < pair[1].error_metres);
                prop_assert!(pair[0].frame_ns > pair[1].frame_ns);
            }
            let within = |o: &&DetailOption| o.error_metres <= tolerance;
            let least = all.iter().filter(within).map(|o| o.frame_ns).min_by(f32::total_cmp);
            let last = kept.iter().rfind(within).map(|o| o.frame_ns);
            prop_assert_eq!(last, least);
        }
    }
}
