//! Tests of whole portraits: a mask of red lips in front of a green tongue, with a blue left cheek.

use super::document::PictureFormat;
use super::evaluate::truth;
use super::flat_mesh::FlatMesh;
use super::posing::{Poser, places, project};
use super::visibility::NOT_SEEN;
use super::*;
use crate::appearance::Appearance;
use crate::picture::Rgba;
use articula_core::source::{self, Joint, MorphTarget, Primitive, Skeleton, Skin};
use articula_core::{
    Articulation, Camera, JointArticulation, Mesh, Progress, Region, Rig, Transform, Viewport,
};
use glam::{Affine3A, Vec2, Vec3, Vec4};

/// A rectangle of two triangles and one colour, with its offset when the mouth is open.
fn plate(corners: [Vec3; 4], color: Vec4, open: Vec3) -> source::RawMesh {
    source::RawMesh {
        skin: Skin {
            joints: vec![0],
            inverse_bind: vec![Affine3A::IDENTITY],
        },
        morph_weights: vec![0.0],
        primitives: vec![Primitive {
            positions: corners.to_vec(),
            colors: vec![color; 4],
            influences: 1,
            joints: vec![0; 4],
            weights: vec![1.0; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            morphs: vec![MorphTarget {
                positions: vec![open; 4],
                normals: Vec::new(),
            }],
            ..Primitive::default()
        }],
        ..source::RawMesh::default()
    }
}

struct Mask {
    mesh: Mesh,
    rig: Rig,
    appearance: Appearance,
    expressions: Vec<PortraitExpression>,
    camera: Camera,
}

fn mask() -> Mask {
    let flat = |left: f32, right: f32, low: f32, high: f32, z: f32| {
        [(left, low), (right, low), (right, high), (left, high)].map(|(x, y)| Vec3::new(x, y, z))
    };
    let red = Vec4::new(0.8, 0.0, 0.0, 1.0);
    let down = Vec3::NEG_Y * 0.08;
    let cheek = [(-0.1, 0.05), (-0.1, -0.05), (0.1, -0.05), (0.1, 0.05)];
    let cheek = cheek.map(|(y, z)| Vec3::new(0.1, y, z));
    let meshes = [
        plate(flat(-0.1, 0.1, 0.0, 0.1, 0.05), red, Vec3::ZERO),
        plate(flat(-0.1, 0.1, -0.1, 0.0, 0.05), red, down),
        plate(
            flat(-0.03, 0.03, -0.06, 0.03, 0.0),
            Vec4::Y + Vec4::W,
            Vec3::ZERO,
        ),
        plate(cheek, Vec4::Z + Vec4::W, Vec3::ZERO),
    ];
    let skeleton = Skeleton {
        joints: vec![Joint {
            name: "head".to_owned(),
            parent: None,
            rest: Transform::IDENTITY,
            in_skin: true,
        }],
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![JointArticulation {
            hanim: None,
            level: 0,
            region: Region::Torso,
        }],
    };
    let mesh = Mesh::new(&meshes, 1).unwrap();
    let opened = |slot: &usize| (*slot as u16, 1.0);
    let expressions = vec![PortraitExpression {
        name: "jawOpen\"<".to_owned(),
        morphs: mesh.morph_slots.iter().map(opened).collect(),
        joints: Vec::new(),
    }];
    let viewport = Viewport {
        width_px: 120.0,
        height_px: 120.0,
        ..Viewport::default()
    };
    Mask {
        rig: Rig::new(&skeleton, articulation).unwrap(),
        appearance: Appearance::default(),
        expressions,
        camera: Camera::looking_at(Vec3::Z * 0.6, Vec3::ZERO, viewport),
        mesh,
    }
}

impl Mask {
    fn source(&self) -> PortraitSource<'_> {
        PortraitSource {
            mesh: &self.mesh,
            rig: &self.rig,
            appearance: &self.appearance,
            triangles: &self.mesh.triangles,
            head: Head::Whole { pivot: Vec3::ZERO },
            expressions: &self.expressions,
            clips: &[],
            camera: self.camera,
        }
    }

    fn portrait(&self, views: usize) -> Portrait {
        let options = PortraitOptions {
            views,
            ..PortraitOptions::default()
        };
        build(&self.source(), &options, &mut Progress::none()).unwrap()
    }
}

