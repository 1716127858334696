//! Every real humanoid maps to the standard, on the correct sides.

use crate::real::bytes;
use articula_build::joint_names::{JointMapping, UnmappedReason};
use articula_core::source::{Joint, Skeleton};
use articula_core::{Region, Transform};
use articula_formats::joint_map;
use glam::{Affine3A, Mat4, Quat, Vec3};
use serde_json::Value;

/// Reports a missing data set once, and returns whether it is present.
fn data_is_here() -> bool {
    let here = bytes("MANIFEST.md").is_some();
    if !here {
        println!("skipped: no data");
    }
    here
}

fn document(name: &str) -> Value {
    let bytes = bytes(name).unwrap();
    let json = if bytes.starts_with(b"glTF") {
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        &bytes[20..20 + length]
    } else {
        &bytes[..]
    };
    serde_json::from_slice(json).unwrap()
}

fn floats(value: &Value) -> Vec<f32> {
    let list = value.as_array().map_or(&[][..], Vec::as_slice);
    list.iter().map(|v| v.as_f64().unwrap() as f32).collect()
}

fn rest(node: &Value) -> Transform {
    if let Some(matrix) = node.get("matrix") {
        return Transform::from_matrix(Mat4::from_cols_slice(&floats(matrix))).unwrap();
    }
    let mut rest = Transform::IDENTITY;
    if let Some(t) = node.get("translation") {
        rest.translation = Vec3::from_slice(&floats(t));
    }
    if let Some(r) = node.get("rotation") {
        rest.rotation = Quat::from_slice(&floats(r));
    }
    if let Some(s) = node.get("scale") {
        rest.scale = Vec3::from_slice(&floats(s));
    }
    rest
}

/// Returns all nodes of a file as a skeleton, parents first, and the joint of each node.
fn skeleton(json: &Value) -> (Skeleton, Vec<usize>) {
    let nodes = json["nodes"].as_array().unwrap();
    let empty = Vec::new();
    let skins = json["skins"].as_array().unwrap_or(&empty);
    let index = |v: &Value| v.as_u64().unwrap() as usize;
    let in_skin: Vec<usize> = skins
        .iter()
        .flat_map(|s| s["joints"].as_array().unwrap().iter().map(index))
        .collect();
    let children = |n: usize| -> Vec<usize> {
        let list = nodes[n]["children"].as_array().unwrap_or(&empty);
        list.iter().map(index).collect()
    };
    let mut parent = vec![None; nodes.len()];
    for n in 0..nodes.len() {
        for c in children(n) {
            parent[c] = Some(n);
        }
    }
    let mut joint_of = vec![0; nodes.len()];
    let mut skeleton = Skeleton::default();
    let mut open: Vec<usize> = (0..nodes.len())
        .rev()
        .filter(|&n| parent[n].is_none())
        .collect();
    while let Some(n) = open.pop() {
        joint_of[n] = skeleton.joints.len();
        skeleton.joints.push(Joint {
            name: nodes[n]["name"].as_str().unwrap_or("").to_owned(),
            parent: parent[n].map(|p: usize| joint_of[p]),
            rest: rest(&nodes[n]),
            in_skin: in_skin.contains(&n),
        });
        open.extend(children(n).into_iter().rev());
    }
    (skeleton, joint_of)
}

/// Returns node and human bone of a VRM file, by an independent reader.
fn humanoid(json: &Value) -> Option<Vec<(usize, String)>> {
    let extensions = ["VRM", "VRMC_vrm", "VRMC_vrm_animation"];
    let bones = extensions.map(|e| &json["extensions"][e]["humanoid"]["humanBones"]);
    let bones = bones.into_iter().find(|bones| !bones.is_null())?;
    let node = |bone: &Value| bone["node"].as_u64().unwrap() as usize;
    Some(match bones.as_array() {
        Some(list) => list
            .iter()
            .map(|b| (node(b), b["bone"].as_str().unwrap().to_owned()))
            .collect(),
        None => bones
            .as_object()?
            .iter()
            .map(|(name, b)| (node(b), name.clone()))
            .collect(),
    })
}

