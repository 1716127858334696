//! Crowds of the library: every file gives a sensible crowd, and the output does not depend on the
//! thread that evaluates.

use crate::real::{file, real_data};
use crate::short::shortened;
use articula::crowd::{
    Camera, CrowdAsset, CrowdOptions, CrowdPlayer, Culling, JointLodMethod, PaletteForm,
    PaletteHash, PaletteMatrices, PaletteSlice, RootMotionPolicy, View, Viewport,
};
use articula::{AddClipsOptions, CharacterFile, Executor, Figure, OpenOptions};
use articula_core::loa::LoaExpression;
use glam::Vec3;
use std::sync::OnceLock;

/// The reference human, built once for all tests.
pub(crate) fn human() -> CharacterFile {
    static HUMAN: OnceLock<CharacterFile> = OnceLock::new();
    let made = HUMAN.get_or_init(|| {
        let options = articula_human::HumanOptions::mannequin(2000);
        let character = articula_human::human(&options).unwrap();
        let document = articula_formats::gltf::Document::from_character(&character).unwrap();
        let glb = document.write_glb().unwrap();
        let nothing: &mut articula_formats::Resolver<'_> = &mut |_| Err("nothing".into());
        articula::open(&glb, "human.glb", &OpenOptions::default(), nothing).unwrap()
    });
    made.clone()
}

pub(crate) fn asset_of(opened: CharacterFile, options: &CrowdOptions) -> CrowdAsset {
    let figure = Figure::new(opened).unwrap();
    CrowdAsset::new(&figure, options, &Executor::default()).unwrap()
}

/// The human as a crowd by the usual options, made once for all tests.
pub(crate) fn human_asset() -> &'static CrowdAsset {
    static ASSET: OnceLock<CrowdAsset> = OnceLock::new();
    ASSET.get_or_init(|| asset_of(human(), &CrowdOptions::default()))
}

/// A row of characters, each slightly later in the next clip, and a camera that sees all of them.
pub(crate) fn row(asset: &CrowdAsset, count: usize) -> (CrowdPlayer, Camera) {
    let mut crowd = CrowdPlayer::new(asset, count).unwrap();
    for i in 0..count {
        crowd.place(i, Vec3::X * (2.0 * i as f32 - count as f32), 0.3);
        crowd.play(i, i % asset.clips().len(), 0.1 * i as f32);
    }
    let bounds = &asset.model().parts().bounds;
    let radius = |c: &articula_core::ClipBounds| c.whole().sphere.radius;
    let reach = bounds.clips.iter().map(radius).fold(1.0, f32::max);
    let eye = Vec3::new(0.0, reach, 4.0 * reach + 4.0 * count as f32);
    (
        crowd,
        Camera::looking_at(eye, Vec3::ZERO, Viewport::default()),
    )
}

fn all_finite(palettes: PaletteSlice<'_>) -> bool {
    match palettes {
        PaletteSlice::Float(rows) => rows.as_flattened().iter().all(|v| v.is_finite()),
        PaletteSlice::Half(rows) => rows.as_flattened().iter().all(|v| v & 0x7c00 != 0x7c00),
    }
}

/// Plays a crowd for a second; returns the largest distance that a vertex moved between frames, in
/// metres.
fn played(asset: &CrowdAsset) -> f32 {
    let (mut crowd, camera) = row(asset, 8);
    let mut before: Vec<Option<Vec<Vec3>>> = vec![None; 8];
    let mut way: f32 = 0.0;
    for frame in 0..10 {
        let report = crowd.frame(0.1, &camera);
        assert_eq!(report.visible, 8, "frame {frame}");
        assert!(all_finite(crowd.palettes()), "frame {frame}");
        let shown: usize = crowd.draws().map(|d| d.instances.len()).sum();
        assert_eq!(shown, 8);
        for (i, before) in before.iter_mut().enumerate() {
            let (mesh, skinned) = crowd.skinned(i).unwrap();
            assert_eq!(skinned.positions.len(), mesh.len());
            assert!(skinned.positions.iter().all(|p| p.is_finite()));
            if let Some(before) = before {
                let apart = before.iter().zip(&skinned.positions);
                way = apart.map(|(a, b)| a.distance(*b)).fold(way, f32::max);
            }
            *before = Some(skinned.positions);
        }
    }
    way
}

