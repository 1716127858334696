//! The left foot: heel, arch, ball and five toes on a flat sole.

use crate::field::{Group, Join, Shape};
use glam::{Mat3, Vec3};

/// Root and tip of each toe with their radii, big toe first.
const TOES: [([f32; 3], [f32; 3], [f32; 2]); 5] = [
    (
        [0.0905, 0.015, 0.1],
        [0.0915, 0.0118, 0.15],
        [0.0148, 0.0116],
    ),
    (
        [0.1095, 0.014, 0.104],
        [0.11, 0.0103, 0.149],
        [0.0118, 0.01],
    ),
    (
        [0.1235, 0.013, 0.1],
        [0.1245, 0.0098, 0.142],
        [0.0112, 0.0095],
    ),
    (
        [0.136, 0.0125, 0.093],
        [0.1375, 0.0093, 0.1315],
        [0.0104, 0.009],
    ),
    (
        [0.1465, 0.0118, 0.083],
        [0.149, 0.0088, 0.118],
        [0.0098, 0.0084],
    ),
];

/// The foot from ankle to toe tips.
pub(crate) fn foot() -> Group {
    let add = Join::Add;
    let flat = |a, b, radii, factor| Shape::flat_cone(a, b, radii, Vec3::X, factor);
    let mut foot = Group::default()
        // Heel and tendon.
        .with(
            Shape::ellipsoid(
                [0.104, 0.034, -0.057],
                [0.030, 0.038, 0.038],
                Mat3::IDENTITY,
            ),
            add(0.0),
        )
        .with(
            Shape::cone([0.104, 0.11, -0.052], [0.104, 0.05, -0.06], [0.018, 0.024]),
            add(0.03),
        )
        // Instep, outer edge, ball.
        .with(
            flat(
                [0.106, 0.062, -0.03],
                [0.113, 0.034, 0.066],
                [0.030, 0.02],
                1.05,
            ),
            add(0.03),
        )
        .with(
            flat(
                [0.113, 0.034, 0.05],
                [0.117, 0.019, 0.1],
                [0.021, 0.0145],
                1.9,
            ),
            add(0.025),
        )
        .with(
            Shape::cone([0.12, 0.02, -0.04], [0.138, 0.014, 0.07], [0.022, 0.017]),
            add(0.02),
        )
        .with(
            Shape::ellipsoid([0.091, 0.019, 0.088], [0.02, 0.018, 0.026], Mat3::IDENTITY),
            add(0.015),
        )
        // Arch.
        .with(
            Shape::ellipsoid([0.076, -0.004, 0.015], [0.02, 0.019, 0.045], Mat3::IDENTITY),
            Join::Carve(0.022),
        );
    for (root, tip, radii) in TOES {
        foot = foot.with(Shape::cone(root, tip, radii), add(0.007));
    }
    // The floor: a huge ball whose top touches the sole.
    foot.with(
        Shape::ellipsoid([0.11, -8.0, 0.02], [8.0, 8.0, 8.0], Mat3::IDENTITY),
        Join::Carve(0.012),
    )
}

/// The shoe: a round toe cap, a flat sole and a low shaft.
pub(crate) fn shoe() -> Group {
    let add = Join::Add;
    let flat = |a, b, radii, factor| Shape::flat_cone(a, b, radii, Vec3::X, factor);
    Group::default()
        .with(
            flat(
                [0.105, 0.036, -0.052],
                [0.107, 0.034, 0.0],
                [0.039, 0.036],
                0.95,
            ),
            add(0.0),
        )
        .with(
            flat(
                [0.106, 0.075, -0.04],
                [0.104, 0.1, -0.043],
                [0.038, 0.041],
                0.92,
            ),
            add(0.03),
        )
        .with(
            flat(
                [0.107, 0.056, -0.015],
                [0.113, 0.034, 0.075],
                [0.033, 0.027],
                1.1,
            ),
            add(0.03),
        )
        .with(
            flat(
                [0.112, 0.026, 0.05],
                [0.116, 0.022, 0.122],
                [0.03, 0.0235],
                1.5,
            ),
            add(0.025),
        )
        .with(
            Shape::ellipsoid([0.11, -8.0, 0.02], [8.0, 8.0, 8.0], Mat3::IDENTITY),
            Join::Carve(0.012),
        )
}
