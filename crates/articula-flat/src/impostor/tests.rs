//! Tests of whole impostors: a red front and a blue back on a post that turns and walks.

use super::*;
use crate::appearance::Appearance;
use crate::picture::Picture;
use crate::render::Light;
use articula_core::source::{self, Joint, Primitive, Skeleton, Skin};
use articula_core::{Articulation, Clip, JointArticulation, Mesh, Progress, Region, Rig, Track};
use articula_core::{Tracks, Transform};
use glam::{Affine3A, Vec3, Vec4};

const RED: Vec4 = Vec4::new(1.0, 0.0, 0.0, 1.0);
const BLUE: Vec4 = Vec4::new(0.0, 0.0, 1.0, 1.0);

/// A board that faces +Z or -Z, 0.5 m wide and 2 m high, `z` before the origin.
fn board(z: f32, color: Vec4) -> source::RawMesh {
    let side = z.signum();
    let corners = [(-0.25, 0.0), (0.25, 0.0), (0.25, 2.0), (-0.25, 2.0)];
    source::RawMesh {
        skin: Skin {
            joints: vec![0],
            inverse_bind: vec![Affine3A::IDENTITY],
        },
        primitives: vec![Primitive {
            positions: corners.map(|(x, y)| Vec3::new(side * x, y, z)).to_vec(),
            colors: vec![color; 4],
            influences: 1,
            joints: vec![0; 4],
            weights: vec![1.0; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Primitive::default()
        }],
        ..source::RawMesh::default()
    }
}

struct Post {
    rig: Rig,
    mesh: Mesh,
    clips: Vec<Clip>,
    appearance: Appearance,
}

impl Post {
    fn new() -> Self {
        let root = Joint {
            name: "root".into(),
            parent: None,
            rest: Transform::IDENTITY,
            in_skin: true,
        };
        let known = JointArticulation {
            hanim: None,
            level: 0,
            region: Region::Pelvis,
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: vec![known],
        };
        let skeleton = Skeleton { joints: vec![root] };
        let stand = Clip::new("stand", 1.0, 2, 1, Tracks::default()).unwrap();
        let walk = Tracks {
            translations: vec![Track {
                target: 0,
                step: false,
                values: vec![Vec3::ZERO, Vec3::Y * 0.5],
            }],
            ..Tracks::default()
        };
        let walk = Clip::new("\"rise\"", 1.0, 2, 1, walk).unwrap();
        Self {
            rig: Rig::new(&skeleton, articulation).unwrap(),
            mesh: Mesh::new(&[board(0.1, RED), board(-0.1, BLUE)], 1).unwrap(),
            clips: vec![stand, walk],
            appearance: Appearance::default(),
        }
    }

    fn source(&self) -> ImpostorSource<'_> {
        ImpostorSource {
            rig: &self.rig,
            mesh: &self.mesh,
            clips: &self.clips,
            appearance: &self.appearance,
        }
    }

    fn plan(&self, bound: ImpostorBound) -> Result<ImpostorPlan, ImpostorError> {
        let options = ImpostorOptions {
            bound,
            ..ImpostorOptions::default()
        };
        let options = ImpostorOptions {
            light: Light {
                key: 0.0,
                fill: 0.0,
                ambient: 1.0,
                ..Light::default()
            },
            ..options
        };
        ImpostorPlan::new(&self.source(), &options, &mut Progress::none())
    }
}

/// Pixels of a picture that are at least half covered.
fn covered(picture: &Picture) -> impl Iterator<Item = (u32, u32, [u8; 4])> + '_ {
    let places = (0..picture.height()).flat_map(|y| (0..picture.width()).map(move |x| (x, y)));
    let pixels = places.map(|(x, y)| (x, y, picture.get(x, y).unwrap()));
    pixels.filter(|(_, _, color)| color[3] >= 128)
}

#[test]
fn more_bytes_give_less_error_within_the_bound() {
    let post = Post::new();
    let mut most = f32::INFINITY;
    for bytes in [20_000, 200_000, 2_000_000] {
        let plan = post.plan(ImpostorBound::Bytes(bytes)).unwrap();
        assert!(
            plan.bytes() <= bytes && plan.bytes() > bytes / 3,
            "{}",
            plan.bytes()
        );
        let error = plan.clips.iter().map(|c| c.error_m).fold(0.0, f32::max);
        assert!(error < most, "{error} in {bytes}");
        most = error;
    }
    assert!(matches!(
        post.plan(ImpostorBound::Bytes(100)),
        Err(ImpostorError::LimitExceeded { limit: 100, .. })
    ));
}

