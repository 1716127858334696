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
    /// Draws the pictures of one pose, in the order of the directions.
    ///
    /// # Errors
    /// [`ImpostorError::Mismatch`] if there is no such pose or the source is another one.
    pub fn draw(
        &self,
        source: &ImpostorSource<'_>,
        pose: usize,
    ) -> Result<Vec<Picture>, ImpostorError> {
        let Some((clip, place)) = self.clip_of(pose) else {
            return Err(refuse("pose", format!("there is no pose {pose}")));
        };
        let secs = self.clips[clip].pose_secs[place];
        let centre = self.clips[clip].centres[place];
        let skinned = source.skinned(clip, secs);
        let options = RenderOptions {
            background: [0; 4],
            samples: Supersampling::Four,
            projection: Projection::Parallel {
                pixels_per_metre: 1.0 / self.cell.metres_per_px,
            },
            light: self.light,
            ..RenderOptions::default()
        };
        let rows = self.views.rows.iter();
        let turns = rows.flat_map(|row| {
            let turn = move |yaw: u32| TAU * yaw as f32 / row.yaws as f32;
            (0..row.yaws).map(move |yaw| (turn(yaw), row.pitch_radians))
        });
        let pictures = turns.map(|(yaw, pitch)| {
            let camera = self.camera(centre, yaw, pitch);
            render(source.mesh, &skinned, source.appearance, &camera, &options)
        });
        Ok(pictures.collect::<Result<_, _>>()?)
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

    /// Number of pictures in a row of the atlas, which is about square.
    pub fn columns(&self) -> usize {
        let [width, height] = self.cell.size_px.map(|px| px as usize);
        let pictures = self.pictures().max(1);
        let squared = (pictures * height) as f64 / width as f64;
        let beside = (squared.sqrt().ceil() as usize).clamp(1, pictures);
        beside.min(MAX_SIDE as usize / width)
    }

    /// Joins the pictures of all poses.
    ///
    /// # Errors
    /// [`ImpostorError::Mismatch`] if number or size of the pictures is not that of the plan,
    /// [`ImpostorError::Picture`] if the atlas has more than 16,384 pixels on a side.
    pub fn atlas(&self, poses: &[Vec<Picture>]) -> Result<Picture, ImpostorError> {
        let [width, height] = self.cell.size_px;
        let is_ours = |p: &Picture| (p.width(), p.height()) == (width, height);
        let is_whole = |p: &Vec<Picture>| p.len() == self.views.len() && p.iter().all(is_ours);
        if poses.len() != self.poses() || !poses.iter().all(is_whole) {
            let what = format!("expected {} poses", self.poses());
            return Err(refuse(
                "poses",
                format!("{what} of {} pictures", self.views.len()),
            ));
        }
        let columns = self.columns();
        let side = |count: usize, px: u32| {
            let count = u32::try_from(count).unwrap_or(u32::MAX);
            count.saturating_mul(px)
        };
        let rows = self.pictures().div_ceil(columns);
        let mut atlas = Picture::new(side(columns, width), side(rows, height), [0; 4])?;
        for (i, picture) in poses.iter().flatten().enumerate() {
            let (x, y) = (width * (i % columns) as u32, height * (i / columns) as u32);
            atlas.put(picture, x, y);
        }
        Ok(atlas)
    }
}
