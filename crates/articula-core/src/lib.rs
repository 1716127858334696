//! What a virtual human is, and how it moves this frame.
//!
//! The modules stand in the order of the FRAME line: a view asks for detail, a selection
//! says which joints may move, the clip is sampled, the hierarchy turns local transforms into
//! model space, the skin follows.
//!
//! - [`source`]: the editable nouns that readers give and builders take
//! - [`rig`], [`clip`], [`mesh`]: the read-only nouns of the frame
//! - [`clustered`]: the levels of a mesh as ranges of one index list
//! - [`level_table`]: what each of them loses
//! - [`articulation`]: H-Anim level and region of every joint
//! - [`hanim_table`], [`fap_table`]: the joints of the standard humanoid, and the parameters of
//!   its face
//! - [`loa`]: joint sets, the selectors, their combination and the expression language
//! - [`view`]: viewport, camera, pixels per metre
//! - [`sphere`], [`world_bounds`], [`frustum`], [`visibility`]: which bodies are seen, soon may
//!   be, and how large
//! - [`capsule`], [`occlusion`]: how much of a body others hide, for those who ask no renderer
//! - [`pose`], [`sample`], [`mod@blend`], [`hierarchy`], [`skin`]: one verb each
//! - [`skin_groups`]: the skin four vertices at a time, and only where something moved
//! - [`joint_state`]: active, passive and the transitions between them
//! - [`motion_bounds`]: what holds a moving character, by the second of its clip
//! - [`motion_error`]: what a held joint costs, in metres and in pixels
//! - [`attention`]: when a clip and who plays it matter more, so that less error is tolerated
//! - [`thesis_metric`]: the second step of the thesis' metric, kept as a baseline
//! - [`drift`]: ours, untabled: holds joints while what is shown stays within the tolerance
//! - [`budget`]: one option for each character of a crowd, least error within the budget
//! - [`key_table`]: ours, tabled: nested keys for a ladder of tolerances
//! - [`ladder`], [`level_error`]: merged levels of a crowd, and what each costs
//! - [`mesh_level`]: which level of its mesh a character is drawn with
//! - [`clip_set`], [`palette`], [`batch`]: eight characters at once, from cursors to palettes
//! - [`pose_cache`]: whole palettes shared by all characters, and the blend between two of them
//! - [`crowd`]: the whole FRAME line for many characters
//! - [`Progress`]: how far work outside the frame is, and whether it goes on
//!
//! What is deliberately absent: files, clocks, threads, logging, JSON, and any allocation in a
//! function that runs once a frame (a test counts them).
//!
//! Units are metres, seconds and radians; +Y is up and a character faces +Z.

pub mod articulation;
pub mod attention;
pub mod batch;
pub mod blend;
pub mod budget;
pub mod capsule;
pub mod clip;
pub mod clip_set;
pub mod clustered;
pub mod crowd;
pub mod drift;
pub mod fap_table;
pub mod frustum;
pub mod hanim_table;
pub mod hierarchy;
pub mod joint_state;
pub mod key_table;
pub mod ladder;
pub mod level_error;
pub mod level_table;
pub mod loa;
pub mod math;
pub mod mesh;
pub mod mesh_level;
pub mod motion_bounds;
pub mod motion_error;
pub mod occlusion;
pub mod palette;
pub mod pose;
pub mod pose_cache;
mod progress;
pub mod rig;
pub mod sample;
pub mod skin;
pub mod skin_groups;
pub mod source;
pub mod sphere;
pub mod stream;
pub mod thesis_metric;
pub mod view;
pub mod visibility;
pub mod world_bounds;

mod mismatch;
mod simd;
pub use mismatch::Mismatch;
pub use simd::half::{f32_from_half, half_from_f32};
pub use simd::{Backend, LANES, Tile};

pub use progress::{Cancelled, Progress};
