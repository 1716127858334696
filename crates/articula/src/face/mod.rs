//! Faces driven by facial animation parameters (FAP) of MPEG-4.
//!
//! - `named`: what morph targets and expressions show by their names
//! - `controls`: the morph targets, expressions or joints of a face whose effect is known
//! - `joints`: joints that show parameters
//! - `fields`: how far the controls move the vertices
//! - `rig`: the parameters that each control amounts to
//! - `frames`: the values of a clip's frames
//! - `surface`: the head as a surface
//! - `points`: the feature points found on it
//! - `fdp`: those of FDP files
//! - `stored`: those that an asset keeps
//! - `found`: a head with its points
//! - `around`: the skin that goes on from a head
//! - `shapes`: blend shapes for a face without them, and tables
//! - `targets`: new morph targets of a head
//! - `turns`: head and eyes, which turn
//! - `capture`: captures of blend shapes as parameters, and back
//! - `measured`: parameters read off a moving face
//! - `vrma`: VRM animations of expressions
//! - `fit`: a FAP clip as a clip of a character
//! - `motion`: any motion of a face that was read from a file
//! - `levels`: a FAP clip at a level of articulation
//! - `detail`: error of levels on a head, and their choice by distance
//! - `with_body`: the parameters of a face that moves with a body
//! - `driven`: how many parameters a face shows

mod around;
mod capture;
mod controls;
mod detail;
#[cfg(all(feature = "flat", feature = "streams"))]
mod driven;
mod fdp;
mod fields;
mod fit;
mod found;
mod frames;
mod joints;
mod levels;
mod measured;
mod motion;
mod named;
mod points;
mod region;
mod rig;
mod shapes;
mod stored;
mod surface;
mod targets;
mod turns;
mod vrma;
mod with_body;

#[cfg(feature = "speech")]
pub(crate) use capture::row_values;
pub use capture::{
    CaptureReport, ShapeLoss, capture_of_clip, capture_to_faps, drives_shapes, faps_to_capture,
};
pub use controls::FaceKind;
pub use detail::{
    FACE_DISTANCES_M, FaceDetailOptions, FaceDetailReport, FaceDetailRow, FaceLevelError, FapLever,
    MeasuredFace, face_detail,
};
#[cfg(all(feature = "flat", feature = "streams"))]
pub(crate) use driven::driven_faps;
pub use fdp::{face_fdp, fdp_points};
pub use fit::{FaceTransfer, FittedFace, NotDriven, ShownParameter, fit_capture, fit_face};
#[cfg(feature = "speech")]
pub(crate) use fit::{NamedMotion, fit_named};
#[cfg(any(feature = "flat", feature = "prepare"))]
pub(crate) use found::FoundFace;
#[cfg(feature = "speech")]
pub(crate) use frames::{file_name, rounded};
pub use levels::{FaceLevelReport, expand_face, reduce_face};
pub use measured::measure_faps;
pub use motion::fit_motion;
pub use named::{NamedTarget, named_controls, rig_face_map};
pub use points::{FaceLayout, FaceUnit, FeaturePoint, face_layout};
pub(crate) use region::face_vertices;
pub use rig::{CaptureBridge, FaceColumns, FaceRig, GENERIC_BRIDGE};
pub use shapes::{
    FaceShapes, FaceTableTargets, RefusedShape, add_face_shapes, add_face_shapes_by, add_face_table,
};
pub use surface::HeadSurface;
#[cfg(feature = "flat")]
pub(crate) use turns::{Turn, turns};
pub use vrma::{faps_to_vrma, presets_to_faps};
pub use with_body::{FaceWithBody, FaceWithBodyRow, face_with_body};
