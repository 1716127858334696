//! One character, one motion, one camera: what is seen of it, at the triangles that were asked
//! for.

use super::head::head_weights;
use crate::console::Console;
use crate::facing::facing;
use crate::prepared::Prepared;
use anyhow::{Context, anyhow};
use articula_build::decimate;
use articula_core::{ModelPose, Viewport, local_to_model};
use articula_flat::planar::stage;
use articula_flat::planar::{BakeOptions, Lamp, Subject, Turn, bake};
use articula_flat::planar::{Drawn, PlanarClip, PlanarError};
use articula_flat::planar::{MAX_FRAMES, MAX_TRIANGLES};
use articula_flat::{Appearance, Projection};

/// Moments at which bounds and hidden layers are looked for.
const LOOKS: usize = 40;

/// What is to be shown, and from where.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shot {
    /// Index of the clip; the rest pose without one.
    pub(crate) clip: Option<usize>,
    /// The one moment that is shown, seconds; all of the clip without.
    pub(crate) still_at: Option<f32>,
    /// How often the clip is played.
    pub(crate) cycles: u32,
    /// Frames a second that are wished for.
    pub(crate) fps: f32,
    /// Where the camera stands about the figure's front, degrees to its left, and how high.
    pub(crate) yaw_deg: f32,
    pub(crate) pitch_deg: f32,
    /// How far the figure turns in all.
    pub(crate) turn_deg: f32,
    /// Size and opening of the picture.
    pub(crate) viewport: Viewport,
    /// Triangles that the figure should have; all of them without.
    pub(crate) triangles: Option<usize>,
}

/// A character before a camera.
pub(crate) struct Staged<'a> {
    prepared: &'a Prepared,
    shot: Shot,
    look: Appearance,
    pub(crate) options: BakeOptions,
    /// The triangles that are shown, over the character's vertices.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Moments of the frames.
    pub(crate) moments_secs: Vec<f64>,
}

impl<'a> Staged<'a> {
    /// Puts up the camera, leaves out what it never sees, and makes the rest as coarse as asked.
    pub(crate) fn new(
        prepared: &'a Prepared,
        shot: Shot,
        console: &Console,
    ) -> anyhow::Result<Self> {
        let character = &prepared.loaded.character;
        if prepared.asset.mesh.triangles.is_empty() {
            let place = prepared.loaded.place();
            let what = "no mesh to show; give a file with one, or hide fewer of them";
            return Err(anyhow!("{place}: {what}"));
        }
        let (look, _) = Appearance::new(&character.materials, &character.images);
        let (moments_secs, fps) = moments(prepared, &shot)?;
        let length = moments_secs.last().copied().unwrap_or_default();
        let options = BakeOptions {
            camera: articula_core::Camera::looking_at(
                glam::Vec3::Z,
                glam::Vec3::ZERO,
                shot.viewport,
            ),
            projection: Projection::Perspective,
            lamp: Lamp::default(),
            fps,
            turn: Turn {
                axis: (0.0, 0.0),
                radians_per_sec: if length > 0.0 {
                    shot.turn_deg.to_radians() / length as f32
                } else {
                    0.0
                },
            },
        };
        let mut staged = Self {
            prepared,
            shot,
            look,
            options,
            triangles: prepared.asset.mesh.triangles.clone(),
            moments_secs,
        };
        let bar = console.progress("looking", 2);
        staged.put_up_camera()?;
        bar.inc(1);
        staged.thin_out()?;
        bar.finish_and_clear();
        Ok(staged)
    }

