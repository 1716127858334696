//! Eyeballs, and the openings of the lids in front of them.

use super::front::{FrontGrid, FrontView, regions};
use super::surface::{FaceSurface, SurfacePart};
use glam::Vec3;

/// Greatest root mean square distance of an eyeball's vertices from its sphere, as a fraction of the
/// radius.
const ROUNDNESS: f32 = 0.05;
/// Distance from an eyeball's sphere, as a fraction of its radius, up to which a layer in front of it
/// is part of the eye, such as a shell that paints the shadow of the lids.
const LAYER: f32 = 0.06;
/// Distances of a part around an eyeball from its centre, by its radius: a cornea bulges, and behind it
/// the optic nerve.
const AROUND: std::ops::Range<f32> = 0.75..1.3;
/// Radii of eyeballs as fractions of the height of the head.
const RADII: std::ops::Range<f32> = 0.02..0.12;

/// An eyeball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Eyeball {
    /// Index of its part.
    pub(super) part: usize,
    pub(super) centre: Vec3,
    pub(super) radius: f32,
}

impl Eyeball {
    /// Whether a triangle is of a layer on the ball.
    pub(super) fn is_layer(&self, corners: &[Vec3; 3]) -> bool {
        is_on_ball(corners, self.centre, self.radius)
    }

    /// Whether a part is a layer around the eyeball, front and back, as a cornea in one piece with the
    /// white of the eye; a shell between the lids is in front only.
    pub(super) fn has(&self, part: &SurfacePart, positions: &[Vec3]) -> bool {
        let mut places = part.vertices.iter().map(|v| positions[*v as usize]);
        let is_behind = |p: Vec3| p.z < self.centre.z - 0.5 * self.radius;
        places.clone().any(is_behind)
            && places.all(|p| AROUND.contains(&(p.distance(self.centre) / self.radius)))
    }
}

/// Whether the corners of a triangle are so near to a ball that it is a layer on it.
pub(in crate::face) fn is_on_ball(corners: &[Vec3; 3], centre: Vec3, radius: f32) -> bool {
    let near = |p: &Vec3| (p.distance(centre) / radius - 1.0).abs() < LAYER;
    corners.iter().all(near)
}

/// What is seen of an eyeball from the front.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EyeOpening {
    /// Most outward, and most inward place: towards +X and -X.
    pub(super) left: Vec3,
    pub(super) right: Vec3,
    /// Rims above and below the centre.
    pub(super) top: Vec3,
    pub(super) bottom: Vec3,
}

/// Left and right eyeball: the largest two round parts at mirrored places.
pub(super) fn eyeballs(
    surface: &FaceSurface,
    parts: &[SurfacePart],
    middle_x: f32,
    head_height: f32,
) -> Option<[Eyeball; 2]> {
    let balls: Vec<Eyeball> = parts
        .iter()
        .enumerate()
        .filter_map(|(part, p)| {
            let (centre, radius) = sphere(surface, p)?;
            let fits = RADII.contains(&(radius / head_height));
            fits.then_some(Eyeball {
                part,
                centre,
                radius,
            })
        })
        .collect();
    let mut best: Option<(f32, [Eyeball; 2])> = None;
    for left in balls.iter().filter(|b| b.centre.x > middle_x) {
        for right in balls.iter().filter(|b| b.centre.x < middle_x) {
            let mirrored = Vec3::new(
                2.0 * middle_x - right.centre.x,
                right.centre.y,
                right.centre.z,
            );
            let radius = left.radius.min(right.radius);
            let alike = left.centre.distance(mirrored) < 0.5 * radius
                && left.radius.max(right.radius) < 1.2 * radius
                && left.centre.x - right.centre.x > 2.0 * radius;
            let area = parts[left.part].area + parts[right.part].area;
            if alike && best.is_none_or(|(most, _)| area > most) {
                best = Some((area, [*left, *right]));
            }
        }
    }
    best.map(|(_, pair)| pair)
}

