//! A character with clip and camera, and the triangles that are visible.

use super::features::features;
use super::head::{judged_regions, vertex_weights};
use super::judged::{COUNTS, RegionWeights, TriedTriangles, chosen};
use crate::error::{Context, Error, Result};
use crate::facing::facing;
use crate::figure::Figure;
use crate::work::Executor;
use articula_build::decimate;
use articula_core::{Camera, ModelPose, Viewport, local_to_model};
use articula_flat::flatten::{JudgedRegion, SourceFrames, SourceTime};
use articula_flat::planar::{BakeOptions, Lighting, PlanarSubject, Turntable, bake, textured};
use articula_flat::planar::{MAX_FRAMES, MAX_TRIANGLES};
use articula_flat::planar::{PlanarClip, PlanarError};
use articula_flat::{Appearance, Projection};
use glam::Vec3;

/// Name of the first step in progress reports.
const LOOKING: &str = "looking";

/// Name of the step that chooses the triangle count.
const JUDGING: &str = "choosing the triangle count";

/// Maximum number of frames at which bounds and hidden layers are computed.
const LOOKS: usize = 40;

/// Maximum number of frames at which triangle counts are judged.
const JUDGED_FRAMES: usize = 6;

/// Number of triangles of a conversion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TriangleCount {
    /// All of the character, hidden ones included.
    All,
    /// About this many, all if there are fewer.
    About(usize),
    /// The fewest, from this number to four times as many, whose largest local differences are
    /// within [`super::FACE_DELTA_E`] and [`super::REST_DELTA_E`]; the weights of face and hands
    /// are raised first.
    Judged {
        /// The least number.
        least: usize,
    },
}

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
    /// Eye of a camera and what it looks at, in metres in model space, in place of one that frames the figure.
    pub seen_from: Option<(Vec3, Vec3)>,
    /// Size and field of view of the picture.
    pub viewport: Viewport,
    /// Number of triangles.
    pub triangles: TriangleCount,
    /// Whether triangles show their textures where colours of their corners do not show them; for
    /// the player, which alone draws pictures.
    pub shows_textures: bool,
}

/// Least number of triangles that is tried for a picture, where none is asked for.
pub const LEAST_TRIANGLES: usize = 600;

/// The same for the player, whose triangles take fewer bytes.
pub const LEAST_TRIANGLES_OF_PLAYER: usize = 1500;

impl Default for Shot {
    /// The rest pose from the front, in 400 x 400 pixels with a field of view of 25 degrees, at 25 frames per second;
    /// triangles are judged from [`LEAST_TRIANGLES`] on.
    fn default() -> Self {
        Self {
            clip: None,
            still_at: None,
            cycles: 1,
            fps: 25.0,
            yaw_deg: 0.0,
            pitch_deg: 0.0,
            turn_deg: 0.0,
            seen_from: None,
            viewport: Viewport {
                width_px: 400.0,
                height_px: 400.0,
                fov_y_radians: 25.0_f32.to_radians(),
            },
            triangles: TriangleCount::Judged {
                least: LEAST_TRIANGLES,
            },
            shows_textures: false,
        }
    }
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
#[derive(Debug, Clone)]
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
    regions: Vec<JudgedRegion>,
    /// Whether each triangle of the character is visible in some frame; empty until it is known.
    seen: Vec<bool>,
    /// Factors on the weight of an error at features of the face; empty until visible triangles are known.
    features: Vec<f32>,
    tried: Vec<TriedTriangles>,
    count: Option<usize>,
    weights: RegionWeights,
}

impl<'a> FramedCharacter<'a> {
    /// Places the camera, removes triangles that are never visible, and simplifies the rest to the
    /// target number.
    ///
    /// # Errors
    /// An [`Error`] that names the file: no mesh, no vertex with a finite position, or too many
    /// frames.
    pub fn new(figure: &'a Figure, shot: Shot, work: &Executor<'_>) -> Result<Self> {
        let character = figure.opened.character();
        if figure.asset.mesh.triangles.is_empty() {
            let what = "there is no mesh to show; give a file with a mesh or hide fewer meshes";
            return Err(Error::unsuited(what)).context(figure.opened.name());
        }
        let (appearance, _) = Appearance::new(&character.materials, &character.images);
        let (frame_times_secs, fps) = moments(figure, &shot)?;
        let length = frame_times_secs.last().copied().unwrap_or_default();
        let options = BakeOptions {
            camera: Camera::looking_at(Vec3::Z, Vec3::ZERO, shot.viewport),
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
            regions: judged_regions(figure),
            seen: Vec::new(),
            features: Vec::new(),
            tried: Vec::new(),
            count: None,
            weights: RegionWeights::default(),
        };
        work.step(LOOKING, 0, 2)?;
        framed.put_up_camera()?;
        work.step(LOOKING, 1, 2)?;
        framed.look()?;
        work.step(LOOKING, 2, 2)?;
        framed.thin_out(work)?;
        Ok(framed)
    }

