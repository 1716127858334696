//! Patches of a skin: vertices that lie together and move alike, with a box that holds them in a pose.
//!
//! A bound is the greatest of many vertices, of which all but a few are far inside. A patch whose box is
//! inside what is known already needs not be skinned, so the bounds are those of every vertex at a
//! fraction of the cost.
//!
//! With weights that sum to 1 a skinned vertex is its place on one binding `d` plus `w (M - M_d) p` for
//! each other binding, so over a patch it lies in the box of the first, moved by at most the greatest
//! weight times the box of each difference.

use crate::skin_patches::{Patch, split};
use articula_core::{Mesh, skin_points};
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

/// Most vertices of a patch.
const PATCH: usize = 48;

/// Part of the magnitudes in a pose that covers the rounding of skinning.
const ROUNDING: f32 = 1e-5;

/// Difference of a sum of weights from 1 that rounding may leave.
const SUM_SLACK: f32 = 1e-5;

/// The patches of a mesh.
pub(super) struct Patches {
    patches: Vec<Patch>,
    /// Vertices of which nothing is known beforehand, since their weights are no shares.
    loose: Vec<u32>,
    /// Greatest coordinate at rest.
    reach: f32,
    /// What morphs do to each patch and, last, to the loose vertices.
    morphs: Vec<Vec<PatchMorph>>,
}

/// What a morph does to a patch.
struct PatchMorph {
    slot: u16,
    /// Offset of each vertex that it moves.
    offsets: Vec<(u32, Vec3)>,
    /// The greatest offset along each axis.
    greatest: Vec3A,
}

/// A mesh with the morph target weights of a pose.
pub(super) struct MorphedSkin<'a> {
    source: &'a Mesh,
    patches: &'a Patches,
    /// The mesh with moved positions, as far as they were asked for.
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

    /// Sets the weights.
    pub(super) fn set(&mut self, weights: &[f32]) {
        if self.weights == weights {
            return;
        }
        self.weights.copy_from_slice(weights);
        for (spread, morphs) in self.spread.iter_mut().zip(&self.patches.morphs) {
            let moved = morphs
                .iter()
                .map(|m| weights[usize::from(m.slot)].abs() * m.greatest);
            *spread = moved.sum();
        }
    }

    /// [`Patches::beyond`] of the moved mesh.
    pub(super) fn beyond(
        &mut self,
        palette: &[Affine3A],
        points: &mut Vec<Vec3>,
        is_within: impl FnMut(Vec3, Vec3) -> bool,
        mut see: impl FnMut(Vec3),
    ) {
        let (patches, spread) = (self.patches, &self.spread);
        let (mesh, source, weights) = (&mut self.mesh, self.source, &self.weights);
        let skin = |place: usize, vertices: &[u32]| {
            let morphs = &patches.morphs[place];
            if !morphs.is_empty() {
                for v in vertices {
                    mesh.positions[*v as usize] = source.positions[*v as usize];
                }
                for morph in morphs {
                    morph.apply(weights, &mut mesh.positions);
                }
            }
            see_all((mesh, palette, points), vertices, &mut see);
        };
        patches.beyond_spread(palette, |p| spread[p], is_within, skin);
    }
}

