//! Eyeballs and lids. A lid is a sheet around the eyeball that turns about its centre.

use crate::polygonise::Surface;
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, TAU};

/// Centre of the left eyeball.
pub(crate) const EYE: Vec3 = Vec3::new(0.0325, 1.6332, 0.0612);

/// Radius of an eyeball.
pub(crate) const EYE_RADIUS: f32 = 0.0158;

/// Radii of the inner and the outer face of a lid.
const LID: [f32; 2] = [EYE_RADIUS + 0.0007, EYE_RADIUS + 0.0018];

/// Longitude of the corners of the eye about the vertical, seen from its centre.
pub(crate) const CORNER: f32 = 0.98;

/// Latitudes about the axis through the corners at which the lids end, below the skin.
const HIDDEN: [f32; 2] = [1.2, -1.05];

/// A lid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lid {
    Upper,
    Lower,
}

/// The direction at a longitude about the vertical (outwards) and a latitude about the axis of the
/// lids.
fn direction(longitude: f32, latitude: f32) -> Vec3 {
    let flat = longitude.cos();
    Vec3::new(
        longitude.sin(),
        flat * latitude.sin(),
        flat * latitude.cos(),
    )
}

/// Height of the line on which closed lids meet.
pub(crate) fn closed(longitude: f32) -> f32 {
    let arch = 1.0 - (longitude / CORNER).powi(2);
    0.05 * longitude / CORNER - 0.19 * arch.max(0.0)
}

/// Latitude of the rim of an open lid.
pub(crate) fn rim(lid: Lid, longitude: f32) -> f32 {
    let along = (longitude / CORNER).clamp(-1.0, 1.0);
    // The upper lid is highest towards the nose, the lower one lowest towards the temple.
    let (height, lean) = match lid {
        Lid::Upper => (0.54, -0.12),
        Lid::Lower => (-0.17, 0.15),
    };
    let bent = along - lean * (1.0 - along * along);
    closed(longitude) + height * (1.0 - bent * bent).max(0.0).powf(0.8)
}

/// A point of the rim of an open lid.
pub(crate) fn rim_point(lid: Lid, longitude: f32) -> Vec3 {
    EYE + direction(longitude, rim(lid, longitude)) * LID[1]
}

/// Latitude at which a lid ends below the skin.
fn hidden(lid: Lid) -> f32 {
    match lid {
        Lid::Upper => HIDDEN[0],
        Lid::Lower => HIDDEN[1],
    }
}

/// A lid of the left eye: columns from corner to corner, each from the inner face over the rim to the
/// hidden end.
pub(crate) fn lid(lid: Lid, columns: usize, rows: usize) -> Surface {
    let mut out = Surface::default();
    for i in 0..=columns {
        let longitude = lid_longitude(i, columns);
        let (rim, end) = (rim(lid, longitude), hidden(lid));
        let mut add = |radius: f32, latitude: f32| {
            let p = EYE + direction(longitude, latitude) * radius;
            out.positions.push(p);
        };
        add(LID[0], rim + 0.08 * (end - rim).signum());
        add(LID[0] + 0.0002, rim);
        add(LID[1] - 0.0003, rim);
        for j in 1..=rows {
            // Rows are closer near the rim, which is round.
            let t = (j as f32 / rows as f32).powf(1.2);
            add(LID[1], rim + (end - rim) * t);
        }
    }
    quads(&mut out, columns, rows + 3);
    facing(out, |p| p - EYE)
}

/// Longitudes of the columns, beyond both corners by a little.
fn lid_longitude(i: usize, columns: usize) -> f32 {
    let even = 2.0 * i as f32 / columns as f32 - 1.0;
    1.12 * CORNER * even
}

/// Triangles of a grid of `columns` strips with `height` vertices in each column.
pub(crate) fn quads(out: &mut Surface, columns: usize, height: usize) {
    for i in 0..columns {
        for j in 0..height - 1 {
            let at = |i: usize, j: usize| (i * height + j) as u32;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            out.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
}

/// The surface, turned over if it faces against the given direction.
pub(crate) fn facing(mut surface: Surface, direction: impl Fn(Vec3) -> Vec3) -> Surface {
    let turned = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| surface.positions[v as usize]);
        (b - a).cross(c - a).dot(direction((a + b + c) / 3.0))
    };
    if surface.triangles.iter().map(turned).sum::<f32>() < 0.0 {
        surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    surface
}

/// Where a point of a lid is at a closing from 0 to 1.
pub(crate) fn closing(lid: Lid, p: Vec3, amount: f32) -> Vec3 {
    let arm = p - EYE;
    let radius = arm.length();
    let longitude = (arm.x / radius).clamp(-1.0, 1.0).asin();
    let latitude = arm.y.atan2(arm.z);
    let (rim, end) = (rim(lid, longitude), hidden(lid));
    let share = ((end - latitude) / (end - rim)).clamp(0.0, 1.1);
    let turned = latitude + amount * share * (closed(longitude) - rim);
    EYE + direction(longitude, turned) * radius
}

/// Sclera, iris and pupil of the left eye: bands of one surface of revolution.
pub(crate) fn eyeball(around: usize) -> [Surface; 3] {
    let rings = |from: f32, to: f32, count: usize| -> Vec<f32> {
        (0..=count)
            .map(|i| from + (to - from) * i as f32 / count as f32)
            .collect()
    };
    // Behind its middle an eyeball is never seen.
    let detail = (around / 5).max(2);
    let sclera = rings(0.45, FRAC_PI_2 + 0.2, detail);
    [sclera, rings(0.2, 0.45, 1), rings(0.0, 0.2, 1)].map(|angles| band(&angles, around))
}

/// A band of the left eyeball between polar angles from the viewing direction.
fn band(angles: &[f32], around: usize) -> Surface {
    let mut out = Surface::default();
    for angle in angles {
        for i in 0..=around {
            let turn = TAU * (i % around) as f32 / around as f32;
            let flat = angle.sin();
            let direction = Vec3::new(flat * turn.cos(), flat * turn.sin(), angle.cos());
            out.positions.push(EYE + direction * EYE_RADIUS);
        }
    }
    quads(&mut out, angles.len() - 1, around + 1);
    out.triangles.retain(|t| {
        let [a, b, c] = t.map(|v| out.positions[v as usize]);
        (b - a).cross(c - a).length() > 1e-12
    });
    facing(out, |p| p - EYE)
}
