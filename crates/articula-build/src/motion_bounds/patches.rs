//! Patches of a skin: vertices that lie together and move alike, with a box that holds them in a pose.
//!
//! A bound is the greatest of many vertices, of which all but a few are far inside. A patch whose box is
//! inside what is known already needs not be skinned, so the bounds are those of every vertex at a
//! fraction of the cost.
//!
//! With weights that sum to 1 a skinned vertex is its place on one binding `d` plus `w (M - M_d) p` for
//! each other binding, so over a patch it lies in the box of the first, moved by at most the greatest
//! weight times the box of each difference.

use articula_core::{Mesh, skin_points};
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

/// Most vertices of a patch.
const PATCH: usize = 48;

/// Part of the magnitudes in a pose that covers the rounding of skinning.
const ROUNDING: f32 = 1e-5;

/// Difference of a sum of weights from 1 that rounding may leave.
const SUM_SLACK: f32 = 1e-5;

/// Vertices on one binding, and in part on others.
struct Patch {
    vertices: Vec<u32>,
    /// The binding with the greatest weight.
    binding: usize,
    /// Other bindings, each with its greatest weight.
    others: Vec<(usize, f32)>,
    /// Box around the rest positions.
    middle: Vec3A,
    half: Vec3A,
}

/// The patches of a mesh.
pub(super) struct Patches {
    patches: Vec<Patch>,
    /// Vertices of which nothing is known beforehand, since their weights are no shares.
    loose: Vec<u32>,
    /// Greatest coordinate at rest.
    reach: f32,
    /// Of each morph the patches that it moves, with the greatest offset along each axis.
    morphs: Vec<Vec<(usize, Vec3A)>>,
}

/// A mesh with the morph target weights of a pose.
pub(super) struct MorphedSkin<'a> {
    source: &'a Mesh,
    patches: &'a Patches,
    /// The mesh with moved positions.
    mesh: Mesh,
    weights: Vec<f32>,
    /// How far each patch is moved at most along each axis.
    spread: Vec<Vec3A>,
}

impl<'a> MorphedSkin<'a> {
    pub(super) fn new(source: &'a Mesh, patches: &'a Patches) -> Self {
        Self {
            mesh: source.clone(),
            weights: vec![0.0; source.morph_weights.len()],
            spread: vec![Vec3A::ZERO; patches.patches.len()],
            source,
            patches,
        }
    }

    /// Moves the vertices at rest, as skinning does.
    pub(super) fn set(&mut self, weights: &[f32]) {
        if self.weights == weights {
            return;
        }
        self.weights.copy_from_slice(weights);
        self.mesh.positions.copy_from_slice(&self.source.positions);
        self.spread.fill(Vec3A::ZERO);
        for (morph, of_patches) in self.source.morphs.iter().zip(&self.patches.morphs) {
            let weight = weights[usize::from(morph.slot)];
            if weight == 0.0 {
                continue;
            }
            for (v, offset) in morph.vertices.iter().zip(&morph.positions) {
                self.mesh.positions[*v as usize] += *offset * weight;
            }
            for (patch, greatest) in of_patches {
                self.spread[*patch] += weight.abs() * *greatest;
            }
        }
    }

    /// [`Patches::beyond`] of the moved mesh.
    pub(super) fn beyond(
        &self,
        palette: &[Affine3A],
        points: &mut Vec<Vec3>,
        is_within: impl FnMut(Vec3, Vec3) -> bool,
        see: impl FnMut(Vec3),
    ) {
        let spread = |patch: usize| self.spread[patch];
        let skin = (&self.mesh, palette, points);
        self.patches.beyond_spread(skin, spread, is_within, see);
    }
}

