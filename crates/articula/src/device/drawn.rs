//! The content of bodies and faces: one figure, posed, skinned and drawn.

use super::face;
use super::grade::Grade;
use super::rest::at_rest;
use super::workload::Workload;
use crate::error::{Error, Result};
use crate::figure::Figure;
use articula_core::{
    Complexity, JointSet, LocalPose, PosedMesh, SkinnedMesh, Viewport, Wrap, loa, local_to_model,
    sample, sample_morphs,
};
use articula_flat::{Appearance, Bounds, Ground, Picture, RenderOptions, orbit_view, render};

/// Where the camera stands, radians.
const AZIMUTH: f32 = 0.5;
const ELEVATION: f32 = 0.1;
/// Vertical field of view, radians.
const FOV_Y_RADIANS: f32 = 0.4;

/// A figure, and what its pictures show of it.
#[derive(Debug)]
pub(super) struct DrawnFigure {
    figure: Figure,
    look: Appearance,
    bounds: Bounds,
    ground: Option<Ground>,
    /// The clip of each level of articulation.
    clips: Vec<usize>,
    /// The joints that move, of each level.
    joints: Vec<JointSet>,
    pose: LocalPose,
    morphs: Vec<f32>,
    skinned: SkinnedMesh,
}

impl DrawnFigure {
    /// The walk of a figure, or its first clip.
    pub(super) fn body(figure: Figure) -> Result<Self> {
        let asset = &figure.asset;
        let walk = asset.clips.iter().position(|clip| clip.name == "walk");
        let levels = &Complexity::ALL[1..];
        let joints = levels
            .iter()
            .map(|level| loa::complexity(&asset.rig, *level));
        let (clips, joints) = (vec![walk.unwrap_or(0); levels.len()], joints.collect());
        let all = Bounds::around(at_rest(&figure).into_iter().map(|p| (p, p)));
        Self::new(figure, all, (clips, joints), Some(Ground::default()))
    }

    /// A face that moves by as many parameters as its level has.
    pub(super) fn face(figure: Figure) -> Result<Self> {
        let (figure, bounds) = face::moving(figure)?;
        let levels = figure.asset.clips.len();
        let all = figure.asset.rig.all();
        let clips = ((0..levels).collect(), vec![all; levels]);
        Self::new(figure, Some(bounds), clips, None)
    }

    fn new(
        figure: Figure,
        bounds: Option<Bounds>,
        (clips, joints): (Vec<usize>, Vec<JointSet>),
        ground: Option<Ground>,
    ) -> Result<Self> {
        let asset = &figure.asset;
        let character = figure.opened.character();
        let bounds = bounds
            .ok_or_else(|| Error::Unsupported("the figure has no place at rest".to_owned()))?;
        Ok(Self {
            look: Appearance::new(&character.materials, &character.images).0,
            pose: asset.rig.rest_pose().clone(),
            morphs: asset.mesh.morph_weights.clone(),
            skinned: SkinnedMesh::new(&asset.mesh),
            bounds,
            ground,
            clips,
            joints,
            figure,
        })
    }

    pub(super) fn play(&mut self, grade: &Grade, secs: f64) -> Result<Picture> {
        let (rig, mesh) = (&self.figure.asset.rig, &self.figure.asset.mesh);
        let level = usize::from(grade.loa).min(self.clips.len() - 1);
        let clip = &self.figure.asset.clips[self.clips[level]];
        self.pose.copy_from(rig.rest_pose());
        self.morphs.copy_from_slice(&mesh.morph_weights);
        sample(clip, secs, Wrap::Loop, &self.joints[level], &mut self.pose);
        sample_morphs(clip, secs, Wrap::Loop, &mut self.morphs);
        let mut posed = PosedMesh::new(rig, mesh);
        local_to_model(rig, &self.pose, &mut posed.model);
        posed.skin(&self.morphs, &mut self.skinned);
        let (width, height) = grade.size_px;
        let viewport = Viewport {
            width_px: width as f32,
            height_px: height as f32,
            fov_y_radians: FOV_Y_RADIANS,
        };
        let camera = orbit_view(&self.bounds, AZIMUTH, ELEVATION, viewport);
        let options = RenderOptions {
            ground: self.ground,
            ..RenderOptions::default()
        };
        Ok(render(mesh, &self.skinned, &self.look, &camera, &options)?)
    }

    pub(super) fn workload(&self, grade: &Grade) -> Workload {
        let level = usize::from(grade.loa).min(self.clips.len() - 1);
        let skin = self.figure.asset.rig.skin_joints();
        Workload {
            figures: 1,
            joints: self.joints[level].intersection(skin).len(),
            vertices: self.figure.asset.mesh.len(),
            pixels: (grade.size_px.0 * grade.size_px.1) as usize,
        }
    }
}
