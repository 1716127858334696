//! Error of a FAP clip on a head at levels of articulation, over distance.

use super::frames::face_frames;
use super::levels::names;
use super::rig::FaceRig;
use super::turns::{Turn, turns};
use crate::error::{Context, Error, Result};
use crate::facing::facing;
use crate::figure::Figure;
use crate::inner_lips::with_inner_lips;
use crate::work::Executor;
use articula_build::face::{FaceBridge, FaceDetail, FaceFields, FaceFrames};
use articula_core::LibmQuat;
use articula_core::face_levels::{FaceLevel, FaceLevels, FapRoles};
use articula_core::fap_table::{FAP_COUNT, LOW_FAPS};
use articula_core::{PosedMesh, Viewport};
use articula_formats::mpeg4::fap::FapClip;
use glam::{Quat, Vec3};
use serde::Serialize;
use std::collections::BTreeMap;

/// Distances and tolerance of a [`FaceDetailReport`].
#[derive(Debug, Clone, PartialEq)]
pub struct FaceDetailOptions {
    /// Distances from the camera in metres.
    pub distances_m: Vec<f32>,
    /// Tolerated error in pixels.
    pub tolerance_px: f32,
    /// Picture in whose pixels errors are measured.
    pub viewport: Viewport,
}

impl Default for FaceDetailOptions {
    /// Five distances, 1 px, 1280 x 720 at 45 degrees.
    fn default() -> Self {
        Self {
            distances_m: FACE_DISTANCES_M.to_vec(),
            tolerance_px: 1.0,
            viewport: Viewport::default(),
        }
    }
}

/// Default distances of faces in metres.
pub const FACE_DISTANCES_M: [f32; 5] = [1.0, 2.0, 3.5, 5.65, 9.05];

/// Parameters and errors of a FAP clip on a head at levels of articulation.
///
/// Parameters are counted where they are low-level and move in the clip. Errors are the greatest
/// over all frames and vertices of the distance in 3D from the place with all parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceDetailReport {
    /// Name of the FAP file.
    pub file: String,
    /// Name of the head's file.
    pub head: String,
    /// Number of frames.
    pub frames: usize,
    /// Frames per second.
    pub rate_hz: f32,
    /// Number of controls of the head whose effect is known.
    pub controls: usize,
    /// Number of vertices, all of which are measured.
    pub vertices: usize,
    /// The four levels, finest first.
    pub levels: Vec<FaceLevelError>,
    /// The parameters that move, with their levers.
    pub parameters: Vec<FapLever>,
    /// One entry for each distance, nearest first.
    pub rows: Vec<FaceDetailRow>,
}

/// Error of a level.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceLevelError {
    /// Name of the level.
    pub level: &'static str,
    /// Number of parameters.
    pub parameters: usize,
    /// Greatest error in millimetres.
    pub error_mm: f32,
}

/// How far a parameter moves a head.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FapLever {
    /// Number of the parameter.
    pub fap: usize,
    /// Greatest displacement of a vertex per unit in micrometres, when it alone has its greatest
    /// value of the clip.
    pub lever_um: f32,
}

/// Choices at a distance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceDetailRow {
    /// Distance from the camera in metres.
    pub distance_m: f32,
    /// Error of each level in pixels, finest first.
    pub levels_px: Vec<f32>,
    /// Name of the coarsest level of each region with which the error stays within the tolerance.
    pub regions: BTreeMap<&'static str, &'static str>,
    /// Number of parameters with these levels.
    pub regions_parameters: usize,
    /// Their error in pixels.
    pub regions_px: f32,
    /// Numbers of the parameters that are kept where each is chosen for itself.
    pub chosen: Vec<usize>,
    /// Error of this choice in pixels.
    pub chosen_px: f32,
}

