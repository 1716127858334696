//! The last of the way: closed lids are looked at from the front, and moved until nothing of the eye is seen.

use super::super::unfold::SkinFolds;
use super::lid_view::{EyeView, Look, NoLids};
use super::lids::EyeLids;
use glam::Vec3;

/// Number of times that the closed eye is looked at.
const LOOKS: usize = 12;
/// Looks after which the upper lid goes farther, instead of the lower one coming up to it.
const BY_LOWER: usize = 5;
/// Cells that may stay open for the lids to count as meeting.
const MEET: usize = 1;
/// Cells up to which an opening that stays is no reason not to move the lids: 0.3 mm on an average face.
const MOST: usize = 3;
/// Cells that may be open after triangles that were turned over are smoothed.
const UNFOLDED: usize = 2;
/// Depth behind the surface of an eyeball up to which skin is not beside a gap, but has gone into it, by height
/// of the face.
const POKED: f32 = 0.02;
/// Distance by which it then comes forward, by height of the face.
const CLEAR: f32 = 7e-4;

/// What the closed lids leave open.
struct Left {
    /// Most open cells above each other, in each column.
    columns: Vec<usize>,
    /// Triangles of the lids behind the eyeball, and how far.
    poked: Vec<(usize, f32)>,
}

impl EyeLids {
    /// Corrects the closed lids until they meet; `joined` has the first vertex of the same place for each vertex.
    ///
    /// # Errors
    /// [`NoLids::Open`] if more stays open than one would see.
    pub(super) fn close_fully(
        &mut self,
        view: &EyeView,
        positions: &[Vec3],
        joined: &[u32],
    ) -> Result<(), NoLids> {
        let corrected = |lids: &Self| (lids.heights.more.clone(), lids.vertices.clone());
        let (mut least, mut best) = (usize::MAX, corrected(self));
        for look in 0..LOOKS {
            let left = self.left(view, positions);
            let open = most(&left);
            if open < least {
                (least, best) = (open, corrected(self));
            }
            if open <= MEET {
                break;
            }
            self.come_forward(view, &left);
            let first = view.column(self.heights.low);
            self.go_farther(
                usize::from(look < BY_LOWER),
                &left.columns,
                first,
                positions,
            );
        }
        (self.heights.more, self.vertices) = best;
        if least > MOST {
            return Err(NoLids::Open(least as f32 * self.heights.step));
        }
        let folded = self.vertices.clone();
        self.unfold(view, positions, joined);
        if most(&self.left(view, positions)) > least.max(UNFOLDED) {
            self.vertices = folded;
        }
        Ok(())
    }

    /// Smooths the closed lids where they turn triangles over.
    fn unfold(&mut self, view: &EyeView, positions: &[Vec3], joined: &[u32]) {
        let folds = SkinFolds::of_triangles(positions.to_vec(), joined.to_vec(), &view.lids);
        let closed = self.closed(positions);
        let mut unfolded = closed.clone();
        folds.unfold(&mut unfolded);
        for lid in &mut self.vertices {
            let v = lid.vertex as usize;
            lid.more += unfolded[v] - closed[v];
        }
    }

    /// How the lids move to close the eye.
    fn closed(&self, positions: &[Vec3]) -> Vec<Vec3> {
        let mut moved = vec![Vec3::ZERO; positions.len()];
        self.move_lids([1.0, 0.0], positions, &mut moved);
        self.push_out(positions, &mut moved);
        moved
    }

    /// What the closed lids leave open.
    fn left(&self, view: &EyeView, positions: &[Vec3]) -> Left {
        let moved = self.closed(positions);
        let at = |v: u32| positions[v as usize] + moved[v as usize];
        let look = view.look(&at);
        Left {
            columns: tallest(&look),
            poked: poked(&look, POKED * view.height),
        }
    }

    /// Brings triangles that are behind the eyeball in front of it.
    fn come_forward(&mut self, view: &EyeView, left: &Left) {
        for (triangle, depth) in &left.poked {
            for vertex in view.lids[*triangle] {
                if let Ok(index) = self.vertices.binary_search_by_key(&vertex, |v| v.vertex) {
                    let forward = &mut self.vertices[index].more.z;
                    *forward = forward.max(depth + CLEAR * view.height);
                }
            }
        }
    }