impl PatchMorph {
    /// Moves vertices at rest, as skinning does.
    fn apply(&self, weights: &[f32], positions: &mut [Vec3]) {
        let weight = weights[usize::from(self.slot)];
        if weight != 0.0 {
            for (v, offset) in &self.offsets {
                positions[*v as usize] += *offset * weight;
            }
        }
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
            split(mesh, binding, vertices, PATCH, &mut patches);
        }
        let coordinates = mesh.positions.iter().map(|p| p.abs().max_element());
        Self {
            reach: coordinates.filter(|c| c.is_finite()).fold(0.0, f32::max),
            morphs: patch_morphs(mesh, &patches),
            patches,
            loose,
        }
    }

    /// Skins the vertices of all patches that are not known to lie within something, by the box around
    /// them, and calls `see` with each.
    pub(super) fn beyond(
        &self,
        (mesh, palette, points): (&Mesh, &[Affine3A], &mut Vec<Vec3>),
        is_within: impl FnMut(Vec3, Vec3) -> bool,
        mut see: impl FnMut(Vec3),
    ) {
        let skin = |_, vertices: &[u32]| see_all((mesh, palette, points), vertices, &mut see);
        self.beyond_spread(palette, |_| Vec3A::ZERO, is_within, skin);
    }

    /// Calls `skin` with the place of a patch, or of the loose vertices behind all patches, and its vertices.
    fn beyond_spread(
        &self,
        palette: &[Affine3A],
        spread: impl Fn(usize) -> Vec3A,
        mut is_within: impl FnMut(Vec3, Vec3) -> bool,
        mut skin: impl FnMut(usize, &[u32]),
    ) {
        for (p, patch) in self.patches.iter().enumerate() {
            let (least, greatest) = around(patch, palette, spread(p), self.reach);
            if !is_within(least, greatest) {
                skin(p, &patch.vertices);
            }
        }
        skin(self.patches.len(), &self.loose);
    }
}

/// Skins some vertices and calls `see` with each.
fn see_all(
    (mesh, palette, points): (&Mesh, &[Affine3A], &mut Vec<Vec3>),
    vertices: &[u32],
    see: &mut impl FnMut(Vec3),
) {
    points.resize(vertices.len(), Vec3::ZERO);
    skin_points(mesh, palette, vertices, points);
    points.iter().for_each(|point| see(*point));
}

/// What the morphs do to each patch and to all other vertices.
fn patch_morphs(mesh: &Mesh, patches: &[Patch]) -> Vec<Vec<PatchMorph>> {
    let mut patch_of = vec![patches.len(); mesh.len()];
    for (p, patch) in patches.iter().enumerate() {
        for v in &patch.vertices {
            patch_of[*v as usize] = p;
        }
    }
    let mut all: Vec<Vec<PatchMorph>> = Vec::new();
    all.resize_with(patches.len() + 1, Vec::new);
    for morph in &mesh.morphs {
        let mut of_patches = vec![Vec::new(); patches.len() + 1];
        for (v, offset) in morph.vertices.iter().zip(&morph.positions) {
            of_patches[patch_of[*v as usize]].push((*v, *offset));
        }
        for (all, offsets) in all.iter_mut().zip(of_patches) {
            if offsets.iter().all(|(_, offset)| *offset == Vec3::ZERO) {
                continue;
            }
            let sizes = offsets.iter().map(|(_, offset)| Vec3A::from(offset.abs()));
            all.push(PatchMorph {
                slot: morph.slot,
                greatest: sizes.fold(Vec3A::ZERO, Vec3A::max),
                offsets,
            });
        }
    }
    all
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

/// Corners of a box that holds a patch in a pose; not finite if the pose is not.
fn around(patch: &Patch, palette: &[Affine3A], spread: Vec3A, reach: f32) -> (Vec3, Vec3) {
    let own = &palette[patch.weights.own.0];
    let (at, sides) = (Vec3A::from(patch.middle), Vec3A::from(patch.half) + spread);
    let reach = reach + spread.max_element();
    let (mut middle, mut half) = moved(own, at, sides);
    let mut magnitude = magnitude(own, reach);
    for (binding, weight) in &patch.weights.others {
        let other = &palette[*binding];
        let apart = Affine3A {
            matrix3: other.matrix3 - own.matrix3,
            translation: other.translation - own.translation,
        };
        let (way, around) = moved(&apart, at, sides);
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

/// Middle and half sides of the box around a moved box, given its own.
fn moved(by: &Affine3A, middle: Vec3A, sides: Vec3A) -> (Vec3A, Vec3A) {
    let Mat3A {
        x_axis,
        y_axis,
        z_axis,
    } = by.matrix3;
    let half = x_axis.abs() * sides.x + y_axis.abs() * sides.y;
    let half = half + z_axis.abs() * sides.z;
    (by.transform_point3a(middle), half)
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
            let (least, greatest) = around(last, &turned, Vec3A::ZERO, 1.0);
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
