//! Options for opening files.

use articula_core::face_control::FaceMap;
use articula_core::joint_names::JointMap;
use articula_formats::mpeg4::fap::AbsentPolicy;
use articula_formats::{Limits, UpAxis};

/// Options for opening a file: joint maps, and unit, up axis and rate for formats that do not store
/// them.
#[derive(Debug, Clone, Default)]
pub struct OpenOptions {
    /// Joint maps that take precedence over the file's own humanoid map and the built-in ones; the
    /// one that fits best is used alone.
    pub joint_maps: Vec<JointMap>,
    /// What morph targets and expressions show, instead of what their names say.
    pub face_map: Option<FaceMap>,
    /// Metres per unit of the file, above 0; if `None`, estimated from the figure's size for BVH,
    /// ASF and BVA, and as the format states it for the others: metres.
    pub unit_metres: Option<f32>,
    /// BVH, ASF, BVA: the up axis; by default estimated from the position of the head, at rest or in
    /// motion.
    pub up: UpAxis,
    /// AMC: the bytes of the motion's skeleton file (`.asf`).
    pub skeleton: Option<Vec<u8>>,
    /// AMC: frames per second; if `None`, as stored in the file, else 120.
    pub amc_rate_hz: Option<f32>,
    /// FAP, BAP: treatment of parameters that a frame's mask omits.
    pub absent: AbsentPolicy,
    /// Maximum memory and time that a file may require.
    pub limits: Limits,
}
