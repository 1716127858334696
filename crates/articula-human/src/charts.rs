//! Texture coordinates: charts of the surfaces, and where they lie in the picture.
//!
//! A chart is a view of a part, as a sewing pattern has a front and a back: it depends on the position
//! alone, so that humans of all numbers of triangles have the same picture. Both halves of the body
//! have the same coordinates.

use crate::eyes::EYE;
use crate::person_head::{ARMS, BARE, INSIDE, SHIRT, SHOES, TROUSERS};
use crate::person_pieces::material;
use articula_core::source::Primitive;
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::f32::consts::PI;

/// Width and height of the picture, in px.
pub(crate) const SIDE: u32 = 512;

/// Px between what a chart shows and its frame.
const MARGIN: f32 = 3.0;

/// Centres about which the charts of head and hair turn.
const HEAD: Vec3 = Vec3::new(0.0, 1.62, -0.025);
const HAIR: Vec3 = Vec3::new(0.0, 1.66, -0.02);

/// A view of a part.
pub(crate) struct Chart {
    /// Left, top, width and height in the picture, in px.
    pub(crate) frame: [u32; 4],
    /// What the frame shows: the least and the greatest value of both coordinates of the view.
    shown: [[f32; 2]; 2],
    view: View,
}

/// A map from the left half of the body to a plane.
#[derive(Clone, Copy)]
enum View {
    /// From +Z: right and down.
    Front,
    /// From +X: forwards and down.
    Side,
    /// From +Y: forwards and to the left.
    Top,
    /// Longitude from +Z, larger in front, and angle from +Y, about a centre.
    Around(Vec3),
    /// Around the direction of the gaze of an eyeball; the iris is larger than at equal angles.
    Eyeball,
}

impl View {
    fn of(self, p: Vec3) -> Vec2 {
        match self {
            Self::Front => Vec2::new(p.x, -p.y),
            Self::Side => Vec2::new(p.z, -p.y),
            Self::Top => Vec2::new(p.z, p.x),
            Self::Around(center) => {
                let arm = p - center;
                let turn = arm.x.atan2(arm.z) / PI;
                let down = (arm.y / arm.length().max(1e-6)).clamp(-1.0, 1.0).acos();
                Vec2::new(turn * (1.6 - 0.6 * turn), down)
            }
            Self::Eyeball => {
                let arm = (p - EYE).normalize_or(Vec3::Z);
                let flat = arm.truncate().normalize_or_zero();
                Vec2::new(flat.x, -flat.y) * arm.z.clamp(-1.0, 1.0).acos().powf(0.6)
            }
        }
    }
}

/// Index of each chart in [`CHARTS`].
mod index {
    pub(super) const HEAD: usize = 0;
    pub(super) const MOUTH: usize = 1;
    pub(super) const HAIR: usize = 2;
    pub(super) const EYEBALL: usize = 3;
    pub(super) const LIPS: usize = 4;
    pub(super) const LIDS: usize = 5;
    pub(super) const BROWS: usize = 6;
    pub(super) const TEETH: usize = 7;
    pub(super) const TONGUE: usize = 8;
    pub(super) const SHIRT: usize = 9;
    pub(super) const TROUSERS: usize = 11;
    pub(super) const ARM: usize = 13;
    pub(super) const SHOE: usize = 15;
}

/// All charts. Of the shirt and of the trousers the front and the back, of the bare arm and of the
/// shoe the outer and the inner side, of the shoe also its top and its sole.
pub(crate) const CHARTS: [Chart; 19] = [
    chart(
        [0, 0, 208, 208],
        View::Around(HEAD),
        [[0.0, 0.0], [1.0, 2.82]],
    ),
    chart(
        [484, 0, 28, 28],
        View::Front,
        [[0.0, -1.582], [0.0245, -1.554]],
    ),
    chart(
        [212, 0, 148, 148],
        View::Around(HAIR),
        [[0.0, 0.0], [1.0, 3.02]],
    ),
    chart(
        [364, 0, 116, 116],
        View::Eyeball,
        [[-1.42, -1.42], [1.42, 1.42]],
    ),
    chart(
        [212, 152, 56, 44],
        View::Front,
        [[0.0, -1.577], [0.0248, -1.559]],
    ),
    chart(
        [272, 152, 56, 48],
        View::Front,
        [[0.0164, -1.65], [0.0486, -1.6174]],
    ),
    chart(
        [332, 152, 64, 28],
        View::Front,
        [[0.0102, -1.6662], [0.0507, -1.6556]],
    ),
    chart(
        [332, 184, 36, 28],
        View::Front,
        [[0.0, -1.5778], [0.019, -1.5572]],
    ),
    chart(
        [372, 184, 24, 44],
        View::Top,
        [[0.0488, 0.0], [0.0755, 0.0147]],
    ),
    chart(
        [0, 212, 112, 236],
        View::Front,
        [[0.0, -1.517], [0.247, -0.983]],
    ),
    chart(
        [116, 212, 112, 236],
        View::Front,
        [[0.0, -1.517], [0.247, -0.983]],
    ),
    chart(
        [232, 236, 56, 272],
        View::Front,
        [[0.0, -0.986], [0.166, -0.085]],
    ),
    chart(
        [292, 236, 56, 272],
        View::Front,
        [[0.0, -0.986], [0.166, -0.085]],
    ),
    chart(
        [352, 236, 76, 272],
        View::Side,
        [[-0.0875, -1.242], [0.0515, -0.68]],
    ),
    chart(
        [432, 236, 76, 272],
        View::Side,
        [[-0.0875, -1.242], [0.0515, -0.68]],
    ),
    chart(
        [0, 452, 112, 56],
        View::Side,
        [[-0.092, -0.098], [0.147, -0.005]],
    ),
    chart(
        [116, 452, 112, 56],
        View::Side,
        [[-0.092, -0.098], [0.147, -0.005]],
    ),
    chart(
        [400, 120, 108, 52],
        View::Top,
        [[-0.008, 0.0685], [0.1445, 0.155]],
    ),
    chart(
        [400, 176, 108, 52],
        View::Top,
        [[-0.0845, 0.0697], [0.1436, 0.1542]],
    ),
];