/// Strongest of red, green and blue; `None` for a transparent pixel.
fn strongest(pixel: Option<Rgba>) -> Option<usize> {
    let [r, g, b, a] = pixel?;
    let all = [r, g, b];
    (a > 128).then(|| (0..3).max_by_key(|i| all[*i]).unwrap())
}

#[test]
fn what_lips_cover_appears_when_they_open() {
    let mask = mask();
    let portrait = mask.portrait(3);
    // The tongue's two triangles lie behind the lips, in a separate layer.
    assert_eq!(portrait.layers.of_view[0][4..6], [1, 1]);
    assert_eq!(portrait.layers.of_view[0][..4], [0; 4]);
    let closed = portrait.picture(&HeadPose::default(), &[0.0]).unwrap();
    let open = portrait.picture(&HeadPose::default(), &[1.0]).unwrap();
    // 0.03 m below the centre, between the lips once they are open.
    assert_eq!(strongest(closed.get(60, 65)), Some(0));
    assert_eq!(strongest(open.get(60, 65)), Some(1));
    assert_eq!(strongest(open.get(60, 50)), Some(0));
    assert_eq!(open.get(2, 2), Some([0; 4]));
    // With the head turned, the mouth is still right.
    let turned = portrait.picture(&HeadPose::yaw(20.0), &[1.0]).unwrap();
    let options = PortraitOptions::default();
    let wanted = truth(&mask.source(), &options, &HeadPose::yaw(20.0), &[1.0]).unwrap();
    let off = evaluate::rmse_over_figure(&turned, &wanted).unwrap();
    assert!(off < 12.0, "{off}");
}

#[test]
fn side_views_show_the_cheek_that_the_front_does_not() {
    let mask = mask();
    let (one, three) = (mask.portrait(1), mask.portrait(3));
    // The cheek is seen edge-on in front, and is visible only in the view from its side (the head
    // turned to its right, which is the second view).
    assert_eq!(three.layers.of_view[0][6], NOT_SEEN);
    assert_eq!(three.layers.of_view[1][6], 0);
    assert_eq!(three.layers.of_view[2][6], NOT_SEEN);
    let pose = HeadPose::yaw(-40.0);
    let error = |portrait: &Portrait, views| {
        let options = PortraitOptions {
            views,
            ..PortraitOptions::default()
        };
        portrait
            .error(&mask.source(), &options, &pose, &[])
            .unwrap()
    };
    let (worse, better) = (error(&one, 1), error(&three, 3));
    // What remains are edges of strong colours, in a small picture.
    assert!(
        better < 15.0 && 5.0 * better < worse,
        "{better} and {worse}"
    );
}

#[test]
fn nodes_are_exact_and_blend_in_between() {
    let mask = mask();
    let portrait = mask.portrait(3);
    let source = mask.source();
    let poser = Poser::new(&mask.mesh, &mask.rig, &source.head, &mask.expressions);
    let at = |pose: HeadPose, weight: f32| portrait.places(&pose, &[weight]).unwrap();
    for (yaw_degrees, pitch_degrees) in [(0.0, 0.0), (-45.0, 10.0), (52.5, -30.0)] {
        let pose = HeadPose {
            yaw_degrees,
            pitch_degrees,
            roll_degrees: 0.0,
        };
        for weight in [0.0, 1.0] {
            let skinned = poser.skin(pose, &[(0, weight)]);
            let true_places = places(&project(&skinned, &mask.camera, pose).unwrap());
            for (v, place) in portrait.mesh.vertices.iter().zip(at(pose, weight)) {
                // The tolerance is a root mean square; twice 0.1 px and half a step of 8 bits.
                let off = place.distance(true_places[*v as usize]);
                assert!(off < 0.4, "{off} at yaw {yaw_degrees}");
            }
        }
    }
    // Halfway between two nodes is the mean, and beyond the border the border.
    let (a, b) = (at(HeadPose::yaw(7.5), 0.5), at(HeadPose::yaw(15.0), 0.5));
    for ((a, b), m) in a.iter().zip(&b).zip(at(HeadPose::yaw(11.25), 0.5)) {
        assert!((0.5 * (*a + *b) - m).length() < 1e-3);
    }
    assert_eq!(at(HeadPose::yaw(60.0), 0.0), at(HeadPose::yaw(80.0), 0.0));
}

