//! Parts of the extension `ARTICULA_prepared` as bytes: what is computed once for a character and
//! played in every frame.
//!
//! Little endian; counts and indices are variable-length, numbers 32-bit floats. Readers check the
//! shapes within a part, and against the rig or mesh where they are given one. The layout is
//! described in `docs/formats/ARTICULA_prepared.md`.
//!
//! - `order`: the order of vertices in the source file
//! - `clips`: runtime clips, and clips whose root motion was removed
//! - `joint_levels`: joint LODs, pairs of joint and mesh levels, and their errors
//! - `skins`: the skin of each joint LOD
//! - `bounds`: bounds for culling
//! - `pose_keys`: keys of the pose cache
//! - `numbers`: the numbers that all of them are made of

mod bounds;
mod clips;
mod joint_levels;
mod numbers;
mod order;
mod pose_keys;
mod skins;

pub use bounds::{read_motion_bounds, write_motion_bounds};
pub use clips::{ClipsInPlace, read_clips, read_clips_in_place, write_clips, write_clips_in_place};
pub use joint_levels::{
    JointLevels, PairedLevels, read_joint_levels, read_paired_levels, write_joint_levels,
    write_paired_levels,
};
pub use order::{SourceOrder, read_source_orders, restore_order, write_source_orders};
pub use pose_keys::{CACHE_KEYS_VERSION, CacheKeys, read_cache_keys, write_cache_keys};
pub use skins::{read_level_skins, write_level_skins};