    /// Adds what is open to the way of one lid, at the places of its vertices; `first` is the column of the first step.
    fn go_farther(&mut self, side: usize, open: &[usize], first: f32, positions: &[Vec3]) {
        let step = self.heights.step;
        let of_rim = self
            .vertices
            .iter()
            .filter(|v| v.side() == side && v.is_rim);
        let steps = self.heights.more[side].len();
        let mut knots: Vec<f32> = of_rim
            .map(|v| (positions[v.vertex as usize].x - self.heights.low) / step)
            .filter(|at| (0.0..steps as f32).contains(at))
            .collect();
        knots.extend([0.0, steps as f32 - 1.0]);
        knots.sort_by(f32::total_cmp);
        knots.dedup();
        // The most that is open at a knot or, for the upper lid, up to the knots beside it.
        let most = |index: usize| {
            if index == 0 || index + 1 == knots.len() {
                return 0.0;
            }
            let [low, high] = match side {
                0 => [knots[index - 1], knots[index + 1]],
                _ => [knots[index] - 1.5, knots[index] + 1.5],
            };
            let columns = (low + first).ceil().max(0.0) as usize..=(high + first).max(0.0) as usize;
            let open = columns.filter_map(|column| open.get(column));
            step * open.copied().max().unwrap_or(0) as f32
        };
        let values: Vec<f32> = (0..knots.len()).map(most).collect();
        for (index, more) in self.heights.more[side].iter_mut().enumerate() {
            let at = index as f32;
            let after = knots.partition_point(|k| *k < at).clamp(1, knots.len() - 1);
            let (a, b) = (knots[after - 1], knots[after]);
            let t = ((at - a) / (b - a).max(1e-6)).clamp(0.0, 1.0);
            *more += values[after - 1] + t * (values[after] - values[after - 1]);
        }
    }
}

/// The most open cells above each other.
fn most(left: &Left) -> usize {
    left.columns.iter().copied().max().unwrap_or(0)
}

/// The most open cells above each other, in each column.
fn tallest(look: &Look) -> Vec<usize> {
    let count = look.skin.grid.count;
    let column = |column: usize| {
        let (mut most, mut now) = (0, 0);
        for row in 0..count {
            now = if look.is_open[row * count + column] {
                now + 1
            } else {
                0
            };
            most = most.max(now);
        }
        most
    };
    (0..count).map(column).collect()
}

/// Triangles that are behind the eyeball, but not far.
fn poked(look: &Look, depth: f32) -> Vec<(usize, f32)> {
    let Some(ball) = &look.ball else {
        return Vec::new();
    };
    let cells = ball.iter().zip(&look.skin.depths).zip(&look.skin.triangles);
    let behind = cells.map(|((ball, skin), triangle)| (*triangle as usize, ball - skin));
    behind.filter(|(_, d)| *d > 0.0 && *d < depth).collect()
}

#[cfg(test)]
mod tests {
    use super::super::super::points::{FaceParts, FacePoint, FacePoints, FaceSurface, PointSource};
    use super::super::eye_shape::EyeShape;
    use super::super::lids::LidInput;
    use super::super::mirror::Mirror;
    use super::*;
    use articula_core::feature_points::FEATURE_POINTS;
    use glam::Vec2;

    const RADIUS: f32 = 0.012;
    const WIDE: f32 = 0.011;

    /// Heights of the rims of an almond 22 mm wide; they meet at its corners.
    fn rims(x: f32) -> [f32; 2] {
        let open = (1.0 - (x / WIDE).powi(2)).max(0.0);
        [0.006 * open, -0.004 * open]
    }

    /// A wall before two eyeballs with an almond in it for each, in strips of some width; the left one at 32 mm.
    fn face(strip: f32, open: f32) -> (FaceSurface, FacePoints) {
        let mut surface = FaceSurface::default();
        let mut skin = Vec::new();
        let columns = (0.03 / strip).round() as i32;
        for side in [1.0, -1.0] {
            let middle = Vec3::new(0.032 * side, 0.0, 0.0);
            for (lid, up) in [(0, 1.0), (1, -1.0)] {
                let first = surface.positions.len() as u32;
                for column in -columns..=columns {
                    let x = column as f32 * strip;
                    let rim = open * rims(x)[lid];
                    for row in 0..=12 {
                        let t = row as f32 / 12.0;
                        let y = rim + t * (0.03 * up - rim);
                        surface
                            .positions
                            .push(middle + Vec3::new(x, y, RADIUS + 0.001));
                    }
                }
                for column in 0..2 * columns as u32 {
                    for row in 0..12 {
                        let a = first + column * 13 + row;
                        let [b, c, d] = [a + 13, a + 14, a + 1];
                        skin.extend([[a, b, c], [a, c, d]]);
                    }
                }
            }
        }
        let skin_vertices: Vec<u32> = (0..surface.positions.len() as u32).collect();
        surface.triangles = skin.clone();
        let balls = [1.0, -1.0].map(|side| {
            let centre = Vec3::new(0.032 * side, 0.0, 0.0);
            (ball(&mut surface, centre), centre)
        });
        let joined = surface.joined();
        let place = |point| match point {
            (4, 1 | 2) => Vec3::new(0.0, 0.03, 0.0),
            (2, 1) => Vec3::new(0.0, -0.09, 0.0),
            (3, 7) => Vec3::new(0.032 + WIDE, 0.0, RADIUS),
            (3, 11) => Vec3::new(0.032 - WIDE, 0.0, RADIUS),
            (3, 8) => Vec3::new(-0.032 + WIDE, 0.0, RADIUS),
            (3, 12) => Vec3::new(-0.032 - WIDE, 0.0, RADIUS),
            _ => Vec3::ZERO,
        };
        let points = FEATURE_POINTS.iter().map(|entry| FacePoint {
            point: entry.point,
            place: place(entry.point),
            vertex: None,
            source: PointSource::Given,
            confidence: 1.0,
        });
        let points = FacePoints {
            points: points.collect(),
            dropped: Vec::new(),
            seen: Vec::new(),
            parts: FaceParts {
                joined,
                skin,
                skin_vertices,
                eyeballs: Some(balls),
                others: Vec::new(),
            },
        };
        (surface, points)
    }

