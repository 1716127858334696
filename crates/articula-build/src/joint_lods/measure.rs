//! Distance between the skins of coarser levels and the full character, in motion.

use super::moments::{model_of, pose_of, share_frames, spread_frames};
use super::watch::Watched;
use crate::character::Asset;
use articula_core::percentile;
use articula_core::{Mesh, ModelPose, palette, skin_points};
use glam::{Affine3A, Vec3};

/// Error of one skin, as the maximum over frames.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Tally {
    /// 95th percentile over the uniform random sample of vertices.
    pub(crate) percentile_metres: f32,
    /// Maximum over the watched vertices.
    pub(crate) worst_metres: f32,
}

impl Tally {
    pub(crate) fn worst_of(self, other: Self) -> Self {
        Self {
            percentile_metres: self.percentile_metres.max(other.percentile_metres),
            worst_metres: self.worst_metres.max(other.worst_metres),
        }
    }
}

/// Skins the watched vertices repeatedly, with reused buffers.
pub(crate) struct Poser<'a> {
    mesh: &'a Mesh,
    vertices: Vec<u32>,
    palette: Vec<Affine3A>,
    pub(crate) points: Vec<Vec3>,
}

impl<'a> Poser<'a> {
    pub(crate) fn new(mesh: &'a Mesh, vertices: Vec<u32>) -> Self {
        Self {
            palette: vec![Affine3A::IDENTITY; mesh.bindings.len()],
            points: vec![Vec3::ZERO; vertices.len()],
            vertices,
            mesh,
        }
    }

    pub(crate) fn pose(&mut self, model: &ModelPose) -> &[Vec3] {
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
    let mut truth = Poser::new(full, all.clone());
    let whole = |s: &WatchedSkin| (0..s.mesh.len() as u32).collect();
    let mut shown: Vec<Poser<'_>> = skins
        .iter()
        .map(|s| Poser::new(&s.mesh, whole(s)))
        .collect();
    let (mut lengths, mut of_skin) = (Vec::new(), Vec::new());
    let mut out = Vec::with_capacity(asset.clips.len());
    let counts = share_frames(&asset.clips, frames);
    for (clip, count) in asset.clips.iter().zip(counts) {
        let mut tallies = vec![Tally::default(); skins.len()];
        for frame in spread_frames(clip.frames(), count) {
            let model = model_of(asset, &pose_of(asset, clip, frame));
            let truth = truth.pose(&model);
            let each = skins.iter().zip(&places).zip(&mut shown);
            for (tally, ((skin, places), poser)) in tallies.iter_mut().zip(each) {
                of_skin.clear();
                of_skin.extend(places.iter().map(|place| truth[*place]));
                let shown = poser.pose(&model);
                let tallied = compare(&of_skin, shown, &skin.watched, &mut lengths);
                *tally = tally.worst_of(tallied);
            }
        }
        out.push(tallies);
    }
    out
}

/// Compares one frame; distances that are not finite count as 0.
pub(crate) fn compare(
    truth: &[Vec3],
    shown: &[Vec3],
    watched: &Watched,
    lengths: &mut Vec<f32>,
) -> Tally {
    lengths.clear();
    let mut worst = 0.0f32;
    for ((t, s), drawn) in truth.iter().zip(shown).zip(&watched.drawn) {
        let squared = t.distance_squared(*s);
        let squared = if squared.is_finite() { squared } else { 0.0 };
        worst = worst.max(squared);
        if *drawn {
            lengths.push(squared.sqrt());
        }
    }
    Tally {
        percentile_metres: percentile(lengths, 0.95),
        worst_metres: worst.sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_of_the_sample_the_maximum_of_all() {
        let watched = Watched {
            vertices: (0..22).collect(),
            drawn: (0..22).map(|v| v < 21).collect(),
        };
        // 0 to 20 mm, then 1 m outside the sample; one that is lost counts as 0.
        let truth = vec![Vec3::ZERO; 22];
        let mut shown: Vec<Vec3> = (0..21).map(|v| Vec3::Y * 0.001 * v as f32).collect();
        shown.push(Vec3::X);
        let mut lengths = Vec::new();
        let found = compare(&truth, &shown, &watched, &mut lengths);
        assert!((found.percentile_metres - 0.019).abs() < 1e-6);
        assert_eq!(found.worst_metres, 1.0);
        shown[21] = Vec3::NAN;
        let other = compare(&truth, &shown, &watched, &mut lengths);
        assert!((other.worst_metres - 0.020).abs() < 1e-6);
        assert_eq!(other.worst_of(found), found);
        assert_eq!(found.worst_of(other), found);
    }
}
