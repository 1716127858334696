//! Error of the skin's points with joints and mesh reduced together.

use super::chain::Candidate;
use crate::character::Asset;
use crate::joint_lods::{
    Poser, Tally, Watched, compare, model_of, pose_of, share_frames, skin_part, spread_frames,
};
use crate::surface_distance::{SkinPoint, corners};
use articula_core::{Binding, LevelSkin, Mesh};
use glam::Vec3;

/// A displayed combination: index of a skin, and index of the points of a mesh level.
#[derive(Debug, Clone, Copy)]
pub(super) struct DisplayedLevel {
    pub(super) skin: usize,
    pub(super) points: usize,
}

impl DisplayedLevel {
    pub(super) fn of(candidate: &Candidate) -> Self {
        Self {
            skin: candidate.skin,
            points: candidate.level.mesh_level,
        }
    }
}

/// Skins and points, reduced to the vertices that are used.
pub(super) struct LevelMeasurement<'a> {
    asset: &'a Asset,
    watched: &'a Watched,
    /// Each skin over these vertices.
    skins: Vec<Mesh>,
    /// Points of each mesh level, with corners as indices into these vertices.
    points: Vec<Vec<SkinPoint>>,
}

impl<'a> LevelMeasurement<'a> {
    pub(super) fn new(
        asset: &'a Asset,
        watched: &'a Watched,
        skins: &[&LevelSkin],
        bindings: &[Binding],
        points: &[Vec<SkinPoint>],
    ) -> Self {
        let vertices = corners(&points.concat());
        Self {
            asset,
            watched,
            skins: skins
                .iter()
                .map(|s| skin_part(s, bindings, &vertices))
                .collect(),
            points: points
                .iter()
                .map(|level| level.iter().map(|p| p.among(&vertices)).collect())
                .collect(),
        }
    }

    /// Returns, for each clip, the error of each displayed level, over about `frames` frames of all
    /// clips.
    pub(super) fn measure(&self, shown: &[DisplayedLevel], frames: usize) -> Vec<Vec<Tally>> {
        let asset = self.asset;
        let mut truth = Poser::new(&asset.mesh, self.watched.vertices.clone());
        let needed = self.needed(shown);
        let skins = self.skins.iter().zip(&needed);
        let mut skins: Vec<Poser<'_>> = skins
            .map(|(mesh, vertices)| Poser::new(mesh, vertices.clone()))
            .collect();
        let points = shown.iter().map(|s| {
            let among = self.points[s.points].iter();
            among.map(|p| p.among(&needed[s.skin])).collect()
        });
        let points: Vec<Vec<SkinPoint>> = points.collect();
        let mut lengths = Vec::with_capacity(self.watched.vertices.len());
        let mut there: Vec<Vec3> = Vec::with_capacity(self.watched.vertices.len());
        let mut out = Vec::with_capacity(asset.clips.len());
        let counts = share_frames(&asset.clips, frames);
        for (clip, count) in asset.clips.iter().zip(counts) {
            let mut tallies = vec![Tally::default(); shown.len()];
            for frame in spread_frames(clip.frames(), count) {
                let model = model_of(asset, &pose_of(asset, clip, frame));
                let truth = truth.pose(&model);
                for (skin, _) in skins.iter_mut().zip(&needed).filter(|(_, n)| !n.is_empty()) {
                    skin.pose(&model);
                }
                for (tally, (s, points)) in tallies.iter_mut().zip(shown.iter().zip(&points)) {
                    let posed = &skins[s.skin].points;
                    there.clear();
                    there.extend(points.iter().map(|p| p.posed(posed)));
                    let tallied = compare(truth, &there, self.watched, &mut lengths);
                    *tally = tally.worst_of(tallied);
                }
            }
            out.push(tallies);
        }
        out
    }

    /// Vertices of each skin between which the points of displayed levels are: few where a coarse mesh is shown
    /// with it alone.
    fn needed(&self, shown: &[DisplayedLevel]) -> Vec<Vec<u32>> {
        let of_skin = |skin: usize| {
            let with = shown.iter().filter(|s| s.skin == skin);
            let mut levels: Vec<usize> = with.map(|s| s.points).collect();
            levels.sort_unstable();
            levels.dedup();
            let points: Vec<&[SkinPoint]> = levels.iter().map(|l| &self.points[*l][..]).collect();
            corners(&points.concat())
        };
        (0..self.skins.len()).map(of_skin).collect()
    }
}
