//! Differences between two readings of one character: joints over the clips, skin in some poses.

use anyhow::{Context, Result};
use articula_build::source_rate_hz;
use articula_core::source::{Character, Joint, Property, RawClip, evaluate};
use articula_core::{
    Articulation, JointArticulation, LocalPose, Mesh, ModelPose, PosedMesh, Rig, SkinnedMesh,
    local_to_model,
};
use std::collections::{HashMap, VecDeque};

/// Maximum number of frames of a clip whose joints are compared, spread evenly.
const FRAMES: usize = 500;
/// Number of frames of a clip whose skin is compared.
const SKINNED: usize = 5;

/// Differences between two characters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Apart {
    /// Number of joints compared, by name.
    pub(super) joints: usize,
    /// Number of clips compared, by order.
    pub(super) clips: usize,
    /// Maximum distance of a joint, millimetres.
    pub(super) joints_mm: f32,
    /// Maximum distance of a vertex, millimetres; `None` if a side has no vertices.
    pub(super) skin_mm: Option<f32>,
}

/// The joints that are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JointFilter {
    All,
    /// Joints of skins; all joints where there is no skin.
    Skin,
    /// Joints that correspond to one of the standard, matched by it; skins are not compared, since
    /// the vertices are in another order.
    Twins,
}

/// Compares a character with its written and read copy; at rest where there are no clips.
pub(super) fn apart(
    was: (&Character, &Articulation),
    is: (&Character, &Articulation),
    kept: JointFilter,
) -> Result<Apart> {
    let mut was = Side::new(was)?;
    let mut is = Side::new(is)?;
    let pairs = pairs(&was, &is, kept);
    let clips = was.character.clips.len().min(is.character.clips.len());
    let same_order = kept != JointFilter::Twins && was.mesh.len() == is.mesh.len();
    let skinned = same_order && !was.mesh.is_empty();
    let mut apart = Apart {
        joints: pairs.len(),
        clips,
        joints_mm: 0.0,
        skin_mm: skinned.then_some(0.0),
    };
    for c in 0..clips.max(1) {
        let clip = was.character.clips.get(c);
        let times = clip.map_or_else(|| vec![0.0], times);
        let stride = times.len().div_ceil(SKINNED);
        for (i, time) in times.iter().enumerate() {
            was.pose(c, *time);
            is.pose(c, *time);
            for (a, b) in &pairs {
                let far = was.model.position(*a).distance(is.model.position(*b));
                apart.joints_mm = apart.joints_mm.max(1000.0 * far);
            }
            if let Some(worst) = &mut apart.skin_mm
                && i % stride == 0
            {
                was.skin();
                is.skin();
                let points = was.skinned.positions.iter().zip(&is.skinned.positions);
                let far = points.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
                *worst = worst.max(1000.0 * far);
            }
        }
    }
    Ok(apart)
}

/// Times of the compared frames, on the clip's own grid, where nothing is interpolated.
fn times(clip: &RawClip) -> Vec<f32> {
    let rate = source_rate_hz(clip);
    let last = (clip.duration_secs * rate).round() as usize;
    let step = (last + 1).div_ceil(FRAMES);
    (0..=last).step_by(step).map(|f| f as f32 / rate).collect()
}

/// Pairs of joints with the same name, or that are the same joint of the standard, whichever are
/// more: joints whose names tell nothing are written under the names of the standard.
fn pairs(was: &Side<'_>, is: &Side<'_>, kept: JointFilter) -> Vec<(usize, usize)> {
    let of_standard = twins(was, is);
    if kept == JointFilter::Twins {
        return of_standard;
    }
    let named = of_one_name(was, is, kept);
    if of_standard.len() > named.len() {
        of_standard
    } else {
        named
    }
}

