//! One look at a whole crowd, against looking at each body by itself, and while cameras move.

use articula_core::visibility::{
    Bodies, Closing, Occlusion, Seen, View, Visibility, secs_until_grown, see,
};
use articula_core::{
    Attention, Bound, Camera, Capsule, ClipBounds, Interval, Sphere, Viewport, Wrap,
};
use glam::{Quat, Vec3};
use proptest::prelude::*;

/// Bodies as their owner keeps them.
#[derive(Debug, Clone, Default)]
struct Crowd {
    bounds: Vec<Sphere>,
    wakes: Vec<f32>,
}

const BALL: Sphere = Sphere {
    centre: Vec3::ZERO,
    radius: 1.0,
};

impl Crowd {
    /// Unit balls that may move so far.
    fn of(rows: &[(Vec3, f32)]) -> Self {
        let mut crowd = Self::default();
        for (centre, wake) in rows {
            crowd.push(
                Sphere {
                    centre: *centre,
                    ..BALL
                },
                *wake,
            );
        }
        crowd
    }

    fn push(&mut self, bound: Sphere, wake: f32) {
        self.bounds.push(bound);
        self.wakes.push(wake);
    }

    fn seen(&self, views: &[View<'_>]) -> Vec<Seen> {
        let mut out = vec![Seen::default(); self.bounds.len()];
        see(
            views,
            Bodies::new(&self.bounds, &self.wakes).unwrap(),
            &mut out,
        );
        out
    }
}

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from)
}

proptest! {
    /// Acceptance test 13's half for visibility: a camera that moves, turns and runs into a
    /// body that comes to meet it never sees it denser than was foretold.
    #[test]
    fn a_dolly_keeps_the_bound(
        eye in vector(20.0),
        way in vector(1.0),
        axis in vector(1.0),
        speeds in (0.0f32..8.0, 0.0f32..8.0, 0.0f32..2.0),
        growth in 0.01f32..1.0,
    ) {
        let (camera_speed, body_speed, turning) = speeds;
        let closing = Closing { metres_per_sec: camera_speed + body_speed, radians_per_sec: turning };
        let start = Camera::looking_at(eye, Vec3::ZERO, Viewport::default());
        let crowd = |position| Crowd::of(&[(position, 0.0)]);
        let before = crowd(Vec3::ZERO).seen(&[View::of(&start)])[0];
        let secs = secs_until_grown(&[View::of(&start)], BALL, before, growth, closing);
        prop_assert!(secs > 0.0 || before.visibility != Visibility::Visible);
        // Towards each other most of the time, whatever the random way says.
        let inwards = (way - eye.normalize_or_zero()).normalize_or_zero();
        for step in 0..=20 {
            let t = secs.min(10.0) * step as f32 / 20.0;
            let turned = Quat::from_scaled_axis(axis.normalize_or_zero() * (turning * t));
            let camera = Camera {
                eye: eye + inwards * (camera_speed * t),
                orientation: turned * start.orientation,
                ..start
            };
            let position = -inwards * (body_speed * t);
            let seen = crowd(position).seen(&[View::of(&camera)])[0];
            let limit = before.pixels_per_metre * (1.0 + growth) * 1.0001;
            prop_assert!(
                before.visibility != Visibility::Visible
                    || seen.visibility != Visibility::Visible
                    || seen.pixels_per_metre <= limit,
                "{} above {limit} after {t} s of {secs}", seen.pixels_per_metre
            );
        }
    }
}

/// Everything that this part of a frame asks, in one frame.
#[test]
fn a_look_does_not_allocate() {
    let second = Bound {
        sphere: BALL,
        least: Vec3::NEG_ONE,
        greatest: Vec3::ONE,
    };
    let clip = ClipBounds::new(1.5, vec![second; 2], BALL).unwrap();
    let step = Interval {
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
    let wakes = vec![0.1; count];
    let mut occluded = vec![0.0; count];
    let mut seen = vec![Seen::default(); count];
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
        see(&views, Bodies::new(&world, &wakes).unwrap(), &mut seen);
        let secs = secs_until_grown(&views, world[0], seen[0], 0.25, Closing::default());
        let m = attention.at(f64::from(secs.min(1.0)), Wrap::Loop);
        tolerance = m / seen[0].pixels_per_metre;
    });
    assert_eq!(counted.count_total, 0);
    assert_eq!(seen[0].visibility, Visibility::Visible);
    assert!(tolerance > 0.0);
}
