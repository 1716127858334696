//! The left half of the head: skull, face with lids and ears; lips and brows are pieces of
//! their own that sit in the skin, so that their edges stay crisp at every level of detail.

use super::field::{Group, Join, Section, Shape};
use super::skeleton::EYE;
use glam::{Mat3, Vec3};

/// Radius of an eyeball.
pub(super) const EYE_RADIUS: f32 = 0.0122;

/// Chin to forehead.
const FACE: [Section; 9] = [
    [1.535, -0.026, 0.026, 0.084, 0.02],
    [1.545, -0.037, 0.037, 0.088, -0.01],
    [1.56, -0.046, 0.046, 0.0875, -0.03],
    [1.58, -0.0545, 0.0545, 0.086, -0.045],
    [1.60, -0.0605, 0.0605, 0.0845, -0.055],
    [1.62, -0.065, 0.065, 0.083, -0.065],
    [1.64, -0.068, 0.068, 0.0825, -0.075],
    [1.66, -0.07, 0.07, 0.083, -0.08],
    [1.69, -0.068, 0.068, 0.079, -0.08],
];

fn e(center: [f32; 3], radii: [f32; 3]) -> Shape {
    Shape::ellipsoid(center, radii, Mat3::IDENTITY)
}

/// Neck and head.
pub(super) fn head() -> Group {
    let add = Join::Add;
    let group = Group::default()
        .with(Shape::loft(&FACE), add(0.0))
        .with(e([0.0, 1.668, -0.014], [0.0745, 0.082, 0.095]), add(0.02))
        // Neck, with the muscle from behind the ear to the breast bone.
        .with(
            Shape::flat_cone(
                [0.0, 1.47, -0.042],
                [0.0, 1.6, -0.02],
                [0.056, 0.052],
                Vec3::Z,
                1.06,
            ),
            add(0.02),
        )
        .with(
            Shape::cone([0.05, 1.59, -0.025], [0.014, 1.458, 0.012], [0.012, 0.009]),
            add(0.025),
        )
        // Jaw and chin.
        .with(
            Shape::cone([0.042, 1.574, 0.006], [0.014, 1.5465, 0.07], [0.012, 0.012]),
            add(0.025),
        )
        .with(e([0.0, 1.545, 0.078], [0.018, 0.014, 0.014]), add(0.016));
    face(group)
}

fn face(group: Group) -> Group {
    let add = Join::Add;
    let group = group
        // Cheek bone, cheek, muzzle.
        .with(e([0.036, 1.607, 0.054], [0.02, 0.016, 0.021]), add(0.028))
        .with(e([0.0, 1.57, 0.074], [0.027, 0.022, 0.02]), add(0.018))
        // Eye socket, brow ridge.
        .with(
            e(
                [EYE.x + 0.001, EYE.y + 0.001, 0.092],
                [0.021, 0.0125, 0.018],
            ),
            Join::Carve(0.016),
        )
        .with(
            Shape::cone(
                [0.012, 1.6505, 0.0795],
                [0.044, 1.653, 0.064],
                [0.0065, 0.006],
            ),
            add(0.018),
        )
        // Nose: bridge, tip, wing, nostril.
        .with(
            Shape::cone([0.0, 1.645, 0.0795], [0.0, 1.605, 0.098], [0.0068, 0.0085]),
            add(0.014),
        )
        .with(e([0.0, 1.6, 0.1005], [0.0098, 0.0088, 0.0098]), add(0.008))
        .with(
            e([0.0118, 1.597, 0.0905], [0.0062, 0.0066, 0.0095]),
            add(0.007),
        )
        .with(
            e([0.0066, 1.5895, 0.0965], [0.003, 0.0035, 0.0048]),
            Join::Carve(0.004),
        );
    ear(lids(group))
}

/// A lid shell around the eyeball with an almond opening.
fn lids(group: Group) -> Group {
    let [x, y, z] = EYE.to_array();
    group
        .with(e([x, y, z], [EYE_RADIUS + 0.0021; 3]), Join::Add(0.005))
        .with(
            Shape::ellipsoid(
                [x + 0.0004, y - 0.0012, z + 0.014],
                [0.0132, 0.0048, 0.02],
                Mat3::from_rotation_z(0.08),
            ),
            Join::Carve(0.0022),
        )
}

fn ear(group: Group) -> Group {
    let turn = Mat3::from_rotation_y(-0.35) * Mat3::from_rotation_x(-0.15);
    group
        .with(
            Shape::ellipsoid([0.0715, 1.628, -0.010], [0.0065, 0.030, 0.0175], turn),
            Join::Add(0.006),
        )
        .with(
            Shape::ellipsoid([0.079, 1.631, -0.004], [0.0065, 0.018, 0.0095], turn),
            Join::Carve(0.007),
        )
}

/// The left brow: an arch that stands out of the ridge.
pub(super) fn brow(head: &Group) -> Group {
    let arch = [
        ([0.0125, 1.6545], 0.0034),
        ([0.024, 1.6585], 0.0036),
        ([0.036, 1.6595], 0.0031),
        ([0.0475, 1.655], 0.0017),
    ];
    let at = |i: usize| on_skin(head, arch[i].0, -0.0008);
    (0..3).fold(Group::default(), |group, i| {
        let bone = Shape::cone(at(i), at(i + 1), [arch[i].1, arch[i + 1].1]);
        group.with(bone, Join::Add(0.004))
    })
}

/// Both lips, as one piece with the mouth line carved between them.
pub(super) fn lips(head: &Group) -> Group {
    let add = Join::Add;
    let at = |x: f32, y: f32, lift: f32| on_skin(head, [x, y], lift);
    Group::default()
        .with(
            Shape::cone(
                at(0.006, 1.5732, -0.0012),
                at(0.024, 1.5688, -0.0004),
                [0.0042, 0.0014],
            ),
            add(0.0),
        )
        .with(
            Shape::cone(
                at(0.0, 1.5722, -0.0012),
                at(0.006, 1.5732, -0.0012),
                [0.0036, 0.0042],
            ),
            add(0.003),
        )
        .with(
            Shape::cone(
                at(0.0, 1.5648, -0.0008),
                at(0.011, 1.5655, -0.0008),
                [0.0046, 0.0044],
            ),
            add(0.0008),
        )
        .with(
            Shape::cone(
                at(0.011, 1.5655, -0.0008),
                at(0.0235, 1.5688, -0.0006),
                [0.0044, 0.0013],
            ),
            add(0.002),
        )
        .with(
            Shape::cone(
                at(0.0, 1.5688, 0.0048),
                at(0.012, 1.569, 0.0048),
                [0.0022, 0.0022],
            ),
            Join::Carve(0.0012),
        )
        .with(
            Shape::cone(
                at(0.012, 1.569, 0.0048),
                at(0.025, 1.569, 0.003),
                [0.0022, 0.0016],
            ),
            Join::Carve(0.0012),
        )
}

/// The point of the face at x and y, moved out of the skin by `lift`.
fn on_skin(head: &Group, [x, y]: [f32; 2], lift: f32) -> [f32; 3] {
    let mut p = Vec3::new(x, y, 0.13);
    for _ in 0..60 {
        p.z -= 0.7 * head.distance(p);
    }
    (p + head.normal(p) * lift).into()
}
