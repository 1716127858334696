//! Linear blend skinning with vertices grouped by their number of influences.
//!
//! The fast counterpart of [`crate::skin`]: the same operations in the same order, so its values
//! are equal (within rounding in builds that fuse multiplication and addition). A vertex costs only
//! its nonzero influences. The matrices of four vertices of a group are blended one vertex at a
//! time, then transposed so that each vertex occupies one lane. Each block of 32 vertices stores
//! its joints, so that a block whose joints did not move need not be skinned again. Morph targets
//! are stored in the same order, as offsets of four vertices that are added at once.
//!
//! The grouping and the blocks do not come from a publication. Eight lanes on the backends of
//! batches were measured as an alternative: 8 % faster with AVX2, but twice as slow on plain
//! arrays. Most of the time is spent on loading matrices and scattering vertices.

use crate::joint_set::JointSet;
use crate::mesh::{Mesh, Morph};
use crate::skin::SkinnedMesh;
use glam::{Affine3A, Mat4, Vec3, Vec4};
use std::ops::Range;

/// The three rows of an affine matrix, 48 bytes. Rows written by
/// [`crate::palette::PaletteForm::Matrix`] are converted with `as_chunks::<3>().0`.
pub type Matrix3x4 = [[f32; 4]; 3];

/// Number of vertices that are transformed together.
const LANES: usize = 4;

/// Quads per block: 32 vertices. Smaller blocks skip more unmoved vertices, but cost more to visit.
const BLOCK_QUADS: usize = 8;

/// Marks an unused lane in the last quad of a group.
const NO_VERTEX: u32 = u32::MAX;

/// Rest positions and normals of four vertices, one per lane.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Quad {
    position: [Vec4; 3],
    normal: [Vec4; 3],
}

/// Unskinned positions and normals in mesh space, in the order of one [`GroupedSkin`], at rest or
/// with morph targets added.
#[derive(Debug, Clone, PartialEq)]
pub struct MorphedShape {
    quads: Vec<Quad>,
    /// Morph target weights of the last call of [`GroupedSkin::morph`].
    weights: Vec<f32>,
}

/// One flag for each block of a [`GroupedSkin`]: whether its skinned output is out of date.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StaleBlocks {
    blocks: Vec<bool>,
}

/// A morph target in the order of the groups: four vertices at a time, where it moves any of them;
/// the offsets of the others are 0.
#[derive(Debug, Clone)]
struct QuadTarget {
    /// Index into the morph target weights.
    slot: usize,
    /// Offsets by quad, ascending.
    quads: Vec<(u32, Quad)>,
    /// Blocks of these quads, ascending.
    blocks: Vec<u32>,
}

/// Up to 32 vertices of one group.
#[derive(Debug, Clone)]
struct Block {
    /// Number of influences of each vertex.
    influences: usize,
    quads: Range<usize>,
    /// Range of the block in `indices` and `weights`.
    values: Range<usize>,
    /// Joints that move any of the vertices.
    joints: JointSet,
}

/// The skin of a [`Mesh`] with its vertices grouped by their number of nonzero influences; shared
/// by all characters with the mesh.
///
/// ```
/// use articula_core::{GroupedSkin, Matrix3x4, Mesh, SkinnedMesh};
///
/// let mesh = Mesh::default();
/// let (before, now): (Vec<Matrix3x4>, Vec<Matrix3x4>) = (vec![], vec![]);
/// let skin = GroupedSkin::new(&mesh);
/// // One of each for every character that is skinned:
/// let (mut stale, mut out) = (skin.stale(), SkinnedMesh::new(&mesh));
/// // Every frame:
/// skin.mark_joints(&skin.moved(&before, &now), &mut stale);
/// let skinned = skin.skin_stale(skin.rest(), &now, &mut stale, &mut out);
/// assert_eq!(skinned, mesh.len(), "in the first frame all");
/// ```
#[derive(Debug, Clone)]
pub struct GroupedSkin {
    /// Joint of each matrix of the palette.
    joints: Vec<u16>,
    blocks: Vec<Block>,
    /// Mesh vertex in each lane, or [`NO_VERTEX`].
    vertices: Vec<[u32; LANES]>,
    /// Lane of each vertex of the mesh.
    lane_of: Vec<u32>,
    /// Palette indices of the influences, vertex after vertex of a group.
    indices: Vec<u16>,
    weights: Vec<f32>,
    rest: MorphedShape,
    targets: Vec<QuadTarget>,
}

