//! Prepared assets: what is stored gives what a fresh preparation gives, and is checked.

mod chosen;

use crate::crowd;
use crate::real::file;
use crate::short::shortened;
use articula::convert::write;
use articula::crowd::{
    CacheUse, Camera, CrowdAsset, CrowdOptions, CrowdPlayer, JointLodMethod, PaletteHash, Viewport,
};
use articula::{
    CharacterFile, Executor, Figure, Format, MeshLevelOptions, MotionTables, OpenOptions,
    PartState, PrepareOptions, PreparedMeshLevels, PreparedPart, check_prepared, open, prepare,
};
use articula_formats::gltf::Document;
use glam::Vec3;
use serde_json::{Value, json};

/// Opens a file in memory.
fn opened(glb: &[u8]) -> CharacterFile {
    open(glb, "a.glb", &OpenOptions::default(), &mut |_| {
        Err("nothing beside".into())
    })
    .unwrap()
}

/// A file with the beginnings of the first two clips of a character.
fn brief(mut file: CharacterFile) -> CharacterFile {
    file.select_clips(&[0, 1]);
    opened(&write(&shortened(file, 0.5), Format::Glb).unwrap().bytes)
}

/// The reference human, which every test prepares anew: in few frames.
fn human() -> CharacterFile {
    brief(crowd::human())
}

fn built(source: CharacterFile, options: &PrepareOptions) -> Vec<u8> {
    prepare(source, options, &Executor::default()).unwrap().glb
}

fn levelled() -> PrepareOptions {
    PrepareOptions {
        mesh_levels: PreparedMeshLevels::New(MeshLevelOptions::levels(5)),
        ..PrepareOptions::default()
    }
}

/// The asset of the reference human, with mesh levels.
fn asset() -> &'static [u8] {
    static ASSET: std::sync::OnceLock<Vec<u8>> = std::sync::OnceLock::new();
    ASSET.get_or_init(|| built(human(), &levelled()))
}

/// The usual options with the original mesh, which a file without mesh levels has too.
fn original_mesh() -> CrowdOptions {
    CrowdOptions {
        mesh_levels: Some(1),
        ..CrowdOptions::default()
    }
}

/// Crowds by the options that use stored data, and those that do not.
fn options() -> Vec<CrowdOptions> {
    let usual = original_mesh;
    vec![
        usual(),
        CrowdOptions {
            mesh_levels: Some(5),
            pose_cache: true,
            ..usual()
        },
        CrowdOptions {
            joints: JointLodMethod::Whole,
            pose_cache: true,
            ..usual()
        },
        // Fewer mesh levels than the asset has.
        CrowdOptions {
            mesh_levels: Some(2),
            pose_cache: true,
            ..usual()
        },
        CrowdOptions { seed: 2, ..usual() },
    ]
}

/// A hash of the palettes of a few frames, with warnings.
fn played(asset: &CrowdAsset) -> (String, Vec<String>) {
    let mut crowd = CrowdPlayer::new(asset, 12).unwrap();
    if asset.model().parts().cache.is_some() {
        crowd.cache = CacheUse::Cpu;
    }
    for i in 0..12 {
        crowd.place(i, Vec3::new(i as f32, 0.0, -4.0 * i as f32), 0.4 * i as f32);
        crowd.play(i, i % asset.clips().len(), 0.17 * i as f32);
    }
    let eye = Vec3::new(3.0, 1.6, 9.0);
    let camera = Camera::looking_at(eye, Vec3::Y, Viewport::default());
    let mut hash = PaletteHash::default();
    for _ in 0..6 {
        crowd.frame(0.05, &camera);
        hash.add(&crowd);
    }
    (hash.text(), asset.warnings().to_vec())
}

fn crowd_of(figure: &Figure, options: &CrowdOptions) -> CrowdAsset {
    CrowdAsset::new(figure, options, &Executor::default()).unwrap()
}

/// Checks that two figures have the same rig, mesh and clips; a failure does not print them.
fn same_asset(a: &Figure, b: &Figure) {
    let (name, a, b) = (b.opened.name(), &a.asset, &b.asset);
    assert!(a.rig == b.rig, "{name}: rig");
    assert!(a.mesh.positions == b.mesh.positions, "{name}: positions");
    assert!(a.mesh.normals == b.mesh.normals, "{name}: normals");
    assert!(a.mesh.triangles == b.mesh.triangles, "{name}: triangles");
    assert!(a.mesh == b.mesh, "{name}: mesh");
    assert!(a.clips == b.clips, "{name}: clips");
}

