//! Digital items of real characters: what an item, whole or cut, shows is within what its manifest
//! states; hostile items are refused.

use crate::real;
use crate::short::shortened;
use articula::item::{
    CarriedFile, FaceMotion, Item, ItemPart, MANIFEST, PackageOptions, PartKind, assemble, package,
};
use articula::{CharacterFile, Data, DataFormat, Executor, Figure, OpenOptions, fs, open_data};
use articula_build::{DistanceOptions, surface_distances};
use articula_core::{Clip, Mesh, PosedMesh, Rig, Viewport, Wrap, sample_morphs};
use articula_flat::Picture;
use articula_formats::Limits;
use articula_mutate::{Edit, Mutations};
use articula_stream::abp2::MotionOptions;
use articula_stream::read_index;
use glam::Vec3;
use serde_json::Value;
use std::sync::OnceLock;

/// Slack on errors of meshes, which are measured on some poses, not on these frames.
const SLACK: f64 = 1.1;
/// Rounding of positions to `f32` in metres.
const ROUNDING: f64 = 1e-5;

fn plain() -> PackageOptions {
    PackageOptions {
        mesh_levels: 3,
        flat: false,
        texture_distances_m: vec![3.0],
        ..PackageOptions::default()
    }
}

fn packaged(opened: &CharacterFile, options: &PackageOptions) -> Item {
    package(opened.clone(), options, &Executor::default()).unwrap()
}

fn part(item: &Item, kind: PartKind) -> &ItemPart {
    item.manifest.parts.iter().find(|p| p.kind == kind).unwrap()
}

/// Opens an item again from its files.
fn reopened(files: &[(String, Vec<u8>)], limits: &Limits) -> articula::Result<Item> {
    let file = |name: &str| files.iter().find(|f| f.0 == name).map(|f| f.1.clone());
    let manifest = file(MANIFEST).unwrap_or_default();
    Item::open(&manifest, limits, &mut |name| {
        file(name).ok_or_else(|| "there is no such file".into())
    })
}

/// Vertices of a mesh in a clip at a time.
fn shown(rig: &Rig, mesh: &Mesh, clip: &Clip, secs: f64) -> Vec<Vec3> {
    let mut posed = PosedMesh::new(rig, mesh);
    let mut weights = mesh.morph_weights.clone();
    sample_morphs(clip, secs, Wrap::Clamp, &mut weights);
    posed
        .pose_at(clip, secs, Wrap::Clamp)
        .skinned(&weights)
        .positions
}

/// Greatest distance of the surface of one figure from that of another, in frames of a clip.
fn distance(a: &Figure, b: &Figure, clip: &str) -> f64 {
    let clip_of = |figure: &Figure| figure.clip(Some(clip)).unwrap().unwrap();
    let (of_a, of_b) = (clip_of(a), clip_of(b));
    let (of_a, of_b) = (&a.asset.clips[of_a], &b.asset.clips[of_b]);
    assert!((of_a.duration_secs() - of_b.duration_secs()).abs() < 1e-3);
    let first = a.asset.mesh.len() as u32;
    let right = &a.asset.mesh.triangles;
    let other = b.asset.mesh.triangles.iter();
    let other: Vec<[u32; 3]> = other.map(|t| t.map(|v| v + first)).collect();
    let frames = of_a.frames();
    let mut most = 0.0_f64;
    for frame in (0..frames).step_by(frames.div_ceil(5).max(1)) {
        let secs = frame as f64 / f64::from(of_a.rate_hz());
        let mut all = shown(&a.asset.rig, &a.asset.mesh, of_a, secs);
        all.extend(shown(&b.asset.rig, &b.asset.mesh, of_b, secs));
        let opts = DistanceOptions::default();
        let found = surface_distances(right, &[&other], &all, &[], &opts).unwrap();
        most = most.max(f64::from(found[0].rest.max_metres));
    }
    most
}

/// The figure of an item.
fn figure(item: &Item) -> Figure {
    Figure::new(assemble(item, &OpenOptions::default()).unwrap()).unwrap()
}

fn least_error(part: &ItemPart) -> f64 {
    let last = part.layers.last().unwrap();
    last.error_m
}

