//! Distances between postures in the space of their principal components: a baseline of the whole
//! body.
//!
//! Source: thesis 5.2, which tried them before its metric for each joint;
//! `docs/methods/motion-lod.md` 3.5 states what it leaves open.

/// Fraction of the variance that the components kept hold together.
const KEPT: f64 = 0.99;

/// Maximum number of steps of a power iteration, and the change of the vector below which it ends.
const STEPS: usize = 500;
const STILL: f64 = 1e-12;

/// The postures of a clip by their coefficients of principal components.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PostureSpace {
    /// `coefficients[frame][component]`, in the unit of the parameters.
    coefficients: Vec<Vec<f64>>,
}

impl PostureSpace {
    /// Projects postures, of equal numbers of parameters, onto the fewest components that hold
    /// [`KEPT`] of their variance.
    pub(crate) fn of(postures: &[Vec<f64>]) -> Self {
        let count = postures.len().max(1) as f64;
        let size = postures.first().map_or(0, Vec::len);
        let mean: Vec<f64> = (0..size)
            .map(|i| postures.iter().map(|p| p[i]).sum::<f64>() / count)
            .collect();
        let centred: Vec<Vec<f64>> = postures
            .iter()
            .map(|p| p.iter().zip(&mean).map(|(x, m)| x - m).collect())
            .collect();
        let mut covariance = vec![0.0; size * size];
        for posture in &centred {
            for (row, x) in covariance.chunks_mut(size.max(1)).zip(posture) {
                for (sum, y) in row.iter_mut().zip(posture) {
                    *sum += x * y / count;
                }
            }
        }
        let components = components(&mut covariance, size, KEPT);
        let project = |posture: &Vec<f64>| components.iter().map(|c| dot(c, posture)).collect();
        Self {
            coefficients: centred.iter().map(project).collect(),
        }
    }

    /// The frames at which a posture that is held is renewed: as soon as its Euclidean distance to
    /// the frame's own exceeds `radians`. The first frame is one of them.
    pub(crate) fn held(&self, radians: f64) -> Vec<usize> {
        let mut starts = Vec::new();
        for (frame, now) in self.coefficients.iter().enumerate() {
            let held = starts
                .last()
                .map(|start: &usize| &self.coefficients[*start]);
            if held.is_none_or(|held| distance(held, now) > radians) {
                starts.push(frame);
            }
        }
        starts
    }
}

/// Unit eigenvectors of a covariance matrix of `size` rows, largest variance first, until they hold
/// the fraction `kept` of the variance. The matrix is left with what they do not hold.
///
/// Power iteration with deflation. Where two variances are equal, any vector of their plane will do
/// for distances.
fn components(covariance: &mut [f64], size: usize, kept: f64) -> Vec<Vec<f64>> {
    let total: f64 = (0..size).map(|i| covariance[i * size + i]).sum();
    let mut found: Vec<Vec<f64>> = Vec::new();
    let mut held = 0.0;
    while found.len() < size && held < kept * total {
        // The row of the largest variance has a part along an eigenvector that is left.
        let variance = |i: &usize| covariance[i * size + i];
        let Some(start) = (0..size).max_by(|a, b| variance(a).total_cmp(&variance(b))) else {
            break;
        };
        let mut vector = covariance[start * size..(start + 1) * size].to_vec();
        if !normalise(&mut vector) {
            break;
        }
        for _ in 0..STEPS {
            let mut next = times(covariance, &vector);
            if !normalise(&mut next) {
                break;
            }
            let change = distance(&next, &vector);
            vector = next;
            if change < STILL {
                break;
            }
        }
        let value = dot(&times(covariance, &vector), &vector);
        for (row, x) in covariance.chunks_mut(size).zip(&vector) {
            for (entry, y) in row.iter_mut().zip(&vector) {
                *entry -= value * x * y;
            }
        }
        held += value;
        found.push(vector);
    }
    found
}

fn times(matrix: &[f64], vector: &[f64]) -> Vec<f64> {
    let rows = matrix.chunks(vector.len().max(1));
    rows.map(|row| dot(row, vector)).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y));
    squares.sum::<f64>().sqrt()
}

/// Scales a vector to unit length; `false` if it has none.
fn normalise(vector: &mut [f64]) -> bool {
    let length = dot(vector, vector).sqrt();
    let has_length = length > f64::MIN_POSITIVE;
    if has_length {
        vector.iter_mut().for_each(|x| *x /= length);
    }
    has_length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_of_a_known_covariance() {
        // Eigenvalues 4, 2 and 1 by hand: (1, 1, 0), (1, -1, 0) and (0, 0, 1).
        let matrix = [3.0, 1.0, 0.0, 1.0, 3.0, 0.0, 0.0, 0.0, 1.0];
        let half = 0.5f64.sqrt();
        let expected = [[half, half, 0.0], [half, -half, 0.0], [0.0, 0.0, 1.0]];
        for (kept, count) in [(0.5, 1), (0.8, 2), (0.9, 3), (1.0, 3)] {
            let found = components(&mut matrix.clone(), 3, kept);
            assert_eq!(found.len(), count, "{kept} of the variance");
            for (vector, wanted) in found.iter().zip(&expected) {
                assert!((dot(vector, wanted).abs() - 1.0).abs() < 1e-9, "{vector:?}");
            }
        }
    }

    #[test]
    fn distances_of_postures_on_a_line_are_those_of_the_line() {
        // All postures lie on (3, 4, 0) / 5 around their mean, at 0, 1, 2 and 10.
        let at = |s: f64| vec![0.6 * s + 7.0, 0.8 * s, 2.0];
        let space = PostureSpace::of(&[at(0.0), at(1.0), at(2.0), at(10.0)]);
        assert_eq!(space.coefficients[0].len(), 1);
        let apart = distance(&space.coefficients[0], &space.coefficients[3]);
        assert!((apart - 10.0).abs() < 1e-9);
        assert_eq!(space.held(0.5), [0, 1, 2, 3]);
        assert_eq!(space.held(1.5), [0, 2, 3]);
        assert_eq!(space.held(20.0), [0]);
    }

    #[test]
    fn postures_that_do_not_move_have_no_component() {
        let space = PostureSpace::of(&[vec![1.0, 2.0], vec![1.0, 2.0]]);
        assert_eq!(space.held(0.0), [0]);
        assert_eq!(PostureSpace::of(&[Vec::new(), Vec::new()]).held(0.0), [0]);
        assert!(PostureSpace::of(&[]).held(1.0).is_empty());
    }
}
