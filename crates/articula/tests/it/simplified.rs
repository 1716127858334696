//! Fewer triangles in optimised files: the surface within the error, no cracks, and what is locked left alone.

use articula::core::Transform;
use articula::core::source::{
    Channel, Character, Interpolation, Joint, MorphTarget, Primitive, Property, RawClip, RawMesh,
    Skeleton, Skin,
};
use articula::glam::{Affine3A, Quat, Vec2, Vec3};
use articula::human::HumanOptions;
use articula::optimize::{
    ErrorBound, OptimizeLimits, OptimizeOptions, OptimizeReport, Optimized, optimize,
    optimize_to_fit,
};
use articula::{CharacterFile, Executor, Format, OpenOptions, convert, open};
use articula_mutate::{Edit, Mutations};
use std::collections::{BTreeMap, BTreeSet};

const BOUND: f32 = 2e-3;

fn options() -> OptimizeOptions {
    OptimizeOptions {
        error: ErrorBound::Metres(BOUND),
        ..OptimizeOptions::default()
    }
}

fn made(character: Character, options: &OptimizeOptions) -> Optimized {
    let opened = CharacterFile::from_character("made", character);
    let made = optimize(&opened, options, &Executor::default()).unwrap();
    let report = &made.report;
    assert!(report.error_mm <= report.bound_mm, "{report:?}");
    let greater = report.vertex_error_mm.max(report.surface_error_mm);
    assert_eq!(report.error_mm, greater);
    let triangles: usize = primitives(&made).iter().map(|p| p.triangles.len()).sum();
    assert_eq!(report.triangles_out, triangles);
    made
}

fn primitives(made: &Optimized) -> Vec<Primitive> {
    let beside = &mut |uri: &str| Err(uri.to_owned());
    let shown = open(&made.glb, "out.glb", &OpenOptions::default(), beside).unwrap();
    let meshes = shown.into_character().meshes.into_iter();
    meshes.flat_map(|mesh| mesh.primitives).collect()
}

/// A square of 1 m in the ground with 2 N² triangles, one mesh of one joint, and one triangle twice and
/// one without area.
fn sheet(n: u32) -> Character {
    let at = |x: u32, z: u32| x + (n + 1) * z;
    let places = (0..=n).flat_map(|z| (0..=n).map(move |x| (x, z)));
    let positions: Vec<Vec3> = places
        .map(|(x, z)| Vec3::new(x as f32, 0.0, z as f32) / n as f32)
        .collect();
    let quads = (0..n).flat_map(|z| (0..n).map(move |x| (x, z)));
    let mut triangles: Vec<[u32; 3]> = quads
        .flat_map(|(x, z)| {
            let [a, b, c, d] = [at(x, z), at(x + 1, z), at(x + 1, z + 1), at(x, z + 1)];
            [[a, c, b], [a, d, c]]
        })
        .collect();
    triangles.push(triangles[0]);
    triangles.push([0, 1, 1]);
    let count = positions.len();
    Character {
        skeleton: Skeleton {
            joints: vec![Joint {
                name: "root".into(),
                parent: None,
                rest: Transform::IDENTITY,
                in_skin: true,
            }],
        },
        meshes: vec![RawMesh {
            name: "sheet".into(),
            skin: Skin {
                joints: vec![0],
                inverse_bind: vec![Affine3A::IDENTITY],
            },
            primitives: vec![Primitive {
                normals: vec![Vec3::Y; count],
                influences: 1,
                joints: vec![0; count],
                weights: vec![1.0; count],
                triangles,
                positions,
                ..Primitive::default()
            }],
            ..RawMesh::default()
        }],
        ..Character::default()
    }
}

/// The sheet with a morph target that raises one vertex inside by a length.
fn raised(n: u32, metres: f32) -> Character {
    let mut character = sheet(n);
    let mesh = &mut character.meshes[0];
    let mut positions = vec![Vec3::ZERO; mesh.primitives[0].positions.len()];
    positions[(n / 2 + (n + 1) * (n / 2)) as usize] = Vec3::Y * metres;
    mesh.morph_names = vec!["up".into()];
    mesh.morph_weights = vec![0.0];
    mesh.primitives[0].morphs = vec![MorphTarget {
        positions,
        normals: Vec::new(),
    }];
    character
}

/// Edges that only one triangle has, by the places of their ends.
fn borders(primitives: &[Primitive]) -> Vec<[[u32; 3]; 2]> {
    let mut edges: BTreeMap<[[u32; 3]; 2], usize> = BTreeMap::new();
    for primitive in primitives {
        for [a, b, c] in &primitive.triangles {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let mut ends = [p, q].map(|v| {
                    primitive.positions[*v as usize]
                        .to_array()
                        .map(f32::to_bits)
                });
                ends.sort_unstable();
                *edges.entry(ends).or_default() += 1;
            }
        }
    }
    let once = edges.into_iter().filter(|(_, count)| *count == 1);
    once.map(|(ends, _)| ends).collect()
}

fn triangles(report: &OptimizeReport) -> [usize; 2] {
    [report.triangles_in, report.triangles_out]
}