#[test]
fn an_error_is_kept_and_a_clip_that_stands_needs_one_pose() {
    let post = Post::new();
    for metres in [0.2, 0.05] {
        let plan = post.plan(ImpostorBound::Metres(metres)).unwrap();
        let [stand, rise] = &plan.clips[..] else {
            panic!("two clips");
        };
        assert_eq!((stand.pose_secs.len(), rise.first_pose), (1, 1));
        // Directions, poses and pixels together, each at its limit, and half a display frame.
        assert!(stand.error_m <= 1.01 * metres && rise.error_m <= 1.01 * metres + 0.005);
        assert!(rise.error_m > 0.4 * metres, "{}", rise.error_m);
        assert!(rise.pose_secs.len() > 1);
        assert_eq!(plan.trials.len(), 1);
    }
    assert!(post.plan(ImpostorBound::Metres(f32::NAN)).is_err());
}

#[test]
fn pictures_show_the_side_that_faces_the_eye_where_it_is() {
    let post = Post::new();
    let plan = post.plan(ImpostorBound::Metres(0.08)).unwrap();
    let pictures = plan.draw(&post.source(), 0).unwrap();
    let height = plan.cell.size_px[1];
    let m = plan.cell.metres_per_px;
    let front = plan.views.nearest(Vec3::Z);
    let back = plan.views.nearest(Vec3::NEG_Z);
    for (view, red, blue) in [(front, 255, 0), (back, 0, 255)] {
        let seen: Vec<_> = covered(&pictures[view]).collect();
        // One square metre, to within half a pixel around it.
        let area = seen.len() as f32 * m * m;
        assert!((area - 1.0).abs() < 0.5 * m * 5.0, "{area}");
        assert!(seen.iter().all(|(_, _, c)| (c[0], c[2]) == (red, blue)));
        // The feet are a metre below the centre.
        let lowest = seen.iter().map(|(_, y, _)| *y).max().unwrap();
        let foot = plan.cell.corner_m[1] + m * (height - 1 - lowest) as f32;
        assert!((foot + 1.0).abs() <= m, "{foot}");
    }
    assert!(plan.draw(&post.source(), plan.poses()).is_err());
}

#[test]
fn painted_pictures_are_what_the_eye_sees() {
    use crate::projection::{Projection, Screen};
    let post = Post::new();
    let plan = post.plan(ImpostorBound::Metres(0.15)).unwrap();
    let poses: Vec<Vec<Picture>> = (0..plan.poses())
        .map(|pose| plan.draw(&post.source(), pose).unwrap())
        .collect();
    let atlas = plan.atlas(&poses).unwrap();
    let viewport = articula_core::Viewport {
        width_px: 64.0,
        height_px: 64.0,
        ..articula_core::Viewport::default()
    };
    let projection = Projection::Parallel {
        pixels_per_metre: 10.0,
    };
    let world = Affine3A::from_rotation_translation(
        glam::Quat::from_rotation_y(0.4),
        Vec3::new(0.2, 0.1, -3.0),
    );
    for eye in [
        Vec3::new(0.5, 1.4, 2.0),
        Vec3::new(-3.0, 4.0, -5.0),
        Vec3::new(0.1, 9.0, -2.0),
    ] {
        let middle = world.transform_point3(Vec3::Y);
        let camera = articula_core::Camera::looking_at(eye, middle, viewport);
        let screen = Screen::new(&camera, projection);
        let mut shown = Picture::new(64, 64, [255; 4]).unwrap();
        ImpostorPainter::new(&plan, &atlas).paint(&mut shown, &screen, &world, 0);
        let mut skinned = post.source().skinned(0, 0.0);
        for p in &mut skinned.positions {
            *p = world.transform_point3(*p);
        }
        let options = crate::render::RenderOptions {
            background: [255; 4],
            projection,
            light: plan.light,
            ..crate::render::RenderOptions::default()
        };
        let truth =
            crate::render::render(&post.mesh, &skinned, &post.appearance, &camera, &options);
        let truth = truth.unwrap();
        // Green is only in the background: what is covered differs by less than a pixel around.
        let green = |p: &Picture| {
            p.pixels()
                .iter()
                .map(|c| 255 - u32::from(c[1]))
                .sum::<u32>()
        };
        let pairs = truth.pixels().iter().zip(shown.pixels());
        let off: u32 = pairs.map(|(a, b)| u32::from(a[1].abs_diff(b[1]))).sum();
        let rim = 2.0 * (0.5 + 2.0) * 10.0 * 255.0;
        assert!(
            f64::from(off) < rim,
            "{off} of {} from {eye}",
            green(&truth)
        );
        assert!(green(&shown).abs_diff(green(&truth)) < green(&truth) / 5 + 2000);
    }
}

