//! Transfers clips of real files to other characters, and checks the errors where they do not fit.

use crate::real::real_data;
use crate::short::shortened;
use articula::convert::{
    ClipEdits, ClipPart, ClipProvenance, ReduceOptions, Timelines, fit_clips, write,
};
use articula::glam::{EulerRot, Quat, Vec3};
use articula::inspect::inspect;
use articula::{
    AddClipsOptions, CharacterFile, ConvertOptions, Error, Executor, Figure, Format, OpenOptions,
    PrepareOptions, convert, fs, open, prepare,
};
use articula_core::source::{Character, evaluate};
use articula_core::{ModelPose, Rig, local_to_model};
use std::path::Path;

const MANNEQUIN: &str = "glb/kaykit_mannequin/manny_med_mod.gltf";
const LIBRARY: &str = "glb/kaykit_mannequin/Med_MovementBasic.glb";
const WOMAN: &str = "glb/mh_female_default163_arkit52.glb";
const WALK: &str = "bvh/cmu_12_01_walk.bvh";
const AVATAR: &str = "vrm/Godette_vrm_v4.vrm";
const FOX: &str = "glb/Fox.glb";

/// Adds the clips of a file to a character; also returns their origin.
fn added(data: &Path, character: &str, file: &str) -> (CharacterFile, Vec<ClipProvenance>) {
    let mut opened = fs::open(data.join(character)).unwrap();
    let files = [fs::open(data.join(file)).unwrap()];
    let options = AddClipsOptions::default();
    let fits = opened.add_clips(&files, &options, &Executor::default());
    (opened, fits.unwrap())
}

/// The error of adding the clips of a file.
fn refused(data: &Path, character: &str, file: &str) -> Error {
    let mut opened = fs::open(data.join(character)).unwrap();
    let before = opened.character().clips.len();
    let files = [fs::open(data.join(file)).unwrap()];
    let why = opened.add_clips(&files, &AddClipsOptions::default(), &Executor::default());
    assert_eq!(opened.character().clips.len(), before);
    why.unwrap_err()
}

/// Joint positions at a time of a clip, by name.
fn positions(opened: &CharacterFile, clip: &str, secs: f32) -> Vec<(String, Vec3)> {
    let skeleton = &opened.character().skeleton;
    let rig = Rig::new(skeleton, opened.articulation()).unwrap();
    let clips = &opened.character().clips;
    let clip = clips.iter().find(|c| c.name == clip).unwrap();
    let mut local = rig.rest_pose().clone();
    evaluate::pose(clip, skeleton, secs, &mut local);
    let mut model = ModelPose::new(rig.len());
    local_to_model(&rig, &local, &mut model);
    let names = skeleton.joints.iter().map(|j| j.name.clone());
    names
        .enumerate()
        .map(|(j, name)| (name, model.position(j)))
        .collect()
}

/// Reads a written GLB.
fn again(bytes: &[u8]) -> CharacterFile {
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    open(bytes, "written.glb", &OpenOptions::default(), nothing).unwrap()
}

#[test]
fn a_library_of_clips_moves_its_mannequin_as_it_is() {
    let Some(data) = real_data() else { return };
    let (opened, fits) = added(&data, MANNEQUIN, LIBRARY);
    assert_eq!(fits.len(), 11);
    assert!(fits.iter().all(|fit| fit.retargeted.is_none()));
    let name = "Rig_Medium|Running_A";
    assert!(fits.iter().any(|fit| fit.name == name && fit.from == name));
    // Every joint has the position that it has on the library's own rig.
    let library = fs::open(data.join(LIBRARY)).unwrap();
    let there = positions(&library, name, 0.3);
    let mut compared = 0;
    for (joint, position) in positions(&opened, name, 0.3) {
        if let Some((_, other)) = there.iter().find(|(name, _)| *name == joint) {
            assert!(position.distance(*other) < 1e-4, "{joint}");
            compared += 1;
        }
    }
    assert!(compared > 20, "only {compared} joints");
    // The prepared and written file has the clips.
    let opened = shortened(opened, 0.3);
    let prepared = prepare(opened, &PrepareOptions::default(), &Executor::default()).unwrap();
    assert_eq!(prepared.tables.len(), 11);
    let asset = again(&prepared.glb);
    assert_eq!(asset.character().clips.len(), 11);
    assert_eq!(asset.character().meshes.len(), 8);
}

