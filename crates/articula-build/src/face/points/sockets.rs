//! Openings of the lids of a head without eyeballs: where the skin falls back into a socket, or has a hole,
//! at mirrored places beside the nose.

use super::eyes::EyeOpening;
use super::front::{FrontGrid, FrontView, regions};
use super::surface::{FaceSurface, SurfacePart};
use glam::{Vec2, Vec3};

/// Least depth of a socket behind the skin around it, by the height of the skull above the nose: eyes that are
/// painted lie in hollows of less.
const DEEP: f32 = 0.05;
/// Heights of the middle of an eye above the tip of the nose, by that height, and distances from the middle
/// of the face.
const ABOVE: std::ops::Range<f32> = 0.03..0.6;
const ASIDE: std::ops::Range<f32> = 0.1..0.45;
/// Least width of an opening, and how far one may be from the mirrored other one, by that height.
const WIDE: f32 = 0.06;
const ALIKE: f32 = 0.06;
/// Largest ratio of the areas of both.
const AREAS: f32 = 1.6;

/// An eye without eyeball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Socket {
    /// In front of the middle of what is open: the inner corner is narrow, and counts little.
    pub(super) pupil: Vec3,
    pub(super) opening: EyeOpening,
}

/// A region that may be an opening.
struct Hollow {
    cells: Vec<usize>,
    middle: Vec2,
    width: f32,
}

/// The openings of the left and of the right eye; `None` if no mirrored pair of sockets is seen. `skull` is the height
/// of the top of the skull above the tip of the nose.
pub(super) fn sockets(
    surface: &FaceSurface,
    skin: &SurfacePart,
    nose: Vec3,
    middle_x: f32,
    skull: f32,
    step: f32,
) -> Option<[Socket; 2]> {
    // Even about the plane of symmetry.
    let middle = Vec2::new(middle_x, nose.y + 0.25 * skull);
    let grid = FrontGrid::around(middle, 0.6 * skull, step);
    let corners = skin.triangles.iter().map(|t| surface.corners(t));
    let view = FrontView::of(grid, corners, f32::NEG_INFINITY);
    let is_deep = view.deeper(DEEP * skull);
    let hollow = |cells: Vec<usize>| {
        let places = || cells.iter().map(|c| grid.place(*c));
        let middle = places().sum::<Vec2>() / cells.len() as f32;
        let low = places().fold(f32::INFINITY, |low, p| low.min(p.x));
        let high = places().fold(f32::NEG_INFINITY, |high, p| high.max(p.x));
        Hollow {
            middle,
            width: high - low,
            cells,
        }
    };
    let is_eye = |h: &Hollow| {
        h.width > WIDE * skull
            && ABOVE.contains(&((h.middle.y - nose.y) / skull))
            && ASIDE.contains(&((h.middle.x - middle_x).abs() / skull))
    };
    let all = regions(&is_deep, grid.count).into_iter().map(hollow);
    let all: Vec<Hollow> = all.filter(is_eye).collect();
    let is_left = |h: &&Hollow| h.middle.x > middle_x;
    // The largest pair; regions are in the order of their size.
    all.iter().filter(is_left).find_map(|left| {
        let mirrored = Vec2::new(2.0 * middle_x - left.middle.x, left.middle.y);
        let is_alike = |right: &&Hollow| {
            let [a, b] = [left, *right].map(|h| h.cells.len() as f32);
            right.middle.distance(mirrored) < ALIKE * skull && a.max(b) < AREAS * a.min(b)
        };
        let right = all.iter().filter(|h| !is_left(h)).find(is_alike)?;
        Some([socket(&view, left)?, socket(&view, right)?])
    })
}

/// The places of the skin at the rim of a region.
fn socket(view: &FrontView, hollow: &Hollow) -> Option<Socket> {
    let grid = &view.grid;
    let count = grid.count;
    let place = |cell: usize| grid.place(cell).extend(view.depths[cell]);
    let columns = || hollow.cells.iter().map(|cell| cell % count);
    let rows = |column: usize| {
        let in_column = hollow.cells.iter().filter(move |c| **c % count == column);
        in_column.map(|c| c / count)
    };
    // The cell of the skin beside a cell of the region: the depth is that of the rim.
    let corner = |column: usize, beside: usize| {
        let cells = rows(column).map(|row| row * count + beside);
        let row_count = rows(column).count() as f32;
        let sum = cells.map(place).sum::<Vec3>() / row_count;
        sum.is_finite().then_some(sum)
    };
    let middle = grid.column(hollow.middle.x).round() as usize;
    let (left, right) = (columns().max()?, columns().min()?);
    let (top, bottom) = (rows(middle).max()?, rows(middle).min()?);
    let [top, bottom] = [top + 1, bottom.checked_sub(1)?];
    let found = EyeOpening {
        left: corner(left, left + 1)?,
        right: corner(right, right.checked_sub(1)?)?,
        top: edge(view, (top..count).map(|row| row * count + middle))?,
        bottom: edge(view, (0..=bottom).rev().map(|row| row * count + middle))?,
    };
    let rims = place(top * count + middle).midpoint(place(bottom * count + middle));
    rims.is_finite().then_some(Socket {
        pupil: Vec3::new(hollow.middle.x, rims.y, rims.z),
        opening: found,
    })
}

