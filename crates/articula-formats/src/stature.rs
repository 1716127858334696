//! Stature of a figure from the lengths of its bones, for files whose zero rotations are no
//! standing figure.
//!
//! Lengths do not depend on the zero pose, and the longest paths of the tree need no joint names.
//! Source of the factors: measured on humanoid figures of the test data; see `docs/formats/bvh.md`.

/// Stature as a fraction of the longest path that starts at the head joint, which ends at a toe.
const OF_HEAD_PATH: f32 = 1.0 / 1.12;
/// Stature as a fraction of the longest path between two ends, from a toe to a hand.
const OF_LONGEST_PATH: f32 = 1.0 / 1.56;
/// Longest path of a human, as a multiple of the longest path from the head joint.
const HUMAN: std::ops::RangeInclusive<f32> = 1.25..=1.65;
/// Branches whose lengths differ by at most this fraction are a pair of limbs.
const PAIR: f32 = 0.07;
/// Minimum length of a pair of limbs, as a fraction of the longest path.
const LIMB: f32 = 0.2;

/// Bones as a forest, parents before children; end sites are bones too.
pub(crate) struct Bones {
    pub(crate) parents: Vec<Option<usize>>,
    /// Length of the bone from the parent's joint to this one; 0 for a root.
    pub(crate) lengths: Vec<f32>,
}

/// What the lengths of the bones say about a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stature {
    /// The height of a standing human with bones of these lengths, in the unit of the lengths.
    Human(f32),
    /// Not a human; the height of a human with the same longest path.
    Other(f32),
}

impl Bones {
    /// Measures the figure; `head` is the head joint, if a joint has such a name.
    pub(crate) fn stature(&self, head: Option<usize>) -> Stature {
        let branches = self.branches();
        let longest = branches.iter().map(|b| first_two(b)).fold(0.0, f32::max);
        let from_longest = longest * OF_LONGEST_PATH;
        match head.map(|head| self.longest_from(head, &branches).0) {
            Some(path) if HUMAN.contains(&(longest / path)) => Stature::Human(path * OF_HEAD_PATH),
            None if has_limbs(&branches, longest) => Stature::Human(from_longest),
            _ => Stature::Other(from_longest),
        }
    }

    /// Returns the length of the longest path from a joint that leads to its parent first, and the
    /// bone at its end; for the head joint of a human, a toe.
    pub(crate) fn path_from(&self, joint: usize) -> (f32, usize) {
        self.longest_from(joint, &self.branches())
    }

    /// Returns for every joint the longest path through each of its children, longest first.
    fn branches(&self) -> Vec<Vec<(f32, usize)>> {
        let mut branches: Vec<Vec<(f32, usize)>> = vec![Vec::new(); self.parents.len()];
        for joint in (0..self.parents.len()).rev() {
            branches[joint].sort_by(|a, b| b.0.total_cmp(&a.0));
            if let Some(parent) = self.parents[joint] {
                let below = branches[joint].first().map_or(0.0, |b| b.0);
                branches[parent].push((self.lengths[joint] + below, joint));
            }
        }
        branches
    }

    fn longest_from(&self, joint: usize, branches: &[Vec<(f32, usize)>]) -> (f32, usize) {
        let (mut at, mut climbed) = (joint, 0.0);
        // Length, and the joint at which the path turns down into a branch, with that branch.
        let (mut longest, mut end, mut branch) = (0.0, joint, None);
        while let Some(parent) = self.parents[at] {
            climbed += self.lengths[at];
            if climbed > longest {
                (longest, end, branch) = (climbed, parent, None);
            }
            let other = branches[parent].iter().find(|b| b.1 != at);
            if let Some(&(below, child)) = other
                && climbed + below > longest
            {
                (longest, branch) = (climbed + below, Some(child));
            }
            at = parent;
        }
        while let Some(child) = branch {
            end = child;
            branch = branches[child].first().map(|b| b.1);
        }
        (longest, end)
    }
}

fn first_two(branches: &[(f32, usize)]) -> f32 {
    branches.iter().take(2).map(|b| b.0).sum()
}

/// Returns whether two joints have a pair of limbs each, as pelvis and chest have.
fn has_limbs(branches: &[Vec<(f32, usize)>], longest: f32) -> bool {
    let paired = |of_joint: &&Vec<(f32, usize)>| {
        of_joint.windows(2).any(|pair| {
            let [long, short] = [pair[0].0, pair[1].0];
            short > LIMB * longest && short >= (1.0 - PAIR) * long
        })
    };
    longest > 0.0 && branches.iter().filter(paired).count() >= 2
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pelvis with two legs, and a trunk with two arms and a head; `arm` is the length of an arm.
    fn figure(arm: f32) -> Bones {
        Bones {
            // Pelvis, trunk, head, arms, legs, feet.
            parents: [
                None,
                Some(0),
                Some(1),
                Some(1),
                Some(1),
                Some(0),
                Some(0),
                Some(5),
                Some(6),
            ]
            .into(),
            lengths: [0.0, 0.5, 0.2, arm, arm, 0.9, 0.9, 0.2, 0.2].into(),
        }
    }

    #[test]
    fn paths_by_hand() {
        // Head to toe: 0.2 + 0.5 + 0.9 + 0.2; toe to hand: 0.2 + 0.9 + 0.5 + 0.8.
        assert_eq!(
            figure(0.8).stature(Some(2)),
            Stature::Human(1.8 * OF_HEAD_PATH)
        );
        assert_eq!(
            figure(0.8).stature(None),
            Stature::Human(2.4 * OF_LONGEST_PATH)
        );
        // From the head to a foot; from a foot to a hand, or with short arms to the other foot.
        let far_end = |arm, joint| figure(arm).path_from(joint).1;
        assert!([7, 8].contains(&far_end(0.8, 2)));
        assert!([3, 4].contains(&far_end(0.8, 7)));
        assert_eq!(far_end(0.3, 7), 8);
        // Arms as short as a dog's neck.
        assert!(matches!(figure(0.3).stature(Some(2)), Stature::Other(_)));
        let chain = Bones {
            parents: vec![None, Some(0), Some(1)],
            lengths: vec![0.0, 1.0, 2.0],
        };
        assert_eq!(chain.stature(None), Stature::Other(3.0 * OF_LONGEST_PATH));
        let point = Bones {
            parents: vec![None],
            lengths: vec![0.0],
        };
        assert_eq!(point.stature(Some(0)), Stature::Other(0.0));
    }
}
