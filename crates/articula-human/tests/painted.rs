//! Properties of the painted human: its shape, its texture coordinates and its colours.
#![allow(
    clippy::unwrap_used,
    reason = "a failed step of a test is a failed test"
)]

use articula_core::source::{Character, Primitive, TextureWrap};
use articula_human::{HumanError, HumanOptions, PaintedHuman, human, painted_human};
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::sync::OnceLock;

/// The painted human of the default number of triangles, created once.
fn painted() -> &'static PaintedHuman {
    static HUMAN: OnceLock<PaintedHuman> = OnceLock::new();
    HUMAN.get_or_init(|| painted_human(12_000).unwrap())
}

fn plain() -> &'static Character {
    static HUMAN: OnceLock<Character> = OnceLock::new();
    HUMAN.get_or_init(|| human(&HumanOptions::default()).unwrap())
}

fn primitives(character: &Character) -> impl Iterator<Item = &Primitive> {
    character.meshes.iter().flat_map(|m| &m.primitives)
}

fn name<'a>(character: &'a Character, primitive: &Primitive) -> &'a str {
    &character.materials[primitive.material.unwrap()].name
}

/// Linear colour of the px at a texture coordinate.
fn color(of: &PaintedHuman, at: Vec2) -> Vec3 {
    let [x, y] = (at * of.side as f32).to_array().map(|v| v as u32);
    let bytes = of.pixels[(y * of.side + x) as usize];
    Vec3::from(bytes.map(|b| {
        let v = f32::from(b) / 255.0;
        match v <= 0.04045 {
            true => v / 12.92,
            false => ((v + 0.055) / 1.055).powf(2.4),
        }
    }))
}

#[test]
fn shape_skin_and_blend_shapes_are_those_of_the_plain_human() {
    let (painted, plain) = (&painted().character, plain());
    assert_eq!(painted.clips, plain.clips);
    assert_eq!(painted.skeleton, plain.skeleton);
    assert_eq!(primitives(painted).count(), primitives(plain).count());
    for (of, like) in primitives(painted).zip(primitives(plain)) {
        assert_eq!(of.triangles.len(), like.triangles.len());
        assert_eq!(of.morphs.len(), like.morphs.len());
        for (t, u) in of.triangles.iter().zip(&like.triangles) {
            for (v, w) in t.iter().zip(u).map(|(v, w)| (*v as usize, *w as usize)) {
                let influences = |p: &Primitive, v: usize| {
                    let range = v * p.influences..(v + 1) * p.influences;
                    (p.joints[range.clone()].to_vec(), p.weights[range].to_vec())
                };
                assert_eq!(of.positions[v], like.positions[w]);
                assert_eq!(of.normals[v], like.normals[w]);
                assert_eq!(influences(of, v), influences(like, w));
                for (morph, same) in of.morphs.iter().zip(&like.morphs) {
                    assert_eq!(morph.positions[v], same.positions[w]);
                }
            }
        }
    }
    let count = |c| primitives(c).map(|p| p.positions.len()).sum::<usize>();
    let more = count(painted) as f64 / count(plain) as f64;
    assert!((1.0..1.1).contains(&more), "{more} times the vertices");
}

#[test]
fn every_material_shows_the_one_picture() {
    let PaintedHuman {
        character,
        side,
        pixels,
    } = painted();
    assert_eq!(pixels.len(), (side * side) as usize);
    for material in &character.materials {
        assert_eq!(material.base_color.to_array(), [1.0; 4]);
        assert_eq!(material.base_color_image, Some(0));
        assert_eq!(material.base_color_wrap, [TextureWrap::Clamp; 2]);
    }
    for p in primitives(character) {
        assert_eq!(p.texcoords.len(), p.positions.len());
        assert!(
            p.texcoords
                .iter()
                .all(|t| t.min_element() > 0.0 && t.max_element() < 1.0)
        );
    }
}

#[test]
fn both_halves_have_the_same_coordinates() {
    for p in primitives(&painted().character) {
        let mut found: HashMap<[u32; 3], Vec<[u32; 2]>> = HashMap::new();
        let places = |sign: f32| {
            let all = p.positions.iter().zip(&p.texcoords);
            all.filter(move |(p, _)| p.x * sign > 0.0)
                .map(move |(p, t)| {
                    let at = Vec3::new(p.x * sign, p.y, p.z).to_array().map(f32::to_bits);
                    (at, t.to_array().map(f32::to_bits))
                })
        };
        for (at, coordinates) in places(1.0) {
            found.entry(at).or_default().push(coordinates);
        }
        for (at, coordinates) in places(-1.0) {
            assert!(found[&at].contains(&coordinates));
        }
    }
}

