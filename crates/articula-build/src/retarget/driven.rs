//! The main joints of a target that a source does not drive.

use super::plan::{Drive, Plan};
use super::side::Side;

/// Joints that a motion of a whole body drives; the first vertebra stands for the spine. Without
/// wrists: hands that stay in line with their forearms are hardly seen.
const MAIN: [&str; 13] = [
    "humanoid_root",
    "vl5",
    "skullbase",
    "l_shoulder",
    "l_elbow",
    "r_shoulder",
    "r_elbow",
    "l_hip",
    "l_knee",
    "l_ankle",
    "r_hip",
    "r_knee",
    "r_ankle",
];

/// Main joints of a target that nothing drives.
#[derive(Debug, Clone, PartialEq)]
pub struct NotDriven {
    /// Their H-Anim names.
    pub joints: Vec<&'static str>,
    /// Their share of the main joints that the target has, 0 to 1.
    pub share: f32,
}

/// Main joints of the target that no source joint drives.
pub(super) fn not_driven(target: &Side, plan: &Plan) -> NotDriven {
    let found = MAIN
        .iter()
        .filter_map(|name| Some((*name, target.rest.find(name)?)));
    let found: Vec<(&str, usize)> = found.collect();
    let is_held = |(_, joint): &&(&'static str, usize)| plan.drives[*joint] == Drive::Held;
    let held = found.iter().filter(is_held).map(|(name, _)| *name);
    let joints: Vec<&str> = held.collect();
    NotDriven {
        share: joints.len() as f32 / found.len().max(1) as f32,
        joints,
    }
}