/// Centre and radius of the sphere through the vertices of a part, by linear least squares. `None`
/// if they are no sphere, or too little of one.
fn sphere(surface: &FaceSurface, part: &SurfacePart) -> Option<(Vec3, f32)> {
    let places = || part.vertices.iter().map(|v| surface.positions[*v as usize]);
    let count = part.vertices.len();
    if count < 8 {
        return None;
    }
    let middle = places().sum::<Vec3>() / count as f32;
    let mut matrix = vec![0.0_f64; 16];
    let mut right = vec![0.0_f64; 4];
    for place in places() {
        let p = (place - middle).as_dvec3();
        let row = [2.0 * p.x, 2.0 * p.y, 2.0 * p.z, 1.0];
        for (i, a) in row.iter().enumerate() {
            for (j, b) in row.iter().enumerate() {
                matrix[i * 4 + j] += a * b;
            }
            right[i] += a * p.length_squared();
        }
    }
    super::super::dense::solve(&mut matrix, &mut right, 1)?;
    let centre = glam::DVec3::new(right[0], right[1], right[2]);
    let radius = (right[3] + centre.length_squared()).max(0.0).sqrt();
    let miss = places().map(|p| ((p - middle).as_dvec3().distance(centre) - radius).powi(2));
    let miss = (miss.sum::<f64>() / count as f64).sqrt();
    // A cap of the sphere, such as a cornea, has its middle far from the centre.
    let is_round =
        radius > 0.0 && miss < f64::from(ROUNDNESS) * radius && centre.length() < 0.7 * radius;
    is_round.then(|| (middle + centre.as_vec3(), radius as f32))
}

