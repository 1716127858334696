//! Inserting and removing joints of a character, with everything that refers to joints.

use super::motion::{Into, Merge};
use super::skin::{drop_from_skin, list_inserted, skins};
use super::{InsertedJoint, MergedJoint, Place};
use crate::clip::check;
use crate::clip_edit::channel;
use crate::clip_edit::similarity::Similarity;
use articula_core::hanim_table::HanimJoint;
use articula_core::source::{
    Character, Interpolation, Joint, Property, RawClip, renumber_influences,
};
use articula_core::{Articulation, JointArticulation, Mismatch, Rig, Transform};
use glam::Vec3;
use std::collections::BTreeSet;

/// A character whose joints change.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    pub(super) character: Character,
    pub(super) joints: Vec<JointArticulation>,
    pub(super) ends: Vec<(usize, Vec3)>,
    /// Index in the beginning of each joint that was there.
    pub(super) before: Vec<Option<usize>>,
    /// Indices in the beginning of the joints that were removed.
    pub(super) removed: BTreeSet<usize>,
    /// The same of the joints that took their rotation and skin.
    pub(super) taking: BTreeSet<usize>,
}

impl Tree {
    pub(super) fn new(
        character: &Character,
        articulation: &Articulation,
        ends: &[(usize, Vec3)],
    ) -> Result<Self, Mismatch> {
        let count = Rig::new(&character.skeleton, articulation.clone())?.len();
        consistent(character, ends, count)?;
        Ok(Self {
            character: character.clone(),
            joints: articulation.joints.clone(),
            ends: ends.to_vec(),
            before: (0..count).map(Some).collect(),
            removed: BTreeSet::new(),
            taking: BTreeSet::new(),
        })
    }

    /// The joint of an H-Anim name.
    pub(super) fn find(&self, hanim: &str) -> Option<usize> {
        let is = |joint: &JointArticulation| joint.hanim.as_deref() == Some(hanim);
        self.joints.iter().position(is)
    }

    fn joint(&self, joint: usize) -> &Joint {
        &self.character.skeleton.joints[joint]
    }

    /// The place directly above a joint, if `above` is among its ancestors and the joint to be
    /// inserted is missing.
    pub(super) fn place_above(&self, missing: &str, below: &str, above: &str) -> Option<Place> {
        let child = self.child_towards(missing, below, above)?.1;
        let parent = self.joint(child).parent?;
        Some(Place { parent, child })
    }

    /// The place directly below a joint, towards a joint below it, if the joint to be inserted is
    /// missing.
    pub(super) fn place_below(&self, missing: &str, below: &str, above: &str) -> Option<Place> {
        let child = self.child_towards(missing, below, above)?.0;
        let parent = self.joint(child).parent?;
        Some(Place { parent, child })
    }

    /// The child of `above` on the way to `below`, and `below` itself.
    fn child_towards(&self, missing: &str, below: &str, above: &str) -> Option<(usize, usize)> {
        if self.find(missing).is_some() {
            return None;
        }
        let (joint, above) = (self.find(below)?, self.find(above)?);
        let mut child = joint;
        while let Some(parent) = self.joint(child).parent {
            if parent == above {
                return Some((child, joint));
            }
            child = parent;
        }
        None
    }

    fn children(&self, of: usize) -> Vec<usize> {
        let joints = self.character.skeleton.joints.iter().enumerate();
        let children = joints.filter(|(_, joint)| joint.parent == Some(of));
        children.map(|(j, _)| j).collect()
    }

    /// Whether a joint with an H-Anim name hangs from the parent of a place by another child.
    pub(super) fn has_other_branch(&self, Place { parent, child }: Place) -> bool {
        let joints = &self.character.skeleton.joints;
        let mut is_other = vec![false; joints.len()];
        for (j, joint) in joints.iter().enumerate() {
            is_other[j] = match joint.parent {
                Some(above) if above == parent => j != child,
                Some(above) => is_other[above],
                None => false,
            };
        }
        let named = self.joints.iter().map(|entry| entry.hanim.is_some());
        is_other
            .into_iter()
            .zip(named)
            .any(|(other, named)| other && named)
    }

