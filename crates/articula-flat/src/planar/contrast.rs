//! Contrast of a surface with its surroundings: where a character has small features, such as pupils, brows
//! and lips, which few triangles show.

use super::bake::{Painter, Poser};
use super::subject::PlanarSubject;
use super::vertex_colors::fitted;
use crate::local_difference::lab;
use crate::picture::linear_table;
use glam::Vec3;
use std::collections::BTreeMap;

/// Colour of a cell of space: the sum over its surface, weighted by area, and that area.
type Cell = (Vec3, f32);

/// Returns for each vertex of the mesh how much its colour differs from the mean colour of the surface around
/// it in the rest pose, without light, in units of CIELAB; 0 for vertices that no triangle uses. The surface
/// around is that in a cube whose half side is between one and two times `radius_metres`.
///
/// O(triangles log triangles).
pub fn color_contrast(subject: &PlanarSubject<'_>, radius_metres: f32) -> Vec<f32> {
    let painter = Painter::new(subject);
    let levels = fitted(subject, |triangle| painter.appearance_of(triangle));
    let colors: BTreeMap<u32, Vec3> = levels.iter().map(|(v, c)| (*v, of_levels(*c))).collect();
    let mut poser = Poser::new(subject);
    poser.shape(subject.morph_weights);
    let positions = &poser.skinned.positions;
    let side = radius_metres.max(1e-6);
    let cell_of = |v: &u32| {
        positions[*v as usize]
            .to_array()
            .map(|x| (x / side).floor() as i32)
    };
    let mut cells: BTreeMap<[i32; 3], Cell> = BTreeMap::new();
    for triangle in subject.triangles {
        let [a, b, c] = triangle.map(|v| positions[v as usize]);
        let share = (b - a).cross(c - a).length() / 6.0;
        for v in triangle.iter().filter(|_| share.is_finite()) {
            let cell = cells.entry(cell_of(v)).or_default();
            *cell = (cell.0 + share * colors[v], cell.1 + share);
        }
    }
    let mut contrast = vec![0.0; subject.mesh.len()];
    for (v, color) in &colors {
        let (sum, area) = around(cell_of(v), &cells);
        if area > 0.0 {
            contrast[*v as usize] = color.distance(sum / area);
        }
    }
    contrast
}

/// The sum of a cell and of those beside it.
fn around(cell: [i32; 3], cells: &BTreeMap<[i32; 3], Cell>) -> Cell {
    let mut sum = Cell::default();
    for k in 0..27 {
        let [x, y, z] = cell;
        let beside =
            [(x, k % 3), (y, k / 3 % 3), (z, k / 9)].map(|(at, step)| at.saturating_add(step - 1));
        if let Some((color, area)) = cells.get(&beside) {
            sum = (sum.0 + *color, sum.1 + area);
        }
    }
    sum
}

/// CIELAB of sRGB levels.
fn of_levels(levels: [f32; 3]) -> Vec3 {
    let table = linear_table();
    let linear = levels.map(|level| table[usize::from(level.round().clamp(0.0, 255.0) as u8)]);
    Vec3::from(lab(linear))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::fixture::figure;

    /// The fixture in one colour, with some vertices in another.
    fn painted(is_dark: impl Fn(Vec3) -> bool) -> (Vec<Vec3>, Vec<f32>) {
        let mut figure = figure();
        let mut mesh = (*figure.asset.mesh).clone();
        figure.appearance = crate::Appearance::default();
        mesh.parts.iter_mut().for_each(|part| part.material = None);
        for (color, place) in mesh.colors.iter_mut().zip(&mesh.positions) {
            let level = if is_dark(*place) { 0.0 } else { 1.0 };
            *color = glam::Vec4::new(level, level, level, 1.0);
        }
        let places = mesh.positions.clone();
        figure.asset.mesh = mesh.into();
        let contrast = color_contrast(&figure.subject(), 0.1);
        (places, contrast)
    }

    #[test]
    fn one_colour_has_no_contrast_in_itself() {
        let (_, contrast) = painted(|_| false);
        assert!(contrast.iter().all(|c| *c < 0.01));
    }

    #[test]
    fn a_spot_has_contrast_and_its_surroundings_have_little() {
        let (places, _) = painted(|_| false);
        let top = places
            .iter()
            .fold(Vec3::ZERO, |a, b| if b.y > a.y { *b } else { a });
        let (places, contrast) = painted(|place| place.distance(top) < 0.01);
        let of = |near: bool| {
            let here = places.iter().zip(&contrast);
            here.filter(move |(p, _)| (p.distance(top) < 0.01) == near)
                .map(|(_, c)| *c)
        };
        // Black on white is 100 units, less the share that the spot has in its own surroundings.
        assert!(of(true).all(|c| c > 60.0));
        assert!(of(false).all(|c| c < 40.0));
        // Beyond the cells around the spot there is nothing but white.
        let far = places
            .iter()
            .zip(&contrast)
            .filter(|(p, _)| p.distance(top) > 0.4);
        assert!(far.map(|(_, c)| *c).all(|c| c < 0.01));
    }
}
