//! Error of the skin's points with joints and mesh reduced together.

use super::bounds::{BoundedLevel, ErrorBounds, Motion, Palettes};
use super::chain::Candidate;
use crate::character::Asset;
use crate::joint_lods::{
    BlockComparison, BlockPoser, Tally, Watched, distances_squared, models_of, share_frames,
    skin_part, spread_frames,
};
use crate::surface_distance::{SkinPoint, compact, corners};
use articula_core::{
    BLOCK_POSES, Binding, LevelSkin, Mesh, ModelPose, PaletteBlock, PointBlock, palette, skin_block,
};
use glam::Affine3A;

/// Frames that share the norms of their matrices.
const STRETCH: usize = 32;

/// Vertices that are measured before the bounds of the others are looked at again.
const TOGETHER: usize = 48;

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
        let mut truth = BlockPoser::new(&asset.mesh, self.watched.vertices.clone());
        let needed = self.needed(shown);
        let skins = self.skins.iter().zip(&needed);
        let mut skins: Vec<BlockPoser<'_>> = skins
            .map(|(mesh, vertices)| BlockPoser::new(mesh, vertices.clone()))
            .collect();
        let points = shown.iter().map(|s| {
            let among = self.points[s.points].iter();
            among.map(|p| p.among(&needed[s.skin])).collect()
        });
        let points: Vec<Vec<SkinPoint>> = points.collect();
        let mut comparison = BlockComparison::default();
        let mut out = Vec::with_capacity(asset.clips.len());
        let counts = share_frames(&asset.clips, frames);
        for (clip, count) in asset.clips.iter().zip(counts) {
            let mut tallies = vec![Tally::default(); shown.len()];
            for block in spread_frames(clip.frames(), count).chunks(BLOCK_POSES) {
                let models = models_of(asset, clip, block);
                let truth = truth.pose(&models);
                for (skin, _) in skins.iter_mut().zip(&needed).filter(|(_, n)| !n.is_empty()) {
                    skin.pose(&models);
                }
                for (tally, (s, points)) in tallies.iter_mut().zip(shown.iter().zip(&points)) {
                    let posed = &skins[s.skin].points;
                    let there = points.iter().map(|p| p.posed_block(posed));
                    let pairs = truth.iter().zip(there);
                    comparison.take(pairs, self.watched, block.len(), tally);
                }
            }
            out.push(tallies);
        }
        out
    }

    /// Returns what [`measure`](Self::measure) does, where percentiles are those of the drawn vertices: `drawn`
    /// measures these alone. Of the others it measures only those that may err more than any so far.
    pub(super) fn measure_with_worst(
        &self,
        drawn: &Self,
        shown: &[DisplayedLevel],
        frames: usize,
    ) -> Vec<Vec<Tally>> {
        let mut tallies = drawn.measure(shown, frames);
        let levels = shown.iter().map(|s| BoundedLevel {
            skin: &self.skins[s.skin],
            points: &self.points[s.points],
        });
        let levels: Vec<BoundedLevel<'_>> = levels.collect();
        let bounds = ErrorBounds::new(&self.asset.mesh, &self.watched.vertices, &levels);
        let clips = self.asset.clips.iter();
        let counts = share_frames(&self.asset.clips, frames);
        for ((clip, count), tallies) in clips.zip(counts).zip(&mut tallies) {
            for stretch in spread_frames(clip.frames(), count).chunks(STRETCH) {
                let models = models_of(self.asset, clip, stretch);
                let poses: Vec<Palettes> = models.iter().map(|m| self.palettes(m)).collect();
                let blocks: Vec<BlockPalettes> =
                    poses.chunks(BLOCK_POSES).map(BlockPalettes::of).collect();
                let motion = bounds.motion(&poses);
                for (level, tally) in tallies.iter_mut().enumerate() {
                    let known = tally.worst_metres;
                    let likely = likely(&bounds, level, &motion, known);
                    tally.worst_metres = self.worst(&levels[level], &blocks, &likely, known);
                }
            }
        }
        tallies
    }

    fn palettes(&self, model: &ModelPose) -> Palettes {
        let of = |mesh: &Mesh| {
            let mut matrices = vec![Affine3A::IDENTITY; mesh.bindings.len()];
            palette(mesh, model, &mut matrices);
            matrices
        };
        Palettes {
            full: of(&self.asset.mesh),
            level: self.skins.first().map_or(Vec::new(), of),
        }
    }

    /// The greatest distance of the points of a level in some frames, at least `worst`. `likely` has bounds and
    /// indices of points, the greatest bound first.
    fn worst(
        &self,
        level: &BoundedLevel<'_>,
        blocks: &[BlockPalettes],
        likely: &[(f32, u32)],
        mut worst: f32,
    ) -> f32 {
        let (mut truth, mut there) = (Vec::new(), Vec::new());
        for some in likely.chunks(TOGETHER) {
            if some[0].0 <= worst {
                break;
            }
            let vertices = some.iter().map(|(_, i)| self.watched.vertices[*i as usize]);
            let vertices: Vec<u32> = vertices.collect();
            let points: Vec<SkinPoint> = some
                .iter()
                .map(|(_, i)| level.points[*i as usize])
                .collect();
            let (corners, points) = compact(&points);
            truth.resize(vertices.len(), PointBlock::ZERO);
            there.resize(corners.len(), PointBlock::ZERO);
            for block in blocks {
                skin_block(&self.asset.mesh, &block.full, &vertices, &mut truth);
                skin_block(level.skin, &block.level, &corners, &mut there);
                for (truth, point) in truth.iter().zip(&points) {
                    let squared = distances_squared(truth, &point.posed_block(&there));
                    let squared = squared[..block.poses].iter().copied();
                    worst = worst.max(squared.fold(0.0, f32::max).sqrt());
                }
            }
        }
        worst
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

/// Palettes of up to eight frames.
struct BlockPalettes {
    poses: usize,
    full: PaletteBlock,
    level: PaletteBlock,
}

impl BlockPalettes {
    fn of(poses: &[Palettes]) -> Self {
        let mut full = PaletteBlock::new(poses[0].full.len());
        let mut level = PaletteBlock::new(poses[0].level.len());
        for (i, pose) in poses.iter().enumerate() {
            full.set(i, &pose.full);
            level.set(i, &pose.level);
        }
        Self {
            poses: poses.len(),
            full,
            level,
        }
    }
}

/// Bounds and indices of the points of a level whose bound is not within a known error, the greatest first. One
/// that is no number is greater than all.
fn likely(bounds: &ErrorBounds, level: usize, motion: &Motion, known: f32) -> Vec<(f32, u32)> {
    let all = bounds.of_level(level, motion).zip(0..);
    let number = |bound: f32| if bound.is_nan() { f32::INFINITY } else { bound };
    let mut likely: Vec<(f32, u32)> = all
        .map(|(bound, i)| (number(bound), i))
        .filter(|(bound, _)| *bound > known)
        .collect();
    likely.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    likely
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_lods::test_figures::{arm, moving};
    use crate::joint_lods::{JointLodOptions, merged_levels};
    use glam::{Quat, Vec3};

    #[test]
    fn errors_with_few_vertices_measured_are_those_with_all() {
        let mut asset = arm(20);
        let turns = |axis: Vec3| -> Vec<Quat> {
            let turn = |f: usize| Quat::from_axis_angle(axis, 0.03 * f as f32);
            (0..70).map(turn).collect()
        };
        asset.clips = vec![
            moving(20, 1, &turns(Vec3::Z)),
            moving(20, 9, &turns(Vec3::X)),
            moving(20, 17, &turns(Vec3::Z)),
        ];
        let options = JointLodOptions::default();
        let merged = merged_levels(&asset, &options).unwrap();
        let skins: Vec<&LevelSkin> = merged.skins.levels.iter().collect();
        let every = Watched::every(&asset.mesh, 9, 3);
        let count = asset.mesh.len() as u32;
        let whole = every.vertices.iter().map(|v| SkinPoint::at(*v)).collect();
        let between = every.vertices.iter().map(|v| SkinPoint {
            corners: [*v, (v + 5) % count, (v + 9) % count],
            weights: [0.5, 0.3, 0.2],
        });
        let points: Vec<Vec<SkinPoint>> = vec![whole, between.collect()];
        let shown: Vec<DisplayedLevel> = (0..skins.len())
            .flat_map(|skin| [0, 1].map(|points| DisplayedLevel { skin, points }))
            .collect();
        assert!(shown.len() > 4, "several levels");
        let of = |watched, points: &[Vec<SkinPoint>]| {
            LevelMeasurement::new(&asset, watched, &skins, &merged.skins.bindings, points)
        };
        let (drawn, of_drawn) = super::super::drawn(&every, &points);
        let scene = of(&every, &points);
        let all = scene.measure(&shown, 150);
        let few = scene.measure_with_worst(&of(&drawn, &of_drawn), &shown, 150);
        assert_eq!(few, all);
        assert!(all[1].iter().any(|t| t.worst_metres > t.percentile_metres));
    }
}