#[test]
fn the_atlas_holds_each_picture_and_the_table_says_where() {
    let post = Post::new();
    let plan = post.plan(ImpostorBound::Metres(0.1)).unwrap();
    let poses: Vec<Vec<Picture>> = (0..plan.poses())
        .map(|pose| plan.draw(&post.source(), pose).unwrap())
        .collect();
    let atlas = plan.atlas(&poses).unwrap();
    let table: serde_json::Value = serde_json::from_str(&plan.to_json("a.png")).unwrap();
    let columns = table["cell"]["columns"].as_u64().unwrap() as u32;
    let views: u64 = table["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["yaws"].as_u64().unwrap())
        .sum();
    assert_eq!(views as usize, plan.views.len());
    let [width, height] = plan.cell.size_px;
    let (pose, view) = (plan.poses() as u32 - 1, 3);
    let picture = pose * views as u32 + view;
    let (x, y) = (picture % columns * width, picture / columns * height);
    let expected = &poses[pose as usize][view as usize];
    assert_eq!(&atlas.crop(x, y, width, height), expected);
    assert_eq!(table["clips"][1]["name"], "\"rise\"");
    let listed = table["clips"][1]["pose_secs"].as_array().unwrap();
    assert_eq!(listed.len(), plan.clips[1].pose_secs.len());
    assert!(plan.atlas(&poses[1..]).is_err());
}

#[test]
fn every_eye_is_shown_a_direction_beside_it() {
    let post = Post::new();
    let plan = post.plan(ImpostorBound::Metres(0.1)).unwrap();
    let views: Vec<ImpostorView> = plan.views.iter().collect();
    for (i, view) in views.iter().enumerate() {
        assert_eq!(plan.views.nearest(view.to_eye * 3.0), i);
    }
    for (view, corners) in views.iter().zip(plan.views.corners()) {
        for corner in corners {
            assert!(view.to_eye.dot(corner) > 0.5 - 1e-3);
        }
    }
}

#[test]
fn the_table_of_a_crowd_shows_the_same_poses() {
    let post = Post::new();
    let plan = post.plan(ImpostorBound::Metres(0.1)).unwrap();
    let table = plan.table().unwrap();
    for (c, clip) in plan.clips.iter().enumerate() {
        assert_eq!(table.error_metres(c), Some(clip.error_m));
        for i in 0..=60 {
            let secs = clip.duration_secs * i as f32 / 60.0;
            let pose = (clip.first_pose + clip.pose_at(secs)) as u32;
            assert_eq!(table.pose(c, secs), Some(pose), "clip {c} at {secs} s");
            assert_eq!(plan.clip_of(pose as usize).map(|found| found.0), Some(c));
        }
    }
    assert_eq!(plan.clip_of(plan.poses()), None);
    let buffers = ImpostorBuffers::new(&plan);
    assert_eq!(buffers.cells.len(), 32);
    assert_eq!(buffers.centres.len(), 16 * plan.poses());
    assert_eq!(buffers.rows.len(), 16 * plan.views.rows.len());
    let view = plan.views.iter().nth(2).unwrap();
    let (centre, point) = (Vec3::new(0.3, 1.0, -0.2), Vec3::new(0.7, 1.9, 0.5));
    let shown = view.flattened(centre).transform_point3(point);
    assert!((shown - centre - view.shown(point - centre)).length() < 1e-6);
}

#[test]
fn without_a_mesh_there_is_nothing_and_without_clips_the_rest_pose() {
    let mut post = Post::new();
    post.clips.clear();
    let plan = post.plan(ImpostorBound::Bytes(100_000)).unwrap();
    assert_eq!((plan.clips.len(), plan.poses()), (1, 1));
    assert!(plan.draw(&post.source(), 0).is_ok());
    post.mesh = Mesh::new(&[], 1).unwrap();
    let none = post.plan(ImpostorBound::Bytes(100_000));
    assert_eq!(none, Err(ImpostorError::Nothing));
}