#[test]
fn tilting_turns_the_picture_about_the_pivot() {
    let portrait = mask().portrait(1);
    let roll = |roll_degrees| HeadPose {
        roll_degrees,
        ..HeadPose::default()
    };
    let straight = portrait.places(&roll(0.0), &[]).unwrap();
    let tilted = portrait.places(&roll(90.0), &[]).unwrap();
    for (s, t) in straight.iter().zip(&tilted) {
        // Counter-clockwise as seen: what is right of the pivot moves up, to smaller y.
        let (s, t) = (*s - portrait.roll.pivot, *t - portrait.roll.pivot);
        assert!((t - Vec2::new(s.y, -s.x)).length() < 1e-3, "{s} {t}");
    }
}

#[test]
fn angles_come_back_from_rotations() {
    let pose = HeadPose {
        yaw_degrees: 30.0,
        pitch_degrees: -7.5,
        roll_degrees: 12.0,
    };
    let back = HeadPose::of_rotation(pose.rotation());
    assert!((back.yaw_degrees - 30.0).abs() < 1e-3, "{back:?}");
    assert!((back.pitch_degrees + 7.5).abs() < 1e-3, "{back:?}");
    assert!((back.roll_degrees - 12.0).abs() < 1e-3, "{back:?}");
    // Towards the figure's left is +X for one that faces +Z; down is -Y.
    assert!((HeadPose::yaw(90.0).rotation() * Vec3::Z - Vec3::X).length() < 1e-6);
    let nod = HeadPose {
        pitch_degrees: 90.0,
        ..HeadPose::default()
    };
    assert!((nod.rotation() * Vec3::Z - Vec3::NEG_Y).length() < 1e-6);
}

#[test]
fn nonsense_is_refused_by_name() {
    let mask = mask();
    let refused = |change: &dyn Fn(&mut PortraitSource<'_>, &mut PortraitOptions)| {
        let (mut source, mut options) = (mask.source(), PortraitOptions::default());
        change(&mut source, &mut options);
        build(&source, &options, &mut Progress::none()).unwrap_err()
    };
    for views in [0, 2, 4, 6, usize::MAX] {
        let error = refused(&|_, o| o.views = views);
        assert!(matches!(error, PortraitError::Mismatch(_)), "{error}");
    }
    for value in [f32::NAN, -1.0, 1e9] {
        assert!(
            refused(&|_, o| o.view_yaw_degrees = value)
                .to_string()
                .contains("view_yaw")
        );
        assert!(
            refused(&|_, o| o.tolerance_px = value)
                .to_string()
                .contains("tolerance")
        );
    }
    let inside = refused(&|s, _| s.camera.eye = Vec3::ZERO);
    assert!(
        matches!(inside, PortraitError::NotInView { .. }),
        "{inside}"
    );
    let empty = refused(&|s, _| s.triangles = &[]);
    assert!(empty.to_string().contains("nothing to show"), "{empty}");
    assert!(
        refused(&|s, _| s.triangles = &[[0, 1, 99]])
            .to_string()
            .contains("[0, 1, 99]")
    );
    assert!(
        refused(&|s, _| s.head = Head::Joints(vec![7]))
            .to_string()
            .contains("joint 7")
    );
    let many = vec![[0, 1, 2]; super::source::MAX_TRIANGLES + 1];
    let error = {
        let mut source = mask.source();
        source.triangles = &many;
        build(&source, &PortraitOptions::default(), &mut Progress::none()).unwrap_err()
    };
    assert!(
        matches!(error, PortraitError::LimitExceeded { .. }),
        "{error}"
    );
    let portrait = mask.portrait(1);
    for weights in [&[f32::NAN][..], &[0.0, 0.0], &[f32::INFINITY]] {
        assert!(portrait.picture(&HeadPose::default(), weights).is_err());
    }
    assert!(portrait.picture(&HeadPose::yaw(f32::NAN), &[]).is_err());
    assert!(portrait.picture_at(&[], &HeadPose::default()).is_err());
}