/// The opening in front of an eyeball: where the ball is in front of the skin, seen along -Z on a
/// grid with this step. `None` if nothing of it is seen.
pub(super) fn opening(
    surface: &FaceSurface,
    skin: &SurfacePart,
    balls: &SurfacePart,
    ball: &Eyeball,
    step: f32,
) -> Option<EyeOpening> {
    // Even around the centre, so that mirrored eyes have mirrored cells.
    let grid = FrontGrid::around(ball.centre.truncate(), 1.3 * ball.radius, step);
    let count = grid.count;
    let front = |part: &SurfacePart, layers: bool| {
        let triangles = part.triangles.iter().map(|t| surface.corners(t));
        let drawn = triangles.filter(|corners| layers || !ball.is_layer(corners));
        FrontView::of(grid, drawn, ball.centre.z).depths
    };
    let skin = front(skin, false);
    let seen_ball = front(balls, true);
    let is_open: Vec<bool> = skin.iter().zip(&seen_ball).map(|(s, b)| b > s).collect();
    let region = regions(&is_open, count).into_iter().next()?;
    let place = |cell: usize| grid.place(cell).extend(seen_ball[cell]);
    let in_column = |column: usize| region.iter().copied().filter(move |c| c % count == column);
    // A column has several cells at a corner; the corner is their middle.
    let corner = |column: usize| {
        let places = in_column(column).map(place);
        places.sum::<Vec3>() / in_column(column).count() as f32
    };
    let columns = || region.iter().map(|cell| cell % count);
    let middle = || in_column(count / 2);
    Some(EyeOpening {
        left: corner(columns().max()?),
        right: corner(columns().min()?),
        top: place(middle().max()?),
        bottom: place(middle().min()?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::{PI, TAU};

    /// Adds a ball, and returns its part.
    fn ball(surface: &mut FaceSurface, centre: Vec3, radius: f32) -> SurfacePart {
        const ROUND: u32 = 48;
        let first = surface.positions.len() as u32;
        for row in 0..=ROUND {
            for column in 0..=ROUND {
                let (sin, cos) = (PI * row as f32 / ROUND as f32).sin_cos();
                let (across, along) = (TAU * column as f32 / ROUND as f32).sin_cos();
                let at = Vec3::new(sin * across, cos, sin * along);
                surface.positions.push(centre + radius * at);
            }
        }
        let mut part = SurfacePart::default();
        for row in 0..ROUND {
            for column in 0..ROUND {
                let at = first + row * (ROUND + 1) + column;
                let below = at + ROUND + 1;
                part.triangles.push([at, below, at + 1]);
                part.triangles.push([at + 1, below, below + 1]);
            }
        }
        part.vertices = (first..surface.positions.len() as u32).collect();
        part.area = 4.0 * PI * radius * radius;
        part
    }

    #[test]
    fn the_mirrored_pair_of_balls_is_found() {
        let mut surface = FaceSurface::default();
        let left = Vec3::new(0.05, 0.2, 0.1);
        let parts = vec![
            ball(&mut surface, Vec3::new(0.06, 0.5, 0.1), 0.02),
            ball(&mut surface, left, 0.012),
            ball(&mut surface, Vec3::new(-0.01, 0.2, 0.1), 0.012),
        ];
        let [l, r] = eyeballs(&surface, &parts, 0.02, 0.25).unwrap();
        assert_eq!((l.part, r.part), (1, 2));
        assert!(l.centre.distance(left) < 1e-4 && (l.radius - 0.012).abs() < 1e-4);
        // Not balls of eyes: too large for the head.
        assert!(eyeballs(&surface, &parts, 0.02, 0.05).is_none());
    }

    #[test]
    fn a_cornea_is_of_the_eyeball_and_a_shell_between_the_lids_is_not() {
        let mut surface = FaceSurface::default();
        let white = ball(&mut surface, Vec3::ZERO, 1.0);
        let cornea = ball(&mut surface, 0.1 * Vec3::Z, 1.1);
        let eye = Eyeball {
            part: 0,
            centre: Vec3::ZERO,
            radius: 1.0,
        };
        let has = |part: &SurfacePart| eye.has(part, &surface.positions);
        assert!(has(&white) && has(&cornea));
        let mut shell = cornea;
        shell
            .vertices
            .retain(|v| surface.positions[*v as usize].z > 0.0);
        assert!(!has(&shell));
    }

    #[test]
    fn mirrored_lids_have_mirrored_openings() {
        let open = |side: f32| {
            let mut surface = FaceSurface::default();
            let centre = Vec3::new(side * 0.0316, 0.03, 0.08);
            let part = ball(&mut surface, centre, 0.0145);
            let eye = Eyeball {
                part: 0,
                centre,
                radius: 0.0145,
            };
            // The lids meet in corners that lean outwards.
            let at = |x: f32, y: f32| centre + Vec3::new(side * x, y, 0.02);
            let mut lids = SurfacePart::default();
            for (far, middle) in [(0.05, 0.0052), (-0.05, -0.0047)] {
                let first = surface.positions.len() as u32;
                surface.positions.extend([
                    at(-0.0103, 0.0011),
                    at(0.0001, middle),
                    at(0.0112, -0.0013),
                    at(-0.05, 0.0011),
                    at(0.0, far),
                    at(0.05, -0.0013),
                ]);
                for [a, b, c] in [[3, 0, 4], [0, 1, 4], [1, 2, 4], [2, 5, 4]] {
                    lids.triangles.push([first + a, first + b, first + c]);
                }
            }
            opening(&surface, &lids, &part, &eye, 0.00036).unwrap()
        };
        let (left, right) = (open(1.0), open(-1.0));
        let near = |a: Vec3, b: Vec3| a.distance(Vec3::new(-b.x, b.y, b.z)) < 1e-6;
        assert!(
            near(left.left, right.right) && near(left.right, right.left),
            "{left:?}, {right:?}"
        );
        assert!(
            near(left.top, right.top) && near(left.bottom, right.bottom),
            "{left:?}, {right:?}"
        );
    }

    #[test]
    fn an_opening_ends_where_the_lids_begin() {
        let mut surface = FaceSurface::default();
        let part = ball(&mut surface, Vec3::ZERO, 1.0);
        let eye = Eyeball {
            part: 0,
            centre: Vec3::ZERO,
            radius: 1.0,
        };
        // Two lids in front of the ball: above y = 0.3 and below y = -0.2.
        let mut lids = SurfacePart::default();
        for (near, far) in [(0.3, 3.0), (-3.0, -0.2)] {
            let first = surface.positions.len() as u32;
            surface.positions.extend([
                Vec3::new(-2.0, near, 1.2),
                Vec3::new(2.0, near, 1.2),
                Vec3::new(2.0, far, 1.2),
                Vec3::new(-2.0, far, 1.2),
            ]);
            let at = |i: u32| first + i;
            lids.triangles.push([at(0), at(1), at(2)]);
            lids.triangles.push([at(0), at(2), at(3)]);
        }
        let step = 0.01;
        let seen = opening(&surface, &lids, &part, &eye, step).unwrap();
        assert!((seen.top.y - 0.3).abs() < 2.0 * step, "{seen:?}");
        assert!((seen.bottom.y + 0.2).abs() < 2.0 * step, "{seen:?}");
        assert!(seen.left.x > 0.9 && seen.right.x < -0.9, "{seen:?}");
        lids.triangles.truncate(2);
        surface.positions[part.vertices.len()].y = -3.0;
        surface.positions[part.vertices.len() + 1].y = -3.0;
        assert!(opening(&surface, &lids, &part, &eye, step).is_none());
    }
}