/// Checks that two files give the same figure and the same crowds.
fn same(fresh: CharacterFile, stored: CharacterFile, options: &[CrowdOptions]) {
    let name = fresh.name().to_owned();
    let (fresh, stored) = (Figure::new(fresh).unwrap(), Figure::new(stored).unwrap());
    assert_eq!(stored.opened.warnings(), fresh.opened.warnings(), "{name}");
    same_asset(&stored, &fresh);
    for options in options {
        let [a, b] = [&fresh, &stored].map(|figure| crowd_of(figure, options));
        assert_eq!(played(&a), played(&b), "{name} {options:?}");
        let (a, b) = (&a, &b);
        assert_eq!(a.levels(), b.levels());
        assert!(a.model().parts().errors == b.model().parts().errors);
        assert!(a.model().parts().bounds == b.model().parts().bounds);
        for level in 0..a.levels() {
            assert!(a.mesh(level) == b.mesh(level), "{name}: level {level}");
        }
    }
}

#[test]
fn what_is_stored_is_what_a_fresh_preparation_gives() {
    let options = options();
    same(human(), opened(asset()), &options);
    // What other figures store differs by their meshes and rigs, in the way of the first options.
    for name in [
        "glb/Quaternius_single_knight_pack__KnightCharacter.glb",
        "glb/Fox.glb",
    ] {
        let Some(path) = file(name) else { continue };
        let source = || brief(articula::fs::open(&path).unwrap());
        let stored = opened(&built(source(), &levelled()));
        same(source(), stored, &options[..2]);
    }
}

#[test]
fn hidden_meshes_are_left_out_of_both() {
    let hide = |mut file: CharacterFile| {
        let first = file.character().meshes[0].name.clone();
        file.keep_meshes(&[], &[first]).unwrap();
        Figure::new(file).unwrap()
    };
    let (fresh, stored) = (hide(human()), hide(opened(asset())));
    assert_eq!(stored.asset, fresh.asset);
    assert_eq!(
        stored.opened.warnings(),
        fresh.opened.warnings(),
        "nothing is stale"
    );
    let hash = |figure| played(&crowd_of(figure, &original_mesh()));
    assert_eq!(hash(&stored), hash(&fresh));
    // Levels of what is left, as far as they have a triangle.
    let levels = crowd_of(&stored, &CrowdOptions::default());
    assert!(levels.has_mesh_lods() && levels.warnings().is_empty());
    let triangles = (0..levels.levels()).map(|level| levels.level(level).triangles);
    assert!(triangles.min() > Some(0));
}

#[test]
fn preparing_an_asset_again_gives_the_same_parts() {
    let parts = |glb: &[u8]| -> Vec<(String, Vec<u8>)> {
        let file = opened(glb).detach_document().unwrap();
        let parts = file.document.prepared_parts();
        parts
            .map(|p| (p.name.to_owned(), p.bytes.to_vec()))
            .collect()
    };
    let again = built(opened(asset()), &levelled());
    assert!(
        parts(&again) == parts(asset()),
        "made from the source again"
    );
    // Without a request for levels those of the file stay.
    let kept = built(opened(asset()), &PrepareOptions::default());
    assert!(parts(&kept) == parts(asset()), "levels are kept");
    let check = check_prepared(opened(&kept)).unwrap();
    assert!(check.is_whole(), "{check:?}");
}

#[test]
fn an_asset_with_another_clip_keeps_the_order_of_its_source() {
    let with_clip = |mut file: CharacterFile| {
        let mut clip = file.character().clips[0].clone();
        clip.name = "again".into();
        file.clips_mut().push(clip);
        built(file, &levelled())
    };
    let (fresh, stored) = (with_clip(human()), with_clip(opened(asset())));
    let [fresh, stored] = [&fresh, &stored].map(|glb| Figure::new(opened(glb)).unwrap());
    same_asset(&stored, &fresh);
    let usual = CrowdOptions::default();
    assert_eq!(
        played(&crowd_of(&stored, &usual)),
        played(&crowd_of(&fresh, &usual))
    );
}

#[test]
fn a_character_that_is_not_its_document_is_refused() {
    let mut file = human();
    file.keep_meshes(&[], &["lips".into()]).unwrap();
    let mut edited = file.clone();
    edited.skip_first_frames().unwrap();
    for file in [file, edited] {
        let why = prepare(file, &PrepareOptions::default(), &Executor::default()).unwrap_err();
        assert!(
            why.to_string().contains("differs from its document"),
            "{why}"
        );
    }
}

