//! Skins of a block of frames, and their errors.

use super::watch::Watched;
use crate::beyond::points_beyond;
use articula_core::{
    BLOCK_POSES, Mesh, ModelPose, PaletteBlock, PointBlock, palette, percentile, skin_block,
};
use glam::Affine3A;

/// Part of a known error that rounding may take from the square of one above it, with a wide margin.
const ROUNDING: f32 = 1e-6;

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

/// Skins vertices in the frames of a block, with reused buffers.
pub(crate) struct BlockPoser<'a> {
    mesh: &'a Mesh,
    vertices: Vec<u32>,
    matrices: Vec<Affine3A>,
    palettes: PaletteBlock,
    pub(crate) points: Vec<PointBlock>,
}

impl<'a> BlockPoser<'a> {
    pub(crate) fn new(mesh: &'a Mesh, vertices: Vec<u32>) -> Self {
        Self {
            matrices: vec![Affine3A::IDENTITY; mesh.bindings.len()],
            palettes: PaletteBlock::new(mesh.bindings.len()),
            points: vec![PointBlock::ZERO; vertices.len()],
            vertices,
            mesh,
        }
    }

    /// Skins the vertices in one to eight poses; what further poses of the block show is unspecified.
    pub(crate) fn pose(&mut self, models: &[ModelPose]) -> &[PointBlock] {
        for (pose, model) in models.iter().enumerate() {
            palette(self.mesh, model, &mut self.matrices);
            self.palettes.set(pose, &self.matrices);
        }
        skin_block(self.mesh, &self.palettes, &self.vertices, &mut self.points);
        &self.points
    }
}

/// Compares skins in blocks of frames, with reused buffers.
#[derive(Default)]
pub(crate) struct BlockComparison {
    /// Squared distances of the drawn vertices.
    squared: Vec<[f32; BLOCK_POSES]>,
    lengths: Vec<f32>,
}

impl BlockComparison {
    /// Takes the first `frames` frames of a block into a tally; distances that are not finite count as 0.
    pub(crate) fn take<'p>(
        &mut self,
        pairs: impl Iterator<Item = (&'p PointBlock, PointBlock)>,
        watched: &Watched,
        frames: usize,
        tally: &mut Tally,
    ) {
        self.squared.clear();
        let mut worst = [0.0f32; BLOCK_POSES];
        for ((truth, shown), drawn) in pairs.zip(&watched.drawn) {
            let squared = distances_squared(truth, &shown);
            for (worst, squared) in worst.iter_mut().zip(squared) {
                *worst = if squared > *worst { squared } else { *worst };
            }
            if *drawn {
                self.squared.push(squared);
            }
        }
        for worst in &worst[..frames] {
            tally.worst_metres = tally.worst_metres.max(worst.sqrt());
        }
        let known = tally.percentile_metres;
        let least = known * known * (1.0 - ROUNDING);
        let mut above = [0usize; BLOCK_POSES];
        for squared in &self.squared {
            for (above, squared) in above.iter_mut().zip(squared) {
                *above += usize::from(*squared > least);
            }
        }
        let beyond = points_beyond(self.squared.len());
        for frame in (0..frames).filter(|frame| above[*frame] > beyond) {
            self.lengths.clear();
            let lengths = self.squared.iter().map(|squared| squared[frame].sqrt());
            self.lengths.extend(lengths);
            let found = percentile(&mut self.lengths, 0.95);
            tally.percentile_metres = tally.percentile_metres.max(found);
        }
    }
}

/// Squared distance in each pose, 0 where it is not finite.
#[inline]
pub(crate) fn distances_squared(a: &PointBlock, b: &PointBlock) -> [f32; BLOCK_POSES] {
    let ([ax, ay, az], [bx, by, bz]) = (a.components(), b.components());
    let mut out = [0.0; BLOCK_POSES];
    for (i, out) in out.iter_mut().enumerate() {
        let (x, y, z) = (ax[i] - bx[i], ay[i] - by[i], az[i] - bz[i]);
        let squared = x * x + y * y + z * z;
        *out = if squared.is_finite() { squared } else { 0.0 };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::split_mix::SplitMix;
    use glam::Vec3;

    fn still(at: Vec3) -> PointBlock {
        PointBlock::new(at.to_array().map(|c| [c; BLOCK_POSES]))
    }

    #[test]
    fn percentiles_are_of_the_sample_the_maximum_of_all() {
        let watched = Watched {
            vertices: (0..22).collect(),
            drawn: (0..22).map(|v| v < 21).collect(),
        };
        // 0 to 20 mm, then 1 m outside the sample; one that is lost counts as 0.
        let truth = [PointBlock::ZERO; 22];
        let mut shown: Vec<Vec3> = (0..21).map(|v| Vec3::Y * 0.001 * v as f32).collect();
        shown.push(Vec3::X);
        let tally = |shown: &[Vec3]| {
            let shown = shown.iter().map(|at| still(*at));
            let (pairs, mut tally) = (truth.iter().zip(shown), Tally::default());
            BlockComparison::default().take(pairs, &watched, 1, &mut tally);
            tally
        };
        let found = tally(&shown);
        assert!((found.percentile_metres - 0.019).abs() < 1e-6);
        assert_eq!(found.worst_metres, 1.0);
        shown[21] = Vec3::NAN;
        let other = tally(&shown);
        assert!((other.worst_metres - 0.020).abs() < 1e-6);
    }

    #[test]
    fn tallies_of_blocks_are_those_of_every_frame() {
        let mut random = SplitMix(3);
        let count = 90;
        let watched = Watched {
            vertices: (0..count).collect(),
            drawn: (0..count).map(|v| v % 3 != 1).collect(),
        };
        let (mut comparison, mut tally) = (BlockComparison::default(), Tally::default());
        let mut expected = Tally::default();
        for block in 0..40 {
            // Most blocks are calmer than some before; of the last poses nothing counts.
            let size = if block % 9 == 4 { 2.0 } else { 1.0 };
            let frames = 1 + block % BLOCK_POSES;
            let mut number = |pose: usize| match (random.unit(), pose < frames) {
                (_, false) => 99.0,
                (at, true) if at > 0.998 => f32::NAN,
                (at, true) => size * at,
            };
            let mut points = || -> Vec<PointBlock> {
                let mut point =
                    || PointBlock::new([(); 3].map(|()| std::array::from_fn(&mut number)));
                (0..count).map(|_| point()).collect()
            };
            let (truth, shown) = (points(), points());
            let pairs = truth.iter().zip(shown.iter().copied());
            comparison.take(pairs, &watched, frames, &mut tally);
            for frame in 0..frames {
                let length = |v: u32| {
                    let at = |of: &[PointBlock]| {
                        Vec3::from_array(of[v as usize].components().map(|c| c[frame]))
                    };
                    let length = at(&truth).distance(at(&shown));
                    if length.is_finite() { length } else { 0.0 }
                };
                let drawn = (0..count).filter(|v| v % 3 != 1);
                let mut lengths: Vec<f32> = drawn.map(length).collect();
                expected = expected.worst_of(Tally {
                    percentile_metres: percentile(&mut lengths, 0.95),
                    worst_metres: (0..count).map(length).fold(0.0, f32::max),
                });
            }
            assert_eq!(tally, expected, "block {block}");
        }
    }
}
