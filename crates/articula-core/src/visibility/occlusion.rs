//! Estimate of how much of a body is hidden behind others, for callers without a renderer to query.
//!
//! Source: `docs/methods/motion-lod.md` part 5. An engine may supply occluded fractions from its
//! renderer; this module computes them as software occlusion buffers do. Capsules that lie *inside*
//! the nearest bodies are drawn into a small depth grid, and the boxes of the other bodies are
//! tested against it. The test is conservative on both sides: a cell counts as covered only if one
//! capsule covers all of it, at the farthest depth of that capsule, and a box is tested by its
//! screen rectangle at its nearest depth. So only a body that cannot be visible has fraction 1.
//!
//! A test costs as much as evaluating a few joints, so it pays for bodies that are expensive to
//! evaluate or to draw, in dense crowds; showing far ones at a coarse level is cheaper than testing
//! them.
//!
//! A body is never hidden by its own capsules, since these lie behind the front of its box. Draw
//! bodies where they are in this frame, not in the last one; otherwise a body that comes into view
//! appears late.

use super::frustum::Tangents;
use crate::Mismatch;
use crate::capsule::Capsule;
use crate::motion_bounds::Bound;
use crate::view::Camera;
use glam::{Mat3, Quat, Vec2, Vec3, Vec4};
use std::ops::Range;

/// Depth in metres; capsules and boxes nearer to the eye hide nothing and are not hidden.
const NEAR_METRES: f32 = 0.05;

/// Margin for rounding, as a fraction of a cell.
const ROUNDING_CELLS: f32 = 1e-3;

/// Cells on each side of a block.
const BLOCK: usize = 8;

/// Length of the steps by which a box is drawn, and their greatest number.
const PIECE_METRES: f32 = 1.0;
const PIECES: usize = 32;

/// Points on the half circle around each end of a capsule.
const ARC: [(f32, f32); 5] = {
    const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;
    [
        (0.0, -1.0),
        (HALF, -HALF),
        (1.0, 0.0),
        (HALF, HALF),
        (0.0, 1.0),
    ]
};

/// What is hidden of the bodies in a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoxOcclusion {
    /// Nothing of any body in it.
    Nothing,
    /// Perhaps some; each body has a fraction of its own.
    Some,
    /// Every body in it, wholly.
    All,
}

/// The part of a grid in front of a box.
enum Reach {
    /// The box is outside the picture.
    Nowhere,
    /// The box reaches the eye or is not finite.
    Eye,
    Cells(Rectangle),
}

/// Cells in front of a box, and its depths with a margin for rounding.
struct Rectangle {
    columns: Range<usize>,
    rows: Range<usize>,
    nearest: f32,
    farthest: f32,
}

/// Depth grid of one camera, into which occluders are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Occlusion {
    columns: usize,
    rows: usize,
    /// For each cell, row by row from the top, the depth behind which all of it is hidden.
    depths: Vec<f32>,
    /// The least of these depths in each square block of cells, row by row.
    block_depths: Vec<f32>,
    eye: Vec3,
    /// Axes: right, up, depth.
    camera_from_world: Mat3,
    /// Half of the extent of a horizontal disc of radius 1 along these axes.
    disc: Vec3,
    /// Cells per unit of tangent, to the right and down, and the cell position of the viewing
    /// direction.
    cells: Vec2,
    middle: Vec2,
}

impl Occlusion {
    /// Makes an empty grid; 160 by 90 cells suit a crowd in full HD.
    ///
    /// # Errors
    /// A [`Mismatch`] if a side has no cell or more than 4096.
    pub fn new(columns: usize, rows: usize) -> Result<Self, Mismatch> {
        for (at, cells) in [("columns", columns), ("rows", rows)] {
            if !(1..=4096).contains(&cells) {
                return Err(Mismatch::new(at, format!("{cells}, expected 1 to 4096")));
            }
        }
        Ok(Self {
            columns,
            rows,
            depths: vec![f32::INFINITY; columns * rows],
            block_depths: vec![f32::INFINITY; columns.div_ceil(BLOCK) * rows.div_ceil(BLOCK)],
            eye: Vec3::ZERO,
            camera_from_world: Mat3::IDENTITY,
            disc: Vec3::new(1.0, 0.0, 1.0),
            cells: Vec2::ONE,
            middle: Vec2::ZERO,
        })
    }

