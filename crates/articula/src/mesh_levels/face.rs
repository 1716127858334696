//! What mesh levels keep of a face.
//!
//! Source: thesis 3.1.2 (figures 3.6 and 3.7): vertices of a face weigh more the further its
//! animation table moves them, and its feature points are never removed.

use crate::face::FoundFace;
use crate::figure::Figure;
use articula_build::face::{FacePoint, FaceTable, FapValues, PointSource};
use articula_core::fap_table::LOW_FAPS;
use articula_core::feature_points::PointId;

/// Parameters that move skin by displacements; eyeballs are turned as a whole.
const OF_EYEBALLS: std::ops::RangeInclusive<usize> = 23..=30;
/// Left corner of the lips: on a face without a mouth it can only be carried over from the template.
const CORNER: PointId = (2, 4);
/// Value at which the displacements of a parameter are compared; only their ratios count.
const VALUE: f32 = 256.0;

/// What every mesh level keeps of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptFace {
    /// Number of feature points that a vertex of the skin stands for.
    pub points: usize,
    /// These vertices, which no level removes, in the mesh of the figure; ascending, each once.
    pub vertices: Vec<u32>,
    /// How far the face animation table moves each vertex of the mesh, relative to the vertex that
    /// the same parameter moves furthest, 0 to 1. Empty where the face has morph targets, which
    /// count by themselves.
    pub extents: Vec<f32>,
}

impl KeptFace {
    /// That of a figure; `None` if its points may be wrong, or it shows no mouth.
    pub(super) fn of(figure: &Figure, face: &FoundFace) -> Option<Self> {
        let has_mouth = |point: &FacePoint| point.source != PointSource::Template;
        if !face.doubtful().is_empty() || !face.points.get(CORNER).is_some_and(has_mouth) {
            return None;
        }
        let of_figure = |vertex: u32| face.head.vertices[vertex as usize];
        let on_skin = face.points.points.iter().filter_map(|p| p.vertex);
        let mut vertices: Vec<u32> = on_skin.map(of_figure).collect();
        let points = vertices.len();
        vertices.sort_unstable();
        vertices.dedup();
        let extents = match has_morphs(figure, &vertices) {
            true => Vec::new(),
            false => extents(figure, face).unwrap_or_default(),
        };
        Some(Self {
            points,
            vertices,
            extents,
        })
    }
}

/// Whether morph targets of a figure move any of these vertices.
fn has_morphs(figure: &Figure, vertices: &[u32]) -> bool {
    let morphs = figure.asset.mesh.morphs.iter();
    let mut moved = morphs.flat_map(|m| &m.vertices);
    moved.any(|v| vertices.binary_search(v).is_ok())
}

/// How far the table moves each vertex of a figure; `None` without a table.
fn extents(figure: &Figure, face: &FoundFace) -> Option<Vec<f32>> {
    let mut extents = vec![0.0_f32; figure.asset.mesh.len()];
    let of_head = largest_shares(&face.table().ok()?);
    for (vertex, share) in face.head.vertices.iter().zip(of_head) {
        extents[*vertex as usize] = share;
    }
    Some(extents)
}

/// The largest displacement of each vertex over the parameters, each relative to its own largest.
fn largest_shares(table: &FaceTable) -> Vec<f32> {
    let mut shares = Vec::new();
    let of_skin = LOW_FAPS.filter(|fap| !OF_EYEBALLS.contains(fap) && table.moves(*fap));
    for fap in of_skin {
        let offsets = table.displacements(&FapValues::alone(fap, VALUE));
        let largest = offsets.iter().map(|o| o.length()).fold(0.0, f32::max);
        shares.resize(offsets.len(), 0.0_f32);
        if largest > 0.0 {
            for (share, offset) in shares.iter_mut().zip(&offsets) {
                *share = share.max(offset.length() / largest);
            }
        }
    }
    shares
}
