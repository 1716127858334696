//! The set-up of an evaluation, the reference motion of a clip, and the statistics of one run.

use super::baselines::postures::PostureSpace;
use super::baselines::thesis::{ThesisMetricOptions, error_matrix};
use super::method::{Method, MethodOptions, Playback};
use super::skin_sample::SkinSample;
use super::statistics::{FrameErrors, SkinErrors, across};
use crate::character::Asset;
use crate::motion_error::bounds::moving_joints;
use crate::motion_error::contacts::contacts;
use crate::motion_error::hull::JointHull;
use crate::motion_error::joint_lever::JointLever;
use crate::motion_error::levers::{hulls, levers};
use crate::motion_error::tables::key_table;
use articula_core::Libm;
use articula_core::playback::{ErrorMatrix, StoredKeys};
use articula_core::{
    Clip, Contact, JointSet, KeyMode, KeyTable, LocalPose, ModelPose, Viewport, Wrap,
    local_to_model, percentile, rotation_vector, sample, sample_morphs,
};
use glam::{Quat, Vec3};
use std::cell::OnceCell;
use std::sync::Arc;

/// Cameras of an evaluation and the sampled part of the skin.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluationSetup {
    /// Picture size in pixels and field of view.
    pub viewport: Viewport,
    /// Azimuths of the level cameras, degrees from the front.
    pub azimuths_deg: Vec<f32>,
    /// Number of sampled vertices.
    pub points: usize,
    /// Seed of the vertex sample.
    pub seed: u64,
}

impl Default for EvaluationSetup {
    /// 1280 x 720 at 45 degrees; azimuths of 0, 45 and 90 degrees; 700 vertices.
    fn default() -> Self {
        Self {
            viewport: Viewport::default(),
            azimuths_deg: vec![0.0, 45.0, 90.0],
            points: 700,
            seed: 1,
        }
    }
}

/// A clip prepared for evaluation under any method; its reference motion is computed once.
pub struct ClipEvaluator<'a> {
    /// The character that plays the clip.
    pub asset: &'a Asset,
    /// The clip at the rate of its keys: frames inserted between them would count as saved.
    pub clip: Clip,
    /// Cameras and sampled skin.
    pub setup: EvaluationSetup,
    /// Options of the methods.
    pub options: MethodOptions,
    /// Joints that move, without the root.
    pub moving: JointSet,
    /// Levers of all joints.
    pub levers: Vec<JointLever>,
    /// Contacts of the feet.
    pub(crate) contacts: Vec<Contact>,
    /// Unreduced local poses of all frames.
    pub truth: Vec<LocalPose>,
    /// Vertices of the face of a head without a head joint.
    pub(super) face: Vec<u32>,
    sample: SkinSample<'static>,
    true_points: Vec<Vec<Vec3>>,
    matrix: OnceCell<Arc<ErrorMatrix>>,
    key_table: OnceCell<Arc<KeyTable>>,
    hulls: OnceCell<Vec<JointHull>>,
    postures: OnceCell<PostureSpace>,
}

/// Statistics of a method at one parameter. Under weak perspective they are the same from every
/// distance, except for the scale of the error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodRun {
    /// Parameter of the method.
    pub parameter: f32,
    /// Saved joint updates as a share of moving joints times frames after the first.
    pub joint_update_gain: f32,
    /// Share of frames after the first at which no joint was updated.
    pub evaluations_saved: f32,
    /// Mean number of joints sampled per frame.
    pub joints_sampled: f32,
    /// Mean number of joints per frame whose model matrix changed, relative to the root.
    pub fk_joints: f32,
    /// Displacement of the skin, metres.
    pub error: FrameErrors,
    /// Mean distance in metres by which feet slide during contacts because joints are held.
    pub foot_slide_metres: f32,
}

/// A [`MethodRun`] seen from a given distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DistanceRow {
    /// Distance of the camera to the root, metres.
    pub distance_m: f32,
    /// Statistics of the run, with its parameter.
    pub trial: MethodRun,
    /// Error of the run, pixels.
    pub error_px: FrameErrors,
    /// Error of the run over the whole skin, pixels.
    pub skin_px: SkinErrors,
}