#[test]
fn other_mesh_levels_than_the_stored_are_told() {
    let mut document = opened(asset()).detach_document().unwrap().document;
    for mesh in document.json["meshes"].as_array_mut().unwrap() {
        for primitive in mesh["primitives"].as_array_mut().unwrap() {
            let levels = &mut primitive["extensions"]["ARTICULA_clustered_mesh"];
            for cluster in levels["clusters"].as_array_mut().unwrap() {
                // The triangles of level 1 that level 2 has too are left out of level 2.
                let [first, last] = ["first", "last"].map(|at| cluster[at].as_u64().unwrap());
                if first == 1 && last == 2 {
                    cluster["last"] = json!(1);
                }
            }
        }
    }
    let figure = Figure::new(opened(&document.write_glb().unwrap())).unwrap();
    let options = CrowdOptions {
        mesh_levels: Some(5),
        ..CrowdOptions::default()
    };
    let told = crowd_of(&figure, &options).warnings().to_vec();
    assert!(
        told.iter().any(|w| w.contains("mesh levels of this file")),
        "{told:?}"
    );
}

/// The asset with one bit of a buffer view changed.
fn damaged(glb: &[u8], view: usize) -> Vec<u8> {
    let mut document = opened(glb).detach_document().unwrap().document;
    let view = &document.json["bufferViews"][view];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    let length = view["byteLength"].as_u64().unwrap() as usize;
    document.buffers[0][start + length / 2] ^= 1;
    document.write_glb().unwrap()
}

#[test]
fn one_changed_bit_of_any_part_is_told_and_the_part_made_again() {
    let document = opened(asset()).detach_document().unwrap().document;
    let parts = document.json["extensions"]["ARTICULA_prepared"]["parts"].clone();
    let fresh = Figure::new(human()).unwrap();
    let all = CrowdOptions {
        mesh_levels: Some(5),
        pose_cache: true,
        ..CrowdOptions::default()
    };
    let usual = original_mesh();
    let hashes = [&all, &usual].map(|options| played(&crowd_of(&fresh, options)).0);
    for (name, part) in parts.as_object().unwrap() {
        let view = part["bufferView"].as_u64().unwrap() as usize;
        let figure = Figure::new(opened(&damaged(asset(), view))).unwrap();
        let crowds = [&all, &usual].map(|options| crowd_of(&figure, options));
        let told = figure.opened.warnings().iter().map(|w| w.what.clone());
        let told: Vec<String> = told
            .chain(crowds.iter().flat_map(|c| c.warnings().to_vec()))
            .collect();
        assert!(
            told.iter().any(|w| w.contains(name.as_str())),
            "{name}: {told:?}"
        );
        if name == "vertexOrder" {
            // The source is lost with it; the character is prepared as it stands.
            assert_eq!(figure.asset.mesh.len(), fresh.asset.mesh.len());
            continue;
        }
        same_asset(&figure, &fresh);
        let again = crowds.map(|crowd| played(&crowd).0);
        assert_eq!(again, hashes, "{name}");
    }
    // Tables of animations are checked too.
    let tables = &document.json["animations"][0]["extensions"]["ARTICULA_articulation"]["tables"];
    for (name, view) in tables.as_object().unwrap() {
        // The first bytes are magic, version and hashes.
        let mut document = document.clone();
        let at = &document.json["bufferViews"][view.as_u64().unwrap() as usize];
        let start = at["byteOffset"].as_u64().unwrap() as usize;
        document.buffers[0][start + 20] ^= 1;
        let figure = Figure::new(opened(&document.write_glb().unwrap())).unwrap();
        let told = MotionTables::stored(&figure, 0).warnings;
        assert_eq!(told.len(), 1, "{name}: {told:?}");
        assert!(told[0].contains(name.as_str()), "{told:?}");
    }
}

#[test]
fn data_of_other_clips_or_meshes_is_told_and_not_used() {
    let mut document = opened(asset()).detach_document().unwrap().document;
    let input = document.json["animations"][1]["samplers"][0]["output"]
        .as_u64()
        .unwrap();
    let view = document.json["accessors"][input as usize]["bufferView"]
        .as_u64()
        .unwrap();
    let glb = damaged(asset(), view as usize);
    let figure = Figure::new(opened(&glb)).unwrap();
    let told: Vec<&str> = figure
        .opened
        .warnings()
        .iter()
        .map(|w| w.what.as_str())
        .collect();
    assert!(
        told.iter().any(|w| w.contains("the clips of this file")),
        "{told:?}"
    );
    let check = check_prepared(opened(&glb)).unwrap();
    assert!(!check.is_whole());
    let stale = check.parts.iter().filter(|p| p.state == PartState::Stale);
    assert!(stale.count() >= 6, "{check:?}");

    // A name that nothing is computed from may change.
    document.json["materials"][0]["name"] = json!("another");
    let renamed = document.write_glb().unwrap();
    assert!(check_prepared(opened(&renamed)).unwrap().is_whole());

    document.json["extensions"]["ARTICULA_prepared"]["version"] = json!(2);
    let newer = document.write_glb().unwrap();
    let figure = Figure::new(opened(&newer)).unwrap();
    assert!(figure.opened.warnings()[0].what.contains("version 2"));
    crowd_of(&figure, &CrowdOptions::default());
}