    /// Number of triangles of the character.
    pub(super) fn triangles_of_character(&self) -> usize {
        self.figure.asset.mesh.triangles.len()
    }

    /// Width and height of the picture, pixels.
    pub(super) fn size_px(&self) -> (u32, u32) {
        let viewport = self.shot.viewport;
        (viewport.width_px as u32, viewport.height_px as u32)
    }

    /// Returns the same view with about this many triangles, simplified by the same weights.
    ///
    /// # Errors
    /// An [`Error`] that names the file, as [`Self::new`].
    pub fn with_triangles(&self, count: usize) -> Result<Self> {
        let mut framed = Self {
            triangles: self.figure.asset.mesh.triangles.clone(),
            count: Some(count),
            ..self.clone()
        };
        if framed.seen.is_empty() {
            framed.look()?;
        }
        framed.triangles = framed.simplified(count, self.weights)?;
        Ok(framed)
    }

    /// Returns the same view at about this many frames per second.
    ///
    /// # Errors
    /// An [`Error`] that names the file: too many frames.
    pub fn with_rate(&self, fps: f32) -> Result<Self> {
        let shot = Shot { fps, ..self.shot };
        let (frame_times_secs, fps) = moments(self.figure, &shot)?;
        Ok(Self {
            shot,
            frame_times_secs,
            options: BakeOptions {
                fps,
                ..self.options
            },
            ..self.clone()
        })
    }

    /// Returns a still at a time in seconds, seen by the same camera, with the same triangles.
    #[must_use]
    pub fn still(&self, at_secs: f32) -> Self {
        Self {
            shot: Shot {
                still_at: Some(at_secs),
                ..self.shot
            },
            frame_times_secs: vec![f64::from(at_secs)],
            ..self.clone()
        }
    }

    /// Returns the triangle counts and weights that were tried; none for a count that was given.
    pub fn tried(&self) -> &[TriedTriangles] {
        &self.tried
    }

    /// Whether fewer triangles may be taken to keep a byte budget.
    pub(super) fn may_coarsen(&self) -> bool {
        matches!(self.shot.triangles, TriangleCount::Judged { .. })
    }

    /// Returns the target number of triangles; `None` if all are kept.
    pub fn count(&self) -> Option<usize> {
        self.count
    }

    /// Returns the weights of face and hands by which the triangles were simplified.
    pub fn weights(&self) -> RegionWeights {
        self.weights
    }

