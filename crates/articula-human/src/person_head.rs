//! The head of the human with a face, its hair, its clothes and their borders.
//!
//! The mouth and the openings of the eyes are carved into the head; lids and lips, which are separate
//! sheets, cover the rims of these openings.

use crate::body::Body;
use crate::eyes::{EYE, EYE_RADIUS};
use crate::field::{Group, Join, Section, Shape};
use crate::foot;
use crate::head::{e, skull_and_neck};
use crate::mouth;
use glam::{Mat3, Vec3};

/// Tones of the skin, in the order of their materials.
pub(crate) const BARE: u8 = 0;
pub(crate) const INSIDE: u8 = 1;
pub(crate) const SHIRT: u8 = 2;
pub(crate) const TROUSERS: u8 = 3;
pub(crate) const SHOES: u8 = 4;

/// A height between the bare skin of the arms and that of the head.
pub(crate) const ARMS: f32 = 1.4;

/// The face from chin to forehead.
const FACE: [Section; 9] = [
    [1.537, -0.017, 0.017, 0.0735, 0.036],
    [1.548, -0.029, 0.029, 0.077, 0.014],
    [1.56, -0.0385, 0.0385, 0.0795, -0.009],
    [1.575, -0.0475, 0.0475, 0.081, -0.032],
    [1.59, -0.0545, 0.0545, 0.0815, -0.046],
    [1.605, -0.06, 0.06, 0.0815, -0.056],
    [1.62, -0.064, 0.064, 0.081, -0.066],
    [1.64, -0.067, 0.067, 0.081, -0.076],
    [1.66, -0.0695, 0.0695, 0.0825, -0.081],
];

/// The human with a face, clothed.
pub(crate) fn body() -> Body {
    Body {
        head: mouth::carved(closed_head()),
        foot: foot::shoe(),
        ..Body::new()
    }
}

/// Neck and head without the mouth, with the openings of the eyes.
pub(crate) fn closed_head() -> Group {
    let add = Join::Add;
    let group = skull_and_neck(&FACE)
        // Jaw and chin.
        .with(
            Shape::cone([0.04, 1.573, 0.006], [0.013, 1.538, 0.06], [0.0145, 0.012]),
            add(0.04),
        )
        .with(
            Shape::cone([0.0, 1.562, 0.008], [0.0, 1.543, 0.052], [0.032, 0.019]),
            add(0.03),
        )
        .with(e([0.0, 1.537, 0.067], [0.0155, 0.0135, 0.0135]), add(0.03));
    ear(face(group))
}

fn face(group: Group) -> Group {
    let add = Join::Add;
    let group = group
        // Cheek bone, cheek, muzzle.
        .with(e([0.038, 1.61, 0.053], [0.021, 0.017, 0.021]), add(0.035))
        .with(e([0.031, 1.586, 0.052], [0.023, 0.026, 0.023]), add(0.035))
        .with(e([0.0, 1.57, 0.064], [0.026, 0.02, 0.021]), add(0.03))
        // Eye socket, brow ridge.
        .with(
            e(
                [EYE.x + 0.001, EYE.y + 0.002, 0.099],
                [0.0215, 0.0125, 0.0175],
            ),
            Join::Carve(0.02),
        )
        .with(
            Shape::cone(
                [0.012, 1.6545, 0.0775],
                [0.043, 1.657, 0.0645],
                [0.0062, 0.0057],
            ),
            add(0.025),
        );
    eye(nose(group))
}

fn nose(group: Group) -> Group {
    let add = Join::Add;
    group
        .with(
            Shape::cone([0.0, 1.648, 0.0765], [0.0, 1.606, 0.0915], [0.0058, 0.0072]),
            add(0.018),
        )
        .with(
            e([0.0, 1.6005, 0.0935], [0.0088, 0.0078, 0.0088]),
            add(0.01),
        )
        .with(
            e([0.0102, 1.598, 0.0855], [0.0052, 0.0056, 0.0082]),
            add(0.009),
        )
        .with(
            e([0.0058, 1.591, 0.0905], [0.0024, 0.003, 0.0042]),
            Join::Carve(0.004),
        )
}

/// A shell around the eyeball with an opening that the lids fill.
fn eye(group: Group) -> Group {
    let [x, y, z] = EYE.to_array();
    let opening = Shape::ellipsoid(
        [x + 0.0002, y - 0.0005, z + 0.014],
        [0.0148, 0.0088, 0.02],
        Mat3::from_rotation_z(0.06),
    );
    group
        .with(e([x, y, z], [EYE_RADIUS + 0.0022; 3]), Join::Add(0.011))
        .with(opening, Join::Carve(0.0015))
}

