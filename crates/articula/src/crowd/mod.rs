//! Crowds of one character: prepared once, played every frame.
//!
//! - [`CrowdAsset`]: the character with its joint and mesh LODs and what each costs the viewer
//! - [`CrowdPlayer`]: a crowd of it, with all the memory that a frame needs
//! - [`ScenePlayer`]: the same as a scene says: places, cameras, cross-fades; [`read_scene`]
//! - [`BudgetAllocator`]: what a frame may spend, learnt from what frames took
//! - [`ErrorMeter`], [`LevelTally`]: what is shown against what should be, and who is shown how
//!
//! ```no_run
//! use articula::crowd::{Camera, CrowdAsset, CrowdOptions, CrowdPlayer, Viewport};
//! use articula::{Figure, Result, Work, glam::Vec3};
//!
//! fn main() -> Result<()> {
//!     let path = std::env::args().nth(1).unwrap_or("hero.glb".into());
//!     let figure = Figure::new(articula::fs::open(path)?)?;
//!     let asset = CrowdAsset::new(&figure, &CrowdOptions::default(), &Work::default())?;
//!     let mut crowd = CrowdPlayer::new(&asset, 1000)?;
//!     for i in 0..1000 {
//!         let place = Vec3::new((i % 40) as f32, 0.0, (i / 40) as f32) * 2.0;
//!         crowd.place(i, place, 0.0);
//!         crowd.play(i, i % asset.clips().len(), i as f32 * 0.37);
//!     }
//!     let (eye, target) = (Vec3::new(39.0, 1.7, -6.0), Vec3::new(39.0, 1.0, 20.0));
//!     let camera = Camera::looking_at(eye, target, Viewport::default());
//!     for _frame in 0..60 {
//!         let report = crowd.frame(1.0 / 60.0, &camera);
//!         println!("{} visible, error at most {} px", report.visible, report.bound_px);
//!         for group in crowd.groups() {
//!             // One instanced draw of `group.mesh`; each of `group.draws` names a character and
//!             // where its `group.matrices` matrices begin in `crowd.palettes()`.
//!         }
//!     }
//!     Ok(())
//! }
//! ```
//!
//! Nothing here has a clock, a thread or a policy of its own: time steps, the nanoseconds that
//! frames took and the threads that evaluate [`parts`](CrowdPlayer::parts) are the caller's.

mod asset;
mod budget;
mod level_use;
mod lod_error;
mod mesh_lods;
mod options;
mod palette_hash;
mod palettes;
mod player;
mod scene_file;
mod scene_player;

pub use asset::{CrowdAsset, CrowdLevel};
pub use budget::{Allowance, BudgetAllocator};
pub use level_use::{DrawCost, LevelTally, LevelUse, MeasuredError};
pub use lod_error::{CharacterError, ErrorMeter, ErrorSample, ErrorSummary, NEAR_METRES};
pub use mesh_lods::MOST_MESH_LEVELS;
pub use options::{CrowdOptions, JointLods, PaletteMatrices, RootMotion};
pub use palette_hash::PaletteHash;
pub use palettes::PaletteSlice;
pub use player::{CrowdGroup, CrowdPlayer, FramePart, PoseSource};
pub use scene_file::{MOST_MEMBERS, read_scene, write_scene};
pub use scene_player::{DetailGoal, SceneOptions, ScenePlayer};

pub use articula_core::Backend;
pub use articula_core::clip_set::Storage;
pub use articula_core::crowd::{CacheUse, Crowd, CrowdReport, Detail, Draw, Notice, Sight};
pub use articula_core::palette::PaletteForm;
pub use articula_core::view::{Camera, Viewport};
pub use articula_core::visibility::View;
