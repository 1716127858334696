//! Small golden pictures; `cargo xtask golden` renews them.
#![expect(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    reason = "golden pictures lie beside the test and are renewed on request; a test may fail"
)]

mod figure;

use articula::core::Viewport;
use articula::core::source::{Image, Material};
use articula::flat::{
    Appearance, Bounds, Ground, Picture, RenderOptions, orbit_view, render, rmse,
};
use articula_report::{ContactSheet, JointMark, SheetCell, SheetRow, SheetTile, draw_skeleton};
use glam::Vec4;
use std::path::PathBuf;

/// Root mean square difference that rounding on another machine may cause, levels.
const TOLERANCE: f64 = 0.6;

fn look() -> Appearance {
    let colors = [[220, 120, 60, 255], [240, 220, 190, 255]];
    let stripes = (0..64).map(|i| colors[i / 8 % 2]).collect();
    let stripes = Picture::from_pixels(8, 8, stripes).unwrap();
    let image = Image {
        bytes: stripes.to_png().unwrap(),
        ..Image::default()
    };
    let plain = Material {
        base_color: Vec4::new(0.25, 0.4, 0.6, 1.0),
        ..Material::default()
    };
    let striped = Material {
        base_color_image: Some(0),
        ..Material::default()
    };
    Appearance::new(&[plain, striped], &[image]).0
}

/// The figure alone, and with its skeleton.
fn drawn() -> (Picture, Picture) {
    let figure = figure::bent(0.9);
    let viewport = Viewport {
        width_px: 150.0,
        height_px: 200.0,
        ..Viewport::default()
    };
    let bounds = Bounds::around(figure.skinned.bounds()).unwrap();
    let camera = orbit_view(&bounds, 0.6, 0.25, viewport);
    let options = RenderOptions {
        ground: Some(Ground::below(&bounds, 0.0)),
        ..RenderOptions::default()
    };
    let body = render(&figure.mesh, &figure.skinned, &look(), &camera, &options).unwrap();
    let mut skeleton = body.clone();
    let all = [
        JointMark::Active,
        JointMark::InTransition,
        JointMark::Passive,
    ];
    let marks: Vec<JointMark> = (0..figure.rig.len()).map(|j| all[j / 2 % 3]).collect();
    draw_skeleton(
        &mut skeleton,
        &figure.rig,
        &figure.pose,
        &camera,
        figure.rig.skin_joints(),
        &marks,
    );
    (body, skeleton)
}

/// White where two pictures of one size agree over white, darker by four times their difference.
fn difference(a: &Picture, b: &Picture) -> Picture {
    let [a, b] = [a, b].map(|picture| {
        let mut over = Picture::new(picture.width(), picture.height(), [255; 4]).unwrap();
        over.blit(picture, 0, 0);
        over
    });
    let of = |(p, q): (&[u8; 4], &[u8; 4])| {
        let channel = |i: usize| 255 - p[i].abs_diff(q[i]).saturating_mul(4);
        [channel(0), channel(1), channel(2), 255]
    };
    let pixels = a.pixels().iter().zip(b.pixels()).map(of).collect();
    Picture::from_pixels(a.width(), a.height(), pixels).unwrap()
}

fn check(name: &str, picture: &Picture) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let path = folder.join(format!("{name}.png"));
    if std::env::var_os("ARTICULA_GOLDEN").is_some_and(|v| v == "renew") {
        std::fs::write(&path, picture.to_png().unwrap()).unwrap();
        return;
    }
    let golden = std::fs::read(&path).expect("run `cargo xtask golden` once");
    let golden = Picture::decode(&golden).unwrap();
    let off = rmse(picture, &golden).expect("the size changed; `cargo xtask golden` renews");
    if off > TOLERANCE {
        let scratch = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
        let seen = scratch.join(format!("{name}-difference.png"));
        let apart = difference(picture, &golden);
        std::fs::write(&seen, apart.to_png().unwrap()).unwrap();
        panic!("{name}: {off:.2} levels off; see {}", seen.display());
    }
}

#[test]
fn figure_skeleton_and_sheet_look_as_before() {
    let (body, skeleton) = drawn();
    check("figure", &body);
    check("skeleton", &skeleton);
    let tile = |picture: &Picture, caption: &str| SheetTile {
        picture: picture.clone(),
        caption: caption.to_owned(),
    };
    let tiles = vec![tile(&body, "reference"), tile(&skeleton, "reduced")];
    let sheet = ContactSheet {
        title: "Figure".into(),
        notes: vec!["a knee and an elbow bent".into()],
        columns: vec!["frame 0".into()],
        rows: vec![SheetRow {
            label: "3.5 m".into(),
            cells: vec![SheetCell { tiles }],
        }],
        explains_joints: true,
    };
    check("sheet", &sheet.draw().unwrap());
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let (once, again) = (drawn(), drawn());
    assert_eq!(once.0.to_png().unwrap(), again.0.to_png().unwrap());
    assert_eq!(once.1.to_png().unwrap(), again.1.to_png().unwrap());
}

/// Independent of the golden pictures: the body covers its own projected joints.
#[test]
fn the_figure_stands_where_its_joints_are() {
    let figure = figure::bent(0.9);
    let viewport = Viewport {
        width_px: 300.0,
        height_px: 400.0,
        ..Viewport::default()
    };
    let bounds = Bounds::around(figure.skinned.bounds()).unwrap();
    let camera = orbit_view(&bounds, 0.6, 0.25, viewport);
    let options = RenderOptions::default();
    let picture = render(&figure.mesh, &figure.skinned, &look(), &camera, &options).unwrap();
    for joint in 0..figure.rig.len() {
        let (at, _) = camera.project(figure.pose.position(joint));
        let seen = picture.get(at.x as u32, at.y as u32);
        assert_ne!(seen, Some(options.background), "{}", figure.rig.name(joint));
    }
}