fn mapped(name: &str) -> (Skeleton, JointMapping) {
    let json = document(name);
    let (skeleton, joint_of) = skeleton(&json);
    let given = humanoid(&json).map(|bones| {
        let joint = |(node, bone): (usize, String)| (joint_of[node], bone);
        bones.into_iter().map(joint).collect::<Vec<_>>()
    });
    let mapping =
        articula_build::joint_names::map(&skeleton, joint_map::builtin(), given.as_deref());
    (skeleton, mapping)
}

fn position(skeleton: &Skeleton, mapping: &JointMapping, hanim: &str) -> Option<Vec3> {
    let joints = &mapping.articulation.joints;
    let found = joints
        .iter()
        .position(|j| j.hanim.as_deref() == Some(hanim))?;
    let mut at = Some(found);
    let mut world = Affine3A::IDENTITY;
    while let Some(joint) = at {
        world = skeleton.joints[joint].rest.to_affine() * world;
        at = skeleton.joints[joint].parent;
    }
    Some(world.translation.into())
}

/// Joints that every humanoid has here; of paired joints only the left one is listed.
const EXPECTED: [&str; 7] = [
    "humanoid_root",
    "l_hip",
    "l_knee",
    "l_ankle",
    "l_shoulder",
    "l_elbow",
    "skullbase",
];

/// File, joint map, mapped joints (counted by reading the files' joint names), wrists.
const HUMANOIDS: [(&str, &str, usize, bool); 24] = [
    // Its joints have no names: 3 torso, 2 neck, 4 per leg, 3 per arm.
    ("glb/CesiumMan.glb", "shape", 19, true),
    ("glb/RiggedFigure.glb", "shape", 19, true),
    // 43 joints minus Bone and two pole targets.
    ("glb/RobotExpressive.glb", "quaternius", 40, false),
    ("glb/KayKit_Knight.glb", "kaykit", 18, true),
    ("glb/KayKit_Mage.glb", "kaykit", 18, true),
    (
        "glb/kaykit_mannequin/manny_med_mod.gltf",
        "kaykit",
        18,
        true,
    ),
    ("glb/kaykit_mannequin/Med_General.glb", "kaykit", 18, true),
    // 49, 51 joints minus Root.
    (
        "glb/Quaternius_modular_men__Casual2.glb",
        "quaternius-modular-men",
        48,
        true,
    ),
    (
        "glb/Quaternius_modular_women__Formal.glb",
        "quaternius-modular-women",
        50,
        true,
    ),
    (
        "glb/Quaternius_cyberpunk_pack__Character.glb",
        "quaternius",
        21,
        true,
    ),
    (
        "glb/Quaternius_single_knight_pack__KnightCharacter.glb",
        "quaternius",
        28,
        true,
    ),
    (
        "glb/Quaternius_platformer_game_pack__Character.glb",
        "quaternius",
        20,
        true,
    ),
    (
        "glb/Quaternius_Astronaut_Barbara_draco.glb",
        "quaternius",
        40,
        false,
    ),
    ("glb/mannequiny.glb", "unreal", 45, true),
    // 53 joints minus root.
    ("glb/viverse/mannequin.glb", "vrm-1", 52, true),
    ("glb/viverse/walk.glb", "vrm-1", 52, true),
    // 5 + 3 spine and neck, root, head, 2 eyes, 2 lids, 2 brows, jaw; per side: 3 arm, 2 collar, 19
    // fingers, 3 leg, 14 toes: 17 + 2 * 41.
    (
        "glb/mh_female_default163_arkit52.glb",
        "makehuman",
        99,
        true,
    ),
    // 31 joints minus two hip offsets and two finger bases.
    ("glb/mh_male_cmu31.glb", "cmu-bvh", 27, true),
    // 67 joints minus 13 ends.
    ("glb/pab_arnaud.glb", "pab", 54, true),
    // As many as their humanoid maps name.
    ("vrm/Godette_vrm_v4.vrm", "vrm-0", 45, true),
    ("vrm/debug_robot.vrm", "vrm-1", 53, true),
    (
        "vrm/VRMC_vrm_expressions_isBinary_Overridden.vrm",
        "vrm-1",
        22,
        true,
    ),
    ("vrm/idle_loop.vrma", "vrm-1", 22, true),
    ("vrm/test.vrma", "vrm-1", 51, true),
];

