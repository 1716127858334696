//! Motions of real files, retargeted alike whatever axes and zero pose their joints have.

use crate::real::real_data;
use articula::convert::{FittedClip, fit_clips};
use articula::glam::{Affine3A, Quat, Vec3};
use articula::{AddClipsOptions, CharacterFile, fs};
use articula_build::retarget::{ContactPinning, RestPose};
use articula_build::source_rate_hz;
use articula_core::source::{
    Channel, Character, Interpolation, Joint, Property, RawClip, evaluate,
};
use articula_core::{LocalPose, angle_between};
use articula_mutate::Dice;
use std::path::Path;
use std::sync::OnceLock;

/// Motions, with the name of a clip where the file has several, and the characters that they are
/// retargeted onto.
const PAIRS: [(&str, &str, &str); 12] = [
    (
        "bvh/cmu_12_01_walk.bvh",
        "",
        "glb/Quaternius_modular_men__Casual2.glb",
    ),
    ("bvh/fair1_dab.bvh", "", "glb/mh_male_cmu31.glb"),
    ("bvh/fair1_zombie.bvh", "", "vrm/Godette_vrm_v4.vrm"),
    ("bvh/fair1_jumping.bvh", "", "glb/pab_arnaud.glb"),
    ("bvh/makehuman_walk1.bvh", "", "glb/CesiumMan.glb"),
    (
        "bvh/dance_fingers.bvh",
        "",
        "glb/mh_female_default163_arkit52.glb",
    ),
    ("bvh/cmu_01_01.amc", "", "glb/KayKit_Knight.glb"),
    (
        "glb/pab_arnaud.glb",
        "walk",
        "glb/Quaternius_modular_women__Casual.glb",
    ),
    (
        "glb/kaykit_mannequin/Med_MovementBasic.glb",
        "Rig_Medium|Walking_A",
        "vrm/Godette_vrm_v4.vrm",
    ),
    ("glb/mannequiny.glb", "", "glb/mh_male_cmu31.glb"),
    ("glb/mh_female_dance.glb", "", "glb/pab_arnaud.glb"),
    ("vrm/idle_loop.vrma", "", "glb/KayKit_Knight.glb"),
];

/// Seconds of a motion that are compared, from its middle.
const SECS: f32 = 4.0;

/// The motions and characters of all pairs, opened once.
fn opened(data: &Path) -> &'static [(CharacterFile, CharacterFile)] {
    static OPENED: OnceLock<Vec<(CharacterFile, CharacterFile)>> = OnceLock::new();
    OPENED.get_or_init(|| {
        let open = |(file, clip, onto)| {
            let character = fs::open(data.join(onto)).unwrap();
            (motion(data, file, clip), character)
        };
        PAIRS.into_iter().map(open).collect()
    })
}

/// A random rotation, each direction of its four numbers equally likely.
fn rotation(dice: &mut Dice) -> Quat {
    loop {
        let numbers = [(); 4].map(|()| dice.roll(2001) as f32 / 1000.0 - 1.0);
        let length = numbers.iter().map(|n| n * n).sum::<f32>();
        if (0.05..=1.0).contains(&length) {
            return Quat::from_array(numbers).normalize();
        }
    }
}

/// The motion of a pair as the only clip of its file.
fn motion(data: &Path, file: &str, wanted: &str) -> CharacterFile {
    let mut opened = fs::open(data.join(file)).unwrap();
    let clips = opened.clips_mut();
    let index = clips
        .iter()
        .position(|c| wanted.is_empty() || c.name == wanted);
    let mut clip = clips.swap_remove(index.unwrap());
    cut(&mut clip);
    *clips = vec![clip];
    opened
}

/// Keeps a few seconds of the middle of a clip.
fn cut(clip: &mut RawClip) {
    if clip.duration_secs <= SECS {
        return;
    }
    let rate = source_rate_hz(clip);
    let start = (0.5 * (clip.duration_secs - SECS) * rate).round() / rate;
    let end = start + SECS;
    for channel in &mut clip.channels {
        let first = channel.times_secs.partition_point(|t| *t < start - 1e-4);
        let first = first.min(channel.times_secs.len() - 1);
        let last = channel
            .times_secs
            .partition_point(|t| *t <= end + 1e-4)
            .max(first + 1);
        let width = channel.values.len() / channel.times_secs.len();
        channel.values = channel.values[first * width..last * width].to_vec();
        channel.times_secs = channel.times_secs[first..last].to_vec();
        for time in &mut channel.times_secs {
            *time = (*time - start).max(0.0);
        }
    }
    clip.duration_secs = SECS;
}

/// The same world motion with other axes of every joint.
fn with_axes(file: &CharacterFile, dice: &mut Dice) -> CharacterFile {
    let mut new = file.clone();
    new.edit_character(|character| turn_axes(character, dice));
    new
}

