//! Fewer influences per vertex: the largest weights are kept, the rest is distributed among them.

use articula_core::Mesh;

/// Weights that differ by less than this count as equal, so that vertices at one position that
/// differ by rounding keep the same joints and no seam opens.
const WEIGHT_STEPS: f32 = 4096.0;

/// Keeps the `count` largest of (index, weight) pairs, at least one, and scales them to the sum of
/// all.
///
/// Of equal weights the smaller index stays. If anything was cut, the result is in order of falling
/// weight, otherwise it is untouched.
pub(crate) fn keep_largest(influences: &mut Vec<(u16, f32)>, count: usize) {
    let count = count.max(1);
    if influences.len() <= count {
        return;
    }
    let sum = |list: &[(u16, f32)]| list.iter().map(|(_, w)| *w).sum::<f32>();
    let all = sum(influences);
    influences.sort_by_key(|(index, weight)| {
        let steps = (weight * WEIGHT_STEPS).round() as i64;
        (std::cmp::Reverse(steps), *index)
    });
    influences.truncate(count);
    let left = sum(influences);
    if left > 0.0 {
        for (_, weight) in influences.iter_mut() {
            *weight *= all / left;
        }
    }
}

/// Limits a mesh to `most` influences per vertex (at least one) by [`keep_largest`]; vertices with
/// no more keep theirs bit for bit. Influences of the same binding are added up first where a
/// vertex has too many.
///
/// Returns the largest share of a vertex's weight that was cut. In any pose a vertex moves by at
/// most that share of the distance between the positions to which its joints, each alone, would
/// take it. O(vertices).
pub(crate) fn limit(mesh: &mut Mesh, most: usize) -> f32 {
    let (before, most) = (mesh.influences, most.max(1));
    if before <= most {
        return 0.0;
    }
    let mut worst = 0.0f32;
    let mut list = Vec::with_capacity(before);
    for v in 0..mesh.len() {
        let at = v * before..(v + 1) * before;
        let filler = mesh.binding_indices[at.start];
        let pairs = mesh.binding_indices[at.clone()]
            .iter()
            .zip(&mesh.weights[at]);
        list.clear();
        list.extend(pairs.map(|(i, w)| (*i, *w)).filter(|(_, w)| *w != 0.0));
        if list.len() > most {
            worst = worst.max(cut(&mut list, most));
        }
        // As in `Mesh::new`: a padded influence repeats the first, with weight 0.
        let filler = list.first().map_or(filler, |(index, _)| *index);
        list.resize(most, (filler, 0.0));
        // The new index of an influence never exceeds its old one.
        for (i, (index, weight)) in list.iter().enumerate() {
            mesh.binding_indices[v * most + i] = *index;
            mesh.weights[v * most + i] = *weight;
        }
    }
    mesh.binding_indices.truncate(mesh.len() * most);
    mesh.weights.truncate(mesh.len() * most);
    mesh.influences = most;
    worst
}

