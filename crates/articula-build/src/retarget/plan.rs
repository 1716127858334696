//! Assignment of source joints to target joints: twins, shared spines, twist, held joints.

use super::chain;
use super::rest::Rest;
use super::side::Side;
use glam::{Quat, Vec3};

/// A source joint whose rotation is read, and its conversion to the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RotationSource {
    /// Index of the joint in the source.
    pub(super) joint: usize,
    /// Applied before the source's rotation from rest: from the target's frame to the source's.
    pub(super) frame: Quat,
    /// Start and end joint of a limb whose direction must be taken from positions, because dropped
    /// joints bend it.
    pub(super) along: Option<(usize, usize)>,
}

/// Source of a target joint's rotation.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Drive {
    /// The rest rotation, relative to the parent.
    Held,
    /// The rotation of one source joint.
    Twin(RotationSource),
    /// A blend of two source joints; the number is the share of the second.
    Between(RotationSource, RotationSource, f32),
}

/// The plan for a pair of rigs.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// One entry per target joint.
    pub(super) drives: Vec<Drive>,
    /// The joint to which a target joint is attached where that is not its parent: such joints get
    /// a translation as well.
    pub(super) floats: Vec<Option<usize>>,
    /// Target joints, each after the joint to which it is attached.
    pub(super) order: Vec<usize>,
    /// Rotation from the source's world to the target's.
    pub(super) world: Quat,
    /// Leg length of the target over that of the source.
    pub(super) scale: f32,
}

impl Plan {
    pub(super) fn new(source: &Side, target: &Side) -> Self {
        let drives = drives(source, target);
        let floats = floats(target, &drives);
        Self {
            order: order(&target.rest, &floats),
            drives,
            floats,
            world: target.body.heading * source.body.heading.inverse(),
            scale: target.body.leg_metres / source.body.leg_metres,
        }
    }
}

fn drives(source: &Side, target: &Side) -> Vec<Drive> {
    let twins = twins(source, target);
    let pairer = Pairer {
        source,
        target,
        twins: &twins,
    };
    let mut drives: Vec<Drive> = (0..target.rest.len())
        .map(|t| match twins[t] {
            Some(s) => Drive::Twin(pairer.twin(s, t)),
            None => pairer.mitten(t).unwrap_or(Drive::Held),
        })
        .collect();
    pelvis(&pairer, &mut drives);
    for (t, knots) in chain::shares(&source.spine, &target.spine) {
        drives[t] = match knots {
            Some((a, b, share)) => pairer.between(a, b, share, t),
            None => Drive::Held,
        };
    }
    drives
}

/// Root joint and sacroiliac: the joint that the legs hang from follows its counterpart.
fn pelvis(pairer: &Pairer<'_>, drives: &mut [Drive]) {
    let (source, target) = (&pairer.source.body, &pairer.target.body);
    let follow = |s: usize, t: usize| Drive::Twin(pairer.whole(s, t));
    drives[target.root] = follow(source.root, target.root);
    if target.pelvis == target.root {
        drives[target.root] = follow(source.pelvis, target.root);
    } else if source.pelvis == source.root {
        drives[target.pelvis] = Drive::Held;
    } else {
        drives[target.pelvis] = follow(source.pelvis, target.pelvis);
    }
}

/// The source joint with the same H-Anim name for each target joint, or with the same name where
/// neither rig maps it and both hang from twins.
fn twins(source: &Side, target: &Side) -> Vec<Option<usize>> {
    let mut twins: Vec<Option<usize>> = Vec::with_capacity(target.rest.len());
    for t in 0..target.rest.len() {
        let twin = match &target.rest.hanim[t] {
            Some(name) => source.rest.find(name),
            None => target.rest.parents[t]
                .and_then(|p| twins[p])
                .and_then(|p| namesake(source, p, &target.rest.names[t])),
        };
        twins.push(twin);
    }
    twins
}

fn namesake(source: &Side, parent: usize, name: &str) -> Option<usize> {
    let rest = &source.rest;
    rest.children(parent)
        .find(|c| rest.hanim[*c].is_none() && !name.is_empty() && rest.names[*c] == name)
}

struct Pairer<'a> {
    source: &'a Side,
    target: &'a Side,
    twins: &'a [Option<usize>],
}

