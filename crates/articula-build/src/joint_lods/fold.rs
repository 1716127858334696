//! Skinning of one vertex at one level: weights moved to kept joints, and a rest position that
//! preserves the mean pose.
//!
//! The palette of a level is a prefix of the full one, so inverse binds stay the same. The
//! transform of a merged joint in the mean pose goes into the vertex instead: with `F` the blend of
//! matrices of the full character in the mean pose and `L` that of the level, the rest position
//! becomes `L⁻¹ F x`, so that the level shows the mean pose exactly.

use super::plan::Plan;
use crate::influences::keep_largest;
use glam::{DAffine3, DMat3, DVec3, Vec3};

/// Minimum volume of a blended matrix relative to the matrices it blends; below it, opposing
/// matrices cancel out and the inverse would move the vertex far away.
const MIN_VOLUME: f64 = 0.05;

/// A vertex whose skinning differs from that of the full character.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FoldedVertex {
    /// Index into the plan's bindings, and weight.
    pub(super) influences: Vec<(u16, f32)>,
    /// `None` if no rest position reproduces the mean pose: the position stays as it is.
    pub(super) correction: Option<Correction>,
}

/// Transform of rest positions, normals and their morph offsets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Correction {
    position: DAffine3,
    /// Scale is arbitrary.
    normal: DMat3,
}

impl Correction {
    pub(super) fn position(&self, p: Vec3) -> Vec3 {
        self.position.transform_point3(p.as_dvec3()).as_vec3()
    }

    pub(super) fn offset(&self, d: Vec3) -> Vec3 {
        self.position.transform_vector3(d.as_dvec3()).as_vec3()
    }

    /// Returns the unit normal at rest, and the scale of its morph offsets.
    pub(super) fn normal(&self, n: Vec3) -> (Vec3, f64) {
        let turned = self.normal * n.as_dvec3();
        match turned.try_normalize() {
            Some(unit) => (unit.as_vec3(), 1.0 / turned.length()),
            None => (n, 0.0),
        }
    }

    pub(super) fn normal_offset(&self, d: Vec3, scale: f64) -> Vec3 {
        (self.normal * d.as_dvec3() * scale).as_vec3()
    }
}

/// Returns the skinning of a vertex at a level with at most `most` influences; `None` if it equals
/// that of the full character.
pub(super) fn fold(
    plan: &mut Plan<'_>,
    level: usize,
    vertex: usize,
    most: usize,
) -> Option<FoldedVertex> {
    let full = plan.influences(vertex);
    let mut folded: Vec<(u16, f32)> = Vec::with_capacity(full.len());
    let mut changed = false;
    for &(binding, weight) in &full {
        let target = plan.target(level, vertex, binding);
        changed |= target != binding;
        match folded.iter_mut().find(|(b, _)| *b == target) {
            Some((_, sum)) if changed => *sum += weight,
            _ => folded.push((target, weight)),
        }
    }
    if folded.len() > most {
        keep_largest(&mut folded, most);
        changed = true;
    }
    if !changed {
        return None;
    }
    let before = plan.blend(&full);
    let mut correction = correct(plan, &before, &folded);
    if correction.is_none() && folded.len() > 1 {
        keep_largest(&mut folded, 1);
        correction = correct(plan, &before, &folded);
    }
    Some(FoldedVertex {
        influences: folded,
        correction,
    })
}

fn correct(plan: &Plan<'_>, full: &DAffine3, folded: &[(u16, f32)]) -> Option<Correction> {
    let level = plan.blend(folded);
    let volume = |m: &DAffine3| m.matrix3.determinant().abs();
    let parts = folded
        .iter()
        .map(|(b, w)| f64::from(*w) * volume(plan.mean_matrix(*b)));
    let parts: f64 = parts.sum();
    let own = volume(&level);
    if !(own.is_finite() && parts > 0.0 && own >= MIN_VOLUME * parts) {
        return None;
    }
    let position = level.inverse() * *full;
    let normal = level.matrix3.transpose() * cofactor(full.matrix3);
    (position.is_finite() && normal.is_finite()).then_some(Correction { position, normal })
}

/// Cofactor matrix, signed as in the skinning of normals: they point outwards when a matrix
/// mirrors.
fn cofactor(m: DMat3) -> DMat3 {
    let cross = |a: DVec3, b: DVec3| a.cross(b);
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    DMat3::from_cols(
        cross(m.y_axis, m.z_axis) * sign,
        cross(m.z_axis, m.x_axis) * sign,
        cross(m.x_axis, m.y_axis) * sign,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_stay_upright_where_the_surface_is_stretched_or_mirrored() {
        let diagonal = |x, y, z| DMat3::from_diagonal(DVec3::new(x, y, z));
        assert_eq!(cofactor(diagonal(2.0, 3.0, 4.0)), diagonal(12.0, 8.0, 6.0));
        assert_eq!(
            cofactor(diagonal(-2.0, 3.0, 4.0)),
            diagonal(-12.0, 8.0, 6.0)
        );
        // Stretched to twice its length along X.
        let stretch = diagonal(2.0, 1.0, 1.0);
        let correction = Correction {
            position: DAffine3::from_mat3_translation(stretch, DVec3::Y),
            normal: cofactor(stretch),
        };
        assert_eq!(correction.position(Vec3::ONE), Vec3::new(2.0, 2.0, 1.0));
        assert_eq!(correction.offset(Vec3::ONE), Vec3::new(2.0, 1.0, 1.0));
        // The plane x + y = 0 becomes x / 2 + y = 0.
        let (normal, scale) = correction.normal(Vec3::new(1.0, 1.0, 0.0).normalize());
        assert!((normal - Vec3::new(1.0, 2.0, 0.0).normalize()).length() < 1e-6);
        // An offset is scaled as the normal was.
        let whole = Vec3::new(1.0, 1.0, 0.0).normalize();
        assert!((correction.normal_offset(whole, scale) - normal).length() < 1e-6);
        assert_eq!(correction.normal(Vec3::ZERO), (Vec3::ZERO, 0.0));
    }
}
