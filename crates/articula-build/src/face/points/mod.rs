//! Feature points of a face, found on its mesh.
//!
//! - `surface`: the mesh of a head, and its connected parts
//! - `profile`: the profile of a face, and the features along it
//! - `front`: what is seen of triangles from the front
//! - `eyes`: eyeballs, and the openings of the lids
//! - `sockets`: the same of a head without eyeballs
//! - `anchors`: the points that the geometry shows by itself
//! - `template`: an average head with all points
//! - `warp`: the smooth map from the template to a head
//! - `find`: all points, from the anchors and the template
//! - `units`: the distances by which parameters are measured

mod anchors;
mod eyes;
mod find;
mod front;
mod profile;
mod sockets;
mod surface;
mod template;
mod units;
mod warp;

pub(super) use eyes::is_on_ball;
#[cfg(test)]
pub(super) use find::FaceParts;
pub use find::{FacePoint, FacePoints, NoFace, PointSource};
pub(super) use find::{Snap, to_template};
pub(super) use front::{FrontGrid, FrontView, regions};
pub use surface::FaceSurface;
pub(super) use template::template_place;
pub use units::{FaceUnits, UnitRatio};