    /// Begins a frame of a camera, with nothing hidden.
    pub fn begin(&mut self, camera: &Camera) {
        let tangents = Tangents::of(&camera.viewport);
        self.begin_off_axis(camera.eye, camera.orientation, tangents);
    }

    /// Begins a frame of a picture that need not be centred, such as that of an eye of a headset;
    /// the orientation is world from camera, looking along -Z. An invalid camera hides nothing.
    pub fn begin_off_axis(&mut self, eye: Vec3, orientation: Quat, tangents: Tangents) {
        self.depths.fill(f32::INFINITY);
        self.block_depths.fill(f32::INFINITY);
        self.eye = eye;
        let back = Mat3::from_diagonal(Vec3::new(1.0, 1.0, -1.0));
        self.camera_from_world = back * Mat3::from_quat(orientation.conjugate());
        let up = self.camera_from_world.y_axis;
        let spread = (Vec3::ONE - up * up).max(Vec3::ZERO);
        self.disc = Vec3::new(spread.x.sqrt(), spread.y.sqrt(), spread.z.sqrt());
        let size = Vec2::new(tangents.left + tangents.right, tangents.up + tangents.down);
        self.cells = Vec2::new(self.columns as f32, self.rows as f32) / size;
        self.middle = Vec2::new(tangents.left, tangents.up) * self.cells;
    }

    /// Draws a capsule, in world space, that lies inside something opaque. Does not allocate.
    pub fn draw(&mut self, capsule: &Capsule) {
        let radius = capsule.radius;
        let [a, b] = capsule.ends.map(|end| self.view(end));
        let nearest = a.z.min(b.z) - radius;
        if !(nearest >= NEAR_METRES && radius > 0.0 && (a + b).is_finite()) {
            return;
        }
        // Two half circles that face the eye, joined by straight lines from one end to the other.
        let toward = (a + b).normalize();
        let along = (b - a).reject_from_normalized(toward);
        let along = along
            .try_normalize()
            .unwrap_or_else(|| toward.any_orthonormal_vector());
        let across = toward.cross(along);
        let mut outline = [Vec2::ZERO; 2 * ARC.len()];
        let mut farthest = 0.0f32;
        for (i, at) in outline.iter_mut().enumerate() {
            let (end, sign) = if i < ARC.len() { (a, -1.0) } else { (b, 1.0) };
            let (out, side) = ARC[i % ARC.len()];
            let point = end + radius * sign * (out * along + side * across);
            farthest = farthest.max(point.z);
            *at = self.middle + Vec2::new(point.x, -point.y) / point.z * self.cells;
        }
        self.fill(&outline, farthest);
    }

    /// Draws a box, in world space, that is opaque: a wall or a house. Its half size is along its own
    /// axes, and `rotation` is world from box. Does not allocate.
    ///
    /// A long box is drawn in overlapping pieces, each at its own farthest depth, so that a wall that is
    /// seen from its end hides what is behind its near part.
    pub fn draw_box(&mut self, centre: Vec3, half_size: Vec3, rotation: Quat) {
        if !(half_size.cmpge(Vec3::ZERO).all() && half_size.is_finite()) {
            return;
        }
        let along = half_size.max_position();
        let length = 2.0 * half_size[along];
        let steps = ((length / PIECE_METRES).ceil().max(1.0) as usize).min(PIECES);
        let step = length / steps as f32;
        // Each piece is two steps long, or the whole.
        let mut half = half_size;
        half[along] = step.min(half_size[along]);
        for piece in 0..steps.max(2) - 1 {
            let mut middle = Vec3::ZERO;
            if steps > 1 {
                middle[along] = (piece + 1) as f32 * step - half_size[along];
            }
            self.draw_piece(centre + rotation * middle, half, rotation);
        }
    }

