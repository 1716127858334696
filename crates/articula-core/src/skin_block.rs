//! Linear blend skinning of points in several poses at once, for measurements.
//!
//! Each pose is one lane: weights and positions are read once for all of them, and no lane depends on
//! another. Sums are those of [`skin_points`](crate::skin_points), so the bits are too.

use crate::mesh::Mesh;
use crate::simd::{Backend, Kernel, LANES, Lanes, Tile, dispatch};
use glam::Affine3A;

/// Number of poses that [`skin_block`] skins at once.
pub const BLOCK_POSES: usize = LANES;

/// Palettes of eight poses.
#[derive(Debug, Clone)]
pub struct PaletteBlock {
    /// Of each binding, the components of its matrix, column by column.
    matrices: Vec<[Tile; 12]>,
}

/// A point in eight poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointBlock([Tile; 3]);

impl PaletteBlock {
    /// Eight palettes of so many zero matrices.
    pub fn new(bindings: usize) -> Self {
        Self {
            matrices: vec![[Tile::ZERO; 12]; bindings],
        }
    }

    /// Sets the palette of one pose.
    ///
    /// # Panics
    /// If there are not eight poses up to this one, or the number of bindings differs.
    pub fn set(&mut self, pose: usize, palette: &[Affine3A]) {
        assert_eq!(
            palette.len(),
            self.matrices.len(),
            "the palette must belong to this mesh"
        );
        for (tiles, matrix) in self.matrices.iter_mut().zip(palette) {
            for (tile, component) in tiles.iter_mut().zip(matrix.to_cols_array()) {
                tile.0[pose] = component;
            }
        }
    }
}

impl PointBlock {
    /// The origin in all poses.
    pub const ZERO: Self = Self([Tile::ZERO; 3]);

    /// A point by its x, y and z in each pose.
    pub fn new(components: [[f32; BLOCK_POSES]; 3]) -> Self {
        Self(components.map(Tile))
    }

    /// The x, y and z of the point in each pose.
    #[inline]
    pub fn components(&self) -> [&[f32; BLOCK_POSES]; 3] {
        self.0.each_ref().map(|tile| &tile.0)
    }
}

/// Skins the positions of the given vertices without morph targets in eight poses, into `out` in the order of
/// `vertices`. Gives the bits of [`skin_points`](crate::skin_points).
///
/// # Panics
/// If a slice belongs to another mesh, or `out` and `vertices` differ in length.
pub fn skin_block(mesh: &Mesh, palettes: &PaletteBlock, vertices: &[u32], out: &mut [PointBlock]) {
    let backend = Backend::best();
    skin_block_on(backend, mesh, palettes, vertices, out);
}

fn skin_block_on(
    backend: Backend,
    mesh: &Mesh,
    palettes: &PaletteBlock,
    vertices: &[u32],
    out: &mut [PointBlock],
) {
    let matrices = &palettes.matrices[..];
    assert_eq!(
        matrices.len(),
        mesh.bindings.len(),
        "the palettes must belong to this mesh"
    );
    assert_eq!(
        out.len(),
        vertices.len(),
        "expected one output for each vertex"
    );
    let work = SkinBlock {
        mesh,
        matrices,
        vertices,
        out,
    };
    dispatch(backend, work);
}

struct SkinBlock<'a> {
    mesh: &'a Mesh,
    matrices: &'a [[Tile; 12]],
    vertices: &'a [u32],
    out: &'a mut [PointBlock],
}

impl Kernel for SkinBlock<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mesh = self.mesh;
        for (PointBlock(out), &v) in self.out.iter_mut().zip(self.vertices) {
            let v = v as usize;
            let of = v * mesh.influences..(v + 1) * mesh.influences;
            let mut sum = [L::splat(0.0); 12];
            let indices = &mesh.binding_indices[of.clone()];
            for (binding, weight) in indices.iter().zip(&mesh.weights[of]) {
                if *weight == 0.0 {
                    continue;
                }
                let weight = L::splat(*weight);
                let matrix = &self.matrices[usize::from(*binding)];
                for (sum, tile) in sum.iter_mut().zip(matrix) {
                    *sum = sum.add(L::load(&tile.0).mul(weight));
                }
            }
            let [x, y, z] = mesh.positions[v].to_array().map(L::splat);
            for (row, out) in out.iter_mut().enumerate() {
                let turned = sum[row].mul(x).add(sum[row + 3].mul(y));
                let turned = turned.add(sum[row + 6].mul(z));
                turned.add(sum[row + 9]).store(out);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Binding;
    use crate::skin::skin_points;
    use glam::Vec3;
    use proptest::prelude::*;

    const BINDINGS: usize = 5;

    proptest! {
        #[test]
        fn every_backend_gives_the_bits_of_one_pose_after_the_other(
            numbers in prop::collection::vec(-9.0f32..9.0, BLOCK_POSES * BINDINGS * 12),
            positions in prop::collection::vec(prop::array::uniform3(-2.0f32..2.0), 9),
            influences in 1usize..6,
            weights in prop::collection::vec(
                prop_oneof![Just(0.0f32), Just(-0.0), 0.0f32..1.0, Just(f32::NAN)], 45),
        ) {
            let matrices: Vec<Affine3A> = numbers
                .as_chunks::<12>().0.iter().map(Affine3A::from_cols_array).collect();
            let binding = Binding { joint: 0, inverse_bind: Affine3A::IDENTITY };
            let count = positions.len() * influences;
            let mesh = Mesh {
                positions: positions.into_iter().map(Vec3::from_array).collect(),
                influences,
                binding_indices: (0..count).map(|i| (i * 7 % BINDINGS) as u16).collect(),
                weights: weights[..count].to_vec(),
                bindings: vec![binding; BINDINGS],
                ..Mesh::default()
            };
            let vertices = [8, 0, 3, 3, 5];
            let mut palettes = PaletteBlock::new(BINDINGS);
            let palette = |pose: usize| &matrices[pose * BINDINGS..][..BINDINGS];
            (0..BLOCK_POSES).for_each(|pose| palettes.set(pose, palette(pose)));
            for backend in Backend::ALL.into_iter().filter(|b| b.is_available()) {
                let mut found = [PointBlock::ZERO; 5];
                skin_block_on(backend, &mesh, &palettes, &vertices, &mut found);
                for pose in 0..BLOCK_POSES {
                    let mut expected = [Vec3::ZERO; 5];
                    skin_points(&mesh, palette(pose), &vertices, &mut expected);
                    for (found, expected) in found.iter().zip(expected) {
                        let found = found.components().map(|of| of[pose]);
                        for (found, expected) in found.into_iter().zip(expected.to_array()) {
                            let same = found.to_bits() == expected.to_bits();
                            prop_assert!(same || found.is_nan() && expected.is_nan());
                        }
                    }
                }
            }
        }
    }
}