    /// Inserts a joint that does not turn at rest.
    pub(super) fn insert(
        &mut self,
        row: &HanimJoint,
        Place { parent, child }: Place,
        offset: Vec3,
    ) -> InsertedJoint {
        let new = child;
        self.renumber(&|joint| joint + usize::from(joint >= new));
        let joints = &mut self.character.skeleton.joints;
        let below = &mut joints[child];
        below.parent = Some(new);
        below.rest.translation -= offset;
        let inserted = InsertedJoint {
            joint: new,
            name: row.name.to_owned(),
            parent,
            child_name: below.name.clone(),
            child_rest: below.rest,
            parent_name: joints[parent].name.clone(),
            offset,
        };
        let joint = Joint {
            name: row.name.to_owned(),
            parent: Some(parent),
            rest: Transform::from_translation(offset),
            in_skin: joints[child].in_skin,
        };
        joints.insert(new, joint);
        self.before.insert(new, None);
        let entry = JointArticulation {
            hanim: Some(row.name.to_owned()),
            level: row.level,
            region: row.region,
        };
        self.joints.insert(new, entry);
        for skin in skins(&mut self.character) {
            list_inserted(skin, &inserted);
        }
        let channels = self
            .character
            .clips
            .iter_mut()
            .flat_map(|c| &mut c.channels);
        let moves = |c: &&mut articula_core::source::Channel| {
            c.property == Property::Translation && c.target == new + 1
        };
        for channel in channels.filter(moves) {
            for key in 0..channel.times_secs.len() {
                let value = channel::key_value_mut(channel, key);
                value
                    .iter_mut()
                    .zip(offset.to_array())
                    .for_each(|(v, o)| *v -= o);
            }
        }
        inserted
    }

    /// Removes a joint; its parent takes its rotation. `None` if it has no parent.
    pub(super) fn merge_into_parent(
        &mut self,
        joint: usize,
    ) -> Result<Option<MergedJoint>, Mismatch> {
        let Some(parent) = self.joint(joint).parent else {
            return Ok(None);
        };
        self.merge(joint, parent, parent, Into::Parent).map(Some)
    }

    /// Removes a joint; its children take its motion, and the one towards the joint named `wanted`
    /// its skin. `None` if it has no parent.
    pub(super) fn merge_into_children(
        &mut self,
        joint: usize,
        wanted: &str,
    ) -> Result<Option<MergedJoint>, Mismatch> {
        let Some(parent) = self.joint(joint).parent else {
            return Ok(None);
        };
        let mut towards = self.find(wanted);
        while let Some(child) = towards
            && self.joint(child).parent != Some(joint)
        {
            towards = self.joint(child).parent;
        }
        let first = self.children(joint).first().copied();
        let into = towards.or(first).unwrap_or(parent);
        self.merge(joint, parent, into, Into::Children).map(Some)
    }

    fn merge(
        &mut self,
        joint: usize,
        parent: usize,
        into: usize,
        rule: Into,
    ) -> Result<MergedJoint, Mismatch> {
        let children = self.children(joint);
        let siblings = self.children(parent).into_iter().filter(|s| *s != joint);
        let merge = Merge {
            skeleton: &self.character.skeleton,
            joint,
            parent,
            children: children.clone(),
            siblings: siblings.collect(),
            into: rule,
        };
        self.check_expressions(joint)?;
        let clips = self.character.clips.iter();
        let clips = clips
            .map(|clip| merge.clip(clip))
            .collect::<Result<_, _>>()?;
        let rest = merge.even(joint)?;
        self.character.clips = clips;
        let joints = &mut self.character.skeleton.joints;
        let of_parent = joints[joint].rest;
        let into_name = joints[into].name.clone();
        let of_receiver = if into == parent {
            rest
        } else {
            Similarity::of(joints[into].rest).inverse()
        };
        let children = children.into_iter().map(|child| {
            joints[child].parent = Some(parent);
            joints[child].rest = rest.after(joints[child].rest);
            (child, joints[child].rest)
        });
        let merged = MergedJoint {
            children: children.collect(),
            joint,
            parent,
            into,
            into_name,
            rest: of_receiver.transform(),
            name: joints[joint].name.clone(),
        };
        self.move_bindings(&merged, rest);
        for (end, offset) in self.ends.iter_mut().filter(|(end, _)| *end == joint) {
            (*end, *offset) = (parent, of_parent.to_affine().transform_point3(*offset));
        }
        self.move_skin(&merged);
        self.character.skeleton.joints.remove(joint);
        self.joints.remove(joint);
        self.taking.extend(self.before[into]);
        self.removed.extend(self.before.remove(joint));
        self.renumber(&|other| other - usize::from(other > joint));
        Ok(merged)
    }

