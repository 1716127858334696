//! The left foot: heel, arch, ball and five toes on a flat sole.

use super::field::{Group, Join, Shape};
use glam::{Mat3, Vec3};

/// Root and tip of each toe with their radii, great toe first.
const TOES: [([f32; 3], [f32; 3], [f32; 2]); 5] = [
    (
        [0.0905, 0.0150, 0.108],
        [0.0905, 0.0120, 0.1535],
        [0.0140, 0.0118],
    ),
    (
        [0.1105, 0.0140, 0.112],
        [0.1115, 0.0095, 0.1540],
        [0.0100, 0.0088],
    ),
    (
        [0.1250, 0.0130, 0.107],
        [0.1275, 0.0090, 0.1455],
        [0.0095, 0.0083],
    ),
    (
        [0.1380, 0.0120, 0.099],
        [0.1420, 0.0085, 0.1335],
        [0.0090, 0.0078],
    ),
    (
        [0.1490, 0.0110, 0.088],
        [0.1545, 0.0080, 0.1175],
        [0.0088, 0.0073],
    ),
];

/// Ankle to toe tips.
pub(super) fn foot() -> Group {
    let add = Join::Add;
    let flat = |a, b, radii, factor| Shape::flat_cone(a, b, radii, Vec3::X, factor);
    let mut foot = Group::default()
        // Heel with the tendon above it.
        .with(
            Shape::ellipsoid([0.104, 0.034, -0.057], [0.031, 0.04, 0.038], Mat3::IDENTITY),
            add(0.0),
        )
        .with(
            Shape::cone([0.104, 0.11, -0.052], [0.104, 0.05, -0.06], [0.022, 0.026]),
            add(0.03),
        )
        // Instep, outer edge, ball.
        .with(
            flat(
                [0.106, 0.066, -0.03],
                [0.113, 0.034, 0.066],
                [0.036, 0.02],
                1.15,
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
        foot = foot.with(Shape::cone(root, tip, radii), add(0.0035));
    }
    // The floor: a huge ball whose top touches the sole.
    foot.with(
        Shape::ellipsoid([0.11, -8.0, 0.02], [8.0, 8.0, 8.0], Mat3::IDENTITY),
        Join::Carve(0.012),
    )
}
