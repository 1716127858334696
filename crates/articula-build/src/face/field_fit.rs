//! Fields of displacements as sums of others, by least squares.

use super::dense::solve;
use glam::{DVec3, Vec3};

/// Displacement, relative to the largest of its field, below which a vertex does not count as moved.
const STILL: f32 = 1e-4;

/// A set of fields of displacements whose weighted sums approximate others.
#[derive(Debug, Clone)]
pub struct FieldFit {
    /// Moved vertices of each field of length 1, ascending.
    fields: Vec<Vec<(u32, DVec3)>>,
    /// Length of each field: the root of the sum of its squared displacements. 0 for one that moves
    /// nothing.
    lengths: Vec<f64>,
    /// Inverse of the matrix of the normal equations.
    inverse: Vec<f64>,
}

impl FieldFit {
    /// Creates a fit from the displacement of each vertex under each field at weight 1. The squared
    /// share of a field in the sum, its weight times its length, costs `ridge` times as much as an error
    /// of the same size; one ridge above 0 for each field. O(n³ + n² v) for n fields and v vertices.
    ///
    /// # Panics
    /// If the fields differ in their number of vertices, or there is not one ridge for each.
    pub fn new(fields: &[Vec<Vec3>], ridges: &[f64]) -> Self {
        let n = fields.len();
        let vertices = fields.first().map_or(0, Vec::len);
        let is_like = |field: &Vec<Vec3>| field.len() == vertices;
        assert!(fields.iter().all(is_like), "one offset for each vertex");
        assert_eq!(ridges.len(), n, "one ridge for each field");
        let lengths: Vec<f64> = fields.iter().map(|field| length(field)).collect();
        let sparse = |(field, length): (&Vec<Vec3>, &f64)| {
            let largest = field.iter().map(|o| o.length()).fold(0.0, f32::max);
            let moved = (0..)
                .zip(field)
                .filter(|(_, o)| o.length() > STILL * largest);
            moved.map(|(v, o)| (v, o.as_dvec3() / *length)).collect()
        };
        let fields: Vec<Vec<(u32, DVec3)>> = fields.iter().zip(&lengths).map(sparse).collect();
        let mut matrix = vec![0.0; n * n];
        let mut dense = vec![DVec3::ZERO; vertices];
        for i in 0..n {
            fields[i].iter().for_each(|(v, o)| dense[*v as usize] = *o);
            for j in i..n {
                let product = fields[j].iter().map(|(v, o)| o.dot(dense[*v as usize]));
                let product: f64 = product.sum();
                matrix[i * n + j] = product;
                matrix[j * n + i] = product;
            }
            matrix[i * n + i] += ridges[i];
            fields[i]
                .iter()
                .for_each(|(v, _)| dense[*v as usize] = DVec3::ZERO);
        }
        let mut inverse = vec![0.0; n * n];
        (0..n).for_each(|i| inverse[i * n + i] = 1.0);
        if solve(&mut matrix, &mut inverse, n).is_none() {
            inverse.fill(0.0);
        }
        Self {
            fields,
            lengths,
            inverse,
        }
    }

    /// Returns the weight of each field whose sum is nearest to a target: the displacement of each
    /// vertex.
    ///
    /// # Panics
    /// If the target has fewer vertices than the fields.
    pub fn weights(&self, target: &[Vec3]) -> Vec<f32> {
        let along = self.fields.iter().map(|field| {
            let products = field
                .iter()
                .map(|(v, o)| o.dot(target[*v as usize].as_dvec3()));
            products.sum::<f64>()
        });
        let along: Vec<f64> = along.collect();
        let n = self.fields.len();
        let weight = |i: usize| {
            let row = self.inverse[i * n..(i + 1) * n].iter().zip(&along);
            let share: f64 = row.map(|(a, b)| a * b).sum();
            if self.lengths[i] > 0.0 {
                (share / self.lengths[i]) as f32
            } else {
                0.0
            }
        };
        (0..n).map(weight).collect()
    }
}

fn length(field: &[Vec3]) -> f64 {
    let squares = field.iter().map(|o| f64::from(o.length_squared()));
    squares.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Two vertices: the first field lifts the first, the second moves both sideways.
    fn fields() -> Vec<Vec<Vec3>> {
        vec![
            vec![Vec3::Y, Vec3::ZERO],
            vec![2.0 * Vec3::X, 2.0 * Vec3::X],
        ]
    }

    #[test]
    fn what_nothing_shows_is_left_over() {
        let fit = FieldFit::new(&fields(), &[1e-9; 2]);
        // Sideways by 1 and 3: the field shows their mean of 2. Depth is not shown at all.
        let target = [Vec3::new(1.0, 0.5, 4.0), Vec3::new(3.0, 0.0, 4.0)];
        let weights = fit.weights(&target);
        assert!((weights[0] - 0.5).abs() < 1e-6 && (weights[1] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_ridge_shrinks_its_field_alone() {
        // A field of length 1 with ridge 1: half of the target.
        let fit = FieldFit::new(&fields(), &[1.0, 1e-9]);
        let weights = fit.weights(&[Vec3::new(2.0, 1.0, 0.0), Vec3::new(2.0, 0.0, 0.0)]);
        assert!((weights[0] - 0.5).abs() < 1e-6 && (weights[1] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_field_that_moves_nothing_has_no_weight() {
        let fit = FieldFit::new(&[vec![Vec3::ZERO; 2], fields()[0].clone()], &[1e-9; 2]);
        let weights = fit.weights(&[Vec3::Y, Vec3::Y]);
        assert_eq!(weights[0], 0.0);
        assert!((weights[1] - 1.0).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn sums_come_back(a in -5.0..5.0_f32, b in -5.0..5.0_f32) {
            let fields = fields();
            let fit = FieldFit::new(&fields, &[1e-9; 2]);
            let sum = fields[0].iter().zip(&fields[1]).map(|(x, y)| a * *x + b * *y);
            let weights = fit.weights(&sum.collect::<Vec<_>>());
            prop_assert!((weights[0] - a).abs() < 1e-4 && (weights[1] - b).abs() < 1e-4);
        }
    }
}
