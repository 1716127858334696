//! Verifies a selection of keys against its source and restores keys until the bound holds.

use super::super::subject::{EditSubject, Posed};
use super::choice::{Choice, distance};
use super::observed::Observed;
use super::{ReduceOptions, Timelines};
use articula_core::Rig;
use articula_core::source::{Channel, Property, RawClip};
use glam::Vec3A;

/// State of a verification.
pub(super) struct Proof<'a> {
    source: &'a Observed<'a>,
    bound_metres: f32,
    /// Whether channels with the same times in the source keep the same keys.
    is_shared: bool,
    /// Maximum error at each time, as far as it is known.
    errors: Vec<f32>,
    /// Times that must be evaluated (again).
    is_open: Vec<bool>,
    /// Buffers of poses.
    wanted: Posed,
    played: Posed,
    /// Error of each joint's skin caused by morph weights.
    morphed: Vec<f32>,
    /// For each joint the first one of its unbranched chain.
    limbs: Vec<usize>,
}

fn limbs(rig: &Rig) -> Vec<usize> {
    let mut children = vec![0; rig.len()];
    (0..rig.len())
        .filter_map(|j| rig.parent(j))
        .for_each(|p| children[p] += 1);
    let mut limbs: Vec<usize> = (0..rig.len()).collect();
    for j in 0..rig.len() {
        if let Some(p) = rig.parent(j).filter(|p| children[*p] == 1) {
            limbs[j] = limbs[p];
        }
    }
    limbs
}

/// A point whose error exceeds the bound.
#[derive(Debug, Clone, Copy)]
struct Breach {
    /// Of the time.
    index: usize,
    time: f32,
    joint: usize,
    /// The point, in the joint's space.
    point: Vec3A,
    excess: f32,
}

/// For each joint the intervals in which keys were restored in this round. Breaches at or below the
/// joint are ignored there until the next round.
struct Mended {
    spans: Vec<Vec<(f32, f32)>>,
}

impl Mended {
    fn concerns(&self, rig: &Rig, breach: &Breach) -> bool {
        let mut at = Some(breach.joint);
        while let Some(j) = at {
            let near = |(from, to): &(f32, f32)| (*from..=*to).contains(&breach.time);
            if self.spans[j].iter().any(near) {
                return true;
            }
            at = rig.parent(j);
        }
        false
    }
}

impl<'a> Proof<'a> {
    pub(super) fn new(source: &'a Observed<'a>, opts: &ReduceOptions) -> Self {
        let (subject, times) = (source.subject, source.times.len());
        Self {
            source,
            bound_metres: opts.bound_metres,
            is_shared: opts.timelines == Timelines::Shared,
            errors: vec![0.0; times],
            is_open: vec![false; times],
            wanted: subject.rest(),
            played: subject.rest(),
            morphed: vec![0.0; subject.rig.len()],
            limbs: limbs(&subject.rig),
        }
    }