#[test]
fn an_item_assembles_within_its_stated_errors() {
    for (name, clip) in [
        ("glb/pab_arnaud.glb", "walk"),
        ("glb/RobotExpressive.glb", "Robot_Walking"),
        ("glb/Quaternius_single_knight_pack__KnightCharacter.glb", ""),
    ] {
        let Some(path) = real::file(name) else {
            continue;
        };
        let opened = shortened(fs::open(path).unwrap(), 0.7);
        let first = &opened.character().clips[0].name;
        let clip = if clip.is_empty() {
            first.clone()
        } else {
            clip.to_owned()
        };
        // The finest level is compared, and one is coarser.
        let options = PackageOptions {
            mesh_levels: 2,
            clips: vec![clip.clone()],
            ..plain()
        };
        let item = packaged(&opened, &options);
        let original = Figure::new(opened).unwrap();
        let again = reopened(&item.files(), &Limits::default()).unwrap();
        assert_eq!(again, item, "{name}");
        let assembled = figure(&again);
        let (a, b) = (&original.opened, &assembled.opened);
        assert_eq!(b.articulation(), a.articulation(), "{name}");
        let of = |c: &CharacterFile| c.character().skeleton.joints.len();
        assert!(of(b) <= of(a), "{name}");
        assert_eq!(b.character().materials.len(), a.character().materials.len());
        let names = |c: &CharacterFile| -> Vec<Vec<String>> {
            c.character()
                .meshes
                .iter()
                .map(|m| m.morph_names.clone())
                .collect()
        };
        assert_eq!(names(b), names(a), "{name}");
        let mesh = part(&item, PartKind::Mesh);
        let finest = &mesh.levels[0];
        let stated = finest.error_rest_m.max(finest.error_motion_m);
        let motion = least_error(part(&item, PartKind::BodyMotion));
        let found = distance(&original, &assembled, &clip);
        let bound = SLACK * stated + motion + ROUNDING;
        assert!(found <= bound, "{name}: {found} > {bound}");
        // No more than a millimetre is lost on a person.
        assert!(
            found < 1e-3 * item.manifest.figure.size_m.max(1.0),
            "{name}: {found}"
        );
    }
}

/// A finer layer never has a greater error than what it needs.
fn finer_layers_err_no_more(part: &ItemPart) {
    for layer in &part.layers {
        for need in &layer.needs {
            let below = part.layers[*need].error_m;
            assert!(
                layer.error_m <= 1.05 * below + ROUNDING,
                "{}: {} {below}",
                layer.name,
                layer.error_m
            );
        }
    }
}

/// The bytes of some ranges of a stream.
fn gathered(stream: &[u8], ranges: &[[u64; 2]]) -> Vec<u8> {
    let slices = ranges.iter().map(|[start, count]| {
        let start = *start as usize;
        &stream[start..start + *count as usize]
    });
    slices.collect::<Vec<_>>().concat()
}

/// The ranges of a cut have the bytes that those of the whole stream have.
fn check_ranges(
    (whole, bytes, keep): (&ItemPart, &[u8], &[bool]),
    (cut, of_cut): (&ItemPart, &[u8]),
) {
    let kept = whole.layers.iter().zip(keep).filter(|(_, keep)| **keep);
    for ((before, _), after) in kept.zip(&cut.layers) {
        let of_layer = gathered(bytes, &before.ranges);
        assert_eq!(gathered(of_cut, &after.ranges), of_layer, "{}", before.name);
        assert_eq!(of_layer.len() as u64, before.bytes);
    }
}

/// Base and layers have all bytes of a stream, and none twice.
fn shares_all_bytes(part: &ItemPart) {
    let of_layers = part.layers.iter().flat_map(|layer| &layer.ranges);
    let mut ranges: Vec<[u64; 2]> = of_layers.chain(&part.base_ranges).copied().collect();
    ranges.sort_unstable();
    let end = ranges.into_iter().fold(0, |at, [start, count]| {
        assert_eq!(at, start, "{}", part.name);
        start + count
    });
    assert_eq!(end, part.bytes, "{}", part.name);
}