#[test]
fn any_file_makes_a_crowd() {
    for (name, moves, said) in [
        ("glb/KayKit_Knight.glb", true, ""),
        ("glb/Quaternius_cyberpunk_pack__Character.glb", true, ""),
        ("glb/Quaternius_modular_men__Casual2.glb", false, "no clip"),
        ("glb/Quaternius_modular_women__Casual.glb", false, "no clip"),
        ("glb/RobotExpressive.glb", true, ""),
        ("glb/mh_female_dance.glb", true, ""),
        ("glb/Fox.glb", true, ""),
        ("glb/CesiumMan.glb", true, ""),
        ("glb/mh_female_default163_arkit52.glb", false, "no clip"),
        ("vrm/Godette_vrm_v4.vrm", false, "no clip"),
        ("glb/AnimatedMorphCube.glb", true, ""),
        ("bvh/cmu_12_01_walk.bvh", true, "points on the bones"),
    ] {
        let Some(path) = file(name) else { continue };
        // All clips of the file: one may be odd. Their beginnings show it.
        let opened = shortened(articula::fs::open(path).unwrap(), 0.2);
        let asset = asset_of(opened, &CrowdOptions::default());
        let way = played(&asset);
        assert_eq!(way > 1e-3, moves, "{name}: {way} m");
        let warnings = asset.warnings().join("; ");
        assert_eq!(warnings.is_empty(), said.is_empty(), "{name}: {warnings}");
        assert!(warnings.contains(said), "{name}: {warnings}");
    }
}

#[test]
fn a_file_without_clips_moves_with_those_of_another() {
    let Some(walk) = file("bvh/cmu_12_01_walk.bvh") else {
        return;
    };
    let motion = shortened(articula::fs::open(walk).unwrap(), 2.5);
    for name in [
        "glb/Quaternius_modular_men__Worker.glb",
        "glb/mh_female_default163_arkit52.glb",
        "vrm/Godette_vrm_v4.vrm",
    ] {
        let Some(path) = file(name) else { continue };
        let mut opened = articula::fs::open(path).unwrap();
        let motions = std::slice::from_ref(&motion);
        opened
            .add_clips(motions, &AddClipsOptions::default(), &Executor::default())
            .unwrap();
        let asset = asset_of(opened, &CrowdOptions::default());
        // A walk of some metres is played in place.
        assert!(asset.travels(0), "{name}");
        let way = played(&asset);
        assert!(way > 0.01, "{name}: {way} m");
        assert_eq!(asset.warnings(), [""; 0], "{name}");
    }
}

#[test]
fn a_named_level_of_unknown_joints_says_the_mend() {
    let Some(data) = real_data() else { return };
    let opened = articula::fs::open(data.join("glb/Fox.glb")).unwrap();
    let options = CrowdOptions {
        joints: JointLodMethod::Named("loa(Low)".parse::<LoaExpression>().unwrap()),
        ..CrowdOptions::default()
    };
    let asset = asset_of(opened, &options);
    assert!(asset.warnings().concat().contains("give a joint map"));
    assert!(played(&asset) > 1e-3);
}

#[test]
fn who_evaluates_changes_no_bit() {
    for (matrices, form) in [
        (PaletteMatrices::Skin, PaletteForm::Matrix),
        (PaletteMatrices::Joints, PaletteForm::HalfMatrix),
    ] {
        let options = CrowdOptions {
            matrices,
            form,
            ..CrowdOptions::default()
        };
        let asset = asset_of(human(), &options);
        let run = |parts: usize, backwards: bool| {
            let (mut crowd, camera) = row(&asset, 100);
            let mut hash = PaletteHash::default();
            for _ in 0..3 {
                let views = [View::of(&camera)];
                crowd.plan(1.0 / 60.0, Culling::Views(&views), &mut |_| ());
                let mut parts: Vec<_> = crowd.parts(parts).collect();
                if backwards {
                    parts.reverse();
                }
                parts.iter_mut().for_each(|part| part.evaluate());
                drop(parts);
                hash.add(&crowd);
            }
            hash.text()
        };
        let one = run(1, false);
        assert_eq!(one, run(5, false));
        assert_eq!(one, run(7, true));
        assert_eq!(one, run(1000, true));
    }
}

#[test]
fn a_frame_allocates_nothing() {
    let asset = human_asset();
    let (mut crowd, camera) = row(asset, 200);
    crowd.frame(0.0, &camera);
    let counted = allocation_counter::measure(|| {
        for i in 0..200 {
            crowd.place(i, Vec3::Z * i as f32, 0.1);
            crowd.fade_to(i, i % asset.clips().len(), 0.2);
        }
        crowd.frame(1.0 / 60.0, &camera);
        let shown: usize = crowd.draws().map(|d| d.instances.len()).sum();
        assert!(shown > 0);
    });
    assert_eq!(counted.count_total, 0);
}

