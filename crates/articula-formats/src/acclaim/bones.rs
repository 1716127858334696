//! Conversion of any joint tree into Acclaim bones: each bone has one end, and its children start
//! there.
//!
//! A joint whose children start at several positions ends at one of them; the others are attached
//! by connecting bones that do not move, like `lhipjoint` and `rhipjoint` in the CMU files. The
//! root has no length.

use crate::sampled::Place;
use articula_core::source::Skeleton;
use glam::Vec3;
use std::collections::HashMap;

/// Positions closer than this fraction of the figure's size are equal.
const SAME: f32 = 1e-7;

/// A bone to write.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bone {
    pub(super) name: String,
    /// Bone at whose end this one starts; `None` for the root.
    pub(super) parent: Option<usize>,
    /// Joint at its start; `None` for a connecting bone.
    pub(super) joint: Option<usize>,
    /// Offset from start to end at rest, in model space, in metres.
    pub(super) way: Vec3,
}

/// All bones, parents before children.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Bones {
    /// The joint that is the root; `None` if there are several, which are then children of a root
    /// that does not move.
    pub(super) root: Option<usize>,
    pub(super) list: Vec<Bone>,
    /// Parent of every joint among the written joints; `None` also for joints that are not written.
    pub(super) joint_above: Vec<Option<usize>>,
    /// Number of joints whose name had to be changed.
    pub(super) renamed: usize,
    /// Number of end sites that could not be written.
    pub(super) sites_left_out: usize,
}

/// Makes the bones of the joints of `order` (each followed by its descendants). End sites are
/// offsets in the joints' local spaces.
pub(super) fn build(
    skeleton: &Skeleton,
    order: &[usize],
    rest: &[Place],
    end_sites: &[(usize, Vec3)],
) -> Bones {
    let mut builder = Builder::new(skeleton, order, rest, end_sites);
    let roots = builder.roots(order);
    if let [root] = roots[..] {
        builder.bones.root = Some(root);
        builder.bones.sites_left_out += builder.sites[root].len();
        builder.hang_children(root, None, Vec3::ZERO);
    } else {
        for root in roots {
            builder.start[root] = Some((None, rest[root].position));
        }
    }
    for &joint in order {
        if let Some((parent, offset)) = builder.start[joint] {
            builder.bone(joint, parent, offset);
        }
    }
    builder.bones
}

struct Builder<'a> {
    skeleton: &'a Skeleton,
    rest: &'a [Place],
    children: Vec<Vec<usize>>,
    /// Offsets in model space, by joint.
    sites: Vec<Vec<Vec3>>,
    same_metres: f32,
    /// Names in lower case, with the number of the next copy.
    taken: HashMap<String, usize>,
    bones: Bones,
    /// For joints whose parent is made: the parent bone, and the offset of their start from its
    /// end.
    start: Vec<Option<(Option<usize>, Vec3)>>,
}

impl<'a> Builder<'a> {
    fn new(
        skeleton: &'a Skeleton,
        order: &[usize],
        rest: &'a [Place],
        end_sites: &[(usize, Vec3)],
    ) -> Self {
        let count = skeleton.joints.len();
        let mut children = vec![Vec::new(); count];
        for &joint in order {
            if let Some(parent) = skeleton.joints[joint].parent {
                children[parent].push(joint);
            }
        }
        let mut sites = vec![Vec::new(); count];
        for (joint, offset) in end_sites {
            if let Some(list) = sites.get_mut(*joint) {
                list.push(rest[*joint].rotation * *offset);
            }
        }
        let places = order.iter().map(|&j| rest[j].position);
        let (low, high) = places.fold((Vec3::MAX, Vec3::MIN), |(l, h), p| (l.min(p), h.max(p)));
        Self {
            skeleton,
            rest,
            children,
            sites,
            same_metres: SAME * (high - low).max_element(),
            taken: ["root", "begin", "end"].map(|n| (n.to_owned(), 2)).into(),
            bones: Bones {
                joint_above: vec![None; count],
                ..Bones::default()
            },
            start: vec![None; count],
        }
    }