/// The front edge of a lid, along cells from its rim on: what comes forward more steeply than 45° is the margin, which goes
/// back to the eye.
fn edge(view: &FrontView, cells: impl Iterator<Item = usize>) -> Option<Vec3> {
    let places = cells.map(|cell| view.grid.place(cell).extend(view.depths[cell]));
    let mut places = places.take_while(|place| place.is_finite());
    let mut edge = places.next()?;
    for next in places {
        if next.z - edge.z <= view.grid.step {
            break;
        }
        edge = next;
    }
    Some(edge)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A face of 0.3 m with openings 24 mm wide and 8 mm tall, and a wall behind at some depth.
    fn face(behind: f32) -> (FaceSurface, SurfacePart) {
        let mut surface = FaceSurface::default();
        let mut part = SurfacePart::default();
        let mut wall = |[left, right]: [f32; 2], [low, high]: [f32; 2], z: f32| {
            let first = surface.positions.len() as u32;
            let corners = [[left, low], [right, low], [right, high], [left, high]];
            let places = corners.map(|[x, y]| Vec3::new(x, y, z));
            surface.positions.extend(places);
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                part.triangles.push([first + a, first + b, first + c]);
            }
        };
        let all = [-0.15, 0.15];
        wall(all, [-0.15, 0.036], 0.1);
        wall(all, [0.044, 0.2], 0.1);
        for [left, right] in [[-0.15, -0.042], [-0.018, 0.018], [0.042, 0.15]] {
            wall([left, right], [0.036, 0.044], 0.1);
        }
        wall(all, [-0.15, 0.2], 0.1 - behind);
        (surface, part)
    }

    #[test]
    fn the_edge_of_a_lid_is_in_front_of_its_margin() {
        // Cells of 1 m in a column: the margin comes forward by 2 m in each of three, the skin above by half a metre.
        let grid = FrontGrid::around(Vec2::ZERO, 3.0, 1.0);
        let depths = (0..49).map(|cell| match cell / 7 {
            row @ 0..=3 => 2.0 * row as f32,
            row => 6.0 + 0.5 * (row - 3) as f32,
        });
        let view = FrontView {
            grid,
            depths: depths.collect(),
            triangles: vec![0; 49],
        };
        let found = edge(&view, (0..7).map(|row| 7 * row + 3));
        assert_eq!(found, Some(Vec3::new(0.0, 0.0, 6.0)));
        // Skin that goes back at once has its edge at the rim.
        let back = edge(&view, (0..7).rev().map(|row| 7 * row + 3));
        assert_eq!(back, Some(Vec3::new(0.0, 3.0, 7.5)));
    }

    #[test]
    fn sockets_are_found_and_hollows_are_not() {
        let nose = Vec3::new(0.0, 0.0, 0.12);
        let found = |behind: f32| {
            let (surface, part) = face(behind);
            sockets(&surface, &part, nose, 0.0, 0.14, 0.00035)
        };
        let [left, right] = found(0.02).unwrap();
        let near = |a: Vec3, b: Vec3| assert!(a.distance(b) < 8e-4, "{a}, not {b}");
        let Socket { pupil, opening } = left;
        near(opening.left, Vec3::new(0.042, 0.04, 0.1));
        near(opening.right, Vec3::new(0.018, 0.04, 0.1));
        near(opening.top, Vec3::new(0.03, 0.044, 0.1));
        near(opening.bottom, Vec3::new(0.03, 0.036, 0.1));
        near(pupil, Vec3::new(0.03, 0.04, 0.1));
        near(right.opening.left, Vec3::new(-0.018, 0.04, 0.1));
        // A hollow of 4 mm is that of a painted eye.
        assert!(found(0.004).is_none());
    }
}
