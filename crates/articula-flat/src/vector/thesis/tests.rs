//! Sizes as printed in the thesis, and what a renderer shows.

use super::*;
use crate::planar::clip::fixture::{loose, turning_cube};
use crate::planar::{PlanarFrame, PlanarMaterial};
use crate::vector::raster::raster;
use glam::{Mat3, Vec2, Vec3};
use proptest::prelude::*;
use resvg::usvg::roxmltree::{Document as Xml, Node};

const POLYGON: ThesisForm = ThesisForm::Polygon;
const PATH: ThesisForm = ThesisForm::Path;

fn options(form: ThesisForm) -> ThesisSvgOptions {
    ThesisSvgOptions {
        form,
        ..ThesisSvgOptions::default()
    }
}

/// The pyramid of thesis 6.2.2: eight faces (four sides, a base of four), turned intermittently by
/// a user for twelve seconds. Both printed sizes of its paths imply 34 frames per second.
fn pyramid() -> PlanarClip {
    let corners = [
        Vec3::new(-1.0, -0.6, -1.0),
        Vec3::new(1.0, -0.6, -1.0),
        Vec3::new(1.0, -0.6, 1.0),
        Vec3::new(-1.0, -0.6, 1.0),
        Vec3::new(0.0, 1.0, 0.0),
        Vec3::new(0.0, -0.6, 0.0),
    ];
    let sides = (0..4).map(|k| [(k + 1) % 4, k, 4]);
    let base = (0..4).map(|k| [k, (k + 1) % 4, 5]);
    let frames = 12 * 34;
    let mut turn = Mat3::from_rotation_x(-0.5);
    let mut clip = PlanarClip {
        width: 500,
        height: 500,
        fps: 34.0,
        frames: Vec::new(),
        triangles: sides.chain(base).collect(),
        surface: vec![0; 8],
        part: vec![0; 8],
        surfaces: vec![PlanarMaterial {
            name: "</svg> & \"stone\" \u{1}".into(),
            albedo: Some([200, 180, 90]),
        }],
        albedo: vec![[200.0, 180.0, 90.0]; 6],
        texture: None,
    };
    for f in 0..frames {
        // One and a half seconds of turning every three seconds.
        let (drag, since) = (f / 102, f % 102);
        if since >= 51 {
            let axis = [Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0), Vec3::NEG_X][drag];
            turn = Mat3::from_axis_angle(axis.normalize(), 0.045) * turn;
        }
        let mut frame = PlanarFrame::default();
        for corner in corners {
            let p = turn * corner;
            let depth = 6.0 - p.z;
            let xy = Vec2::new(p.x, -p.y) * (480.0 / depth);
            frame.xy.push(xy + 250.0);
            frame.nearness.push(1.0 / depth);
            frame.light.push((0.6 + 0.3 * p.z).clamp(0.0, 1.0));
        }
        clip.frames.push(frame);
    }
    clip
}

/// Whether `value` is within a fraction of `of`.
fn near(value: usize, of: f64, share: f64) -> bool {
    (value as f64 / of - 1.0).abs() <= share
}

#[test]
fn the_pyramid_has_the_sizes_of_the_thesis() {
    let clip = pyramid();
    let path = thesis(&clip, &options(PATH)).unwrap();
    assert_eq!(path.triangles, 8);
    // 185 kB of paths, by formula and as printed.
    let formula = formula_bytes(PATH, 8, clip.frames.len());
    assert!(near(path.text.len(), formula as f64, 0.02));
    assert!(near(path.text.len(), 185e3, 0.03));
    // 529 kB of polygons: for every face in view in a frame. Their number depends on the user who
    // turned it; this one shows 4.0 faces per frame, the printed sizes imply 4.5.
    let polygon = thesis(&clip, &options(POLYGON)).unwrap();
    assert_eq!(polygon.shown, path.shown);
    let formula = formula_bytes(POLYGON, 1, polygon.shown);
    assert!(near(polygon.text.len(), formula as f64, 0.09));
    assert!(near(polygon.text.len(), 529e3, 0.2));
    // 55 kB with optimisations; each of them helps.
    let size = |optimise_hidden, optimise_static| {
        let options = ThesisSvgOptions {
            optimise_hidden,
            optimise_static,
            ..options(PATH)
        };
        thesis(&clip, &options).unwrap().text.len()
    };
    let [hidden, both] = [size(true, false), size(true, true)];
    assert!(both < size(false, true) && both < hidden && hidden < path.text.len());
    assert!(near(both, 55e3, 0.2), "{both}");
}