fn ear(group: Group) -> Group {
    let turn = Mat3::from_rotation_y(-0.5) * Mat3::from_rotation_x(-0.16);
    group
        .with(
            Shape::ellipsoid([0.0735, 1.6315, -0.016], [0.0068, 0.0285, 0.0175], turn),
            Join::Add(0.009),
        )
        .with(
            Shape::ellipsoid([0.0818, 1.6355, -0.0125], [0.0072, 0.018, 0.0105], turn),
            Join::Carve(0.006),
        )
}

/// The hair: a closed solid around the skull, open at face, ears and neck.
pub(crate) fn hair() -> Group {
    let add = Join::Add;
    let carve = Join::Carve;
    Group::default()
        .with(e([0.0, 1.677, -0.0155], [0.0855, 0.0855, 0.1065]), add(0.0))
        .with(e([0.0, 1.643, -0.05], [0.074, 0.057, 0.0675]), add(0.03))
        // The hair above the forehead rises a little.
        .with(e([0.0, 1.727, 0.04], [0.057, 0.03, 0.047]), add(0.035))
        // Face, temples, ears, neck.
        .with(
            e([0.0, 1.63, 0.112], [0.0725, 0.0785, 0.0775]),
            carve(0.006),
        )
        .with(e([0.1, 1.592, 0.032], [0.052, 0.068, 0.046]), carve(0.012))
        .with(
            e([0.094, 1.628, -0.015], [0.027, 0.037, 0.024]),
            carve(0.008),
        )
        .with(e([0.0, 1.53, -0.03], [0.12, 0.06, 0.11]), carve(0.006))
}

/// The left brow: it tapers from the nose outwards.
pub(crate) fn brow(head: &Group) -> Group {
    let arch = [
        ([0.0135, 1.6588], 0.0026),
        ([0.0225, 1.6612], 0.0030),
        ([0.034, 1.6632], 0.0024),
        ([0.0435, 1.6614], 0.0016),
        ([0.0505, 1.6572], 0.0008),
    ];
    let at = |i: usize| head.on_skin(arch[i].0, -0.0012);
    (0..4).fold(Group::default(), |group, i| {
        let hairs = Shape::cone(at(i).into(), at(i + 1).into(), [arch[i].1, arch[i + 1].1]);
        group.with(hairs, Join::Add(0.0012))
    })
}

/// The borders between the tones of the skin; each is where a function is zero.
pub(crate) struct Borders<'a> {
    body: &'a Body,
    closed: Group,
}

impl<'a> Borders<'a> {
    pub(crate) fn new(body: &'a Body) -> Self {
        Self {
            body,
            closed: closed_head(),
        }
    }

    /// Depth below the closed head: what the mouth has carved is inside.
    pub(crate) fn mouth(&self, p: Vec3) -> f32 {
        let p = Vec3::new(p.x.abs(), p.y, p.z);
        let depth = -self.closed.distance(p) - 0.0025;
        // Elsewhere the head blends with the trunk, and nothing is below it.
        let near = 0.045 - p.distance(Vec3::new(0.0, 1.568, 0.06));
        depth.min(near)
    }

    /// Depth within the collar and the sleeves.
    pub(crate) fn shirt(&self, p: Vec3) -> f32 {
        let p = Vec3::new(p.x.abs(), p.y, p.z);
        let neck = Vec3::new(0.0, 1.516, -0.034);
        let collar = (((p - neck) * Vec3::new(0.92, 1.0, 1.0)).length() - 0.079).min(1.515 - p.y);
        let trunk = self.body.trunk.distance(p).min(self.body.leg.distance(p));
        if self.body.upper_limb(p) < trunk {
            let sleeve = (p - Vec3::new(0.21, 1.235, -0.04)).dot(Vec3::new(-0.14, 0.99, 0.0));
            return collar.min(sleeve);
        }
        collar
    }

    /// Height of a point of the trunk above the belt.
    pub(crate) fn belt(&self, p: Vec3) -> f32 {
        let p = Vec3::new(p.x.abs(), p.y, p.z);
        let trunk = self.body.trunk.distance(p).min(self.body.leg.distance(p));
        if self.body.upper_limb(p) < trunk {
            return 1.0;
        }
        p.y - 0.985
    }

    /// Height above the shoes.
    pub(crate) fn shoe(p: Vec3) -> f32 {
        p.y - 0.088 + 0.1 * p.z
    }

    /// The tone of a point of the skin.
    pub(crate) fn tone(&self, p: Vec3) -> u8 {
        if self.mouth(p) > 0.0 {
            INSIDE
        } else if self.shirt(p) < 0.0 {
            BARE
        } else if self.belt(p) > 0.0 {
            SHIRT
        } else if Self::shoe(p) > 0.0 {
            TROUSERS
        } else {
            SHOES
        }
    }
}
