//! Image error of a portrait against a render of the 3D figure in the same pose.

use super::error::PortraitError;
use super::head::HeadPose;
use super::model::Portrait;
use super::posing::Poser;
use super::source::{PortraitOptions, PortraitSource};
use super::views::render_options;
use crate::error::PictureError;
use crate::picture::Picture;
use crate::render::render;

/// Renders the reference of a portrait: the 3D figure in full quality, under the same light.
///
/// # Errors
/// As [`super::build`], and [`PortraitError::Mismatch`] for more weights than expressions.
pub(super) fn truth(
    source: &PortraitSource<'_>,
    options: &PortraitOptions,
    pose: &HeadPose,
    weights: &[f32],
) -> Result<Picture, PortraitError> {
    source.check(options)?;
    let most = source.expressions.len();
    if weights.len() > most || weights.iter().any(|w| !w.is_finite()) || !pose.is_finite() {
        let what = format!(
            "{} weights for {most} expressions; there must not be more, and all values must be \
             finite",
            weights.len()
        );
        return Err(super::error::refuse("weights", what));
    }
    let poser = Poser::new(source.mesh, source.rig, &source.head, source.expressions);
    let driven: Vec<(usize, f32)> = weights.iter().copied().enumerate().collect();
    let skinned = poser.skin(*pose, &driven);
    let options = render_options(pose);
    Ok(render(
        source.mesh,
        &skinned,
        source.appearance,
        &source.camera,
        &options,
    )?)
}

/// Root mean square difference over the pixels where either picture shows the figure, in levels (0
/// to 255), both over white.
///
/// # Errors
/// [`PictureError::Mismatch`] if the pictures differ in size.
pub(super) fn rmse_over_figure(a: &Picture, b: &Picture) -> Result<f64, PictureError> {
    let whole = crate::compare::rmse(a, b)?;
    let shown = a.pixels().iter().zip(b.pixels());
    let shown = shown.filter(|(p, q)| p[3] > 0 || q[3] > 0).count();
    // Pixels without the figure are white in both, so they only increase the count.
    let share = shown.max(1) as f64 / a.pixels().len().max(1) as f64;
    Ok(whole / share.sqrt())
}

impl Portrait {
    /// Returns the error against a render of the 3D figure in full quality under the same light:
    /// root mean square over the figure's pixels, levels (0 to 255).
    ///
    /// # Errors
    /// As [`super::build()`] and [`Self::picture`]; [`PortraitError::Mismatch`] for more weights
    /// than expressions.
    pub fn error(
        &self,
        source: &PortraitSource<'_>,
        options: &PortraitOptions,
        pose: &HeadPose,
        weights: &[f32],
    ) -> Result<f64, PortraitError> {
        let found = self.picture(pose, weights)?;
        let truth = truth(source, options, pose, weights)?;
        Ok(rmse_over_figure(&found, &truth)?)
    }
}
