//! Change of the normals of a surface by displacements of its vertices.

use super::super::points::FaceSurface;
use glam::Vec3;

/// Returns how the normal of each vertex changes: the difference of the area-weighted normals of
/// the displaced surface and of the surface at rest. Vertices of one place have one normal.
pub fn normal_offsets(surface: &FaceSurface, displacements: &[Vec3]) -> Vec<Vec3> {
    let joined = surface.joined();
    let normals = |at: &dyn Fn(usize) -> Vec3| {
        let mut sums = vec![Vec3::ZERO; displacements.len()];
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|v| at(v as usize));
            let normal = (b - a).cross(c - a);
            for v in triangle {
                sums[joined[*v as usize] as usize] += normal;
            }
        }
        sums
    };
    let rest = normals(&|v| surface.positions[v]);
    let moved = normals(&|v| surface.positions[v] + displacements[v]);
    let change = |v: &u32| {
        let v = *v as usize;
        if rest[v] == moved[v] {
            return Vec3::ZERO;
        }
        moved[v].normalize_or_zero() - rest[v].normalize_or_zero()
    };
    joined.iter().map(change).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_raised_edge_tilts_the_normals() {
        // A square in the plane z = 0 whose right edge rises by its length: 45 degrees.
        let surface = FaceSurface {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..FaceSurface::default()
        };
        let up = [Vec3::ZERO, Vec3::Z, Vec3::Z, Vec3::ZERO];
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let expected = Vec3::new(-half, 0.0, half) - Vec3::Z;
        for offset in normal_offsets(&surface, &up) {
            assert!((offset - expected).length() < 1e-6, "{offset}");
        }
        let still = [Vec3::ZERO; 4];
        assert_eq!(normal_offsets(&surface, &still), still);
    }
}