/// Adds up influences of the same binding, keeps the largest, and returns the share that was cut.
fn cut(list: &mut Vec<(u16, f32)>, most: usize) -> f32 {
    let mut merged: Vec<(u16, f32)> = Vec::with_capacity(list.len());
    for (index, weight) in list.drain(..) {
        match merged.iter_mut().find(|(i, _)| *i == index) {
            Some((_, sum)) => *sum += weight,
            None => merged.push((index, weight)),
        }
    }
    list.extend(&merged);
    keep_largest(list, most);
    let is_cut = |index: u16| list.iter().all(|(i, _)| *i != index);
    let weights = merged.iter().filter(|(i, _)| is_cut(*i)).map(|(_, w)| *w);
    let all: f32 = merged.iter().map(|(_, w)| *w).sum();
    if all > 0.0 {
        weights.sum::<f32>() / all
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_largest_stay_and_share_what_is_cut() {
        let mut list = vec![(7, 0.1), (3, 0.5), (2, 0.1), (9, 0.3)];
        keep_largest(&mut list, 4);
        assert_eq!(list[0], (7, 0.1), "nothing to cut");
        keep_largest(&mut list, 3);
        let indices: Vec<u16> = list.iter().map(|i| i.0).collect();
        assert_eq!(indices, [3, 9, 2], "of equal ones the smaller index stays");
        assert!((list.iter().map(|i| i.1).sum::<f32>() - 1.0).abs() < 1e-6);
        keep_largest(&mut list, 0);
        assert_eq!(list.len(), 1);
        assert!((list[0].1 - 1.0).abs() < 1e-6);
        let mut rounding = vec![(5, 0.500_000_1), (4, 0.499_999_9)];
        keep_largest(&mut rounding, 1);
        assert_eq!(rounding[0].0, 4, "a seam's two vertices agree");
        let mut none: Vec<(u16, f32)> = vec![];
        keep_largest(&mut none, 1);
        assert!(none.is_empty());
    }

    /// Two vertices; each influence as (binding, weight).
    fn mesh(influences: &[(u16, f32)]) -> Mesh {
        Mesh {
            positions: vec![glam::Vec3::X; 2],
            normals: vec![glam::Vec3::Y; 2],
            influences: influences.len() / 2,
            binding_indices: influences.iter().map(|i| i.0).collect(),
            weights: influences.iter().map(|i| i.1).collect(),
            ..Mesh::default()
        }
    }

    #[test]
    fn a_mesh_is_limited_and_says_what_was_cut() {
        let first = [(1, 0.25), (2, 0.0), (3, 0.5), (1, 0.25)];
        let second = [(4, 0.125), (5, 0.25), (6, 0.125), (7, 0.5)];
        let full = mesh(&[first, second].concat());
        let mut same = full.clone();
        assert_eq!(limit(&mut same, 4), 0.0);
        assert_eq!(same, full, "nothing to cut");

        let mut two = full.clone();
        assert_eq!(limit(&mut two, 2), 0.25);
        assert_eq!(
            two.binding_indices,
            [1, 3, 7, 5],
            "of equal ones the smaller first"
        );
        let third = 1.0 / 3.0;
        let near = |a: f32, b: f32| (a - b).abs() < 1e-6;
        assert_eq!(
            two.weights[..2],
            [0.5, 0.5],
            "two influences of one binding are one"
        );
        assert!(near(two.weights[2], 2.0 * third) && near(two.weights[3], third));

        let mut one = full;
        assert_eq!(limit(&mut one, 0), 0.5, "at least one stays");
        assert_eq!((one.influences, &one.binding_indices[..]), (1, &[1, 7][..]));
        assert_eq!(limit(&mut Mesh::default(), 1), 0.0);
    }

    proptest! {
        #[test]
        fn a_cut_vertex_stays_within_its_share(
            rows in prop::collection::vec((0u16..5, 0.01f32..1.0), 2 * 5),
            places in prop::array::uniform5(prop::array::uniform3(-1.0f32..1.0)),
            most in 1usize..5,
        ) {
            // Each joint alone takes the vertex to a different position.
            let places = places.map(glam::Vec3::from_array);
            let sums = [0, 5].map(|at| rows[at..at + 5].iter().map(|r| r.1).sum::<f32>());
            let row = |(i, r): (usize, &(u16, f32))| (r.0, r.1 / sums[i / 5]);
            let rows: Vec<(u16, f32)> = rows.iter().enumerate().map(row).collect();
            let full = mesh(&rows);
            let mut limited = full.clone();
            let share = limit(&mut limited, most);
            let shown = |mesh: &Mesh, v: usize| -> glam::Vec3 {
                let at = v * mesh.influences..(v + 1) * mesh.influences;
                let pairs = mesh.binding_indices[at.clone()].iter().zip(&mesh.weights[at]);
                pairs.map(|(i, w)| places[usize::from(*i)] * *w).sum()
            };
            let far = |a: &glam::Vec3| places.iter().map(|b| a.distance(*b)).fold(0.0, f32::max);
            let widest = places.iter().map(far).fold(0.0, f32::max);
            for v in 0..2 {
                let moved = shown(&full, v).distance(shown(&limited, v));
                prop_assert!(moved <= share * widest + 1e-5, "{} of {}", moved, share * widest);
            }
        }
    }
}
