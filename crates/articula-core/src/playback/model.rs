//! What figures share: rig, clips, events and root motion.

use crate::Mismatch;
use crate::clip::{Clip, Track};
use crate::crowd::{ClipEvent, ClipTimes, RootTrajectory, filled, sorted_events};
use crate::joint_set::JointSet;
use crate::rig::Rig;
use crate::travel::Carriers;
use std::sync::Arc;

/// A rig and its clips, shared by any number of [`FigurePlayer`](super::FigurePlayer)s. Read-only.
///
/// A model owns what it reads, without copies: the rig is shared, and a [`Clip`] shares its tracks
/// with its clones. A model with another version of one clip, as when more of a stream has arrived,
/// is made from the rig and the clips of the one before.
#[derive(Debug, Clone)]
pub struct FigureModel {
    rig: Arc<Rig>,
    clips: Vec<Clip>,
    events: Vec<Vec<ClipEvent>>,
    paths: Vec<Option<RootTrajectory>>,
    /// Joints with a track, for each clip.
    animated: Vec<JointSet>,
    carriers: JointSet,
}

impl FigureModel {
    /// Joins a rig with its clips, without events and root motion.
    ///
    /// # Errors
    /// A [`Mismatch`] if a clip was made for a rig with another number of joints.
    pub fn new(rig: impl Into<Arc<Rig>>, clips: impl Into<Vec<Clip>>) -> Result<Self, Mismatch> {
        let (rig, clips) = (rig.into(), clips.into());
        for (c, clip) in clips.iter().enumerate() {
            if clip.joints() != rig.len() {
                let what = format!("{} joints, the rig has {}", clip.joints(), rig.len());
                return Err(Mismatch::new(format!("clips[{c}]"), what));
            }
        }
        if clips.len() > usize::from(u16::MAX) {
            let what = format!("{} clips, at most 65535", clips.len());
            return Err(Mismatch::new("clips", what));
        }
        Ok(Self {
            events: vec![Vec::new(); clips.len()],
            paths: vec![None; clips.len()],
            animated: clips.iter().map(animated).collect(),
            carriers: Carriers::new(&rig).set(),
            rig,
            clips,
        })
    }

    /// Adds the events of each clip, in any order; an empty list stands for no events.
    ///
    /// # Errors
    /// A [`Mismatch`] if the list has another length than that of the clips, or an event lies
    /// outside its clip.
    pub fn with_events(mut self, mut events: Vec<Vec<ClipEvent>>) -> Result<Self, Mismatch> {
        filled("events", &mut events, self.clips.len())?;
        for (c, (events, clip)) in events.iter_mut().zip(&self.clips).enumerate() {
            *events = sorted_events(events, clip.duration_secs())
                .map_err(|e| Mismatch::new(format!("events[{c}]{}", e.at), e.what))?;
        }
        self.events = events;
        Ok(self)
    }

    /// Adds the root motion of each clip that is played in place; an empty list stands for none.
    ///
    /// # Errors
    /// A [`Mismatch`] if the list has another length than that of the clips.
    pub fn with_root_motion(
        mut self,
        mut paths: Vec<Option<RootTrajectory>>,
    ) -> Result<Self, Mismatch> {
        filled("paths", &mut paths, self.clips.len())?;
        self.paths = paths;
        Ok(self)
    }

    /// The rig.
    pub fn rig(&self) -> &Arc<Rig> {
        &self.rig
    }

    /// The clips.
    pub fn clips(&self) -> &[Clip] {
        &self.clips
    }

    /// Joints that a clip moves, with constant tracks.
    pub(super) fn animated(&self, clip: usize) -> &JointSet {
        &self.animated[clip]
    }

    /// The root and the nodes above it.
    pub(super) fn carriers(&self) -> &JointSet {
        &self.carriers
    }
}

impl ClipTimes for FigureModel {
    fn clip_count(&self) -> usize {
        self.clips.len()
    }

    fn clip_secs(&self, clip: usize) -> f32 {
        self.clips[clip].duration_secs()
    }

    fn clip_events(&self, clip: usize) -> &[ClipEvent] {
        &self.events[clip]
    }

    fn clip_path(&self, clip: usize) -> Option<&RootTrajectory> {
        self.paths[clip].as_ref()
    }
}

fn animated(clip: &Clip) -> JointSet {
    fn targets<T>(tracks: &[Track<T>]) -> impl Iterator<Item = usize> + '_ {
        tracks.iter().map(|t| usize::from(t.target))
    }
    let tracks = clip.tracks();
    let turned = targets(&tracks.rotations);
    let moved = targets(&tracks.translations).chain(targets(&tracks.scales));
    turned.chain(moved).collect()
}
