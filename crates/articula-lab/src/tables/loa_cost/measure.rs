//! One pass over a clip with a set of joints that move: times of its stages, and what was done.

use articula_build::Asset;
use articula_core::crowd::ClipState;
use articula_core::playback::{
    ControlResult, FigureModel, FigurePlayer, FigureSkin, FigureViews, FrameContext, FullDetail,
    MotionController,
};
use articula_core::{Clip, GroupedSkin, JointSet, LocalPose};
use articula_report::thread_ns;
use std::hint::black_box;
use std::sync::Arc;

/// Nanoseconds of the two stages of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct StageNs {
    /// Sampling and model matrices.
    pub(super) transforms: f64,
    pub(super) skinning: f64,
}

impl StageNs {
    /// Both stages.
    pub(super) fn sum(self) -> f64 {
        self.transforms + self.skinning
    }

    /// Mean of several frames; zero without frames.
    pub(super) fn mean(frames: &[Self]) -> Self {
        let count = frames.len().max(1) as f64;
        Self {
            transforms: frames.iter().map(|f| f.transforms).sum::<f64>() / count,
            skinning: frames.iter().map(|f| f.skinning).sum::<f64>() / count,
        }
    }
}

/// Work of a frame, mean over the frames after the first.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Counts {
    /// Joints whose local transform is sampled from the clip and shown.
    pub(super) transforms: f64,
    /// Model matrices that change.
    pub(super) matrices: f64,
    /// Vertices that are skinned again.
    pub(super) vertices: f64,
}

/// A clip to play, by the playback that ships.
pub(super) struct Stage<'a> {
    asset: &'a Asset,
    clip: &'a Clip,
    groups: Arc<GroupedSkin>,
}

impl<'a> Stage<'a> {
    pub(super) fn new(asset: &'a Asset, clip: &'a Clip) -> Self {
        Self {
            asset,
            clip,
            groups: GroupedSkin::new(&asset.mesh).into(),
        }
    }

    /// Plays the clip once with a number of figures of which the joints of a set move; all other
    /// joints hold the rest pose, the root too. The first frame, in which everything is new, is not
    /// counted. The counts are those of the first figure.
    ///
    /// # Panics
    /// If the clip belongs to another rig than the asset.
    pub(super) fn pass(&self, joints: &JointSet, figures: usize) -> (Vec<StageNs>, Counts) {
        let (rig, mesh) = (&self.asset.rig, &self.asset.mesh);
        let model = FigureModel::new(rig.clone(), [self.clip.clone()])
            .expect("the clip must belong to the rig");
        let (start, model) = (ClipState::new(&model, 0).once(), Arc::new(model));
        let frames = self.clip.frames();
        let mut shown: Vec<(FigurePlayer, FigureSkin)> = (0..figures)
            .map(|_| {
                let mut player = FigurePlayer::new(model.clone(), &mesh.morph_weights);
                player.play(start);
                (player, FigureSkin::new(mesh.clone(), self.groups.clone()))
            })
            .collect();
        let views = FigureViews::Parallel {
            pixels_per_metre: 1.0,
            distance_metres: 0.0,
            directions: &[],
        };
        let mut only = Only {
            joints: *joints,
            shown: FullDetail::default(),
        };
        let mut times = Vec::with_capacity(frames.saturating_sub(1));
        let mut sums = Counts::default();
        for frame in 0..frames {
            let secs = frame as f64 / f64::from(self.clip.rate_hz());
            let start = thread_ns();
            let (mut sampled, mut matrices) = (0, 0);
            for (f, (player, _)) in shown.iter_mut().enumerate() {
                player.advance_to(secs, secs as f32);
                player.control(&mut only, views);
                let changed = player.hierarchy();
                if f == 0 {
                    sampled = player.report().sampled.intersection(joints).len();
                    matrices = changed;
                }
            }
            let posed = thread_ns();
            let mut vertices = 0;
            for (f, (player, skin)) in shown.iter_mut().enumerate() {
                let skinned = skin.skin(player.model_pose(), player.morph_weights());
                black_box(skin.skinned());
                if f == 0 {
                    vertices = skinned;
                }
            }
            let end = thread_ns();
            if frame > 0 {
                times.push(StageNs {
                    transforms: (posed - start) as f64,
                    skinning: (end - posed) as f64,
                });
                sums.transforms += sampled as f64;
                sums.matrices += matrices as f64;
                sums.vertices += vertices as f64;
            }
        }
        let count = times.len().max(1) as f64;
        let counts = Counts {
            transforms: sums.transforms / count,
            matrices: sums.matrices / count,
            vertices: sums.vertices / count,
        };
        (times, counts)
    }
}

/// Shows the joints of a set in full detail, and leaves all others as they are.
struct Only {
    joints: JointSet,
    shown: FullDetail,
}

impl MotionController for Only {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        frame.allowed.intersection(&self.joints)
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        self.shown.control(frame, due, wanted, shown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_joints_of_the_set_cost() {
        let asset = crate::small::human();
        let clip = asset.clips[0].at_key_rate();
        let (rig, stage) = (&asset.rig, Stage::new(asset, &clip));
        let (times, none) = stage.pass(&JointSet::EMPTY, 1);
        assert_eq!(none, Counts::default(), "nothing moves");
        assert_eq!(times.len(), clip.frames() - 1);
        let (_, all) = stage.pass(&rig.all(), 1);
        assert!(all.transforms > 0.0 && all.transforms <= rig.len() as f64);
        let knee = rig.all().iter().find(|j| rig.name(*j) == "l_knee").unwrap();
        let (_, shin) = stage.pass(&JointSet::from_iter([knee]), 1);
        let below = (0..rig.len()).filter(|j| rig.is_at_or_below(*j, knee));
        assert!(shin.transforms <= 1.0, "the knee alone is sampled");
        assert!(
            shin.matrices <= below.count() as f64,
            "what is below it moves"
        );
        assert!(shin.matrices < all.matrices);
        assert!(shin.vertices > 0.0 && shin.vertices < all.vertices);
    }
}