    fn draw_piece(&mut self, centre: Vec3, half: Vec3, rotation: Quat) {
        let (mut corners, mut farthest) = ([Vec2::ZERO; 8], 0.0f32);
        for (i, corner) in corners.iter_mut().enumerate() {
            let sign = |axis: usize| if i >> axis & 1 == 0 { -1.0 } else { 1.0 };
            let offset = half * Vec3::new(sign(0), sign(1), sign(2));
            let point = self.view(centre + rotation * offset);
            if !(point.z >= NEAR_METRES && point.is_finite()) {
                return;
            }
            farthest = farthest.max(point.z);
            *corner = self.middle + Vec2::new(point.x, -point.y) / point.z * self.cells;
        }
        let (outline, count) = hull(corners);
        self.fill(&outline[..count], farthest);
    }

    /// Whether nothing that was drawn in this frame hides anything. O(cells).
    pub fn is_empty(&self) -> bool {
        let mut depths = self.block_depths.iter();
        depths.all(|depth| *depth == f32::INFINITY)
    }

    /// Returns the occluded fraction of a body, 0 to 1: the part of the cells of its screen
    /// rectangle that is hidden. 1 only if no point of its box is visible; 0 if the box is outside
    /// the picture, reaches the eye or is not finite. `bound` is in model space; does not allocate.
    pub fn occluded(&self, bound: &Bound, position: Vec3, rotation: Quat, scale: f32) -> f32 {
        let centre = 0.5 * (bound.least + bound.greatest);
        let half = (0.5 * scale) * (bound.greatest - bound.least);
        let world_from_model = Mat3::from_quat(rotation);
        let middle = position + world_from_model * (centre * scale);
        match self.rectangle(middle, half, world_from_model) {
            Reach::Cells(rectangle) => self.hidden_part(&rectangle),
            Reach::Nowhere | Reach::Eye => 0.0,
        }
    }

    /// Returns the occluded fraction of a body within an upright cylinder of the world, as
    /// [`occluded`](Self::occluded) at a third of its cost: `foot` lies on the axis, which is +Y, and
    /// `heights` are least and greatest above it. Does not allocate.
    pub fn occluded_upright(&self, foot: Vec3, radius: f32, heights: [f32; 2]) -> f32 {
        match self.upright(foot, radius, heights) {
            Reach::Cells(rectangle) => self.hidden_part(&rectangle),
            Reach::Nowhere | Reach::Eye => 0.0,
        }
    }

    /// Cells and depths of an upright cylinder.
    #[inline]
    fn upright(&self, foot: Vec3, radius: f32, heights: [f32; 2]) -> Reach {
        let foot = self.view(foot);
        let axis = self.camera_from_world.y_axis;
        let spread = self.disc * radius;
        // The box around each end, at its near and at its far face.
        let ends = Vec4::new(heights[0], heights[0], heights[1], heights[1]);
        let faces = Vec4::new(-spread.z, spread.z, -spread.z, spread.z);
        let depths = foot.z + axis.z * ends + faces;
        let nearest = depths.min_element();
        if !(nearest >= NEAR_METRES && foot.is_finite() && spread.is_finite()) {
            return Reach::Eye;
        }
        let scales = 1.0 / depths;
        let range = |middle: Vec4, side: f32, cells: f32, centre: f32, most: usize| {
            let least = ((middle - side) * scales).min_element();
            let greatest = ((middle + side) * scales).max_element();
            let least = least * cells + centre - ROUNDING_CELLS;
            let greatest = greatest * cells + centre + ROUNDING_CELLS;
            // A cast truncates towards zero and saturates.
            least as usize..((greatest + 1.0) as usize).min(most)
        };
        let (x, y) = (foot.x + axis.x * ends, -(foot.y + axis.y * ends));
        let columns = range(x, spread.x, self.cells.x, self.middle.x, self.columns);
        let rows = range(y, spread.y, self.cells.y, self.middle.y, self.rows);
        if columns.is_empty() || rows.is_empty() {
            return Reach::Nowhere;
        }
        Reach::Cells(Rectangle {
            columns,
            rows,
            nearest: nearest * (1.0 - 1e-5),
            farthest: depths.max_element(),
        })
    }