#[test]
fn poses_are_cached_unless_told_otherwise() {
    let (mut crowd, camera) = row(human_asset(), 100);
    let report = crowd.frame(0.1, &camera);
    assert!(report.stepped > 50, "{report:?}");
    let evaluated = CrowdOptions {
        pose_cache: false,
        ..CrowdOptions::default()
    };
    let (mut crowd, camera) = row(&asset_of(human(), &evaluated), 100);
    let report = crowd.frame(0.1, &camera);
    assert_eq!((report.own, report.stepped), (100, 0));
}

#[test]
fn joints_and_skin_show_the_same_vertices() {
    let skinned = |matrices, form| {
        let options = CrowdOptions {
            matrices,
            form,
            pose_cache: false,
            ..CrowdOptions::default()
        };
        let (mut crowd, camera) = row(&asset_of(human(), &options), 3);
        crowd.frame(0.3, &camera);
        crowd.skinned(1).unwrap().1.positions
    };
    let skin = skinned(PaletteMatrices::Skin, PaletteForm::Matrix);
    for (form, metres) in [
        (PaletteForm::Matrix, 1e-5),
        (PaletteForm::Rigid, 1e-5),
        // Half floats: 1/2048 of a rotation's numbers at 2 m.
        (PaletteForm::HalfMatrix, 4e-3),
    ] {
        let joints = skinned(PaletteMatrices::Joints, form);
        let apart = skin.iter().zip(&joints).map(|(a, b)| a.distance(*b));
        let apart = apart.fold(0.0, f32::max);
        assert!(apart < metres, "{form:?}: {apart} m");
    }
}

#[test]
fn clips_are_chosen_by_name_and_unknown_ones_are_told() {
    let figure = Figure::new(human()).unwrap();
    let name = figure.asset.clips[1].name.clone();
    let options = |name: &str| CrowdOptions {
        clips: vec![name.to_owned()],
        joints: JointLodMethod::Named("loa(Low)".parse::<LoaExpression>().unwrap()),
        root_motion: RootMotionPolicy::Extracted,
        ..CrowdOptions::default()
    };
    let asset = CrowdAsset::new(&figure, &options(&name), &Executor::default()).unwrap();
    assert_eq!((asset.clips().len(), asset.clip(&name).unwrap()), (1, 0));
    assert_eq!(asset.levels(), 2);
    assert!(asset.level(1).joints < asset.level(0).joints);
    let why = CrowdAsset::new(&figure, &options("fly"), &Executor::default()).unwrap_err();
    assert!(why.is_argument() && why.to_string().starts_with("human.glb: there is no clip"));
}

#[test]
fn too_large_a_crowd_is_refused() {
    let asset = human_asset();
    let why = CrowdPlayer::new(asset, usize::MAX / 1000).unwrap_err();
    assert!(why.to_string().contains("lower the count"), "{why}");
}

/// What is shown of each character, as positions of the vertices of its mesh.
fn shown(crowd: &CrowdPlayer, count: usize) -> Vec<Option<Vec<Vec3>>> {
    let skinned = (0..count).map(|i| crowd.skinned(i));
    skinned
        .map(|of| of.map(|(_, skinned)| skinned.positions))
        .collect()
}