#[test]
fn a_flat_sheet_needs_two_triangles_and_keeps_its_border() {
    let flat = made(sheet(8), &options());
    assert_eq!(triangles(&flat.report), [130, 2]);
    let corners: BTreeSet<[i32; 2]> = primitives(&flat)[0]
        .positions
        .iter()
        .map(|p| [p.x, p.z].map(|x| (x * 100.0).round() as i32))
        .collect();
    assert_eq!(corners, [[0, 0], [0, 100], [100, 0], [100, 100]].into());
    let whole = OptimizeOptions {
        simplify: false,
        ..options()
    };
    let whole = made(sheet(8), &whole).report;
    assert_eq!(whole.triangles_out, 130);
    assert_eq!(whole.surface_error_mm, 0.0);
}

#[test]
fn a_vertex_that_a_morph_target_raises_stays_and_one_that_it_hardly_raises_goes() {
    let high = made(raised(8, 0.1), &options());
    let offsets = primitives(&high)[0].morphs[0].positions.clone();
    let raises = offsets.iter().filter(|o| o.y > 0.09).count();
    assert_eq!(raises, 1, "{offsets:?}");
    assert!(high.report.triangles_out > 3);
    let low = made(raised(8, 2e-4), &options());
    assert_eq!(low.report.triangles_out, 2);
    assert!(low.report.surface_error_mm > 0.19, "{:?}", low.report);
}

#[test]
fn what_is_locked_keeps_its_triangles() {
    // The mesh and its joint.
    let locked = OptimizeOptions {
        locked: vec!["root".into()],
        ..options()
    };
    let report = made(sheet(8), &locked).report;
    // The second and the one without area show nothing.
    assert!(report.triangles_out >= 128, "{report:?}");
    let locked = OptimizeOptions {
        locked: vec!["up".into()],
        ..options()
    };
    let file = made(raised(8, 2e-4), &locked);
    assert!(file.report.triangles_out > 3, "{:?}", file.report);
    let unknown = OptimizeOptions {
        locked: vec!["tail".into()],
        ..options()
    };
    let opened = CharacterFile::from_character("made", sheet(2));
    let refused = optimize(&opened, &unknown, &Executor::default()).unwrap_err();
    let line = refused.to_string();
    assert!(
        line.contains("\"tail\"") && line.contains("meshes: root"),
        "{line}"
    );
}

#[test]
fn seams_of_texture_coordinates_do_not_open() {
    // Two charts that meet in the middle, bent there so that nothing is flat.
    let mut character = sheet(8);
    let primitive = &mut character.meshes[0].primitives[0];
    for p in &mut primitive.positions {
        p.y = 0.2 * (3.0 * p.x).sin() * (2.0 * p.z).cos();
    }
    let count = primitive.positions.len();
    let right = |p: &Vec3| if p.x > 0.5 { 0.5 } else { 0.0 };
    let uv = |p: &Vec3| Vec2::new(0.4 * p.x + right(p), p.z);
    primitive.texcoords = primitive.positions.iter().map(uv).collect();
    // The right half has vertices of its own along the middle.
    let middle: Vec<u32> = (0..count as u32).filter(|v| v % 9 == 4).collect();
    for v in &middle {
        let v = *v as usize;
        primitive.positions.push(primitive.positions[v]);
        primitive.normals.push(primitive.normals[v]);
        primitive
            .texcoords
            .push(primitive.texcoords[v] + Vec2::X * 0.5);
        primitive.joints.push(0);
        primitive.weights.push(1.0);
    }
    let own = |v: u32| count as u32 + v / 9;
    for triangle in &mut primitive.triangles {
        if triangle.iter().any(|v| v % 9 > 4) {
            *triangle = triangle.map(|v| if v % 9 == 4 { own(v) } else { v });
        }
    }
    let keep = OptimizeOptions {
        error: ErrorBound::Metres(0.03),
        keep_attributes: true,
        ..OptimizeOptions::default()
    };
    let before = borders(&character.meshes[0].primitives);
    let around: BTreeSet<bool> = before.iter().flatten().map(on_border).collect();
    assert_eq!(around, [true].into());
    let file = made(character, &keep);
    assert!(file.report.triangles_out < 100, "{:?}", file.report);
    let after = primitives(&file);
    for end in borders(&after).iter().flatten() {
        assert!(on_border(end), "{:?}", end.map(f32::from_bits));
    }
    // Both charts are left, and no triangle spans them.
    for t in &after[0].triangles {
        let u = t.map(|v| after[0].texcoords[v as usize].x);
        assert!(
            u.iter().all(|u| *u < 0.45) || u.iter().all(|u| *u > 0.45),
            "{u:?}"
        );
    }
}

/// Whether a place is at the rim of the sheet.
fn on_border(place: &[u32; 3]) -> bool {
    let [x, _, z] = place.map(f32::from_bits);
    [x, z].iter().any(|x| *x < 0.01 || *x > 0.99)
}