#[test]
fn a_capture_walks_on_other_figures_by_the_map() {
    let Some(data) = real_data() else { return };
    for (character, tall) in [(WOMAN, 1.0), (AVATAR, 0.8)] {
        let (opened, fits) = added(&data, character, WALK);
        assert_eq!(fits[0].name, "cmu_12_01_walk");
        let report = fits[0].retargeted.as_ref().unwrap();
        assert!(report.quality.slide.mean_metres < 0.02, "{character}");
        let format = opened.format();
        let written = write(&opened, format).unwrap();
        let back = again(&written.bytes);
        let hips = |secs| {
            let all = positions(&back, "cmu_12_01_walk", secs);
            let at = back.mapping().articulation.joints.iter();
            let hips = at.clone().position(|j| j.hanim.as_deref() == Some("l_hip"));
            all[hips.unwrap()].1
        };
        let (start, end) = (hips(0.5), hips(3.5));
        assert!(start.distance(end) > tall, "{character}: {start} to {end}");
    }
}

#[test]
fn figures_move_with_what_came_from_elsewhere() {
    let Some(data) = real_data() else { return };
    for (character, file) in [(MANNEQUIN, LIBRARY), (WOMAN, WALK)] {
        let (opened, _) = added(&data, character, file);
        let figure = Figure::new(opened).unwrap();
        assert!(figure.clip(None).unwrap().is_some(), "{character}");
    }
}

#[test]
fn what_fits_neither_by_name_nor_by_map_says_the_mend() {
    let Some(data) = real_data() else { return };
    for (character, file) in [(FOX, WALK), (WOMAN, FOX)] {
        let why = refused(&data, character, file);
        assert!(matches!(why.cause(), Error::Unmapped(_)), "{why}");
        let said = why.to_string();
        assert!(said.contains(file) && said.contains("Fox.glb"), "{said}");
        assert!(said.contains("joint map"), "{said}");
    }
    let why = refused(&data, WOMAN, "glb/mh_male_cmu31.glb").to_string();
    assert!(
        why.contains("mh_male_cmu31.glb: clips: the file has no clip"),
        "{why}"
    );
}

/// The fox twice as large, with other axes of every joint, without a mesh.
fn other_fox(data: &Path) -> CharacterFile {
    let mut fox = fs::open(data.join(FOX)).unwrap();
    fox.edit_character(enlarge);
    fox
}

fn enlarge(fox: &mut Character) {
    fox.meshes.clear();
    fox.clips.clear();
    let joints = &mut fox.skeleton.joints;
    let turned: Vec<Quat> = (0..joints.len())
        .map(|j| Quat::from_euler(EulerRot::XYZ, j as f32, 0.7 * j as f32, 2.0 - j as f32))
        .collect();
    for joint in 0..joints.len() {
        let above = joints[joint].parent.map_or(Quat::IDENTITY, |p| turned[p]);
        let rest = &mut joints[joint].rest;
        rest.translation = above.inverse() * (2.0 * rest.translation);
        rest.rotation = above.inverse() * rest.rotation * turned[joint];
    }
}

#[test]
fn rigs_with_the_same_names_that_are_no_humans_are_retargeted_by_name() {
    let Some(data) = real_data() else { return };
    let fox = fs::open(data.join(FOX)).unwrap();
    let mut other = other_fox(&data);
    let options = AddClipsOptions {
        prefix: "new ".to_owned(),
        ..AddClipsOptions::default()
    };
    let files = [fox.clone()];
    let fits = other.add_clips(&files, &options, &Executor::default());
    let fits = fits.unwrap();
    for fit in &fits {
        let report = fit.by_name.as_ref().unwrap();
        assert!(fit.retargeted.is_none() && report.dropped.is_empty());
        assert_eq!(report.followed, report.moving, "{}", fit.from);
        assert!((report.scale - 2.0).abs() < 1e-4);
        // Every joint is where the fox's is, twice as far from the origin.
        for secs in [0.0, 0.3, 0.6] {
            let there = positions(&fox, &fit.from, secs);
            let here = positions(&other, &fit.name, secs);
            for ((name, wanted), (_, found)) in there.iter().zip(&here) {
                // The fox is 79 m high by its unit.
                assert!(found.distance(2.0 * *wanted) < 0.02, "{name}");
            }
        }
    }
    // The same skeleton is still copied.
    let (_, fits) = added(&data, FOX, FOX);
    let is_copy = |fit: &ClipProvenance| fit.by_name.is_none() && fit.retargeted.is_none();
    assert!(fits.iter().all(is_copy));
}

