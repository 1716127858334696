//! Points by which the skin of a face is moved.

use super::super::points::FacePoints;
use articula_core::feature_points::PointId;
use glam::Vec3;

/// A point that the skin follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Handle {
    pub(super) what: HandleKind,
    /// Vertex of the skin.
    pub(super) vertex: u32,
    /// Its place at rest.
    pub(super) place: Vec3,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum HandleKind {
    /// A feature point that moves.
    Moving(PointId),
    /// Part of the rim of a lid: its middle, and how far to the corner it is, in hundredths.
    Rim(PointId, u8),
    /// A feature point that rests.
    Resting,
}

impl HandleKind {
    /// The middle of the lid that the handle is of.
    pub(super) fn lid(self) -> Option<PointId> {
        match self {
            Self::Moving(point) | Self::Rim(point, _) if point.0 == 3 => Some(point),
            _ => None,
        }
    }
}

/// Feature points that parameters move, and 2.11 to 2.14, which follow the jaw.
const MOVING: [PointId; 43] = [
    (2, 1),
    (2, 2),
    (2, 3),
    (2, 4),
    (2, 5),
    (2, 6),
    (2, 7),
    (2, 8),
    (2, 9),
    (2, 10),
    (2, 11),
    (2, 12),
    (2, 13),
    (2, 14),
    (3, 1),
    (3, 2),
    (3, 3),
    (3, 4),
    (4, 1),
    (4, 2),
    (4, 3),
    (4, 4),
    (4, 5),
    (4, 6),
    (5, 1),
    (5, 2),
    (5, 3),
    (5, 4),
    (8, 1),
    (8, 2),
    (8, 3),
    (8, 4),
    (8, 5),
    (8, 6),
    (8, 7),
    (8, 8),
    (9, 1),
    (9, 2),
    (9, 3),
    (10, 1),
    (10, 2),
    (10, 3),
    (10, 4),
];
const RESTING: [PointId; 15] = [
    (3, 7),
    (3, 8),
    (3, 11),
    (3, 12),
    (9, 6),
    (9, 7),
    (9, 12),
    (10, 7),
    (10, 8),
    (10, 9),
    (10, 10),
    (11, 1),
    (11, 2),
    (11, 3),
    (11, 4),
];
/// Middle of each lid and its two corners.
const LIDS: [(PointId, [PointId; 2]); 4] = [
    ((3, 1), [(3, 7), (3, 11)]),
    ((3, 3), [(3, 7), (3, 11)]),
    ((3, 2), [(3, 8), (3, 12)]),
    ((3, 4), [(3, 8), (3, 12)]),
];
/// Places of further handles between the middle of a lid and its corner, in hundredths.
const RIM: [u8; 2] = [35, 68];

/// The handles of a face: no two at one vertex, the first of them is kept.
pub(super) fn handles(
    points: &FacePoints,
    rim: impl Fn(PointId, Vec3) -> Option<u32>,
    at: impl Fn(u32) -> Vec3,
) -> Vec<Handle> {
    let mut found: Vec<Handle> = Vec::new();
    let mut add = |what: HandleKind, vertex: Option<u32>| {
        if let Some(vertex) = vertex.filter(|v| !found.iter().any(|h| h.vertex == *v)) {
            let place = at(vertex);
            found.push(Handle {
                what,
                vertex,
                place,
            });
        }
    };
    let vertex = |point: PointId| points.get(point)?.vertex;
    for point in MOVING {
        add(HandleKind::Moving(point), vertex(point));
    }
    for point in RESTING {
        add(HandleKind::Resting, vertex(point));
    }
    let place = |point: PointId| points.get(point).map_or(Vec3::ZERO, |p| p.place);
    for (middle, corners) in LIDS {
        for corner in corners {
            for part in RIM {
                let along = f32::from(part) / 100.0;
                // The rim bulges: at this share of the way it is still near the height of the middle.
                let (a, b) = (place(middle), place(corner));
                let bulge = Vec3::new(
                    a.x + along * (b.x - a.x),
                    a.y + along * along * (b.y - a.y),
                    a.z + along * (b.z - a.z),
                );
                add(HandleKind::Rim(middle, part), rim(middle, bulge));
            }
        }
    }
    found
}