#[test]
fn what_is_left_out_is_missing_and_computed() {
    let fresh = Figure::new(human()).unwrap();
    let usual = original_mesh();
    let expected = played(&crowd_of(&fresh, &usual));
    // By default what is prepared has the meshes that it stores, and what is not gets levels.
    let has_levels = |figure| crowd_of(figure, &CrowdOptions::default()).has_mesh_lods();
    assert!(has_levels(&fresh));
    let unlevelled = PrepareOptions {
        mesh_levels: PreparedMeshLevels::OfFile,
        ..PrepareOptions::default()
    };
    let plain = Figure::new(opened(&built(human(), &unlevelled))).unwrap();
    assert!(!has_levels(&plain));
    let by_default = built(human(), &PrepareOptions::default());
    assert!(has_levels(&Figure::new(opened(&by_default)).unwrap()));
    for part in [
        PreparedPart::Clips,
        PreparedPart::Skins,
        PreparedPart::Bounds,
    ] {
        let options = PrepareOptions {
            without: vec![part, PreparedPart::PoseCache],
            ..unlevelled.clone()
        };
        let glb = built(human(), &options);
        let check = check_prepared(opened(&glb)).unwrap();
        let missing: Vec<&str> = check
            .parts
            .iter()
            .filter(|p| p.state == PartState::Missing)
            .map(|p| p.part)
            .collect();
        assert_eq!(missing, [part.name(), "pose-cache"]);
        let figure = Figure::new(opened(&glb)).unwrap();
        assert_eq!(played(&crowd_of(&figure, &usual)), expected, "{part}");
    }
    let nothing = PrepareOptions {
        without: PreparedPart::ALL.to_vec(),
        ..PrepareOptions::default()
    };
    for source in [human(), opened(asset())] {
        let check = check_prepared(opened(&built(source, &nothing))).unwrap();
        assert!(check.parts.iter().all(|p| p.bytes == 0), "{check:?}");
    }
}

#[test]
fn everything_else_of_the_file_is_kept() {
    let mut document = human().detach_document().unwrap().document;
    document.json["cameras"] = json!([{
        "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}
    }]);
    document.json["nodes"][0]["camera"] = json!(0);
    document.json["nodes"][0]["extras"] = json!({"a": [1, "b", null]});
    document.json["extensionsUsed"] = json!(["EXT_unheard_of"]);
    document.json["extensions"] = json!({"EXT_unheard_of": {"kept": true}});
    document.json["asset"]["copyright"] = json!("somebody");
    let before = document.json.clone();
    let glb = built(opened(&document.write_glb().unwrap()), &levelled());
    let after: Document = opened(&glb).detach_document().unwrap().document;
    let of = |json: &Value, at: &str| json.pointer(at).cloned();
    for at in [
        "/cameras",
        "/nodes/0/camera",
        "/nodes/0/extras",
        "/extensions/EXT_unheard_of",
        "/asset/copyright",
        "/materials",
        "/scenes",
    ] {
        assert_eq!(of(&after.json, at), of(&before, at), "{at}");
    }
    for (clip, animation) in before["animations"].as_array().unwrap().iter().enumerate() {
        let stored = &after.json["animations"][clip];
        assert_eq!(
            stored["channels"], animation["channels"],
            "samplers stay beside the clips"
        );
    }
}

/// An asset that version 1 of the extension wrote, which is never renewed.
#[test]
fn an_asset_of_version_1_still_opens() {
    let glb = include_bytes!("version-1.glb");
    let check = check_prepared(opened(glb)).unwrap();
    assert_eq!(check.warnings, Vec::<String>::new());
    assert!(check.is_whole(), "{check:?}");
    let figure = Figure::new(opened(glb)).unwrap();
    assert_eq!(figure.asset.clips.len(), 1);
    let of_levels = |mesh_levels| CrowdOptions {
        mesh_levels,
        pose_cache: true,
        ..CrowdOptions::default()
    };
    for options in [of_levels(Some(1)), of_levels(Some(3))] {
        let crowd = crowd_of(&figure, &options);
        assert_eq!(crowd.warnings(), Vec::<String>::new());
        played(&crowd);
    }
}
