//! Test 9 of `docs/methods/motion-lod.md` part 10, the part on visibility: a character that walks
//! into view is inside the cull margin before any of its skin is visible, and visible when any of
//! its skin is.

use crate::random_figure::{RATE, Row, character_of, flat, rows};
use articula_build::ClipOptions;
use articula_build::motion_bounds;
use articula_build::{Asset, character};
use articula_core::visibility::{Bodies, CullResult, MIN_DEPTH_METRES, View, Visibility, cull};
use articula_core::{Camera, MotionBounds, PosedMesh, Viewport, Wrap, sample};
use glam::{Affine3A, Quat, Vec2, Vec3};
use proptest::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

fn asset(rows: &[Row]) -> Asset {
    let opts = ClipOptions {
        rate_hz: Some(RATE),
    };
    character(&character_of(rows), Some(flat(rows.len())), &opts).unwrap()
}

/// A character that moves along an arc through the origin while it plays the clip.
#[derive(Debug, Clone, Copy)]
struct Walker {
    heading: f32,
    passes_secs: f32,
    speed: f32,
    turning: f32,
    scale: f32,
    clip_speed: f32,
}

fn walker() -> impl Strategy<Value = Walker> {
    let ways = (0.0f32..6.3, 0.0f32..4.0, 0.5f32..30.0, -1.5f32..1.5);
    (ways, 0.3f32..2.0, -2.0f32..2.0).prop_map(
        |((heading, passes_secs, speed, turning), scale, clip_speed)| Walker {
            heading,
            passes_secs,
            speed,
            turning,
            scale,
            clip_speed,
        },
    )
}

impl Walker {
    fn heading_at(&self, secs: f32) -> f32 {
        self.heading + self.turning * (secs - self.passes_secs)
    }

    /// The position that heading and speed give, in closed form: on an arc of a circle.
    fn position_at(&self, secs: f32) -> Vec3 {
        let t = secs - self.passes_secs;
        // Half the chord over half the angle; its direction is the mean heading.
        let half = 0.5 * self.turning * t;
        let shorter = if half.abs() < 1e-3 {
            1.0
        } else {
            half.sin() / half
        };
        let mean = self.heading + half;
        Vec3::new(mean.sin(), 0.0, mean.cos()) * (self.speed * t * shorter)
    }

    fn rotation_at(&self, secs: f32) -> Quat {
        Quat::from_rotation_y(self.heading_at(secs))
    }

    fn clip_secs(&self, secs: f32) -> f64 {
        f64::from(self.clip_speed) * f64::from(secs)
    }