#[test]
fn too_few_common_names_are_refused() {
    let Some(data) = real_data() else { return };
    let fox = fs::open(data.join(FOX)).unwrap();
    let mut other = other_fox(&data);
    // Hips, two spine joints, neck, head and an upper arm keep their names; what is above has no keys.
    other.edit_character(|character| {
        for joint in character.skeleton.joints.iter_mut().skip(9) {
            joint.name.push_str("_x");
        }
    });
    let why = other.add_clips(&[fox], &AddClipsOptions::default(), &Executor::default());
    let said = why.unwrap_err().to_string();
    assert!(said.contains("only 6 of the 20 moving joints"), "{said}");
}

#[test]
fn a_skeleton_without_skin_and_mesh_is_a_motion() {
    let Some(data) = real_data() else { return };
    let mut motion = fs::open(data.join("glb/mannequiny.glb")).unwrap();
    motion.edit_character(|character| {
        character.meshes.clear();
        let joints = character.skeleton.joints.iter_mut();
        joints.for_each(|j| j.in_skin = false);
    });
    let written = write(&motion, Format::Glb).unwrap();
    let back = again(&written.bytes);
    assert!(back.mapping().humanoid);
    let figure = Figure::new(back.clone()).unwrap();
    let found = inspect(&figure, &[0], &Executor::default()).unwrap();
    assert_eq!(found.skeletons.len(), 1);
    assert_eq!(found.skeletons[0].joints, 45);
    assert!(found.clips[0].joints_animated <= 45);
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    // It is prepared as any figure is, and what is stored is read again.
    let prepared = prepare(
        back.clone(),
        &PrepareOptions::default(),
        &Executor::default(),
    )
    .unwrap();
    let asset = Figure::new(again(&prepared.glb)).unwrap();
    assert_eq!(asset.asset.rig.skin_joints().len(), 45);
    assert!(
        asset.opened.warnings().is_empty(),
        "{:?}",
        asset.opened.warnings()
    );
    let mut hero = fs::open(data.join(WOMAN)).unwrap();
    let fits = hero.add_clips(&[back], &AddClipsOptions::default(), &Executor::default());
    assert!(fits.unwrap()[0].retargeted.is_some());
}

#[test]
fn clips_of_several_files_keep_apart() {
    let Some(data) = real_data() else { return };
    let mut opened = fs::open(data.join(WOMAN)).unwrap();
    let own = opened.character().clips.len();
    let file = |name: &str| fs::open(data.join(name)).unwrap();
    let files = [file(WALK), file(WALK), file(LIBRARY)];
    let options = AddClipsOptions {
        prefix: "new ".into(),
        ..AddClipsOptions::default()
    };
    let fits = opened
        .add_clips(&files, &options, &Executor::default())
        .unwrap();
    let names: Vec<&str> = fits.iter().map(|fit| fit.name.as_str()).collect();
    assert_eq!(names[..2], ["new cmu_12_01_walk", "new cmu_12_01_walk 2"]);
    assert_eq!(names[2], "new Med_MovementBasic Rig_Medium|Jump_Full_Long");
    assert_eq!(opened.character().clips.len(), own + 13);
    let options = AddClipsOptions {
        keep_own: false,
        clip: Some("Rig_Medium|Walking_A".into()),
        ..AddClipsOptions::default()
    };
    let files = [file(LIBRARY)];
    opened
        .add_clips(&files, &options, &Executor::default())
        .unwrap();
    assert_eq!(opened.character().clips.len(), 1);
}