impl<'a> ClipEvaluator<'a> {
    /// Computes the reference motion of a clip.
    pub fn new(
        asset: &'a Asset,
        clip: &Clip,
        setup: EvaluationSetup,
        options: MethodOptions,
    ) -> Self {
        let clip = clip.at_key_rate();
        let mut pose = asset.rig.rest_pose().clone();
        let truth: Vec<LocalPose> = (0..clip.frames())
            .map(|i| {
                let secs = i as f64 / f64::from(clip.rate_hz());
                sample(&clip, secs, Wrap::Clamp, &asset.rig.all(), &mut pose);
                pose.clone()
            })
            .collect();
        let sample = SkinSample::draw(asset, setup.points, setup.seed);
        let mut made = Self {
            moving: moving_joints(asset, &clip),
            levers: levers(&asset.rig, &asset.mesh),
            contacts: contacts(asset, &clip, false),
            true_points: Vec::new(),
            face: Vec::new(),
            truth,
            sample,
            matrix: OnceCell::new(),
            key_table: OnceCell::new(),
            hulls: OnceCell::new(),
            postures: OnceCell::new(),
            asset,
            clip,
            setup,
            options,
        };
        let frames = made.truth.iter().enumerate();
        made.true_points = frames
            .map(|(f, pose)| made.points_at(pose, made.secs(f)))
            .collect();
        made
    }

    /// Time of a frame, seconds.
    fn secs(&self, frame: usize) -> f64 {
        frame as f64 / f64::from(self.clip.rate_hz())
    }

    /// Weights of the morph targets at a time; `None` if the clip moves none.
    fn morphs(&self, secs: f64) -> Option<Vec<f32>> {
        if self.clip.tracks().morphs.is_empty() {
            return None;
        }
        let mut weights = self.asset.mesh.morph_weights.clone();
        sample_morphs(&self.clip, secs, Wrap::Clamp, &mut weights);
        Some(weights)
    }

