//! 2D output of a virtual human: lit pictures, vector graphics with a correct painting order, and
//! portraits that turn their head.
//!
//! All functions map values to values (pixels, PNG bytes, SVG text). The same input gives the same
//! output.
//!
//! - [`render()`]: renders a skinned character to a lit [`Picture`] through a [`Screen`];
//!   [`Appearance`]: materials and textures; [`orbit_view`], [`tight_view`]: camera placement;
//!   [`Ground`]: the floor
//! - [`Picture::to_png`], [`Picture::decode`]: picture files; [`Picture::resized`]: smaller textures
//! - [`Picture::to_small_png`], [`Picture::to_jpeg`], [`Picture::to_webp`]: small files;
//!   [`color_difference`], [`number_difference`]: whether a texture looks the same
//! - [`rmse`], [`ssim`], [`equal_shift`]: image differences
//! - [`planar`]: a clip projected to the screen, ready to be written in 2D
//! - [`flatten`]: writes a planar clip to a file and measures size and error, in one call
//! - [`vector`]: writers, readers and samplers of the vector formats
//! - [`portrait`]: a talking 2D face that turns its head
//! - [`impostor`]: a far character as small pictures, baked once
//! - [`escaped`]: escapes text for markup
//!
//! [`planar::bake()`] makes a planar clip from a character; this example uses a triangle that moves
//! to the right instead:
//!
//! ```
//! use articula_core::Progress;
//! use articula_flat::flatten::{
//!     PrepareClipOptions, PreparedClip, Profile, Quality, ReferenceFrames, Settings, flatten,
//!     sampled_frames,
//! };
//! use articula_flat::planar::{PlanarClip, PlanarError, PlanarFrame, PlanarMaterial};
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
//!     surfaces: vec![PlanarMaterial { name: "red".into(), albedo: Some([200, 30, 30]) }],
//!     albedo: vec![[200.0, 30.0, 30.0]; 3],
//!     texture: None,
//! };
//! let frames: Vec<f64> = (0..10).map(f64::from).collect();
//! let mut progress = Progress::none();
//! let prepared = PreparedClip::new(clip(&frames), &PrepareClipOptions::default(), &mut progress)?;
//! let moments = sampled_frames(frames.len());
//! let truth = ReferenceFrames::new(&clip(&moments), &moments)?;
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
//! Out of scope: files, clocks, threads, a GPU, system fonts; pictures and plots of reports
//! (`articula-report`); the choice of camera and triangle count for a character (the library
//! `articula`).

#[cfg(test)]
extern crate self as articula_flat;

mod appearance;
mod codec;
mod compare;
mod encode;
mod error;
pub mod flatten;
mod frame;
mod ground;
pub mod impostor;
mod item_buffer;
mod local_difference;
mod low_rank;
mod markup;
mod picture;
pub mod planar;
pub mod portrait;
mod projection;
mod render;
mod resize;
mod shift;
mod texture_difference;
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
pub use resize::Averaging;
pub use shift::{PictureShift, equal_shift};
pub use texture_difference::{
    ColorDifference, NumberDifference, color_difference, number_difference,
};
