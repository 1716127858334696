//! Rigs, clips, meshes and levels of detail of virtual humans, and their evaluation each frame.
//!
//! An engine that plays prepared characters needs only this crate and `glam`. For a single
//! character [`playback::FigurePlayer`] covers the frame: clocks, layers, levels of detail for each
//! joint, forward kinematics and skinning; its plain steps are [`sample`] on a [`Clip`], [`blend`],
//! [`local_to_model`] and [`skin`], and [`PosedMesh`] combines the last two. For many characters
//! [`crowd::Crowd`] covers the whole frame: clocks, culling, levels of detail and palettes.
//!
//! ```
//! use articula_core::{Articulation, JointArticulation, LocalPose, ModelPose, Region, Rig};
//! use articula_core::{Transform, local_to_model, source};
//! use glam::{Quat, Vec3};
//!
//! // An arm of two joints along x, as a file reader returns it, and the rig made from it.
//! let joint = |name: &str, parent, at| source::Joint {
//!     name: name.into(),
//!     parent,
//!     rest: Transform::from_translation(at),
//!     in_skin: true,
//! };
//! let joints = vec![joint("elbow", None, Vec3::ZERO), joint("wrist", Some(0), Vec3::X)];
//! let known = JointArticulation { hanim: None, level: 0, region: Region::Arms };
//! let articulation = Articulation { profile: String::new(), joints: vec![known; 2] };
//! let rig = Rig::new(&source::Skeleton { joints }, articulation)?;
//!
//! // A quarter turn at the elbow carries the wrist from x to y.
//! let mut local: LocalPose = rig.rest_pose().clone();
//! local.rotations[0] = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
//! let mut model = ModelPose::new(rig.len());
//! local_to_model(&rig, &local, &mut model);
//! assert!(model.position(1).distance(Vec3::Y) < 1e-6);
//! # Ok::<(), articula_core::Mismatch>(())
//! ```
//!
//! # Where things are
//!
//! The root exports the read-only types of a frame ([`Rig`], [`Clip`], [`Mesh`], poses, palettes,
//! tables of levels and their errors) and the functions that work on them. Larger topics are
//! modules:
//!
//! - [`source`]: the editable data that file readers return and builders take
//! - [`crowd`]: evaluation of many characters with levels of detail, one tick per frame
//! - [`playback`]: live playback of one figure: layers, controllers of detail, skinning
//! - [`visibility`]: frustum culling, occlusion and size on screen of bodies
//! - [`batch`]: evaluation of eight characters at once, from cursors to palettes
//! - [`loa`]: levels of articulation: selectors, their combination and the expression language
//! - [`face_control`]: what morph targets and expressions of a face show
//! - [`joint_names`]: joint maps: the meaning of the joint names of a kind of rig, as data
//! - [`joint_state`]: active and passive joints, and the transitions between them
//! - [`hanim_table`], [`fap_table`], [`arkit_table`]: the joints of the H-Anim humanoid, the facial
//!   animation parameters of MPEG-4, and the blend shapes of ARKit
//! - [`face_levels`]: levels of articulation of faces
//! - [`Progress`]: progress reports and cancellation of work outside the frame
//!
//! Levels of detail are numbered from 0, the finest, everywhere: joints ([`JointLods`]), meshes
//! ([`Clusters`], [`LevelTable`], [`MeshErrors`]) and keys ([`KeyTable`]). Levels of articulation
//! are a different concept and keep H-Anim's numbers ([`loa`]).
//!
//! Deliberately absent: files, clocks, threads, logging, JSON, and allocation in functions that run
//! once a frame (a test counts allocations).
//!
//! Units are metres, seconds and radians; +Y is up and a character faces +Z.

mod allowance;
pub mod arkit_table;
pub mod batch;
pub mod crowd;
pub mod face_control;
pub mod face_levels;
pub mod fap_table;
pub mod feature_points;
pub mod hanim_table;
pub mod joint_names;
pub mod joint_state;
pub mod loa;
pub mod playback;
pub mod source;
pub mod viseme;
pub mod visibility;

mod articulation;
mod attention;
mod blend;
mod blend_record;
mod bytes;
mod capsule;
mod clip;
mod clip_set;
mod clustered;
mod contact;
mod drift;
mod elementary;
mod figure_level;
mod hierarchy;
mod impostors;
mod joint_lods;
mod joint_set;
mod key_table;
mod level_choice;
mod level_skins;
mod level_table;
mod local_extent;
mod lod_error;
mod math;
mod mesh;
mod mesh_level;
mod mismatch;
mod motion_bounds;
mod palette;
mod percentile;
mod pose;
mod pose_cache;
mod posed_mesh;
mod progress;
mod rig;
mod sample;
mod second_moment;
mod simd;
mod skin;
mod skin_block;
mod skin_groups;
mod sphere;
mod travel;
mod triangle;
mod view;

pub use articulation::{Articulation, Complexity, JointArticulation, Region, Zone};
pub use attention::{Attention, AttentionInterval};
pub use blend::blend;
pub use blend_record::BlendRecord;
pub use bytes::{ByteReader, MalformedBytes, push_varint};
pub use capsule::Capsule;
pub use clip::{Clip, Track, Tracks};
pub use clip_set::{ClipSet, ClipStorage};
pub use clustered::{Cluster, ClusteredTriangles, Clusters};
pub use contact::{Contact, ContactTable};
pub use drift::{DriftController, DriftOptions, JointErrorBounds, JointViewScales};
pub use figure_level::FigureLevel;
pub use hierarchy::{local_to_model, local_to_model_from};
pub use impostors::{ClipImpostors, Impostors};
pub use joint_lods::JointLods;
pub use joint_set::{JointSet, MAX_JOINTS};
pub use key_table::{KeyMode, KeyTable, PoseKeys, TableHashes};
pub use level_skins::{LevelSkin, LevelSkins};
pub use level_table::{LevelRow, LevelTable, SurfaceError};

pub use elementary::{Libm, LibmArc, LibmQuat};
pub use lod_error::{ClipLodErrors, LodErrors, SMALL_PART, lod_error_metres};
pub use math::{Transform, angle_between, nlerp, normalised, rotation_vector, same_hemisphere};
pub use mesh::{Binding, Mesh, Morph, Part};
pub use mesh_level::{MeshChoice, MeshErrors};
pub use mismatch::Mismatch;
pub use motion_bounds::{Bound, ClipBounds, MotionBounds};
pub use palette::{PaletteForm, PaletteMap, PaletteRows};
pub use percentile::{Float, percentile, percentile_at_or_above};
pub use pose::{LocalPose, ModelPose};
pub use pose_cache::{CachedKeys, CachedRows, CachedSteps, PoseCache};
pub use posed_mesh::PosedMesh;
pub use progress::{Cancelled, Progress};
pub use rig::Rig;
pub use sample::{FramePosition, Wrap, frame_position, sample, sample_morphs};
pub use second_moment::SecondMoment;
pub use simd::Backend;
pub use simd::half::{f32_from_half, half_from_f32};
pub use skin::{SkinnedMesh, palette, skin, skin_points};
pub use skin_block::{BLOCK_POSES, PaletteBlock, PointBlock, skin_block};
pub use skin_groups::{GroupedSkin, Matrix3x4, MorphedShape, StaleBlocks};
pub use sphere::Sphere;
pub use travel::{heading, hold_with_heading};
pub use triangle::{triangle_distance_squared, triangle_weights};
pub use view::{Camera, Viewport};
