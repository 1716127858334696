//! Distance between the skins of coarser levels and the full character, in motion.

use super::blocks::{BlockComparison, BlockPoser, Tally};
use super::moments::{models_of, share_frames, spread_frames};
use super::watch::Watched;
use crate::character::Asset;
use articula_core::{BLOCK_POSES, Mesh, ModelPose, palette, skin_points};
use glam::{Affine3A, Vec3};

/// Skins the watched vertices repeatedly, with reused buffers.
pub(super) struct Poser<'a> {
    mesh: &'a Mesh,
    vertices: Vec<u32>,
    palette: Vec<Affine3A>,
    points: Vec<Vec3>,
}

impl<'a> Poser<'a> {
    pub(super) fn new(mesh: &'a Mesh, vertices: Vec<u32>) -> Self {
        Self {
            palette: vec![Affine3A::IDENTITY; mesh.bindings.len()],
            points: vec![Vec3::ZERO; vertices.len()],
            vertices,
            mesh,
        }
    }

    pub(super) fn pose(&mut self, model: &ModelPose) -> &[Vec3] {
        palette(self.mesh, model, &mut self.palette);
        skin_points(self.mesh, &self.palette, &self.vertices, &mut self.points);
        &self.points
    }
}

/// The skin of a level at the vertices where it is compared.
pub(super) struct WatchedSkin {
    pub(super) watched: Watched,
    /// The skin of these vertices.
    pub(super) mesh: Mesh,
}

/// Returns, for each clip, the error of each skin against the full mesh, over about `frames` frames
/// of all clips.
pub(super) fn measure(
    asset: &Asset,
    full: &Mesh,
    skins: &[WatchedSkin],
    frames: usize,
) -> Vec<Vec<Tally>> {
    let mut all: Vec<u32> = skins
        .iter()
        .flat_map(|s| &s.watched.vertices)
        .copied()
        .collect();
    all.sort_unstable();
    all.dedup();
    let place = |v: &u32| all.partition_point(|other| other < v);
    let places = skins
        .iter()
        .map(|s| s.watched.vertices.iter().map(place).collect());
    let places: Vec<Vec<usize>> = places.collect();
    let mut truth = BlockPoser::new(full, all.clone());
    let whole = |s: &WatchedSkin| (0..s.mesh.len() as u32).collect();
    let mut shown: Vec<BlockPoser<'_>> = skins
        .iter()
        .map(|s| BlockPoser::new(&s.mesh, whole(s)))
        .collect();
    let mut comparison = BlockComparison::default();
    let mut out = Vec::with_capacity(asset.clips.len());
    let counts = share_frames(&asset.clips, frames);
    for (clip, count) in asset.clips.iter().zip(counts) {
        let mut tallies = vec![Tally::default(); skins.len()];
        for block in spread_frames(clip.frames(), count).chunks(BLOCK_POSES) {
            let models = models_of(asset, clip, block);
            let truth = truth.pose(&models);
            let each = skins.iter().zip(&places).zip(&mut shown);
            for (tally, ((skin, places), poser)) in tallies.iter_mut().zip(each) {
                let truth = places.iter().map(|place| &truth[*place]);
                let pairs = truth.zip(poser.pose(&models).iter().copied());
                comparison.take(pairs, &skin.watched, block.len(), tally);
            }
        }
        out.push(tallies);
    }
    out
}
