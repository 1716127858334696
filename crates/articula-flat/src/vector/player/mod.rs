//! A clip as a small file with a small player: one SVG or one JavaScript module.
//!
//! Source: `docs/methods/vector.md` 8.3; `docs/formats/artv.md`.
//!
//! - [`PlayerClip`]: content of the container; [`encode`] and [`decode`] write and read it
//! - [`LiveSource`]: a clip that named inputs drive
//! - [`PlayerOutput`]: SVG or module, with the player's script
//! - [`ShownTexture`]: what a file tells of the picture that its triangles show
//! - [`PlayerError`]: errors of malformed containers

mod canvas;
mod clip;
mod container;
mod decode;
mod deflate;
mod error;
mod first_frame;
mod fit;
mod live;
mod make;
mod page;
mod stream;
#[cfg(test)]
mod tests;
mod texture;
mod topology;

pub use clip::{PlayerClip, PlayerFrame};
pub use container::encode;
pub use decode::decode;
pub use error::PlayerError;
pub use live::LiveSource;
pub use page::PlayerOutput;
pub use texture::ShownTexture;

pub(crate) use canvas::on_canvas;
pub(crate) use live::live_player;
pub(crate) use make::{PlayerOptions, player};
