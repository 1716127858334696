//! Patches of a skin: vertices that lie together and are moved by the same bindings.
//!
//! What is bounded for a patch need not be computed for each of its vertices.

use articula_core::Mesh;
use glam::Vec3;

/// Vertices on one binding, and in part on others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Patch {
    pub(crate) vertices: Vec<u32>,
    pub(crate) weights: GreatestWeights,
    /// Greatest difference of the sum of the weights of a vertex from 1.
    pub(crate) unbalanced: f32,
    /// Box around the positions of the mesh.
    pub(crate) middle: Vec3,
    /// Half the sides of that box.
    pub(crate) half: Vec3,
}

/// Bindings of some vertices, each with the greatest magnitude of its weight.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GreatestWeights {
    /// The binding that the vertices lie on.
    pub(crate) own: (usize, f32),
    pub(crate) others: Vec<(usize, f32)>,
}

impl GreatestWeights {
    /// Those of no vertices.
    pub(crate) fn on(binding: usize) -> Self {
        Self {
            own: (binding, 0.0),
            others: Vec::new(),
        }
    }

    fn hold(&mut self, binding: usize, weight: f32) {
        if binding == self.own.0 {
            self.own.1 = self.own.1.max(weight);
        } else {
            change(&mut self.others, binding, |most| most.max(weight));
        }
    }

    /// Adds vertices on the same binding.
    pub(crate) fn join(&mut self, other: &Self) {
        let others = other.others.iter();
        others
            .chain([&other.own])
            .for_each(|(binding, weight)| self.hold(*binding, *weight));
    }
}

/// Halves vertices across the longest side of their box until there are at most `most` in a patch.
///
/// Their positions must be finite.
pub(crate) fn split(
    mesh: &Mesh,
    binding: usize,
    mut vertices: Vec<u32>,
    most: usize,
    patches: &mut Vec<Patch>,
) {
    let place = |v: &u32| mesh.positions[*v as usize];
    let Some(first) = vertices.first().map(place) else {
        return;
    };
    let corners = |(least, greatest): (Vec3, Vec3), p: Vec3| (least.min(p), greatest.max(p));
    let (least, greatest) = vertices.iter().map(place).fold((first, first), corners);
    if vertices.len() > most {
        let sides = greatest - least;
        let axis = (0..3).fold(0, |a, b| if sides[b] > sides[a] { b } else { a });
        let middle = vertices.len() / 2;
        vertices.select_nth_unstable_by(middle, |a, b| {
            place(a)[axis].total_cmp(&place(b)[axis]).then(a.cmp(b))
        });
        let other = vertices.split_off(middle);
        split(mesh, binding, vertices, most, patches);
        split(mesh, binding, other, most, patches);
        return;
    }
    let mut weights = GreatestWeights::on(binding);
    let mut unbalanced = 0.0f32;
    for v in &vertices {
        let of = *v as usize * mesh.influences..(*v as usize + 1) * mesh.influences;
        let sum: f32 = mesh.weights[of.clone()].iter().sum();
        unbalanced = unbalanced.max((sum - 1.0).abs());
        let mut own: Vec<(usize, f32)> = Vec::new();
        for (b, weight) in mesh.binding_indices[of.clone()]
            .iter()
            .zip(&mesh.weights[of])
        {
            // A vertex may name a binding twice.
            change(&mut own, usize::from(*b), |sum| sum + weight.abs());
        }
        for (b, weight) in own.into_iter().filter(|(_, w)| *w > 0.0) {
            weights.hold(b, weight);
        }
    }
    patches.push(Patch {
        vertices,
        weights,
        unbalanced,
        middle: 0.5 * (least + greatest),
        half: 0.5 * (greatest - least),
    });
}

fn change(all: &mut Vec<(usize, f32)>, binding: usize, to: impl Fn(f32) -> f32) {
    match all.iter_mut().find(|(b, _)| *b == binding) {
        Some((_, weight)) => *weight = to(*weight),
        None => all.push((binding, to(0.0))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_are_small_boxes_with_all_bindings() {
        let mesh = Mesh {
            positions: (0..10).map(|v| Vec3::new(v as f32, 0.0, 1.0)).collect(),
            influences: 3,
            binding_indices: [2, 1, 2].repeat(10),
            weights: (0..10)
                .flat_map(|v| [0.5, -0.125 * v as f32, 0.25])
                .collect(),
            ..Mesh::default()
        };
        let mut patches = Vec::new();
        split(&mesh, 2, vec![9, 3, 0, 1, 2, 4, 5, 6, 8], 3, &mut patches);
        let mut all: Vec<u32> = patches.iter().flat_map(|p| p.vertices.clone()).collect();
        all.sort_unstable();
        assert_eq!(all, [0, 1, 2, 3, 4, 5, 6, 8, 9], "each once");
        assert!(patches.iter().all(|p| p.vertices.len() <= 3));
        let last = patches.iter().find(|p| p.vertices.contains(&9)).unwrap();
        // A binding that is named twice has the sum of its weights.
        let weights = |own: f32, other: f32| GreatestWeights {
            own: (2, own),
            others: vec![(1, other)],
        };
        assert_eq!(last.weights, weights(0.75, 1.125));
        assert_eq!(last.unbalanced, 1.375);
        let least = *last.vertices.iter().min().unwrap() as f32;
        assert_eq!(last.middle, Vec3::new(0.5 * (least + 9.0), 0.0, 1.0));
        assert_eq!(last.half, Vec3::new(0.5 * (9.0 - least), 0.0, 0.0));
        let mut whole = GreatestWeights::on(2);
        patches.iter().for_each(|p| whole.join(&p.weights));
        assert_eq!(whole, weights(0.75, 1.125));
    }
}
