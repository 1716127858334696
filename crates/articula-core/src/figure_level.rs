//! A level of joints, mesh and influences that are shown together.

/// One level of a figure: joints, mesh level and influences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FigureLevel {
    /// Joint LOD that it was made from.
    pub joint_level: usize,
    /// Mesh level; 0 is the original.
    pub mesh_level: usize,
    /// Number of joints kept.
    pub joints: usize,
    /// Number of triangles drawn.
    pub triangles: usize,
    /// Number of vertices skinned for them.
    pub vertices: usize,
    /// Maximum number of influences of a vertex.
    pub influences: usize,
    /// Sum of joints, triangles, and influences of all vertices, each as a fraction of the full
    /// character's: 3 for the full character.
    pub cost: f32,
}
