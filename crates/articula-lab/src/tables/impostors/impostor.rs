//! Impostors of a character within a tolerance.

use super::{Row, Subject};
use anyhow::Result;
use articula_core::Progress;
use articula_flat::impostor::{
    ImpostorBound, ImpostorError, ImpostorOptions, ImpostorPlan, ImpostorSource, ImpostorTrial,
};
use articula_flat::{Appearance, Picture};

/// Bytes of pixels above which impostors are not baked.
const MOST_BYTES: usize = 64 << 20;

/// Lowest and highest pitch of eyes, degrees: near the ground among standing characters, and any.
pub(super) const LEVEL_DEG: [f32; 2] = [-10.0, 20.0];
pub(super) const ALL_DEG: [f32; 2] = [-90.0, 90.0];

/// Bytes of pixels to which errors are listed.
const LISTED_BYTES: usize = 16 << 20;

/// Planned impostors, drawn when a sheet needs them.
pub(super) struct Baked {
    pub(super) plan: ImpostorPlan,
}

fn appearance(subject: &Subject) -> Appearance {
    let character = subject.figure.opened.character();
    Appearance::new(&character.materials, &character.images).0
}

fn source<'a>(subject: &'a Subject, appearance: &'a Appearance) -> ImpostorSource<'a> {
    let full = subject.crowd.full();
    ImpostorSource {
        rig: &full.rig,
        mesh: &full.mesh,
        clips: &full.clips,
        appearance,
    }
}

impl Baked {
    /// Impostors of all clips within a tolerance in metres; `None` if that needs too many directions
    /// or bytes.
    pub(super) fn within(
        subject: &Subject,
        tolerance_m: f32,
        pitches_deg: [f32; 2],
    ) -> Result<Option<Self>> {
        let appearance = appearance(subject);
        let options = ImpostorOptions {
            bound: ImpostorBound::Metres(tolerance_m),
            pitches_radians: pitches_deg.map(f32::to_radians),
            ..ImpostorOptions::default()
        };
        let plan = ImpostorPlan::new(
            &source(subject, &appearance),
            &options,
            &mut Progress::none(),
        );
        match plan {
            Ok(plan) => Ok((plan.bytes() <= MOST_BYTES).then_some(Self { plan })),
            Err(ImpostorError::LimitExceeded { .. }) => Ok(None),
            Err(e) => Err(e.into()),
        }
    }

    /// The row, with the time of a cached pose, whose place an impostor takes.
    pub(super) fn row(&self, subject: &Subject, height_px: f32, way: &'static str, ns: f64) -> Row {
        let errors = self.plan.clips.iter().map(|c| c.error_m);
        let worst = errors.fold(0.0, f32::max);
        Row {
            character: subject.name.clone(),
            height_px,
            way,
            error_px: worst * height_px / subject.height_m,
            joints: 0,
            ns,
            bytes: 8.0,
            resident: self.plan.bytes(),
            vertices: 4.0,
            triangles: 2.0,
        }
    }

    /// The atlas with the pictures of one pose; the others are blank.
    pub(super) fn atlas(&self, subject: &Subject, pose: usize) -> Result<Picture> {
        let appearance = appearance(subject);
        let source = source(subject, &appearance);
        let [width, height] = self.plan.cell.size_px;
        let blank = vec![Picture::new(width, height, [0; 4])?; self.plan.views.len()];
        let mut poses = vec![blank; self.plan.poses()];
        if let Some(pictures) = poses.get_mut(pose) {
            *pictures = self.plan.draw(&source, pose)?;
        }
        Ok(self.plan.atlas(&poses)?)
    }
}

/// Errors that numbers of bytes bring.
pub(super) fn trials(subject: &Subject) -> Result<Vec<(String, f32, ImpostorTrial)>> {
    let appearance = appearance(subject);
    let options = ImpostorOptions {
        bound: ImpostorBound::Bytes(LISTED_BYTES),
        pitches_radians: LEVEL_DEG.map(f32::to_radians),
        ..ImpostorOptions::default()
    };
    let plan = ImpostorPlan::new(
        &source(subject, &appearance),
        &options,
        &mut Progress::none(),
    )?;
    let trials = plan.trials.into_iter();
    Ok(trials
        .map(|t| (subject.name.clone(), subject.height_m, t))
        .collect())
}