impl Patches {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut loose = Vec::new();
        let mut of_binding = vec![Vec::new(); mesh.bindings.len()];
        for v in 0..mesh.len() {
            match dominant(mesh, v) {
                Some(binding) => of_binding[binding].push(v as u32),
                None => loose.push(v as u32),
            }
        }
        let mut patches = Vec::new();
        for (binding, vertices) in of_binding.into_iter().enumerate() {
            split(mesh, binding, vertices, &mut patches);
        }
        let coordinates = mesh.positions.iter().map(|p| p.abs().max_element());
        Self {
            reach: coordinates.filter(|c| c.is_finite()).fold(0.0, f32::max),
            morphs: moved_patches(mesh, &patches),
            patches,
            loose,
        }
    }

    /// Skins the vertices of all patches that are not known to lie within something, by the box around
    /// them, and calls `see` with each.
    pub(super) fn beyond(
        &self,
        skin: (&Mesh, &[Affine3A], &mut Vec<Vec3>),
        is_within: impl FnMut(Vec3, Vec3) -> bool,
        see: impl FnMut(Vec3),
    ) {
        self.beyond_spread(skin, |_| Vec3A::ZERO, is_within, see);
    }

    fn beyond_spread(
        &self,
        (mesh, palette, points): (&Mesh, &[Affine3A], &mut Vec<Vec3>),
        spread: impl Fn(usize) -> Vec3A,
        mut is_within: impl FnMut(Vec3, Vec3) -> bool,
        mut see: impl FnMut(Vec3),
    ) {
        let mut skin = |vertices: &[u32]| {
            points.resize(vertices.len(), Vec3::ZERO);
            skin_points(mesh, palette, vertices, points);
            points.iter().for_each(|point| see(*point));
        };
        for (p, patch) in self.patches.iter().enumerate() {
            let (least, greatest) = patch.around(palette, spread(p), self.reach);
            if !is_within(least, greatest) {
                skin(&patch.vertices);
            }
        }
        skin(&self.loose);
    }
}

/// Of each morph the patches that it moves.
fn moved_patches(mesh: &Mesh, patches: &[Patch]) -> Vec<Vec<(usize, Vec3A)>> {
    let mut patch_of = vec![None; mesh.len()];
    for (p, patch) in patches.iter().enumerate() {
        for v in &patch.vertices {
            patch_of[*v as usize] = Some(p);
        }
    }
    let of_morph = mesh.morphs.iter().map(|morph| {
        let mut greatest = vec![Vec3A::ZERO; patches.len()];
        for (v, offset) in morph.vertices.iter().zip(&morph.positions) {
            if let Some(p) = patch_of[*v as usize] {
                greatest[p] = greatest[p].max(Vec3A::from(offset.abs()));
            }
        }
        let moved = greatest.into_iter().enumerate();
        moved.filter(|(_, g)| *g != Vec3A::ZERO).collect()
    });
    of_morph.collect()
}

/// The binding with the greatest weight of a vertex, if its weights are shares and it has a place.
fn dominant(mesh: &Mesh, vertex: usize) -> Option<usize> {
    let of = vertex * mesh.influences..(vertex + 1) * mesh.influences;
    let weights = &mesh.weights[of.clone()];
    let sum: f32 = weights.iter().sum();
    let are_shares = weights.iter().all(|w| *w >= 0.0) && (sum - 1.0).abs() <= SUM_SLACK;
    let first = |best: usize, i: usize| if weights[i] > weights[best] { i } else { best };
    let best = (0..weights.len()).reduce(first)?;
    let binding = usize::from(mesh.binding_indices[of.start + best]);
    (are_shares && mesh.positions[vertex].is_finite()).then_some(binding)
}

