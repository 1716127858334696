//! The built-in scenes for figures that are larger than a person.

use articula::build::Scene;
use articula::core::Mesh;
use articula::flat::Bounds;

/// Extent of a figure for which the built-in scenes are made, metres: a person with raised or spread arms,
/// and the distance between neighbours.
const PERSON_METRES: f32 = 2.0;

/// Returns a scene whose distances, the height of its cameras included, are larger in proportion to the
/// largest figure at rest; that of persons stays as it is.
pub fn crowd_for_sizes<'a>(mut scene: Scene, meshes: impl Iterator<Item = &'a Mesh>) -> Scene {
    let largest = meshes.map(extent_metres).fold(PERSON_METRES, f32::max);
    let factor = largest / PERSON_METRES;
    if factor > 1.0 && factor.is_finite() {
        for member in &mut scene.members {
            member.position *= factor;
        }
        for key in scene.views.iter_mut().flat_map(|view| &mut view.camera) {
            key.eye *= factor;
            key.target *= factor;
        }
    }
    scene
}

/// The largest side of the box around a mesh at rest.
fn extent_metres(mesh: &Mesh) -> f32 {
    let points = mesh.positions.iter().filter(|p| p.is_finite());
    let bounds = Bounds::around(points.map(|p| (*p, *p)));
    bounds.map_or(0.0, |b| (b.high - b.low).max_element())
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula::build::{Plaza, plaza};
    use glam::Vec3;

    #[test]
    fn neighbours_are_as_far_apart_as_the_largest_figure_is_wide() {
        let scene = plaza(4, &[1], 1, Plaza::Moving);
        let of_extent = |metres: f32| Mesh {
            positions: vec![Vec3::ZERO, Vec3::new(0.5, metres, 0.5)],
            ..Mesh::default()
        };
        let [person, giant] = [1.8, 5.0].map(of_extent);
        assert_eq!(crowd_for_sizes(scene.clone(), [&person].into_iter()), scene);
        let wide = crowd_for_sizes(scene.clone(), [&person, &giant].into_iter());
        let apart = |s: &Scene| s.members[0].position.distance(s.members[1].position);
        assert_eq!((apart(&scene), apart(&wide)), (2.0, 5.0));
        let eye = |s: &Scene| s.views[0].camera[0].eye.y;
        assert_eq!(eye(&wide), 2.5 * eye(&scene));
    }
}
