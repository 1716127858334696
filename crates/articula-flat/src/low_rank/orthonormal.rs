//! Gram-Schmidt orthonormalisation.

/// Orthonormalises vectors by Gram-Schmidt, twice for accuracy. `is_noise` gets the length of a
/// vector before and after the components along the others were subtracted; noise is dropped.
pub(super) fn orthonormalise(vectors: &mut Vec<Vec<f64>>, is_noise: impl Fn(f64, f64) -> bool) {
    let mut kept: Vec<Vec<f64>> = Vec::with_capacity(vectors.len());
    for mut vector in vectors.drain(..) {
        let before = dot(&vector, &vector).sqrt();
        for _ in 0..2 {
            for other in &kept {
                let share = dot(&vector, other);
                add_scaled(&mut vector, other, -share);
            }
        }
        let length = dot(&vector, &vector).sqrt();
        if !is_noise(before, length) && length > f64::MIN_POSITIVE {
            vector.iter_mut().for_each(|v| *v /= length);
            kept.push(vector);
        }
    }
    *vectors = kept;
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

pub(super) fn add_scaled(to: &mut [f64], what: &[f64], factor: f64) {
    for (t, w) in to.iter_mut().zip(what) {
        *t += w * factor;
    }
}