#[test]
fn a_crowd_starts_at_once_and_takes_the_prepared_asset_between_frames() {
    let options = CrowdOptions::default();
    let figure = Figure::new(human()).unwrap();
    let at_once = CrowdAsset::at_once(&figure, &options).unwrap();
    assert_eq!((at_once.levels(), at_once.has_mesh_lods()), (1, false));
    assert_eq!(at_once.full().mesh.positions, at_once.mesh(0).positions);
    let prepared = human_asset();
    let bounds = [&at_once, prepared].map(|asset| &asset.model().parts().bounds.clips);
    for (wide, close) in bounds[0].iter().zip(bounds[1]) {
        let (wide, close) = (wide.whole().sphere, close.whole().sphere);
        assert!(wide.centre.distance(close.centre) + close.radius <= wide.radius);
    }

    let count = 12;
    let (mut crowd, camera) = row(&at_once, count);
    crowd.set_importance(3, 2.0);
    crowd.set_scale(4, 1.5);
    for _ in 0..5 {
        crowd.frame(0.1, &camera);
    }
    crowd.fade_to(2, 1, 0.5);
    crowd.frame(0.1, &camera);
    let before = shown(&crowd, count);
    crowd.set_asset(prepared).unwrap();
    crowd.frame(0.0, &camera);
    assert!((0..count).any(|i| crowd.crowd().level(i) > Some(0)));

    // The same as if it had been prepared from the beginning.
    let (mut other, _) = row(prepared, count);
    other.set_importance(3, 2.0);
    other.set_scale(4, 1.5);
    for _ in 0..5 {
        other.frame(0.1, &camera);
    }
    other.fade_to(2, 1, 0.5);
    other.frame(0.1, &camera);
    assert_eq!(shown(&crowd, count), shown(&other, count));

    // Within a pixel of what was shown in full detail: 95 of 100 vertices, and all within two.
    let depth = |at: Vec3| camera.project(at).1;
    for (i, full) in before.iter().enumerate() {
        let (Some(full), Some((mesh, now))) = (full, crowd.skinned(i)) else {
            panic!("character {i} is in view before and after");
        };
        let used: std::collections::BTreeSet<u32> =
            mesh.triangles.iter().flatten().copied().collect();
        let world = crowd.world_from_model(i);
        let mut px: Vec<f32> = used
            .iter()
            .map(|v| {
                let [a, b] = [full[*v as usize], now.positions[*v as usize]];
                let [a, b] = [a, b].map(|p| world.transform_point3(p));
                a.distance(b) * camera.viewport.pixels_per_metre(depth(a))
            })
            .collect();
        px.sort_by(f32::total_cmp);
        assert!(
            px[px.len() * 94 / 100] <= 1.0 && px[px.len() - 1] <= 2.0,
            "{i}: {px:?}"
        );
    }
}

#[test]
fn an_asset_of_other_clips_is_refused_and_changes_nothing() {
    let figure = Figure::new(human()).unwrap();
    let one = CrowdOptions {
        clips: vec![figure.asset.clips[0].name.clone()],
        ..CrowdOptions::default()
    };
    let other = CrowdAsset::at_once(&figure, &one).unwrap();
    let (mut crowd, camera) = row(human_asset(), 2);
    crowd.frame(0.1, &camera);
    let before = shown(&crowd, 2);
    let refused = crowd.set_asset(&other).unwrap_err().to_string();
    assert!(refused.contains("other clips"), "{refused}");
    assert_eq!(shown(&crowd, 2), before);
}

/// Materials and draws of a character in full detail.
fn materials_and_draws(opened: CharacterFile) -> [usize; 2] {
    let figure = Figure::new(opened).unwrap();
    let asset = CrowdAsset::at_once(&figure, &CrowdOptions::default()).unwrap();
    let ranges = asset.material_ranges(0).iter();
    let draws = ranges.clone().filter(|range| !range.joins_previous);
    [ranges.len(), draws.count()]
}

#[test]
fn parts_that_differ_in_colour_alone_are_one_draw() {
    // Its materials have a colour each, and no texture.
    let all = human().character().materials.len();
    assert_eq!(all, 7);
    assert_eq!(materials_and_draws(human()), [all, 1]);
    let changed = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut document = human().gltf().unwrap().document.clone();
        change(&mut document.json);
        let nothing: &mut articula_formats::Resolver<'_> = &mut |_| Err("nothing".into());
        let bytes = document.write_glb().unwrap();
        articula::open(&bytes, "changed.glb", &OpenOptions::default(), nothing).unwrap()
    };
    let shiny = changed(&|json| {
        json["materials"][1]["pbrMetallicRoughness"]["roughnessFactor"] = 0.25.into();
    });
    assert_eq!(materials_and_draws(shiny), [all, 2]);
    let variants = changed(&|json| {
        let day_and_night = serde_json::json!({"variants": [{"name": "day"}, {"name": "night"}]});
        json["extensions"]["KHR_materials_variants"] = day_and_night;
    });
    assert_eq!(materials_and_draws(variants), [all, all]);
    for (name, expected) in [
        ("RobotExpressive", [3, 1]),
        ("Quaternius_modular_men__Worker", [11, 1]),
    ] {
        let Some(path) = file(&format!("glb/{name}.glb")) else {
            continue;
        };
        let found = materials_and_draws(articula::fs::open(path).unwrap());
        assert_eq!(found, expected, "{name}");
    }
}