/// Halves vertices across the longest side of their box until they are few.
fn split(mesh: &Mesh, binding: usize, mut vertices: Vec<u32>, patches: &mut Vec<Patch>) {
    let place = |v: &u32| mesh.positions[*v as usize];
    let Some(first) = vertices.first().map(place) else {
        return;
    };
    let corners = |(least, greatest): (Vec3, Vec3), p: Vec3| (least.min(p), greatest.max(p));
    let (least, greatest) = vertices.iter().map(place).fold((first, first), corners);
    if vertices.len() > PATCH {
        let sides = greatest - least;
        let axis = (0..3).fold(0, |a, b| if sides[b] > sides[a] { b } else { a });
        let middle = vertices.len() / 2;
        vertices.select_nth_unstable_by(middle, |a, b| {
            place(a)[axis].total_cmp(&place(b)[axis]).then(a.cmp(b))
        });
        let other = vertices.split_off(middle);
        split(mesh, binding, vertices, patches);
        split(mesh, binding, other, patches);
        return;
    }
    let mut others: Vec<(usize, f32)> = Vec::new();
    for v in &vertices {
        let of = *v as usize * mesh.influences..(*v as usize + 1) * mesh.influences;
        let mut own: Vec<(usize, f32)> = Vec::new();
        for (b, weight) in mesh.binding_indices[of.clone()]
            .iter()
            .zip(&mesh.weights[of])
        {
            // A vertex may name a binding twice.
            add(&mut own, usize::from(*b), |sum| sum + weight);
        }
        for (b, weight) in own.into_iter().filter(|(b, w)| *b != binding && *w > 0.0) {
            add(&mut others, b, |most| most.max(weight));
        }
    }
    patches.push(Patch {
        vertices,
        binding,
        others,
        middle: (0.5 * (least + greatest)).into(),
        half: (0.5 * (greatest - least)).into(),
    });
}

fn add(all: &mut Vec<(usize, f32)>, binding: usize, change: impl Fn(f32) -> f32) {
    match all.iter_mut().find(|(b, _)| *b == binding) {
        Some((_, weight)) => *weight = change(*weight),
        None => all.push((binding, change(0.0))),
    }
}

impl Patch {
    /// Corners of a box that holds the patch in a pose; not finite if the pose is not.
    fn around(&self, palette: &[Affine3A], spread: Vec3A, reach: f32) -> (Vec3, Vec3) {
        let own = &palette[self.binding];
        let sides = self.half + spread;
        let reach = reach + spread.max_element();
        let (mut middle, mut half) = self.moved(own, sides);
        let mut magnitude = magnitude(own, reach);
        for (binding, weight) in &self.others {
            let other = &palette[*binding];
            let apart = Affine3A {
                matrix3: other.matrix3 - own.matrix3,
                translation: other.translation - own.translation,
            };
            let (way, around) = self.moved(&apart, sides);
            // From no weight to the greatest.
            let (least, greatest) = (way - around, way + around);
            let least = *weight * least.min(Vec3A::ZERO);
            let greatest = *weight * greatest.max(Vec3A::ZERO);
            middle += 0.5 * (least + greatest);
            half += 0.5 * (greatest - least);
            magnitude = magnitude.max(self::magnitude(other, reach));
        }
        half += Vec3A::splat(ROUNDING * magnitude);
        ((middle - half).into(), (middle + half).into())
    }

    /// Middle and half sides of the box around the moved box at rest, given its half sides.
    fn moved(&self, by: &Affine3A, sides: Vec3A) -> (Vec3A, Vec3A) {
        let Mat3A {
            x_axis,
            y_axis,
            z_axis,
        } = by.matrix3;
        let half = x_axis.abs() * sides.x + y_axis.abs() * sides.y;
        let half = half + z_axis.abs() * sides.z;
        (by.transform_point3a(self.middle), half)
    }
}

