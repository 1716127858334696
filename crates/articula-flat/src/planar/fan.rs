//! Triangles around the end of an edge, which bound how far a corner may move across the edge.

use super::clip::PlanarClip;
use super::neighbours::{Neighbour, Neighbours, outward};
use glam::Vec2;

/// Maximum number of triangles of a fan; a corner does not move past more.
const MAX_STEPS: usize = 6;

/// How far a corner may stick out at a silhouette, and over an earlier triangle of another colour,
/// without being seen; pixels.
const OUTSIDE_PX: f32 = 0.4;
const FOREIGN_PX: f32 = 0.6;

/// Angle of the triangles around a corner below which it is a tip.
const TIP_RADIANS: f32 = 2.6;

/// A line that a corner may cross by `reach`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Wall {
    pub(super) normal: Vec2,
    pub(super) reach: f32,
}

impl Wall {
    /// How far a displacement lies beyond the wall; negative on this side.
    pub(super) fn excess(&self, way: Vec2) -> f32 {
        self.normal.dot(way) - self.reach
    }
}

/// A triangle of a fan.
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    /// The edge from the corner to the next triangle of the fan.
    next: Wall,
    /// The edge opposite of the corner.
    far: Wall,
}

/// Triangles around the end of an edge, from the neighbour across the edge on.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Fan {
    steps: [Step; MAX_STEPS],
    len: usize,
    /// Direction of the last edge from the corner; zero without triangles, or if they reach half a
    /// turn away from the first edge.
    end: Vec2,
    is_half_turn: bool,
    /// How far one may be painted over that lies behind the first triangle.
    behind: f32,
}

impl Fan {
    /// Maximum number of walls.
    pub(super) const MAX_WALLS: usize = 2 * MAX_STEPS;

    /// Walks from the neighbour across an edge around the edge's start or end.
    ///
    /// `share` returns how much of a triangle may be painted over, 0 to 1, given its vertex at the
    /// corner; `None` if it is not drawn.
    pub(super) fn new(
        (clip, neighbours): (&PlanarClip, &Neighbours),
        frame: usize,
        first: Neighbour,
        at_start: bool,
        share: impl Fn(Neighbour, u32) -> Option<f32>,
    ) -> Self {
        let mut fan = Self::default();
        let edge = {
            let places = clip.places(frame, first.triangle as usize);
            -outward(&places, (first.apex as usize + 1) % 3)
        };
        let mut at = Some(first);
        while let Some(n) = at.filter(|_| fan.len < MAX_STEPS) {
            let (triangle, apex) = (n.triangle as usize, n.apex as usize);
            let places = clip.places(frame, triangle);
            // The neighbour has the opposite direction: its edge to the apex begins at the start.
            let (corner, next, far) = if at_start {
                ((apex + 2) % 3, (apex + 2) % 3, apex)
            } else {
                ((apex + 1) % 3, apex, (apex + 2) % 3)
            };
            // The triangle across an edge that may be painted over most, and how far.
            let beyond = |edge: usize| {
                let mut best = (OUTSIDE_PX, None);
                for n in neighbours.across(triangle, edge) {
                    let height = n.height(clip, frame, (triangle, edge));
                    if height <= 0.0 {
                        continue;
                    }
                    let at_corner = if at_start { n.apex + 2 } else { n.apex + 1 };
                    let corners = clip.triangles[n.triangle as usize];
                    let reach = share(*n, corners[at_corner as usize % 3]).map_or(0.0, |share| {
                        height.min((height * share).max(FOREIGN_PX)).max(OUTSIDE_PX)
                    });
                    if reach > best.0 {
                        best = (reach, Some(*n));
                    }
                }
                best
            };
            let (reach, across) = beyond(next);
            let normal = outward(&places, far);
            let height = normal.dot(places[far] - places[corner]).max(0.0);
            let beyond_far = beyond(far).0;
            if fan.len == 0 {
                fan.behind = reach.max(beyond_far);
            }
            fan.steps[fan.len] = Step {
                next: Wall {
                    normal: outward(&places, next),
                    reach,
                },
                far: Wall {
                    normal,
                    reach: height + beyond_far,
                },
            };
            fan.len += 1;
            // Half a turn away from the edge, all that lies across it is within the fan.
            let along = places[apex] - places[corner];
            fan.end = along.normalize_or_zero();
            if fan.len > 1 && edge.dot(along) <= 0.0 {
                fan.steps[fan.len - 1].next.reach = f32::MAX;
                fan.is_half_turn = true;
                break;
            }
            at = across.filter(|n| n.triangle != first.triangle);
        }
        fan
    }

    /// How far a triangle may be painted over that lies behind the first one.
    pub(super) fn beyond_first(&self) -> f32 {
        (self.behind - OUTSIDE_PX).max(0.0)
    }

    /// Keeps a corner from sticking out of the triangles around it, from those of one fan to those of
    /// another, if they fill less than half a turn; `own` are the directions of the corner's edges,
    /// where a fan is empty.
    pub(super) fn tip(fans: [&Self; 2], own: [Vec2; 2]) -> Option<Wall> {
        if fans.iter().any(|fan| fan.is_half_turn) {
            return None;
        }
        let end = |i: usize| if fans[i].len > 0 { fans[i].end } else { own[i] };
        let (from, to) = (end(0), end(1));
        let angles = [
            from.angle_to(own[0]).abs(),
            own[0].angle_to(own[1]).abs(),
            own[1].angle_to(to).abs(),
        ];
        let is_tip = angles.iter().sum::<f32>() < TIP_RADIANS;
        is_tip.then(|| Wall {
            normal: -(from + to).normalize_or_zero(),
            reach: OUTSIDE_PX,
        })
    }

    /// All walls of the fan.
    pub(super) fn walls(&self) -> impl Iterator<Item = Wall> {
        let steps = self.steps[..self.len].iter();
        let all = steps.flat_map(|step| [step.next, step.far]);
        all.filter(|wall| wall.reach < f32::MAX)
    }

    /// How far a displacement across the fan's first edge lies outside of it.
    pub(super) fn excess(&self, way: Vec2) -> f32 {
        let mut most: f32 = 0.0;
        for step in &self.steps[..self.len] {
            most = most.max(step.next.excess(way)).max(step.far.excess(way));
            if step.next.normal.dot(way) <= 0.0 {
                break;
            }
        }
        most
    }
}