#[test]
fn every_cut_of_an_item_keeps_its_promises() {
    let Some(path) = real::file("glb/pab_arnaud.glb") else {
        return;
    };
    let opened = shortened(fs::open(path).unwrap(), 0.7);
    let of_motion = plain().motion;
    let options = PackageOptions {
        clips: vec!["walk".to_owned()],
        motion: MotionOptions {
            tiers: 2,
            ..of_motion
        },
        ..plain()
    };
    let item = packaged(&opened, &options);
    let original = Figure::new(opened).unwrap();
    let (mesh, motion) = (
        part(&item, PartKind::Mesh),
        part(&item, PartKind::BodyMotion),
    );
    assert!(
        mesh.regions.len() == 3 && mesh.layers.len() > 3,
        "{:?}",
        mesh.regions
    );
    let cases = mesh.layers.len().max(motion.layers.len());
    for case in 0..cases {
        // A layer of each, so that every one is met.
        let of_mesh = case % mesh.layers.len();
        let of_motion = (case * 7) % motion.layers.len();
        let keeps = [mesh.closure(&[of_mesh]), motion.closure(&[of_motion])];
        let kept = item
            .kept(|part, layer| match part.kind {
                PartKind::Mesh => keeps[0][layer],
                PartKind::BodyMotion => keeps[1][layer],
                _ => layer == 0,
            })
            .unwrap();
        // The manifest, the files and their indices agree, and what was written is read again.
        let kept = reopened(&kept.files(), &Limits::default()).unwrap();
        for (before, keep) in [(mesh, &keeps[0]), (motion, &keeps[1])] {
            let after = part(&kept, before.kind);
            assert_eq!(after.bytes, before.bytes_of(keep));
            let file = kept.file(after.file.as_ref().unwrap()).unwrap();
            assert_eq!(file.len() as u64, after.bytes);
            let index = kept.file(after.index.as_ref().unwrap()).unwrap();
            read_index(index).unwrap().check_values(file).unwrap();
            let whole = item.file(before.file.as_ref().unwrap()).unwrap();
            check_ranges((before, whole, keep), (after, file));
        }
        let shown = figure(&kept);
        let stated = [
            SLACK * mesh.layers[of_mesh].error_m,
            motion.layers[of_motion].error_m,
        ];
        let found = distance(&original, &shown, "walk");
        let bound = stated[0] + stated[1] + ROUNDING;
        assert!(
            found <= bound,
            "{}, {}: {found} > {bound}",
            mesh.layers[of_mesh].name,
            motion.layers[of_motion].name
        );
    }
    for part in [mesh, motion] {
        finer_layers_err_no_more(part);
        shares_all_bytes(part);
    }
    assert!(mesh.layers.iter().all(|layer| layer.ranges.len() == 1));
    // An access unit begins with its coarsest tier.
    let base = &motion.layers[0].ranges;
    assert!((1..=2).contains(&base.len()), "{base:?}");
    for level in &mesh.levels {
        let kept = item.kept(|part, l| {
            part.kind != PartKind::Mesh || part.layers[l].keep["level"] >= level.level
        });
        assert_eq!(part(&kept.unwrap(), PartKind::Mesh).bytes, level.bytes);
    }
    let lacking = item.kept(|part, layer| part.kind != PartKind::BodyMotion || layer > 0);
    let why = lacking.unwrap_err();
    assert!(
        why.is_argument() && why.to_string().contains("not kept"),
        "{why}"
    );
}

#[test]
fn faces_move_as_stated_and_files_are_carried() {
    let head = real::file("glb/ict_head_talk_554.glb");
    let (Some(head), Some(talk)) = (head, real::bytes("fap/speech_synthetic.fap")) else {
        return;
    };
    let opened = fs::open(head).unwrap();
    let options = OpenOptions::default();
    let data = open_data(&talk, "talk.fap", DataFormat::Fap, &options)
        .unwrap()
        .data;
    let Data::Fap(clip) = data else {
        panic!("a FAP file holds a FAP clip");
    };
    let options = PackageOptions {
        faces: vec![FaceMotion {
            file: "talk.fap".into(),
            clip,
        }],
        with: vec![CarriedFile {
            name: "talk.MP3".into(),
            bytes: vec![1, 2, 3],
        }],
        clips: opened
            .character()
            .clips
            .iter()
            .take(1)
            .map(|c| c.name.clone())
            .collect(),
        ..plain()
    };
    let item = packaged(&opened, &options);
    assert_eq!(item.file("with/talk.mp3"), Some([1, 2, 3].as_slice()));
    assert_eq!(item.manifest.whole[0].mime, "audio/mpeg");
    let face = part(&item, PartKind::FaceMotion);
    let levels: Vec<u32> = face.layers.iter().map(|l| l.keep["face_loa"]).collect();
    assert!(levels.contains(&0) && levels.contains(&3), "{levels:?}");
    assert!(least_error(face) < face.layers[0].error_m && face.layers[0].error_m < 0.05);
    assert!(face.base_error_m > Some(face.layers[0].error_m));
    let mesh = part(&item, PartKind::Mesh);
    let whole = figure(&item);
    for layer in [0, face.layers.len() / 2, face.layers.len() - 1] {
        let keep = face.closure(&[layer]);
        let kept = item
            .kept(|part, l| part.kind != PartKind::FaceMotion || keep[l])
            .unwrap();
        let found = distance(&whole, &figure(&kept), "talk");
        // Both meshes are the decoded one.
        let bound = face.layers[layer].error_m
            + least_error(face)
            + 2.0 * mesh.levels[0].error_motion_m
            + ROUNDING;
        assert!(
            found <= bound,
            "{}: {found} > {bound}",
            face.layers[layer].name
        );
    }
}

