//! One level of one part in the form that the compared codecs receive: the same whole numbers that
//! Articula's codec codes.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8. Position 14 bits, texture coordinates 12 bits,
//! four influences whose weights are bytes that sum to 255, in order of increasing joint, which
//! Draco and meshoptimizer code in fewer bytes than in order of decreasing weight. Each codec gets
//! the rounded direction of a normal and rounds it to the same number of bits in its own octahedral
//! form.

use anyhow::{Result, ensure};
use articula_stream::mesh::{Precision, Quantised, restore};
use glam::Vec3;

/// Bits to which all values are rounded.
pub(crate) const PRECISION: Precision = Precision {
    position_bits: 14,
    normal_bits: 10,
    texcoord_bits: 12,
};

/// Influences of a vertex.
const INFLUENCES: usize = 4;

/// Distinct vertices and their triangles. Without morph targets, which neither codec supports.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct WireMesh {
    pub(crate) positions: Vec<[u16; 3]>,
    /// Empty if the part has none, as are the following fields.
    pub(crate) normals: Vec<Vec3>,
    pub(crate) texcoords: Vec<[u16; 2]>,
    /// Empty also if all are equal and thus a factor of the material.
    pub(crate) colors: Vec<[u8; 4]>,
    /// Empty also if all vertices follow a single joint, as a node does.
    pub(crate) joints: Vec<[u16; 4]>,
    pub(crate) weights: Vec<[u8; 4]>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl WireMesh {
    /// One level of a part; `finest` determines which kinds of values the part has.
    pub(crate) fn new(part: &Quantised, level: usize) -> Result<Self> {
        let mesh = &part.levels[level];
        let points = || mesh.wedge_points.iter().map(|p| *p as usize);
        let mut wire = Self {
            positions: points()
                .map(|p| mesh.positions[p].map(|x| x as u16))
                .collect(),
            normals: restore(mesh, &part.layout, &part.scale).normals,
            triangles: mesh.faces.clone(),
            ..Self::default()
        };
        let texcoords = mesh.texcoords.iter();
        wire.texcoords = texcoords.map(|t| t.map(|x| x as u16)).collect();
        if differ(part, |m| m.colors.as_slice()) {
            wire.colors.clone_from(&mesh.colors);
        }
        if differ(part, |m| m.skins.as_slice()) {
            for skin in points().map(|p| &mesh.skins[p]) {
                ensure!(skin.len() <= INFLUENCES, "{} influences", skin.len());
                let mut skin = skin.clone();
                skin.sort_unstable();
                skin.resize(INFLUENCES, (0, 0));
                wire.joints.push(std::array::from_fn(|i| skin[i].0));
                wire.weights.push(std::array::from_fn(|i| skin[i].1));
            }
        }
        Ok(wire)
    }

    pub(crate) fn vertices(&self) -> usize {
        self.positions.len()
    }
}

/// Whether any two values of the finest level differ.
fn differ<T: PartialEq>(
    part: &Quantised,
    values: impl Fn(&articula_stream::mesh::QuantisedMesh) -> &[T],
) -> bool {
    let finest = part.levels.last();
    finest.is_some_and(|m| values(m).windows(2).any(|pair| pair[0] != pair[1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::Primitive;
    use articula_stream::mesh::{Grid, quantise};

    #[test]
    fn a_part_on_one_joint_has_no_joints_and_unused_vertices_are_left_out() {
        let mut part = Primitive {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X, Vec3::splat(9.0)],
            influences: 1,
            joints: vec![2; 5],
            weights: vec![1.0; 5],
            ..Primitive::default()
        };
        let grid = Grid::new(std::slice::from_ref(&part), PRECISION.position_bits).unwrap();
        let levels = [vec![[0, 1, 2], [2, 3, 0]]];
        let wire = |part: &Primitive| {
            WireMesh::new(&quantise(part, &levels, &grid, &PRECISION).unwrap(), 0).unwrap()
        };
        let rigid = wire(&part);
        assert_eq!(rigid.vertices(), 3);
        assert!(
            rigid.positions.contains(&[1820, 0, 0]),
            "16383 / 9, rounded"
        );
        assert!(rigid.joints.is_empty() && rigid.normals.is_empty() && rigid.colors.is_empty());
        part.joints[2] = 1;
        assert_eq!(wire(&part).joints.iter().filter(|j| j[0] == 1).count(), 1);
    }
}
