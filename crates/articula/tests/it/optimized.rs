//! Optimised files: fewer bytes, the same character within the error that was allowed, and all else kept.

use crate::real::real_data;
use articula::build::{Played, resampling_error};
use articula::core::Mesh;
use articula::core::source::{Channel, Character, Interpolation, Property, RawClip};
use articula::glam::{Quat, Vec3};
use articula::human::HumanOptions;
use articula::optimize::{
    Compression, ErrorBound, MeasuredOn, OptimizeOptions, Optimized, optimize,
};
use articula::{CharacterFile, Executor, Format, OpenOptions, convert, fs, open};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Arc, OnceLock};

const BOUND: f32 = 1e-3;

/// All triangles are kept; `simplified` has tests of fewer.
fn options() -> OptimizeOptions {
    OptimizeOptions {
        error: ErrorBound::Metres(BOUND),
        simplify: false,
        ..OptimizeOptions::default()
    }
}

/// Our human with one clip, made once.
fn human() -> CharacterFile {
    static HUMAN: OnceLock<Vec<u8>> = OnceLock::new();
    read(HUMAN.get_or_init(|| {
        let small = HumanOptions::mannequin(2000);
        let character = articula::human::human(&small).unwrap();
        let mut opened = CharacterFile::from_character("human", character);
        opened.select_clips(&[0]);
        convert::write(&opened, Format::Glb).unwrap().bytes
    }))
}

fn read(bytes: &[u8]) -> CharacterFile {
    let beside = &mut |uri: &str| Err(format!("{uri} does not lie beside it"));
    open(bytes, "file.glb", &OpenOptions::default(), beside).unwrap()
}

fn made(opened: &CharacterFile, options: &OptimizeOptions) -> Optimized {
    optimize(opened, options, &Executor::default()).unwrap()
}

