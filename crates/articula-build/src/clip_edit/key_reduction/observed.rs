//! The source of a reduction at the times at which it is verified.

use super::super::grid::{VERIFIED_HZ, grid};
use super::super::subject::{EditSubject, Posed};
use super::morphs::MorphErrors;
use super::watch::Watch;
use crate::clip::steps_at;
use articula_core::source::RawClip;
use articula_core::{Mismatch, Transform};
use glam::Affine3A;

/// Bytes of poses that are kept; those of longer clips are evaluated each time.
const MAX_BYTES: usize = 32 << 20;

/// A clip, the times at which it is verified, and what is observed there.
pub(super) struct Observed<'a> {
    pub(super) subject: &'a EditSubject<'a>,
    pub(super) clip: &'a RawClip,
    pub(super) times: Vec<f32>,
    pub(super) watch: Watch,
    pub(super) morphs: MorphErrors,
    /// The pose at each time; none if they need too much memory.
    poses: Vec<Posed>,
}

impl<'a> Observed<'a> {
    /// # Errors
    /// A [`Mismatch`] if the clip does not belong to the character or is longer than can be verified.
    pub(super) fn new(subject: &'a EditSubject<'a>, clip: &'a RawClip) -> Result<Self, Mismatch> {
        subject.check(clip)?;
        steps_at(clip, clip.duration_secs, VERIFIED_HZ, 1)?;
        let times = grid([clip], clip.duration_secs);
        let of_joint = size_of::<Transform>() + size_of::<Affine3A>();
        let is_kept = times.len() * subject.rig.len() * of_joint <= MAX_BYTES;
        let (mut sampler, mut posed) = (subject.sampler(clip), subject.rest());
        let poses = times.iter().filter(|_| is_kept).map(|secs| {
            subject.next_pose(&mut sampler, *secs, &mut posed);
            posed.clone()
        });
        let poses = poses.collect();
        Ok(Self {
            watch: Watch::new(subject, clip),
            morphs: MorphErrors::new(subject, clip),
            subject,
            clip,
            times,
            poses,
        })
    }

    /// The pose at one of the times, in a buffer if it is not kept.
    pub(super) fn pose<'b>(&'b self, time: usize, buffer: &'b mut Posed) -> &'b Posed {
        if let Some(posed) = self.poses.get(time) {
            return posed;
        }
        self.subject.pose(self.clip, self.times[time], buffer);
        buffer
    }
}
