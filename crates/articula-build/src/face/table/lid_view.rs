//! What is seen of an eye between its lids, from the front: where they are open, at rest and as they move.

use super::super::points::{FacePoints, FaceSurface, FrontGrid, FrontView, is_on_ball, regions};
use super::eye_shape::EyeShape;
use super::lid_parts::lid_parts;
use glam::{Vec2, Vec3};

/// Width of a cell, by height of the face: 0.1 mm on an average one.
const CELL: f32 = 7.4e-4;
/// Half the width of what is looked at, by height of the face, by the radius of an eyeball, and by the width
/// of an opening.
const HALF: f32 = 0.2;
const HALF_OF_BALL: f32 = 1.5;
const HALF_OF_WIDTH: f32 = 0.75;
/// Least depth of a socket behind the skin around it, by height of the face; that of its rim; and the depth
/// from which anything is inside of it.
const DEEP: f32 = 0.05;
const RIM: f32 = 0.04;
const INSIDE: f32 = 0.06;
/// Depth behind the middle of the eye from which a triangle is not of it, by height of the face.
const BEHIND: f32 = 0.3;
/// Least height of an opening, by height of the face.
const OPEN: f32 = 0.01;

/// Why the lids of an eye are not moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoLids {
    /// Nothing of an eyeball or a socket is seen between lids.
    NoOpening,
    /// What is around the opening is no lid: nothing of the skin ends at it.
    NoRim,
    /// The closed lids leave this much open, metres.
    Open(f32),
}

impl std::fmt::Display for NoLids {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoOpening => f.write_str(
                "no opening between the lids is seen: the eyes are painted, shut or behind the skin",
            ),
            Self::NoRim => f.write_str("no rim of a lid is found around the eye"),
            Self::Open(gap) => write!(f, "its lids would leave {:.1} mm open", 1e3 * gap),
        }
    }
}

/// An eye, and what is drawn of it.
pub(super) struct EyeView {
    /// Triangles of the skin around the eye, and of lids that are parts of their own.
    pub(super) lids: Vec<[u32; 3]>,
    ball: Vec<[u32; 3]>,
    grid: FrontGrid,
    /// Nothing behind this depth is drawn.
    behind: f32,
    socket: Option<Socket>,
    /// Height of the face, metres.
    pub(super) height: f32,
}

/// The inside of a socket without an eyeball.
struct Socket {
    /// Depth from which it is inside, metres.
    deep: f32,
    inside: f32,
    /// Triangles of the lids that are seen inside at rest.
    seen: Vec<bool>,
}

/// What is seen at a moment.
pub(super) struct Look {
    pub(super) skin: FrontView,
    /// Depths of the eyeball, if there is one.
    pub(super) ball: Option<Vec<f32>>,
    pub(super) is_open: Vec<bool>,
}

/// The opening of an eye at rest.
pub(super) struct Opening {
    pub(super) grid: FrontGrid,
    /// First column.
    pub(super) first: usize,
    /// Heights of the upper and the lower rim at each column.
    pub(super) rims: Vec<[f32; 2]>,
    /// Places at the upper and the lower rim, each with its triangle of the lids.
    pub(super) hits: [Vec<(usize, Vec3)>; 2],
    /// Vertices that are seen inside of a socket.
    pub(super) inside: Vec<u32>,
}

impl EyeView {
    /// The view of an eye with the opening at rest; `left` and `right` corners say how wide it may be.
    pub(super) fn of(
        surface: &FaceSurface,
        points: &FacePoints,
        eye: usize,
        shape: &EyeShape,
        corners: [Vec3; 2],
    ) -> Result<(Self, Opening), NoLids> {
        let height = points.height();
        let at = |v: u32| surface.positions[v as usize];
        let radius = shape.radius(Vec3::Y);
        let half = HALF * height;
        let half = half.max(HALF_OF_BALL * radius);
        let half = half.max(HALF_OF_WIDTH * corners[0].distance(corners[1]));
        let mut grid = FrontGrid::around(shape.centre.truncate(), half, CELL * height);
        grid.slack = 1e-3;
        let has_ball = points.eyeballs().is_some();
        let is_layer = |t: &[u32; 3]| has_ball && is_on_ball(&t.map(at), shape.centre, radius);
        let is_near = |t: &&[u32; 3]| {
            let places = t.map(at);
            let low = places.iter().fold(Vec3::INFINITY, |low, p| low.min(*p));
            let high = places
                .iter()
                .fold(Vec3::NEG_INFINITY, |high, p| high.max(*p));
            let least = grid.low;
            let most = grid.low + Vec2::splat(grid.step * grid.count as f32);
            high.truncate().cmpge(least).all()
                && low.truncate().cmple(most).all()
                && high.z > shape.centre.z - BEHIND * height
        };
        let lids = points.parts.skin.iter().filter(is_near).copied().collect();
        let ball: Vec<[u32; 3]> = match points.eyeballs() {
            Some(balls) => {
                let is_ball = |t: &&[u32; 3]| t.iter().all(|v| balls[eye].binary_search(v).is_ok());
                surface.triangles.iter().filter(is_ball).copied().collect()
            }
            None => Vec::new(),
        };
        let mut view = Self {
            lids,
            ball,
            grid,
            behind: if has_ball {
                shape.centre.z
            } else {
                f32::NEG_INFINITY
            },
            socket: None,
            height,
        };
        let (look, region) = view.at_rest(&at).or_else(|none| {
            // The skin may have a layer on the eyeball, such as a shell that paints the shadow of the lids.
            let all = view.lids.len();
            view.lids.retain(|t| !is_layer(t));
            if view.lids.len() == all {
                return Err(none);
            }
            view.at_rest(&at)
        })?;
        let seen = (grid, look.ball.as_deref());
        let parts = lid_parts(surface, points, shape, seen, &region);
        if parts.is_empty() {
            let opening = view.opening(&look, &region, &at);
            return Ok((view, opening?));
        }
        view.lids.extend(parts);
        let (look, region) = view.at_rest(&at)?;
        let opening = view.opening(&look, &region, &at);
        Ok((view, opening?))
    }