#[test]
fn textures_come_in_sizes_that_decode() {
    for name in ["glb/CesiumMan.glb", "glb/Fox.glb"] {
        if let Some(path) = real::file(name) {
            check_textures(&shortened(fs::open(path).unwrap(), 0.5));
        }
    }
}

fn check_textures(opened: &CharacterFile) {
    let options = PackageOptions {
        mesh_levels: 1,
        clips: vec![opened.character().clips[0].name.clone()],
        texture_distances_m: vec![2.0, 8.0],
        least_texture_px: 256,
        viewport: Viewport {
            width_px: 400.0,
            height_px: 225.0,
            ..Viewport::default()
        },
        ..plain()
    };
    let item = packaged(opened, &options);
    let of = |item: &Item| -> Vec<ItemPart> {
        let parts = item.manifest.parts.iter();
        parts
            .filter(|p| p.kind == PartKind::Texture)
            .cloned()
            .collect()
    };
    let textures = of(&item);
    assert!(!textures.is_empty(), "the character has textures");
    for texture in &textures {
        for pair in texture.layers.windows(2) {
            assert!(pair[0].bytes < pair[1].bytes && pair[0].size_px < pair[1].size_px);
        }
        let mean = &texture.layers[0];
        assert_eq!((mean.bytes, mean.size_px), (0, Some([1, 1])));
        for layer in &texture.layers {
            match &layer.file {
                Some(file) => {
                    let picture = Picture::decode(item.file(file).unwrap()).unwrap();
                    assert_eq!(Some([picture.width(), picture.height()]), layer.size_px);
                }
                None => assert_eq!(layer, mean),
            }
            for view in &layer.views {
                // Both are rounded up to four digits.
                let bound = layer.error_m * view.px_per_metre;
                assert!(view.error_px <= bound * 1.001, "{view:?}");
            }
        }
        let largest = texture.layers.last().unwrap();
        assert_eq!(largest.error_m, 0.0, "the original is no error");
        let image = &opened.character().images[texture.image.unwrap()];
        assert_eq!(
            item.file(largest.file.as_ref().unwrap()),
            Some(image.bytes.as_slice())
        );
        if texture.layers.len() > 2 && !texture.layers[0].views.is_empty() {
            assert!(texture.layers[0].error_m > texture.layers[texture.layers.len() - 2].error_m);
        }
    }
    // The smallest sizes are what the character then has; without any, it has one pixel.
    let small = item
        .kept(|part, layer| part.kind != PartKind::Texture || layer == 0)
        .unwrap();
    let shown = assemble(&small, &OpenOptions::default()).unwrap();
    for texture in of(&small) {
        assert_eq!(texture.layers.len(), 1);
        let image = &shown.character().images[texture.image.unwrap()];
        let picture = Picture::decode(&image.bytes).unwrap();
        assert_eq!(
            Some([picture.width(), picture.height()]),
            texture.layers[0].size_px
        );
    }
    let bare = item.kept(|part, _| part.kind != PartKind::Texture).unwrap();
    let shown = assemble(&bare, &OpenOptions::default()).unwrap();
    let image = &shown.character().images[textures[0].image.unwrap()];
    assert_eq!(Picture::decode(&image.bytes).unwrap().width(), 1);
}

/// An item of a small head, for what does not need a large one.
fn small_item() -> Option<&'static Item> {
    static ITEM: OnceLock<Option<Item>> = OnceLock::new();
    ITEM.get_or_init(make_small_item).as_ref()
}