    /// Adds a ball; returns its vertices.
    fn ball(surface: &mut FaceSurface, centre: Vec3) -> Vec<u32> {
        const ROUND: u32 = 32;
        let first = surface.positions.len() as u32;
        for row in 0..=ROUND {
            for column in 0..=ROUND {
                let (sin, cos) = (std::f32::consts::PI * row as f32 / ROUND as f32).sin_cos();
                let (a, b) = (std::f32::consts::TAU * column as f32 / ROUND as f32).sin_cos();
                let at = RADIUS * Vec3::new(sin * a, cos, sin * b);
                surface.positions.push(centre + at);
            }
        }
        for row in 0..ROUND {
            for column in 0..ROUND {
                let a = first + row * (ROUND + 1) + column;
                let b = a + ROUND + 1;
                surface.triangles.extend([[a, b, a + 1], [a + 1, b, b + 1]]);
            }
        }
        (first..surface.positions.len() as u32).collect()
    }

    fn lids(surface: &FaceSurface, points: &FacePoints) -> [Result<EyeLids, NoLids>; 2] {
        let balls = points.parts.eyeballs.as_ref().unwrap();
        let shape = |eye: usize| {
            let (vertices, centre) = &balls[eye];
            let places = vertices.iter().map(|v| surface.positions[*v as usize]);
            EyeShape::new(*centre, places)
        };
        EyeLids::of(&LidInput {
            surface,
            points,
            mirror: &Mirror::of(&surface.positions, &points.parts.joined, 0.0),
            vertices: &points.parts.skin_vertices,
            followers: &[],
            height: points.height(),
            eyes: [0, 1].map(shape),
            closed: 0.01,
        })
    }

    /// Whether any triangle of the skin is before the ball at a place, by looking at each.
    fn is_covered(at: &[Vec3], skin: &[[u32; 3]], place: Vec2, ball: f32) -> bool {
        skin.iter().any(|t| {
            let [a, b, c] = t.map(|v| at[v as usize]);
            let [p, ab, ac] = [place - a.truncate(), (b - a).truncate(), (c - a).truncate()];
            let area = ab.perp_dot(ac);
            let (u, v) = (p.perp_dot(ac) / area, ab.perp_dot(p) / area);
            let is_inside = area != 0.0 && u >= -1e-3 && v >= -1e-3 && u + v <= 1.001;
            is_inside && a.z + u * (b.z - a.z) + v * (c.z - a.z) > ball
        })
    }

    #[test]
    fn closed_lids_leave_nothing_open() {
        // Fine lids, and coarse ones, whose rims have corners at other places than the almond.
        for strip in [0.001, 0.004] {
            let (surface, points) = face(strip, 1.0);
            for (eye, side) in [(0, 1.0), (1, -1.0)] {
                let lids = lids(&surface, &points);
                let lids = lids[eye].as_ref().unwrap();
                let mut moved = vec![Vec3::ZERO; surface.positions.len()];
                lids.move_lids([1.0, 0.0], &surface.positions, &mut moved);
                lids.push_out(&surface.positions, &mut moved);
                let pairs = surface.positions.iter().zip(&moved);
                let at: Vec<Vec3> = pairs.map(|(p, d)| *p + *d).collect();
                for column in -6..=6 {
                    let x = column as f32 * 1.7e-3;
                    let open = |row: &i32| {
                        let y = *row as f32 * 1e-4;
                        let ball = (RADIUS.powi(2) - x * x - y * y).max(0.0).sqrt();
                        let place = Vec2::new(0.032 * side + x, y);
                        !is_covered(&at, &points.parts.skin, place, ball)
                    };
                    let count = (-70..=70).filter(open).count();
                    assert!(count <= 3, "{strip}, eye {eye}: {count} open at {x}");
                }
            }
        }
    }

    #[test]
    fn lids_that_are_shut_are_not_moved() {
        let (surface, points) = face(0.002, 0.0);
        for lids in lids(&surface, &points) {
            assert_eq!(lids, Err(NoLids::NoOpening));
        }
    }
}
