//! No vertex of a crowd is off by more than twice the tolerance, wherever its character stands in the
//! picture, however large it is, and whatever its pose comes from.

use crate::crowd::human_asset;
use articula::crowd::{
    CacheUse, Camera, CrowdAsset, CrowdPlayer, Detail, ErrorMeter, ErrorSummary, Viewport,
};
use glam::Vec3;

/// Characters on both sides of the way of a wide camera, the nearest around it.
fn walked(asset: &CrowdAsset, px: f32, cache: CacheUse, scales: &[f32]) -> ErrorSummary {
    const COUNT: usize = 48;
    let mut crowd = CrowdPlayer::new(asset, COUNT).unwrap();
    crowd.detail = Detail::Tolerance { px };
    crowd.cache = cache;
    for i in 0..COUNT {
        let across = (i % 8) as f32 - 3.5;
        let place = Vec3::new(1.5 * across, 0.0, -2.5 * (i / 8) as f32);
        crowd.place(i, place, 0.7 * i as f32);
        crowd.play(i, i % asset.clips().len(), 0.13 * i as f32);
        if !scales.is_empty() {
            crowd.set_scale(i, scales[i % scales.len()]);
        }
    }
    let viewport = Viewport {
        width_px: 1920.0,
        height_px: 1080.0,
        fov_y_radians: 1.2,
    };
    let mut meter = ErrorMeter::new(asset, 1);
    let mut samples = Vec::new();
    for frame in 0..12 {
        let eye = Vec3::new(0.3, 1.6, 2.0 - 0.4 * frame as f32);
        let camera = Camera::looking_at(eye, eye + Vec3::new(0.1, -0.2, -1.0), viewport);
        crowd.frame(0.11, &camera);
        samples.push(meter.measure(&crowd, 0.0, &[camera.into()]));
    }
    ErrorSummary::of(&samples)
}

#[test]
fn no_vertex_is_off_by_more_than_twice_the_tolerance() {
    let asset = human_asset();
    for px in [1.0, 4.0] {
        for cache in [CacheUse::Never, CacheUse::Cpu, CacheUse::Gpu] {
            for scales in [&[][..], &[0.5, 3.0, 1.0]] {
                let found = walked(asset, px, cache, scales);
                assert!(found.near > 300, "{found:?}");
                let what = format!("{px} px, {cache:?}, scales {scales:?}");
                let worst = found.worst_vertex;
                assert!(worst <= 2.0 * f64::from(px), "{what}: {worst} px");
                // Coarser levels are shown.
                assert!(worst >= 0.3 * f64::from(px), "{what}: {worst} px");
            }
        }
    }
}

#[test]
fn a_scaled_character_is_shown_at_its_size() {
    let asset = human_asset();
    let mut crowd = CrowdPlayer::new(asset, 2).unwrap();
    assert_eq!(crowd.scale(1), 1.0);
    crowd.place(1, Vec3::X * 5.0, 0.0);
    let camera = Camera::looking_at(
        Vec3::new(2.5, 1.0, 12.0),
        Vec3::X * 2.5,
        Viewport::default(),
    );
    let density = |crowd: &mut CrowdPlayer| {
        crowd.frame(0.0, &camera);
        [0, 1].map(|c| crowd.crowd().cull_result(c).pixels_per_metre)
    };
    let before = density(&mut crowd);
    crowd.set_scale(1, 0.5);
    assert_eq!([0, 1].map(|c| crowd.scale(c)), [1.0, 0.5]);
    let after = density(&mut crowd);
    // Its bound shrinks, so its nearest point is farther.
    assert_eq!(before[0], after[0]);
    assert!(after[1] < before[1]);
    let top = crowd.world_from_model(1).transform_point3(Vec3::Y * 1.8);
    assert!(top.distance(Vec3::new(5.0, 0.9, 0.0)) < 1e-6);
}