/// The document of a GLB.
fn document(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

/// All vertices as they are read. The encoder of indices may turn triangles.
fn positions(file: &Optimized) -> Vec<Vec3> {
    let meshes = read(&file.glb).into_character().meshes;
    let primitives = meshes.into_iter().flat_map(|mesh| mesh.primitives);
    primitives.flat_map(|p| p.positions).collect()
}

/// Displacement of the skin by other keys, as the judge of resampling measures it in double precision.
fn keys_metres(source: &CharacterFile, shown: &CharacterFile) -> f64 {
    let character = source.character();
    let mesh = Mesh::new(&character.meshes, character.skeleton.joints.len()).unwrap();
    let pairs = character.clips.iter().zip(&shown.character().clips);
    let errors = pairs.map(|(file, clip)| {
        assert_eq!(file.name, clip.name);
        assert!((file.duration_secs - clip.duration_secs).abs() < 1e-4);
        let played = Played::Keys {
            clip,
            rate_hz: 30.0,
        };
        resampling_error(character, &mesh, file, played).metres
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn a_human_takes_a_third_and_stays_within_the_error() {
    let source = human();
    let optimized = made(&source, &options());
    let report = &optimized.report;
    assert_eq!(report.bytes_in, source.bytes());
    assert_eq!(report.bytes_out, optimized.glb.len());
    assert!(3 * report.bytes_out < report.bytes_in, "{report:?}");
    assert!(report.error_mm <= 1e3 * BOUND && report.error_mm > 0.0);
    let shown = read(&optimized.glb);
    let [wanted, found] = [&source, &shown].map(|file| file.character().skeleton.joints.iter());
    assert_eq!(wanted.len(), found.len());
    for (wanted, found) in wanted.zip(found) {
        assert_eq!((&wanted.name, wanted.parent), (&found.name, found.parent));
        // A fiftieth of the bound, at most.
        let moved = wanted.rest.translation.distance(found.rest.translation);
        assert!(moved <= 0.021 * BOUND, "{}: {moved} m", wanted.name);
        assert_eq!(wanted.rest.rotation, found.rest.rotation);
    }
    // Bounds of boxes below 0.01 mm, and the part that rounded meshes have of the error.
    let metres = keys_metres(&source, &shown);
    assert!(metres <= f64::from(BOUND) + 1e-5, "{metres}");
    let (before, after) = (report.before, report.after);
    assert!(after.keys < before.keys && after.geometry < before.geometry);
}

/// The clip of our human without its meshes.
fn motion_alone() -> CharacterFile {
    let mut character = human().into_character();
    character.meshes.clear();
    for clip in &mut character.clips {
        let is_of_joint = |c: &Channel| c.property != Property::Weights;
        clip.channels.retain(is_of_joint);
    }
    let opened = CharacterFile::from_character("motion", character);
    read(&convert::write(&opened, Format::Glb).unwrap().bytes)
}

#[test]
fn a_clip_alone_is_within_the_error_on_the_skin_that_is_named() {
    let (human, source) = (human(), motion_alone());
    let with_skin = |skin: Character| {
        let options = OptimizeOptions {
            skin: Some(Arc::new(skin)),
            ..options()
        };
        optimize(&source, &options, &Executor::default())
    };
    let whole = with_skin(human.character().clone()).unwrap();
    let shown = read(&whole.glb);
    let metres = keys_metres(&human, &shown);
    assert!(metres > 0.25 * f64::from(BOUND), "{metres}");
    assert!(metres <= f64::from(BOUND) + 1e-5, "{metres}");
    let joints = |missing: usize| {
        let skins = human.character().meshes.iter().flat_map(|m| &m.skin.joints);
        MeasuredOn::Skin {
            joints: skins.collect::<BTreeSet<_>>().len(),
            joints_missing: missing,
        }
    };
    assert_eq!(whole.report.measured_on, joints(0));

    // A joint of the skin that the file lacks stays with the one above it.
    let mut longer = human.character().clone();
    let skinned = *longer.meshes[0].skin.joints.last().unwrap();
    longer.skeleton.joints[skinned].name = "not in the file".to_owned();
    let made = with_skin(longer.clone()).unwrap();
    assert_eq!(made.report.measured_on, joints(1));
    assert!(made.report.error_mm <= 1e3 * BOUND);
    for joint in &mut longer.skeleton.joints {
        joint.name.insert(0, '-');
    }
    let refused = with_skin(longer).unwrap_err();
    assert!(refused.to_string().contains("skin"), "{refused}");
}

#[test]
fn turns_at_the_ends_of_limbs_count_without_a_skin() {
    // The last joint turns, and no joint is below it.
    let turn = |angle: f32| Quat::from_rotation_z(angle);
    let mut source = motion_alone().into_character();
    let parents: BTreeSet<usize> = (source.skeleton.joints.iter())
        .filter_map(|joint| joint.parent)
        .collect();
    let last = (0..source.skeleton.joints.len()).rfind(|j| !parents.contains(j));
    let last = last.unwrap();
    let rest = source.skeleton.joints[last].rest.rotation;
    let angles = [0.0, 0.5, -0.5, 0.0];
    source.clips = vec![RawClip {
        name: "wave".to_owned(),
        duration_secs: 2.0,
        channels: vec![Channel {
            target: last,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0, 0.5, 1.5, 2.0],
            values: (angles.into_iter())
                .flat_map(|angle| (rest * turn(angle)).to_array())
                .collect(),
        }],
    }];
    let source = CharacterFile::from_character("wave", source);
    let optimized = made(&source, &options());
    assert_eq!(optimized.report.measured_on, MeasuredOn::Joints);
    let shown = read(&optimized.glb);
    let channel = &shown.character().clips[0].channels[0];
    assert_eq!((channel.target, channel.times_secs.len()), (last, 4));
    for (found, angle) in channel.values.chunks_exact(4).zip(angles) {
        let found = Quat::from_slice(found).normalize();
        // The points are at least 3 cm from the joint.
        let metres = 0.03 * found.angle_between(rest * turn(angle));
        assert!(metres <= BOUND, "{angle}: {metres} m");
    }
}

#[test]
fn an_optimised_file_stays_as_it_is_and_every_form_shows_the_same() {
    let source = human();
    let once = made(&source, &options());
    let again = made(&read(&once.glb), &options());
    let (before, after) = (once.glb.len() as f64, again.glb.len() as f64);
    // Vertices are put into an order anew.
    assert!((0.95..1.03).contains(&(after / before)), "{before} {after}");
    let kept = again.or_source(&once.glb);
    assert!(kept.report.is_kept && kept.glb == once.glb);
    assert_eq!(kept.report.bytes_out, once.glb.len());
    assert_eq!(kept.report.error_mm, 0.0);
    assert_eq!(kept.report.after, once.report.after);
    let coarse = OptimizeOptions {
        error: ErrorBound::Metres(20.0 * BOUND),
        ..options()
    };
    // What saves more is worth an error.
    let coarse = made(&read(&once.glb), &coarse).or_source(&once.glb);
    assert!(!coarse.report.is_kept && coarse.report.error_mm > 0.0);
    assert!(coarse.glb.len() < once.glb.len());
    // What is no GLB cannot stand for the file.
    assert!(!once.clone().or_source(b"{}").report.is_kept);
    assert_eq!(once.glb, made(&source, &options()).glb);
    for compression in [Compression::Khr, Compression::Quantized, Compression::None] {
        let other = made(
            &source,
            &OptimizeOptions {
                compression,
                ..options()
            },
        );
        assert!(other.report.error_mm <= 1e3 * BOUND);
        assert_eq!(positions(&other).len(), positions(&once).len());
        let is_whole = |p: &Vec3| *p == p.round();
        let has_integers = compression != Compression::None;
        assert_eq!(positions(&other).iter().all(is_whole), has_integers);
        let required = document(&other.glb)["extensionsRequired"].clone();
        let is_compressed = required.to_string().contains("meshopt");
        assert_eq!(is_compressed, compression == Compression::Khr, "{required}");
    }
}

#[test]
fn names_extras_and_extensions_are_kept() {
    let mut source = human();
    let bytes = {
        let gltf = source.gltf().unwrap();
        let mut document = gltf.document.clone();
        document.json["nodes"][1]["extras"] = json!({"mine": [1, 2]});
        document.json["animations"][0]["extras"] = json!("walks");
        document.json["extensions"] = json!({"VRMC_vrm": {"meta": {"name": "a"}}});
        document.json["extensionsUsed"] = json!(["VRMC_vrm"]);
        document.write_glb().unwrap()
    };
    source = read(&bytes);
    let (before, after) = (document(&bytes), document(&made(&source, &options()).glb));
    for part in [
        "nodes",
        "skins",
        "materials",
        "extensions",
        "scenes",
        "asset",
    ] {
        assert_eq!(
            before[part].as_array().map(Vec::len),
            after[part].as_array().map(Vec::len)
        );
    }
    assert_eq!(after["nodes"][1]["extras"], json!({"mine": [1, 2]}));
    assert_eq!(after["animations"][0]["extras"], "walks");
    assert_eq!(after["extensions"], before["extensions"]);
    assert!(
        after["extensionsUsed"]
            .as_array()
            .unwrap()
            .contains(&json!("VRMC_vrm"))
    );
}

#[test]
fn arrays_that_an_unknown_extension_may_name_stay() {
    let source = human();
    let mut document_in = source.gltf().unwrap().document.clone();
    document_in.json["extensions"] = json!({"EXT_new": {"accessor": 3}});
    let source = read(&document_in.write_glb().unwrap());
    let optimized = made(&source, &options());
    assert!(optimized.report.keeps_arrays);
    let (before, after) = (&document_in.json["accessors"], document(&optimized.glb));
    assert_eq!(before, &after["accessors"]);
}

#[test]
fn bounds_that_are_none_are_refused() {
    for error in [ErrorBound::Metres(0.0), ErrorBound::Metres(f32::NAN)] {
        let wrong = OptimizeOptions {
            error,
            ..OptimizeOptions::default()
        };
        let refused = optimize(&human(), &wrong, &Executor::default()).unwrap_err();
        assert!(refused.to_string().contains("positive"), "{refused}");
    }
    let fine = OptimizeOptions {
        error: ErrorBound::Metres(1e-12),
        ..OptimizeOptions::default()
    };
    let refused = optimize(&human(), &fine, &Executor::default()).unwrap_err();
    assert!(refused.to_string().contains("finer"), "{refused}");
}

#[test]
fn files_of_all_kinds_stay_within_the_error() {
    let Some(data) = real_data() else { return };
    let open = |name: &str| fs::open(data.join(Path::new(name))).unwrap();
    for name in [
        "glb/RiggedFigure.glb",
        "glb/AnimatedMorphCube.glb",
        "glb/viverse/walk.glb",
        "glb/webxr_hand_left.glb",
        "vrm/debug_robot.vrm",
    ] {
        let source = open(name);
        let optimized = made(&source, &OptimizeOptions::default());
        let report = &optimized.report;
        assert!(report.bytes_out < report.bytes_in, "{name}: {report:?}");
        assert!(report.error_mm <= report.bound_mm, "{name}: {report:?}");
        let shown = read(&optimized.glb);
        let bound = f64::from(1e-3 * report.bound_mm);
        let metres = keys_metres(&source, &shown);
        assert!(metres <= bound + 1e-5, "{name}: {metres} of {bound}");
        let expressions = |file: &CharacterFile| file.character().expressions.len();
        assert_eq!(expressions(&source), expressions(&shown), "{name}");
        assert_eq!(
            source.gltf().map(|g| g.version.clone()),
            shown.gltf().map(|g| g.version.clone())
        );
    }
}