    /// Returns what of an axis-aligned box of the world is hidden, so that bodies in it need not be tested
    /// one by one. Does not allocate.
    pub fn occluded_box(&self, least: Vec3, greatest: Vec3) -> BoxOcclusion {
        let (middle, half) = (0.5 * (least + greatest), 0.5 * (greatest - least));
        match self.rectangle(middle, half, Mat3::IDENTITY) {
            Reach::Nowhere => BoxOcclusion::Nothing,
            Reach::Eye => BoxOcclusion::Some,
            Reach::Cells(rectangle) if !self.may_hide(&rectangle, rectangle.farthest) => {
                BoxOcclusion::Nothing
            }
            Reach::Cells(rectangle) => {
                let mut rows = self.rows_of(&rectangle);
                match rows.all(|row| row.iter().all(|depth| *depth <= rectangle.nearest)) {
                    true => BoxOcclusion::All,
                    false => BoxOcclusion::Some,
                }
            }
        }
    }

    /// The part of the cells of a rectangle that hide everything behind its nearest depth.
    fn hidden_part(&self, rectangle: &Rectangle) -> f32 {
        let nearest = rectangle.nearest;
        if !self.may_hide(rectangle, nearest) {
            return 0.0;
        }
        let rows = self.rows_of(rectangle);
        let hidden = rows.map(|row| row.iter().filter(|depth| **depth <= nearest).count());
        let hidden: usize = hidden.sum();
        hidden as f32 / (rectangle.columns.len() * rectangle.rows.len()) as f32
    }

    /// The cells of a rectangle, row by row.
    fn rows_of(&self, rectangle: &Rectangle) -> impl Iterator<Item = &[f32]> {
        let Rectangle { columns, rows, .. } = rectangle;
        let of_rows = &self.depths[rows.start * self.columns..rows.end * self.columns];
        let rows = of_rows.chunks_exact(self.columns);
        rows.map(|row| &row[columns.clone()])
    }

    /// Whether a cell in the blocks of a rectangle hides something behind a depth.
    fn may_hide(&self, rectangle: &Rectangle, depth: f32) -> bool {
        let blocks = |cells: &Range<usize>| cells.start / BLOCK..cells.end.div_ceil(BLOCK);
        let across = self.columns.div_ceil(BLOCK);
        let columns = blocks(&rectangle.columns);
        let mut rows = blocks(&rectangle.rows).map(|row| row * across);
        rows.any(|row| {
            let blocks = &self.block_depths[row + columns.start..row + columns.end];
            blocks.iter().any(|least| *least <= depth)
        })
    }

    /// Cells and depths of a box around a point of the world, with its half size and rotation.
    fn rectangle(&self, middle: Vec3, half: Vec3, world_from_box: Mat3) -> Reach {
        let middle = self.view(middle);
        let turned = self.camera_from_world * world_from_box;
        let (x, y, z) = (
            turned.x_axis * half.x,
            turned.y_axis * half.y,
            turned.z_axis * half.z,
        );
        // Four corners by the signs of x and y, on both sides of z.
        let (sx, sy) = (
            Vec4::new(1.0, -1.0, 1.0, -1.0),
            Vec4::new(1.0, 1.0, -1.0, -1.0),
        );
        let corner = |m: f32, x: f32, y: f32, z: f32| {
            let four = m + sx * x + sy * y;
            [four + z, four - z]
        };
        let xs = corner(middle.x, x.x, y.x, z.x);
        let ys = corner(middle.y, x.y, y.y, z.y);
        let depths = corner(middle.z, x.z, y.z, z.z);
        let nearest = depths[0].min(depths[1]).min_element();
        if !(nearest >= NEAR_METRES && middle.is_finite()) {
            return Reach::Eye;
        }
        let scales = depths.map(|depths| 1.0 / depths);
        let range = |values: [Vec4; 2], cells: f32, middle: f32, most: usize| {
            let at = [0, 1].map(|i| values[i] * scales[i] * cells + middle);
            let least = at[0].min(at[1]).min_element() - ROUNDING_CELLS;
            let greatest = at[0].max(at[1]).max_element() + ROUNDING_CELLS;
            // A cast truncates towards zero and saturates.
            least as usize..((greatest + 1.0) as usize).min(most)
        };
        let columns = range(xs, self.cells.x, self.middle.x, self.columns);
        let rows = range(ys, -self.cells.y, self.middle.y, self.rows);
        if columns.is_empty() || rows.is_empty() {
            return Reach::Nowhere;
        }
        Reach::Cells(Rectangle {
            columns,
            rows,
            nearest: nearest * (1.0 - 1e-5),
            farthest: depths[0].max(depths[1]).max_element(),
        })
    }

