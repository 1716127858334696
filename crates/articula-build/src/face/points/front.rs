//! What is seen of triangles from the front, on a square grid.

use glam::{Vec2, Vec3};

/// Cells on each side of the middle at most: what is looked at may be of any size where points are wrong.
const MOST: f32 = 800.0;

/// No triangle.
pub(in crate::face) const NONE: u32 = u32::MAX;

/// A square grid of cells, seen along -Z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::face) struct FrontGrid {
    /// Middle of the first cell.
    pub(in crate::face) low: Vec2,
    pub(in crate::face) step: f32,
    /// Cells of a row, and rows.
    pub(in crate::face) count: usize,
    /// Part of a triangle by which it is taken as wider, so that no seam stays between two of them.
    pub(in crate::face) slack: f32,
}

/// The foremost depth of each cell, negative infinity where nothing is, and the index of its triangle.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::face) struct FrontView {
    pub(in crate::face) grid: FrontGrid,
    pub(in crate::face) depths: Vec<f32>,
    pub(in crate::face) triangles: Vec<u32>,
}

impl FrontGrid {
    /// A grid around a place, even on both sides of it, with this half width at least. Cells are larger than `step` where
    /// there would be more than 1601 in a row.
    pub(in crate::face) fn around(middle: Vec2, half: f32, step: f32) -> Self {
        let step = step.max(half / MOST);
        let half = (half / step).ceil().min(MOST);
        Self {
            low: middle - half * step,
            step,
            count: 2 * half as usize + 1,
            slack: 0.0,
        }
    }

    /// Middle of a cell.
    pub(in crate::face) fn place(&self, cell: usize) -> Vec2 {
        let at = Vec2::new((cell % self.count) as f32, (cell / self.count) as f32);
        self.low + self.step * at
    }

    /// The column at a place, which may be outside of the grid.
    pub(in crate::face) fn column(&self, x: f32) -> f32 {
        (x - self.low.x) / self.step
    }

    /// The cell at a place.
    pub(in crate::face) fn cell(&self, place: Vec2) -> Option<usize> {
        let at = ((place - self.low) / self.step).round();
        let inside = at.min_element() >= 0.0 && at.max_element() < self.count as f32;
        inside.then(|| at.y as usize * self.count + at.x as usize)
    }

    /// Calls `draw` with the index and the depth of each cell whose middle is inside a triangle.
    pub(in crate::face) fn raster(&self, corners: [Vec3; 3], mut draw: impl FnMut(usize, f32)) {
        let [a, b, c] = corners;
        let [fa, fb, fc] = corners.map(|p| (p.truncate() - self.low) / self.step);
        let area = (fb - fa).perp_dot(fc - fa);
        if area.abs() < 1e-9 {
            return;
        }
        let least = fa.min(fb).min(fc).ceil().max(Vec2::ZERO);
        let most = fa.max(fb).max(fc).floor();
        let most = most.min(Vec2::splat(self.count as f32 - 1.0));
        let mut p = least;
        while p.y <= most.y {
            p.x = least.x;
            while p.x <= most.x {
                let wb = (p - fa).perp_dot(fc - fa) / area;
                let wc = (fb - fa).perp_dot(p - fa) / area;
                if wb >= -self.slack && wc >= -self.slack && wb + wc <= 1.0 + self.slack {
                    let cell = p.y as usize * self.count + p.x as usize;
                    draw(cell, a.z + wb * (b.z - a.z) + wc * (c.z - a.z));
                }
                p.x += 1.0;
            }
            p.y += 1.0;
        }
    }
}

impl FrontView {
    /// What is seen of triangles, in front of a depth.
    pub(in crate::face) fn of(
        grid: FrontGrid,
        triangles: impl Iterator<Item = [Vec3; 3]>,
        behind: f32,
    ) -> Self {
        let cells = grid.count * grid.count;
        let mut view = Self {
            grid,
            depths: vec![f32::NEG_INFINITY; cells],
            triangles: vec![NONE; cells],
        };
        for (index, corners) in triangles.enumerate() {
            grid.raster(corners, |cell, z| {
                if z > behind && z > view.depths[cell] {
                    view.depths[cell] = z;
                    view.triangles[cell] = index as u32;
                }
            });
        }
        view
    }

    /// For each cell the least of the foremost depths above it, below it, to its left and to its right:
    /// how far in front of it all that surrounds it is.
    pub(in crate::face) fn surrounding(&self) -> Vec<f32> {
        let count = self.grid.count;
        let mut least = vec![f32::INFINITY; self.depths.len()];
        for line in 0..count {
            let row: Vec<usize> = (0..count).map(|i| line * count + i).collect();
            let column: Vec<usize> = (0..count).map(|i| i * count + line).collect();
            for cells in [row, column] {
                self.foremost_before(cells.iter(), &mut least);
                self.foremost_before(cells.iter().rev(), &mut least);
            }
        }
        least
    }

