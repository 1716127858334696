//! Files as they come from elsewhere, made from those of the data: other zero poses, names and sizes,
//! hands without a body.

use articula::CharacterFile;
use articula_core::source::{
    Channel, Character, Interpolation, Property, RawClip, Skeleton, evaluate,
};
use articula_core::{LocalPose, Transform};
use glam::{Affine3A, Mat4, Quat};

/// How the files of a case differ from those of the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Variant {
    AsRead,
    /// Every joint of the motion's figure has a random rotation at rest; it moves as before.
    ZeroPose(u32),
    /// Joints of the motion have the names of DAZ and Poser; those without are gone.
    DazNames,
    /// The motion has hands alone.
    HandsAlone,
    /// The figure of the motion is larger by this factor.
    Scaled(f32),
    /// Both rigs have names that tell nothing; the character is half as large, with other axes.
    UnknownNames,
}

/// Names of DAZ and Poser; `{s}` is the side.
const DAZ: [(&str, &str); 22] = [
    ("humanoid_root", "hip"),
    ("vl5", "abdomen"),
    ("vt10", "chest"),
    ("vc4", "neck"),
    ("skullbase", "head"),
    ("sternoclavicular", "{s}Collar"),
    ("shoulder", "{s}Shldr"),
    ("elbow", "{s}ForeArm"),
    ("wrist", "{s}Hand"),
    ("thumb1", "{s}Thumb1"),
    ("thumb2", "{s}Thumb2"),
    ("thumb3", "{s}Thumb3"),
    ("index1", "{s}Index1"),
    ("index2", "{s}Index2"),
    ("index3", "{s}Index3"),
    ("middle1", "{s}Mid1"),
    ("ring1", "{s}Ring1"),
    ("pinky1", "{s}Pinky1"),
    ("hip", "{s}Thigh"),
    ("knee", "{s}Shin"),
    ("ankle", "{s}Foot"),
    ("metatarsal", "{s}Toe"),
];

impl Variant {
    /// The motion and the character of a case.
    pub(super) fn apply(
        self,
        source: CharacterFile,
        target: CharacterFile,
    ) -> (CharacterFile, CharacterFile) {
        match self {
            Self::AsRead => (source, target),
            Self::ZeroPose(seed) => (with_zero_pose(source, seed), target),
            Self::DazNames => (with_daz_names(&source), target),
            Self::HandsAlone => (hands(&source), target),
            Self::Scaled(factor) => (scaled(source, factor), target),
            Self::UnknownNames => {
                let target = scaled(with_axes(target), 0.5);
                (without_names(source), without_names(target))
            }
        }
    }
}

/// A rotation for a number and a seed, any equally likely enough for a zero pose.
fn rotation(index: usize, seed: u32) -> Quat {
    let at = index as f32 + 100.0 * seed as f32;
    let part = |frequency: f32| (frequency * (at + 1.0)).sin();
    Quat::from_xyzw(part(1.7), part(2.9), part(4.3), part(5.9)).normalize()
}

/// The same world motion with another rest rotation of every joint.
fn with_zero_pose(mut file: CharacterFile, seed: u32) -> CharacterFile {
    file.edit_character(|character| turn_rest(character, seed));
    file
}

fn turn_rest(character: &mut Character, seed: u32) {
    let joints = &mut character.skeleton.joints;
    for clip in &mut character.clips {
        for (j, joint) in joints.iter().enumerate() {
            let is_own = |c: &Channel| c.target == j && c.property == Property::Rotation;
            if !clip.channels.iter().any(is_own) {
                let values = joint.rest.rotation.to_array().to_vec();
                clip.channels.push(rotation_channel(j, vec![0.0], values));
            }
        }
    }
    for (j, joint) in joints.iter_mut().enumerate() {
        joint.rest.rotation = rotation(j, seed);
    }
}

fn rotation_channel(target: usize, times_secs: Vec<f32>, values: Vec<f32>) -> Channel {
    Channel {
        target,
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times_secs,
        values,
    }
}

/// Other axes of every joint, at rest in the same places. Meshes, whose binding would have to follow,
/// are left out.
fn with_axes(mut file: CharacterFile) -> CharacterFile {
    file.edit_character(turn_axes);
    file
}

fn turn_axes(character: &mut Character) {
    let joints = &mut character.skeleton.joints;
    let parents: Vec<Option<usize>> = joints.iter().map(|j| j.parent).collect();
    for (j, joint) in joints.iter_mut().enumerate() {
        let above = parents[j].map_or(Quat::IDENTITY, |p| rotation(p, 7).inverse());
        joint.rest.rotation = above * joint.rest.rotation * rotation(j, 7);
        joint.rest.translation = above * joint.rest.translation;
    }
    character.clips.clear();
    character.meshes.clear();
}