#[test]
fn every_humanoid_maps_with_its_sides() {
    if !data_is_here() {
        return;
    }
    for (name, profile, count, wrists) in HUMANOIDS {
        let (skeleton, mapping) = mapped(name);
        let articulation = &mapping.articulation;
        assert!(mapping.humanoid, "{name}");
        assert_eq!(articulation.profile, profile, "{name}");
        assert_eq!(articulation.mapped(), count, "{name}: {:?}", mapping.gaps);
        assert_eq!(articulation.joints.len(), skeleton.joints.len(), "{name}");
        let wrist = wrists.then_some("l_wrist");
        for joint in EXPECTED.into_iter().chain(wrist) {
            let right = joint.replacen("l_", "r_", 1);
            let both = [joint, &right].map(|j| position(&skeleton, &mapping, j));
            let [Some(left), Some(right)] = both else {
                panic!("{name} lacks {joint}");
            };
            // VRM 0.x characters face -Z, Cesium man faces +X (seen from his feet), others +Z.
            let to_the_left = match name {
                "vrm/Godette_vrm_v4.vrm" => Vec3::NEG_X,
                "glb/CesiumMan.glb" => Vec3::NEG_Z,
                _ => Vec3::X,
            };
            let apart = (left - right).dot(to_the_left);
            assert!(apart > 0.0 || !joint.starts_with("l_"), "{name}: {joint}");
        }
    }
}

#[test]
fn the_densest_rig_has_every_finger_and_toe() {
    if !data_is_here() {
        return;
    }
    let (skeleton, mapping) = mapped("glb/mh_female_default163_arkit52.glb");
    let joints = &mapping.articulation.joints;
    let count = |region: Region, mapped: bool| {
        let of = |j: &&_| -> bool {
            let j: &articula_core::JointArticulation = j;
            j.region == region && j.hanim.is_some() == mapped
        };
        joints.iter().filter(of).count()
    };
    assert_eq!(
        count(Region::Hands, true),
        38,
        "all fingers of the standard"
    );
    assert_eq!(count(Region::Feet, true), 28, "five toes a side");
    assert_eq!(count(Region::Hands, false) + count(Region::Feet, false), 0);
    assert_eq!(count(Region::Face, true), 7);
    let helpers = mapping
        .gaps
        .iter()
        .filter(|g| g.reason == UnmappedReason::Helper);
    assert_eq!(helpers.count(), count(Region::Face, false));
    let level_of = |name: &str| joints[skeleton.find(name).unwrap()].level;
    assert_eq!((level_of("toe2-1.L"), level_of("toe3-1.L")), (2, 5));
    assert_eq!((level_of("upperarm02.R"), level_of("tongue02")), (1, 5));
}

#[test]
fn spine_joints_take_vertebrae_in_order() {
    if !data_is_here() {
        return;
    }
    let (skeleton, mapping) = mapped("glb/mh_female_default163_arkit52.glb");
    let of = |name: &str| {
        let joint = &mapping.articulation.joints[skeleton.find(name).unwrap()];
        joint.hanim.clone().unwrap()
    };
    let spine = [
        "spine05", "spine04", "spine03", "spine02", "spine01", "neck02",
    ];
    assert_eq!(spine.map(of), ["vl5", "vl1", "vt10", "vt6", "vt1", "vc4"]);
}

#[test]
fn crossed_thumbs_go_with_their_arm() {
    if !data_is_here() {
        return;
    }
    let (skeleton, mapping) = mapped("glb/Quaternius_single_knight_pack__KnightCharacter.glb");
    let names = mapping
        .crossed
        .iter()
        .map(|&j| skeleton.joints[j].name.as_str());
    assert_eq!(
        names.collect::<Vec<_>>(),
        ["Thumb.R", "Thumb2.R", "Thumb.L", "Thumb2.L"]
    );
    let left = position(&skeleton, &mapping, "l_thumb1").unwrap();
    assert!(left.x > 0.0);
}

#[test]
fn a_hand_is_mapped_as_the_hand_it_is() {
    if !data_is_here() {
        return;
    }
    for (name, side) in [("left", "l_"), ("right", "r_")] {
        let (_, mapping) = mapped(&format!("glb/webxr_hand_{name}.glb"));
        assert!(!mapping.humanoid);
        let mut names = mapping
            .articulation
            .joints
            .iter()
            .filter_map(|j| j.hanim.as_deref());
        assert!(names.all(|n| n.starts_with(side)), "{name}");
        // 25 joints minus five tips.
        assert_eq!(mapping.articulation.mapped(), 20);
    }
}