const fn chart(frame: [u32; 4], view: View, shown: [[f32; 2]; 2]) -> Chart {
    Chart { frame, shown, view }
}

impl Chart {
    /// Texture coordinates of a point of the left half: from 0 to 1, to the right and down.
    pub(crate) fn texcoord(&self, p: Vec3) -> Vec2 {
        let [low, high] = self.shown.map(Vec2::from);
        let share = ((self.view.of(p) - low) / (high - low)).clamp(Vec2::ZERO, Vec2::ONE);
        let [left, top, width, height] = self.frame.map(|v| v as f32);
        let size = Vec2::new(width, height) - 2.0 * MARGIN;
        (Vec2::new(left, top) + MARGIN + share * size) / SIDE as f32
    }
}

/// The chart that shows a triangle of the left half: its middle, and the sum of its normals.
fn chart_of(material: usize, middle: Vec3, normal: Vec3) -> usize {
    const SKIN: usize = BARE as usize;
    const MOUTH: usize = INSIDE as usize;
    const TORSO: usize = SHIRT as usize;
    const LEGS: usize = TROUSERS as usize;
    const FEET: usize = SHOES as usize;
    match material {
        SKIN if middle.y > ARMS => index::HEAD,
        SKIN => index::ARM + usize::from(normal.x < 0.0),
        MOUTH => index::MOUTH,
        TORSO => index::SHIRT + usize::from(normal.z < 0.0),
        LEGS => index::TROUSERS + usize::from(normal.z < 0.0),
        FEET => index::SHOE + side_of_shoe(normal.normalize_or_zero()),
        material::LIPS => index::LIPS,
        material::LIDS => index::LIDS,
        material::BROWS => index::BROWS,
        material::HAIR => index::HAIR,
        material::TEETH => index::TEETH,
        material::TONGUE => index::TONGUE,
        _ => index::EYEBALL,
    }
}

/// The chart that shows a triangle of either half.
fn chart_of_triangle(of: &Primitive, material: usize, t: &[u32; 3]) -> usize {
    let middle = t.map(|v| of.positions[v as usize]).iter().sum::<Vec3>() / 3.0;
    let normal = t.map(|v| of.normals[v as usize]).iter().sum::<Vec3>();
    let mirror = Vec3::new(if middle.x < 0.0 { -1.0 } else { 1.0 }, 1.0, 1.0);
    chart_of(material, middle * mirror, normal * mirror)
}

/// Outer side, inner side, top or sole.
fn side_of_shoe(normal: Vec3) -> usize {
    match normal.y {
        0.45.. => 2,
        ..-0.6 => 3,
        _ => usize::from(normal.x < 0.0),
    }
}

/// A point of the right half on the left one.
pub(crate) fn on_left(p: Vec3) -> Vec3 {
    Vec3::new(p.x.abs(), p.y, p.z)
}

/// The primitive with texture coordinates. Vertices between charts are there once for each.
pub(crate) fn unwrapped(primitive: &Primitive, material: usize) -> Primitive {
    let mut known = HashMap::new();
    let (mut order, mut texcoords) = (Vec::new(), Vec::new());
    let triangles = primitive.triangles.iter().map(|t| {
        let chart = chart_of_triangle(primitive, material, t);
        t.map(|v| {
            *known.entry((v, chart)).or_insert_with(|| {
                let p = on_left(primitive.positions[v as usize]);
                order.push(v);
                texcoords.push(CHARTS[chart].texcoord(p));
                order.len() as u32 - 1
            })
        })
    });
    let triangles = triangles.collect();
    Primitive {
        texcoords,
        ..primitive.reordered(&order, triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_charts_lie_in_the_picture_and_apart() {
        for (i, chart) in CHARTS.iter().enumerate() {
            let [left, top, width, height] = chart.frame;
            assert!(left + width <= SIDE && top + height <= SIDE, "chart {i}");
            for (j, other) in CHARTS.iter().enumerate().skip(i + 1) {
                let [x, y, w, h] = other.frame;
                let beside = left + width <= x || x + w <= left;
                let below = top + height <= y || y + h <= top;
                assert!(beside || below, "charts {i} and {j}");
            }
        }
    }
}
