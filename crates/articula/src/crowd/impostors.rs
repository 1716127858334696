//! Impostors of the character of a crowd: the choice, the pictures, and the points that each shows.

use super::options::CrowdOptions;
use crate::error::{Context, Error, Result};
use crate::work::Executor;
use articula_build::Asset;
use articula_core::{Impostors, Mismatch, PosedMesh, Wrap};
use articula_flat::impostor::{ImpostorPlan, ImpostorSource};
use articula_flat::{Appearance, Picture};
use glam::{Affine3A, Vec3};

/// Name of the step that chooses in progress reports.
pub(crate) const CHOOSING: &str = "choosing impostors";

/// Name of the step that draws in progress reports.
const DRAWING: &str = "drawing impostors";

/// Draws all pictures of a plan.
pub(crate) fn drawn(
    plan: &ImpostorPlan,
    source: &ImpostorSource<'_>,
    work: &Executor<'_>,
) -> Result<Picture> {
    let poses = (0..plan.poses()).collect();
    let drawn = work.map(DRAWING, poses, |pose| {
        plan.draw(source, pose).map_err(Error::from)
    })?;
    Ok(plan.atlas(&drawn)?)
}

/// The impostors of a crowd's character.
#[derive(Debug)]
pub(super) struct CrowdImpostors(ImpostorPlan);

impl CrowdImpostors {
    /// Chooses the impostors that the options ask for.
    pub(super) fn chosen(
        asset: &Asset,
        options: &CrowdOptions,
        work: &Executor<'_>,
    ) -> Result<Option<Self>> {
        let plain = Appearance::default();
        let source = source(asset, &plain);
        let plan = options.impostors.map(|options| {
            work.with_progress(CHOOSING, |p| ImpostorPlan::new(&source, &options, p))
        });
        Ok(plan.transpose().context("impostors")?.map(Self))
    }

    /// Which pictures there are.
    pub(super) fn plan(&self) -> &ImpostorPlan {
        &self.0
    }

    /// The table that a frame reads.
    pub(super) fn table(&self) -> Result<Impostors, Mismatch> {
        self.0.table()
    }

    /// The greatest error of any clip, metres.
    pub(super) fn error_metres(&self) -> f32 {
        let errors = self.0.clips.iter().map(|clip| clip.error_m);
        errors.fold(0.0, f32::max)
    }

    /// Bytes of the pixels of all pictures.
    pub(super) fn bytes(&self) -> usize {
        self.0.bytes()
    }

    /// Writes the matrices of [`CrowdPlayer::impostor_matrices`](super::CrowdPlayer::impostor_matrices) for an
    /// eye in model space.
    pub(super) fn matrices(&self, full: &Asset, pose: usize, eye: Vec3, out: &mut Vec<Affine3A>) {
        let Some((clip, place)) = self.0.clip_of(pose) else {
            return;
        };
        let of_clip = &self.0.clips[clip];
        let centre = of_clip.centres[place];
        let views = &self.0.views;
        let view = views.iter().nth(views.nearest(eye - centre));
        let Some(flattened) = view.map(|view| view.flattened(centre)) else {
            return;
        };
        let mut posed = PosedMesh::new(&full.rig, &full.mesh);
        let secs = f64::from(of_clip.pose_secs[place]);
        posed.pose_at(&full.clips[clip], secs, Wrap::Clamp);
        out.clear();
        let bindings = full.mesh.bindings.iter();
        out.extend(
            bindings
                .map(|b| flattened * posed.model.matrices[usize::from(b.joint)] * b.inverse_bind),
        );
    }
}

/// The character as impostors show it.
pub(super) fn source<'a>(asset: &'a Asset, appearance: &'a Appearance) -> ImpostorSource<'a> {
    ImpostorSource {
        rig: &asset.rig,
        mesh: &asset.mesh,
        clips: &asset.clips,
        appearance,
    }
}
