//! How a file is understood where it does not say it.

use articula_core::joint_names::JointMap;
use articula_formats::joint_map;
use articula_formats::mpeg4::fap::Absent;
use articula_formats::{Limits, UpAxis};

/// How a file is understood: its joint names and, where it does not say, its unit, up axis and
/// rate.
#[derive(Debug, Clone, Default)]
pub struct OpenOptions {
    /// Joint-name profiles that are asked before the built-in ones.
    pub joint_maps: Vec<JointMap>,
    /// BVH, ASF, BVA: metres of one unit; told from the figure's height without it.
    pub unit_metres: Option<f32>,
    /// BVH, ASF, BVA: the axis that points up; told from where the head is without it.
    pub up: UpAxis,
    /// AMC: the bytes of the skeleton (`.asf`) that the motion was made for.
    pub skeleton: Option<Vec<u8>>,
    /// AMC: frames a second; 120 without it, unless the file says it.
    pub amc_rate_hz: Option<f32>,
    /// FAP, BAP: what a parameter does that a frame's mask leaves out.
    pub absent: Absent,
    /// Most memory and time that a file may ask for.
    pub limits: Limits,
}

impl OpenOptions {
    /// The caller's profiles, then the built-in ones.
    pub(super) fn all_profiles(&self) -> Vec<JointMap> {
        let built_in = joint_map::builtin().iter();
        self.joint_maps.iter().chain(built_in).cloned().collect()
    }
}