#[test]
fn a_human_loses_triangles_and_hardly_more_the_second_time() {
    let human = || {
        let mut human = articula::human::human(&HumanOptions::mannequin(2000)).unwrap();
        human.clips.truncate(1);
        human
    };
    let coarse = OptimizeOptions {
        error: ErrorBound::Metres(8e-3),
        // Keys have tests of their own, which take long.
        reduce_keys: false,
        ..OptimizeOptions::default()
    };
    let once = made(human(), &coarse);
    let [before, after] = triangles(&once.report);
    assert!(after < before * 19 / 20, "{:?}", once.report);
    assert!(once.report.surface_error_mm > 1.0);
    let beside = &mut |uri: &str| Err(uri.to_owned());
    let opened = open(&once.glb, "once.glb", &OpenOptions::default(), beside).unwrap();
    let again = optimize(&opened, &coarse, &Executor::default()).unwrap();
    let ratio = again.glb.len() as f64 / once.glb.len() as f64;
    assert!((0.7..1.02).contains(&ratio), "{ratio}");
    // The face counts more, so it keeps more.
    let weighed = OptimizeOptions {
        region_weights: vec![("face".into(), 100.0)],
        ..coarse
    };
    assert!(made(human(), &weighed).report.triangles_out > after);
}

#[test]
fn a_file_fits_into_limits_at_the_least_error_or_it_is_told_what_is_left() {
    // A hill, of which fewer triangles show less.
    let hill = || {
        let mut character = sheet(8);
        for p in &mut character.meshes[0].primitives[0].positions {
            p.y = 0.1 * (2.5 * p.x).sin() * (2.0 * p.z).cos();
        }
        CharacterFile::from_character("hill", character)
    };
    let fit = |limits: OptimizeLimits| {
        optimize_to_fit(&hill(), &options(), &limits, &Executor::default())
    };
    let few = OptimizeLimits {
        max_triangles: Some(40),
        ..OptimizeLimits::default()
    };
    let (made, found) = fit(few).unwrap();
    assert!(made.report.triangles_out <= 40, "{:?}", made.report);
    assert!(made.report.error_mm <= found.bound_mm && found.bound_mm > found.asked_mm);
    // At the greatest error that is known to be too small it does not fit.
    let low = ErrorBound::Metres(1e-3 * found.too_large_at_mm.unwrap());
    let opened = hill();
    let lower = OptimizeOptions {
        error: low,
        ..options()
    };
    let lower = optimize(&opened, &lower, &Executor::default()).unwrap();
    assert!(lower.report.triangles_out > 40, "{:?}", lower.report);
    let small = OptimizeLimits {
        max_bytes: Some(lower.glb.len() - 1),
        ..OptimizeLimits::default()
    };
    let (made, _) = fit(small).unwrap();
    assert!(made.glb.len() < lower.glb.len());
    let wide = OptimizeLimits {
        max_bytes: Some(1 << 20),
        max_triangles: Some(1 << 20),
        max_joints: Some(1),
        ..OptimizeLimits::default()
    };
    let (_, found) = fit(wide).unwrap();
    assert_eq!(
        (found.bound_mm, found.too_large_at_mm),
        (found.asked_mm, None)
    );
    let line = |limits| fit(limits).unwrap_err().to_string();
    let none = OptimizeLimits {
        max_bytes: Some(10),
        ..OptimizeLimits::default()
    };
    let line_of = line(none);
    assert!(
        line_of.contains("bytes: 10 allowed") && line_of.contains("fewest"),
        "{line_of}"
    );
    let none = OptimizeLimits {
        max_joints: Some(0),
        ..OptimizeLimits::default()
    };
    assert!(line(none).contains("the skins have 1, allowed are 0"));
}

#[test]
fn a_file_that_was_changed_is_refused_or_made_lighter_within_the_error() {
    let mut character = raised(4, 0.2);
    let channel = |property, values: Vec<f32>| Channel {
        target: 0,
        property,
        interpolation: Interpolation::Linear,
        times_secs: vec![0.0, 0.5, 1.0],
        values,
    };
    let turns = [0.0, 0.4, 0.0].map(|a| Quat::from_rotation_y(a).to_array());
    character.clips = vec![RawClip {
        name: "clip".into(),
        duration_secs: 1.0,
        channels: vec![
            channel(Property::Rotation, turns.concat()),
            channel(Property::Weights, vec![0.0, 1.0, 0.0]),
        ],
    }];
    let opened = CharacterFile::from_character("made", character);
    let source = convert::write(&opened, Format::Glb).unwrap().bytes;
    let mutations = Mutations {
        edits: &[
            Edit::FlipBit,
            Edit::Delete(4),
            Edit::Word(&["0", "-1", "1e99", "null", "[]", "STEP"]),
        ],
        most: 2,
    };
    let beside = &mut |uri: &str| Err(uri.to_owned());
    let good = mutations.read_of(&source, 300, |bytes| {
        let Ok(opened) = open(bytes, "made.glb", &OpenOptions::default(), beside) else {
            return false;
        };
        let Ok(made) = optimize(&opened, &options(), &Executor::default()) else {
            return false;
        };
        assert!(made.report.error_mm <= made.report.bound_mm);
        open(&made.glb, "out.glb", &OpenOptions::default(), beside).is_ok()
    });
    assert!(good > 10 && good < 300, "{good}");
}
