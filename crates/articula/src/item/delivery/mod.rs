//! An item in pieces that can be fetched or sent one by one, and the levels of quality that they make.
//!
//! - `catalogue`: the pieces, as ranges of bytes
//! - `ladder`: the layers of each level
//! - `missing`: what is there and missing of a level

mod catalogue;
mod ladder;
mod missing;

pub(crate) use catalogue::{PieceOf, access_units};
pub(crate) use ladder::{Kept, is_motion, largest, mesh_level, side};
pub(crate) use missing::Delivery;
