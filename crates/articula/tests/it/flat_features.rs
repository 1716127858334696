//! Features of a face in 2D: what a viewer looks at is there at the least number of triangles.

use articula::flatten::{FramedCharacter, LEAST_TRIANGLES, Shot, TriangleCount};
use articula::glam::Vec3;
use articula::{Executor, Figure, reference_mannequin};

/// Area that triangles of a mesh with a material cover from the front, on the figure's left or right.
fn area(figure: &Figure, triangles: &[[u32; 3]], material: usize, is_left: bool) -> f32 {
    let mesh = &figure.asset.mesh;
    let parts = mesh
        .parts
        .iter()
        .filter(|part| part.material == Some(material));
    let vertices: Vec<_> = parts.map(|part| part.vertices.clone()).collect();
    let of_part = |v: u32| vertices.iter().any(|range| range.contains(&(v as usize)));
    let shown = triangles.iter().filter(|t| of_part(t[0]));
    let areas = shown
        .map(|t| t.map(|v| mesh.positions[v as usize]))
        .map(|[a, b, c]| {
            let front = (b - a).cross(c - a).dot(Vec3::Z).max(0.0) / 2.0;
            if ((a + b + c).x > 0.0) == is_left {
                front
            } else {
                0.0
            }
        });
    areas.sum()
}

#[test]
fn eyes_brows_and_lips_of_the_human_stay() {
    let figure = Figure::new(reference_mannequin().unwrap()).unwrap();
    let shot = Shot {
        still_at: Some(0.0),
        triangles: TriangleCount::About(LEAST_TRIANGLES),
        ..Shot::default()
    };
    let framed = FramedCharacter::new(&figure, shot, &Executor::default()).unwrap();
    let materials = &figure.opened.character().materials;
    for (m, material) in materials.iter().enumerate() {
        let name = material.name.as_str();
        if !["lips", "brows", "sclera", "iris"].contains(&name) {
            continue;
        }
        for is_left in [false, true] {
            let whole = area(&figure, &figure.asset.mesh.triangles, m, is_left);
            let left = area(&figure, &framed.triangles, m, is_left);
            let share = left / whole;
            assert!(
                (0.4..2.5).contains(&share),
                "{name}, left {is_left}: {share}"
            );
        }
    }
}
