//! A character with clip and camera, and the triangles that are visible.

use super::head::head_weights;
use crate::error::{Context, Error, Result};
use crate::facing::facing;
use crate::figure::Figure;
use crate::work::Executor;
use articula_build::decimate;
use articula_core::{ModelPose, Viewport, local_to_model};
use articula_flat::planar::{BakeOptions, Lighting, PlanarSubject, Turntable, bake};
use articula_flat::planar::{MAX_FRAMES, MAX_TRIANGLES};
use articula_flat::planar::{PlanarClip, PlanarError};
use articula_flat::{Appearance, Projection};

/// Name of the first step in progress reports.
const LOOKING: &str = "looking";

/// Maximum number of frames at which bounds and hidden layers are computed.
const LOOKS: usize = 40;

/// Clip, camera and level of detail of a 2D rendering.
#[derive(Debug, Clone, Copy)]
pub struct Shot {
    /// Index of the clip; `None` for the rest pose.
    pub clip: Option<usize>,
    /// Time of a single still picture in seconds; `None` for the whole clip.
    pub still_at: Option<f32>,
    /// Number of repetitions of the clip.
    pub cycles: u32,
    /// Desired frame rate, in frames per second.
    pub fps: f32,
    /// Azimuth of the camera from the front of the figure, in degrees towards its left.
    pub yaw_deg: f32,
    /// Elevation of the camera, in degrees.
    pub pitch_deg: f32,
    /// Angle by which the figure turns over the whole duration, in degrees.
    pub turn_deg: f32,
    /// Size and field of view of the picture.
    pub viewport: Viewport,
    /// Target number of triangles; `None` keeps all.
    pub triangles: Option<usize>,
}

/// Parts of a [`FramedCharacter`] that [`FramedCharacter::new`] computes.
#[derive(Debug, Clone)]
pub struct FramedParts {
    /// Camera, lighting, frame rate and turn.
    pub options: BakeOptions,
    /// Shown triangles, as indices of the character's vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Times of the frames, in seconds of the clip.
    pub frame_times_secs: Vec<f64>,
}

/// A character framed by a camera, ready for flattening.
#[derive(Debug)]
pub struct FramedCharacter<'a> {
    figure: &'a Figure,
    shot: Shot,
    appearance: Appearance,
    /// Camera, lighting, frame rate and turn.
    pub options: BakeOptions,
    /// Shown triangles, as indices of the character's vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Times of the frames, in seconds of the clip.
    pub frame_times_secs: Vec<f64>,
}

impl<'a> FramedCharacter<'a> {
    /// Places the camera, removes triangles that are never visible, and simplifies the rest to the
    /// target number.
    ///
    /// # Errors
    /// An [`Error`] that names the file: no mesh, no vertex with a finite position, or too many
    /// frames.
    pub fn new(figure: &'a Figure, shot: Shot, work: &Executor<'_>) -> Result<Self> {
        let character = &figure.opened.character;
        if figure.asset.mesh.triangles.is_empty() {
            let what = "there is no mesh to show; give a file with a mesh or hide fewer meshes";
            return Err(Error::unsuited(what)).context(&figure.opened.name);
        }
        let (appearance, _) = Appearance::new(&character.materials, &character.images);
        let (frame_times_secs, fps) = moments(figure, &shot)?;
        let length = frame_times_secs.last().copied().unwrap_or_default();
        let options = BakeOptions {
            camera: articula_core::Camera::looking_at(
                glam::Vec3::Z,
                glam::Vec3::ZERO,
                shot.viewport,
            ),
            projection: Projection::Perspective,
            lighting: Lighting::default(),
            fps,
            turn: Turntable {
                axis: (0.0, 0.0),
                radians_per_sec: if length > 0.0 {
                    shot.turn_deg.to_radians() / length as f32
                } else {
                    0.0
                },
            },
        };
        let mut framed = Self {
            figure,
            shot,
            appearance,
            options,
            triangles: figure.asset.mesh.triangles.clone(),
            frame_times_secs,
        };
        work.step(LOOKING, 0, 2)?;
        framed.put_up_camera()?;
        work.step(LOOKING, 1, 2)?;
        framed.thin_out()?;
        work.step(LOOKING, 2, 2)?;
        Ok(framed)
    }

    /// Creates a framed character from given camera, frame times and triangles, for experiments
    /// that prescribe them.
    pub fn from_parts(figure: &'a Figure, shot: Shot, parts: FramedParts) -> Self {
        let character = &figure.opened.character;
        let (appearance, _) = Appearance::new(&character.materials, &character.images);
        Self {
            figure,
            shot,
            appearance,
            options: parts.options,
            triangles: parts.triangles,
            frame_times_secs: parts.frame_times_secs,
        }
    }

