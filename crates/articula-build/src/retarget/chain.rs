//! Spines and necks of any number of joints: the position of each joint along the chain, and its
//! share of the bend.
//!
//! A chain's orientation is known at its segments; a target joint takes the orientation at the
//! middle of its segment, measured in rest length from pelvis to chest (and from chest to head).
//! The last joint of the chain always agrees with the last one of the source, so that shoulders and
//! head point in the same direction.

use super::body::Body;
use super::rest::Rest;

/// The joints of trunk and neck, lowest first.
#[derive(Debug, Clone, Default)]
pub(super) struct Chain {
    pelvis: usize,
    /// Each joint with the position of its segment's middle, 0 at the pelvis and 1 for the last.
    spine: Vec<(usize, f32)>,
    /// Likewise from chest to head.
    neck: Vec<(usize, f32)>,
    head: Option<usize>,
}

impl Chain {
    pub(super) fn new(rest: &Rest, body: &Body) -> Self {
        let mut chain = Self {
            pelvis: body.pelvis,
            ..Self::default()
        };
        let last_vertebra = || {
            (0..rest.len())
                .rev()
                .find(|j| is_vertebra(rest.title(*j), &["vt", "vl"]))
        };
        let Some(top) = rest.spine_top().or_else(last_vertebra) else {
            return chain;
        };
        let Some(mut path) = rest.between(body.root, top) else {
            return chain;
        };
        path.push(top);
        let lower = |j: &usize| rest.title(*j) == "sacroiliac";
        let first = path.iter().rposition(lower).map_or(0, |i| i + 1);
        let in_spine = |j: &usize| is_vertebra(rest.title(*j), &["vt", "vl"]);
        let split = path
            .iter()
            .rposition(in_spine)
            .map_or(first, |i| i + 1)
            .max(first);
        let start = if first > 0 {
            path[first - 1]
        } else {
            body.root
        };
        let after = path.get(split).copied();
        chain.spine = segment_midpoints(rest, start, &path[first..split], after);
        let head = (rest.title(top) == "skullbase").then_some(top);
        let neck_end = path.len() - usize::from(head.is_some());
        let base = path[..split].last().copied().unwrap_or(start);
        chain.neck = segment_midpoints(rest, base, &path[split.min(neck_end)..neck_end], head);
        chain.head = head;
        chain
    }

    /// The last joint of the spine, from which collars hang.
    pub(super) fn chest(&self) -> Option<usize> {
        self.spine.last().map(|s| s.0)
    }

    fn base_of_neck(&self) -> usize {
        self.chest().unwrap_or(self.pelvis)
    }
}

fn is_vertebra(title: &str, kinds: &[&str]) -> bool {
    kinds.iter().any(|kind| {
        title
            .strip_prefix(kind)
            .is_some_and(|n| n.parse::<u8>().is_ok())
    })
}

/// Midpoints of the joints' segments by rest length from `start`, scaled so that the last is 1.
fn segment_midpoints(
    rest: &Rest,
    start: usize,
    joints: &[usize],
    end: Option<usize>,
) -> Vec<(usize, f32)> {
    let mut at = 0.0;
    let mut last = start;
    let mut places = Vec::with_capacity(joints.len());
    for (i, &joint) in joints.iter().enumerate() {
        at += rest.way(last, joint).length();
        last = joint;
        let next = joints.get(i + 1).copied().or(end);
        let segment = next.map_or(0.0, |n| rest.way(joint, n).length());
        places.push((joint, at + 0.5 * segment));
    }
    let whole = places.last().map_or(0.0, |p| p.1);
    let count = places.len() as f32;
    for (i, place) in places.iter_mut().enumerate() {
        place.1 = if whole > 1e-6 {
            place.1 / whole
        } else {
            (i + 1) as f32 / count
        };
    }
    places
}

/// Two source joints and the share of the second.
type Share = (usize, usize, f32);

/// The source joints of each joint of the target's chain: `None` if the source has no such part.
pub(super) fn shares(source: &Chain, target: &Chain) -> Vec<(usize, Option<Share>)> {
    let mut shares = parts(&source.spine, source.pelvis, &target.spine);
    let top = source.base_of_neck();
    if source.neck.is_empty() {
        // Between chest and head: halfway for one joint, thirds for two.
        let count = target.neck.len() as f32 + 1.0;
        for (i, &(joint, _)) in target.neck.iter().enumerate() {
            let share = source.head.map(|h| (top, h, (i + 1) as f32 / count));
            shares.push((joint, share));
        }
    } else {
        shares.extend(parts(&source.neck, top, &target.neck));
    }
    shares
}

fn parts(
    source: &[(usize, f32)],
    base: usize,
    target: &[(usize, f32)],
) -> Vec<(usize, Option<Share>)> {
    if source.len() == target.len() {
        let pairs = source.iter().zip(target);
        return pairs.map(|(s, t)| (t.0, Some((s.0, s.0, 0.0)))).collect();
    }
    target
        .iter()
        .map(|&(joint, place)| (joint, at(source, base, place)))
        .collect()
}

fn at(source: &[(usize, f32)], base: usize, place: f32) -> Option<Share> {
    let last = source.last()?;
    let after = source.iter().position(|s| s.1 >= place - 1e-6);
    let Some(after) = after else {
        return Some((last.0, last.0, 0.0));
    };
    let (low, low_place) = if after == 0 {
        (base, 0.0)
    } else {
        source[after - 1]
    };
    let (high, high_place) = source[after];
    let span = high_place - low_place;
    let share = if span > 1e-6 {
        ((place - low_place) / span).clamp(0.0, 1.0)
    } else {
        1.0
    };
    Some((low, high, share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_joints_pair_up() {
        let source = [(3, 0.2), (4, 1.0)];
        let target = [(7, 0.5), (8, 1.0)];
        let pairs = parts(&source, 0, &target);
        assert_eq!(pairs, [(7, Some((3, 3, 0.0))), (8, Some((4, 4, 0.0)))]);
    }

    #[test]
    fn other_counts_take_shares_by_length() {
        let source = [(3, 0.5), (4, 1.0)];
        assert_eq!(at(&source, 0, 0.25), Some((0, 3, 0.5)));
        assert_eq!(at(&source, 0, 0.75), Some((3, 4, 0.5)));
        assert_eq!(at(&source, 0, 1.0), Some((3, 4, 1.0)));
        assert_eq!(at(&[], 0, 1.0), None, "a source without a spine");
    }
}
