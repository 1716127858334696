//! The tracks of a motion: which joint or morph target, how it is coded, and in which group.

use super::grouping::groups;
use super::head::{MotionHead, PosePlace, ReadHead};
use super::pose_unit::{self, Kind, MOST_TIERS, REFERENCE, TrackForm};
use super::rotation::{exp, product};
use super::step::step;
use crate::abp2::face_channels;
use crate::error::StreamError;
use articula_core::{Mismatch, Rig};
use glam::{Quat, Vec3};

/// A track of a motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TrackPlace {
    pub(super) kind: Kind,
    /// Joint, or slot of a morph target.
    pub(super) target: u16,
    pub(super) form: TrackForm,
}

impl TrackPlace {
    /// Step code and planes of a track that moves.
    pub(super) fn moving(&self) -> Option<(i32, &[u8; MOST_TIERS])> {
        match &self.form {
            TrackForm::Moving { code, planes, .. } => Some((*code, planes)),
            _ => None,
        }
    }

    /// What the reference numbers are multiplied by, and these.
    fn numbers(&self) -> (f64, [i32; 3]) {
        match self.form {
            TrackForm::Rest => (0.0, [0; 3]),
            TrackForm::Constant { code, numbers, .. } => (step(code), numbers),
            TrackForm::Moving { numbers, .. } => (1.0 / REFERENCE, numbers),
        }
    }

    /// What decoded values are multiplied by: a power of 2.
    pub(super) fn unit(&self) -> f32 {
        match self.form {
            TrackForm::Rest => 1.0,
            TrackForm::Constant { exponent, .. } | TrackForm::Moving { exponent, .. } => {
                unit(exponent)
            }
        }
    }

    /// The reference numbers as values.
    pub(super) fn reference(&self) -> [f32; 3] {
        let (step, numbers) = self.numbers();
        let unit = f64::from(self.unit());
        numbers.map(|number| (f64::from(number) * step * unit) as f32)
    }

    /// The reference rotation.
    pub(super) fn rotation(&self, rest: Quat) -> Quat {
        product(rest, exp(self.reference()))
    }

    /// The reference translation or scale.
    pub(super) fn vector(&self, rest: Vec3) -> Vec3 {
        rest + Vec3::from(self.reference())
    }
}

impl MotionHead {
    /// Whether a track has numbers that mean nothing in between, so that no tier drops planes of it.
    pub(super) fn is_exact(&self, track: &TrackPlace) -> bool {
        let is_exact = face_channels::is_exact(usize::from(track.target));
        self.face.is_some() && track.kind == Kind::Morph && is_exact
    }
}

/// `2^-exponent`, exact.
pub(super) fn unit(exponent: i32) -> f32 {
    f32::from_bits(((127 - exponent) as u32) << 23)
}

/// All tracks of a motion by group.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TrackTable {
    pub(super) tracks: Vec<TrackPlace>,
    /// For each group of units its tracks that move, in coded order.
    pub(super) of_group: Vec<Vec<usize>>,
    /// For each group whether its pose unit is there.
    pub(super) has_pose: Vec<bool>,
}

/// The tracks of one pose unit, in coded order: kind and target.
pub(super) type PoseTracks = Vec<(Kind, u16)>;

/// Returns the tracks of each pose unit: joints by level of articulation, then morph targets by
/// group.
pub(super) fn pose_tracks(head: &MotionHead, rig: &Rig) -> Vec<PoseTracks> {
    let mut kinds = vec![Kind::Rotation, Kind::Translation];
    if head.scales {
        kinds.push(Kind::Scale);
    }
    let joints = &rig.articulation().joints;
    let of_level = |level: &u8| -> PoseTracks {
        let joints = (0..joints.len()).filter(|j| joints[*j].level == *level);
        joints
            .flat_map(|j| kinds.iter().map(move |kind| (*kind, j as u16)))
            .collect()
    };
    let of_morphs = |group: usize| -> PoseTracks {
        let slots = (0..head.morphs.len()).filter(|s| usize::from(head.morphs[*s]) == group);
        slots.map(|s| (Kind::Morph, s as u16)).collect()
    };
    let levels = head.pose_levels();
    let mut all: Vec<PoseTracks> = levels.iter().map(of_level).collect();
    all.extend((0..head.morph_groups.len()).map(of_morphs));
    all
}

