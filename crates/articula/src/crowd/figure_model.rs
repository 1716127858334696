//! What the player of one character reads, with the same treatment of root motion as a crowd's.

use super::options::RootMotionPolicy;
use super::preparation::in_place;
use crate::error::{Context, Result};
use crate::figure::Figure;
use articula_core::playback::FigureModel;

/// Joins rig and clips of a figure for [`FigurePlayer`](articula_core::playback::FigurePlayer). Root motion that
/// is extracted is what [`advance`](articula_core::playback::FigurePlayer::advance) returns.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file, if the clips in place do not fit the character.
pub fn figure_model(figure: &Figure, root_motion: RootMotionPolicy) -> Result<FigureModel> {
    let made = || {
        let found = in_place(figure, root_motion, figure.stored().as_ref())?;
        let model = FigureModel::new(found.asset.rig, found.asset.clips)?;
        Ok(match root_motion {
            RootMotionPolicy::Extracted => model.with_root_motion(found.paths)?,
            _ => model,
        })
    };
    let made: Result<FigureModel> = made();
    made.with_context(|| figure.opened.name())
}