    /// Returns the roots. Nodes above a skin with a single child joint are skipped: their motion
    /// becomes the motion of that joint.
    fn roots(&self, order: &[usize]) -> Vec<usize> {
        let joints = &self.skeleton.joints;
        let any_skin = joints.iter().any(|j| j.in_skin);
        let all = order.iter().filter(|&&j| joints[j].parent.is_none());
        let lowered = all.map(|&root| {
            let mut root = root;
            while let ([child], true) =
                (&self.children[root][..], any_skin && !joints[root].in_skin)
            {
                root = *child;
            }
            root
        });
        lowered.collect()
    }

    /// Attaches the children of a joint to the end of its bone.
    fn hang_children(&mut self, joint: usize, bone: Option<usize>, way: Vec3) {
        for &child in &self.children[joint] {
            self.bones.joint_above[child] = Some(joint);
            self.start[child] = Some((bone, self.rest[child].from_parent - way));
        }
    }

    /// Makes the bone of a joint, and a connecting bone before it if it does not start at the end
    /// of another.
    fn bone(&mut self, joint: usize, parent: Option<usize>, offset: Vec3) {
        let own = &self.skeleton.joints[joint].name;
        let name = self.unique(own, joint);
        self.bones.renamed += usize::from(name != *own);
        let mut parent = parent;
        if offset.length() > self.same_metres {
            let above = parent.map_or("root", |p| self.bones.list[p].name.as_str());
            let between = self.unique(&format!("{above}_to_{name}"), joint);
            parent = Some(self.push(between, parent, None, offset));
        }
        let way = self.end(joint);
        let bone = self.push(name, parent, Some(joint), way);
        let sites = &self.sites[joint];
        self.bones.sites_left_out += sites.len() - usize::from(sites.contains(&way));
        self.hang_children(joint, Some(bone), way);
    }

    fn push(
        &mut self,
        name: String,
        parent: Option<usize>,
        joint: Option<usize>,
        way: Vec3,
    ) -> usize {
        self.bones.list.push(Bone {
            name,
            parent,
            joint,
            way,
        });
        self.bones.list.len() - 1
    }

    /// Returns the end of a joint's bone: the child that continues in the straightest line, or the
    /// first end site.
    fn end(&self, joint: usize) -> Vec3 {
        let children = &self.children[joint];
        if children.is_empty() {
            return self.sites[joint].first().copied().unwrap_or_default();
        }
        let before = self.rest[joint].from_parent.normalize_or_zero();
        let offsets = children.iter().map(|&c| self.rest[c].from_parent);
        let straightness = |way: &Vec3| way.normalize_or_zero().dot(before);
        let long = offsets.filter(|way| way.length() > self.same_metres);
        // The search runs backwards so that the first of equals wins.
        let mut long: Vec<Vec3> = long.collect();
        long.reverse();
        let best = long
            .into_iter()
            .max_by(|a, b| straightness(a).total_cmp(&straightness(b)));
        best.unwrap_or_default()
    }

    /// Returns a valid name that no other bone has.
    fn unique(&mut self, name: &str, joint: usize) -> String {
        let odd = |c: char| c.is_whitespace() || c.is_control() || "#,()".contains(c);
        let mut plain = name.trim().replace(odd, "_");
        // A leading colon would make it a keyword.
        if plain.starts_with(':') {
            plain.replace_range(..1, "_");
        }
        // A number alone would be read as a frame number.
        if plain.bytes().all(|b| b.is_ascii_digit()) {
            plain = format!("joint_{joint}");
        }
        let stem = plain.to_ascii_lowercase();
        let mut unique = plain.clone();
        while self.taken.contains_key(&unique.to_ascii_lowercase()) {
            let copy = self.taken.entry(stem.clone()).or_insert(2);
            unique = format!("{plain}_{copy}");
            *copy += 1;
        }
        self.taken.insert(unique.to_ascii_lowercase(), 2);
        unique
    }
}
