//! Recognition of a human without joint names, by the shape of the joint tree at rest.
//!
//! Some exporters drop joint names. Then two branches that go down to the floor on either side of a
//! joint are legs, the branch that goes up is the spine, and where that splits into three the outer
//! two are arms. Only plain rigs are accepted (3 or 4 joints per limb), and only if the hands are
//! above the knees, which excludes four-legged animals.

use super::rest;
use articula_core::Libm;
use articula_core::joint_names::JointTarget;
use articula_core::source::Skeleton;
use glam::Vec3;

/// Maximum height of a foot above the lowest joint, as a share of the figure's height.
const NEAR_FLOOR: f32 = 0.15;

const LEG: [&str; 4] = ["hip", "knee", "ankle", "metatarsal"];
const ARM: [&str; 4] = ["sternoclavicular", "shoulder", "elbow", "wrist"];

struct Tree {
    places: Vec<Vec3>,
    children: Vec<Vec<usize>>,
    low: f32,
    high: f32,
}

/// The target of each joint, if the tree has the shape of a human.
pub(super) fn human(skeleton: &Skeleton) -> Option<Vec<Option<JointTarget>>> {
    let tree = Tree::new(skeleton)?;
    (0..tree.places.len()).find_map(|joint| tree.human_from_hips(joint))
}

impl Tree {
    /// Joints of the skin alone; other nodes between them are skipped.
    fn new(skeleton: &Skeleton) -> Option<Self> {
        let joints = &skeleton.joints;
        let any_skin = joints.iter().any(|j| j.in_skin);
        let counts = |j: usize| joints[j].in_skin || !any_skin;
        let mut nearest: Vec<Option<usize>> = Vec::with_capacity(joints.len());
        let mut children = vec![Vec::new(); joints.len()];
        for (index, joint) in joints.iter().enumerate() {
            let above = joint.parent.and_then(|p| nearest[p]);
            nearest.push(if counts(index) { Some(index) } else { above });
            if let Some(parent) = above.filter(|_| counts(index)) {
                children[parent].push(index);
            }
        }
        let places = rest::positions(skeleton);
        let heights = || {
            (0..joints.len())
                .filter(|&j| counts(j))
                .map(|j| places[j].y)
        };
        let low = heights().reduce(f32::min)?;
        let high = heights().reduce(f32::max)?;
        Some(Self {
            places,
            children,
            low,
            high,
        })
    }

    fn human_from_hips(&self, hips: usize) -> Option<Vec<Option<JointTarget>>> {
        let below = |joint: usize| self.places[joint].y < self.places[hips].y;
        let floor = self.low + NEAR_FLOOR * (self.high - self.low);
        let branches = || self.children[hips].iter().map(|&c| self.chain(c));
        let is_leg = |chain: &Vec<usize>| {
            let down = chain.iter().skip(1).all(|&j| below(j));
            down && (3..=4).contains(&chain.len()) && self.lowest(chain) <= floor
        };
        let mut legs = branches().filter(is_leg);
        let (first, second) = (legs.next()?, legs.next()?);
        let spine = branches().max_by(|a, b| self.highest(a).total_cmp(&self.highest(b)))?;
        let chest = *spine.last()?;
        let mut upper: Vec<Vec<usize>> = self.children[chest]
            .iter()
            .map(|&c| self.chain(c))
            .collect();
        upper.sort_by(|a, b| self.highest(b).total_cmp(&self.highest(a)));
        let [neck, arm, other_arm] = &upper[..] else {
            return None;
        };
        let knee = self.places[first[1]].y;
        let arms = [arm, other_arm];
        let is_arm =
            |chain: &Vec<usize>| (3..=4).contains(&chain.len()) && self.lowest(chain) > knee;
        if neck.len() > 2 || !arms.iter().all(|a| is_arm(a)) {
            return None;
        }
        let left = self.left(&first);
        let mut found = vec![None; self.places.len()];
        name(&mut found, hips, "humanoid_root");
        for joint in spine {
            found[joint] = Some(JointTarget::Spine);
        }
        for (&joint, title) in neck.iter().rev().zip(["skullbase", "vc4"]) {
            name(&mut found, joint, title);
        }
        self.limbs(&mut found, [&first, &second], left, |_| &LEG);
        self.limbs(&mut found, arms, left, |chain| &ARM[4 - chain.len()..]);
        Some(found)
    }

    /// The joints from here down to where the tree ends or splits.
    fn chain(&self, from: usize) -> Vec<usize> {
        let mut chain = vec![from];
        let mut at = from;
        while let [only] = self.children[at][..] {
            chain.push(only);
            at = only;
        }
        chain
    }

    fn lowest(&self, chain: &[usize]) -> f32 {
        chain
            .iter()
            .map(|&j| self.places[j].y)
            .fold(f32::MAX, f32::min)
    }

    fn highest(&self, chain: &[usize]) -> f32 {
        chain
            .iter()
            .map(|&j| self.places[j].y)
            .fold(f32::MIN, f32::max)
    }

    /// Direction to the figure's left: the toes point forward, and without toes +Z is forward.
    fn left(&self, leg: &[usize]) -> Vec3 {
        let toes = leg
            .get(3)
            .map(|&toe| self.places[toe] - self.places[leg[2]]);
        let forward = toes
            .filter(|t| t.x.libm_hypot(t.z) > 1e-6)
            .unwrap_or(Vec3::Z);
        Vec3::Y.cross(forward)
    }

    fn limbs<'a>(
        &self,
        found: &mut [Option<JointTarget>],
        pair: [&Vec<usize>; 2],
        left: Vec3,
        titles: impl Fn(&[usize]) -> &'a [&'a str],
    ) {
        let along = |chain: &[usize]| chain.last().map_or(0.0, |&j| self.places[j].dot(left));
        let first_is_left = along(pair[0]) > along(pair[1]);
        for (chain, is_left) in pair.into_iter().zip([first_is_left, !first_is_left]) {
            let letter = if is_left { "l" } else { "r" };
            for (&joint, title) in chain.iter().zip(titles(chain)) {
                name(found, joint, &format!("{letter}_{title}"));
            }
        }
    }
}

fn name(found: &mut [Option<JointTarget>], joint: usize, title: &str) {
    found[joint] = JointTarget::standard(title);
}
