//! One character, one motion, one camera: what is seen of it, at the triangles that were asked
//! for.

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

/// What the first step is called.
const LOOKING: &str = "looking";

/// Moments at which bounds and hidden layers are looked for.
const LOOKS: usize = 40;

/// What is to be shown, and from where.
#[derive(Debug, Clone, Copy)]
pub struct Shot {
    /// Index of the clip; the rest pose without one.
    pub clip: Option<usize>,
    /// The one moment that is shown, seconds; all of the clip without.
    pub still_at: Option<f32>,
    /// How often the clip is played.
    pub cycles: u32,
    /// Frames a second that are wished for.
    pub fps: f32,
    /// Where the camera stands about the figure's front, degrees to its left.
    pub yaw_deg: f32,
    /// How high it stands, degrees.
    pub pitch_deg: f32,
    /// How far the figure turns in all.
    pub turn_deg: f32,
    /// Size and opening of the picture.
    pub viewport: Viewport,
    /// Triangles that the figure should have; all of them without.
    pub triangles: Option<usize>,
}

/// What [`FramedCharacter::new`] finds by itself.
#[derive(Debug, Clone)]
pub struct FramedParts {
    /// Camera, light, rate and turn.
    pub options: BakeOptions,
    /// The triangles that are shown, over the character's vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Moments of the frames, seconds of the clip.
    pub moments_secs: Vec<f64>,
}

/// A character before a camera.
#[derive(Debug)]
pub struct FramedCharacter<'a> {
    figure: &'a Figure,
    shot: Shot,
    look: Appearance,
    /// Camera, light, rate and turn.
    pub options: BakeOptions,
    /// The triangles that are shown, over the character's vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Moments of the frames.
    pub moments_secs: Vec<f64>,
}

impl<'a> FramedCharacter<'a> {
    /// Puts up the camera, leaves out what it never sees, and makes the rest as coarse as asked.
    ///
    /// # Errors
    /// An [`Error`] that names the file: no mesh, no vertex at a finite place, too many frames.
    pub fn new(figure: &'a Figure, shot: Shot, work: &Executor<'_>) -> Result<Self> {
        let character = &figure.opened.character;
        if figure.asset.mesh.triangles.is_empty() {
            let what = "no mesh to show; give a file with one, or hide fewer of them";
            return Err(Error::unsuited(what)).context(&figure.opened.name);
        }
        let (look, _) = Appearance::new(&character.materials, &character.images);
        let (moments_secs, fps) = moments(figure, &shot)?;
        let length = moments_secs.last().copied().unwrap_or_default();
        let options = BakeOptions {
            camera: articula_core::Camera::looking_at(
                glam::Vec3::Z,
                glam::Vec3::ZERO,
                shot.viewport,
            ),
            projection: Projection::Perspective,
            lamp: Lighting::default(),
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
            look,
            options,
            triangles: figure.asset.mesh.triangles.clone(),
            moments_secs,
        };
        work.step(LOOKING, 0, 2)?;
        framed.put_up_camera()?;
        work.step(LOOKING, 1, 2)?;
        framed.thin_out()?;
        work.step(LOOKING, 2, 2)?;
        Ok(framed)
    }

    /// A figure at some moments before a camera of the caller's, with triangles of the caller's
    /// choice: for experiments whose protocol says both.
    pub fn from_parts(figure: &'a Figure, shot: Shot, parts: FramedParts) -> Self {
        let character = &figure.opened.character;
        let (look, _) = Appearance::new(&character.materials, &character.images);
        Self {
            figure,
            shot,
            look,
            options: parts.options,
            triangles: parts.triangles,
            moments_secs: parts.moments_secs,
        }
    }

    /// The character.
    pub(super) fn figure(&self) -> &'a Figure {
        self.figure
    }

    /// What is shown of it, and from where.
    pub(super) fn shot(&self) -> &Shot {
        &self.shot
    }

    /// What errors call the file.
    pub(super) fn name(&self) -> &'a str {
        &self.figure.opened.name
    }

    /// The subject as it is shown.
    pub fn subject(&self) -> PlanarSubject<'_> {
        let asset = &self.figure.asset;
        PlanarSubject {
            rig: &asset.rig,
            mesh: &asset.mesh,
            triangles: &self.triangles,
            look: &self.look,
            clip: self.shot.clip.map(|c| &asset.clips[c]),
            morph_weights: &asset.mesh.morph_weights,
        }
    }

    /// The clip as the camera sees it, at its frames.
    ///
    /// # Errors
    /// An [`Error`] that names the file, if it has more triangles or frames than can be converted.
    pub fn clip(&self) -> Result<PlanarClip> {
        self.at(&self.moments_secs)
    }

    /// The clip as the camera sees it at some frames, which may lie between two.
    ///
    /// # Errors
    /// An [`Error`] that names the file, if it has more triangles or frames than can be converted.
    pub fn at_frames(&self, frames: &[f64]) -> Result<PlanarClip> {
        let first = self.moments_secs.first().copied().unwrap_or_default();
        let secs = |f: &f64| first + f / f64::from(self.options.fps);
        let moments: Vec<f64> = frames.iter().map(secs).collect();
        self.at(&moments)
    }

    /// The clip as the camera sees it at some moments.
    ///
    /// # Errors
    /// An [`Error`] that names the file, if it has more triangles or frames than can be converted.
    pub fn at(&self, moments_secs: &[f64]) -> Result<PlanarClip> {
        bake(&self.subject(), moments_secs, &self.options).context(&self.figure.opened.name)
    }

    /// Some of the moments, spread over all of them.
    fn looks(&self) -> Vec<f64> {
        let step = self.moments_secs.len().div_ceil(LOOKS).max(1);
        let last = self.moments_secs.last().copied();
        let some = self.moments_secs.iter().copied().step_by(step);
        some.chain(last).collect()
    }

    fn put_up_camera(&mut self) -> Result<()> {
        let looks = self.looks();
        let place = &self.figure.opened.name;
        let unseen = || Error::At {
            place: place.clone(),
            cause: Box::new(Error::unsuited(
                "no vertex at a finite place; mend the clip",
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

    /// Leaves out what is never seen, then simplifies to the count, once more if much of what is
    /// left turns out to be hidden.
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

/// The moments of the frames and how many a second there are: as near to the wish as lets the
/// last frame fall on the clip's end.
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
