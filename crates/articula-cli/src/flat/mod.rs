//! A character before the camera, ready to be converted to 2D.

mod expressions;
mod head;
mod live;
mod staged;

pub(crate) use expressions::expressions;
pub(crate) use head::HeadShot;
pub(crate) use live::live_source;
pub(crate) use staged::{Shot, Staged};