impl GroupedSkin {
    /// Groups the vertices of a mesh. Allocates; of the other methods only [`GroupedSkin::stale`]
    /// does.
    ///
    /// # Panics
    /// If the mesh belongs to a rig with more than `MAX_JOINTS` joints.
    pub fn new(mesh: &Mesh) -> Self {
        let counts: Vec<usize> = (0..mesh.len()).map(|v| weighty(mesh, v).count()).collect();
        let most = counts.iter().copied().max().unwrap_or(0);
        let mut skin = Self {
            joints: mesh.bindings.iter().map(|b| b.joint).collect(),
            blocks: Vec::new(),
            vertices: Vec::with_capacity(mesh.len() / LANES + most + 1),
            lane_of: vec![0; mesh.len()],
            indices: Vec::new(),
            weights: Vec::new(),
            rest: MorphedShape {
                quads: Vec::new(),
                weights: vec![0.0; mesh.morph_weights.len()],
            },
            targets: Vec::new(),
        };
        for influences in 0..=most {
            let mut group: Vec<usize> = (0..mesh.len())
                .filter(|v| counts[*v] == influences)
                .collect();
            // Vertices of the same joint share blocks, so that a moved joint touches few of them.
            group.sort_by_key(|v| heaviest(mesh, *v));
            for block in group.chunks(BLOCK_QUADS * LANES) {
                skin.append(mesh, influences, block);
            }
        }
        skin.targets = mesh.morphs.iter().map(|m| skin.target(m)).collect();
        skin
    }

    fn target(&self, morph: &Morph) -> QuadTarget {
        let offsets = morph.positions.iter().zip(&morph.normals);
        let each = morph.vertices.iter().zip(offsets);
        let mut lanes: Vec<(usize, Vec3, Vec3)> = each
            .map(|(v, (dp, dn))| (self.lane_of[*v as usize] as usize, *dp, *dn))
            .collect();
        lanes.sort_by_key(|(lane, ..)| *lane);
        let quad_of = |a: &(usize, Vec3, Vec3)| a.0 / LANES;
        let quads = lanes
            .chunk_by(|a, b| quad_of(a) == quad_of(b))
            .map(|lanes| {
                let mut quad = Quad {
                    position: [Vec4::ZERO; 3],
                    normal: [Vec4::ZERO; 3],
                };
                for (lane, position, normal) in lanes {
                    quad.set(lane % LANES, *position, *normal);
                }
                (quad_of(&lanes[0]) as u32, quad)
            });
        let quads: Vec<(u32, Quad)> = quads.collect();
        let blocks = quads.iter().map(|(q, _)| self.block_of(*q as usize) as u32);
        let mut blocks: Vec<u32> = blocks.collect();
        blocks.dedup();
        QuadTarget {
            slot: usize::from(morph.slot),
            quads,
            blocks,
        }
    }

