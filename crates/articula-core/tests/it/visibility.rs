//! Culling and tolerances of a whole crowd do not allocate.

use articula_core::visibility::{Bodies, CullResult, Occlusion, View, Visibility, cull};
use articula_core::{
    Attention, AttentionInterval, Bound, Camera, Capsule, ClipBounds, Sphere, Viewport, Wrap,
};
use glam::{Quat, Vec3};

const BALL: Sphere = Sphere {
    centre: Vec3::ZERO,
    radius: 1.0,
};

/// All functions of this part of a frame, in one frame.
#[test]
fn culling_does_not_allocate() {
    let second = Bound {
        sphere: BALL,
        least: Vec3::NEG_ONE,
        greatest: Vec3::ONE,
    };
    let clip = ClipBounds::new(1.5, vec![second; 2], BALL).unwrap();
    let step = AttentionInterval {
        start_secs: 0.2,
        end_secs: 0.6,
        factor: 0.25,
    };
    let attention = Attention::new(1.5, &[step]).unwrap();
    let camera = Camera::looking_at(Vec3::Z * 30.0, Vec3::ZERO, Viewport::default());
    let mut grid = Occlusion::new(160, 90).unwrap();
    let (count, scale) = (130, 1.0);
    let positions: Vec<Vec3> = (0..count).map(|i| Vec3::X * i as f32).collect();
    let rotations = vec![Quat::IDENTITY; count];
    let scales = vec![scale; count];
    let mut bounds = vec![BALL; count];
    let mut world = vec![BALL; count];
    let margins = vec![0.1; count];
    let mut occluded = vec![0.0; count];
    let mut seen = vec![CullResult::default(); count];
    let mut tolerance = 0.0;
    let counted = allocation_counter::measure(|| {
        for bound in &mut bounds {
            *bound = clip.over(1.2, 0.5, 1.0, Wrap::Loop).sphere;
        }
        for (b, world) in world.iter_mut().enumerate() {
            *world = bounds[b].carried(positions[b], rotations[b], scales[b]);
        }
        grid.begin(&camera);
        let trunk = Capsule {
            ends: [Vec3::NEG_Y, Vec3::Y],
            radius: 0.1,
        };
        grid.draw(&trunk);
        for (b, occluded) in occluded.iter_mut().enumerate() {
            *occluded = grid.occluded(&second, positions[b], rotations[b], scale);
        }
        let views = [View::of(&camera).with_occluded(&occluded)];
        cull(&views, Bodies::new(&world, &margins).unwrap(), &mut seen);
        let m = attention.at(1.0, Wrap::Loop);
        tolerance = m / seen[0].pixels_per_metre;
    });
    assert_eq!(counted.count_total, 0);
    assert_eq!(seen[0].visibility, Visibility::Visible);
    assert!(tolerance > 0.0);
}
