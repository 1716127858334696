//! Faces driven by facial animation parameters (FAP) of MPEG-4.
//!
//! - `controls`: the morph targets or expressions of a face whose effect is known
//! - `fields`: how far the controls move the vertices
//! - `rig`: the parameters that each control amounts to
//! - `frames`: the values of a clip's frames
//! - `surface`: the head as a surface
//! - `points`: the feature points found on it
//! - `fdp`: those of FDP files
//! - `stored`: those that an asset keeps
//! - `shapes`: blend shapes for a face without them, and tables
//! - `tabled`: a head with its points and its table
//! - `targets`: new morph targets of a head
//! - `turns`: head and eyes, which turn
//! - `capture`: captures of blend shapes as parameters, and back
//! - `fit`: a FAP clip as a clip of a character
//! - `levels`: a FAP clip at a level of articulation
//! - `detail`: error of levels on a head, and their choice by distance

mod capture;
mod controls;
mod detail;
mod fdp;
mod fields;
mod fit;
mod frames;
mod levels;
mod points;
mod region;
mod rig;
mod shapes;
mod stored;
mod surface;
mod tabled;
mod targets;
mod turns;

pub use capture::{CaptureReport, ShapeLoss, capture_of_clip, capture_to_faps, faps_to_capture};
pub use detail::{
    FACE_DISTANCES_M, FaceDetailOptions, FaceDetailReport, FaceDetailRow, FaceLevelError, FapLever,
    MeasuredFace, face_detail,
};
pub use fdp::{face_fdp, fdp_points};
pub use fit::{FaceTransfer, FittedFace, NotDriven, fit_capture, fit_face};
pub use levels::{FaceLevelReport, expand_face, reduce_face};
pub use points::{FaceLayout, FaceUnit, FeaturePoint, face_layout};
pub(crate) use region::face_vertices;
pub use rig::{CaptureBridge, FaceColumns, FaceRig, GENERIC_BRIDGE};
pub use shapes::{FaceShapes, FaceTableTargets, add_face_shapes, add_face_table};
pub(crate) use stored::stored_face;
pub use surface::HeadSurface;