    /// Restores keys until no error exceeds the bound; returns the maximum error that is left.
    pub(super) fn tighten(&mut self, choices: &mut [Choice<'_>]) -> f32 {
        let mut shown = RawClip {
            channels: choices.iter().map(Choice::shown).collect(),
            ..self.source.clip.clone()
        };
        self.is_open.fill(true);
        loop {
            let mut breaches = self.breaches(&shown);
            breaches.sort_by(|a, b| b.excess.total_cmp(&a.excess));
            let mut mended = Mended {
                spans: vec![Vec::new(); self.source.subject.rig.len()],
            };
            let mut is_done = true;
            for breach in &breaches {
                if mended.concerns(&self.source.subject.rig, breach) {
                    continue;
                }
                let Some((c, key)) = self.blamed(breach, &shown, choices) else {
                    continue;
                };
                let (from, to) = self.keep(c, key, choices, &mut shown);
                mended.spans[choices[c].source.target].push((from, to));
                self.reopen(from, to);
                is_done = false;
            }
            if is_done {
                return self.errors.iter().copied().fold(0.0, f32::max);
            }
        }
    }

    /// Keeps a key of a channel, and of those that share its times; returns the interval in which they
    /// have changed.
    fn keep(
        &self,
        c: usize,
        key: usize,
        choices: &mut [Choice<'_>],
        shown: &mut RawClip,
    ) -> (f32, f32) {
        let times = &choices[c].source.times_secs;
        if self.is_shared {
            let same = |o: &&Choice<'_>| o.keeps_keys() && o.source.times_secs == *times;
            let kept = choices.iter().find(same).map(|other| other.kept.clone());
            kept.into_iter().for_each(|kept| choices[c].join(kept));
        }
        let (mut from, mut to) = choices[c].keep(key);
        shown.channels[c] = choices[c].shown();
        if !self.is_shared {
            return (from, to);
        }
        for (other, choice) in choices
            .iter_mut()
            .enumerate()
            .filter(|(other, _)| *other != c)
        {
            if choice.source.times_secs == *times && choice.lacks(key) {
                let (a, b) = choice.keep(key);
                (from, to) = (from.min(a), to.max(b));
                shown.channels[other] = choice.shown();
            }
        }
        (from, to)
    }

    fn reopen(&mut self, from: f32, to: f32) {
        let times = &self.source.times;
        let first = times.partition_point(|t| *t < from);
        let last = times.partition_point(|t| *t <= to);
        self.is_open[first..last].fill(true);
    }

    /// Evaluates every open time and returns the worst point of each limb that exceeds the bound.
    fn breaches(&mut self, shown: &RawClip) -> Vec<Breach> {
        let mut found = Vec::new();
        let Observed {
            subject,
            clip,
            watch,
            morphs,
            ..
        } = self.source;
        let mut worst: Vec<Option<Breach>> = vec![None; subject.rig.len()];
        let mut sampler = subject.sampler(shown);
        for (i, time) in self.source.times.iter().copied().enumerate() {
            if !std::mem::replace(&mut self.is_open[i], false) {
                continue;
            }
            let wanted = self.source.pose(i, &mut self.wanted);
            subject.next_pose(&mut sampler, time, &mut self.played);
            morphs.errors(clip, &shown.channels, time, &mut self.morphed);
            self.errors[i] = 0.0;
            for joint in 0..subject.rig.len() {
                let allowed = self.bound_metres - self.morphed[joint];
                let (error, point) = watch.error(joint, wanted, &self.played, allowed);
                self.errors[i] = self.errors[i].max(error + self.morphed[joint]);
                let excess = error - allowed;
                let of_limb = &mut worst[self.limbs[joint]];
                if excess > 0.0 && of_limb.is_none_or(|w| w.excess < excess) {
                    *of_limb = Some(Breach {
                        index: i,
                        time,
                        joint,
                        point,
                        excess,
                    });
                }
            }
            found.extend(worst.iter_mut().filter_map(Option::take));
        }
        found
    }

    /// The channel above a breach that moves its point most, and its missing key.
    fn blamed(
        &mut self,
        breach: &Breach,
        shown: &RawClip,
        choices: &[Choice<'_>],
    ) -> Option<(usize, usize)> {
        let subject = self.source.subject;
        let wanted = self.source.pose(breach.index, &mut self.wanted);
        subject.pose(shown, breach.time, &mut self.played);
        let poses = [wanted, &self.played];
        let point = wanted.model.matrices[breach.joint].transform_point3a(breach.point);
        let mut most: Option<(f32, usize, usize)> = None;
        for (c, choice) in choices.iter().enumerate() {
            let channel = choice.source;
            let above = channel.property.is_of_joint()
                && subject.rig.is_at_or_below(breach.joint, channel.target);
            if !above {
                continue;
            }
            let moved = moved(subject, channel, poses, point);
            let Some(key) = choice.missing(breach.time) else {
                continue;
            };
            if most.is_none_or(|(m, _, _)| m < moved) {
                most = Some((moved, c, key));
            }
        }
        most.map(|(_, c, key)| (c, key))
    }
}

/// Approximate distance by which the error of one channel alone, between two poses, moves a point, metres.
fn moved(
    subject: &EditSubject<'_>,
    channel: &Channel,
    [wanted, played]: [&Posed; 2],
    point: Vec3A,
) -> f32 {
    let joint = channel.target;
    let local = |posed: &Posed| match channel.property {
        Property::Rotation => posed.local.rotations[joint].to_array().to_vec(),
        Property::Scale => posed.local.scales[joint].to_array().to_vec(),
        _ => posed.local.translations[joint].to_array().to_vec(),
    };
    let apart = distance(channel.property, &local(wanted), &local(played));
    let lever = point.distance(wanted.model.matrices[joint].translation);
    match channel.property {
        Property::Rotation => apart * lever,
        Property::Scale => {
            let scale = wanted.local.scales[joint].abs().min_element();
            apart * lever / scale.max(1e-6)
        }
        _ => {
            let parent = subject.rig.parent(joint);
            apart * parent.map_or(1.0, |p| subject.scale_at_rest(p))
        }
    }
}
