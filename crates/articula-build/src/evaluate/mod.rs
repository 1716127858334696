//! Evaluation of motion LOD methods: saved updates and error in pixels of a clip played with a
//! method.
//!
//! Source: the protocol of `docs/methods/motion-lod.md` 11.1 and 12. One pass of the clip at its
//! own frames; the camera follows the root's horizontal motion; weak perspective at the root's
//! distance, level cameras at several azimuths. Methods are calibrated before they are compared:
//! each has one parameter, and gains are reported at the parameter that meets an error target.
//!
//! A method is a controller of the live playback ([`articula_core::playback`]), so that what is
//! measured is what an application shows. Methods act on rotations ("orientation updates", thesis
//! 5.2); local translations, scales, the root and morph weights always follow the clip. A root
//! outside of a fixed level keeps its way over the ground and its heading.

mod baselines;
mod calibrate;
mod camera_path;
mod controllers;
mod method;
mod playbacks;
mod pose_keys;
mod schedule;
mod skin_errors;
mod skin_sample;
mod stage;
mod statistics;

pub use baselines::thesis::{
    BoneDirection, SegmentRadius, ThesisMetricOptions, error_matrix_table, error_matrix_with,
};
pub use calibrate::{calibrate, sweep};
pub(crate) use camera_path::camera_at;
pub use camera_path::{CameraKey, PathFrame, PathMethod, PathRun, play_camera_path};
pub use method::{ClusterKey, Method, MethodOptions, Playback, SkinPxVariant};
pub use playbacks::play;
pub use pose_keys::{pose_key_frames, uniform_key_frames};
pub use schedule::{LevelSchedule, RequestedLevel, ScheduleFrame, ScheduledLevel, play_schedule};
pub use stage::{ClipEvaluator, DistanceRow, EvaluationSetup, MethodRun};
pub use statistics::{FrameErrors, PartErrors, SkinErrors};