    /// Returns the character.
    pub(super) fn figure(&self) -> &'a Figure {
        self.figure
    }

    /// Returns clip, camera and level of detail.
    pub(super) fn shot(&self) -> &Shot {
        &self.shot
    }

    /// Returns the name of the file in errors.
    pub(super) fn name(&self) -> &'a str {
        &self.figure.opened.name
    }

    /// Returns the subject in the form that the baking functions take.
    pub fn subject(&self) -> PlanarSubject<'_> {
        let asset = &self.figure.asset;
        PlanarSubject {
            rig: &asset.rig,
            mesh: &asset.mesh,
            triangles: &self.triangles,
            appearance: &self.appearance,
            clip: self.shot.clip.map(|c| &asset.clips[c]),
            morph_weights: &asset.mesh.morph_weights,
        }
    }

    /// Projects the clip at its frames.
    ///
    /// # Errors
    /// An [`Error`] that names the file, if it has more triangles or frames than can be converted.
    pub fn clip(&self) -> Result<PlanarClip> {
        self.at(&self.frame_times_secs)
    }

    /// Projects the clip at fractional frame numbers.
    ///
    /// # Errors
    /// An [`Error`] that names the file, if it has more triangles or frames than can be converted.
    pub fn at_frames(&self, frames: &[f64]) -> Result<PlanarClip> {
        let first = self.frame_times_secs.first().copied().unwrap_or_default();
        let secs = |f: &f64| first + f / f64::from(self.options.fps);
        let moments: Vec<f64> = frames.iter().map(secs).collect();
        self.at(&moments)
    }

    /// Projects the clip at times in seconds.
    ///
    /// # Errors
    /// An [`Error`] that names the file, if it has more triangles or frames than can be converted.
    pub fn at(&self, frame_times_secs: &[f64]) -> Result<PlanarClip> {
        bake(&self.subject(), frame_times_secs, &self.options).context(&self.figure.opened.name)
    }

    /// A subset of the frame times, evenly spaced, that includes the last.
    fn looks(&self) -> Vec<f64> {
        let step = self.frame_times_secs.len().div_ceil(LOOKS).max(1);
        let last = self.frame_times_secs.last().copied();
        let some = self.frame_times_secs.iter().copied().step_by(step);
        some.chain(last).collect()
    }

    fn put_up_camera(&mut self) -> Result<()> {
        let looks = self.looks();
        let place = &self.figure.opened.name;
        let unseen = || Error::At {
            place: place.clone(),
            cause: Box::new(Error::unsuited(
                "no vertex has a finite position; check the clip and the skin weights",
            )),
        };
        let subject = self.subject();
        let bounds = subject
            .bounds(&looks, &Turntable::default())
            .ok_or_else(unseen)?;
        let rig = &self.figure.asset.rig;
        let mut model = ModelPose::new(rig.len());
        local_to_model(rig, rig.rest_pose(), &mut model);
        let turn = Turntable {
            axis: (bounds.middle().x, bounds.middle().z),
            ..self.options.turn
        };
        let azimuth = facing(rig, &model) + self.shot.yaw_deg.to_radians();
        let angles = (azimuth, self.shot.pitch_deg.to_radians());
        let camera = subject.camera(&looks, &turn, angles, self.shot.viewport);
        self.options.camera = camera.ok_or_else(unseen)?;
        self.options.turn = turn;
        Ok(())
    }

    /// Removes triangles that are never visible, then simplifies to the target number; repeated
    /// once with a higher number if more than a tenth of the result is hidden.
    fn thin_out(&mut self) -> Result<()> {
        let Some(count) = self.shot.triangles else {
            return Ok(());
        };
        if self.triangles.len() <= count {
            return Ok(());
        }
        let looks = self.looks();
        let place = || &self.figure.opened.name;
        let seen = self
            .subject()
            .seen(&looks, &self.options)
            .with_context(place)?;
        let asset = &self.figure.asset;
        let clip = self.shot.clip;
        let weights = head_weights(self.figure);
        let mut triangles = decimate(asset, &seen, clip, count, &weights).with_context(place)?;
        let shown = PlanarSubject {
            triangles: &triangles,
            ..self.subject()
        };
        let few = bake(&shown, &looks, &self.options).with_context(place)?;
        let drawn = few.triangles_seen().with_context(place)?;
        let share = drawn as f64 / triangles.len().max(1) as f64;
        if share < 0.9 && share > 0.0 {
            let more = ((count as f64 / share) as usize).min(MAX_TRIANGLES);
            triangles = decimate(asset, &seen, clip, more, &weights).with_context(place)?;
        }
        self.triangles = triangles;
        Ok(())
    }
}

/// Frame times and frame rate: the rate nearest to the desired one for which the last frame falls
/// on the end of the clip.
fn moments(figure: &Figure, shot: &Shot) -> Result<(Vec<f64>, f32)> {
    let Some(clip) = shot.clip else {
        return Ok((vec![0.0], shot.fps));
    };
    let clip = &figure.asset.clips[clip];
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
        return Err(PlanarError::TooManyFrames { found, most }).context(&figure.opened.name);
    }
    let moment = |f: u32| length * f64::from(f) / steps;
    let moments = (0..=steps as u32).map(moment).collect();
    Ok((moments, (steps / length) as f32))
}