    pub(super) fn sample(&self) -> &SkinSample<'static> {
        &self.sample
    }

    /// Positions of the sampled skin under a pose, with the morph targets of a time.
    pub(super) fn points_at(&self, pose: &LocalPose, secs: f64) -> Vec<Vec3> {
        self.posed(&self.sample, pose, secs)
    }

    /// Positions of a skin under a pose, with the morph targets of a time.
    pub(super) fn posed(&self, skin: &SkinSample<'_>, pose: &LocalPose, secs: f64) -> Vec<Vec3> {
        let morphs = self.morphs(secs);
        skin.posed(&self.asset.rig, pose, morphs.as_deref())
    }

    /// Offsets from the true to the shown positions of a skin at a frame.
    pub(super) fn offsets(
        &self,
        skin: &SkinSample<'_>,
        playback: &Playback,
        frame: usize,
    ) -> Vec<Vec3> {
        let mut pose = self.truth[frame].clone();
        pose.rotations.copy_from_slice(&playback.shown[frame]);
        let shown = self.posed(skin, &pose, self.secs(frame));
        let truth = self.posed(skin, &self.truth[frame], self.secs(frame));
        shown.iter().zip(&truth).map(|(s, t)| *s - *t).collect()
    }

    /// Each playback with the views in which it is measured: a playback made for one view in that
    /// view, a common one in all.
    pub(super) fn seen<'p>(
        &self,
        playbacks: &'p [Playback],
    ) -> impl Iterator<Item = (&'p Playback, Vec<Vec3>)> {
        let views: Vec<Vec3> = self.view_directions().collect();
        let is_each = playbacks.len() == views.len() && views.len() > 1;
        playbacks.iter().enumerate().map(move |(p, playback)| {
            let seen = if is_each {
                vec![views[p]]
            } else {
                views.clone()
            };
            (playback, seen)
        })
    }

    /// Unit directions from the figure to each camera.
    pub(crate) fn view_directions(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.setup.azimuths_deg.iter().map(|a| {
            let (sin, cos) = a.to_radians().libm_sin_cos();
            Vec3::new(sin, 0.0, cos)
        })
    }

    /// True positions of the sampled skin at all frames, without the root's travel over the ground.
    pub(super) fn places_around_root(&self) -> Vec<Vec<Vec3>> {
        let mut model = ModelPose::new(self.asset.rig.len());
        let frames = self.truth.iter().zip(&self.true_points);
        frames
            .map(|(pose, places)| {
                local_to_model(&self.asset.rig, pose, &mut model);
                let way = model.position(0) * Vec3::new(1.0, 0.0, 1.0);
                places.iter().map(|p| *p - way).collect()
            })
            .collect()
    }

    /// Converts a run to a camera distance in metres.
    pub fn row(&self, (trial, skin): (MethodRun, SkinErrors), distance_m: f32) -> DistanceRow {
        let ppm = self.setup.viewport.pixels_per_metre(distance_m);
        DistanceRow {
            distance_m,
            trial,
            error_px: trial.error.scaled(ppm),
            skin_px: skin.scaled(ppm),
        }
    }

    /// Returns the default parameter of a method at a distance, without calibration: a tolerance of
    /// one pixel for `skin-px`, Ahn's method and principal components, the threshold of [`MethodOptions`] for the thesis,
    /// every second frame for skipping, level 0 for fixed levels.
    pub fn default_parameter(&self, method: &Method, distance_m: f32) -> f32 {
        let pixel_metres = 1.0 / self.setup.viewport.pixels_per_metre(distance_m);
        match method {
            // Of principal components the angle that moves a lever of one metre by a pixel.
            Method::SkinPx(_) | Method::Ahn | Method::PrincipalComponents => pixel_metres,
            Method::Thesis => self.options.threshold.at(distance_m),
            Method::SkipHold | Method::SkipLerp => 2.0,
            Method::Loa(_) => 0.0,
        }
    }

    pub(super) fn thesis_matrix(&self) -> &Arc<ErrorMatrix> {
        let made = || error_matrix(self.asset, &self.clip, &self.moving, &self.options.thesis);
        self.matrix.get_or_init(|| made().into())
    }

    /// Gives the stored error matrix of the thesis, made with default options. It is ignored under
    /// other options, or if it has other frames than the evaluated clip.
    #[must_use]
    pub fn with_error_matrix(self, matrix: ErrorMatrix) -> Self {
        let is_own =
            (matrix.joints(), matrix.frames()) == (self.asset.rig.len(), self.clip.frames());
        if is_own && self.options.thesis == ThesisMetricOptions::default() {
            // A cell that is already set keeps its matrix.
            let _ = self.matrix.set(matrix.into());
        }
        self
    }

    /// Gives the vertices of the face, which are reported apart if no vertex belongs to a head joint:
    /// a head alone has none. Vertices beyond the mesh are ignored.
    #[must_use]
    pub fn with_face(mut self, mut vertices: Vec<u32>) -> Self {
        vertices.retain(|v| (*v as usize) < self.asset.mesh.len());
        self.face = vertices;
        self
    }

    /// Uses contacts that were found before instead of those that it found.
    #[must_use]
    pub fn with_contacts(self, contacts: Vec<Contact>) -> Self {
        let frames = self.clip.frames();
        if contacts.iter().any(|c| c.frames.end > frames) {
            return self;
        }
        Self { contacts, ..self }
    }

    /// Gives the stored key table of the clip, played by the variant `Tables`. One that was made
    /// for other frames than those of the evaluated clip is ignored.
    #[must_use]
    pub fn with_key_table(self, table: KeyTable) -> Self {
        let table = Arc::new(table);
        if StoredKeys::new(&self.clip, table.clone()).is_ok() {
            // A cell that is already set keeps its table.
            let _ = self.key_table.set(table);
        }
        self
    }

    /// The given key table, or that which preparation would store.
    pub(super) fn key_table(&self) -> &Arc<KeyTable> {
        let made = || key_table(self.asset, &self.clip, &self.levers, KeyMode::Hold);
        self.key_table.get_or_init(|| made().into())
    }

    /// Hulls of the skin of all joints.
    pub(super) fn hulls(&self) -> &[JointHull] {
        let made = || hulls(&self.asset.rig, &self.asset.mesh);
        self.hulls.get_or_init(made)
    }

    /// The postures of all frames by their principal components: rotation vectors of the moving
    /// joints, from the middle of each joint's range.
    pub(super) fn postures(&self) -> &PostureSpace {
        self.postures.get_or_init(|| {
            let middle = self.key_pose();
            let posture = |pose: &LocalPose| -> Vec<f64> {
                let joints = self.moving.iter();
                let vectors =
                    joints.map(|j| rotation_vector(middle.rotations[j], pose.rotations[j]));
                vectors.flat_map(|v| v.as_dvec3().to_array()).collect()
            };
            let postures: Vec<Vec<f64>> = self.truth.iter().map(posture).collect();
            PostureSpace::of(&postures)
        })
    }

    pub(super) fn trial(&self, parameter: f32, playbacks: &[Playback]) -> MethodRun {
        let count = playbacks.len().max(1) as f32;
        let frames = (self.truth.len() - 1).max(1) as f32;
        let mean = |of: &dyn Fn(&Playback) -> usize| {
            playbacks.iter().map(|p| of(p) as f32).sum::<f32>() / count / frames
        };
        let sampled = mean(&|p| p.updated.iter().map(JointSet::len).sum());
        let moving = self.moving.len() as f32;
        let free = |p: &Playback| p.updated.iter().skip(1).filter(|u| u.is_empty()).count();
        MethodRun {
            parameter,
            joint_update_gain: if moving > 0.0 {
                1.0 - sampled / moving
            } else {
                1.0
            },
            evaluations_saved: mean(&free),
            joints_sampled: sampled,
            fk_joints: mean(&|p| p.updated.iter().map(|u| self.dirty(u)).sum()),
            error: self.error(playbacks),
            foot_slide_metres: playbacks.iter().map(|p| self.foot_slide(p)).sum::<f32>() / count,
        }
    }

    /// Displacement over the ground of the shown joint relative to the true one since the contact
    /// began; the mean over all frames of all contacts.
    fn foot_slide(&self, playback: &Playback) -> f32 {
        let mut pose = self.truth[0].clone();
        let mut model = ModelPose::new(self.asset.rig.len());
        let mut place = |frame: usize, joint: usize, rotations: &[Quat]| {
            pose.copy_from(&self.truth[frame]);
            pose.rotations.copy_from_slice(rotations);
            local_to_model(&self.asset.rig, &pose, &mut model);
            model.position(joint) * Vec3::new(1.0, 0.0, 1.0)
        };
        let (mut sum, mut frames) = (0.0, 0);
        for contact in &self.contacts {
            let mut offset = |frame: usize| {
                let shown = place(frame, contact.joint, &playback.shown[frame]);
                shown - place(frame, contact.joint, &self.truth[frame].rotations)
            };
            let start = offset(contact.frames.start);
            for frame in contact.frames.clone().skip(1) {
                sum += (offset(frame) - start).length();
                frames += 1;
            }
        }
        if frames > 0 { sum / frames as f32 } else { 0.0 }
    }

    /// Joints at or below an updated one.
    fn dirty(&self, updated: &JointSet) -> usize {
        let rig = &self.asset.rig;
        let mut dirty = *updated;
        for joint in 0..rig.len() {
            if rig.parent(joint).is_some_and(|p| dirty.contains(p)) {
                dirty.insert(joint);
            }
        }
        dirty.len()
    }

    fn error(&self, playbacks: &[Playback]) -> FrameErrors {
        let mut worst = FrameErrors::default();
        for (playback, views) in self.seen(playbacks) {
            for frames in &mut self.displacements(playback, &views) {
                worst.add(frames);
            }
        }
        worst
    }

    /// For each view and frame, the 95th percentile over the sampled vertices of the projected
    /// distance between shown and true positions.
    fn displacements(&self, playback: &Playback, views: &[Vec3]) -> Vec<Vec<f32>> {
        let mut pose = self.truth[0].clone();
        let mut out = vec![Vec::with_capacity(self.truth.len()); views.len()];
        for (f, truth) in self.truth.iter().enumerate() {
            pose.copy_from(truth);
            pose.rotations.copy_from_slice(&playback.shown[f]);
            let shown = self.points_at(&pose, self.secs(f));
            for (frames, view) in out.iter_mut().zip(views) {
                let offsets = shown.iter().zip(&self.true_points[f]).map(|(s, t)| *s - *t);
                let mut lengths: Vec<f32> = offsets.map(|d| across(d, *view)).collect();
                frames.push(percentile(&mut lengths, 0.95));
            }
        }
        out
    }
}
