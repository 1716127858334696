//! Properties of the human with a face: clothes, hair, lids and lips at every triangle count.
#![allow(
    clippy::unwrap_used,
    reason = "a failed step of a test is a failed test"
)]

use articula_core::arkit_table::BLEND_SHAPES;
use articula_core::feature_points::{FEATURE_POINTS, PointId};
use articula_core::source::{Character, Primitive, Property, RawMesh};
use articula_human::{HumanOptions, feature_points, human};
use glam::Vec3;
use std::collections::{HashMap, HashSet};
use std::sync::OnceLock;

/// The human with this number of triangles, created once.
fn of(triangles: usize) -> &'static Character {
    static HUMANS: [OnceLock<Character>; 3] = [const { OnceLock::new() }; 3];
    let index = match triangles {
        2_000 => 0,
        12_000 => 1,
        _ => 2,
    };
    HUMANS[index].get_or_init(|| {
        human(&HumanOptions {
            triangles,
            face: true,
        })
        .unwrap()
    })
}

const COUNTS: [usize; 3] = [2_000, 12_000, 70_000];

fn mesh<'a>(character: &'a Character, name: &str) -> &'a RawMesh {
    let mut meshes = character.meshes.iter();
    meshes.find(|mesh| mesh.name == name).unwrap()
}

fn of_material<'a>(character: &'a Character, name: &str) -> Vec<&'a Primitive> {
    let index = character.materials.iter().position(|m| m.name == name);
    let primitives = character.meshes.iter().flat_map(|m| &m.primitives);
    primitives.filter(|p| p.material == index).collect()
}

/// Corner positions of the triangles of some materials, by their bits.
fn triangles(character: &Character, names: &[&str]) -> Vec<[[u32; 3]; 3]> {
    let primitives = names.iter().flat_map(|name| of_material(character, name));
    let corners = |p: &Primitive| -> Vec<[[u32; 3]; 3]> {
        let bits = |v: u32| {
            (p.positions[v as usize] + Vec3::ZERO)
                .to_array()
                .map(f32::to_bits)
        };
        p.triangles.iter().map(|t| t.map(bits)).collect()
    };
    primitives.flat_map(corners).collect()
}

fn assert_closed(triangles: &[[[u32; 3]; 3]], at: &str) {
    let edges = triangles
        .iter()
        .flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]);
    let mut directed = HashSet::new();
    for edge in edges {
        assert!(
            directed.insert(edge),
            "{at}: an edge is used twice in one direction"
        );
    }
    let open = directed.iter().any(|(a, b)| !directed.contains(&(*b, *a)));
    assert!(!open, "{at}: an open edge");
}

#[test]
fn counts_are_met_and_skin_with_clothes_is_one_closed_surface() {
    for count in COUNTS {
        let character = of(count);
        let primitives = character.meshes.iter().flat_map(|m| &m.primitives);
        let found: usize = primitives.map(|p| p.triangles.len()).sum();
        assert!(found.abs_diff(count) * 20 <= count, "{found} of {count}");
        let tones = ["skin", "mouth", "shirt", "trousers", "shoes"];
        assert_closed(&triangles(character, &tones), &format!("skin at {count}"));
        for solid in ["hair", "brows"] {
            assert_closed(
                &triangles(character, &[solid]),
                &format!("{solid} at {count}"),
            );
        }
    }
}

#[test]
fn the_face_is_a_mirror_image_of_itself() {
    for primitive in &mesh(of(12_000), "face").primitives {
        let bits = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
        let places: HashMap<_, _> = primitive.positions.iter().map(|p| (bits(*p), ())).collect();
        for p in &primitive.positions {
            assert!(
                places.contains_key(&bits(*p * Vec3::new(-1.0, 1.0, 1.0))),
                "{p}"
            );
        }
    }
}

#[test]
fn clothes_have_three_values_that_differ_in_lightness() {
    let character = of(2_000);
    let luminance = |name: &str| {
        let material = character.materials.iter().find(|m| m.name == name).unwrap();
        material
            .base_color
            .truncate()
            .dot(Vec3::new(0.2126, 0.7152, 0.0722))
    };
    let values = ["shirt", "shoes", "trousers"].map(luminance);
    for pair in values.windows(2) {
        // Half a photographic stop at least.
        assert!(pair[0] > 1.4 * pair[1], "{values:?}");
    }
}

