//! Files converted to another format and back keep scale, joint map and clips.

use crate::real::real_data;
use articula::convert::{LossyPart, write};
use articula::glam::Vec3;
use articula::{AddClipsOptions, CharacterFile, Executor, Format, OpenOptions, fs, open};
use articula_core::source::evaluate;
use articula_core::{ModelPose, Rig, local_to_model};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Writes a file in another format and reads it again.
fn through(opened: &CharacterFile, format: Format) -> CharacterFile {
    let written = write(opened, format).unwrap();
    let options = OpenOptions {
        skeleton: written.beside.map(|(_, bytes)| bytes),
        ..OpenOptions::default()
    };
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    let name = format!("written.{}", format.name());
    open(&written.bytes, &name, &options, nothing).unwrap()
}

/// Joint positions at a time of the first clip (at rest without one), by H-Anim joint or name.
fn positions(opened: &CharacterFile, secs: f32) -> BTreeMap<String, Vec3> {
    let skeleton = &opened.character().skeleton;
    let rig = Rig::new(skeleton, opened.articulation()).unwrap();
    let mut local = rig.rest_pose().clone();
    if let Some(clip) = opened.character().clips.first() {
        evaluate::pose(clip, skeleton, secs, &mut local);
    }
    let mut model = ModelPose::new(rig.len());
    local_to_model(&rig, &local, &mut model);
    // Names as the writer of BVH files puts them.
    let name = |j: usize| match skeleton.joints[j].name.as_str() {
        "" => format!("joint_{j}"),
        name => name.replace(' ', "_"),
    };
    let joints = opened.articulation().joints.into_iter().enumerate();
    joints
        .map(|(j, own)| (own.hanim.unwrap_or_else(|| name(j)), model.position(j)))
        .collect()
}

fn size(places: &BTreeMap<String, Vec3>) -> f32 {
    let places = || places.values().copied();
    let (low, high) = (
        places().fold(Vec3::MAX, Vec3::min),
        places().fold(Vec3::MIN, Vec3::max),
    );
    low.distance(high)
}

#[test]
fn any_rig_comes_back_from_bvh_at_its_scale() {
    let Some(data) = real_data() else { return };
    for name in ["Fox", "RobotExpressive", "RiggedSimple", "CesiumMan"] {
        let source = fs::open(data.join(format!("glb/{name}.glb"))).unwrap();
        let back = through(&through(&source, Format::Bvh), Format::Glb);
        for secs in [0.0, 0.4] {
            let (there, here) = (positions(&source, secs), positions(&back, secs));
            let mut compared = 0;
            for (joint, place) in &here {
                let apart = there[joint].distance(*place) / size(&there);
                assert!(apart < 1e-3, "{name}, {joint}: {apart} of the figure");
                compared += 1;
            }
            assert!(compared > 1, "{name}: {compared} joints");
        }
    }
}

/// The file with other names of all nodes, which tell nothing.
fn nameless(opened: &CharacterFile) -> CharacterFile {
    let mut document = opened.gltf().unwrap().document.clone();
    let nodes = document.json["nodes"].as_array_mut().unwrap();
    for (n, node) in nodes.iter_mut().enumerate() {
        node["name"] = format!("J_{n}").into();
    }
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    let bytes = document.write_glb().unwrap();
    open(&bytes, "nameless.vrm", &OpenOptions::default(), nothing).unwrap()
}

/// Clips of a VRM animation on an avatar.
fn moved(data: &Path, mut opened: CharacterFile) -> CharacterFile {
    let files = [fs::open(data.join("vrm/idle_loop.vrma")).unwrap()];
    let options = AddClipsOptions::default();
    opened
        .add_clips(&files, &options, &Executor::default())
        .unwrap();
    opened
}

/// H-Anim joints of a file, with their positions.
fn humanoid(opened: &CharacterFile, secs: f32) -> BTreeMap<String, Vec3> {
    let mut places = positions(opened, secs);
    let joints = opened.articulation().joints.into_iter();
    let hanim: BTreeSet<String> = joints.filter_map(|joint| joint.hanim).collect();
    places.retain(|name, _| hanim.contains(name));
    places
}

#[test]
fn the_map_of_a_vrm_file_survives_in_formats_without_one() {
    let Some(data) = real_data() else { return };
    for avatar in [
        "vrm/Godette_vrm_v4.vrm",
        "vrm/VRMC_vrm_expressions_isBinary_Overridden.vrm",
        "vrm/debug_robot.vrm",
    ] {
        let named = fs::open(data.join(avatar)).unwrap();
        let nameless = nameless(&named);
        for source in [named, nameless] {
            let source = moved(&data, source);
            let there = humanoid(&source, 0.5);
            assert!(there.len() > 20, "{avatar}");
            for format in [Format::Amc, Format::Bvh] {
                let here = humanoid(&through(&source, format), 0.5);
                for (joint, place) in &there {
                    let found = here.get(joint);
                    let found =
                        found.unwrap_or_else(|| panic!("{avatar}, {}: {joint}", format.name()));
                    let apart = found.distance(*place);
                    assert!(
                        apart < 1e-3,
                        "{avatar}, {}, {joint}: {apart} m",
                        format.name()
                    );
                }
            }
        }
    }
}

#[test]
fn a_posed_figure_comes_back_from_x3d_in_its_pose_without_a_clip() {
    let Some(data) = real_data() else { return };
    let mut source = fs::open(data.join("glb/CesiumMan.glb")).unwrap();
    // At rest as in the middle of its walk, while the skin stays bound in its T-pose.
    let clip = source.clips_mut().remove(0);
    let rig = Rig::new(&source.character().skeleton, source.articulation()).unwrap();
    let mut local = rig.rest_pose().clone();
    evaluate::pose(&clip, &source.character().skeleton, 0.7, &mut local);
    source.edit_character(|character| {
        for (j, joint) in character.skeleton.joints.iter_mut().enumerate() {
            joint.rest = local.get(j);
        }
    });
    let back = through(&through(&source, Format::X3d), Format::Glb);
    assert!(
        back.character().clips.is_empty(),
        "{:?}",
        back.character().clips
    );
    let (there, here) = (humanoid(&source, 0.0), humanoid(&back, 0.0));
    assert!(there.len() > 12 && there.len() == here.len());
    for (joint, place) in &here {
        let apart = there[joint].distance(*place);
        assert!(apart < 1e-3, "{joint}: {apart} m");
    }
}

#[test]
fn coarser_levels_are_kept_by_glb_and_told_by_x3d() {
    let Some(data) = real_data() else { return };
    for (name, coarser) in [("SimpleSkinLOD", 2), ("msft-lod", 2)] {
        let source = fs::open(data.join(format!("fixtures/msft_lod/{name}.gltf"))).unwrap();
        let levels = |file: &CharacterFile| file.character().meshes[0].levels.len();
        assert_eq!(levels(&source), coarser);
        assert_eq!(levels(&through(&source, Format::Glb)), coarser);
        let mut anew = source.clone();
        anew.detach_document();
        assert_eq!(levels(&through(&anew, Format::Glb)), coarser);
        let written = write(&source, Format::X3d).unwrap();
        assert!(
            written.left_out.contains(&LossyPart::MeshLevels(coarser)),
            "{name}"
        );
    }
}