#[test]
fn a_gouraud_face_takes_what_the_thesis_says() {
    let clip = pyramid();
    for frame in [0, 200] {
        let form = ThesisForm::GouraudStill { frame };
        let still = thesis(&clip, &options(form)).unwrap();
        let formula = formula_bytes(form, still.triangles, 1);
        let head = Document::new(clip.width, clip.height).end().0.len();
        // Coordinates have two decimals here, colours six digits; the rest is as verbose as
        // filters are.
        let bytes = still.text.len() - head;
        assert!(near(bytes, formula as f64, 0.1), "{bytes} for {formula}");
        assert_eq!(still.shown, still.triangles);
        assert_eq!(
            still.text.matches("<linearGradient").count(),
            3 * still.triangles
        );
        assert_eq!(still.text.matches("<polygon").count(), 4 * still.triangles);
    }
}

#[test]
fn xml_is_well_formed_whatever_materials_are_called() {
    let clip = pyramid();
    for form in [POLYGON, PATH, ThesisForm::GouraudStill { frame: 3 }] {
        let file = thesis(&clip, &options(form)).unwrap();
        let xml = Xml::parse(&file.text).unwrap();
        let elements = xml.descendants().filter(Node::is_element).count();
        assert_eq!(elements, file.elements);
    }
}

#[test]
fn wrong_frames_and_what_is_out_of_view_are_told() {
    let cube = turning_cube(4);
    let late = ThesisSvgOptions {
        neutral_frame: 4,
        ..ThesisSvgOptions::default()
    };
    for options in [late, options(ThesisForm::GouraudStill { frame: 4 })] {
        let refused = thesis(&cube, &options);
        assert!(matches!(refused, Err(PlanarError::Mismatch { .. })));
    }
    let mut fast = cube.clone();
    fast.fps = 1001.0;
    assert!(matches!(
        thesis(&fast, &ThesisSvgOptions::default()),
        Err(PlanarError::Mismatch { at: "fps", .. })
    ));
    let back = [[2.0, 2.0, 0.5], [9.0, 2.0, 0.5], [2.0, 9.0, 0.5]];
    let away = loose(&[(back, [0; 3])], 2);
    assert_eq!(
        thesis(&away, &ThesisSvgOptions::default()),
        Err(PlanarError::NothingVisible)
    );
    // A gigabyte is refused before it is written.
    assert!(fits(MAX_BYTES).is_ok() && fits(MAX_BYTES + 1).is_err());
}

#[test]
fn who_does_not_play_sees_the_first_frame() {
    // The first frame differs from the neutral one and has other light.
    let clip = turning_cube(9);
    for form in [POLYGON, PATH] {
        let options = ThesisSvgOptions {
            neutral_frame: 4,
            optimise_hidden: true,
            ..options(form)
        };
        let file = raster(&thesis(&clip, &options).unwrap().text, [255; 4]).unwrap();
        let of = |f: f64| raster(&thesis_frame(&clip, &options, f).unwrap(), [255; 4]).unwrap();
        assert!(file == of(0.0) && file != of(1.0));
        // Between two frames a path moves, a polygon does not.
        assert_eq!(of(0.5) == of(0.0), form == POLYGON);
        for bad in [9.0, -0.1, f64::NAN, f64::INFINITY] {
            assert!(thesis_frame(&clip, &options, bad).is_err());
        }
    }
}

