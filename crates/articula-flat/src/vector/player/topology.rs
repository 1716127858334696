//! Numbering of the triangles, wedges and points of a player clip.
//!
//! Source: `docs/methods/vector.md` 8.3. Wedges (corners with attributes, after H. Hoppe) are
//! numbered in the order of first use in painting order, so that most corners are the next new one
//! or one used shortly before; each triangle begins with the corners that are already known, which
//! predict the new ones better.

use crate::planar::shading::Shading;
use crate::planar::{Drawn, PlanarClip};
use std::collections::BTreeMap;

/// Numbered triangles, wedges and points, and the vertices they come from.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Topology {
    /// Index in the clip of each triangle, in painting order of the first epoch.
    pub(super) sources: Vec<u32>,
    /// Wedges of each triangle.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Point of each wedge.
    pub(super) wedge_points: Vec<u32>,
    /// A vertex of the clip for each wedge.
    pub(super) wedge_vertices: Vec<u32>,
    /// A vertex of the clip for each point.
    pub(super) point_vertices: Vec<u32>,
}

impl Topology {
    /// Numbers the triangles of `order` that are drawn in some frame, each once.
    pub(super) fn new(clip: &PlanarClip, drawn: &Drawn, order: &[u32], shading: Shading) -> Self {
        let places = clip.position_classes();
        let lights = match shading {
            Shading::Flat => places.clone(),
            Shading::Gouraud => light_classes(clip, &places),
        };
        let mut out = Self::default();
        let mut wedges = BTreeMap::new();
        let mut points = BTreeMap::new();
        let mut is_taken = vec![false; clip.triangles.len()];
        for t in order {
            let is_drawn = (0..drawn.frames()).any(|f| drawn.get(f, *t as usize));
            if std::mem::replace(&mut is_taken[*t as usize], true) || !is_drawn {
                continue;
            }
            let corners = known_first(clip.triangles[*t as usize], |v| {
                wedges.contains_key(&lights[v as usize])
            });
            let numbers = corners.map(|v| {
                *wedges.entry(lights[v as usize]).or_insert_with(|| {
                    let point = *points.entry(places[v as usize]).or_insert_with(|| {
                        out.point_vertices.push(v);
                        out.point_vertices.len() as u32 - 1
                    });
                    out.wedge_points.push(point);
                    out.wedge_vertices.push(v);
                    out.wedge_points.len() as u32 - 1
                })
            });
            out.triangles.push(numbers);
            out.sources.push(*t);
        }
        out
    }

    /// Whether each wedge is a corner of a triangle that shows its colour and not a picture.
    pub(super) fn needs_color(&self, clip: &PlanarClip) -> Vec<bool> {
        let mut needs = vec![false; self.wedge_points.len()];
        for (corners, source) in self.triangles.iter().zip(&self.sources) {
            let texture = clip.texture.as_ref();
            let is_textured = texture.is_some_and(|x| x.shows[*source as usize]);
            for wedge in corners.iter().filter(|_| !is_textured) {
                needs[*wedge as usize] = true;
            }
        }
        needs
    }
}

/// Column that predicts each column, itself if there is none: positions and light of a new wedge
/// are close to those of the corner named before it.
pub(super) fn parents(triangles: &[[u32; 3]], wedge_points: &[u32], light: bool) -> Vec<u32> {
    let mut of_points: Vec<u32> = Vec::new();
    let mut of_wedges: Vec<u32> = Vec::new();
    let mut before = 0u32;
    for wedge in triangles.iter().flatten() {
        if *wedge as usize == of_wedges.len() {
            if wedge_points[*wedge as usize] as usize == of_points.len() {
                of_points.push(wedge_points[before as usize]);
            }
            of_wedges.push(before);
        }
        before = *wedge;
    }
    let first_light = 2 * of_points.len() as u32;
    let mut columns: Vec<u32> = of_points.iter().flat_map(|p| [2 * p, 2 * p + 1]).collect();
    if light {
        columns.extend(of_wedges.iter().map(|w| first_light + w));
    }
    columns
}

/// Wedge that each wedge follows, itself for the first: texture coordinates of a new wedge are close
/// to those of the corner named before it.
pub(super) fn wedge_parents(triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut parents = Vec::new();
    let mut before = 0;
    for wedge in triangles.iter().flatten() {
        if *wedge as usize == parents.len() {
            parents.push(before);
        }
        before = *wedge;
    }
    parents
}

/// Class of each vertex: equal for vertices that agree in position, albedo and light in every
/// frame.
fn light_classes(clip: &PlanarClip, places: &[u32]) -> Vec<u32> {
    let mut classes = places.to_vec();
    let paint = VertexPaint::new(clip);
    refine(&mut classes, |v| paint.key(clip, v));
    for frame in &clip.frames {
        refine(&mut classes, |v| frame.light[v].to_bits());
    }
    classes
}