#[test]
fn what_is_no_human_is_said_to_be_none() {
    if !data_is_here() {
        return;
    }
    for name in ["glb/Fox.glb", "glb/RiggedSimple.glb"] {
        let (skeleton, mapping) = mapped(name);
        assert!(!mapping.humanoid, "{name}");
        assert_eq!(mapping.articulation.profile, "");
        let levels = mapping.articulation.joints.iter().map(|j| j.level);
        assert_eq!(levels.clone().min(), Some(0));
        assert!(levels.max() <= Some(5));
        assert_eq!(mapping.gaps.len(), skeleton.joints.len());
    }
}

/// Names of one joint by several conventions: of Mixamo, of DAZ and Poser, of Biovision, of riggers
/// who put the part before its place, and of Blender and Godot's demo characters. `{s}` is the side
/// in the spelling of each.
const CONVENTIONS: [(&str, [&str; 5]); 24] = [
    ("humanoid_root", ["Hips", "hip", "Hips", "C_hips", "hips"]),
    ("vc4", ["Neck", "neck", "Neck", "C_neck", "neck.001"]),
    ("skullbase", ["Head", "head", "Head", "C_head", "head"]),
    (
        "{s}_sternoclavicular",
        [
            "{s}Shoulder",
            "{s}Collar",
            "{s}Collar",
            "{s}_clavicle",
            "shoulder.{s}",
        ],
    ),
    (
        "{s}_shoulder",
        [
            "{s}Arm",
            "{s}Shldr",
            "{s}Shoulder",
            "{s}_armUpper",
            "upper_arm.{s}",
        ],
    ),
    (
        "{s}_elbow",
        [
            "{s}ForeArm",
            "{s}ForeArm",
            "{s}Elbow",
            "{s}_armLower",
            "forearm.{s}",
        ],
    ),
    (
        "{s}_wrist",
        ["{s}Hand", "{s}Hand", "{s}Wrist", "{s}_hand", "hand.{s}"],
    ),
    (
        "{s}_hip",
        [
            "{s}UpLeg",
            "{s}Thigh",
            "{s}Hip",
            "{s}_legUpper",
            "thigh.{s}",
        ],
    ),
    (
        "{s}_knee",
        ["{s}Leg", "{s}Shin", "{s}Knee", "{s}_legLower", "shin.{s}"],
    ),
    (
        "{s}_ankle",
        ["{s}Foot", "{s}Foot", "{s}Ankle", "{s}_foot", "foot.{s}"],
    ),
    (
        "{s}_metatarsal",
        ["{s}ToeBase", "{s}Toe", "{s}Toes", "{s}_ball", "toe.{s}"],
    ),
    (
        "{s}_thumb1",
        [
            "{s}HandThumb1",
            "{s}Thumb1",
            "{s}FingerThumb1",
            "{s}_thumb01",
            "thumb.01.{s}",
        ],
    ),
    (
        "{s}_thumb2",
        [
            "{s}HandThumb2",
            "{s}Thumb2",
            "{s}FingerThumb2",
            "{s}_thumb02",
            "thumb.02.{s}",
        ],
    ),
    (
        "{s}_thumb3",
        [
            "{s}HandThumb3",
            "{s}Thumb3",
            "{s}FingerThumb3",
            "{s}_thumb03",
            "thumb.03.{s}",
        ],
    ),
    (
        "{s}_index1",
        [
            "{s}HandIndex1",
            "{s}Index1",
            "{s}FingerIndex1",
            "{s}_index01",
            "f_index.01.{s}",
        ],
    ),
    (
        "{s}_index2",
        [
            "{s}HandIndex2",
            "{s}Index2",
            "{s}FingerIndex2",
            "{s}_index02",
            "f_index.02.{s}",
        ],
    ),
    (
        "{s}_index3",
        [
            "{s}HandIndex3",
            "{s}Index3",
            "{s}FingerIndex3",
            "{s}_index03",
            "f_index.03.{s}",
        ],
    ),
    (
        "{s}_middle1",
        [
            "{s}HandMiddle1",
            "{s}Mid1",
            "{s}FingerMiddle1",
            "{s}_middle01",
            "f_middle.01.{s}",
        ],
    ),
    (
        "{s}_middle2",
        [
            "{s}HandMiddle2",
            "{s}Mid2",
            "{s}FingerMiddle2",
            "{s}_middle02",
            "f_middle.02.{s}",
        ],
    ),
    (
        "{s}_middle3",
        [
            "{s}HandMiddle3",
            "{s}Mid3",
            "{s}FingerMiddle3",
            "{s}_middle03",
            "f_middle.03.{s}",
        ],
    ),
    (
        "{s}_ring1",
        [
            "{s}HandRing1",
            "{s}Ring1",
            "{s}FingerRing1",
            "{s}_ring01",
            "f_ring.01.{s}",
        ],
    ),
    (
        "{s}_ring2",
        [
            "{s}HandRing2",
            "{s}Ring2",
            "{s}FingerRing2",
            "{s}_ring02",
            "f_ring.02.{s}",
        ],
    ),
    (
        "{s}_pinky1",
        [
            "{s}HandPinky1",
            "{s}Pinky1",
            "{s}FingerPinky1",
            "{s}_little01",
            "f_pinky.01.{s}",
        ],
    ),
    (
        "{s}_pinky2",
        [
            "{s}HandPinky2",
            "{s}Pinky2",
            "{s}FingerPinky2",
            "{s}_little02",
            "f_pinky.02.{s}",
        ],
    ),
];