    /// What is seen at rest, and the cells of the opening; learns what is inside of a socket.
    fn at_rest(&mut self, at: &impl Fn(u32) -> Vec3) -> Result<(Look, Vec<usize>), NoLids> {
        self.socket = None;
        let look = self.look(at);
        let region = regions(&look.is_open, self.grid.count).into_iter().next();
        let region = region.ok_or(NoLids::NoOpening)?;
        if self.ball.is_empty() {
            let mut seen = vec![false; self.lids.len()];
            let triangles = region.iter().map(|cell| look.skin.triangles[*cell]);
            for triangle in triangles {
                if let Some(seen) = seen.get_mut(triangle as usize) {
                    *seen = true;
                }
            }
            self.socket = Some(Socket {
                deep: RIM * self.height,
                inside: INSIDE * self.height,
                seen,
            });
        }
        Ok((look, region))
    }

    /// What is seen with the vertices at some places.
    pub(super) fn look(&self, at: &impl Fn(u32) -> Vec3) -> Look {
        let drawn = |triangles: &[[u32; 3]]| {
            let corners = triangles.iter().map(|t| t.map(at));
            FrontView::of(self.grid, corners, self.behind)
        };
        let skin = drawn(&self.lids);
        if !self.ball.is_empty() {
            let ball = drawn(&self.ball).depths;
            let is_open = ball.iter().zip(&skin.depths).map(|(b, s)| b > s).collect();
            return Look {
                skin,
                ball: Some(ball),
                is_open,
            };
        }
        let is_open = match &self.socket {
            None => skin.deeper(DEEP * self.height),
            Some(socket) => {
                let is_deep = skin.deeper(socket.deep);
                let is_inside = skin.deeper(socket.inside);
                let was_seen = |t: &u32| socket.seen.get(*t as usize).copied().unwrap_or(true);
                let cells = is_deep.into_iter().zip(is_inside).zip(&skin.triangles);
                cells
                    .map(|((deep, inside), t)| inside || (deep && was_seen(t)))
                    .collect()
            }
        };
        Look {
            skin,
            ball: None,
            is_open,
        }
    }

    /// The column at a place, which may be outside of the view.
    pub(super) fn column(&self, x: f32) -> f32 {
        self.grid.column(x)
    }

    fn opening(
        &self,
        look: &Look,
        region: &[usize],
        at: &impl Fn(u32) -> Vec3,
    ) -> Result<Opening, NoLids> {
        let count = self.grid.count;
        let mut rows: Vec<Option<[usize; 2]>> = vec![None; count];
        for cell in region {
            let (column, row) = (cell % count, cell / count);
            let [top, bottom] = rows[column].unwrap_or([row, row]);
            rows[column] = Some([top.max(row), bottom.min(row)]);
        }
        let first = rows
            .iter()
            .position(Option::is_some)
            .ok_or(NoLids::NoOpening)?;
        let rows: Vec<[usize; 2]> = rows.into_iter().flatten().collect();
        let mut hits = [Vec::new(), Vec::new()];
        for (column, ends) in rows.iter().enumerate() {
            let beside = [Some(ends[0] + 1), ends[1].checked_sub(1)];
            for (hits, row) in hits.iter_mut().zip(beside) {
                let Some(row) = row.filter(|row| *row < count) else {
                    continue;
                };
                let cell = row * count + first + column;
                let triangle = look.skin.triangles[cell] as usize;
                if triangle < self.lids.len() {
                    let place = self.grid.place(cell).extend(look.skin.depths[cell]);
                    hits.push((triangle, place));
                }
            }
        }
        let y = |row: usize, beside: f32| self.grid.low.y + (row as f32 + beside) * self.grid.step;
        let rims: Vec<[f32; 2]> = rows
            .iter()
            .map(|[t, b]| [y(*t, 0.5), y(*b, -0.5)])
            .collect();
        let most = rims
            .iter()
            .map(|[top, bottom]| top - bottom)
            .fold(0.0, f32::max);
        if most < OPEN * self.height {
            return Err(NoLids::NoOpening);
        }
        if hits.iter().any(|hits| 4 * hits.len() < rims.len()) {
            return Err(NoLids::NoRim);
        }
        let inside = match &self.socket {
            Some(_) => self.seen_inside(look, at),
            None => Vec::new(),
        };
        Ok(Opening {
            grid: self.grid,
            first,
            rims,
            hits,
            inside,
        })
    }

    /// Vertices that are seen inside of a socket.
    fn seen_inside(&self, look: &Look, at: &impl Fn(u32) -> Vec3) -> Vec<u32> {
        let near = 5.0 * self.grid.step;
        let is_seen = |v: &u32| {
            let place = at(*v);
            let cell = self.grid.cell(place.truncate());
            cell.is_some_and(|c| look.is_open[c] && place.z > look.skin.depths[c] - near)
        };
        let socket = self.socket.iter().flat_map(|s| &s.seen);
        let triangles = self.lids.iter().zip(socket).filter(|(_, seen)| **seen);
        let mut inside: Vec<u32> = triangles.flat_map(|(t, _)| *t).filter(is_seen).collect();
        inside.sort_unstable();
        inside.dedup();
        inside
    }
}