#[test]
fn eyes_are_larger_than_the_mannequins_and_brows_taper_outwards() {
    let character = of(12_000);
    let half_width = |primitives: &[&Primitive], from: f32, to: f32| {
        let points = primitives.iter().flat_map(|p| &p.positions);
        let heights: Vec<f32> = points
            .filter(|p| (from..to).contains(&p.x))
            .map(|p| p.y)
            .collect();
        let (low, high) = (
            heights.iter().copied().fold(f32::MAX, f32::min),
            heights.iter().copied().fold(f32::MIN, f32::max),
        );
        0.5 * (high - low)
    };
    let mannequin = human(&HumanOptions::mannequin(12_000)).unwrap();
    let radius = |c: &Character| half_width(&of_material(c, "sclera"), 0.0, 1.0);
    let ratio = radius(character) / radius(&mannequin);
    assert!((1.25..1.35).contains(&ratio), "{ratio}");
    let brows = of_material(character, "brows");
    let (inner, outer) = (
        half_width(&brows, 0.012, 0.024),
        half_width(&brows, 0.045, 0.06),
    );
    assert!(inner > 1.3 * outer, "{inner} and {outer}");
}

/// Positions of a primitive of the face with one blend shape at weight 1.
fn shaped(face: &RawMesh, primitive: &Primitive, name: &str) -> Vec<Vec3> {
    let index = face.morph_names.iter().position(|n| n == name).unwrap();
    let offsets = &primitive.morphs[index].positions;
    primitive
        .positions
        .iter()
        .zip(offsets)
        .map(|(p, o)| *p + *o)
        .collect()
}

#[test]
fn the_morph_targets_are_the_52_of_arkit() {
    for count in COUNTS {
        let face = mesh(of(count), "face");
        let names = BLEND_SHAPES.iter().map(|shape| shape.name);
        assert!(face.morph_names.iter().map(String::as_str).eq(names));
        assert_eq!(face.morph_weights, [0.0; 52]);
        for (index, name) in face.morph_names.iter().enumerate() {
            let offsets = face
                .primitives
                .iter()
                .flat_map(|p| &p.morphs[index].positions);
            let largest = offsets.map(|o| o.length()).fold(0.0, f32::max);
            // Every shape is seen, and none leaves the head.
            assert!(
                (0.001..0.04).contains(&largest),
                "{name} at {count}: {largest}"
            );
        }
    }
}

/// Height in metres of the largest gap between the lids through which an eyeball is seen from the front.
fn seen_eyeball(character: &Character, shape: Option<&str>, left: bool) -> f32 {
    const PIXEL: f32 = 1e-4;
    const SIZE: usize = 500;
    let face = mesh(character, "face");
    let low = Vec3::new(if left { 0.0325 } else { -0.0325 } - 0.025, 1.6082, 0.0);
    let mut depth = vec![(f32::MIN, false); SIZE * SIZE];
    for primitive in &face.primitives {
        let name = &character.materials[primitive.material.unwrap()].name;
        let is_eyeball = ["sclera", "iris", "pupil"].contains(&name.as_str());
        let positions = match shape {
            Some(shape) => shaped(face, primitive, shape),
            None => primitive.positions.clone(),
        };
        for t in &primitive.triangles {
            draw(
                t.map(|v| (positions[v as usize] - low) / PIXEL),
                SIZE,
                |at, z| {
                    if z > depth[at].0 {
                        depth[at] = (z, is_eyeball);
                    }
                },
            );
        }
    }
    let mut tallest = 0;
    for x in 0..SIZE {
        let mut run = 0;
        for y in 0..SIZE {
            run = if depth[y * SIZE + x].1 { run + 1 } else { 0 };
            tallest = tallest.max(run);
        }
    }
    tallest as f32 * PIXEL
}

/// Calls `put` with the index and the depth of each pixel whose centre a triangle covers.
fn draw([a, b, c]: [Vec3; 3], size: usize, mut put: impl FnMut(usize, f32)) {
    let cross = |p: Vec3, q: Vec3, r: Vec3| (q - p).truncate().perp_dot((r - p).truncate());
    let area = cross(a, b, c);
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let range = |from: f32, to: f32| {
        let limit = |v: f32| v.clamp(0.0, size as f32) as usize;
        limit(from)..limit(to + 1.0)
    };
    for y in range(low.y, high.y) {
        for x in range(low.x, high.x) {
            let p = Vec3::new(x as f32 + 0.5, y as f32 + 0.5, 0.0);
            let [u, v, w] = [cross(b, c, p), cross(c, a, p), cross(a, b, p)].map(|s| s / area);
            if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                put(y * size + x, u * a.z + v * b.z + w * c.z);
            }
        }
    }
}