    fn foremost_before<'a>(&self, cells: impl Iterator<Item = &'a usize>, least: &mut [f32]) {
        let mut foremost = f32::NEG_INFINITY;
        for cell in cells {
            least[*cell] = least[*cell].min(foremost);
            foremost = foremost.max(self.depths[*cell]);
        }
    }

    /// Cells that are deeper than this behind all that surrounds them; a hole is deeper than anything.
    pub(in crate::face) fn deeper(&self, deep: f32) -> Vec<bool> {
        let around = self.surrounding().into_iter();
        let pairs = around.zip(&self.depths);
        pairs
            .map(|(around, depth)| around.is_finite() && around - depth > deep)
            .collect()
    }
}

/// Connected regions of a square grid, the largest first.
pub(in crate::face) fn regions(is_open: &[bool], count: usize) -> Vec<Vec<usize>> {
    let mut seen = vec![false; is_open.len()];
    let mut all: Vec<Vec<usize>> = Vec::new();
    for start in 0..is_open.len() {
        if !is_open[start] || seen[start] {
            continue;
        }
        let mut region = vec![start];
        seen[start] = true;
        let mut next = 0;
        while next < region.len() {
            let cell = region[next];
            next += 1;
            let (column, row) = (cell % count, cell / count);
            let beside = [
                (column > 0).then(|| cell - 1),
                (column + 1 < count).then(|| cell + 1),
                (row > 0).then(|| cell - count),
                (row + 1 < count).then(|| cell + count),
            ];
            for other in beside.into_iter().flatten() {
                if is_open[other] && !seen[other] {
                    seen[other] = true;
                    region.push(other);
                }
            }
        }
        all.push(region);
    }
    // The first of equal ones stays the first.
    all.sort_by_key(|region| std::cmp::Reverse(region.len()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(z: f32, [left, right]: [f32; 2], [low, high]: [f32; 2]) -> [[Vec3; 3]; 2] {
        let at = |x: f32, y: f32| Vec3::new(x, y, z);
        let [a, b, c, d] = [
            at(left, low),
            at(right, low),
            at(right, high),
            at(left, high),
        ];
        [[a, b, c], [a, c, d]]
    }

    #[test]
    fn a_grid_of_any_width_has_a_bounded_number_of_cells() {
        for (half, step) in [
            (1e6, 1e-6),
            (f32::INFINITY, 1e-3),
            (1.0, 0.0),
            (f32::NAN, 1.0),
        ] {
            let grid = FrontGrid::around(Vec2::ZERO, half, step);
            assert!(
                grid.count <= 1601,
                "{half} m in cells of {step} m: {}",
                grid.count
            );
        }
        let wide = FrontGrid::around(Vec2::ZERO, 1e6, 1e-6);
        assert!(
            wide.cell(Vec2::splat(9.9e5)).is_some(),
            "it is as wide as was asked"
        );
        let usual = FrontGrid::around(Vec2::ZERO, 0.9, 0.02);
        assert_eq!((usual.count, usual.step), (91, 0.02));
    }

    #[test]
    fn a_hole_and_a_socket_are_deeper_than_what_surrounds_them() {
        // A wall with a hole of 0.4 by 0.2 m; behind its left half another wall, 0.5 m deep.
        let frame = [
            wall(0.0, [-1.0, 1.0], [0.1, 1.0]),
            wall(0.0, [-1.0, 1.0], [-1.0, -0.1]),
            wall(0.0, [-1.0, -0.2], [-0.1, 0.1]),
            wall(0.0, [0.2, 1.0], [-0.1, 0.1]),
            wall(-0.5, [-0.5, 0.0], [-0.3, 0.3]),
        ];
        let grid = FrontGrid::around(Vec2::ZERO, 0.9, 0.02);
        let view = FrontView::of(grid, frame.into_iter().flatten(), f32::NEG_INFINITY);
        let area = |deep: f32| {
            let cells = view.deeper(deep).into_iter().filter(|d| *d).count();
            cells as f32 * grid.step * grid.step
        };
        assert!((area(0.4) - 0.08).abs() < 0.01, "{}", area(0.4));
        assert!((area(0.6) - 0.04).abs() < 0.01, "{}", area(0.6));
        let cells = regions(&view.deeper(0.4), grid.count);
        assert_eq!(cells.len(), 1);
        let all = cells[0].iter().map(|c| grid.place(*c));
        assert!(all.clone().all(|p| p.x.abs() < 0.21 && p.y.abs() < 0.11));
        assert!(
            cells[0]
                .iter()
                .all(|c| grid.cell(grid.place(*c)) == Some(*c))
        );
    }
}
