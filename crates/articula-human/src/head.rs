//! The left half of the head: skull, face with lids, and ears. Lips and brows are separate pieces
//! embedded in the skin, so that their edges stay sharp at every level of detail.

use crate::field::{Group, Join, Section, Shape};
use crate::skeleton::EYE;
use glam::{Mat3, Vec3};

/// Radius of an eyeball.
pub(crate) const EYE_RADIUS: f32 = 0.0122;

/// The face from chin to forehead.
const FACE: [Section; 9] = [
    [1.537, -0.018, 0.018, 0.074, 0.04],
    [1.548, -0.031, 0.031, 0.0765, 0.018],
    [1.56, -0.041, 0.041, 0.079, -0.005],
    [1.575, -0.049, 0.049, 0.0805, -0.03],
    [1.59, -0.055, 0.055, 0.081, -0.045],
    [1.605, -0.0595, 0.0595, 0.081, -0.055],
    [1.62, -0.063, 0.063, 0.0805, -0.065],
    [1.64, -0.066, 0.066, 0.0805, -0.075],
    [1.66, -0.0685, 0.0685, 0.082, -0.08],
];

/// An ellipsoid along the axes.
pub(crate) fn e(center: [f32; 3], radii: [f32; 3]) -> Shape {
    Shape::ellipsoid(center, radii, Mat3::IDENTITY)
}

/// Skull and neck around a face of these sections.
pub(crate) fn skull_and_neck(face: &[Section]) -> Group {
    let add = Join::Add;
    Group::default()
        .with(Shape::loft(face), add(0.0))
        // Skull, forehead, back of the head.
        .with(e([0.0, 1.671, -0.012], [0.0745, 0.079, 0.096]), add(0.025))
        .with(e([0.0, 1.69, 0.028], [0.056, 0.045, 0.052]), add(0.03))
        .with(e([0.0, 1.65, -0.046], [0.062, 0.05, 0.06]), add(0.03))
        // Neck, with the muscle from behind the ear to the breast bone.
        .with(
            Shape::flat_cone(
                [0.0, 1.46, -0.045],
                [0.0, 1.605, -0.018],
                [0.052, 0.0455],
                Vec3::Z,
                1.04,
            ),
            add(0.025),
        )
        .with(
            Shape::cone([0.042, 1.59, -0.03], [0.015, 1.452, 0.003], [0.01, 0.0085]),
            add(0.03),
        )
}

/// Neck and head.
pub(crate) fn head() -> Group {
    let add = Join::Add;
    let group = skull_and_neck(&FACE)
        // Jaw and chin.
        .with(
            Shape::cone([0.041, 1.571, 0.006], [0.013, 1.537, 0.06], [0.0145, 0.012]),
            add(0.035),
        )
        .with(
            Shape::cone([0.0, 1.562, 0.008], [0.0, 1.543, 0.052], [0.032, 0.019]),
            add(0.03),
        )
        .with(e([0.0, 1.537, 0.067], [0.018, 0.014, 0.0135]), add(0.03));
    face(group)
}

fn face(group: Group) -> Group {
    let add = Join::Add;
    let group = group
        // Cheek bone, cheek, muzzle.
        .with(e([0.038, 1.61, 0.052], [0.02, 0.016, 0.0215]), add(0.03))
        .with(e([0.033, 1.583, 0.05], [0.023, 0.028, 0.023]), add(0.03))
        .with(e([0.0, 1.57, 0.062], [0.027, 0.02, 0.022]), add(0.025))
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
            Shape::cone([0.0, 1.65, 0.0775], [0.0, 1.605, 0.0925], [0.0066, 0.0076]),
            add(0.016),
        )
        .with(e([0.0, 1.6, 0.0945], [0.0092, 0.0082, 0.0092]), add(0.009))
        .with(
            e([0.0108, 1.5975, 0.0865], [0.0055, 0.006, 0.0085]),
            add(0.008),
        )
        .with(
            e([0.0062, 1.5905, 0.0915], [0.0024, 0.003, 0.0042]),
            Join::Carve(0.004),
        );
    ear(lids(group))
}

/// Lids: a shell around the eyeball with an almond-shaped opening.
fn lids(group: Group) -> Group {
    let [x, y, z] = EYE.to_array();
    let almond = Shape::ellipsoid(
        [x + 0.0003, y - 0.0018, z + 0.014],
        [0.0134, 0.0044, 0.02],
        Mat3::from_rotation_z(0.06),
    );
    group
        .with(e([x, y, z], [EYE_RADIUS + 0.0021; 3]), Join::Add(0.009))
        .with(almond, Join::Carve(0.002))
}

fn ear(group: Group) -> Group {
    let turn = Mat3::from_rotation_y(-0.45) * Mat3::from_rotation_x(-0.15);
    group
        .with(
            Shape::ellipsoid([0.0705, 1.633, -0.014], [0.0064, 0.0255, 0.016], turn),
            Join::Add(0.009),
        )
        .with(
            Shape::ellipsoid([0.0782, 1.637, -0.011], [0.007, 0.0155, 0.0095], turn),
            Join::Carve(0.007),
        )
}

/// The left brow: an arch that protrudes from the ridge.
pub(crate) fn brow(head: &Group) -> Group {
    let arch = [
        ([0.0145, 1.6555], 0.0017),
        ([0.0255, 1.6585], 0.0022),
        ([0.0365, 1.6588], 0.0019),
        ([0.0465, 1.6555], 0.001),
    ];
    let at = |i: usize| head.on_skin(arch[i].0, -0.001).into();
    (0..3).fold(Group::default(), |group, i| {
        let bone = Shape::cone(at(i), at(i + 1), [arch[i].1, arch[i + 1].1]);
        group.with(bone, Join::Add(0.0008))
    })
}

/// Both lips, as one piece with the line of the mouth carved between them.
pub(crate) fn lips(head: &Group) -> Group {
    let at = |x: f32, y: f32, lift: f32| head.on_skin([x, y], lift).into();
    let bow = |a, b, radii, join| (Shape::cone(a, b, radii), join);
    let parts = [
        bow(
            at(0.0, 1.5723, -0.0017),
            at(0.006, 1.5732, -0.0017),
            [0.0033, 0.0036],
            Join::Add(0.0),
        ),
        bow(
            at(0.006, 1.5732, -0.0017),
            at(0.0225, 1.569, -0.0008),
            [0.0036, 0.0012],
            Join::Add(0.003),
        ),
        bow(
            at(0.0, 1.5651, -0.0016),
            at(0.01, 1.5658, -0.0016),
            [0.0039, 0.0036],
            Join::Add(0.002),
        ),
        bow(
            at(0.01, 1.5658, -0.0016),
            at(0.022, 1.569, -0.0009),
            [0.0036, 0.0012],
            Join::Add(0.003),
        ),
    ];
    parts
        .into_iter()
        .fold(Group::default(), |lips, (part, join)| lips.with(part, join))
}