#[test]
fn a_blink_hides_the_eyeball_and_an_open_eye_shows_it() {
    for count in COUNTS {
        for (left, shape, other) in [
            (true, "eyeBlinkLeft", "eyeBlinkRight"),
            (false, "eyeBlinkRight", "eyeBlinkLeft"),
        ] {
            let seen = |shape| seen_eyeball(of(count), shape, left);
            let open = seen(None);
            assert!((0.007..0.014).contains(&open), "{open} at {count}");
            assert_eq!(seen(Some(other)), open);
            let gap = seen(Some(shape));
            assert!(gap <= 3e-4, "{shape} leaves {gap} m at {count}");
            assert!(seen(Some(&shape.replace("Blink", "Wide"))) > open + 0.001);
        }
    }
}

#[test]
fn no_triangle_is_turned_over_by_a_shape() {
    let mut turned = Vec::new();
    for count in COUNTS {
        let face = mesh(of(count), "face");
        for name in &face.morph_names {
            for primitive in &face.primitives {
                let mut moved = shaped(face, primitive, name);
                if name == "mouthClose" {
                    // It closes the lips over an open jaw and is not shown without it.
                    let open = shaped(face, primitive, "jawOpen");
                    for ((p, open), rest) in moved.iter_mut().zip(open).zip(&primitive.positions) {
                        *p += open - *rest;
                    }
                }
                for t in &primitive.triangles {
                    let area = |points: &[Vec3]| {
                        let [a, b, c] = t.map(|v| points[v as usize]);
                        (b - a).cross(c - a)
                    };
                    let (before, after) = (area(&primitive.positions), area(&moved));
                    let material = &of(count).materials[primitive.material.unwrap()].name;
                    let at = primitive.positions[t[0] as usize];
                    if before.dot(after) <= 0.0 {
                        turned.push(format!("{name}: {material} at {at}, {count}"));
                    }
                }
            }
        }
    }
    assert!(turned.is_empty(), "{}: {turned:#?}", turned.len());
}

#[test]
fn shapes_of_both_sides_are_mirror_images() {
    let flip = Vec3::new(-1.0, 1.0, 1.0);
    let bits = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
    let face = mesh(of(12_000), "face");
    for (index, name) in face.morph_names.iter().enumerate() {
        let twin = match (name.strip_suffix("Left"), name.strip_suffix("Right")) {
            (Some(stem), _) => format!("{stem}Right"),
            (_, Some(stem)) => format!("{stem}Left"),
            _ => name.clone(),
        };
        let twin = face.morph_names.iter().position(|n| *n == twin).unwrap();
        for primitive in &face.primitives {
            let [here, there] = [index, twin].map(|i| &primitive.morphs[i].positions);
            let places = primitive.positions.iter().enumerate();
            let places: HashMap<_, usize> = places.map(|(v, p)| (bits(*p), v)).collect();
            for (v, p) in primitive.positions.iter().enumerate() {
                let other = places[&bits(*p * flip)];
                let difference = here[v].distance(there[other] * flip);
                assert!(difference < 1e-6, "{name} at {p}");
            }
        }
    }
}

#[test]
fn the_jaw_opens_the_mouth_and_lips_can_stay_closed() {
    for count in COUNTS {
        let face = mesh(of(count), "face");
        let lips: Vec<&Primitive> = face
            .primitives
            .iter()
            .filter(|p| of_material(of(count), "lips").contains(p))
            .collect();
        let [upper, lower] = lips[..] else {
            panic!("two lips")
        };
        // The inner contours lie together at rest.
        let pairs: Vec<(usize, usize)> = (0..upper.positions.len())
            .filter_map(|v| {
                let same = |q: &Vec3| q.distance(upper.positions[v]) < 1e-5;
                Some((v, lower.positions.iter().position(same)?))
            })
            .collect();
        assert!(pairs.len() >= 9, "{} at {count}", pairs.len());
        let gap = |names: &[&str]| {
            let at = |p: &Primitive, v: usize| {
                let moved = names.iter().map(|n| shaped(face, p, n)[v] - p.positions[v]);
                p.positions[v] + moved.sum::<Vec3>()
            };
            let gaps = pairs
                .iter()
                .map(|(v, w)| at(upper, *v).distance(at(lower, *w)));
            gaps.fold(0.0, f32::max)
        };
        // An adult opens a mouth by 15 to 50 mm.
        assert!(
            (0.015..0.05).contains(&gap(&["jawOpen"])),
            "{}",
            gap(&["jawOpen"])
        );
        assert!(gap(&["jawOpen", "mouthClose"]) < 3e-4);
        assert!(gap(&["mouthPucker"]) < 3e-4);
        assert!(gap(&["mouthFunnel"]) > 0.004);
    }
}

