//! Bytes and operations of a progressive mesh with the levels of a character.
//!
//! Source: H. Hoppe, "Progressive Meshes", SIGGRAPH 1996: the coarsest mesh, then a record for each
//! vertex split. The splits are those that undo the collapses of Articula's simplifier, one for each
//! position that the next coarser level does not have.

/// Bytes of an uncoded split without its vertices: the index of the vertex that is split, and two of
/// its edges among those around it.
const RECORD: usize = 4 + 2;

/// Bits by which Hoppe codes the two edges of a split.
const EDGE_BITS: u32 = 5;

/// One level of a part.
#[derive(Debug, Clone, Copy)]
pub(super) struct PartLevel {
    /// Number of positions.
    pub(super) points: usize,
    /// Number of vertices on a GPU.
    pub(super) vertices: usize,
    /// Bytes of the uncoded level.
    pub(super) plain: usize,
    /// Bytes of the coded level.
    pub(super) direct: usize,
}

/// Bytes of a progressive mesh.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Progressive {
    /// Uncoded: the coarsest level, the vertices that finer levels add, and the records.
    pub(super) plain: usize,
    /// Coded, a lower bound: the finest level alone in Articula's codec, and what the order of the
    /// splits costs.
    pub(super) coded: usize,
}

impl Progressive {
    /// Adds a part by its levels, coarsest first. `vertex_bytes` is the size of an uncoded vertex.
    pub(super) fn add(&mut self, levels: &[PartLevel], vertex_bytes: usize) {
        let [Some(coarsest), Some(finest)] = [levels.first(), levels.last()] else {
            return;
        };
        let added = finest.vertices - coarsest.vertices;
        let splits = finest.points - coarsest.points;
        self.plain += coarsest.plain + vertex_bytes * added + RECORD * splits;
        let bits: u64 = (coarsest.points..finest.points)
            .map(|vertices| u64::from(index_bits(vertices) + EDGE_BITS))
            .sum();
        self.coded += finest.direct + bits.div_ceil(8) as usize;
    }
}

/// Bits of the index of one of `count` vertices.
fn index_bits(count: usize) -> u32 {
    count.max(1).next_power_of_two().trailing_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_costs_its_coarsest_mesh_its_vertices_and_a_record_for_each_split() {
        assert_eq!([0, 1, 2, 3, 4, 5].map(index_bits), [0, 0, 1, 2, 2, 3]);
        let level = |points, vertices, plain, direct| PartLevel {
            points,
            vertices,
            plain,
            direct,
        };
        let levels = [
            level(4, 5, 100, 30),
            level(6, 8, 170, 44),
            level(7, 10, 230, 52),
        ];
        let mut found = Progressive::default();
        found.add(&levels, 20);
        // Five vertices and three splits: of 4, 5 and 6 vertices, with 2, 3 and 3 bits of index.
        assert_eq!(found.plain, 100 + 5 * 20 + 3 * 6);
        assert_eq!(found.coded, 52 + (2 + 3 + 3 + 3 * 5_usize).div_ceil(8));
        found.add(&[], 20);
        assert_eq!(found.plain, 218);
    }
}