impl Pairer<'_> {
    /// A source joint treated as a whole part: with the frame of the part, not of the segment.
    fn whole(&self, s: usize, t: usize) -> RotationSource {
        let (a, b) = (self.source.frames.part[s], self.target.frames.part[t]);
        RotationSource {
            joint: s,
            frame: a * b.inverse(),
            along: None,
        }
    }

    fn segment(&self, s: usize, t: usize) -> RotationSource {
        let (a, b) = (self.source.frames.own[s], self.target.frames.own[t]);
        match a.zip(b) {
            Some((a, b)) => RotationSource {
                joint: s,
                frame: a * b.inverse(),
                along: None,
            },
            None => self.whole(s, t),
        }
    }

    fn twin(&self, s: usize, t: usize) -> RotationSource {
        let mut read = self.segment(s, t);
        let own = self.source.frames.own[s].is_some() && self.target.frames.own[t].is_some();
        let Some(next) = next_title(self.target.rest.title(t))
            .and_then(|n| self.target.rest.find(&n))
            .and_then(|n| self.twins[n])
        else {
            return read;
        };
        let between = self.source.rest.between(s, next).unwrap_or_default();
        let copied = |j: &usize| self.twins.contains(&Some(*j));
        if let Some(&last) = between.last().filter(|_| !between.iter().any(copied)) {
            read.joint = last;
            read.along = own.then_some((s, next));
        }
        read
    }

    /// Drive of a finger where the source has one chain for all fingers: it follows that chain.
    fn mitten(&self, t: usize) -> Option<Drive> {
        let title = self.target.rest.title(t);
        let (side, finger) = title.split_once('_')?;
        let digit = finger.strip_prefix("middle").or_else(|| {
            finger
                .strip_prefix("ring")
                .or_else(|| finger.strip_prefix("pinky"))
        })?;
        let side = side.chars().next()?;
        let has = |name: &str| self.source.rest.sided(side, &format!("{name}1")).is_some();
        if has("middle") || has("ring") || has("pinky") {
            return None;
        }
        let s = self.source.rest.sided(side, &format!("index{digit}"))?;
        Some(Drive::Twin(self.segment(s, t)))
    }

    fn between(&self, a: usize, b: usize, share: f32, t: usize) -> Drive {
        let (from, to) = (self.whole(a, t), self.whole(b, t));
        if a == b || share <= 0.0 {
            Drive::Twin(from)
        } else if share >= 1.0 {
            Drive::Twin(to)
        } else {
            Drive::Between(from, to, share)
        }
    }
}

/// The H-Anim joint at the lower end of a limb's segment.
pub(super) fn next_title(title: &str) -> Option<String> {
    let (side, name) = title.split_once('_')?;
    let next = match name {
        "sternoclavicular" | "acromioclavicular" => "shoulder",
        "shoulder" => "elbow",
        "elbow" => "wrist",
        "hip" => "knee",
        "knee" => "ankle",
        "ankle" => "metatarsal",
        _ => {
            let digit = name.find(|c: char| c.is_ascii_digit())?;
            let number: u32 = name[digit..].parse().ok()?;
            let fingers = ["thumb", "index", "middle", "ring", "pinky"];
            return fingers
                .contains(&&name[..digit])
                .then(|| format!("{side}_{}{}", &name[..digit], number + 1));
        }
    };
    Some(format!("{side}_{next}"))
}

/// Joints whose parent in the tree is not the joint that they are attached to in the body.
fn floats(target: &Side, drives: &[Drive]) -> Vec<Option<usize>> {
    let (rest, body) = (&target.rest, &target.body);
    let mut floats = vec![None; rest.len()];
    for (j, float) in floats.iter_mut().enumerate() {
        let Some(base) = base(target, j) else {
            continue;
        };
        let rigid = match rest.between(base, j) {
            Some(path) => path.iter().all(|p| drives[*p] == Drive::Held),
            None => false,
        };
        let loops = rest.between(j, base).is_some() || base == j;
        if !rigid && !loops && j != body.root {
            *float = Some(base);
        }
    }
    floats
}

/// The joint to which a joint is attached in a body.
fn base(target: &Side, j: usize) -> Option<usize> {
    let rest = &target.rest;
    let (side, name) = rest.title(j).split_once('_')?;
    let side = side.chars().next()?;
    let above: &[&str] = match name {
        "hip" => return Some(target.body.pelvis),
        "sternoclavicular" => return target.spine.chest(),
        "acromioclavicular" => &["sternoclavicular"],
        "shoulder" => &["acromioclavicular", "sternoclavicular"],
        "elbow" => &["shoulder"],
        "wrist" => &["elbow"],
        "knee" => &["hip"],
        "ankle" => &["knee"],
        _ => return None,
    };
    let found = above.iter().find_map(|name| rest.sided(side, name));
    // In-line joints of a limb turn about it, which keeps the position of its end.
    let inline = found.filter(|f| rest.between(*f, j).is_none());
    match name {
        "shoulder" | "acromioclavicular" => found.or_else(|| target.spine.chest()),
        _ => inline,
    }
}

/// Every joint after the one to which it is attached; a cycle of such joints is broken at its
/// first.
fn order(rest: &Rest, floats: &[Option<usize>]) -> Vec<usize> {
    let mut order = Vec::with_capacity(rest.len());
    let mut placed = vec![false; rest.len()];
    for start in 0..rest.len() {
        let mut stack = Vec::new();
        let mut at = Some(start);
        while let Some(j) = at.filter(|j| !placed[*j]) {
            placed[j] = true;
            stack.push(j);
            at = floats[j].or(rest.parents[j]);
        }
        order.extend(stack.into_iter().rev());
    }
    order
}

/// Extends a rotation so that the direction `rest` points along `now`.
pub(super) fn swing(delta: Quat, rest: Vec3, now: Vec3) -> Quat {
    let (is, should) = ((delta * rest).normalize_or_zero(), now.normalize_or_zero());
    if is == Vec3::ZERO || should == Vec3::ZERO {
        return delta;
    }
    Quat::from_rotation_arc(is, should) * delta
}
