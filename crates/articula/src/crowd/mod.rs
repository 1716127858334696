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
//! use articula::{AddClipsOptions, Figure, Result, Work, fs, glam::Vec3};
//!
//! fn main() -> Result<()> {
//!     let mut files = std::env::args().skip(1);
//!     let mut hero = fs::open(files.next().unwrap_or("hero.glb".into()))?;
//!     for motion in files {
//!         hero.add_clips(&[fs::open(motion)?], &AddClipsOptions::default(), &Work::default())?;
//!     }
//!     let asset = CrowdAsset::new(&Figure::new(hero)?, &CrowdOptions::default(), &Work::default())?;
//!     let mut crowd = CrowdPlayer::new(&asset, 1000)?;
//!     for i in 0..1000 {
//!         crowd.place(i, Vec3::new((i % 40) as f32, 0.0, (i / 40) as f32) * 2.0, 0.0);
//!         crowd.play(i, i % asset.clips().len(), i as f32 * 0.37);
//!     }
//!     let target = Vec3::new(39.0, 1.0, 20.0);
//!     let camera = Camera::looking_at(target - Vec3::Z * 26.0, target, Viewport::default());
//!     for _frame in 0..60 {
//!         let report = crowd.frame(1.0 / 60.0, &camera);
//!         println!("{} visible, error at most {} px", report.visible, report.bound_px);
//!         for _group in crowd.groups() { /* one instanced draw: mesh, draws, palettes */ }
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

pub use articula_core::crowd::{CacheUse, Crowd, CrowdReport, Detail, Draw, Notice, Sight};
pub use articula_core::visibility::View;
pub use articula_core::{Backend, Camera, PaletteForm, Storage, Viewport};