    /// The subject as it is shown.
    pub(crate) fn subject(&self) -> Subject<'_> {
        let asset = &self.prepared.asset;
        Subject {
            rig: &asset.rig,
            mesh: &asset.mesh,
            triangles: &self.triangles,
            look: &self.look,
            clip: self.shot.clip.map(|c| &asset.clips[c]),
            morph_weights: &asset.mesh.morph_weights,
        }
    }

    /// The clip as the camera sees it, at its frames.
    pub(crate) fn clip(&self) -> anyhow::Result<PlanarClip> {
        self.at(&self.moments_secs)
    }

    /// The clip as the camera sees it at some frames, which may lie between two.
    pub(crate) fn at_frames(&self, frames: &[f64]) -> anyhow::Result<PlanarClip> {
        let first = self.moments_secs.first().copied().unwrap_or_default();
        let secs = |f: &f64| first + f / f64::from(self.options.fps);
        let moments: Vec<f64> = frames.iter().map(secs).collect();
        self.at(&moments)
    }

    /// The clip as the camera sees it at some moments.
    pub(crate) fn at(&self, moments_secs: &[f64]) -> anyhow::Result<PlanarClip> {
        bake(&self.subject(), moments_secs, &self.options).context(self.prepared.loaded.place())
    }

    /// Some of the moments, spread over all of them.
    fn looks(&self) -> Vec<f64> {
        let step = self.moments_secs.len().div_ceil(LOOKS).max(1);
        let last = self.moments_secs.last().copied();
        let some = self.moments_secs.iter().copied().step_by(step);
        some.chain(last).collect()
    }

    fn put_up_camera(&mut self) -> anyhow::Result<()> {
        let looks = self.looks();
        let place = self.prepared.loaded.place();
        let unseen = || anyhow!("{place}: no vertex at a finite place; mend the clip");
        let subject = self.subject();
        let bounds = stage::bounds(&subject, &looks, &Turn::default()).ok_or_else(unseen)?;
        let rig = &self.prepared.asset.rig;
        let mut model = ModelPose::new(rig.len());
        local_to_model(rig, rig.rest_pose(), &mut model);
        let turn = Turn {
            axis: (bounds.middle().x, bounds.middle().z),
            ..self.options.turn
        };
        let azimuth = facing(rig, &model) + self.shot.yaw_deg.to_radians();
        let angles = (azimuth, self.shot.pitch_deg.to_radians());
        let camera = stage::camera(&subject, &looks, &turn, angles, self.shot.viewport);
        self.options.camera = camera.ok_or_else(unseen)?;
        self.options.turn = turn;
        Ok(())
    }

    /// Leaves out what is never seen, then simplifies to the count, once more if much of what is
    /// left turns out to be hidden.
    fn thin_out(&mut self) -> anyhow::Result<()> {
        let Some(count) = self.shot.triangles else {
            return Ok(());
        };
        if self.triangles.len() <= count {
            return Ok(());
        }
        let looks = self.looks();
        let place = || self.prepared.loaded.place();
        let seen = stage::seen(&self.subject(), &looks, &self.options).with_context(place)?;
        let asset = &self.prepared.asset;
        let clip = self.shot.clip;
        let weights = head_weights(self.prepared);
        let mut triangles = decimate(asset, &seen, clip, count, &weights).with_context(place)?;
        let shown = Subject {
            triangles: &triangles,
            ..self.subject()
        };
        let few = bake(&shown, &looks, &self.options).with_context(place)?;
        let drawn = Drawn::seen(&few).with_context(place)?.ever().len();
        let share = drawn as f64 / triangles.len().max(1) as f64;
        if share < 0.9 && share > 0.0 {
            let more = ((count as f64 / share) as usize).min(MAX_TRIANGLES);
            triangles = decimate(asset, &seen, clip, more, &weights).with_context(place)?;
        }
        self.triangles = triangles;
        Ok(())
    }
}

/// The moments of the frames and how many a second there are: as near to the wish as lets the
/// last frame fall on the clip's end.
fn moments(prepared: &Prepared, shot: &Shot) -> anyhow::Result<(Vec<f64>, f32)> {
    let Some(clip) = shot.clip else {
        return Ok((vec![0.0], shot.fps));
    };
    let clip = &prepared.asset.clips[clip];
    if let Some(at) = shot.still_at {
        return Ok((vec![f64::from(at)], shot.fps));
    }
    let length = f64::from(clip.duration_secs()) * f64::from(shot.cycles);
    let steps = (length * f64::from(shot.fps)).round().max(1.0);
    if length <= 0.0 {
        return Ok((vec![0.0], shot.fps));
    }
    if steps >= MAX_FRAMES as f64 {
        let most = MAX_FRAMES;
        let found = steps as usize + 1;
        return Err(PlanarError::TooManyFrames { found, most }).context(prepared.loaded.place());
    }
    let moment = |f: u32| length * f64::from(f) / steps;
    let moments = (0..=steps as u32).map(moment).collect();
    Ok((moments, (steps / length) as f32))
}
