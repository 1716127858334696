//! Transforms the bounds of many bodies to world space.
//!
//! Takes the root transforms of a crowd and a bound of each body in model space; returns the
//! world-space bounds that [`crate::visibility::cull`] tests. Works in groups of four with `glam`'s
//! vectors.

use crate::Mismatch;
use crate::sphere::Sphere;
use glam::{Mat4, Quat, Vec3, Vec4};

/// Root transforms and model-space bounds of bodies; one entry of each slice for each body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Places<'a> {
    positions: &'a [Vec3],
    rotations: &'a [Quat],
    scales: &'a [f32],
    bounds: &'a [Sphere],
}

impl<'a> Places<'a> {
    /// Combines the slices.
    ///
    /// - `positions`: of the roots in the world, metres
    /// - `rotations`: world from model, unit
    /// - `scales`: uniform; a negative one mirrors
    /// - `bounds`: in model space
    ///
    /// # Errors
    /// A [`Mismatch`] if the lengths differ.
    pub(crate) fn new(
        positions: &'a [Vec3],
        rotations: &'a [Quat],
        scales: &'a [f32],
        bounds: &'a [Sphere],
    ) -> Result<Self, Mismatch> {
        for (at, found) in [
            ("rotations", rotations.len()),
            ("scales", scales.len()),
            ("bounds", bounds.len()),
        ] {
            if found != positions.len() {
                let what = format!("{found} entries for {} bodies", positions.len());
                return Err(Mismatch::new(at, what));
            }
        }
        Ok(Self {
            positions,
            rotations,
            scales,
            bounds,
        })
    }
}

/// Writes the world-space bound of every body, as [`Sphere::carried`] computes it for one.
///
/// O(bodies); does not allocate.
///
/// # Panics
/// If `out` does not have one entry for each body.
pub(crate) fn carry(places: Places<'_>, out: &mut [Sphere]) {
    assert_eq!(
        out.len(),
        places.bounds.len(),
        "expected one bound for each body"
    );
    let (positions, last_positions) = places.positions.as_chunks();
    let (rotations, last_rotations) = places.rotations.as_chunks();
    let (scales, last_scales) = places.scales.as_chunks();
    let (bounds, last_bounds) = places.bounds.as_chunks();
    let (out, last_out) = out.as_chunks_mut();
    let spins = rotations.iter().zip(scales);
    let bounds = bounds.iter().zip(out);
    for ((p, (r, s)), (b, out)) in positions.iter().zip(spins).zip(bounds) {
        *out = carry_four(*p, *r, *s, *b);
    }
    let last = carry_four(
        filled(last_positions, Vec3::ZERO),
        filled(last_rotations, Quat::IDENTITY),
        filled(last_scales, 0.0),
        filled(last_bounds, Sphere::default()),
    );
    last_out.copy_from_slice(&last[..last_out.len()]);
}

pub(crate) const LANES: usize = 4;

#[inline]
fn carry_four(
    positions: [Vec3; LANES],
    rotations: [Quat; LANES],
    scales: [f32; LANES],
    bounds: [Sphere; LANES],
) -> [Sphere; LANES] {
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
    columns([x, y, z, radius * scale.abs()]).map(|s| Sphere {
        centre: s.truncate(),
        radius: s.w,
    })
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

    #[test]
    fn lengths_must_agree() {
        let (p, r, s, b) = ([Vec3::ZERO], [Quat::IDENTITY], [1.0], [Sphere::default()]);
        let at = |places: Result<Places<'_>, Mismatch>| places.unwrap_err().at;
        assert_eq!(at(Places::new(&p, &[], &s, &b)), "rotations");
        assert_eq!(at(Places::new(&p, &r, &[], &b)), "scales");
        assert_eq!(at(Places::new(&p, &r, &s, &[])), "bounds");
    }

    proptest! {
        #[test]
        fn many_are_carried_like_one(
            rows in prop::collection::vec((prop::array::uniform3(-30.0f32..30.0), prop::array::uniform3(-3.0f32..3.0), -3.0f32..3.0, prop::array::uniform3(-2.0f32..2.0), 0.0f32..2.0), 0..40),
        ) {
            let positions: Vec<Vec3> = rows.iter().map(|r| r.0.into()).collect();
            let rotations: Vec<Quat> = rows.iter().map(|r| Quat::from_scaled_axis(r.1.into())).collect();
            let scales: Vec<f32> = rows.iter().map(|r| r.2).collect();
            let bounds: Vec<Sphere> = rows.iter().map(|r| Sphere { centre: r.3.into(), radius: r.4 }).collect();
            let mut out = vec![Sphere::default(); rows.len()];
            carry(Places::new(&positions, &rotations, &scales, &bounds).unwrap(), &mut out);
            for (b, out) in out.iter().enumerate() {
                let one = bounds[b].carried(positions[b], rotations[b], scales[b]);
                prop_assert!((one.centre - out.centre).length() < 2e-5);
                prop_assert_eq!(one.radius, out.radius);
            }
        }
    }
}