/// Characters with different rigs.
const RENAMED: [&str; 5] = [
    "glb/pab_arnaud.glb",
    "glb/mannequiny.glb",
    "glb/KayKit_Knight.glb",
    "glb/mh_male_cmu31.glb",
    "glb/CesiumMan.glb",
];

const LEFT_AND_RIGHT: [[&str; 2]; 5] = [
    ["Left", "Right"],
    ["l", "r"],
    ["Left", "Right"],
    ["L", "R"],
    ["L", "R"],
];

/// The name of a joint of the standard by a convention.
fn name_by(convention: usize, hanim: &str) -> Option<String> {
    let sides = ["l", "r"].iter().zip(LEFT_AND_RIGHT[convention]);
    let named = |(side, spelled): (&&str, &str)| {
        let row = CONVENTIONS
            .iter()
            .find(|(joint, _)| joint.replace("{s}", side) == hanim)?;
        Some(row.1[convention].replace("{s}", spelled))
    };
    sides
        .filter_map(|(side, spelled)| named((side, spelled)))
        .next()
}

/// Renames the joints of a mapped rig, with one convention for each joint, and compares the mappings.
fn renamed_maps_alike(
    name: &str,
    (skeleton, before): &(Skeleton, JointMapping),
    convention: impl Fn(usize) -> usize,
    suffix: &str,
) {
    let mut skeleton = skeleton.clone();
    let joints = &before.articulation.joints;
    let mut renamed = Vec::new();
    for (index, joint) in skeleton.joints.iter_mut().enumerate() {
        let hanim = joints[index].hanim.as_deref();
        let own = hanim.and_then(|hanim| name_by(convention(index), hanim));
        if own.is_some() {
            renamed.push(index);
        }
        let own = own.unwrap_or_else(|| "prop".to_owned());
        joint.name = suffix
            .replace("{n}", &own)
            .replace("{i}", &format!("{index:03}"));
    }
    let after = articula_build::joint_names::map(&skeleton, joint_map::builtin(), None);
    assert!(renamed.len() > 12, "{name}: {}", renamed.len());
    for index in renamed {
        assert_eq!(
            after.articulation.joints[index].hanim, joints[index].hanim,
            "{name}: {}, by {}",
            skeleton.joints[index].name, after.articulation.profile
        );
    }
}

#[test]
fn rigs_renamed_by_a_convention_or_two_map_as_before() {
    if !data_is_here() {
        return;
    }
    for name in RENAMED {
        let mapped = mapped(name);
        for suffix in ["{n}", "Character1_{n}", "rig:{n}_{i}", "{n}{i}_bind_JNT"] {
            for one in 0..5 {
                renamed_maps_alike(name, &mapped, |_| one, suffix);
                for two in 0..one {
                    // Mixed as an artist mixes: the limbs of one rig, the trunk of another.
                    let mixed = |j| if j % 3 == 0 { one } else { two };
                    renamed_maps_alike(name, &mapped, mixed, suffix);
                }
            }
        }
    }
}
