//! The pictures of impostors, and the atlas that holds them.
//!
//! Picture `pose * views + view` lies at column `index % columns` and row `index / columns` of the
//! atlas, counted from the top left.

use super::error::{ImpostorError, refuse};
use super::plan::ImpostorPlan;
use super::samples::ImpostorSource;
use super::views::orientation;
use crate::item_buffer::{MAX_SIDE, Supersampling};
use crate::picture::Picture;
use crate::projection::Projection;
use crate::render::{RenderOptions, render};
use articula_core::{Camera, Viewport};
use glam::Vec3;
use std::f32::consts::TAU;

impl ImpostorPlan {
    /// Draws the pictures of one pose, side by side in the order of the directions.
    ///
    /// # Errors
    /// [`ImpostorError::Mismatch`] if there is no such pose or the source is another one.
    pub fn strip(
        &self,
        source: &ImpostorSource<'_>,
        pose: usize,
    ) -> Result<Picture, ImpostorError> {
        let clip = self.clips.iter().rposition(|c| c.first_pose <= pose);
        let of_clip = clip.and_then(|c| {
            let place = pose - self.clips[c].first_pose;
            let (secs, centres) = (&self.clips[c].pose_secs, &self.clips[c].centres);
            Some((c, *secs.get(place)?, *centres.get(place)?))
        });
        let Some((clip, secs, centre)) = of_clip else {
            return Err(refuse("pose", format!("there is no pose {pose}")));
        };
        let skinned = source.skinned(clip, secs);
        let [width, height] = self.cell.size_px;
        let mut strip = Picture::new(width * self.views.len() as u32, height, [0; 4])?;
        let mut x = 0;
        for row in &self.views.rows {
            for yaw in 0..row.yaws {
                let turn = TAU * yaw as f32 / row.yaws as f32;
                let camera = self.camera(centre, turn, row.pitch_radians);
                let options = RenderOptions {
                    background: [0; 4],
                    samples: Supersampling::Four,
                    projection: Projection::Parallel {
                        pixels_per_metre: 1.0 / self.cell.metres_per_px,
                    },
                    light: self.light,
                    ..RenderOptions::default()
                };
                let (mesh, paint) = (source.mesh, source.appearance);
                let picture = render(mesh, &skinned, paint, &camera, &options)?;
                strip.put(&picture, x, 0);
                x += width;
            }
        }
        Ok(strip)
    }

    /// A camera whose viewport is a cell.
    fn camera(&self, centre: Vec3, yaw_radians: f32, pitch_radians: f32) -> Camera {
        let [width_px, height_px] = self.cell.size_px.map(|px| px as f32);
        let orientation = orientation(yaw_radians, pitch_radians);
        let [left, bottom] = self.cell.corner_m;
        let half = 0.5 * self.cell.metres_per_px;
        let middle = Vec3::new(left + half * width_px, bottom + half * height_px, 0.0);
        // The parallel projection shows what is behind the eye too.
        Camera {
            eye: centre + orientation * middle,
            orientation,
            viewport: Viewport {
                width_px,
                height_px,
                ..Viewport::default()
            },
        }
    }

    /// Number of pictures in a row of the atlas: those of one pose, or of as many as make the atlas
    /// about square.
    pub fn columns(&self) -> usize {
        let [width, height] = self.cell.size_px.map(|px| px as usize);
        let (views, poses) = (self.views.len().max(1), self.poses().max(1));
        let squared = (poses * height) as f64 / (views * width) as f64;
        let beside = (squared.sqrt().round() as usize).clamp(1, poses);
        let most = MAX_SIDE as usize / (views * width).max(1);
        views * beside.min(most.max(1))
    }

    /// Joins the strips of all poses.
    ///
    /// # Errors
    /// [`ImpostorError::Mismatch`] if the number or size of strips is not that of the plan,
    /// [`ImpostorError::Picture`] if the atlas has more than 16,384 pixels on a side.
    pub fn atlas(&self, strips: &[Picture]) -> Result<Picture, ImpostorError> {
        let views = self.views.len();
        let [width, height] = self.cell.size_px;
        let is_ours = |s: &Picture| (s.width(), s.height()) == (width * views as u32, height);
        if strips.len() != self.poses() || !strips.iter().all(is_ours) {
            let what = format!("expected {} strips of {views} pictures", self.poses());
            return Err(refuse("strips", what));
        }
        let beside = self.columns() / views.max(1);
        let rows = self.poses().div_ceil(beside);
        let side =
            |count: usize, px: u32| u32::try_from(count).unwrap_or(u32::MAX).saturating_mul(px);
        let size = (side(self.columns(), width), side(rows, height));
        let mut atlas = Picture::new(size.0, size.1, [0; 4])?;
        for (pose, strip) in strips.iter().enumerate() {
            let x = strip.width() * (pose % beside) as u32;
            atlas.put(strip, x, height * (pose / beside) as u32);
        }
        Ok(atlas)
    }
}