/// What the triangles of each vertex need of it: its albedo, its place in the picture, or both.
struct VertexPaint {
    needs_albedo: Vec<bool>,
    needs_place: Vec<bool>,
}

impl VertexPaint {
    fn new(clip: &PlanarClip) -> Self {
        let mut paint = Self {
            needs_albedo: vec![false; clip.albedo.len()],
            needs_place: vec![false; clip.albedo.len()],
        };
        for (t, corners) in clip.triangles.iter().enumerate() {
            let is_textured = clip.texture.as_ref().is_some_and(|x| x.shows[t]);
            for v in corners {
                paint.needs_place[*v as usize] |= is_textured;
                paint.needs_albedo[*v as usize] |= !is_textured;
            }
        }
        paint
    }

    /// Equal for vertices that look alike in the same light.
    fn key(&self, clip: &PlanarClip, vertex: usize) -> (Option<[u32; 3]>, Option<[u32; 2]>) {
        let albedo = clip.albedo[vertex].map(f32::to_bits);
        let place = clip.texture.as_ref().map(|x| x.places[vertex]);
        let place = place.map(|place| place.to_array().map(f32::to_bits));
        (
            self.needs_albedo[vertex].then_some(albedo),
            place.filter(|_| self.needs_place[vertex]),
        )
    }
}

fn refine<K: Ord>(classes: &mut [u32], key: impl Fn(usize) -> K) {
    let mut known = BTreeMap::new();
    for (v, class) in classes.iter_mut().enumerate() {
        let next = known.len() as u32;
        *class = *known.entry((*class, key(v))).or_insert(next);
    }
}

/// Rotates the corners so that as many known ones as possible come first.
fn known_first(corners: [u32; 3], is_known: impl Fn(u32) -> bool) -> [u32; 3] {
    let [a, b, c] = corners;
    match corners.map(is_known) {
        [false, true, _] => [b, c, a],
        [_, false, true] => [c, a, b],
        _ => corners,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::clip::fixture;

    /// Two triangles that share an edge by position; with `lit` one corner of it differs in light.
    fn pair(lit: bool) -> (PlanarClip, Drawn) {
        let mut clip = fixture::loose(
            &[
                ([[1.0, 1.0, 0.5], [1.0, 9.0, 0.5], [9.0, 1.0, 0.5]], [9; 3]),
                ([[9.0, 9.0, 0.5], [9.0, 1.0, 0.5], [1.0, 9.0, 0.5]], [9; 3]),
            ],
            2,
        );
        if lit {
            clip.frames[1].light[4] = 0.5;
        }
        let drawn = Drawn::of(&clip).unwrap();
        (clip, drawn)
    }

    #[test]
    fn vertices_at_one_place_are_one_point_and_one_wedge_if_lit_alike() {
        let (clip, drawn) = pair(false);
        let found = Topology::new(&clip, &drawn, &[0, 1], Shading::Gouraud);
        // The second triangle begins with its two known corners.
        assert_eq!(found.triangles, [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(found.wedge_points, [0, 1, 2, 3]);
        let (clip, drawn) = pair(true);
        let found = Topology::new(&clip, &drawn, &[1, 0], Shading::Gouraud);
        assert_eq!(found.sources, [1, 0]);
        assert_eq!(found.triangles, [[0, 1, 2], [2, 3, 4]]);
        assert_eq!(found.wedge_points, [0, 1, 2, 1, 3]);
        let flat = Topology::new(&clip, &drawn, &[1, 0], Shading::Flat);
        assert_eq!(flat.wedge_points, [0, 1, 2, 3]);
    }

    #[test]
    fn columns_are_guessed_from_the_corner_named_before() {
        let found = parents(&[[0, 1, 2], [2, 3, 4]], &[0, 1, 2, 1, 3], true);
        // Points 0, 1, 2 after 0, 0, 1; point 3 comes with wedge 4 after wedge 3, at point 1.
        assert_eq!(found[..8], [0, 1, 0, 1, 2, 3, 2, 3]);
        assert_eq!(found[8..], [8, 8, 9, 10, 11]);
        for (column, parent) in found.iter().enumerate() {
            assert!(*parent as usize <= column);
        }
        // Those of light, counted from the first wedge.
        let wedges: Vec<u32> = found[8..].iter().map(|c| c - 8).collect();
        assert_eq!(wedge_parents(&[[0, 1, 2], [2, 3, 4]]), wedges);
    }

    #[test]
    fn what_is_never_drawn_or_named_twice_is_left_out() {
        let (clip, mut drawn) = pair(false);
        for f in 0..2 {
            drawn.set(f, 0, false);
        }
        let found = Topology::new(&clip, &drawn, &[1, 0, 1], Shading::Gouraud);
        assert_eq!((found.sources, found.point_vertices.len()), (vec![1], 3));
    }
}
