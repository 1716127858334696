//! The content of crowds.

use super::grade::Grade;
use super::workload::{FRAME_SECS, Workload};
use crate::crowd::{
    Camera, CrowdAsset, CrowdOptions, CrowdPlayer, Culling, Detail, JointLodMethod, View, Viewport,
};
use crate::error::Result;
use crate::figure::Figure;
use crate::work::Executor;
use articula_core::Backend;
use glam::Vec3;

/// Distance between two figures, metres.
const APART_M: f32 = 1.2;
/// Parts of a frame, for the threads of the caller.
const PARTS: usize = 16;

/// A crowd that stands in a square, all of it seen and posed with all joints.
#[derive(Debug)]
pub(super) struct CrowdContent {
    asset: CrowdAsset,
    /// The crowd of the grade that was played last.
    player: Option<CrowdPlayer>,
}

impl CrowdContent {
    pub(super) fn new(figure: &Figure, backend: Backend, work: &Executor<'_>) -> Result<Self> {
        let options = CrowdOptions {
            joints: JointLodMethod::Whole,
            mesh_levels: Some(1),
            pose_cache: false,
            backend,
            ..CrowdOptions::default()
        };
        Ok(Self {
            asset: CrowdAsset::new(figure, &options, work)?,
            player: None,
        })
    }

    /// Poses one frame. A crowd of another size is made anew, which the first frame of a run bears.
    pub(super) fn play(&mut self, grade: &Grade, work: &Executor<'_>) -> Result<()> {
        let is_same = |player: &CrowdPlayer| player.positions().len() == grade.figures;
        let player = match self.player.take().filter(is_same) {
            Some(player) => player,
            None => placed(&self.asset, grade.figures)?,
        };
        let player = self.player.insert(player);
        let side = (grade.figures as f32).sqrt() * APART_M;
        let middle = Vec3::new(0.5 * side, 0.0, 0.5 * side);
        let eye = middle + Vec3::new(0.0, 1.5 * side, -1.5 * side - 5.0);
        let views = [View::of(&Camera::looking_at(
            eye,
            middle,
            Viewport::default(),
        ))];
        let culling = Culling::Views(&views);
        player.plan_on(FRAME_SECS as f32, culling, &mut |_| (), |sections, tick| {
            let share = sections.len().div_ceil(PARTS).max(1);
            let parts = sections.chunks_mut(share);
            work.run(parts.map(|sections| move || sections.iter_mut().for_each(tick)));
        });
        work.run(player.parts(PARTS).map(|mut part| move || part.evaluate()));
        Ok(())
    }

    pub(super) fn workload(&self, grade: &Grade) -> Workload {
        Workload {
            figures: grade.figures,
            joints: grade.figures * self.asset.level(0).joints,
            ..Workload::default()
        }
    }
}

fn placed(asset: &CrowdAsset, figures: usize) -> Result<CrowdPlayer> {
    let mut player = CrowdPlayer::new(asset, figures)?;
    player.detail = Detail::Full;
    let side = (figures as f32).sqrt().ceil() as usize;
    let clips = asset.clips().len();
    for c in 0..figures {
        let place = APART_M * Vec3::new((c % side) as f32, 0.0, (c / side) as f32);
        player.place(c, place, 0.0);
        // A golden share of the clip apart, so that no two neighbours are alike.
        player.play(c, c % clips, 0.618 * c as f32);
    }
    Ok(player)
}
