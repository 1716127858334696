//! Small surfaces whose levels can be computed by hand.

use articula_core::{Binding, Mesh, Part};
use glam::{Affine3A, Vec2, Vec3, Vec4};

/// A mesh of one part whose vertices are bound to one joint.
pub(crate) fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let count = positions.len();
    Mesh {
        normals: vec![Vec3::Y; count],
        texcoords: vec![Vec2::ZERO; count],
        colors: vec![Vec4::ONE; count],
        influences: 1,
        binding_indices: vec![0; count],
        weights: vec![1.0; count],
        bindings: vec![Binding {
            joint: 0,
            inverse_bind: Affine3A::IDENTITY,
        }],
        parts: vec![Part {
            name: "all".into(),
            mesh: 0,
            material: None,
            draw_material: None,
            vertices: 0..count,
            triangles: 0..triangles.len(),
        }],
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// A ball of `2 * rings * rings` quads at most, triangulated, with poles.
pub(crate) fn ball(rings: usize) -> Mesh {
    let around = 2 * rings;
    let mut positions = vec![Vec3::Y, -Vec3::Y];
    let angle = |i: usize, of: usize| std::f32::consts::PI * i as f32 / of as f32;
    for r in 1..rings {
        let (s, c) = angle(r, rings).sin_cos();
        for a in 0..around {
            let (z, x) = angle(2 * a, around).sin_cos();
            positions.push(Vec3::new(s * x, c, s * z));
        }
    }
    let at = |r: usize, a: usize| match r {
        0 => 0,
        r if r == rings => 1,
        r => (2 + (r - 1) * around + a % around) as u32,
    };
    let mut triangles = Vec::new();
    for r in 0..rings {
        for a in 0..around {
            let [p, q, s, t] = [at(r, a), at(r, a + 1), at(r + 1, a + 1), at(r + 1, a)];
            triangles.extend([[p, q, s], [p, s, t]]);
        }
    }
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    mesh(positions, triangles)
}

/// A flat square of `n * n` quads in the plane y = 0.
pub(crate) fn sheet(n: usize) -> Mesh {
    let point = |i: usize| Vec3::new((i % (n + 1)) as f32, 0.0, (i / (n + 1)) as f32);
    let positions = (0..(n + 1) * (n + 1)).map(point).collect();
    let mut triangles = Vec::new();
    for i in (0..n * (n + 1)).filter(|i| i % (n + 1) < n) {
        let (a, b) = (i as u32, (i + n + 1) as u32);
        triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
    }
    mesh(positions, triangles)
}
