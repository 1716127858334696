//! Mouth: the opening and its inside, lips, teeth and tongue, each for the left half.

use crate::eyes::{facing, quads};
use crate::field::{Group, Join, Shape};
use crate::front::on_skin;
use crate::polygonise::Surface;
use glam::{Mat3, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Distance of the corners of the mouth from the middle.
pub(crate) const CORNER: f32 = 0.0235;

/// Half the width of the opening behind the lips: farther out both lips move alike.
pub(crate) const OPENING: f32 = CORNER - 0.003;

/// 1 in the middle of the mouth, falling smoothly to 0 where its opening ends.
pub(crate) fn parting(x: f32) -> f32 {
    let along = (x.abs() / (OPENING - 1e-3)).powi(3);
    (1.0 - along).max(0.0).powi(2)
}

/// Height of the line between the lips in the middle.
pub(crate) const LINE: f32 = 1.569;

/// Half the height of the opening behind the lips.
const SLOT: f32 = 0.0022;

/// A lip or a jaw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Upper,
    Lower,
}

/// Height of the line between the lips at a distance from the middle.
pub(crate) fn line(x: f32) -> f32 {
    let along = (x.abs() / CORNER).min(1.3);
    LINE + 0.0014 * along * along - 0.0006 * (1.0 - along * along).max(0.0)
}

/// Carves the opening of the mouth and the space behind it.
pub(crate) fn carved(head: Group) -> Group {
    let z = on_skin(&head, [0.0, LINE], 0.0).z;
    let e = |center, radii| Shape::ellipsoid(center, radii, Mat3::IDENTITY);
    head.with(
        e([0.0, LINE - 0.001, z - 0.03], [0.0235, 0.0125, 0.0235]),
        Join::Carve(0.001),
    )
    .with(
        e([0.0, LINE, z - 0.006], [OPENING, SLOT, 0.016]),
        Join::Carve(0.0005),
    )
}

/// Share of the way to the corner of the summits of Cupid's bow.
pub(crate) const BOW: f32 = 0.27;

/// Height of a lip at a share of the way to the corner.
fn height(side: Side, along: f32) -> f32 {
    let round = (1.0 - along * along).max(0.0).powf(0.62);
    match side {
        // The bow: two summits beside a dip.
        Side::Upper => {
            let bow = 0.0009 * (-((along - BOW) / 0.2).powi(2)).exp();
            let dip = 0.0006 * (-(along / 0.12).powi(2)).exp();
            0.0062 * round + bow - dip
        }
        Side::Lower => 0.0078 * round,
    }
}

/// The place between the lips at a distance from the middle.
pub(crate) fn inner_contour(head: &Group, x: f32) -> Vec3 {
    let p = on_skin(head, [x, line(x)], INNER);
    Vec3::new(x, line(x), p.z)
}

/// Where a lip begins, at a share of the way to the corner: x and y.
pub(crate) fn outer_contour(side: Side, along: f32) -> [f32; 2] {
    let sign = if side == Side::Upper { 1.0 } else { -1.0 };
    let x = 1.04 * CORNER * along;
    [x, line(x) + sign * height(side, along)]
}

/// Lift above the skin of the line where the lips touch, in metres.
const INNER: f32 = -0.0012;

/// The left half of a lip: columns from the middle to the corner, each from the outer contour over
/// the lip to its inner face.
pub(crate) fn lip(head: &Group, side: Side, columns: usize) -> Surface {
    let sign = if side == Side::Upper { 1.0 } else { -1.0 };
    // Share of the height, and lift above the skin in the middle of the mouth.
    let fullness = if side == Side::Upper { 0.8 } else { 1.0 };
    let rows: [(f32, f32); 6] = [
        (1.12, -0.0014),
        (0.95, 0.0004),
        (0.62, 0.0029 * fullness),
        (0.28, 0.0035 * fullness),
        (0.06, 0.0016),
        (0.0, INNER),
    ];
    let mut out = Surface::default();
    for i in 0..=columns {
        let along = (i as f32 / columns as f32 * FRAC_PI_2).sin();
        let x = 1.04 * CORNER * along;
        let (line, height) = (line(x), height(side, along).max(0.0005));
        let taper = (1.0 - along * along).max(0.0).sqrt();
        for (share, lift) in rows {
            let lift = lift * taper - 0.0012 * (1.0 - taper);
            let mut p = on_skin(head, [x, line + sign * share * height], lift);
            p.x = if i == 0 { 0.0 } else { p.x.max(1e-4) };
            if share == 0.0 {
                p.y = line;
            }
            out.positions.push(p);
        }
        // The inner face goes back behind the teeth's border.
        let mut inner = on_skin(head, [x, line + sign * 0.0018 * taper], -0.0062);
        inner.x = if i == 0 { 0.0 } else { x };
        out.positions.push(inner);
    }
    quads(&mut out, columns, rows.len() + 1);
    facing(out, |_| Vec3::Z)
}

