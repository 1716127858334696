//! The left hand: palm over the metacarpals, four fingers and a thumb of three bones each.

use crate::field::{Group, Join, Shape};
use crate::skeleton::{FINGER_POINTS, hand_axes, hand_point};
use glam::{Mat3, Vec3};

/// Radii at knuckle, middle joint, end joint and tip; thumb first.
const RADII: [[f32; 4]; 5] = [
    [0.0145, 0.0118, 0.0102, 0.0082],
    [0.0098, 0.0084, 0.0076, 0.0064],
    [0.0100, 0.0087, 0.0078, 0.0066],
    [0.0096, 0.0082, 0.0074, 0.0062],
    [0.0086, 0.0072, 0.0065, 0.0055],
];

fn cone(a: [f32; 3], b: [f32; 3], radii: [f32; 2]) -> Shape {
    Shape::cone(hand_point(a).into(), hand_point(b).into(), radii)
}

fn ellipsoid(center: [f32; 3], radii: [f32; 3]) -> Shape {
    // The axes (back, tips, thumb) are left-handed and would mirror the shape, so z is recomputed.
    let axes = hand_axes();
    let turn = Mat3::from_cols(axes.x_axis, axes.y_axis, axes.x_axis.cross(axes.y_axis));
    Shape::ellipsoid(hand_point(center).into(), radii, turn)
}

/// The palm from wrist to knuckles.
pub(crate) fn palm() -> Group {
    let wide = hand_axes().z_axis;
    let wrist = Shape::flat_cone(
        hand_point([0.0, -0.012, 0.0]).into(),
        hand_point([0.0, 0.02, 0.0]).into(),
        [0.0165, 0.0155],
        wide,
        1.4,
    );
    let mut palm = Group::default().with(wrist, Join::Add(0.0));
    for (finger, radii) in FINGER_POINTS.iter().zip(&RADII).skip(1) {
        let [carpus, knuckle, ..] = *finger;
        palm = palm.with(
            cone(carpus, knuckle, [0.0145, radii[0] + 0.0012]),
            Join::Add(0.014),
        );
    }
    palm
        // Ball of the thumb, outer edge, and the hollow between them.
        .with(
            ellipsoid([-0.013, 0.04, 0.021], [0.014, 0.03, 0.017]),
            Join::Add(0.015),
        )
        .with(
            ellipsoid([-0.011, 0.045, -0.02], [0.012, 0.032, 0.013]),
            Join::Add(0.015),
        )
        .with(
            ellipsoid([-0.029, 0.06, -0.004], [0.014, 0.028, 0.018]),
            Join::Carve(0.02),
        )
}

/// Thumb, index, middle, ring, pinky; each a chain of tapered bones with a pad at the tip.
pub(crate) fn fingers() -> [Group; 5] {
    std::array::from_fn(|f| {
        let (points, radii) = (&FINGER_POINTS[f], &RADII[f]);
        let bone = |i: usize| cone(points[i], points[i + 1], [radii[i - 1], radii[i]]);
        let group = Group::default()
            .with(bone(1), Join::Add(0.0))
            .with(bone(2), Join::Add(0.002))
            .with(bone(3), Join::Add(0.002))
            // Pad under the tip.
            .with(pad(points, radii[3]), Join::Add(0.006));
        if f == 0 {
            group.with(web(points), Join::Add(0.012))
        } else {
            group
        }
    })
}

fn pad(points: &[[f32; 3]; 5], radius: f32) -> Shape {
    let (end, tip) = (Vec3::from(points[3]), Vec3::from(points[4]));
    let at = end.lerp(tip, 0.62) - Vec3::X * (0.2 * radius);
    cone(
        at.into(),
        end.lerp(tip, 0.9).into(),
        [radius * 1.08, radius * 0.95],
    )
}

/// Skin between thumb and index.
fn web(points: &[[f32; 3]; 5]) -> Shape {
    let middle = Vec3::from(points[2]).lerp(Vec3::from(FINGER_POINTS[1][1]), 0.45);
    let from = Vec3::from(points[2]).lerp(Vec3::from(points[1]), 0.45);
    cone(
        from.into(),
        (middle - Vec3::Y * 0.016).into(),
        [0.011, 0.0075],
    )
}