/// Measures a FAP clip on a head at levels of articulation, and chooses levels and parameters for
/// each distance (`docs/methods/face-levels.md`). `file` names the clip's file.
///
/// Choices at a distance are no finer than at a smaller one.
///
/// # Errors
/// As from [`fit_face`](super::fit_face), and [`Error::Cancelled`].
pub fn face_detail(
    clip: &FapClip,
    file: &str,
    head: &Figure,
    options: &FaceDetailOptions,
    work: &Executor<'_>,
) -> Result<FaceDetailReport> {
    let face = MeasuredFace::new(clip, file, head)?;
    let detail = face.detail();
    let kept = |roles: &FapRoles| detail.kept(roles);
    let errors = FaceLevel::ALL.map(|level| detail.error_m(&FaceLevels::all(level).roles()));
    let level = |(level, error): (FaceLevel, f32)| FaceLevelError {
        level: level.name(),
        parameters: kept(&FaceLevels::all(level).roles()),
        error_mm: 1e3 * error,
    };
    let levers = (LOW_FAPS).zip(detail.levers());
    let levers = levers.filter(|(_, lever)| *lever > 0.0);
    let mut distances = options.distances_m.clone();
    distances.sort_by(f32::total_cmp);
    let mut rows = Vec::with_capacity(distances.len());
    let mut levels = FaceLevels::all(FaceLevel::High);
    let mut chosen = FapRoles::keeping(&[true; FAP_COUNT]);
    for (done, distance_m) in distances.iter().enumerate() {
        work.step("choosing face levels", done, distances.len())?;
        let px = options.viewport.pixels_per_metre(*distance_m);
        let limit_m = options.tolerance_px / px;
        levels = detail.levels_within(levels, limit_m);
        chosen = detail.faps_within(&chosen, limit_m);
        let roles = levels.roles();
        rows.push(FaceDetailRow {
            distance_m: *distance_m,
            levels_px: errors.iter().map(|error| px * error).collect(),
            regions: names(&levels),
            regions_parameters: kept(&roles),
            regions_px: px * detail.error_m(&roles),
            chosen: LOW_FAPS.filter(|fap| chosen.keeps(*fap)).collect(),
            chosen_px: px * detail.error_m(&chosen),
        });
    }
    Ok(FaceDetailReport {
        file: file.to_owned(),
        head: head.opened.name().to_owned(),
        frames: clip.frames.len(),
        rate_hz: clip.rate_hz,
        controls: face.bridge().controls(),
        vertices: face.fields.vertices(),
        levels: FaceLevel::ALL.into_iter().zip(errors).map(level).collect(),
        parameters: levers
            .map(|(fap, lever)| FapLever {
                fap,
                lever_um: 1e6 * lever,
            })
            .collect(),
        rows,
    })
}

/// A FAP clip on a head, with the displacement of every vertex under each control.
#[derive(Debug)]
pub struct MeasuredFace {
    bridge: FaceBridge,
    fields: FaceFields,
    frames: FaceFrames,
}

impl MeasuredFace {
    /// Poses each control of the head alone. `file` names the clip's file.
    ///
    /// # Errors
    /// As from [`fit_face`](super::fit_face).
    pub fn new(clip: &FapClip, file: &str, head: &Figure) -> Result<Self> {
        if clip.frames.is_empty() {
            return Err(Error::unsuited("the file has no frame")).context(file);
        }
        let (rig, controls) = FaceRig::of_figure(head)?;
        Ok(Self {
            bridge: rig.bridge(clip.bridge.as_deref()).clone(),
            fields: fields(&rig, &controls, head),
            frames: face_frames(&with_inner_lips(clip)),
        })
    }

    /// The relation between parameters and controls.
    pub fn bridge(&self) -> &FaceBridge {
        &self.bridge
    }

    /// How far the controls move the vertices.
    pub fn fields(&self) -> &FaceFields {
        &self.fields
    }

    /// The parameters of each frame.
    pub fn frames(&self) -> &FaceFrames {
        &self.frames
    }

    /// Measures the clip at levels of articulation.
    pub fn detail(&self) -> FaceDetail<'_> {
        FaceDetail::new(&self.bridge, &self.fields, &self.frames)
    }
}

/// The displacements under each control, and the eyeballs that turn.
fn fields(rig: &FaceRig, controls: &[Vec<Vec3>], head: &Figure) -> FaceFields {
    let asset = &head.asset;
    let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
    let rest = posed
        .pose(asset.rig.rest_pose())
        .skinned(&asset.mesh.morph_weights);
    let mut fields = FaceFields::new(controls);
    let axes = Quat::libm_rotation_y(facing(&asset.rig, &posed.model)).inverse();
    let eyes = !(23..=26).any(|fap| rig.controls.bridge().moves(fap));
    for (turn, faps) in turns(&head.opened, eyes).iter().filter_map(eyeball) {
        let follows = |vertex: usize| {
            let influences = asset.mesh.influences_of(vertex);
            let of_eye = influences.filter(|(j, _)| asset.rig.is_at_or_below(*j, turn.joint()));
            of_eye.map(|(_, weight)| weight).sum::<f32>()
        };
        let centre = posed.model.position(turn.joint());
        let offset = |(vertex, at): (usize, &Vec3)| follows(vertex) * (axes * (*at - centre));
        let offsets: Vec<Vec3> = rest.positions.iter().enumerate().map(offset).collect();
        fields.add_eyeball(faps, &offsets);
    }
    fields
}

/// The FAPs of pitch and yaw of a turn without roll.
fn eyeball(turn: &Turn) -> Option<(&Turn, [usize; 2])> {
    match turn.faps() {
        [Some(pitch), Some(yaw), None] => Some((turn, [pitch, yaw])),
        _ => None,
    }
}
