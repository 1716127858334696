//! Faces: between MPEG-4 facial animation parameters (FAP) and the controls of today's faces.
//!
//! - `fap_values`: values of the low-level parameters
//! - `high_level`: visemes and expressions (FAP 1 and 2) as low-level parameters
//! - `names`: what a morph target or an expression shows, by its name
//! - `controls`: the parameters that it amounts to
//! - `bridge`: weights of controls to parameters, and back by bounded least squares
//! - `opposed`: least squares without controls that undo each other
//! - `bounded`: the least-squares solver
//! - `intervals`: morph targets that show a part of one parameter's range
//! - `points`: the feature points of a face on its mesh
//! - `mouth`: how the lower face of any head moves with blend shapes, measured on heads that have them
//! - `table`: how the vertices move with each parameter, from the feature points alone
//! - `unfold`: displacements that turn no triangle over
//! - `dense`: dense systems of linear equations
//! - `field_fit`: displacements as sums of others, by least squares
//! - `fields`: how far the controls of a face move its vertices
//! - `detail`: error of a clip at levels of articulation, and the coarsest choice within a tolerance
//!
//! Method and values: `docs/methods/faces.md`, of levels `docs/methods/face-levels.md`.

mod bounded;
mod bridge;
mod controls;
mod dense;
mod detail;
mod fap_values;
mod field_fit;
mod fields;
mod high_level;
mod intervals;
mod mouth;
mod names;
mod opposed;
mod points;
mod table;
mod unfold;

pub use bridge::{FaceBridge, FaceSolver, ShownFace};
pub use controls::{
    arkit_name, arkit_shape, blend_shape, control_column, opposite_controls, vrm_preset,
};
pub use detail::{FaceDetail, FaceFrames};
pub use fap_values::FapValues;
pub use field_fit::FieldFit;
pub use fields::FaceFields;
pub use high_level::{add_expression, add_viseme};
pub use intervals::FapInterval;
pub use mouth::{BrokenMotions, MouthChart, MouthMotions};
pub use names::{ChosenControl, FaceCandidate, NamedControl, choose_controls, face_control};
pub use points::{FacePoint, FacePoints, FaceSurface, FaceUnits, NoFace, PointSource, UnitRatio};
pub use table::{EyeShape, FaceTable, JawMotion, NoLids, normal_offsets, without_lids};
pub use unfold::SkinFolds;