#[test]
fn a_clip_blends_holds_and_is_checked() {
    let clip = PortraitClip {
        name: "nod".to_owned(),
        rate_hz: 10.0,
        poses: vec![HeadPose::yaw(0.0), HeadPose::yaw(20.0)],
        weights: vec![vec![0.0], vec![1.0]],
    };
    let (pose, weights) = clip.at(0.05);
    assert!((pose.yaw_degrees - 10.0).abs() < 1e-4 && (weights[0] - 0.5).abs() < 1e-6);
    assert_eq!(clip.at(9.0).0, HeadPose::yaw(20.0));
    assert_eq!(clip.at(-1.0).1, [0.0]);
    assert!(clip.check(1).is_ok() && clip.check(2).is_err());
    let mut broken = clip.clone();
    broken.weights[1][0] = f32::NAN;
    assert!(broken.check(1).is_err());
    broken = clip.clone();
    broken.rate_hz = 0.0;
    assert!(broken.check(1).is_err());
    broken = clip;
    broken.poses.clear();
    assert!(broken.check(1).is_err());
}

#[test]
fn neighbours_share_an_edge_and_no_back_is_one() {
    let flat = FlatMesh {
        vertices: (0..4).collect(),
        triangles: vec![[0, 1, 2], [0, 2, 1], [0, 2, 3]],
        materials: vec![None; 3],
    };
    let found = flat.neighbours();
    assert_eq!(found[0], [None, None, Some(2)]);
    assert_eq!(found[1], [Some(2), None, None]);
    assert_eq!(found[2][0], Some(0));
}

/// Checks a value against the subset of JSON Schema that our schema uses.
fn check(
    schema: &serde_json::Value,
    root: &serde_json::Value,
    value: &serde_json::Value,
    at: &str,
) {
    if let Some(name) = schema["$ref"].as_str() {
        let name = name.trim_start_matches("#/$defs/");
        return check(&root["$defs"][name], root, value, at);
    }
    let right = match schema["type"].as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("integer") => value.is_i64() || value.is_u64(),
        Some("number") => value.is_number(),
        Some("boolean") => value.is_boolean(),
        other => panic!("{at}: {other:?} is no type that this test knows"),
    };
    assert!(right, "{at}: {value} is no {}", schema["type"]);
    if let Some(only) = schema.get("const") {
        assert_eq!(value, only, "{at}");
    }
    if let Some(object) = value.as_object() {
        let known = schema["properties"].as_object().unwrap();
        for name in schema["required"].as_array().unwrap() {
            assert!(
                object.contains_key(name.as_str().unwrap()),
                "{at}: no {name}"
            );
        }
        for (name, inner) in object {
            let of = known
                .get(name)
                .unwrap_or_else(|| panic!("{at}: {name} is not described"));
            check(of, root, inner, &format!("{at}.{name}"));
        }
    }
    for (i, inner) in value.as_array().into_iter().flatten().enumerate() {
        check(&schema["items"], root, inner, &format!("{at}[{i}]"));
    }
}

