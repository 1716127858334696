//! What a budget did over the frames of a measured scene.

use super::spread::Spread;
use serde::Serialize;

/// Result of a budget over the frames that count. The names of the fields are stable.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct BudgetUse {
    /// Whether the time and the error that should not be exceeded were kept together in all frames, as far as
    /// expected.
    pub budget_satisfied: bool,
    /// Frames in which they were.
    pub satisfied: usize,
    /// Expected time of a frame, mean, milliseconds.
    pub expected_ms: f64,
    /// The least time of a frame, with everyone at the cheapest that any tolerance allows, mean, milliseconds: a
    /// budget below it gets this.
    pub floor_ms: f64,
    /// Tolerance of a frame, pixels.
    pub tolerance_px: Spread,
    /// Greatest tolerance of any frame, pixels.
    pub worst_px: f32,
    /// Greatest tolerance for near characters of any frame, pixels
    /// ([`Allowance::NEAR_PX_PER_METRE`](super::Allowance::NEAR_PX_PER_METRE)).
    pub near_px: f32,
    /// Frames for which the budget did not suffice for the error cap.
    pub overloaded: usize,
    /// What was given up.
    pub sacrificed: Sacrificed,
}

/// Numbers of frames after which something was given up for the budget, in the order in which it is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Sacrificed {
    /// Triangles: poses were chosen by processor time alone.
    pub triangles: usize,
    /// Pixels: the error was above the cap, of near characters at most twice the cap.
    pub pixels: usize,
    /// Time: the budget was below the least time of a frame.
    pub time: usize,
}
