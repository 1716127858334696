//! The editable nouns between readers and builders: public fields, no cleverness.
//!
//! A reader gives a [`Character`] with everything difficult about its format resolved; a
//! builder turns it into the read-only nouns of the frame.

mod character;
mod clip;
mod credits;
pub mod evaluate;
mod expression;
mod mesh;
mod skeleton;

pub use character::{Character, Image, Material};
pub use clip::{Channel, Interpolation, Property, RawClip};
pub use credits::Credits;
pub use expression::{Expression, JointBinding, Mask, MaskKind, MorphBinding};
pub use mesh::{MeshLevel, MorphTarget, Primitive, RawMesh, Skin};
pub use skeleton::{Joint, Skeleton};