#[test]
fn clips_blink_look_and_speak_and_loop_exactly() {
    let character = of(2_000);
    let names: Vec<&str> = character.clips.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["idle", "walk", "wave", "talk"]);
    for name in ["idle", "talk"] {
        let clip = character.clips.iter().find(|c| c.name == name).unwrap();
        for channel in &clip.channels {
            let size = channel.values.len() / channel.times_secs.len();
            let last = channel.values.len() - size;
            assert_eq!(channel.values[..size], channel.values[last..], "{name}");
        }
        let face = clip
            .channels
            .iter()
            .find(|c| c.property == Property::Weights)
            .unwrap();
        assert_eq!(character.meshes[face.target].name, "face");
        assert!(face.values.iter().all(|w| (0.0..=1.0).contains(w)));
        let of_shape = |shape: &str| -> Vec<f32> {
            let index = BLEND_SHAPES.iter().position(|s| s.name == shape).unwrap();
            face.values.chunks_exact(52).map(|key| key[index]).collect()
        };
        // Adults blink 10 to 40 times per minute; both eyes together and wholly.
        let closed = of_shape("eyeBlinkLeft");
        assert_eq!(closed, of_shape("eyeBlinkRight"));
        let blinks = closed
            .windows(2)
            .filter(|w| w[0] < 0.9 && w[1] >= 0.9)
            .count();
        let per_minute = 60.0 * blinks as f32 / clip.duration_secs;
        assert!((10.0..=40.0).contains(&per_minute), "{name}: {per_minute}");
        let jaw = of_shape("jawOpen");
        let opened = jaw
            .windows(3)
            .filter(|w| w[1] > 0.1 && w[1] > w[0] && w[1] >= w[2])
            .count();
        assert_eq!(
            opened >= 5,
            name == "talk",
            "{name} opens the jaw {opened} times"
        );
        let eye = |side: &str| {
            let name = format!("{side}_eyeball_joint");
            let joint = character
                .skeleton
                .joints
                .iter()
                .position(|j| j.name == name)
                .unwrap();
            clip.channels
                .iter()
                .find(|c| c.property == Property::Rotation && c.target == joint)
        };
        assert_eq!(eye("l").unwrap().values, eye("r").unwrap().values, "{name}");
    }
}

#[test]
fn feature_points_are_all_84_mirrored_and_on_the_face() {
    let points = feature_points();
    let ids = FEATURE_POINTS.iter().map(|entry| entry.point);
    assert!(points.iter().map(|p| p.point).eq(ids));
    let place = |id: PointId| points.iter().find(|p| p.point == id).unwrap().position;
    let primitives = ["face", "hair"].map(|name| &mesh(of(70_000), name).primitives);
    // Corners, middles of edges and centres of the triangles.
    let samples: Vec<Vec3> = primitives
        .into_iter()
        .flatten()
        .flat_map(|p| {
            p.triangles
                .iter()
                .map(|t| t.map(|v| p.positions[v as usize]))
        })
        .flat_map(|[a, b, c]| {
            [
                a,
                b,
                c,
                (a + b) / 2.0,
                (b + c) / 2.0,
                (c + a) / 2.0,
                (a + b + c) / 3.0,
            ]
        })
        .collect();
    for entry in &FEATURE_POINTS {
        let p = place(entry.point);
        assert_eq!(
            p * Vec3::new(-1.0, 1.0, 1.0),
            place(entry.mirror),
            "{:?}",
            entry.point
        );
        // Left and right are the subject's, who looks along +Z.
        let words: Vec<&str> = entry.place.split([' ', ',']).collect();
        let right = words.iter().rev().find(|w| ["left", "right"].contains(w));
        if entry.mirror != entry.point && entry.point.0 != 3 && entry.point.0 != 4 {
            assert_eq!(p.x < 0.0, right == Some(&"right"), "{:?}", entry.point);
        }
        // The scalp below the hair is coarse; the centre of the head's rotation lies within.
        let reach = match entry.point {
            (11, 4 | 6) => 0.015,
            (7, 1) => 0.1,
            _ => 0.004,
        };
        let distances = samples.iter().map(|v| v.distance(p));
        let nearest = distances.fold(f32::MAX, f32::min);
        assert!(nearest < reach, "{:?}: {nearest} m", entry.point);
    }
    // Heights in the order of a face.
    let column = [
        (11, 5),
        (11, 4),
        (11, 1),
        (4, 1),
        (3, 5),
        (9, 3),
        (9, 15),
        (8, 1),
        (2, 2),
        (8, 2),
        (2, 10),
        (2, 1),
    ];
    let heights = column.map(|id| place(id).y);
    assert!(heights.is_sorted_by(|a, b| a > b), "{heights:?}");
    // Ears reach from the brows to the base of the nose.
    assert!((place((10, 1)).y - place((4, 1)).y).abs() < 0.006);
    assert!((place((10, 5)).y - place((9, 15)).y).abs() < 0.015);
}
