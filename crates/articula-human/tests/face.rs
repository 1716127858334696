//! Properties of the human with a face: clothes, hair, lids and lips at every triangle count.
#![allow(
    clippy::unwrap_used,
    reason = "a failed step of a test is a failed test"
)]

use articula_core::source::{Character, Primitive, RawMesh};
use articula_human::{HumanOptions, human};
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
