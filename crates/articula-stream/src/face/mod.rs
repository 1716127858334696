//! Face animations as the face streams have them: values of all parameters, frame by frame.

mod clip;
pub(crate) mod fade;
mod frame;
pub(crate) mod levels;

pub use clip::{DecodedFace, FaceClip, FaceReadOptions};
pub use frame::FaceFrame;
pub(crate) use frame::check_frames;
