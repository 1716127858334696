//! Boxes reported as occluded are occluded: the depth grid against the segment to every point.

use articula_core::visibility::Occlusion;
use articula_core::{Bound, Camera, Capsule, Sphere, Viewport};
use glam::{DVec3, Quat, Vec2, Vec3};
use proptest::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Minimum distance of two segments, by ternary search.
fn distance(a: [DVec3; 2], b: [DVec3; 2]) -> f64 {
    let to_b = |p: DVec3| {
        let along = b[1] - b[0];
        let t = (p - b[0]).dot(along) / along.length_squared().max(1e-300);
        p.distance(b[0] + along * t.clamp(0.0, 1.0))
    };
    // The distance to a segment is convex along the other one.
    let at = |t: f64| to_b(a[0].lerp(a[1], t));
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..80 {
        let (s, t) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at(s) < at(t) {
            high = t;
        } else {
            low = s;
        }
    }
    at(0.5 * (low + high))
}

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from)
}

static HIDDEN: AtomicUsize = AtomicUsize::new(0);

#[test]
fn no_point_of_a_hidden_box_can_be_seen() {
    let capsule = (vector(2.5), vector(1.5), 0.2f32..1.5);
    let target = (vector(3.0), vector(3.0), 0.1f32..0.9, 0.2f32..2.0);
    let cases = (
        prop::collection::vec(capsule, 1..6),
        prop::collection::vec(target, 8),
        prop::collection::vec(prop::array::uniform3(-1.0f32..=1.0), 60),
        vector(0.3),
        (20usize..200, 20usize..120),
    );
    let config = ProptestConfig::with_cases(256);
    proptest!(config, |((capsules, targets, points, aim, (columns, rows)) in cases)| {
        // Capsules around 6 m ahead, boxes around 8 m.
        let camera = Camera::looking_at(Vec3::ZERO, Vec3::NEG_Z + aim, Viewport::default());
        let mut grid = Occlusion::new(columns, rows).unwrap();
        grid.begin(&camera);
        let capsules: Vec<Capsule> = capsules
            .iter()
            .map(|(at, way, radius)| Capsule {
                ends: [*at - *way, *at + *way].map(|end| end + Vec3::NEG_Z * 6.0),
                radius: *radius,
            })
            .collect();
        capsules.iter().for_each(|c| grid.draw(c));
        let picture = Vec2::new(camera.viewport.width_px, camera.viewport.height_px);
        for (at, axis, half, scale) in targets {
            let (position, rotation) = (at + Vec3::NEG_Z * 8.0, Quat::from_scaled_axis(axis));
            let (least, greatest) = (Vec3::splat(-half), Vec3::new(half, 2.0 * half, half));
            let sphere = Sphere::from_corners(least, greatest);
            let bound = Bound { sphere, least, greatest };
            let occluded = grid.occluded(&bound, position, rotation, scale);
            prop_assert!((0.0..=1.0).contains(&occluded));
            if occluded < 1.0 {
                continue;
            }
            HIDDEN.fetch_add(1, Ordering::Relaxed);
            for p in &points {
                let p = least + (Vec3::from(*p) * 0.5 + 0.5) * (greatest - least);
                let p = position + rotation * (p * scale);
                let (px, depth) = camera.project(p);
                let inside = px.cmpge(Vec2::ZERO).all() && px.cmple(picture).all();
                if !(inside && depth > 0.0) {
                    continue;
                }
                let culling = [camera.eye.as_dvec3(), p.as_dvec3()];
                let is_hidden = capsules.iter().any(|c| {
                    distance(culling, c.ends.map(|e| e.as_dvec3())) <= f64::from(c.radius)
                });
                prop_assert!(is_hidden, "{p} can be seen");
            }
        }
    });
    // Without any occluded box nothing would have been tested.
    assert!(HIDDEN.load(Ordering::Relaxed) > 20);
}
