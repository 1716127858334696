//! Transforms the bounds of bodies to world space, in groups of four with `glam`'s vectors.

use crate::sphere::Sphere;
use glam::{Mat4, Quat, Vec3, Vec4};

pub(crate) const LANES: usize = 4;

/// World-space bounds of four bodies, as [`Sphere::carried`] computes them for one: the three
/// coordinates of the centres, and the radii.
///
/// - `positions`: of the roots in the world, metres
/// - `rotations`: world from model, unit
/// - `scales`: uniform; a negative one mirrors
/// - `bounds`: in model space
#[inline]
pub(crate) fn carry_four(
    positions: [Vec3; LANES],
    rotations: [Quat; LANES],
    scales: [f32; LANES],
    bounds: [Sphere; LANES],
) -> [Vec4; 4] {
    let [px, py, pz, _] = columns(positions.map(|p| p.extend(0.0)));
    let [qx, qy, qz, qw] = columns(rotations.map(Vec4::from));
    let [cx, cy, cz, radius] = columns(bounds.map(|s| s.centre.extend(s.radius)));
    let scale = Vec4::from_array(scales);
    // q c q* = c + w t + v x t with t = 2 v x c.
    let [cx, cy, cz] = [cx * scale, cy * scale, cz * scale];
    let tx = 2.0 * (qy * cz - qz * cy);
    let ty = 2.0 * (qz * cx - qx * cz);
    let tz = 2.0 * (qx * cy - qy * cx);
    let x = px + (cx + qw * tx + (qy * tz - qz * ty));
    let y = py + (cy + qw * ty + (qz * tx - qx * tz));
    let z = pz + (cz + qw * tz + (qx * ty - qy * tx));
    [x, y, z, radius * scale.abs()]
}

/// The first four values, padded with `filler`.
#[inline]
pub(crate) fn filled<T: Copy>(values: &[T], filler: T) -> [T; LANES] {
    match values.first_chunk() {
        Some(four) => *four,
        None => std::array::from_fn(|lane| values.get(lane).copied().unwrap_or(filler)),
    }
}

/// Transposes four rows.
#[inline]
pub(crate) fn columns([a, b, c, d]: [Vec4; 4]) -> [Vec4; 4] {
    let m = Mat4::from_cols(a, b, c, d).transpose();
    [m.x_axis, m.y_axis, m.z_axis, m.w_axis]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn four_are_carried_like_one(
            rows in prop::array::uniform4((prop::array::uniform3(-30.0f32..30.0), prop::array::uniform3(-3.0f32..3.0), -3.0f32..3.0, prop::array::uniform3(-2.0f32..2.0), 0.0f32..2.0)),
        ) {
            let positions = rows.map(|r| Vec3::from(r.0));
            let rotations = rows.map(|r| Quat::from_scaled_axis(r.1.into()));
            let scales = rows.map(|r| r.2);
            let bounds = rows.map(|r| Sphere { centre: r.3.into(), radius: r.4 });
            let [x, y, z, radius] = carry_four(positions, rotations, scales, bounds).map(|v| v.to_array());
            for b in 0..4 {
                let one = bounds[b].carried(positions[b], rotations[b], scales[b]);
                prop_assert!((one.centre - Vec3::new(x[b], y[b], z[b])).length() < 2e-5);
                prop_assert_eq!(one.radius, radius[b]);
            }
        }
    }
}