    /// Creates a framed character from given camera, frame times and triangles, for experiments
    /// that prescribe them.
    pub fn from_parts(figure: &'a Figure, shot: Shot, parts: FramedParts) -> Self {
        let character = figure.opened.character();
        let (appearance, _) = Appearance::new(&character.materials, &character.images);
        Self {
            figure,
            shot,
            appearance,
            options: parts.options,
            triangles: parts.triangles,
            frame_times_secs: parts.frame_times_secs,
            regions: judged_regions(figure),
            seen: Vec::new(),
            features: Vec::new(),
            tried: Vec::new(),
            count: None,
            weights: RegionWeights::default(),
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
        self.figure.opened.name()
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

    /// Region of each vertex of the character.
    pub(super) fn regions(&self) -> &[JudgedRegion] {
        &self.regions
    }

    /// The subject with all triangles of the character.
    fn whole(&self) -> PlanarSubject<'_> {
        PlanarSubject {
            triangles: &self.figure.asset.mesh.triangles,
            ..self.subject()
        }
    }

    /// Pictures of the character itself at fractional frame numbers.
    pub(super) fn source_frames(&self, times: &[SourceTime]) -> Result<SourceFrames> {
        SourceFrames::new(&self.whole(), &self.regions, times, &self.options)
            .context(self.figure.opened.name())
    }

    /// Times of fractional frame numbers.
    pub(super) fn times(&self, frames: &[f64]) -> Vec<SourceTime> {
        let first = self.frame_times_secs.first().copied().unwrap_or_default();
        let time = |frame: &f64| SourceTime {
            frame: *frame,
            secs: first + frame / f64::from(self.options.fps),
        };
        frames.iter().map(time).collect()
    }

    /// Times at which triangle counts are judged, evenly spaced.
    pub(super) fn judged_times(&self) -> Vec<SourceTime> {
        let last = self.frame_times_secs.len().saturating_sub(1);
        let step = last.div_ceil(JUDGED_FRAMES).max(1);
        let frames: Vec<f64> = (0..last.max(1)).step_by(step).map(|f| f as f64).collect();
        self.times(&frames)
    }

    /// Projects the clip at its frames.
    ///
    /// # Errors
    /// An [`Error`] that names the file, if it has more triangles or frames than can be converted,
    /// or shows textures and nothing is visible.
    pub fn clip(&self) -> Result<PlanarClip> {
        self.textured(self.at(&self.frame_times_secs)?, &self.subject())
    }

    /// A baked clip of a subject with the picture of its textures, if it shows them.
    pub(super) fn textured(
        &self,
        clip: PlanarClip,
        subject: &PlanarSubject<'_>,
    ) -> Result<PlanarClip> {
        if !self.shot.shows_textures {
            return Ok(clip);
        }
        textured(clip, subject, &self.options).context(self.figure.opened.name())
    }

    /// Projects the clip at fractional frame numbers.
    ///
    /// # Errors
    /// An [`Error`] that names the file, if it has more triangles or frames than can be converted.
    pub fn at_frames(&self, frames: &[f64]) -> Result<PlanarClip> {
        let moments: Vec<f64> = self.times(frames).iter().map(|t| t.secs).collect();
        self.at(&moments)
    }

    /// Projects the clip at times in seconds.
    ///
    /// # Errors
    /// An [`Error`] that names the file, if it has more triangles or frames than can be converted.
    pub fn at(&self, frame_times_secs: &[f64]) -> Result<PlanarClip> {
        bake(&self.subject(), frame_times_secs, &self.options).context(self.figure.opened.name())
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
        let place = self.figure.opened.name();
        let unseen = || Error::At {
            place: place.to_owned(),
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
        self.options.camera = match self.shot.seen_from {
            Some((eye, target)) => Camera::looking_at(eye, target, self.shot.viewport),
            None => {
                let camera = subject.camera(&looks, &turn, angles, self.shot.viewport);
                camera.ok_or_else(unseen)?
            }
        };
        self.options.turn = turn;
        Ok(())
    }

    /// Finds the triangles that are visible in some frame, and the features among them; not if all are kept.
    fn look(&mut self) -> Result<()> {
        if self.shot.triangles != TriangleCount::All {
            let seen = self.whole().seen(&self.looks(), &self.options);
            self.seen = seen.context(self.figure.opened.name())?;
        }
        self.features = features(&self.whole(), &self.seen, &self.regions);
        Ok(())
    }

    /// Removes triangles that are never visible, and simplifies to the target number.
    fn thin_out(&mut self, work: &Executor<'_>) -> Result<()> {
        match self.shot.triangles {
            TriangleCount::All => {}
            TriangleCount::About(count) => {
                self.count = Some(count);
                if self.triangles.len() > count {
                    self.triangles = self.simplified(count, self.weights)?;
                }
            }
            TriangleCount::Judged { least } => {
                if self.triangles.len() > least {
                    self.judge(least, work)?;
                }
            }
        }
        Ok(())
    }

    /// The visible triangles, simplified to a target number; repeated once with a higher number if
    /// more than a tenth of the result is hidden.
    fn simplified(&self, count: usize, weights: RegionWeights) -> Result<Vec<[u32; 3]>> {
        let place = || self.figure.opened.name();
        let asset = &self.figure.asset;
        let clip = self.shot.clip;
        let weights = vertex_weights(&self.regions, &self.features, weights);
        let triangles = decimate(asset, &self.seen, clip, count, &weights).with_context(place)?;
        let shown = PlanarSubject {
            triangles: &triangles,
            ..self.subject()
        };
        let few = bake(&shown, &self.looks(), &self.options).with_context(place)?;
        let drawn = few.triangles_seen().with_context(place)?;
        let share = drawn as f64 / triangles.len().max(1) as f64;
        let more = ((count as f64 / share) as usize).min(MAX_TRIANGLES);
        // What stays above that number has nothing left that may be removed.
        if share < 0.9 && share > 0.0 && triangles.len() <= more {
            return decimate(asset, &self.seen, clip, more, &weights).with_context(place);
        }
        Ok(triangles)
    }

    /// Simplifies to the fewest triangles whose largest local differences are within the bounds.
    /// The weight of the worst region is raised as long as that helps, then the count.
    fn judge(&mut self, least: usize, work: &Executor<'_>) -> Result<()> {
        let times = self.judged_times();
        let source = self.source_frames(&times)?;
        let mut results = Vec::new();
        let mut weights = self.weights;
        let least = match self.is_mostly_textured(least)? {
            true => least.min(LEAST_TRIANGLES),
            false => least,
        };
        for (step, multiple) in COUNTS.into_iter().enumerate() {
            work.step(JUDGING, step, COUNTS.len())?;
            let count = ((multiple * least as f64).round() as usize).min(MAX_TRIANGLES);
            let mut held = self.attempt(count, weights, &source, &mut results)?;
            while held.excess().1 > 1.0 {
                let Some(raised) = weights.raised(held.excess().0) else {
                    break;
                };
                let next = self.attempt(count, raised, &source, &mut results)?;
                if next.excess().1 >= held.excess().1 {
                    break;
                }
                (weights, held) = (raised, next);
            }
            // Further counts change nothing if all visible triangles are left.
            if held.excess().1 <= 1.0 || held.triangles >= self.seen.iter().filter(|s| **s).count()
            {
                break;
            }
        }
        work.step(JUDGING, COUNTS.len(), COUNTS.len())?;
        self.tried = results.iter().map(|(tried, _)| *tried).collect();
        if let Some(best) = chosen(&self.tried) {
            let (tried, triangles) = results.swap_remove(best);
            self.triangles = triangles;
            self.count = Some(tried.count);
            self.weights = tried.weights;
        }
        Ok(())
    }

    /// Whether pictures cover most of the figure with this many triangles: then fewer are enough, since
    /// they carry no colours.
    fn is_mostly_textured(&self, count: usize) -> Result<bool> {
        let materials = &self.appearance.materials;
        if !self.shot.shows_textures || !materials.iter().any(|m| m.base_color_image.is_some()) {
            return Ok(false);
        }
        let triangles = self.simplified(count, self.weights)?;
        let shown = PlanarSubject {
            triangles: &triangles,
            ..self.subject()
        };
        let times: Vec<f64> = self.judged_times().iter().map(|t| t.secs).collect();
        let clip = bake(&shown, &times, &self.options).context(self.figure.opened.name())?;
        Ok(self.textured(clip, &shown)?.textured_share() > 0.5)
    }

    /// Simplifies and compares with the character itself; adds the result to `results`.
    fn attempt(
        &self,
        count: usize,
        weights: RegionWeights,
        source: &SourceFrames,
        results: &mut Vec<(TriedTriangles, Vec<[u32; 3]>)>,
    ) -> Result<TriedTriangles> {
        let place = || self.figure.opened.name();
        let triangles = self.simplified(count, weights)?;
        let shown = PlanarSubject {
            triangles: &triangles,
            ..self.subject()
        };
        let times: Vec<f64> = self.judged_times().iter().map(|t| t.secs).collect();
        let clip = bake(&shown, &times, &self.options).with_context(place)?;
        let clip = self.textured(clip, &shown)?;
        let tried = TriedTriangles {
            count,
            triangles: triangles.len(),
            weights,
            local: source.judge(&clip).with_context(place)?,
        };
        results.push((tried, triangles));
        Ok(tried)
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
        return Err(PlanarError::TooManyFrames { found, most }).context(figure.opened.name());
    }
    let moment = |f: u32| length * f64::from(f) / steps;
    let moments = (0..=steps as u32).map(moment).collect();
    Ok((moments, (steps / length) as f32))
}