    /// Converts a palette to the rows that skinning reads.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn rows(palette: &[Affine3A], out: &mut [Matrix3x4]) {
        assert_eq!(
            palette.len(),
            out.len(),
            "expected one output for each matrix"
        );
        for (rows, matrix) in out.iter_mut().zip(palette) {
            let (m, t) = (matrix.matrix3, matrix.translation);
            *rows = [
                [m.x_axis.x, m.y_axis.x, m.z_axis.x, t.x],
                [m.x_axis.y, m.y_axis.y, m.z_axis.y, t.y],
                [m.x_axis.z, m.y_axis.z, m.z_axis.z, t.z],
            ];
        }
    }

    fn append(&mut self, mesh: &Mesh, influences: usize, block: &[usize]) {
        let (first_quad, first_value) = (self.vertices.len(), self.indices.len());
        let mut joints = JointSet::EMPTY;
        for four in block.chunks(LANES) {
            let mut quad = Quad {
                position: [Vec4::ZERO; 3],
                normal: [Vec4::ZERO; 3],
            };
            let mut vertices = [NO_VERTEX; LANES];
            for (lane, &v) in four.iter().enumerate() {
                self.lane_of[v] = (self.vertices.len() * LANES + lane) as u32;
                vertices[lane] = v as u32;
                quad.set(lane, mesh.positions[v], mesh.normals[v]);
                for (index, weight) in weighty(mesh, v) {
                    joints.insert(usize::from(mesh.bindings[usize::from(index)].joint));
                    self.indices.push(index);
                    self.weights.push(weight);
                }
            }
            // Unused lanes have weight 0, but the kernel still reads their influences.
            let full = first_value + (self.vertices.len() + 1 - first_quad) * LANES * influences;
            let filler = self.indices.last().copied().unwrap_or(0);
            self.indices.resize(full, filler);
            self.weights.resize(full, 0.0);
            self.vertices.push(vertices);
            self.rest.quads.push(quad);
        }
        self.blocks.push(Block {
            influences,
            quads: first_quad..self.vertices.len(),
            values: first_value..self.indices.len(),
            joints,
        });
    }

    /// Returns the number of vertices of the mesh.
    pub(crate) fn len(&self) -> usize {
        self.lane_of.len()
    }

    /// Returns the shape at rest, without morph targets; clone it for a character with morph
    /// targets.
    pub fn rest(&self) -> &MorphedShape {
        &self.rest
    }

    /// Returns flags with all blocks stale, as before the first call of
    /// [`GroupedSkin::skin_stale`]. Allocates.
    pub fn stale(&self) -> StaleBlocks {
        StaleBlocks {
            blocks: vec![true; self.blocks.len()],
        }
    }

    /// Sets a shape to the rest shape plus weighted morph targets, and marks the blocks of targets
    /// with changed weights as stale. Weights must be finite. O(vertices of the targets that have a
    /// weight, now or in the call before).
    ///
    /// # Panics
    /// If an argument belongs to another mesh.
    pub fn morph(&self, weights: &[f32], shape: &mut MorphedShape, stale: &mut StaleBlocks) {
        assert_eq!(
            weights.len(),
            shape.weights.len(),
            "the morph weights must belong to this mesh"
        );
        self.check_shape(shape);
        self.check_stale(stale);
        if weights == shape.weights {
            return;
        }
        // The vertices of other targets are at rest.
        for target in &self.targets {
            let (before, now) = (shape.weights[target.slot], weights[target.slot]);
            if before == 0.0 && now == 0.0 {
                continue;
            }
            for (quad, _) in &target.quads {
                let quad = *quad as usize;
                shape.quads[quad] = self.rest.quads[quad];
            }
            if before != now {
                for block in &target.blocks {
                    stale.blocks[*block as usize] = true;
                }
            }
        }
        // In the mesh's order, so that sums round as in the plain version.
        for target in &self.targets {
            let weight = weights[target.slot];
            if weight == 0.0 {
                continue;
            }
            for (quad, offsets) in &target.quads {
                shape.quads[*quad as usize].add_weighted(offsets, weight);
            }
        }
        shape.weights.copy_from_slice(weights);
    }

    /// Marks the blocks with vertices moved by any of these joints as stale. The set must include
    /// joints that moved only because an ancestor did.
    ///
    /// # Panics
    /// If `stale` belongs to another mesh.
    pub fn mark_joints(&self, moved: &JointSet, stale: &mut StaleBlocks) {
        self.check_stale(stale);
        for (flag, block) in stale.blocks.iter_mut().zip(&self.blocks) {
            *flag |= !block.joints.is_disjoint(moved);
        }
    }

    /// Returns the joints whose matrices differ between two palettes.
    ///
    /// # Panics
    /// If a palette belongs to another mesh.
    pub fn moved(&self, before: &[Matrix3x4], now: &[Matrix3x4]) -> JointSet {
        self.check_palette(before);
        self.check_palette(now);
        let pairs = before.iter().zip(now).zip(&self.joints);
        pairs
            .filter(|((a, b), _)| a != b)
            .map(|(_, joint)| usize::from(*joint))
            .collect()
    }

    /// Skins positions and normals of all vertices, in the mesh's order.
    ///
    /// Every value equals that of [`crate::skin::skin`], within rounding in builds that fuse
    /// multiplication and addition. O(nonzero influences); does not allocate.
    ///
    /// # Panics
    /// If an argument belongs to another mesh.
    pub fn skin(&self, shape: &MorphedShape, palette: &[Matrix3x4], out: &mut SkinnedMesh) {
        self.check_palette(palette);
        self.check_out(out);
        self.check_shape(shape);
        for block in &self.blocks {
            self.skin_block(block, shape, palette, out);
        }
    }

    /// Skins only the stale blocks, clears their flags and returns the number of vertices skinned.
    /// All other vertices of `out` keep their values.
    ///
    /// # Panics
    /// If an argument belongs to another mesh.
    pub fn skin_stale(
        &self,
        shape: &MorphedShape,
        palette: &[Matrix3x4],
        stale: &mut StaleBlocks,
        out: &mut SkinnedMesh,
    ) -> usize {
        self.check_palette(palette);
        self.check_out(out);
        self.check_shape(shape);
        self.check_stale(stale);
        let mut skinned = 0;
        for (block, flag) in self.blocks.iter().zip(&mut stale.blocks) {
            if std::mem::take(flag) {
                self.skin_block(block, shape, palette, out);
                skinned += self.vertices_of(block);
            }
        }
        skinned
    }

    fn vertices_of(&self, block: &Block) -> usize {
        let lanes = self.vertices[block.quads.clone()].as_flattened();
        // Only the last quad of a group has unused lanes.
        lanes.len() - lanes.iter().rev().take_while(|v| **v == NO_VERTEX).count()
    }

    fn block_of(&self, quad: usize) -> usize {
        self.blocks.partition_point(|b| b.quads.end <= quad)
    }

    fn check_shape(&self, shape: &MorphedShape) {
        assert_eq!(
            shape.quads.len(),
            self.vertices.len(),
            "the shape must belong to this mesh"
        );
    }

    fn check_stale(&self, stale: &StaleBlocks) {
        assert_eq!(
            stale.blocks.len(),
            self.blocks.len(),
            "the stale blocks must belong to this mesh"
        );
    }

    fn check_palette(&self, palette: &[Matrix3x4]) {
        assert_eq!(
            palette.len(),
            self.joints.len(),
            "the palette must belong to this mesh"
        );
    }

    fn check_out(&self, out: &SkinnedMesh) {
        let lengths = (out.positions.len(), out.normals.len());
        assert_eq!(
            lengths,
            (self.len(), self.len()),
            "the output must belong to this mesh"
        );
    }

    fn skin_block(
        &self,
        block: &Block,
        shape: &MorphedShape,
        palette: &[Matrix3x4],
        out: &mut SkinnedMesh,
    ) {
        let vertices = &self.vertices[block.quads.clone()];
        let quads = &shape.quads[block.quads.clone()];
        let influences = Influences {
            palette,
            indices: &self.indices[block.values.clone()],
            weights: &self.weights[block.values.clone()],
        };
        match block.influences {
            0 => skin_nowhere(vertices, quads, out),
            1 => influences.skin::<1>(vertices, quads, out),
            2 => influences.skin::<2>(vertices, quads, out),
            3 => influences.skin::<3>(vertices, quads, out),
            4 => influences.skin::<4>(vertices, quads, out),
            many => influences.skin_many(many, vertices, quads, out),
        }
    }
}

