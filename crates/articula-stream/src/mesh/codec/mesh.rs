//! A mesh in the form that is coded: whole numbers, corners separated into points and wedges.
//!
//! Source: `docs/methods/clustered-mesh.md` parts 5 and 8.1. A *point* is a distinct position with
//! its skin and morph offsets. A *wedge* is a point with the values that may differ from face to
//! face (normal, texture coordinates, colour): the vertex of a GPU.

/// Kinds of values and their number of bits, common to all levels of an object.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Layout {
    /// Bits of each position coordinate, 1 to 20; one grid for all levels.
    pub position_bits: u8,
    /// Bits of each octahedral coordinate of a normal, 2 to 16; 0 without normals.
    pub normal_bits: u8,
    /// Bits of each texture coordinate, 1 to 20; 0 without texture coordinates.
    pub texcoord_bits: u8,
    /// Whether wedges have colours of four bytes.
    pub has_colors: bool,
    /// Number of joints of the skin; 0 without a skin.
    pub joints: u16,
    /// Layout of each morph target.
    pub morphs: Vec<MorphLayout>,
}

/// Values that a morph target changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MorphLayout {
    /// Whether it changes normals too.
    pub has_normals: bool,
}

/// One level of one object in whole numbers.
///
/// Points are distinct in (position, skin, morphs), wedges in (point, normal, texture coordinates,
/// colour, morph normals), faces up to rotation; no face uses a point twice. Lists of kinds that
/// the [`Layout`] does not have are empty.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct QuantisedMesh {
    /// Position of each point, each coordinate from 0 to 2^bits - 1.
    pub positions: Vec<[i32; 3]>,
    /// Skin of each point as (joint, weight), by falling weight, then rising joint; weights are 1
    /// to 255 with the sum 255, joints are distinct.
    pub skins: Vec<Vec<(u16, u8)>>,
    /// For each morph target the offset of each point, in steps of the position grid.
    pub morphs: Vec<Vec<[i32; 3]>>,
    /// Point of each wedge.
    pub wedge_points: Vec<u32>,
    /// Octahedral normal of each wedge, each coordinate from 0 to 2^bits - 1.
    pub normals: Vec<[i32; 2]>,
    /// Texture coordinates of each wedge, each from 0 to 2^bits - 1.
    pub texcoords: Vec<[i32; 2]>,
    /// Colour of each wedge.
    pub colors: Vec<[u8; 4]>,
    /// For each morph target the change of each wedge's normal, in 1/127; empty for a target
    /// without normals.
    pub morph_normals: Vec<Vec<[i32; 3]>>,
    /// Faces as counter-clockwise triples of wedges.
    pub faces: Vec<[u32; 3]>,
}

impl QuantisedMesh {
    /// Returns the number of points.
    pub(crate) fn points(&self) -> usize {
        self.positions.len()
    }

    /// Returns the number of wedges.
    pub(crate) fn wedges(&self) -> usize {
        self.wedge_points.len()
    }

    /// Returns the faces as triples of points.
    pub(super) fn point_faces(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let point = |w: u32| self.wedge_points[w as usize];
        self.faces.iter().map(move |f| f.map(point))
    }
}
