//! Faces driven by facial animation parameters (FAP) of MPEG-4.
//!
//! - `controls`: the morph targets or expressions of a face whose effect is known
//! - `turns`: head and eyes, which turn
//! - `fit`: a FAP clip as a clip of a character
//! - `levels`: a FAP clip at a level of articulation
//! - `detail`: error of levels on a head, and their choice by distance

mod controls;
mod detail;
mod fit;
mod levels;
mod turns;

pub use detail::{
    FACE_DISTANCES_M, FaceDetailOptions, FaceDetailReport, FaceDetailRow, FaceLevelError, FapLever,
    MeasuredFace, face_detail,
};
pub use fit::{FaceTransfer, FittedFace, NotDriven, fit_face};
pub use levels::{FaceLevelReport, expand_face, reduce_face};
