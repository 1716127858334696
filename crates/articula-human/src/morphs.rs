//! Morph targets of primitives from the displacements of their points.

use crate::expression::Expressions;
use crate::person_pieces::Sheet;
use crate::primitive::triangle_normals;
use articula_core::arkit_table::BLEND_SHAPES;
use articula_core::source::{MorphTarget, Primitive};
use glam::Vec3;

/// Length in metres from which on a displacement is stored.
const LEAST: f32 = 2e-5;

/// Adds a morph target for each blend shape of ARKit.
pub(crate) fn add(primitive: &mut Primitive, sheet: Sheet, expressions: &Expressions) {
    let rest = triangle_normals(&primitive.positions, &primitive.triangles);
    let target = |name: &str| {
        let moved = primitive.positions.iter().map(|p| {
            let offset = expressions.offset(name, *p, sheet);
            if offset.length() < LEAST {
                Vec3::ZERO
            } else {
                offset
            }
        });
        let positions: Vec<Vec3> = moved.collect();
        MorphTarget {
            normals: normals(primitive, &rest, &positions),
            positions,
        }
    };
    primitive.morphs = BLEND_SHAPES
        .iter()
        .map(|shape| target(shape.name))
        .collect();
}

/// How the normals turn with the triangles; zero for those that hardly do.
fn normals(primitive: &Primitive, rest: &[Vec3], offsets: &[Vec3]) -> Vec<Vec3> {
    if offsets.iter().all(|o| *o == Vec3::ZERO) {
        return vec![Vec3::ZERO; offsets.len()];
    }
    let moved: Vec<Vec3> = primitive
        .positions
        .iter()
        .zip(offsets)
        .map(|(p, o)| *p + *o)
        .collect();
    let after = triangle_normals(&moved, &primitive.triangles);
    let turned = |(before, after): (&Vec3, Vec3)| {
        let delta = after - *before;
        if delta.length() < 0.01 {
            Vec3::ZERO
        } else {
            delta
        }
    };
    rest.iter().zip(after).map(turned).collect()
}