    fn check_expressions(&self, joint: usize) -> Result<(), Mismatch> {
        let mut expressions = self.character.expressions.iter();
        let moves =
            |e: &&articula_core::source::Expression| e.joints.iter().any(|b| b.joint == joint);
        match expressions.find(moves) {
            None => Ok(()),
            Some(expression) => {
                let name = &self.joint(joint).name;
                let what = format!("it moves the joint \"{name}\", which the scheme does not have");
                Err(Mismatch::new(
                    format!("expression \"{}\"", expression.name),
                    what,
                ))
            }
        }
    }

    /// Expressions of joints that hang from another one now.
    fn move_bindings(&mut self, merged: &MergedJoint, rest: Similarity) {
        let expressions = self.character.expressions.iter_mut();
        for binding in expressions.flat_map(|e| &mut e.joints) {
            if merged.children.iter().any(|(c, _)| *c == binding.joint) {
                binding.full = rest.after(binding.full);
            }
        }
    }

    fn move_skin(&mut self, merged: &MergedJoint) {
        for mesh in &mut self.character.meshes {
            let renumber = drop_from_skin(&mut mesh.skin, merged);
            for p in mesh.primitives.iter_mut().filter(|p| p.influences > 0) {
                renumber_influences(&mut p.joints, &mut p.weights, p.influences, &renumber);
            }
            for level in &mut mesh.levels {
                let renumber = drop_from_skin(&mut level.skin, merged);
                for p in level.primitives.iter_mut().filter(|p| p.influences > 0) {
                    renumber_influences(&mut p.joints, &mut p.weights, p.influences, &renumber);
                }
            }
        }
    }

    /// Gives joints new numbers, everywhere but in the lists of joints themselves.
    fn renumber(&mut self, new: &dyn Fn(usize) -> usize) {
        for joint in &mut self.character.skeleton.joints {
            joint.parent = joint.parent.map(new);
        }
        for channel in self
            .character
            .clips
            .iter_mut()
            .flat_map(|c| &mut c.channels)
        {
            if channel.property.is_of_joint() {
                channel.target = new(channel.target);
            }
        }
        for skin in skins(&mut self.character) {
            skin.joints.iter_mut().for_each(|j| *j = new(*j));
        }
        for expression in &mut self.character.expressions {
            expression
                .joints
                .iter_mut()
                .for_each(|b| b.joint = new(b.joint));
        }
        self.ends
            .iter_mut()
            .for_each(|(joint, _)| *joint = new(*joint));
    }
}

/// Checks the parts of a character that are worked on.
fn consistent(character: &Character, ends: &[(usize, Vec3)], count: usize) -> Result<(), Mismatch> {
    for clip in &character.clips {
        consistent_clip(clip, count)?;
    }
    for (m, mesh) in character.meshes.iter().enumerate() {
        let levels = mesh.levels.iter().map(|level| &level.skin);
        for skin in std::iter::once(&mesh.skin).chain(levels) {
            let fits = skin.joints.len() == skin.inverse_bind.len();
            if !fits || skin.joints.iter().any(|j| *j >= count) {
                let what = "its skin does not match the skeleton";
                return Err(Mismatch::new(format!("mesh {m}"), what));
            }
        }
    }
    let bindings = character.expressions.iter().flat_map(|e| &e.joints);
    let mut named = bindings.map(|b| b.joint).chain(ends.iter().map(|e| e.0));
    if named.any(|joint| joint >= count) {
        let what = "an expression or end site names a joint that does not exist";
        return Err(Mismatch::new("joints", what));
    }
    Ok(())
}

fn consistent_clip(clip: &RawClip, count: usize) -> Result<(), Mismatch> {
    channel::check(clip)?;
    for (c, channel) in clip.channels.iter().enumerate() {
        if channel.property.is_of_joint() {
            check(channel, count, &[]).map_err(|what| {
                Mismatch::new(format!("clip \"{}\".channels[{c}]", clip.name), what)
            })?;
            // The number of values is a multiple of the keys, and enough; here it must be exact.
            let width = if channel.property == Property::Rotation {
                4
            } else {
                3
            };
            let spline = channel.interpolation == Interpolation::CubicSpline;
            let each = width * if spline { 3 } else { 1 };
            if channel.values.len() != each * channel.times_secs.len() {
                let at = format!("clip \"{}\".channels[{c}]", clip.name);
                return Err(Mismatch::new(at, "more values than its keys need"));
            }
        }
    }
    Ok(())
}
