//! Surfaces as primitives: skin weights, normals, and parts of one surface.

use crate::body::Body;
use crate::polygonise::Surface;
use crate::skeleton;
use crate::weights::{INFLUENCES, Weigher};
use articula_core::source::{Material, Primitive, RawMesh, Skin};
use glam::{Affine3A, Vec3, Vec4};

/// Materials by names and linear colours.
pub(crate) fn materials(named: &[(&str, [f32; 3])]) -> Vec<Material> {
    let material = |(name, color): &(&str, [f32; 3])| Material {
        name: (*name).to_owned(),
        base_color: Vec4::from((Vec3::from(*color), 1.0)),
        ..Material::default()
    };
    named.iter().map(material).collect()
}

/// A mesh in model space, bound to all joints.
pub(crate) fn mesh(name: &str, primitives: Vec<Primitive>) -> RawMesh {
    let centers = skeleton::centers();
    RawMesh {
        name: name.to_owned(),
        skin: Skin {
            joints: (0..centers.len()).collect(),
            inverse_bind: centers
                .iter()
                .map(|c| Affine3A::from_translation(-*c))
                .collect(),
        },
        primitives,
        ..RawMesh::default()
    }
}

pub(crate) fn skin(body: &Body, surface: &Surface) -> Primitive {
    let weigher = Weigher::new(body);
    let influences: Vec<_> = surface.positions.iter().map(|p| weigher.at(*p)).collect();
    Primitive {
        positions: surface.positions.clone(),
        normals: normals(surface, |p| body.normal(p)),
        influences: INFLUENCES,
        joints: influences.iter().flatten().map(|(j, _)| *j).collect(),
        weights: influences.iter().flatten().map(|(_, w)| *w).collect(),
        triangles: surface.triangles.clone(),
        material: Some(0),
        ..Primitive::default()
    }
}

/// A primitive of some triangles of another, with the vertices that they use.
pub(crate) fn part(whole: &Primitive, triangles: &[[u32; 3]], material: usize) -> Primitive {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let mut place = vec![0; whole.positions.len()];
    for (i, v) in used.iter().enumerate() {
        place[*v as usize] = i as u32;
    }
    let per_vertex = |v: &u32| *v as usize * INFLUENCES..(*v as usize + 1) * INFLUENCES;
    Primitive {
        positions: used.iter().map(|v| whole.positions[*v as usize]).collect(),
        normals: used.iter().map(|v| whole.normals[*v as usize]).collect(),
        influences: INFLUENCES,
        joints: used
            .iter()
            .flat_map(|v| &whole.joints[per_vertex(v)])
            .copied()
            .collect(),
        weights: used
            .iter()
            .flat_map(|v| &whole.weights[per_vertex(v)])
            .copied()
            .collect(),
        triangles: triangles
            .iter()
            .map(|t| t.map(|v| place[v as usize]))
            .collect(),
        material: Some(material),
        ..Primitive::default()
    }
}

/// Mean of the field's gradient and the triangles' own normals: where a coarse surface cuts across
/// a fold of the field, the gradient alone would shade it dark.
fn normals(surface: &Surface, field: impl Fn(Vec3) -> Vec3) -> Vec<Vec3> {
    let positions = &surface.positions;
    let own = triangle_normals(positions, &surface.triangles);
    let blended = positions.iter().zip(own).map(|(p, own)| {
        let smooth = field(*p);
        let mirrored = Vec3::new(if p.x == 0.0 { 0.0 } else { 1.0 }, 1.0, 1.0);
        let normal = (smooth + own) * mirrored;
        normal.try_normalize().unwrap_or(smooth)
    });
    blended.collect()
}

/// Unit normals of the vertices as sums of those of their triangles, weighted by the angles.
pub(crate) fn triangle_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for t in triangles {
        let corner = |i: usize| positions[t[i % 3] as usize];
        for i in 0..3 {
            let (a, b) = (corner(i + 1) - corner(i), corner(i + 2) - corner(i));
            sums[t[i] as usize] += a.cross(b).normalize_or_zero() * a.angle_between(b);
        }
    }
    sums.into_iter().map(Vec3::normalize_or_zero).collect()
}

/// A surface bound rigidly to one joint per vertex.
pub(crate) fn rigid(
    surface: &Surface,
    material: usize,
    normal: impl Fn(Vec3) -> Vec3,
    joint: impl Fn(Vec3) -> u16,
) -> Primitive {
    let positions = surface.positions.clone();
    Primitive {
        normals: normals(surface, normal),
        influences: 1,
        joints: positions.iter().map(|p| joint(*p)).collect(),
        weights: vec![1.0; positions.len()],
        triangles: surface.triangles.clone(),
        material: Some(material),
        positions,
        ..Primitive::default()
    }
}
