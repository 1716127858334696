//! The interface of controllers: what to update in a frame, and what is shown.

use crate::clip::Clip;
use crate::joint_set::JointSet;
use crate::pose::{LocalPose, ModelPose};
use crate::sample::FramePosition;
use glam::Vec3;

/// The one clip that moves a figure in a frame, and its time.
#[derive(Debug, Clone, Copy)]
pub struct ClipFrame<'a> {
    /// Index of the clip in its model.
    pub index: usize,
    /// The clip.
    pub clip: &'a Clip,
    /// Frames around the time.
    pub at: FramePosition,
}

/// Everything that a controller may know about a frame.
#[derive(Debug, Clone, Copy)]
pub struct FrameContext<'a> {
    /// Time since the start of playback in seconds.
    pub now_secs: f64,
    /// Time since the frame before in seconds.
    pub dt_secs: f32,
    /// Pixels per metre at the depth of each joint, the maximum over all views.
    pub pixels_per_metre: &'a [f32],
    /// Tolerance factor of each joint: below 1 where errors are noticed more.
    pub attention: &'a [f32],
    /// Unit directions from the figure to each view, in model space. Empty if there are more than
    /// the player tells apart; an error then counts whole.
    pub view_directions: &'a [Vec3],
    /// Distance of the nearest view to the root in metres.
    pub distance_metres: f32,
    /// Joints that may move; the controller asks for no others.
    pub allowed: JointSet,
    /// Joints to be sampled at most.
    pub max_joints: usize,
    /// The clip that alone moves the figure. `None` while two clips are blended.
    pub clip: Option<ClipFrame<'a>>,
    /// Joints that a layer moves too, so that `clip` alone does not determine them.
    pub layered: JointSet,
    /// Whether the motion may jump in this frame: the first frame, after a seek, where a clip
    /// starts again, and where a fade or a layer begins or ends.
    pub cut: bool,
    /// Local transforms written in the frame before.
    pub shown: &'a LocalPose,
    /// Model-space pose of the frame before.
    pub model: &'a ModelPose,
}

/// What a controller did in a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ControlResult {
    /// Joints whose transform was renewed; all others show what they showed before.
    pub updated: JointSet,
    /// Joints that are blended between a held and a sampled transform.
    pub in_transition: JointSet,
    /// Values read from stored keys instead of being sampled at the time of the frame.
    pub keys_read: usize,
    /// Upper bound of the displacement of the skin by any one joint, in pixels. `None` if the
    /// controller has none, as with fixed levels.
    pub bound_px: Option<f32>,
}

/// A policy of what to update in a frame, given the view and a budget.
///
/// In every frame the player calls [`MotionController::due`] and samples the joints returned, then
/// [`MotionController::control`], which writes the local transforms to be shown. Neither may
/// allocate.
///
/// A controller that shows every second frame:
///
/// ```
/// use articula_core::playback::{ControlResult, FrameContext, MotionController};
/// use articula_core::{JointSet, LocalPose};
///
/// struct HalfRate {
///     frame: usize,
/// }
///
/// impl MotionController for HalfRate {
///     fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
///         self.frame += 1;
///         match self.frame % 2 == 1 || frame.cut {
///             true => frame.allowed,
///             false => JointSet::EMPTY,
///         }
///     }
///
///     fn control(
///         &mut self,
///         _: &FrameContext<'_>,
///         due: &JointSet,
///         wanted: &LocalPose,
///         shown: &mut LocalPose,
///     ) -> ControlResult {
///         due.iter().for_each(|joint| shown.set(joint, wanted.get(joint)));
///         ControlResult { updated: *due, ..ControlResult::default() }
///     }
/// }
/// ```
pub trait MotionController {
    /// Returns the joints of [`FrameContext::allowed`] whose wanted transform is needed now.
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet;

    /// Writes the local transforms to be shown. `wanted` holds the sampled transforms of at least
    /// the joints of `due`, which contains those that were asked for; its other entries are not to
    /// be read. `shown` holds what was shown before.
    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult;
}

impl<C: MotionController + ?Sized> MotionController for &mut C {
    fn due(&mut self, frame: &FrameContext<'_>) -> JointSet {
        (**self).due(frame)
    }

    fn control(
        &mut self,
        frame: &FrameContext<'_>,
        due: &JointSet,
        wanted: &LocalPose,
        shown: &mut LocalPose,
    ) -> ControlResult {
        (**self).control(frame, due, wanted, shown)
    }
}