impl TrackTable {
    /// Puts tracks into the groups of units.
    pub(super) fn new(
        head: &MotionHead,
        rig: &Rig,
        pose_units: Vec<Option<Vec<TrackPlace>>>,
    ) -> Self {
        let levels = head.pose_levels();
        let poses: Vec<bool> = pose_units.iter().map(Option::is_some).collect();
        let tracks: Vec<TrackPlace> = pose_units.into_iter().flatten().flatten().collect();
        let mut of_joint = vec![Vec::new(); rig.len()];
        let mut of_group = vec![Vec::new(); head.group_count()];
        let moving = tracks
            .iter()
            .enumerate()
            .filter(|(_, track)| track.moving().is_some());
        for (at, track) in moving {
            if track.kind == Kind::Morph {
                let group = usize::from(head.morphs[usize::from(track.target)]);
                of_group[head.groups.len() + group].push(at);
            } else {
                of_joint[usize::from(track.target)].push(at);
            }
        }
        let mut has_pose = Vec::new();
        for (number, (group, joints)) in groups(head.grouping, rig).into_iter().enumerate() {
            of_group[number] = joints
                .iter()
                .flat_map(|j| of_joint[usize::from(*j)].clone())
                .collect();
            has_pose.push(levels.binary_search(&group.loa).is_ok_and(|at| poses[at]));
        }
        has_pose.extend(&poses[levels.len()..]);
        Self {
            tracks,
            of_group,
            has_pose,
        }
    }

    /// The coarsest tier of a group that adds planes and is not among some falling tiers.
    pub(super) fn missing_tier(
        &self,
        tiers: usize,
        group: usize,
        there: impl Iterator<Item = usize>,
    ) -> Option<usize> {
        let mut there = there.peekable();
        let mut all = (0..tiers).rev();
        all.find(|tier| there.next_if_eq(tier).is_none() && self.adds(tiers, group, *tier))
    }

    /// Whether a tier of a group adds planes to the next coarser one; the coarsest has the first levels.
    pub(super) fn adds(&self, tiers: usize, group: usize, tier: usize) -> bool {
        let of_track = |track: &usize| {
            let (_, planes) = self.tracks[*track].moving()?;
            Some(planes[tier + 1] > planes[tier])
        };
        let mut tracks = self.of_group[group].iter();
        tier + 1 == tiers || tracks.any(|track| of_track(track) == Some(true))
    }

    /// Reads the pose units of a head.
    pub(super) fn read(stream: &[u8], read: &ReadHead, rig: &Rig) -> Result<Self, StreamError> {
        let head = &read.head;
        if rig.len() != head.joints {
            let what = format!(
                "the stream is for {} joints, the rig has {}",
                head.joints,
                rig.len()
            );
            return Err(Mismatch::new("joints", what).into());
        }
        let expected: Vec<_> = groups(head.grouping, rig)
            .into_iter()
            .map(|g| g.0)
            .collect();
        if expected != head.groups {
            let what =
                "the levels of articulation or the regions of the rig are not those of the stream";
            return Err(Mismatch::new("groups", what).into());
        }
        let all = pose_tracks(head, rig);
        let mut units: Vec<Option<Vec<TrackPlace>>> = vec![None; all.len()];
        for PosePlace {
            number,
            bytes,
            body,
        } in &read.poses
        {
            let kinds: Vec<Kind> = all[*number].iter().map(|(kind, _)| *kind).collect();
            let forms = pose_unit::read(&stream[body.clone()], head.tiers, &kinds);
            let forms = forms.map_err(|what| {
                StreamError::malformed(format!("byte {} (pose unit {number})", bytes.start), what)
            })?;
            let place = |((kind, target), form): (&(Kind, u16), TrackForm)| TrackPlace {
                kind: *kind,
                target: *target,
                form,
            };
            units[*number] = Some(all[*number].iter().zip(forms).map(place).collect());
        }
        Ok(Self::new(head, rig, units))
    }
}