fn make_small_item() -> Option<Item> {
    let head = real::file("glb/ict_head_talk_554.glb")?;
    let opened = shortened(fs::open(head).unwrap(), 1.0);
    let options = PackageOptions {
        mesh_levels: 2,
        ..plain()
    };
    Some(packaged(&opened, &options))
}

#[test]
fn the_manifest_is_as_its_schema_says_and_the_same_each_time() {
    let (Some(item), Some(again)) = (small_item(), make_small_item()) else {
        return;
    };
    assert_eq!(item.files(), again.files());
    let schema = include_str!("../../../../docs/formats/item.schema.json");
    let schema: Value = serde_json::from_str(schema).unwrap();
    let files = item.files();
    let document: Value = serde_json::from_slice(&files.last().unwrap().1).unwrap();
    check(&schema, &schema, &document, "manifest");
    let listed: Vec<&str> = item.manifest.sizes().iter().map(|f| f.0).collect();
    for (name, _) in &files {
        let is_known = listed.contains(&name.as_str()) || name.ends_with(".auix");
        assert!(is_known || name == MANIFEST, "{name}");
    }
}

/// Checks a value against the subset of JSON Schema that the schema uses.
fn check(schema: &Value, root: &Value, value: &Value, at: &str) {
    if let Some(name) = schema["$ref"].as_str() {
        let name = name.trim_start_matches("#/$defs/");
        return check(&root["$defs"][name], root, value, at);
    }
    let right = match schema["type"].as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("integer") => value.is_u64(),
        Some("number") => value.is_number(),
        other => panic!("{at}: {other:?} is no type that this test knows"),
    };
    assert!(right, "{at}: {value} is no {}", schema["type"]);
    if let Some(only) = schema.get("const") {
        assert_eq!(value, only, "{at}");
    }
    if let Some(names) = schema["enum"].as_array() {
        assert!(names.contains(value), "{at}: {value}");
    }
    if let (Some(least), Some(value)) = (schema["minimum"].as_f64(), value.as_f64()) {
        assert!(value >= least, "{at}: {value} is below {least}");
    }
    if let Some(object) = value.as_object() {
        for name in schema["required"].as_array().unwrap() {
            assert!(
                object.contains_key(name.as_str().unwrap()),
                "{at}: no {name}"
            );
        }
        for (name, inner) in object {
            let other = schema.get("additionalProperties");
            let of = schema["properties"].get(name).or(other);
            let of = of.unwrap_or_else(|| panic!("{at}: {name} is not described"));
            check(of, root, inner, &format!("{at}.{name}"));
        }
    }
    for (i, inner) in value.as_array().into_iter().flatten().enumerate() {
        check(&schema["items"], root, inner, &format!("{at}[{i}]"));
    }
}

/// What a refusal must say, and the change of a manifest that is refused.
type Change<'a> = (&'a str, &'a dyn Fn(&mut Value));