    /// Right, up and depth of a point of the world.
    fn view(&self, point: Vec3) -> Vec3 {
        self.camera_from_world * (point - self.eye)
    }

    /// Limits to `depth` every cell that is inside a closed line around points of a convex body.
    /// The line itself need not be convex: between any two points of the body there is body, so a
    /// cell is inside if its upper and its lower border are.
    fn fill(&mut self, outline: &[Vec2], depth: f32) {
        let (mut top, mut bottom) = (f32::INFINITY, f32::NEG_INFINITY);
        for p in outline {
            top = top.min(p.y);
            bottom = bottom.max(p.y);
        }
        let first = (top + ROUNDING_CELLS).ceil().max(0.0) as usize;
        let last = ((bottom - ROUNDING_CELLS).floor().max(0.0) as usize).min(self.rows);
        let mut above = crossing(outline, first as f32);
        for row in first..last {
            let below = crossing(outline, (row + 1) as f32);
            let left = above.0.max(below.0) + ROUNDING_CELLS;
            let right = above.1.min(below.1) - ROUNDING_CELLS;
            above = below;
            let left = left.ceil().max(0.0) as usize;
            let right = (right.floor().max(0.0) as usize).min(self.columns);
            if left < right {
                let cells = row * self.columns;
                for cell in &mut self.depths[cells + left..cells + right] {
                    *cell = cell.min(depth);
                }
                let blocks = row / BLOCK * self.columns.div_ceil(BLOCK);
                let (left, right) = (left / BLOCK, right.div_ceil(BLOCK));
                for block in &mut self.block_depths[blocks + left..blocks + right] {
                    *block = block.min(depth);
                }
            }
        }
    }
}

/// The convex hull of the corners of a box in the picture, in order, and the number of its corners
/// (Andrew's monotone chain).
fn hull(mut corners: [Vec2; 8]) -> ([Vec2; 9], usize) {
    corners.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let (mut hull, mut count) = ([Vec2::ZERO; 9], 0);
    let mut add = |point: Vec2, floor: usize| {
        while count > floor + 1
            && (hull[count - 1] - hull[count - 2]).perp_dot(point - hull[count - 1]) <= 0.0
        {
            count -= 1;
        }
        hull[count] = point;
        count += 1;
        count
    };
    let mut lower = 0;
    for point in corners {
        lower = add(point, 0);
    }
    for point in corners.into_iter().rev().skip(1) {
        add(point, lower - 1);
    }
    // The first corner closes the line.
    (hull, count - 1)
}