/// Palette indices and weights of a vertex, without zero weights.
fn weighty(mesh: &Mesh, vertex: usize) -> impl Iterator<Item = (u16, f32)> + '_ {
    let at = vertex * mesh.influences..(vertex + 1) * mesh.influences;
    let pairs = mesh.binding_indices[at.clone()]
        .iter()
        .zip(&mesh.weights[at]);
    pairs.map(|(i, w)| (*i, *w)).filter(|(_, w)| *w != 0.0)
}

/// Palette index with the greatest weight, the first of equal ones.
fn heaviest(mesh: &Mesh, vertex: usize) -> Option<u16> {
    let pairs = weighty(mesh, vertex);
    let best = pairs.reduce(|a, b| if b.1 > a.1 { b } else { a });
    best.map(|(index, _)| index)
}

/// Vertices without influences collapse to the origin, as in the plain version.
fn skin_nowhere(vertices: &[[u32; LANES]], quads: &[Quad], out: &mut SkinnedMesh) {
    for (vertices, quad) in vertices.iter().zip(quads) {
        store(vertices, [Vec4::ZERO; 3], &mut out.positions);
        store(vertices, quad.normal, &mut out.normals);
    }
}

/// Palette, indices and weights of the vertices of one block.
struct Influences<'a> {
    palette: &'a [Matrix3x4],
    indices: &'a [u16],
    weights: &'a [f32],
}

impl Influences<'_> {
    fn skin<const K: usize>(
        &self,
        vertices: &[[u32; LANES]],
        quads: &[Quad],
        out: &mut SkinnedMesh,
    ) {
        let (indices, _) = self.indices.as_chunks::<K>().0.as_chunks::<LANES>();
        let (weights, _) = self.weights.as_chunks::<K>().0.as_chunks::<LANES>();
        let influences = indices.iter().zip(weights);
        for ((vertices, quad), (indices, weights)) in vertices.iter().zip(quads).zip(influences) {
            let [i, j, k, l] = indices;
            let [s, t, u, v] = weights;
            let blended = [
                self.blend(i, s),
                self.blend(j, t),
                self.blend(k, u),
                self.blend(l, v),
            ];
            quad.skin(blended, vertices, out);
        }
    }

    /// For numbers of influences without a kernel of their own.
    fn skin_many(
        &self,
        count: usize,
        vertices: &[[u32; LANES]],
        quads: &[Quad],
        out: &mut SkinnedMesh,
    ) {
        let indices = self.indices.chunks_exact(count * LANES);
        let influences = indices.zip(self.weights.chunks_exact(count * LANES));
        for ((vertices, quad), (indices, weights)) in vertices.iter().zip(quads).zip(influences) {
            let blended = [0, 1, 2, 3].map(|l| {
                let at = l * count..(l + 1) * count;
                self.blend(&indices[at.clone()], &weights[at])
            });
            quad.skin(blended, vertices, out);
        }
    }

    /// Rows of the weighted sum of matrices, added in the order of the plain version.
    #[inline(always)]
    fn blend(&self, indices: &[u16], weights: &[f32]) -> [Vec4; 3] {
        let mut sum = [Vec4::ZERO; 3];
        for (i, (index, weight)) in indices.iter().zip(weights).enumerate() {
            let rows = &self.palette[usize::from(*index)];
            for (sum, row) in sum.iter_mut().zip(rows) {
                let part = Vec4::from_array(*row) * *weight;
                *sum = if i == 0 { part } else { *sum + part };
            }
        }
        sum
    }
}

