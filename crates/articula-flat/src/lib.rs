//! How a virtual human looks in 2D: reference pictures, contact sheets and plots.
//!
//! Everything here takes values and gives values (pixels, PNG bytes, SVG text), always the
//! same for the same input.
//!
//! - [`item_buffer`]: which triangle each sample shows, the base of all pictures
//! - [`picture`], [`codec`]: pixels; PNG and JPEG files
//! - [`projection`]: from metres to pixels, with perspective or parallel
//! - [`appearance`], [`render`]: materials and textures; a lit picture of a skinned character
//! - [`error`]: what can be wrong with a picture

pub mod appearance;
pub mod codec;
pub mod error;
mod ground;
pub mod item_buffer;
pub mod picture;
pub mod projection;
pub mod render;

pub use error::PictureError;
pub use ground::Ground;
pub use picture::Picture;