#[test]
fn the_document_is_as_its_schema_says() {
    let mask = mask();
    let mut source = mask.source();
    let clips = [PortraitClip {
        name: "</script>".to_owned(),
        rate_hz: 25.0,
        poses: vec![HeadPose::default(); 2],
        weights: vec![vec![0.0], vec![1.0]],
    }];
    source.clips = &clips;
    let portrait = build(&source, &PortraitOptions::default(), &mut Progress::none()).unwrap();
    let files = portrait.to_files(PictureFormat::Png).unwrap();
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "portrait.json",
            "view0.png",
            "view1.png",
            "view2.png",
            "player.js"
        ]
    );
    let schema = include_str!("../../../../docs/formats/portrait.schema.json");
    let schema: serde_json::Value = serde_json::from_str(schema).unwrap();
    let document: serde_json::Value = serde_json::from_slice(&files[0].1).unwrap();
    check(&schema, &schema, &document, "portrait");
    assert_eq!(document["expressions"][0]["name"], "jawOpen\"<");
    assert_eq!(document["views"][2]["picture"], "view2.png");
    for (view, (_, bytes)) in portrait.views.iter().zip(&files[1..4]) {
        assert_eq!(crate::Picture::decode(bytes).unwrap(), view.picture);
    }
    // The same source gives the same bytes, and a name cannot break out of the page.
    assert_eq!(
        build(&source, &PortraitOptions::default(), &mut Progress::none()).unwrap(),
        portrait
    );
    let plain = page(&portrait, &PageOptions::default()).unwrap();
    assert_eq!(plain.matches("</script>").count(), 2);
    assert!(!plain.contains("<main>"), "the canvas alone");
    assert!(plain.contains("const behind = null;"));
    let controlled = PageOptions {
        title: "a <b>".into(),
        controls: true,
        background: [0.0, 1.5].map(slide).into(),
        ..PageOptions::default()
    };
    let controlled = page(&portrait, &controlled).unwrap();
    let picture = r#""picture":"data:image/png;base64,AA==""#;
    let behind = format!("const behind = [{{\"from\":0,{picture}}},{{\"from\":1.5,{picture}}}];");
    assert!(controlled.contains(&behind));
    assert_eq!(controlled.matches("</script>").count(), 2);
    assert!(controlled.contains("<h1>a &lt;b&gt;</h1>"));
}

fn slide(from_secs: f64) -> Slide {
    let picture = EmbeddedFile {
        media_type: "image/png".into(),
        bytes: vec![0],
    };
    Slide { from_secs, picture }
}

#[test]
fn a_whole_human_turns_its_head_by_the_neck() {
    use crate::planar::fixture::{Figure, figure};
    let Figure {
        asset, appearance, ..
    } = figure();
    let joint = asset.rig.find("skullbase").expect("the human has a head");
    let viewport = Viewport {
        width_px: 100.0,
        height_px: 100.0,
        ..Viewport::default()
    };
    let eye = Vec3::new(0.0, 1.6, 2.0);
    let source = PortraitSource {
        mesh: &asset.mesh,
        rig: &asset.rig,
        appearance: &appearance,
        triangles: &asset.mesh.triangles,
        head: Head::Joints(vec![joint]),
        expressions: &[],
        clips: &[],
        camera: Camera::looking_at(eye, Vec3::Y * 1.5, viewport),
    };
    let options = PortraitOptions {
        tolerance_px: 0.2,
        ..PortraitOptions::default()
    };
    let portrait = build(&source, &options, &mut Progress::none()).unwrap();
    // The shoulders stay, the head does not.
    assert!(portrait.roll.tilts.contains(&0) && portrait.roll.tilts.contains(&255));
    let front = portrait.places(&HeadPose::default(), &[]).unwrap();
    let turned = portrait.places(&HeadPose::yaw(30.0), &[]).unwrap();
    let moved = |tilt: u8| {
        let both = front.iter().zip(&turned).zip(&portrait.roll.tilts);
        let of = both
            .filter(|(_, t)| **t == tilt)
            .map(|((a, b), _)| a.distance(*b));
        of.fold(0.0, f32::max)
    };
    // A face 0.09 m in front of the axis moves 0.045 m sideways, at 60 pixels per metre.
    assert!(
        moved(0) < 1.0 && moved(255) > 2.5,
        "{} {}",
        moved(0),
        moved(255)
    );
}
