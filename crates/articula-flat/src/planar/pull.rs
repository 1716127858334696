//! Displacement of a corner by damped least squares, within walls.

use super::fan::{Fan, Wall};
use glam::Vec2;

/// Weight that keeps a corner at its position, relative to the two edge lines.
const DAMPING: f32 = 0.02;
/// Maximum number of walls of a corner.
const MAX_WALLS: usize = 2 * (1 + Fan::MAX_WALLS) + 1;
/// Distance beyond a wall that does not show, pixels.
const SLACK_PX: f32 = 0.02;

/// Damped least squares of a corner's displacement: weighted targets, each along a direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pull {
    sum: Vec2,
    /// The symmetric 2 x 2 matrix of the normal equations.
    xx: f32,
    xy: f32,
    yy: f32,
}

impl Default for Pull {
    fn default() -> Self {
        Self {
            sum: Vec2::ZERO,
            xx: DAMPING,
            xy: 0.0,
            yy: DAMPING,
        }
    }
}

impl Pull {
    pub(super) fn towards(&mut self, normal: Vec2, wanted: f32, stiffness: f32) {
        self.sum += normal * (stiffness * wanted);
        self.xx += stiffness * normal.x * normal.x;
        self.xy += stiffness * normal.x * normal.y;
        self.yy += stiffness * normal.y * normal.y;
    }

    fn solved(&self) -> Vec2 {
        // Never 0: the diagonal is at least the damping.
        let determinant = self.xx * self.yy - self.xy * self.xy;
        let x = self.yy * self.sum.x - self.xy * self.sum.y;
        let y = self.xx * self.sum.y - self.xy * self.sum.x;
        Vec2::new(x, y) / determinant
    }

    /// The displacement of least error that lies beyond no wall, shortened to a length; `excess`
    /// is how far one lies beyond a wall.
    pub(super) fn within(
        &self,
        furthest: f32,
        excess: impl Fn(Vec2) -> f32,
        walls: impl Iterator<Item = Wall>,
    ) -> Vec2 {
        let is_inside = |way: Vec2| excess(way) <= SLACK_PX;
        let free = self.solved().clamp_length_max(furthest);
        if is_inside(free) {
            return free;
        }
        let mut all = [Wall::default(); MAX_WALLS];
        let mut count = 0;
        for (slot, wall) in all.iter_mut().zip(walls) {
            *slot = wall;
            count += 1;
        }
        let mut best = (self.error(Vec2::ZERO), Vec2::ZERO);
        let mut offer = |way: Vec2| {
            let way = way.clamp_length_max(furthest);
            let error = self.error(way);
            if error < best.0 && way.is_finite() && is_inside(way) {
                best = (error, way);
            }
        };
        // The least error lies on a wall or where two meet.
        for (i, wall) in all[..count].iter().enumerate() {
            let (along, foot) = (wall.normal.perp(), wall.normal * wall.reach);
            let (slope, bend) = (self.slope(foot).dot(along), self.times(along).dot(along));
            offer(foot - along * (slope / bend));
            for other in &all[..i] {
                let across = wall.normal.perp_dot(other.normal);
                if across.abs() > 1e-3 {
                    let x = wall.reach * other.normal.y - other.reach * wall.normal.y;
                    let y = other.reach * wall.normal.x - wall.reach * other.normal.x;
                    offer(Vec2::new(x, y) / across);
                }
            }
        }
        best.1
    }

    /// The matrix times a vector.
    fn times(&self, v: Vec2) -> Vec2 {
        Vec2::new(self.xx * v.x + self.xy * v.y, self.xy * v.x + self.yy * v.y)
    }

    /// Half of the gradient of the error.
    fn slope(&self, way: Vec2) -> Vec2 {
        self.times(way) - self.sum
    }

    /// The error of a displacement, up to a constant.
    fn error(&self, way: Vec2) -> f32 {
        (self.times(way) - 2.0 * self.sum).dot(way)
    }
}
