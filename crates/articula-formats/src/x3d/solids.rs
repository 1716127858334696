//! Boxes, spheres, cylinders and cones as faces.
//!
//! Source: ISO/IEC 19775-1, 13.3.1 to 13.3.8. The standard leaves the number of faces to the
//! player; a preview needs few.

use super::corners::{Corner, Faces, NONE};
use super::fields::Reader;
use super::polygon::newell;
use super::scene::NodeId;
use crate::error::ReadError;
use articula_core::Libm;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Number of faces around a round solid.
const AROUND: u32 = 24;
/// Number of faces from the south pole of a sphere to its north pole.
const UP: u32 = 12;

pub(super) fn is_solid(kind: &str) -> bool {
    matches!(kind, "Box" | "Sphere" | "Cylinder" | "Cone")
}

/// Makes the faces of a solid.
pub(super) fn read(reader: &mut Reader<'_>, id: NodeId) -> Result<Faces, ReadError> {
    let mut faces = Faces {
        ccw: true,
        solid: reader.flag(id, "solid", true),
        ..Faces::default()
    };
    match reader.kind(id) {
        "Box" => {
            let size = reader.vector(id, "size", DVec3::splat(2.0))?;
            cuboid(&mut faces, size / 2.0);
        }
        "Sphere" => sphere(&mut faces, reader.number(id, "radius", 1.0)?),
        "Cylinder" => {
            let radius = reader.number(id, "radius", 1.0)?;
            let half = reader.number(id, "height", 2.0)? / 2.0;
            if reader.flag(id, "side", true) {
                mantle(&mut faces, (radius, -half), (radius, half));
            }
            if reader.flag(id, "top", true) {
                disc(&mut faces, radius, half);
            }
            if reader.flag(id, "bottom", true) {
                disc(&mut faces, -radius, -half);
            }
        }
        _ => {
            let radius = reader.number(id, "bottomRadius", 1.0)?;
            let half = reader.number(id, "height", 2.0)? / 2.0;
            if reader.flag(id, "side", true) {
                mantle(&mut faces, (radius, -half), (0.0, half));
            }
            if reader.flag(id, "bottom", true) {
                disc(&mut faces, -radius, -half);
            }
        }
    }
    reader.charge(id, 8 * faces.points.len())?;
    Ok(faces)
}

impl Faces {
    /// Adds a point with its normal and texture coordinate, which share its index.
    fn point(&mut self, point: DVec3, normal: DVec3, texcoord: DVec2) -> u32 {
        self.points.push(point);
        self.normals.push(normal);
        self.texcoords.push(texcoord);
        u32::try_from(self.points.len() - 1).unwrap_or(NONE)
    }

    /// Adds a triangle as a face, unless it has no area.
    fn triangle(&mut self, points: [u32; 3]) {
        let places = points.map(|i| self.points[i as usize]);
        let normal = newell(&places);
        // At a pole two corners coincide up to rounding.
        let longest = places[0]
            .distance(places[1])
            .max(places[0].distance(places[2]));
        if normal.length() <= 1e-12 * longest * longest {
            return;
        }
        let corner = |point| Corner {
            point,
            texcoord: point,
            normal: point,
            color: NONE,
        };
        let face = u32::try_from(self.face_normals.len()).unwrap_or(NONE);
        self.triangles.push(points.map(corner));
        self.face_of_triangle.push(face);
        self.face_normals.push(normal);
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }
}

fn cuboid(faces: &mut Faces, half: DVec3) {
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let normal = DVec3::AXES[axis] * sign;
            let up = if axis == 1 {
                DVec3::Z * -sign
            } else {
                DVec3::Y
            };
            let right = up.cross(normal);
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            let quad = corners.map(|(u, v)| {
                let point = (normal + right * u + up * v) * half;
                let texcoord = DVec2::new(u + 1.0, v + 1.0) / 2.0;
                faces.point(point, normal, texcoord)
            });
            faces.quad(quad);
        }
    }
}

/// Returns the direction at a fraction of a turn, from the back (-Z) over the left (-X).
fn around(share: f64) -> DVec3 {
    let angle = share * TAU;
    DVec3::new(-angle.libm_sin(), 0.0, -angle.libm_cos())
}

fn sphere(faces: &mut Faces, radius: f64) {
    let grid = |faces: &mut Faces, u: f64, v: f64| {
        let latitude = (v - 0.5) * PI;
        let normal = around(u) * latitude.libm_cos() + DVec3::Y * latitude.libm_sin();
        faces.point(normal * radius, normal, DVec2::new(u, v))
    };
    bands(faces, UP, grid);
}

/// Adds the side between two circles, each given by radius and height.
fn mantle(faces: &mut Faces, low: (f64, f64), high: (f64, f64)) {
    let slope = DVec2::new(high.1 - low.1, low.0 - high.0).normalize_or_zero();
    let grid = |faces: &mut Faces, u: f64, v: f64| {
        let out = around(u);
        let radius = low.0 + (high.0 - low.0) * v;
        let point = out * radius + DVec3::Y * (low.1 + (high.1 - low.1) * v);
        let normal = out * slope.x + DVec3::Y * slope.y;
        faces.point(point, normal, DVec2::new(u, v))
    };
    bands(faces, 1, grid);
}

/// Adds quads between rings of points, the lowest ring first.
fn bands(faces: &mut Faces, count: u32, mut point: impl FnMut(&mut Faces, f64, f64) -> u32) {
    let mut rings: Vec<Vec<u32>> = Vec::new();
    for ring in 0..=count {
        let v = f64::from(ring) / f64::from(count);
        let shares = (0..=AROUND).map(|i| f64::from(i) / f64::from(AROUND));
        rings.push(shares.map(|u| point(faces, u, v)).collect());
    }
    for pair in rings.windows(2) {
        for i in 0..AROUND as usize {
            faces.quad([pair[0][i], pair[0][i + 1], pair[1][i + 1], pair[1][i]]);
        }
    }
}

/// Adds a disc; one with a negative radius faces down.
fn disc(faces: &mut Faces, radius: f64, height: f64) {
    let normal = DVec3::Y * radius.signum();
    let up = DVec3::Y * height;
    let middle = faces.point(up, normal, DVec2::splat(0.5));
    let ring: Vec<u32> = (0..=AROUND)
        .map(|i| {
            let out = around(f64::from(i) / f64::from(AROUND));
            let texcoord = DVec2::new(out.x, -out.z * radius.signum()) / 2.0 + 0.5;
            faces.point(out * radius.abs() + up, normal, texcoord)
        })
        .collect();
    for pair in ring.windows(2) {
        match radius > 0.0 {
            true => faces.triangle([middle, pair[0], pair[1]]),
            false => faces.triangle([middle, pair[1], pair[0]]),
        }
    }
}