fn turn_axes(character: &mut Character, dice: &mut Dice) {
    let skeleton = &mut character.skeleton;
    let axes: Vec<Quat> = skeleton.joints.iter().map(|_| rotation(dice)).collect();
    let parents: Vec<Option<usize>> = skeleton.joints.iter().map(|j| j.parent).collect();
    let above = |j: usize| parents[j].map_or(Quat::IDENTITY, |p| axes[p].inverse());
    for (j, joint) in skeleton.joints.iter_mut().enumerate() {
        joint.rest.rotation = above(j) * joint.rest.rotation * axes[j];
        joint.rest.translation = above(j) * joint.rest.translation;
    }
    for channel in character.clips.iter_mut().flat_map(|c| &mut c.channels) {
        let j = channel.target;
        match channel.property {
            Property::Rotation => {
                for key in channel.values.chunks_exact_mut(4) {
                    let turned = above(j) * Quat::from_slice(key) * axes[j];
                    key.copy_from_slice(&turned.to_array());
                }
            }
            Property::Translation => {
                for key in channel.values.chunks_exact_mut(3) {
                    key.copy_from_slice(&(above(j) * Vec3::from_slice(key)).to_array());
                }
            }
            _ => {}
        }
    }
}

/// The same world motion with another rest rotation of every joint.
fn with_zero_pose(file: &CharacterFile, dice: &mut Dice) -> CharacterFile {
    let mut new = file.clone();
    new.edit_character(|character| turn_rest(character, dice));
    new
}

fn turn_rest(character: &mut Character, dice: &mut Dice) {
    let joints = &mut character.skeleton.joints;
    for clip in &mut character.clips {
        for (j, joint) in joints.iter().enumerate() {
            let is_own = |c: &Channel| c.target == j && c.property == Property::Rotation;
            if !clip.channels.iter().any(is_own) {
                clip.channels.push(Channel {
                    target: j,
                    property: Property::Rotation,
                    interpolation: Interpolation::Linear,
                    times_secs: vec![0.0],
                    values: joint.rest.rotation.to_array().to_vec(),
                });
            }
        }
    }
    for joint in joints {
        joint.rest.rotation = rotation(dice);
    }
}

fn fitted(from: &CharacterFile, onto: &CharacterFile, pinning: ContactPinning) -> FittedClip {
    let mut options = AddClipsOptions {
        by_names: false,
        ..AddClipsOptions::default()
    };
    options.retarget.pinning = pinning;
    fit_clips(from, onto, &options).unwrap().remove(0)
}

/// Model-from-joint matrices of a clip at some times.
fn poses(file: &CharacterFile, clip: &RawClip) -> Vec<Vec<Affine3A>> {
    let skeleton = &file.character().skeleton;
    let mut local: LocalPose = skeleton.joints.iter().map(|j| j.rest).collect();
    (0..24)
        .map(|i| {
            evaluate::pose(
                clip,
                skeleton,
                clip.duration_secs * i as f32 / 23.0,
                &mut local,
            );
            let mut model: Vec<Affine3A> = Vec::new();
            for (j, joint) in skeleton.joints.iter().enumerate() {
                let own = local.get(j).to_affine();
                model.push(joint.parent.map_or(own, |p| model[p] * own));
            }
            model
        })
        .collect()
}

/// A bone of a character: its joint, the joint at its end, and both H-Anim names.
struct Bone {
    joint: usize,
    end: usize,
    names: [String; 2],
}

/// The bones between mapped joints.
fn bones(file: &CharacterFile) -> Vec<Bone> {
    let mapped = file.articulation().joints;
    let name = |j: usize| mapped[j].hanim.clone();
    let joints = file.character().skeleton.joints.iter().enumerate();
    let bone = |(end, joint): (usize, &Joint)| {
        let above = joint.parent?;
        Some(Bone {
            joint: above,
            end,
            names: [name(above)?, name(end)?],
        })
    };
    joints.filter_map(bone).collect()
}

/// Maximum angle between the directions of a bone in two motions, degrees.
fn turned(bone: &Bone, a: &[Vec<Affine3A>], b: &[Vec<Affine3A>]) -> f32 {
    let way = |pose: &Vec<Affine3A>| {
        let way = pose[bone.end].translation - pose[bone.joint].translation;
        Vec3::from(way).normalize_or_zero()
    };
    let angles = a.iter().zip(b).map(|(a, b)| match (way(a), way(b)) {
        (Vec3::ZERO, _) | (_, Vec3::ZERO) => 0.0,
        (a, b) => a.angle_between(b).to_degrees(),
    });
    angles.fold(0.0, f32::max)
}

