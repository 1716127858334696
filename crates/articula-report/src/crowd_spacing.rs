//! The built-in scenes for figures that are larger than a person.

use articula::build::{Asset, Scene};
use articula::core::PosedMesh;
use articula::flat::Bounds;

/// Extent of a figure for which the built-in scenes are made, metres: a person with raised or spread arms,
/// and the distance between neighbours.
const PERSON_METRES: f32 = 2.0;

/// Returns a scene whose distances, the height of its cameras included, are larger in proportion to the
/// largest figure at rest; that of persons stays as it is.
pub fn crowd_for_sizes<'a>(mut scene: Scene, figures: impl Iterator<Item = &'a Asset>) -> Scene {
    let largest = figures.map(extent_metres).fold(PERSON_METRES, f32::max);
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

/// The largest side of the box around a figure at rest. Its mesh alone may have another scale.
fn extent_metres(figure: &Asset) -> f32 {
    let mut posed = PosedMesh::new(&figure.rig, &figure.mesh);
    posed.pose(figure.rig.rest_pose());
    let skinned = posed.skinned(&figure.mesh.morph_weights);
    let points = skinned.positions.iter().filter(|p| p.is_finite());
    let bounds = Bounds::around(points.map(|p| (*p, *p)));
    bounds.map_or(0.0, |b| (b.high - b.low).max_element())
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula::build::{ClipOptions, Plaza, character, plaza};
    use articula::core::source::{Character, Joint, Primitive, RawMesh, Skeleton, Skin};
    use articula::core::{Articulation, Transform};
    use glam::{Affine3A, Vec3};

    /// A figure whose joint makes its mesh larger.
    fn of_extent(metres: f32, scale: f32) -> Asset {
        let primitive = Primitive {
            positions: vec![Vec3::ZERO, Vec3::Y * metres / scale, Vec3::X * 0.1],
            normals: vec![Vec3::Z; 3],
            influences: 1,
            joints: vec![0; 3],
            weights: vec![1.0; 3],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        };
        let source = Character {
            skeleton: Skeleton {
                joints: vec![Joint {
                    name: "root".into(),
                    parent: None,
                    rest: Transform {
                        scale: Vec3::splat(scale),
                        ..Transform::IDENTITY
                    },
                    in_skin: true,
                }],
            },
            meshes: vec![RawMesh {
                name: "body".into(),
                skin: Skin {
                    joints: vec![0],
                    inverse_bind: vec![Affine3A::IDENTITY],
                },
                primitives: vec![primitive],
                ..RawMesh::default()
            }],
            ..Character::default()
        };
        let joints = Some(Articulation::unmapped(1));
        character(&source, joints, &ClipOptions::default()).unwrap()
    }

    #[test]
    fn neighbours_are_as_far_apart_as_the_largest_figure_is_wide() {
        let scene = plaza(4, &[1], 1, Plaza::Moving);
        let person = of_extent(1.8, 0.01);
        assert_eq!(crowd_for_sizes(scene.clone(), [&person].into_iter()), scene);
        let giant = of_extent(5.0, 3.0);
        let wide = crowd_for_sizes(scene.clone(), [&person, &giant].into_iter());
        let apart = |s: &Scene| s.members[0].position.distance(s.members[1].position);
        assert_eq!(apart(&scene), 2.0);
        assert!((apart(&wide) - 5.0).abs() < 1e-5);
        let eye = |s: &Scene| s.views[0].camera[0].eye.y;
        assert!((eye(&wide) - 2.5 * eye(&scene)).abs() < 1e-5);
    }
}