/// Points of the left half at the px whose middles its triangles cover.
fn covered(character: &Character, side: u32) -> HashMap<(u32, u32), Vec<(usize, Vec3)>> {
    let mut out: HashMap<_, Vec<_>> = HashMap::new();
    for p in primitives(character) {
        for t in &p.triangles {
            let corners = t.map(|v| p.positions[v as usize]);
            if corners.iter().sum::<Vec3>().x < 0.0 {
                continue;
            }
            let [a, b, c] = t.map(|v| p.texcoords[v as usize] * side as f32);
            let area = (b - a).perp_dot(c - a);
            let (low, high) = (a.min(b).min(c).floor(), a.max(b).max(c).ceil());
            for y in low.y as u32..high.y as u32 {
                for x in low.x as u32..high.x as u32 {
                    let at = Vec2::new(x as f32, y as f32) + 0.5;
                    let shares =
                        [(b, c), (c, a), (a, b)].map(|(a, b)| (a - at).perp_dot(b - at) / area);
                    if shares.iter().all(|s| *s > 0.0) {
                        let point = (0..3).map(|i| corners[i] * shares[i]).sum();
                        out.entry((x, y))
                            .or_default()
                            .push((p.material.unwrap(), point));
                    }
                }
            }
        }
    }
    out
}

#[test]
fn a_px_belongs_to_one_place() {
    let covered = covered(&painted().character, painted().side);
    let apart =
        |points: &&Vec<(usize, Vec3)>| points.iter().any(|p| p.1.distance(points[0].1) > 0.012);
    for points in covered.values() {
        let eye = |m: usize| m >= 11;
        let one = |m: usize| m == points[0].0 || (eye(m) && eye(points[0].0));
        assert!(points.iter().all(|(m, _)| one(*m)), "{points:?}");
    }
    // Folds lie over each other: of the ears, of the lids behind the skin, between the fingers.
    let folds = covered.values().filter(apart).count() as f64 / covered.len() as f64;
    assert!(folds < 0.02, "{folds}");
    let used = covered.len() as f64 / f64::from(painted().side).powi(2);
    assert!(used > 0.5, "{used}");
}

#[test]
fn colours_are_where_they_belong() {
    let of = painted();
    let mut means: HashMap<&str, (Vec3, f32)> = HashMap::new();
    for p in primitives(&of.character) {
        for t in &p.texcoords {
            let (sum, count) = means.entry(name(&of.character, p)).or_default();
            *sum += color(of, *t);
            *count += 1.0;
        }
    }
    // Painted parts are as dark as the plain materials, apart from stripes, worn cloth and what lies in folds.
    for material in &plain().materials {
        let (sum, count) = means[&material.name[..]];
        let (mean, plain) = (sum / count, material.base_color.truncate());
        let brightness = mean.element_sum() / plain.element_sum();
        assert!(
            (0.5..2.0).contains(&brightness),
            "{}: {mean} for {plain}",
            material.name
        );
    }
    let at = |material: &str, place: [f32; 3]| {
        let of_material = primitives(&of.character).filter(|p| name(&of.character, p) == material);
        let all = of_material.flat_map(|p| p.positions.iter().zip(&p.texcoords));
        let far = |p: &Vec3| p.distance(Vec3::from(place));
        let nearest = all.min_by(|a, b| far(a.0).total_cmp(&far(b.0)));
        color(of, *nearest.unwrap().1)
    };
    let redness = |c: Vec3| c.x / c.y;
    // The cheek is redder than the forehead, the sole lighter than the shoe, and the stripe than the shirt.
    assert!(
        redness(at("skin", [0.042, 1.597, 0.065])) > 1.1 * redness(at("skin", [0.02, 1.68, 0.08]))
    );
    assert!(at("shoes", [0.11, 0.012, 0.16]).x > 1.5 * at("shoes", [0.11, 0.05, -0.09]).x);
    assert!(at("shirt", [0.1, 1.28, 0.09]).x > 1.5 * at("shirt", [0.1, 1.15, 0.08]).x);
    // The back of the shirt has its own chart, with the stripe at the same height.
    assert!(at("shirt", [0.1, 1.28, -0.1]).x > 1.5 * at("shirt", [0.1, 1.15, -0.08]).x);
    // An armpit lies in a fold, the chest does not.
    assert!(at("shirt", [0.15, 1.32, -0.03]).y < 0.8 * at("shirt", [0.08, 1.36, 0.09]).y);
}

#[test]
fn the_picture_of_one_number_of_triangles_fits_others() {
    let coarse = painted_human(2_000).unwrap();
    let mut differences = Vec::new();
    for p in primitives(&coarse.character) {
        for (point, at) in p.positions.iter().zip(&p.texcoords) {
            if point.x >= 0.0 {
                differences.push((color(&coarse, *at) - color(painted(), *at)).length());
            }
        }
    }
    let mean = differences.iter().sum::<f32>() / differences.len() as f32;
    assert!(mean < 0.05, "{mean}");
    assert_eq!(coarse, painted_human(2_000).unwrap());
}

#[test]
fn another_number_of_triangles_is_refused() {
    assert_eq!(painted_human(7), Err(HumanError::Triangles { found: 7 }));
}
