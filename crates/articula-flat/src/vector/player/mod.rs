//! A clip as a small file with a small player: one SVG or one JavaScript module.
//!
//! Source: `spec/vector.md` 8.3; `docs/formats/artv.md`.
//!
//! - [`clip`]: the noun, what the container holds
//! - [`container`], [`decode`]: writing and reading it
//! - [`live`]: a clip that named inputs drive
//! - [`page`]: the text around it, with the player's script
//! - [`error`]: what can be wrong with bytes

pub mod clip;
pub mod container;
pub mod decode;
pub mod error;
mod fit;
pub mod live;
mod make;
pub mod page;
mod stream;
#[cfg(test)]
mod tests;
mod topology;

pub use clip::PlayerClip;
pub use live::{LiveSource, live_player};
pub use make::{PlayerFile, PlayerOptions, PlayerStats, player};
pub use page::Output;