/// How far the direction of a bone may be off where the rest pose is unknown, degrees.
fn limit(bone: &Bone, motion: &str, assumed: &[String]) -> f32 {
    let [from, to] = bone.names.each_ref().map(|n| n.get(2..).unwrap_or(""));
    let side = &bone.names[0][..2];
    let fingers = ["thumb", "index", "middle", "ring", "pinky"];
    match from {
        "shoulder" | "elbow" | "hip" | "knee" => 1.0,
        // A hand whose turn no finger shows may be turned about the forearm.
        "wrist" if assumed.contains(&format!("{side}wrist")) => 180.0,
        _ if fingers.iter().any(|f| from.starts_with(f)) => {
            if assumed.contains(&format!("{side}wrist")) {
                180.0
            } else {
                2.0
            }
        }
        "wrist" => 2.5,
        // MakeHuman's walk never sets its feet down flat; at rest they slope by 30 degrees.
        "ankle" if motion.starts_with("bvh/makehuman") => 20.0,
        "ankle" => 4.0,
        _ if to.contains("tars") => 4.0,
        "sternoclavicular" | "acromioclavicular" => 20.0,
        _ => 18.0,
    }
}

#[test]
fn limbs_move_alike_whatever_the_zero_pose_is() {
    let Some(data) = real_data() else { return };
    for (i, (file, _, onto)) in PAIRS.into_iter().enumerate() {
        let (from, character) = &opened(&data)[i];
        let mut dice = Dice::new(i as u64 + 1);
        let other = with_zero_pose(&with_axes(from, &mut dice), &mut dice);
        let was = fitted(from, character, ContactPinning::Nothing);
        let is = fitted(&other, character, ContactPinning::Nothing);
        let (a, b) = (poses(character, &was.clip), poses(character, &is.clip));
        let report = is.fit.retargeted.unwrap();
        let RestPose::Found { assumed } = report.source_rest else {
            panic!("{file}: a random pose counts as standing");
        };
        assert_eq!(
            was.fit.retargeted.unwrap().source_rest,
            RestPose::OfFile,
            "{file}"
        );
        let names = from.articulation().joints;
        let assumed: Vec<String> = assumed
            .iter()
            .filter_map(|(joint, _)| names[*joint].hanim.clone())
            .collect();
        for bone in bones(character) {
            let off = turned(&bone, &a, &b);
            let [from, to] = &bone.names;
            let most = limit(&bone, file, &assumed);
            assert!(
                off <= most,
                "{file} onto {onto}: {from} to {to} is off by {off} degrees"
            );
        }
    }
}

#[test]
fn the_zero_pose_of_the_character_does_not_matter() {
    let Some(data) = real_data() else { return };
    for (i, (file, _, onto)) in PAIRS.into_iter().enumerate() {
        let (from, character) = &opened(&data)[i];
        // Without a motion there is nothing to learn from, and a figure whose rest pose is unknown
        // faces +Z, as CesiumMan does not.
        if character.character().clips.is_empty() || onto.contains("Cesium") {
            continue;
        }
        let mut dice = Dice::new(100 + i as u64);
        let other = with_zero_pose(&with_axes(character, &mut dice), &mut dice);
        let was = fitted(from, character, ContactPinning::Nothing);
        let is = fitted(from, &other, ContactPinning::Nothing);
        let (a, b) = (poses(character, &was.clip), poses(&other, &is.clip));
        let report = is.fit.retargeted.unwrap();
        assert!(
            matches!(report.target_rest, RestPose::Found { .. }),
            "{onto}"
        );
        for bone in bones(character) {
            let off = turned(&bone, &a, &b);
            let [from, to] = &bone.names;
            // The offset between the two joints of the pelvis moves nothing.
            if to == "sacroiliac" {
                continue;
            }
            let limb = matches!(&from[2..], "shoulder" | "elbow" | "hip" | "knee");
            let most = if limb { 1.0 } else { 45.0 };
            assert!(
                off <= most,
                "{file} onto {onto}: {from} to {to} is off by {off} degrees"
            );
        }
    }
}

#[test]
fn axes_of_joints_do_not_matter() {
    let Some(data) = real_data() else { return };
    for (i, (file, _, onto)) in PAIRS.into_iter().enumerate() {
        let (from, character) = &opened(&data)[i];
        let other = with_axes(from, &mut Dice::new(200 + i as u64));
        let [a, b] = [from, &other].map(|from| {
            let made = fitted(from, character, ContactPinning::Feet);
            poses(character, &made.clip)
        });
        let named = character.articulation().joints;
        for (a, b) in a.iter().flatten().zip(b.iter().flatten()) {
            let [a, b] = [a, b].map(|m| m.to_scale_rotation_translation().1);
            assert!(angle_between(a, b).to_degrees() < 1.0, "{file} onto {onto}");
        }
        let soles = (0..named.len()).filter(|j| {
            let name = named[*j].hanim.as_deref().unwrap_or_default();
            name.ends_with("ankle") || name.ends_with("metatarsal")
        });
        for sole in soles {
            for (a, b) in a.iter().zip(&b) {
                let away = a[sole].translation.distance(b[sole].translation);
                assert!(away < 2e-3, "{file} onto {onto}: {away} m");
            }
        }
    }
}