    fn look(
        &self,
        bounds: &MotionBounds,
        secs: f32,
        horizon: f32,
        views: &[View<'_>],
    ) -> CullResult {
        let (now, speed) = (self.clip_secs(secs), self.clip_speed);
        let bound = bounds.clips[0].over(now, horizon, speed, Wrap::Loop).sphere;
        let world = bound.carried(self.position_at(secs), self.rotation_at(secs), self.scale);
        let mut turned = bound;
        turned.centre *= self.scale;
        // The distance of the root and the arc of the bound's centre about it.
        let margin = (self.speed + self.turning.abs() * turned.centre.length()) * horizon;
        let mut seen = [CullResult::default()];
        cull(views, Bodies::new(&[world], &[margin]).unwrap(), &mut seen);
        seen[0]
    }

    fn skin(&self, asset: &Asset, secs: f32) -> Vec<Vec3> {
        let (rig, mesh) = (&asset.rig, &asset.mesh);
        let mut pose = rig.rest_pose().clone();
        sample(
            &asset.clips[0],
            self.clip_secs(secs),
            Wrap::Loop,
            &rig.all(),
            &mut pose,
        );
        let world = Affine3A::from_scale_rotation_translation(
            Vec3::splat(self.scale),
            self.rotation_at(secs),
            self.position_at(secs),
        );
        let all: Vec<u32> = (0..mesh.len() as u32).collect();
        let mut points = vec![Vec3::ZERO; all.len()];
        let mut posed = PosedMesh::new(rig, mesh);
        posed.pose_from(&pose, world).points(&all, &mut points);
        points
    }
}

fn camera(azimuth: f32, distance: f32, aside: f32) -> Camera {
    let (sin, cos) = azimuth.sin_cos();
    let eye = Vec3::new(sin * distance, 1.0, cos * distance);
    let target = Vec3::new(cos * aside, 0.5, -sin * aside);
    Camera::looking_at(eye, target, Viewport::default())
}

/// Depth of a point, if the picture of a camera shows it.
fn depth_in_picture(camera: &Camera, point: Vec3) -> Option<f32> {
    let (px, depth) = camera.project(point);
    let size = Vec2::new(camera.viewport.width_px, camera.viewport.height_px);
    let inside = px.cmpge(Vec2::ZERO).all() && px.cmple(size).all();
    // Points nearer than a millimetre are projected as if they were a millimetre away.
    (inside && depth > 0.001).then_some(depth)
}

/// Number of frames at which a character came into view that was not visible before.
static ENTERED: AtomicUsize = AtomicUsize::new(0);

#[test]
fn who_walks_into_view_was_awake_before() {
    let cameras = (0.0f32..6.3, 0.5f32..25.0, -8.0f32..8.0);
    let cases = (rows(), walker(), cameras, 15.0f32..120.0);
    let config = ProptestConfig::with_cases(128);
    proptest!(config, |((rows, walker, (azimuth, distance, aside), rate_hz) in cases)| {
        let asset = asset(&rows);
        let bounds = motion_bounds(&asset, 0.0).unwrap();
        let camera = camera(azimuth, distance, aside);
        let views = [View::of(&camera)];
        let mut before: Option<Visibility> = None;
        for frame in 0..(4.0 * rate_hz) as usize {
            let secs = frame as f32 / rate_hz;
            let found = walker.look(&bounds, secs, 1.0 / rate_hz, &views).visibility;
            let skin = walker.skin(&asset, secs);
            if skin.iter().any(|p| depth_in_picture(&camera, *p).is_some()) {
                prop_assert_eq!(found, Visibility::Visible);
                prop_assert_ne!(before, Some(Visibility::Hidden));
                if before == Some(Visibility::Margin) {
                    ENTERED.fetch_add(1, Ordering::Relaxed);
                }
            }
            before = Some(found);
        }
    });
    // If this never happened, nothing would have been tested.
    assert!(
        ENTERED.load(Ordering::Relaxed) > 0,
        "nobody came into view from beside it"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// After a cut, every character that the new camera sees is visible from the first frame, even
    /// if it was hidden before.
    #[test]
    fn a_cut_of_the_camera_is_seen_at_once(
        rows in rows(),
        walker in walker(),
        secs in 0.0f32..4.0,
        azimuths in (0.0f32..6.3, 0.0f32..6.3),
        distances in (0.1f32..25.0, 0.1f32..25.0),
    ) {
        let asset = asset(&rows);
        let bounds = motion_bounds(&asset, 0.0).unwrap();
        for camera in [camera(azimuths.0, distances.0, 0.0), camera(azimuths.1, distances.1, 0.0)] {
            let view = View::of(&camera);
            let seen = walker.look(&bounds, secs, 0.1, &[view]);
            prop_assert!(seen.pixels_per_metre.is_finite());
            for p in walker.skin(&asset, secs) {
                if let Some(depth) = depth_in_picture(&camera, p) {
                    prop_assert_eq!(seen.visibility, Visibility::Visible);
                    // A small step across the line of sight, away from the axis.
                    let pixels = camera.viewport.pixels_per_metre(depth.max(MIN_DEPTH_METRES));
                    let secant = camera.view(p).length() / depth;
                    prop_assert!(seen.pixels_per_metre >= pixels * secant * 0.9999);
                }
            }
        }
    }
}