fn with_daz_names(file: &CharacterFile) -> CharacterFile {
    let known = file.articulation().joints;
    let mut character = file.character().clone();
    character.articulation = None;
    for (joint, known) in character.skeleton.joints.iter_mut().zip(known) {
        let hanim = known.hanim.unwrap_or_default();
        let (side, bare) = match hanim.split_at_checked(2) {
            Some(("l_", bare)) => ("l", bare),
            Some(("r_", bare)) => ("r", bare),
            _ => ("", hanim.as_str()),
        };
        let is_bare =
            |(name, daz): &&(&str, &str)| *name == bare && daz.contains('{') != side.is_empty();
        let found = DAZ.iter().find(is_bare);
        joint.name = match found {
            Some((_, daz)) => daz.replace("{s}", side),
            None => String::new(),
        };
    }
    CharacterFile::from_character(file.name(), character)
}

fn without_names(file: CharacterFile) -> CharacterFile {
    let name = file.name().to_owned();
    let mut character = file.into_character();
    character.articulation = None;
    for (j, joint) in character.skeleton.joints.iter_mut().enumerate() {
        joint.name = format!("part {j}");
    }
    CharacterFile::from_character(&name, character)
}

fn scaled(mut file: CharacterFile, factor: f32) -> CharacterFile {
    file.edit_character(|character| {
        for joint in &mut character.skeleton.joints {
            joint.rest.translation *= factor;
        }
        let channels = character.clips.iter_mut().flat_map(|c| &mut c.channels);
        for channel in channels.filter(|c| c.property == Property::Translation) {
            channel.values.iter_mut().for_each(|v| *v *= factor);
        }
    });
    file
}

/// The wrists and fingers of a figure with their motion, and nothing else.
fn hands(file: &CharacterFile) -> CharacterFile {
    let known = file.articulation().joints;
    let parts = ["wrist", "thumb", "index", "middle", "ring", "pinky"];
    let is_of_hand = |j: usize| {
        let name = known[j].hanim.as_deref().and_then(|name| name.get(2..));
        name.is_some_and(|name| parts.iter().any(|part| name.starts_with(part)))
    };
    let old = &file.character().skeleton;
    let mut skeleton = Skeleton::default();
    let mut kept: Vec<(usize, Option<usize>)> = Vec::new();
    for j in (0..old.joints.len()).filter(|j| is_of_hand(*j)) {
        let mut above = old.joints[j].parent;
        while let Some(p) = above.filter(|p| !is_of_hand(*p)) {
            above = old.joints[p].parent;
        }
        let parent = above.and_then(|above| kept.iter().position(|k| k.0 == above));
        let mut joint = old.joints[j].clone();
        joint.parent = parent;
        skeleton.joints.push(joint);
        kept.push((j, above));
    }
    let local = |model: &[Affine3A], (j, above): (usize, Option<usize>)| {
        let matrix = above.map_or(model[j], |above| model[above].inverse() * model[j]);
        Transform::from_matrix(Mat4::from(matrix)).unwrap_or(Transform::IDENTITY)
    };
    let still = models(old, &RawClip::default(), &[0.0]).swap_remove(0);
    for (joint, of) in skeleton.joints.iter_mut().zip(&kept) {
        joint.rest = local(&still, *of);
    }
    let cut = |clip: &RawClip| {
        let rate = articula_build::source_rate_hz(clip);
        let steps = (clip.duration_secs * rate).round() as usize;
        let times: Vec<f32> = (0..=steps).map(|i| i as f32 / rate).collect();
        let poses = models(old, clip, &times);
        let channel = |(i, of): (usize, &(usize, Option<usize>))| {
            let keys = poses
                .iter()
                .flat_map(|model| local(model, *of).rotation.to_array());
            rotation_channel(i, times.clone(), keys.collect())
        };
        RawClip {
            name: clip.name.clone(),
            duration_secs: clip.duration_secs,
            channels: kept.iter().enumerate().map(channel).collect(),
        }
    };
    let character = Character {
        clips: file.character().clips.iter().map(cut).collect(),
        skeleton,
        ..Character::default()
    };
    CharacterFile::from_character(file.name(), character)
}

/// Model-space matrices at some times.
fn models(skeleton: &Skeleton, clip: &RawClip, times: &[f32]) -> Vec<Vec<Affine3A>> {
    let mut local: LocalPose = skeleton.joints.iter().map(|j| j.rest).collect();
    let model = |time: &f32| {
        evaluate::pose(clip, skeleton, *time, &mut local);
        let mut model: Vec<Affine3A> = Vec::with_capacity(skeleton.joints.len());
        for (j, joint) in skeleton.joints.iter().enumerate() {
            let own = local.get(j).to_affine();
            model.push(joint.parent.map_or(own, |p| model[p] * own));
        }
        model
    };
    times.iter().map(model).collect()
}
