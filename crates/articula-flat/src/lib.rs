//! How a virtual human looks in 2D: lit pictures, portraits that turn their head, and vector
//! graphics with the right painting order.
//!
//! Everything here takes values and gives values (pixels, PNG bytes, SVG text), always the
//! same for the same input.
//!
//! - [`render()`]: a lit [`Picture`] of a skinned character before a [`Screen`]; [`Appearance`]:
//!   its materials and textures; [`orbit_view`], [`tight_view`]: where the camera stands;
//!   [`Ground`]: what it stands on
//! - [`Picture::to_png`], [`Picture::decode`]: picture files; [`rmse`], [`ssim`]: how far two
//!   pictures are apart
//! - [`planar`]: a clip as the camera sees it, ready to be written in 2D
//! - [`flatten`]: one call from there to a file with its size and error
//! - [`vector`]: the files, written, read back and sampled
//! - [`portrait`]: a talking face in 2D that turns its head
//! - [`escaped`]: text inside markup
//!
//! A character comes from [`planar::bake()`]; here a triangle that moves to the right stands in
//! for it:
//!
//! ```
//! use articula_core::Progress;
//! use articula_flat::flatten::{
//!     PrepareOptions, Prepared, Profile, Quality, Settings, Truth, flatten, sampled_frames,
//! };
//! use articula_flat::planar::{PlanarClip, PlanarError, PlanarFrame, Surface};
//! use glam::Vec2;
//!
//! let frame = |at: f64| PlanarFrame {
//!     xy: [(0.0, 50.0), (40.0, 50.0), (20.0, 10.0)]
//!         .map(|(x, y)| Vec2::new(x + 5.0 * at as f32, y))
//!         .to_vec(),
//!     nearness: vec![1.0; 3],
//!     light: vec![1.0; 3],
//! };
//! let clip = |moments: &[f64]| PlanarClip {
//!     width: 100,
//!     height: 60,
//!     fps: 25.0,
//!     frames: moments.iter().map(|at| frame(*at)).collect(),
//!     triangles: vec![[0, 1, 2]],
//!     surface: vec![0],
//!     part: vec![0],
//!     surfaces: vec![Surface { name: "red".into(), albedo: Some([200, 30, 30]) }],
//!     albedo: vec![[200.0, 30.0, 30.0]; 3],
//! };
//! let frames: Vec<f64> = (0..10).map(f64::from).collect();
//! let mut progress = Progress::none();
//! let prepared = Prepared::new(clip(&frames), &PrepareOptions::default(), &mut progress)?;
//! let moments = sampled_frames(frames.len());
//! let truth = Truth::new(&clip(&moments), &moments)?;
//! let settings = Settings {
//!     profile: Profile::Smil,
//!     quality: Quality::of(Profile::Smil),
//!     name: "a triangle".into(),
//!     max_bytes: None,
//! };
//! let flat = flatten(&prepared, &settings, &truth, &mut progress)?;
//! assert!(flat.bytes.starts_with(b"<svg") && flat.sizes.raw < 1000);
//! assert!(flat.errors.image.ssim > 0.98);
//! # Ok::<(), PlanarError>(())
//! ```
//!
//! What is deliberately absent: files, clocks, threads, a GPU, fonts of the system; pictures and
//! plots of reports (`articula-report`); which camera and how many triangles suit a character
//! (the library `articula`).

#[cfg(test)]
extern crate self as articula_flat;

mod appearance;
mod codec;
mod compare;
mod error;
pub mod flatten;
mod frame;
mod ground;
mod item_buffer;
mod low_rank;
mod markup;
mod picture;
pub mod planar;
pub mod portrait;
mod projection;
mod render;
pub mod vector;

pub use appearance::{Appearance, UndecodedTexture};
pub use compare::{masked_rmse, rmse, ssim};
pub use error::PictureError;
pub use frame::{Bounds, orbit_view, tight_view};
pub use ground::Ground;
pub use item_buffer::Supersampling;
pub use markup::escaped;
pub use picture::{Picture, Rgba, linear_table};
pub use projection::{Projection, Screen};
pub use render::{Light, PartSelection, RenderOptions, render};
