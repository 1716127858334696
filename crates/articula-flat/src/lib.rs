//! How a virtual human looks in 2D: reference pictures, contact sheets and plots.
//!
//! Everything here takes values and gives values (pixels, PNG bytes, SVG text), always the
//! same for the same input.
//!
//! - [`item_buffer`]: which triangle each sample shows, the base of all pictures
//! - [`picture`], [`codec`], [`paint`], [`compare`]: pixels; files; marks and words; how far
//!   two pictures are apart
//! - [`frame`], [`projection`]: where the camera stands; from metres to pixels
//! - [`appearance`], [`render`]: materials and textures; a lit picture of a skinned character
//! - [`skeleton`], [`contact_sheet`]: moving and held joints; many pictures on one page
//! - [`portrait`]: a talking face in 2D that turns its head
//! - [`plot`]: line and bar plots as SVG
//! - [`planar`]: a clip as the camera sees it, ready to be written in 2D
//! - [`vector`]: vector graphics, still and moving, written and sampled
//! - [`error`]: what can be wrong with a picture
//!
//! What is deliberately absent: files, clocks, threads, a GPU, fonts of the system.

pub mod appearance;
pub mod codec;
pub mod compare;
pub mod contact_sheet;
pub mod error;
pub mod flatten;
pub mod frame;
mod ground;
pub mod item_buffer;
pub mod paint;
pub mod picture;
pub mod planar;
pub mod plot;
pub mod portrait;
pub mod projection;
pub mod render;
pub mod skeleton;
pub mod vector;

pub use error::PictureError;
pub use ground::Ground;
pub use picture::Picture;
