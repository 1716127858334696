//! One of the two rigs, with its measurements.

use super::RetargetFigure;
use super::body::Body;
use super::chain::Chain;
use super::frames::{Frames, Fronts, frames};
use super::rest::Rest;
use articula_core::{Mismatch, angle_between};

/// A rig with the measurements that the plan uses.
#[derive(Debug, Clone)]
pub(super) struct Side {
    pub(super) rest: Rest,
    pub(super) body: Body,
    pub(super) frames: Frames,
    pub(super) spine: Chain,
}

impl Side {
    pub(super) fn new(figure: &RetargetFigure<'_>, which: &str) -> Result<Self, Mismatch> {
        let rest = Rest::new(figure, which)?;
        let body = Body::new(&rest, which)?;
        Ok(Self {
            frames: frames(&rest, &body, &Fronts::new()),
            spine: Chain::new(&rest, &body),
            rest,
            body,
        })
    }
}

impl Side {
    /// The same figure with fronts of limbs detected in a motion.
    pub(super) fn with_fronts(&self, seen: &Fronts) -> Self {
        let mut side = self.clone();
        side.frames = frames(&self.rest, &self.body, seen);
        side
    }

    /// Whether a joint has the same name and, up to size, the same rest transform in both figures:
    /// then whatever is ambiguous in one is equally so in the other.
    pub(super) fn alike(&self, joint: usize, other: &Self, theirs: usize) -> bool {
        let (a, b) = (self.rest.locals[joint], other.rest.locals[theirs]);
        self.rest.names[joint] == other.rest.names[theirs]
            && angle_between(a.0, b.0) < 1e-3
            && a.1.normalize_or_zero().distance(b.1.normalize_or_zero()) < 1e-3
    }
}