/// Heights above the line of the mouth of gum, crown and edge of a row of teeth, half its width and
/// depth, and the z of its front; the lower row closes behind the upper one.
fn dental_arch(head: &Group, side: Side) -> ([f32; 3], [f32; 2], f32) {
    let z = on_skin(head, [0.0, LINE], 0.0).z;
    match side {
        Side::Upper => ([0.0085, 0.0, -0.0028], [0.0192, 0.022], z - 0.0078),
        Side::Lower => ([-0.0115, -0.006, -0.0034], [0.0178, 0.02], z - 0.0098),
    }
}

/// The point in the middle of a row of teeth at its gum (0), crown (1) or edge (2).
pub(crate) fn teeth_point(head: &Group, side: Side, row: usize) -> Vec3 {
    let (rows, _, front) = dental_arch(head, side);
    let in_bite = if row == 2 { IN_BITE } else { 0.0 };
    Vec3::new(0.0, LINE + rows[row], front - in_bite)
}

/// How far the edges of teeth lie behind their crowns, in metres.
const IN_BITE: f32 = 0.0006;

/// The left half of a row of teeth.
pub(crate) fn teeth(head: &Group, side: Side, columns: usize) -> Surface {
    let (rows, radius, front) = dental_arch(head, side);
    let mut out = Surface::default();
    for i in 0..=columns {
        let turn = i as f32 / columns as f32 * 1.35;
        let x = if i == 0 { 0.0 } else { radius[0] * turn.sin() };
        let back = radius[1] * (1.0 - turn.cos());
        for (row, y) in rows.iter().enumerate() {
            let in_bite = if row == 2 { IN_BITE } else { 0.0 };
            out.positions
                .push(Vec3::new(x, LINE + y, front - back - in_bite));
        }
        // The back of the edge.
        let y = rows[2] + if side == Side::Upper { 0.0015 } else { -0.0015 };
        out.positions
            .push(Vec3::new(x * 0.88, LINE + y, front - back - 0.003));
    }
    quads(&mut out, columns, 4);
    facing(out, |_| Vec3::Z)
}

/// A point of the tongue: the tip at 0, the root at 1 along; from its middle at 0 to its border.
fn on_tongue(z: f32, along: f32, turn: f32) -> Vec3 {
    // Narrow and thin at the tip.
    let wide = 0.0145 * (1.0 - (1.0 - along).powi(2)).sqrt().max(0.02);
    let thick = 0.005 * (1.0 - (1.0 - along).powi(3)).max(0.05);
    let groove = 0.0008 * (1.0 - turn.sin());
    let y = LINE - 0.0105 + thick * turn.cos() - groove * along + 0.003 * along;
    Vec3::new(wide * turn.sin(), y, z - 0.0135 - 0.026 * along)
}

/// A feature point of the tongue: its tip (1), its middle (2) or its left border (3).
pub(crate) fn tongue_point(head: &Group, number: u8) -> Vec3 {
    let z = on_skin(head, [0.0, LINE], 0.0).z;
    match number {
        1 => on_tongue(z, 0.0, 0.0),
        2 => on_tongue(z, 0.5, 0.0),
        _ => on_tongue(z, 0.5, FRAC_PI_2),
    }
}

/// The left half of the tongue: a flat dome behind the lower teeth.
pub(crate) fn tongue(head: &Group, columns: usize) -> Surface {
    let z = on_skin(head, [0.0, LINE], 0.0).z;
    let mut out = Surface::default();
    let rows = columns.max(3) + 1;
    for i in 0..=columns {
        let turn = FRAC_PI_2 * i as f32 / columns as f32;
        let column = (0..=rows).map(|j| on_tongue(z, j as f32 / rows as f32, turn));
        out.positions.extend(column);
    }
    quads(&mut out, columns, rows + 1);
    facing(out, |_| Vec3::Y)
}
