//! All values but positions, over a surface whose topology and positions are known on both sides.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (e, f, g). One walk serves encoder and
//! decoder. In the order of processing:
//!
//! - `ring`, `siblings`: surroundings of a point or wedge, and the wedges of a point
//! - `stencil`: linear predictors over known surroundings; `blend`: mixtures of predictions
//! - `geometry`: normals of faces and the octahedral form, in whole numbers
//! - `residual`: coding of differences
//! - `skins`, `morphs`, `normals`, `texcoords`, `colors`: one per kind of value
//!
//! All predictions use integer arithmetic, so that every platform produces the same bytes.

mod blend;
mod colors;
mod geometry;
mod morphs;
mod normals;
mod residual;
mod ring;
mod siblings;
mod skins;
mod stencil;
mod texcoords;

#[cfg(test)]
mod tests;

use super::mesh::{Layout, QuantisedMesh};
use super::quantise::{LARGEST_OFFSET, LARGEST_TURN};
use super::surface::Surface;
use crate::range_coder::Coder;
use ring::Ring;
use siblings::Siblings;
use stencil::Stencils;

/// Surroundings of a wedge and the wedges of its point.
type Place<'a, 'b> = (&'a Ring, &'a Siblings<'b>);

/// A surface prepared for the walk.
struct Walk<'a> {
    /// Positions of points, clamped to the largest grid for any input.
    positions: Vec<[i32; 3]>,
    points: Ring,
    wedges: Ring,
    siblings: Siblings<'a>,
    known_points: usize,
    known_wedges: usize,
    of_points: Stencils,
    of_wedges: Stencils,
}

impl<'a> Walk<'a> {
    fn new(surface: &Surface<'a>, positions: &[[i32; 3]]) -> Self {
        let within = |p: &[i32; 3]| p.map(|x| x.clamp(0, 1 << 20));
        let positions: Vec<[i32; 3]> = positions.iter().map(within).collect();
        let point = |w: u32| surface.wedge_points[w as usize];
        let faces = surface.faces.iter().map(|f| f.map(point)).collect();
        let points = Ring::new(positions.len(), faces);
        let wedges = Ring::new(surface.wedge_points.len(), surface.faces.to_vec());
        let at_point = |p: u32| positions[p as usize];
        let at_wedge = |w: u32| positions[point(w) as usize];
        Self {
            of_points: Stencils::new(&points, at_point, surface.known_points),
            of_wedges: Stencils::new(&wedges, at_wedge, surface.known_wedges),
            siblings: Siblings::new(positions.len(), surface.wedge_points),
            known_points: surface.known_points,
            known_wedges: surface.known_wedges,
            positions,
            points,
            wedges,
        }
    }
}

/// Codes everything but positions for the new points and wedges of a level.
///
/// A decoder's mesh has its positions and the values of known points and wedges; placeholders of
/// new ones are replaced. A broken stream still gives a valid mesh.
pub(super) fn code_values<C: Coder>(
    coder: &mut C,
    surface: &Surface<'_>,
    layout: &Layout,
    mesh: &mut QuantisedMesh,
) {
    if C::READS {
        make_room(surface, layout, mesh);
    }
    let walk = Walk::new(surface, &mesh.positions);
    if layout.joints > 0 {
        skins::code(coder, &walk, &mut mesh.skins, layout.joints);
    }
    let points = (&walk.of_points, walk.known_points);
    morphs::code(coder, points, (&mut mesh.morphs, LARGEST_OFFSET));
    if layout.normal_bits > 0 {
        let geometry = normals::Geometry::new(&walk);
        let normals = (&mut mesh.normals[..], layout.normal_bits);
        normals::code(coder, &walk, &geometry, normals);
    }
    let normals = &mesh.normals;
    let same_normal = |a: u32, b: u32| match (normals.get(a as usize), normals.get(b as usize)) {
        (Some(a), Some(b)) => 1 + usize::from(a == b),
        _ => 0,
    };
    if layout.texcoord_bits > 0 {
        let texcoords = (&mut mesh.texcoords[..], layout.texcoord_bits);
        texcoords::code(coder, &walk, texcoords, same_normal);
    }
    let texcoords = &mesh.texcoords;
    let same_both = |a: u32, b: u32| {
        let of_texcoords = texcoords.get(a as usize) == texcoords.get(b as usize);
        same_normal(a, b) + 3 * usize::from(of_texcoords)
    };
    if layout.has_colors {
        colors::code(coder, &walk, &mut mesh.colors, same_both);
    }
    let wedges = (&walk.of_wedges, walk.known_wedges);
    morphs::code(coder, wedges, (&mut mesh.morph_normals, LARGEST_TURN));
}

/// Resizes every list of a decoder's mesh; new values are zero.
fn make_room(surface: &Surface<'_>, layout: &Layout, mesh: &mut QuantisedMesh) {
    fn room<T: Clone>(list: &mut Vec<T>, known: usize, all: usize, zero: T) {
        list.truncate(known);
        list.resize(all, zero);
    }
    let points = (surface.known_points, mesh.positions.len());
    let wedges = (surface.known_wedges, surface.wedge_points.len());
    let either = |has: bool, (known, all): (usize, usize)| if has { (known, all) } else { (0, 0) };
    let (known, all) = either(layout.joints > 0, points);
    room(&mut mesh.skins, known, all, Vec::new());
    let (known, all) = either(layout.normal_bits > 0, wedges);
    room(&mut mesh.normals, known, all, [0; 2]);
    let (known, all) = either(layout.texcoord_bits > 0, wedges);
    room(&mut mesh.texcoords, known, all, [0; 2]);
    let (known, all) = either(layout.has_colors, wedges);
    room(&mut mesh.colors, known, all, [0; 4]);
    mesh.morphs.resize(layout.morphs.len(), Vec::new());
    mesh.morph_normals.resize(layout.morphs.len(), Vec::new());
    for (m, morph) in layout.morphs.iter().enumerate() {
        room(&mut mesh.morphs[m], points.0, points.1, [0; 3]);
        let (known, all) = either(morph.has_normals, wedges);
        room(&mut mesh.morph_normals[m], known, all, [0; 3]);
    }
}