impl Quad {
    fn set(&mut self, lane: usize, position: Vec3, normal: Vec3) {
        for axis in 0..3 {
            self.position[axis][lane] = position[axis];
            self.normal[axis][lane] = normal[axis];
        }
    }

    #[inline(always)]
    fn add_weighted(&mut self, offsets: &Self, weight: f32) {
        for axis in 0..3 {
            self.position[axis] += offsets.position[axis] * weight;
            self.normal[axis] += offsets.normal[axis] * weight;
        }
    }

    /// Transforms four vertices, each by its own matrix; every lane performs the operations of
    /// [`crate::skin::skin`] for one vertex, in the same order.
    #[inline(always)]
    fn skin(&self, blended: [[Vec4; 3]; LANES], vertices: &[u32; LANES], out: &mut SkinnedMesh) {
        let [a, b, c, d] = blended;
        // Entries of one row of the four matrices, transposed to one lane per matrix.
        let row = |r: usize| Mat4::from_cols(a[r], b[r], c[r], d[r]).transpose();
        let [x, y, z] = [row(0), row(1), row(2)];
        let [px, py, pz] = self.position;
        let point = |m: &Mat4| m.x_axis * px + m.y_axis * py + m.z_axis * pz + m.w_axis;
        store(
            vertices,
            [point(&x), point(&y), point(&z)],
            &mut out.positions,
        );

        // Columns of the matrices, then of their cofactor matrices.
        let cx = [x.x_axis, y.x_axis, z.x_axis];
        let cy = [x.y_axis, y.y_axis, z.y_axis];
        let cz = [x.z_axis, y.z_axis, z.z_axis];
        let (ux, uy, uz) = (cross(cy, cz), cross(cz, cx), cross(cx, cy));
        let determinant = dot(cx, ux);
        let [nx, ny, nz] = self.normal;
        let turned = [0, 1, 2].map(|r| ux[r] * nx + uy[r] * ny + uz[r] * nz);
        // The sign of the determinant keeps normals pointing outwards under a mirror.
        let mirrored = determinant.cmplt(Vec4::ZERO);
        let squared = dot(turned, turned);
        let reciprocal = Vec4::ONE / squared.sqrt();
        let signed = Vec4::select(mirrored, -reciprocal, reciprocal);
        let mut normal = [turned[0] * signed, turned[1] * signed, turned[2] * signed];
        // One of the two is not finite if the length is 0, infinite or NaN.
        let known = (reciprocal + squared).is_finite_mask();
        if !known.all() {
            normal = [0, 1, 2].map(|r| Vec4::select(known, normal[r], self.normal[r]));
        }
        store(vertices, normal, &mut out.normals);
    }
}

#[inline(always)]
fn dot(a: [Vec4; 3], b: [Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [Vec4; 3], b: [Vec4; 3]) -> [Vec4; 3] {
    [
        a[1] * b[2] - b[1] * a[2],
        a[2] * b[0] - b[2] * a[0],
        a[0] * b[1] - b[0] * a[1],
    ]
}

/// Writes four lanes to their vertices; the index in unused lanes is out of range for every mesh.
#[inline(always)]
fn store(vertices: &[u32; LANES], lanes: [Vec4; 3], out: &mut [Vec3]) {
    let columns = Mat4::from_cols(lanes[0], lanes[1], lanes[2], Vec4::ZERO).transpose();
    let columns = [
        columns.x_axis,
        columns.y_axis,
        columns.z_axis,
        columns.w_axis,
    ];
    for (vertex, value) in vertices.iter().zip(columns) {
        if let Some(place) = out.get_mut(*vertex as usize) {
            *place = value.truncate();
        }
    }
}