/// Pairs of joints with the same name, those with one name in their order. Some formats call the
/// first joint `root` whatever its name was.
fn of_one_name(was: &Side<'_>, is: &Side<'_>, kept: JointFilter) -> Vec<(usize, usize)> {
    let mut known: HashMap<String, VecDeque<usize>> = HashMap::new();
    for (j, joint) in is.character.skeleton.joints.iter().enumerate() {
        known.entry(plain(&joint.name, j)).or_default().push_back(j);
    }
    let joints = &was.character.skeleton.joints;
    let any_skin = joints.iter().any(|j| j.in_skin);
    let counts = |j: &Joint| kept == JointFilter::All || j.in_skin || !any_skin;
    let first = joints.iter().position(counts);
    let counted = joints.iter().enumerate().filter(|(_, j)| counts(j));
    let pair = |(j, joint): (usize, &Joint)| {
        let mut take = |name: &str| known.get_mut(name)?.pop_front();
        let root = || (first == Some(j)).then_some("root");
        let twin = take(&plain(&joint.name, j)).or_else(|| take(root()?));
        Some((j, twin?))
    };
    counted.filter_map(pair).collect()
}

/// Pairs of joints that correspond to the same joint of the standard.
fn twins(was: &Side<'_>, is: &Side<'_>) -> Vec<(usize, usize)> {
    let is = &is.rig.articulation().joints;
    let was = was.rig.articulation().joints.iter().enumerate();
    let pair = |(j, joint): (usize, &JointArticulation)| {
        let name = joint.hanim.as_ref()?;
        let twin = is
            .iter()
            .position(|other| other.hanim.as_ref() == Some(name));
        Some((j, twin?))
    };
    was.filter_map(pair).collect()
}

/// A name in the form of formats that allow no blanks.
fn plain(name: &str, joint: usize) -> String {
    if name.trim().is_empty() {
        return format!("joint_{joint}");
    }
    let odd = |c: char| !c.is_alphanumeric();
    name.trim().replace(odd, "_")
}

/// One of the two characters, in a pose.
struct Side<'a> {
    character: &'a Character,
    rig: Rig,
    mesh: Mesh,
    local: LocalPose,
    model: ModelPose,
    morphs: Vec<f32>,
    skinned: SkinnedMesh,
}

impl<'a> Side<'a> {
    fn new((character, articulation): (&'a Character, &Articulation)) -> Result<Self> {
        let rig = Rig::new(&character.skeleton, articulation.clone()).context("rig")?;
        let mesh = Mesh::new(&character.meshes, rig.len()).context("mesh")?;
        Ok(Self {
            character,
            local: rig.rest_pose().clone(),
            model: ModelPose::new(rig.len()),
            morphs: mesh.morph_weights.clone(),
            skinned: SkinnedMesh::new(&mesh),
            mesh,
            rig,
        })
    }

    /// Applies the pose of a clip at a time, or the rest pose if there is no such clip.
    fn pose(&mut self, clip: usize, time_secs: f32) {
        if let Some(clip) = self.character.clips.get(clip) {
            evaluate::pose(clip, &self.character.skeleton, time_secs, &mut self.local);
            self.morphs.clone_from(&self.mesh.morph_weights);
            let weights = clip.channels.iter();
            for channel in weights.filter(|c| c.property == Property::Weights) {
                let first = self.mesh.morph_slots[channel.target];
                let count = self.character.meshes[channel.target].morph_weights.len();
                let weights = &mut self.morphs[first..first + count];
                evaluate::channel(channel, time_secs, weights);
            }
        }
        local_to_model(&self.rig, &self.local, &mut self.model);
    }

    fn skin(&mut self) {
        let mut posed = PosedMesh::new(&self.rig, &self.mesh);
        posed.model.clone_from(&self.model);
        posed.skin(&self.morphs, &mut self.skinned);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_formats::joint_map;
    use glam::Vec3;

    fn two(name: &str, up: f32) -> Character {
        let joint = |name: &str, parent, y| Joint {
            name: name.into(),
            parent,
            rest: Transform {
                translation: Vec3::Y * y,
                ..Transform::IDENTITY
            },
            in_skin: true,
        };
        let mut character = Character::default();
        character.skeleton.joints = vec![joint("a", None, 0.0), joint(name, Some(0), up)];
        character
    }

    #[test]
    fn two_millimetres_are_two_millimetres() {
        let (was, is) = (two("b c", 1.0), two("b_c", 1.002));
        let map = |c: &Character| {
            articula_build::joint_names::map(&c.skeleton, joint_map::builtin(), None).articulation
        };
        let found = apart((&was, &map(&was)), (&is, &map(&is)), JointFilter::All).unwrap();
        assert_eq!((found.joints, found.clips, found.skin_mm), (2, 0, None));
        assert!((found.joints_mm - 2.0).abs() < 1e-3, "{found:?}");
    }
}