/// Bound on the numbers that are added where a vertex is placed by a matrix.
fn magnitude(matrix: &Affine3A, reach: f32) -> f32 {
    let m = &matrix.matrix3;
    let rows = m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs();
    (reach * rows + matrix.translation.abs()).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_lods::test_figures::arm;
    use crate::split_mix::SplitMix;
    use articula_core::{SkinnedMesh, skin};
    use glam::Quat;

    /// Numbers between -1 and 1.
    fn number(random: &mut SplitMix) -> f32 {
        2.0 * random.unit() - 1.0
    }

    /// A skin of many vertices on four bindings, some of whose weights are no shares.
    fn scattered(random: &mut SplitMix) -> Mesh {
        let (count, bindings) = (700, 4);
        let mut mesh = Mesh::clone(&arm(bindings).mesh);
        mesh.influences = 2;
        let place = |_| Vec3::from_array([(); 3].map(|()| number(random)));
        mesh.positions = (0..count).map(place).collect();
        mesh.normals = vec![Vec3::Y; count];
        mesh.binding_indices = (0..2 * count)
            .map(|i| (i * 7 % 13 % bindings) as u16)
            .collect();
        mesh.weights = (0..count)
            .flat_map(|v| {
                let part = (v * 31 % 101) as f32 / 101.0;
                match v % 90 {
                    0 => [1.5, part],
                    1 => [1.2, -0.2],
                    _ => [part, 1.0 - part],
                }
            })
            .collect();
        mesh
    }

    fn palette(random: &mut SplitMix, count: usize) -> Vec<Affine3A> {
        let matrix = |_| {
            let [x, y, z] = [(); 3].map(|()| number(random));
            let turn = Quat::from_euler(glam::EulerRot::XYZ, 3.0 * x, 3.0 * y, 3.0 * z);
            let scale = Vec3::new(1.0 + 0.5 * x, 1.0, 1.0 - 0.3 * y);
            Affine3A::from_scale_rotation_translation(scale, turn, Vec3::new(y, z, x))
        };
        (0..count).map(matrix).collect()
    }

    #[test]
    fn what_is_left_out_lies_within() {
        let mut random = SplitMix(5);
        for round in 0..20 {
            let mesh = scattered(&mut random);
            let palette = palette(&mut random, mesh.bindings.len());
            let patches = Patches::new(&mesh);
            assert!(!patches.loose.is_empty());
            let mut skinned = SkinnedMesh::new(&mesh);
            skin(&mesh, &palette, &mesh.morph_weights, &mut skinned);
            let limit = 0.1 * round as f32;
            let mut seen = Vec::new();
            let within = |least: Vec3, greatest: Vec3| {
                least.min_element() >= -limit && greatest.max_element() <= limit
            };
            let skin = (&mesh, &palette[..], &mut Vec::new());
            patches.beyond(skin, within, |p| seen.push(p));
            // All that lie beyond are seen, with the bits of skinning.
            for p in &skinned.positions {
                assert!(p.abs().max_element() <= limit || seen.contains(p), "{p}");
            }
            assert!(seen.iter().all(|p| skinned.positions.contains(p)));
        }
    }

    #[test]
    fn a_vertex_alone_has_a_box_as_small_as_itself() {
        let mut mesh = scattered(&mut SplitMix(1));
        mesh.positions.truncate(3);
        mesh.binding_indices.truncate(6);
        mesh.weights = vec![0.5, 0.5, 0.5, 0.5, 1.0, 0.0];
        let turned = palette(&mut SplitMix(2), mesh.bindings.len());
        let patches = Patches::new(&mesh);
        let last = patches.patches.iter().find(|p| p.vertices == [2]);
        if let Some(last) = last {
            let (least, greatest) = last.around(&turned, Vec3A::ZERO, 1.0);
            assert!((greatest - least).max_element() < 1e-3);
        }
        // A pose that is not finite is never within.
        let lost = vec![Affine3A::from_translation(Vec3::NAN); mesh.bindings.len()];
        let mut count = 0;
        let within = |least: Vec3, greatest: Vec3| {
            least.min_element() >= -9.0 && greatest.max_element() <= 9.0
        };
        patches.beyond((&mesh, &lost, &mut Vec::new()), within, |_| count += 1);
        assert_eq!(count, 3);
    }
}