/// The leftmost and the rightmost position at which a closed line crosses a height.
fn crossing(outline: &[Vec2], y: f32) -> (f32, f32) {
    let (mut left, mut right) = (f32::INFINITY, f32::NEG_INFINITY);
    let mut from = outline[outline.len() - 1];
    for &to in outline {
        if (from.y <= y) != (to.y <= y) {
            let x = from.x + (to.x - from.x) * ((y - from.y) / (to.y - from.y));
            left = left.min(x);
            right = right.max(x);
        }
        from = to;
    }
    (left, right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere::Sphere;
    use crate::view::Viewport;

    fn bound(half: Vec3) -> Bound {
        Bound {
            sphere: Sphere::from_corners(-half, half),
            least: -half,
            greatest: half,
        }
    }

    fn grid() -> Occlusion {
        let mut grid = Occlusion::new(160, 90).unwrap();
        grid.begin(&Camera::looking_at(
            Vec3::ZERO,
            Vec3::NEG_Z,
            Viewport::default(),
        ));
        grid
    }

    fn ball(centre: Vec3, radius: f32) -> Capsule {
        Capsule {
            ends: [centre; 2],
            radius,
        }
    }

    #[test]
    fn refuses_grids_of_no_size() {
        assert_eq!(Occlusion::new(0, 90).unwrap_err().at, "columns");
        assert_eq!(Occlusion::new(160, 5000).unwrap_err().at, "rows");
    }

    #[test]
    fn a_wall_of_a_man_by_hand() {
        let mut grid = grid();
        let cube = bound(Vec3::splat(0.5));
        let at = |grid: &Occlusion, p: Vec3| grid.occluded(&cube, p, Quat::IDENTITY, 1.0);
        let behind = Vec3::NEG_Z * 20.0;
        assert_eq!(at(&grid, behind), 0.0);
        assert!(grid.is_empty());
        grid.draw(&ball(Vec3::Z * 5.0, 1.0));
        assert!(grid.is_empty(), "behind the eye");
        // A ball of 1 m at 5 m spans 4 m at 20 m; a cube of 1 m is wholly behind it.
        grid.draw(&ball(Vec3::NEG_Z * 5.0, 1.0));
        assert_eq!(at(&grid, behind), 1.0);
        assert!(!grid.is_empty());
        assert_eq!(at(&grid, behind + Vec3::X * 5.0), 0.0, "beside it");
        let half = at(&grid, behind + Vec3::X * 4.0);
        assert!(half > 0.0 && half < 1.0, "{half} of it shows at the edge");
        assert_eq!(at(&grid, Vec3::NEG_Z * 2.0), 0.0, "in front of it");
        assert_eq!(at(&grid, Vec3::NEG_Z * 5.0), 0.0, "around it: itself");
        assert_eq!(at(&grid, Vec3::Z * 20.0), 0.0, "behind the eye");
        assert_eq!(
            at(&grid, Vec3::new(100.0, 0.0, -20.0)),
            0.0,
            "out of the picture"
        );
        grid.begin(&Camera::looking_at(
            Vec3::ZERO,
            Vec3::NEG_Z,
            Viewport::default(),
        ));
        assert_eq!(at(&grid, behind), 0.0, "a new frame");
    }

    #[test]
    fn two_halves_hide_as_one() {
        // Two bars, one above the other, overlap around a border between two rows of cells.
        let mut grid = grid();
        for side in [-1.0, 1.0] {
            let y = side * 0.9;
            grid.draw(&Capsule {
                ends: [Vec3::new(-3.0, y, -5.0), Vec3::new(3.0, y, -5.0)],
                radius: 0.95,
            });
        }
        let tall = bound(Vec3::new(0.5, 3.0, 0.5));
        assert_eq!(
            grid.occluded(&tall, Vec3::NEG_Z * 20.0, Quat::IDENTITY, 1.0),
            1.0
        );
    }

    #[test]
    fn the_outline_of_a_box_by_hand() {
        let of = |corners: [(f32, f32); 8]| {
            let (outline, count) = hull(corners.map(Vec2::from));
            outline[..count].to_vec()
        };
        // Seen from the front: four corners, each twice.
        let square = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)];
        let twice: Vec<(f32, f32)> = square.into_iter().chain(square).collect();
        let found = of(twice.try_into().unwrap());
        let expected = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(Vec2::from);
        assert_eq!(found, expected);
        // Seen at a corner: a hexagon, with two corners inside.
        let found = of([
            (0.0, 2.0),
            (1.7, 1.0),
            (1.7, -1.0),
            (0.0, -2.0),
            (-1.7, -1.0),
            (-1.7, 1.0),
            (0.0, 0.0),
            (0.0, 0.1),
        ]);
        assert_eq!(found.len(), 6);
        assert!(found.iter().all(|p| p.length() > 1.9));
        // A box of no size has no inside.
        assert!(of([(1.0, 0.0); 8]).len() < 3);
    }

    #[test]
    fn a_wall_hides_what_is_behind_it() {
        let cube = bound(Vec3::splat(0.5));
        let at = |grid: &Occlusion, p: Vec3| grid.occluded(&cube, p, Quat::IDENTITY, 1.0);
        let wall = Vec3::new(6.0, 1.5, 0.1);
        let mut grid = grid();
        grid.draw_box(Vec3::NEG_Z * 5.0, wall, Quat::IDENTITY);
        assert_eq!(at(&grid, Vec3::NEG_Z * 10.0), 1.0);
        assert_eq!(
            at(&grid, Vec3::new(8.0, 0.0, -10.0)),
            1.0,
            "its whole length"
        );
        assert_eq!(at(&grid, Vec3::new(0.0, 4.0, -10.0)), 0.0, "above it");
        assert_eq!(at(&grid, Vec3::NEG_Z * 3.0), 0.0, "in front of it");
        // From its end: 2 m beside the line of sight, from 4 m to 16 m. Its near part hides what
        // stands before its far end.
        let mut grid = self::grid();
        let quarter = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
        grid.draw_box(Vec3::new(2.0, 0.0, -10.0), wall, quarter);
        assert_eq!(at(&grid, Vec3::new(6.0, 0.0, -14.0)), 1.0);
        assert_eq!(at(&grid, Vec3::new(0.0, 0.0, -14.0)), 0.0, "on this side");
        for bad in [f32::NAN, f32::INFINITY, -1.0] {
            let mut grid = self::grid();
            grid.draw_box(Vec3::NEG_Z * 5.0, wall.with_x(bad), Quat::IDENTITY);
            assert_eq!(at(&grid, Vec3::NEG_Z * 10.0), 0.0, "{bad}");
        }
    }

    #[test]
    fn what_sticks_out_of_a_wall_is_not_hidden_by_it() {
        let mut grid = grid();
        for bar in -4..=4 {
            let y = 0.2 * bar as f32;
            grid.draw(&Capsule {
                ends: [Vec3::new(-3.0, y, -5.0), Vec3::new(3.0, y, -5.0)],
                radius: 0.2,
            });
        }
        let pole = bound(Vec3::new(0.05, 0.05, 3.0));
        let at = |z: f32| grid.occluded(&pole, Vec3::NEG_Z * z, Quat::IDENTITY, 1.0);
        assert_eq!(at(8.1), 1.0, "it begins behind the wall");
        assert_eq!(at(7.5), 0.0, "its tip may come through");
    }

    #[test]
    fn hostile_values_hide_nothing() {
        let cube = bound(Vec3::splat(0.5));
        let behind = Vec3::NEG_Z * 20.0;
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38] {
            let mut grid = grid();
            for capsule in [
                ball(Vec3::NEG_Z.with_x(bad), 1.0),
                ball(Vec3::NEG_Z * bad, 1.0),
                ball(Vec3::NEG_Z * 5.0, if bad == 3e38 { -1.0 } else { bad }),
                ball(Vec3::NEG_Z * 0.5, 1.0),
                Capsule {
                    ends: [Vec3::NEG_Z * 5.0, Vec3::Z * 5.0],
                    radius: 0.5,
                },
            ] {
                grid.draw(&capsule);
            }
            assert_eq!(
                grid.occluded(&cube, behind, Quat::IDENTITY, 1.0),
                0.0,
                "{bad}"
            );
            grid.draw(&ball(Vec3::NEG_Z * 5.0, 1.0));
            for (position, rotation, scale) in [
                (Vec3::splat(bad), Quat::IDENTITY, 1.0),
                (behind, Quat::from_xyzw(bad, 0.0, 0.0, 1.0), 1.0),
                (behind, Quat::IDENTITY, bad),
            ] {
                let hidden = grid.occluded(&cube, position, rotation, scale);
                assert_eq!(hidden, 0.0, "{position} {rotation} {scale}");
            }
            let mut odd = Camera::looking_at(Vec3::ZERO, Vec3::NEG_Z, Viewport::default());
            odd.viewport.fov_y_radians = if bad.is_finite() { 0.0 } else { bad };
            grid.begin(&odd);
            grid.draw(&ball(Vec3::NEG_Z * 5.0, 1.0));
            assert_eq!(grid.occluded(&cube, behind, Quat::IDENTITY, 1.0), 0.0);
        }
    }

    /// A body in an upright cylinder is as hidden as the box around that is, and never more.
    #[test]
    fn an_upright_body_is_tested_as_its_box() {
        for (pitch, yaw) in [(0.0, 0.0), (-0.4, 0.7), (0.3, -2.0), (-1.2, 0.1)] {
            let mut grid = Occlusion::new(160, 90).unwrap();
            let orientation = Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch);
            let camera = Camera {
                eye: Vec3::new(0.5, 3.0, -1.0),
                orientation,
                viewport: Viewport::default(),
            };
            grid.begin(&camera);
            let ahead = camera.eye + orientation * Vec3::new(0.3, 0.0, -6.0);
            grid.draw_box(ahead, Vec3::new(3.0, 2.0, 0.1), orientation);
            let mut wholly = 0;
            for (x, z) in (-10..10).flat_map(|x| (1..16).map(move |z| (x as f32, z as f32))) {
                let foot = camera.eye + orientation * Vec3::new(0.6 * x, -0.5, -1.5 * z);
                let (radius, heights) = (0.3, [-0.1, 1.7]);
                let upright = grid.occluded_upright(foot, radius, heights);
                // The box that touches the cylinder, turned about its axis, lies in any cylinder
                // through its corners.
                let mut of_box = 0.0_f32;
                for turn in 0..8 {
                    let side = radius * std::f32::consts::FRAC_1_SQRT_2;
                    let inner = Bound {
                        sphere: Sphere::default(),
                        least: Vec3::new(-side, heights[0], -side),
                        greatest: Vec3::new(side, heights[1], side),
                    };
                    let turn = Quat::from_rotation_y(turn as f32 * 0.2);
                    let inside = grid.occluded(&inner, foot, turn, 1.0);
                    of_box = if turn == Quat::IDENTITY {
                        inside
                    } else {
                        of_box.min(inside)
                    };
                    assert!(
                        upright < 1.0 || [0.0, 1.0].contains(&inside),
                        "{x} {z}: {inside}"
                    );
                }
                let outer = bound(Vec3::new(radius, 0.9, radius));
                let outer = grid.occluded(&outer, foot + Vec3::Y * 0.8, Quat::IDENTITY, 1.0);
                if outer == 1.0 {
                    wholly += 1;
                    // A box around the cylinder hides it, but for a picture that turns its corners
                    // towards the eye.
                    assert!(upright > 0.7, "{x} {z}: {upright}");
                }
            }
            assert!(wholly > 3, "pitch {pitch}: {wholly}");
        }
        let grid = grid();
        for odd in [f32::NAN, f32::INFINITY] {
            assert_eq!(grid.occluded_upright(Vec3::Z * -5.0, odd, [0.0, 1.0]), 0.0);
            assert_eq!(
                grid.occluded_upright(Vec3::splat(odd), 1.0, [0.0, 1.0]),
                0.0
            );
            assert_eq!(grid.occluded_upright(Vec3::Z * -5.0, 1.0, [0.0, odd]), 0.0);
        }
    }

    #[test]
    fn a_box_speaks_for_the_bodies_in_it() {
        let mut grid = grid();
        let wall = Vec3::new(3.0, 2.0, 0.1);
        grid.draw_box(Vec3::new(-2.0, 0.0, -8.0), wall, Quat::from_rotation_y(0.3));
        grid.draw(&ball(Vec3::new(5.0, 0.0, -12.0), 1.5));
        let body = bound(Vec3::new(0.3, 0.9, 0.3));
        let mut found = [0; 3];
        // Rows of five bodies, one metre apart, across the picture, in front of and behind both.
        for (row, depth) in (-20..20).flat_map(|x| (2..30).map(move |z| (x, z))) {
            let at = |i: usize| Vec3::new(row as f32 * 0.8 + i as f32, 0.0, -(depth as f32));
            let bodies = (0..5).map(|i| {
                let turn = Quat::from_rotation_y(i as f32);
                grid.occluded(&body, at(i), turn, 1.0)
            });
            let fractions: Vec<f32> = bodies.collect();
            // A turned body stays within its radius.
            let reach = Vec3::new(0.43, 0.9, 0.43);
            match grid.occluded_box(at(0) - reach, at(4) + reach) {
                BoxOcclusion::Nothing => {
                    found[0] += 1;
                    assert!(fractions.iter().all(|f| *f == 0.0), "{fractions:?}");
                }
                BoxOcclusion::Some => found[1] += 1,
                BoxOcclusion::All => {
                    found[2] += 1;
                    // Those outside of the picture are not in front of any cell.
                    assert!(
                        fractions.iter().all(|f| [0.0, 1.0].contains(f)),
                        "{fractions:?}"
                    );
                    assert!(fractions.contains(&1.0));
                }
            }
        }
        assert!(found.iter().all(|n| *n > 5), "{found:?}");
        let everywhere = Vec3::splat(1e3);
        assert_eq!(
            grid.occluded_box(-everywhere, everywhere),
            BoxOcclusion::Some
        );
        let behind = Vec3::new(0.0, 0.0, 50.0);
        assert_eq!(
            grid.occluded_box(behind, behind + 1.0),
            BoxOcclusion::Some,
            "at the eye"
        );
    }
}