/// A figure of two joints that nods for three frames.
const NOD: &str = "HIERARCHY
ROOT Hips
{
  OFFSET 0 90 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine
  {
    OFFSET 0 30 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 20 0
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.1
0 90 0 0 0 0 0 0 0
0 90 1 0 0 0 0 5 0
0 90 2 0 0 0 0 0 0
";

fn nod() -> CharacterFile {
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    open(NOD.as_bytes(), "nod.bvh", &OpenOptions::default(), nothing).unwrap()
}

#[test]
fn a_file_is_edited_and_written_in_another_format() {
    let options = ConvertOptions {
        edits: ClipEdits {
            trim: Some(ClipPart {
                from_secs: None,
                to_secs: Some(0.1),
            }),
            rate_hz: Some(60.0),
            reduce_keys: Some(ReduceOptions {
                bound_metres: 1e-3,
                drop_rest: false,
                timelines: Timelines::Own,
            }),
            ..ClipEdits::default()
        },
        ..ConvertOptions::default()
    };
    let made = convert(nod(), Format::Glb, &options, &Executor::default()).unwrap();
    let edited = &made.edits[0];
    assert_eq!(edited.trim.unwrap().to_secs, 0.1);
    let keys = edited.reduce_keys.unwrap();
    assert_eq!(edited.rate.unwrap().keys_after, keys.keys_before);
    assert!(keys.keys_after < keys.keys_before && keys.worst_m <= 1e-3);
    let back = again(&made.written.bytes);
    assert!((back.character().clips[0].duration_secs - 0.1).abs() < 1e-5);
    let why = convert(nod(), Format::Bvh, &options, &Executor::default()).unwrap_err();
    assert!(why.is_argument() && why.to_string().contains("every frame"));
    let why = convert(
        nod(),
        Format::Vrm,
        &ConvertOptions::default(),
        &Executor::default(),
    );
    let why = why.unwrap_err().to_string();
    assert!(
        why.starts_with("conversion from bvh to vrm is not supported"),
        "{why}"
    );
}

#[test]
fn without_a_clip_formats_of_motion_are_refused_and_pairs_come_as_two() {
    let pair = write(&nod(), Format::Amc).unwrap();
    assert_eq!(pair.beside.unwrap().0, Format::Asf);
    let mut still = nod();
    still.select_clips(&[]);
    let why = write(&still, Format::Bvh).unwrap_err().to_string();
    assert!(why.contains("the file has no clip to write"), "{why}");
    assert!(write(&still, Format::Asf).unwrap().beside.is_none());
    let made = CharacterFile::from_character("made", nod().into_character());
    assert_eq!(made.mapping().humanoid, nod().mapping().humanoid);
}

/// Feet that cannot reach their contacts are left where the transfer of rotations has them.
#[test]
fn pinning_never_makes_feet_slide_more() {
    let Some(data) = real_data() else { return };
    let (death, twist) = (
        "glb/Quaternius_platformer_game_pack__Character.glb",
        "vrm/hips_spine_twisting.vrma",
    );
    for (file, clip, onto) in [
        (
            death,
            Some("CharacterArmature|Death"),
            "glb/Quaternius_modular_men__Casual2.glb",
        ),
        (twist, None, "glb/pab_arnaud.glb"),
        (twist, None, "glb/RobotExpressive.glb"),
        (WALK, None, "glb/KayKit_Knight.glb"),
    ] {
        let onto = fs::open(data.join(onto)).unwrap();
        let options = AddClipsOptions {
            clip: clip.map(str::to_owned),
            by_names: false,
            ..AddClipsOptions::default()
        };
        let made = fit_clips(&fs::open(data.join(file)).unwrap(), &onto, &options).unwrap();
        let report = made[0].fit.retargeted.as_ref().unwrap();
        let (before, after) = (report.quality.slide_before, report.quality.slide);
        assert!(before.contacts > 0, "{file}");
        let [before, after] = [before, after].map(|slide| 1e3 * slide.mean_metres);
        assert!(
            after <= before + 1.0,
            "{file}: {before} mm before, {after} mm after"
        );
    }
}