/// What a renderer shows of a file at a time: faces in painting order, each with the coordinates of
/// its outline. Slow and independent of the writer: the last animation that began applies, and is
/// frozen.
fn played(text: &str, secs: f64) -> Vec<(String, Vec<f64>)> {
    let xml = Xml::parse(text).unwrap();
    let shapes = xml.root_element().children().filter(Node::is_element);
    let mut out = Vec::new();
    for shape in shapes {
        let mut visibility = shape.attribute("visibility").unwrap().to_owned();
        let mut outline = shape
            .attribute("d")
            .or(shape.attribute("points"))
            .map(numbers)
            .unwrap();
        for tag in shape.children().filter(Node::is_element) {
            let time = |name: &str| {
                let value = tag.attribute(name)?.strip_suffix('s')?;
                value.parse::<f64>().ok()
            };
            let since = secs - time("begin").unwrap();
            let length = time("dur").unwrap_or(f64::INFINITY);
            let is_over = since > length - 1e-6 && tag.attribute("fill") != Some("freeze");
            if since < -1e-6 || is_over {
                continue;
            }
            match tag.tag_name().name() {
                "set" => visibility = tag.attribute("to").unwrap().to_owned(),
                _ => outline = sampled(&tag, (since / length).clamp(0.0, 1.0)),
            }
        }
        if visibility == "visible" {
            let id = shape.attribute("id").unwrap();
            let face = id.split("frame").take(2).next().unwrap();
            out.push((face.to_owned(), outline));
        }
    }
    out
}

fn numbers(text: &str) -> Vec<f64> {
    let words = text.split([' ', ',']);
    words.filter_map(|w| w.parse().ok()).collect()
}

fn sampled(tag: &Node<'_, '_>, share: f64) -> Vec<f64> {
    let keys: Vec<Vec<f64>> = tag
        .attribute("values")
        .unwrap()
        .split(';')
        .map(numbers)
        .collect();
    let last = (keys.len() - 1) as f64;
    let even = (0..keys.len()).map(|k| k as f64 / last).collect();
    let times = tag.attribute("keyTimes").map_or(even, |t| {
        t.split(';')
            .map(|t| t.parse().unwrap())
            .collect::<Vec<f64>>()
    });
    let Some(after) = times.iter().position(|t| *t > share) else {
        return keys[keys.len() - 1].clone();
    };
    let along = (share - times[after - 1]) / (times[after] - times[after - 1]);
    let pairs = keys[after - 1].iter().zip(&keys[after]);
    pairs.map(|(a, b)| a + (b - a) * along).collect()
}

#[test]
fn one_frame_stays() {
    let clip = turning_cube(1);
    for form in [POLYGON, PATH] {
        let text = thesis(&clip, &options(form)).unwrap().text;
        let first = played(&text, 0.0);
        assert!(!first.is_empty());
        assert_eq!(played(&text, 7.0), first);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// All optimisations show the same faces at the same positions in every frame.
    #[test]
    fn all_forms_and_optimisations_show_the_same(
        held in prop::collection::vec(0usize..40, 40),
        optimise_hidden: bool,
        optimise_static: bool,
        neutral_frame in 0usize..40,
    ) {
        let cube = turning_cube(40);
        let mut clip = cube.clone();
        // Frames that repeat others: at rest in intervals, and with jumps.
        let mut frame = 0;
        for (f, to) in held.iter().enumerate() {
            frame = if *to < 12 { *to } else { frame };
            clip.frames[f] = cube.frames[frame].clone();
        }
        let of = |form, optimise_hidden, optimise_static| {
            let options = ThesisSvgOptions { form, optimise_hidden, optimise_static, neutral_frame };
            thesis(&clip, &options).unwrap().text
        };
        let polygon = of(POLYGON, false, false);
        let path = of(PATH, optimise_hidden, optimise_static);
        for f in 0..40 {
            let secs = f as f64 / 25.0;
            let (a, b) = (played(&polygon, secs), played(&path, secs));
            prop_assert_eq!(a.len(), b.len());
            for ((name, at), (path_name, path_at)) in a.iter().zip(&b) {
                prop_assert_eq!(name, path_name);
                let apart = at.iter().zip(path_at).map(|(x, y)| (x - y).abs());
                prop_assert!(apart.fold(0.0, f64::max) < 2e-3, "{name} in frame {f}");
            }
        }
    }
}
