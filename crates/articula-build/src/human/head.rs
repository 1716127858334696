//! The left half of the head: skull, face with lids and ears; lips and brows are pieces of
//! their own that sit in the skin, so that their edges stay crisp at every level of detail.

use super::field::{Group, Join, Section, Shape};
use super::skeleton::EYE;
use glam::{Mat3, Vec3};

/// Radius of an eyeball.
pub(super) const EYE_RADIUS: f32 = 0.0122;

/// Chin to forehead.
const FACE: [Section; 9] = [
    [1.541, -0.019, 0.019, 0.0845, 0.035],
    [1.548, -0.030, 0.030, 0.0865, 0.015],
    [1.56, -0.040, 0.040, 0.0865, -0.01],
    [1.575, -0.049, 0.049, 0.086, -0.03],
    [1.59, -0.0555, 0.0555, 0.0855, -0.045],
    [1.605, -0.060, 0.060, 0.085, -0.055],
    [1.62, -0.064, 0.064, 0.084, -0.065],
    [1.64, -0.067, 0.067, 0.0825, -0.075],
    [1.66, -0.069, 0.069, 0.082, -0.08],
];

fn e(center: [f32; 3], radii: [f32; 3]) -> Shape {
    Shape::ellipsoid(center, radii, Mat3::IDENTITY)
}

/// Neck and head.
pub(super) fn head() -> Group {
    let add = Join::Add;
    let neck = ([0.0, 1.47, -0.042], [0.0, 1.605, -0.024], [0.056, 0.051]);
    let group = Group::default()
        .with(Shape::loft(&FACE), add(0.0))
        .with(
            e([0.0, 1.6685, -0.014], [0.0745, 0.0805, 0.094]),
            add(0.025),
        )
        // Neck, with the muscle from behind the ear to the breast bone.
        .with(
            Shape::flat_cone(neck.0, neck.1, neck.2, Vec3::Z, 1.06),
            add(0.028),
        )
        .with(
            Shape::cone([0.046, 1.59, -0.028], [0.014, 1.458, 0.010], [0.013, 0.009]),
            add(0.03),
        )
        // Jaw and chin.
        .with(
            Shape::cone(
                [0.040, 1.572, 0.006],
                [0.017, 1.5455, 0.067],
                [0.016, 0.0125],
            ),
            add(0.04),
        )
        .with(
            Shape::cone([0.0, 1.564, 0.01], [0.0, 1.554, 0.058], [0.032, 0.021]),
            add(0.03),
        )
        .with(e([0.0, 1.5475, 0.0745], [0.019, 0.014, 0.015]), add(0.02));
    face(group)
}

fn face(group: Group) -> Group {
    let add = Join::Add;
    let group = group
        // Cheek bone, cheek, muzzle.
        .with(e([0.038, 1.61, 0.052], [0.02, 0.016, 0.0215]), add(0.03))
        .with(e([0.031, 1.585, 0.055], [0.021, 0.026, 0.021]), add(0.03))
        .with(e([0.0, 1.57, 0.072], [0.027, 0.022, 0.02]), add(0.022))
        // Eye socket, brow ridge.
        .with(
            e(
                [EYE.x + 0.001, EYE.y + 0.001, 0.0935],
                [0.0205, 0.0115, 0.0165],
            ),
            Join::Carve(0.018),
        )
        .with(
            Shape::cone(
                [0.012, 1.653, 0.0785],
                [0.042, 1.656, 0.0635],
                [0.0065, 0.006],
            ),
            add(0.02),
        )
        // Nose: bridge, tip, wing.
        .with(
            Shape::cone([0.0, 1.645, 0.079], [0.0, 1.605, 0.0965], [0.0066, 0.008]),
            add(0.016),
        )
        .with(e([0.0, 1.6, 0.0985], [0.0092, 0.0082, 0.0094]), add(0.009))
        .with(
            e([0.0112, 1.5975, 0.0895], [0.0058, 0.0062, 0.0088]),
            add(0.008),
        )
        .with(
            e([0.0062, 1.5905, 0.095], [0.0026, 0.0032, 0.0042]),
            Join::Carve(0.004),
        );
    ear(lids(group))
}

/// Lids: a shell around the eyeball with an almond opening.
fn lids(group: Group) -> Group {
    let [x, y, z] = EYE.to_array();
    let almond = Shape::ellipsoid(
        [x + 0.0003, y - 0.001, z + 0.014],
        [0.0132, 0.005, 0.02],
        Mat3::from_rotation_z(0.06),
    );
    group
        .with(e([x, y, z], [EYE_RADIUS + 0.0021; 3]), Join::Add(0.006))
        .with(almond, Join::Carve(0.002))
}

fn ear(group: Group) -> Group {
    let turn = Mat3::from_rotation_y(-0.45) * Mat3::from_rotation_x(-0.15);
    group
        .with(
            Shape::ellipsoid([0.0715, 1.631, -0.012], [0.0068, 0.0275, 0.017], turn),
            Join::Add(0.009),
        )
        .with(
            Shape::ellipsoid([0.0795, 1.635, -0.009], [0.0075, 0.0175, 0.0105], turn),
            Join::Carve(0.007),
        )
}

/// The left brow: an arch that stands out of the ridge.
pub(super) fn brow(head: &Group) -> Group {
    let arch = [
        ([0.0135, 1.6592], 0.0021),
        ([0.025, 1.6625], 0.0028),
        ([0.0365, 1.6625], 0.0024),
        ([0.0475, 1.658], 0.0012),
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
                [0.0042, 0.0040],
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
                [0.0015, 0.0015],
            ),
            Join::Carve(0.0012),
        )
        .with(
            Shape::cone(
                at(0.012, 1.569, 0.0048),
                at(0.026, 1.57, 0.003),
                [0.0015, 0.0012],
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
