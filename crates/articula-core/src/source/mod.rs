//! Editable characters: plain structs with public fields, between file readers and builders.
//!
//! A reader returns a [`Character`] with all peculiarities of its format resolved; a builder turns
//! it into the read-only types of the frame, [`Rig`](crate::Rig), [`Mesh`](crate::Mesh) and
//! [`Clip`](crate::Clip).

mod character;
mod clip;
mod credits;
pub mod evaluate;
mod expression;
mod mesh;
mod skeleton;

pub use character::{Character, Image, Material, TextureWrap};
pub use clip::{Channel, Interpolation, JUMP_SECS, Property, RawClip};
pub use credits::Credits;
pub use expression::{Expression, JointBinding, Mask, MaskKind, MorphBinding};
pub use mesh::{MorphTarget, Primitive, RawMesh, RawMeshLevel, Skin, renumber_influences};
pub use skeleton::{Joint, Skeleton};
