//! The long steps of making impostors, with progress and threads of the caller.

use crate::error::{Error, Result};
use crate::work::Executor;
use articula_flat::Picture;
use articula_flat::impostor::{ImpostorPlan, ImpostorSource};

/// Name of the step that chooses in progress reports.
pub(crate) const CHOOSING: &str = "choosing impostors";

/// Name of the step that draws in progress reports.
const DRAWING: &str = "drawing impostors";

/// Draws all pictures of a plan.
pub(crate) fn drawn(
    plan: &ImpostorPlan,
    source: &ImpostorSource<'_>,
    work: &Executor<'_>,
) -> Result<Picture> {
    let poses = (0..plan.poses()).collect();
    let drawn = work.map(DRAWING, poses, |pose| {
        plan.draw(source, pose).map_err(Error::from)
    })?;
    Ok(plan.atlas(&drawn)?)
}