/// Checks that each change of the manifest of an item is refused with its place.
fn check_refused(files: &[(String, Vec<u8>)], cases: &[Change<'_>]) {
    let good: Value = serde_json::from_slice(&files.last().unwrap().1).unwrap();
    for (expected, change) in cases {
        let mut changed = good.clone();
        change(&mut changed);
        let mut files = files.to_vec();
        files.last_mut().unwrap().1 = changed.to_string().into_bytes();
        let why = reopened(&files, &Limits::default())
            .unwrap_err()
            .to_string();
        assert!(!why.contains('\n') && why.len() < 600, "{why}");
        assert!(why.contains(expected), "{expected}: {why}");
    }
}

#[test]
fn wrong_hashes_sizes_and_ranges_are_refused_with_their_place() {
    let Some(item) = small_item() else {
        return;
    };
    let file = |value: &mut Value, name: &str, to: Value| value["files"]["figure.glb"][name] = to;
    let layer =
        |value: &mut Value, name: &str, to: Value| value["parts"][0]["layers"][0][name] = to;
    let cases: [Change<'_>; 6] = [
        ("64 hexadecimal", &|m| file(m, "hash", "ABC".into())),
        ("its hash is not", &|m| {
            file(m, "hash", "0".repeat(64).into())
        }),
        ("elsewhere", &|m| file(m, "bytes", 7.into())),
        ("more than the bytes", &|m| {
            file(m, "compressed_bytes", u64::MAX.into())
        }),
        ("ranges must rise", &|m| {
            layer(m, "ranges", serde_json::json!([[9, 1], [8, 1]]))
        }),
        ("within the stream", &|m| {
            layer(m, "ranges", serde_json::json!([[u64::MAX, 2]]))
        }),
    ];
    check_refused(&item.files(), &cases);
}

#[test]
fn hostile_manifests_are_refused_with_their_place() {
    let Some(item) = small_item() else {
        return;
    };
    let files = item.files();
    let layer =
        |value: &mut Value, name: &str, to: Value| value["parts"][0]["layers"][0][name] = to;
    let cases: [Change<'_>; 16] = [
        ("absolute", &|m| m["figure"]["file"] = "/etc/passwd".into()),
        ("leaves the folder", &|m| {
            m["figure"]["file"] = "../figure.glb".into()
        }),
        ("URL", &|m| {
            m["parts"][0]["file"] = "https://example.org/mesh.ams".into()
        }),
        ("two entries", &|m| {
            m["parts"][0]["index"] = "Figure.GLB".into()
        }),
        ("no such file", &|m| {
            m["parts"][0]["file"] = "other.ams".into();
            let files = m["files"].as_object_mut().unwrap();
            let entry = files.remove("mesh.ams").unwrap();
            files.insert("other.ams".into(), entry);
        }),
        ("bytes", &|m| m["figure"]["bytes"] = 7.into()),
        ("the limit is", &|m| m["figure"]["bytes"] = u64::MAX.into()),
        ("base and layers", &|m| m["parts"][0]["bytes"] = 7.into()),
        ("expected \"articula-item\"", &|m| {
            m["format"] = "other".into()
        }),
        ("update it", &|m| m["version"] = 3.into()),
        ("before this one", &|m| {
            layer(m, "needs", serde_json::json!([0]))
        }),
        ("before this one", &|m| {
            layer(m, "needs", serde_json::json!([999]))
        }),
        ("error_m", &|m| layer(m, "error_m", (-1).into())),
        ("layers of textures", &|m| {
            layer(m, "file", "mesh.png".into())
        }),
        ("unknown variant", &|m| {
            m["parts"][0]["kind"] = "cloth".into()
        }),
        ("missing field", &|m| *m = serde_json::json!({})),
    ];
    check_refused(&files, &cases);
    let deep = "[".repeat(100_000);
    let nothing = &mut |_: &str| Err("nothing".to_owned());
    for bytes in [deep.as_bytes(), b"", b"{", b"\xff\xfe"] {
        assert!(Item::open(bytes, &Limits::default(), nothing).is_err());
    }
    let tight = Limits {
        bytes: 10_000,
        ..Limits::default()
    };
    assert!(reopened(&files, &tight).is_err());
}

#[test]
fn mutated_items_end_with_a_character_or_an_error() {
    let Some(item) = small_item() else {
        return;
    };
    let files = item.files();
    let mutations = Mutations {
        edits: &[
            Edit::FlipBit,
            Edit::Delete(8),
            Edit::Word(&["0", "-1", "1e99", "null", "[]"]),
        ],
        most: 3,
    };
    for (changed, name) in files.iter().enumerate().map(|(i, f)| (i, f.0.clone())) {
        let count = if name == MANIFEST { 120 } else { 25 };
        mutations.read_of(&files[changed].1, count, |bytes| {
            let mut files = files.clone();
            // Sizes follow and there are no hashes, so that the bytes themselves are read.
            if name != MANIFEST {
                let text = &files.last().unwrap().1;
                let mut manifest: Value = serde_json::from_slice(text).unwrap();
                manifest["version"] = 1.into();
                manifest.as_object_mut().unwrap().remove("files");
                let text = manifest.to_string();
                let old = format!("\"bytes\":{}", files[changed].1.len());
                let new = format!("\"bytes\":{}", bytes.len());
                files.last_mut().unwrap().1 = text.replace(&old, &new).into_bytes();
            }
            files[changed].1 = bytes.to_vec();
            let Ok(item) = reopened(&files, &Limits::default()) else {
                return false;
            };
            let _ = item.kept(|part, layer| part.kind == PartKind::Texture || layer == 0);
            assemble(&item, &OpenOptions::default()).is_ok()
        });
    }
}
