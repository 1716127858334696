//! Files that hold streams: of the motion of a body, alone, as text or in MP4 files, and of a face.

mod abp;
mod face;
mod mp4;

pub(super) use abp::{open, open_text};
pub(super) use face::open_face;
pub(super) use mp4::open as open_mp4;
