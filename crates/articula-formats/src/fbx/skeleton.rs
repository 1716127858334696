//! Which nodes are joints, and their rest pose.
//!
//! Joints are bones and what clusters name; where a file has neither, nodes without content that move or are
//! above one that moves. Nodes above a joint, with a mesh, or that move are kept beside them. The rest pose is
//! the one in which the clusters were bound: many files store the pose of their first frame instead.

use super::scene::{Local, Node, Scene};
use super::source::Reader;
use super::takes::Take;
use crate::error::ReadError;
use articula_core::source::{Joint, Skeleton};
use articula_core::{Transform, angle_between};
use glam::{DAffine3, DVec3};
use std::collections::BTreeMap;

/// Maximum difference of two bound transforms of a bone, in metres and of axes.
const SAME: f64 = 1e-4;
/// Maximum shear of a rest transform, relative to its scale.
const MAX_SHEAR: f64 = 1e-3;
/// Differences up to this size between the bound and the stored local transform are rounding.
const ROUNDED_METRES: f64 = 1e-5;
const ROUNDED: f64 = 2e-5;

/// The joints of a file.
pub(super) struct Bones {
    pub(super) skeleton: Skeleton,
    /// Node of each joint.
    pub(super) nodes: Vec<usize>,
    /// Joint of each node; a helper without effect has that of its node.
    pub(super) joint_of_node: Vec<Option<usize>>,
    /// Stored local transforms.
    pub(super) stored: Vec<Transform>,
    /// Stored transforms in the model.
    pub(super) stored_world: Vec<DAffine3>,
    /// Rest transforms in the model.
    rest_world: Vec<DAffine3>,
}

impl Bones {
    /// Rest transform of a joint in the model.
    pub(super) fn rest_world(&self, joint: usize) -> DAffine3 {
        self.rest_world[joint]
    }
}

/// Chooses the joints and their rest pose.
pub(super) fn bones(reader: &mut Reader<'_>, takes: &[Take]) -> Result<Bones, ReadError> {
    let scene = reader.scene;
    let bound = bound(reader);
    let moves = |node: usize| takes.iter().any(|take| take.tracks[node].moves());
    let moving: Vec<bool> = (0..scene.nodes.len()).map(moves).collect();
    let in_skin = joints(scene, &bound.all, &moving);
    let kept = kept(reader, &in_skin, &moving);
    let mut bones = Bones {
        skeleton: Skeleton::default(),
        nodes: Vec::new(),
        joint_of_node: vec![None; scene.nodes.len()],
        stored: Vec::new(),
        stored_world: Vec::new(),
        rest_world: Vec::new(),
    };
    let helpers = helpers(scene);
    let (mut sheared, mut mirrored) = (0, 0);
    for (index, node) in scene.nodes.iter().enumerate() {
        let parent = node.parent.and_then(|p| bones.joint_of_node[p]);
        if !kept[index] {
            continue;
        }
        let acts = |take: &Take| !take.tracks[index].is_identity();
        let is_idle = node.local.transform() == Transform::IDENTITY && !takes.iter().any(acts);
        if node.is_helper && is_idle {
            bones.joint_of_node[index] = parent;
            continue;
        }
        let above = parent.map_or(DAffine3::IDENTITY, |p| bones.rest_world[p]);
        let helper = helpers[index].filter(|h| bound.agreed.contains_key(h));
        let stored = finite(&node.local);
        let rest = match bound.agreed.get(&helper.unwrap_or(index)) {
            Some(world) => {
                let rest = decomposed(&(above.inverse() * *world));
                sheared += usize::from(rest.is_none());
                let own = rest.map(|rest| own_part(rest, node, helper));
                own.filter(|rest| !is_rounded(rest, &node.local))
            }
            None => None,
        };
        let rest = rest.map_or(stored, |rest| finite(&rest));
        mirrored += usize::from(rest.scale.min_element() < 0.0);
        bones.rest_world.push(above * exact(&rest));
        let stored_above = parent.map_or(DAffine3::IDENTITY, |p| bones.stored_world[p]);
        bones.stored_world.push(stored_above * exact(&stored));
        bones.stored.push(stored);
        bones.joint_of_node[index] = Some(bones.nodes.len());
        bones.nodes.push(index);
        bones.skeleton.joints.push(Joint {
            name: named(scene, index),
            parent,
            rest,
            in_skin: in_skin[index],
        });
    }
    if bones.nodes.is_empty() {
        return Err(ReadError::Unsupported {
            at: "scene".to_owned(),
            what: "an FBX file without a bone, a mesh or a node".to_owned(),
            mend: "give a file with a character or a motion".to_owned(),
        });
    }
    let scene = || "scene".to_owned();
    let what = "a joint is sheared where its skin was bound; its stored pose is its rest";
    reader.kinds.note_all(scene, what, sheared);
    reader
        .kinds
        .note_all(scene, "a node is mirrored by a negative scale", mirrored);
    Ok(bones)
}

/// The name of a node, of a helper that of the node that it helps.
pub(super) fn named(scene: &Scene, node: usize) -> String {
    let node = &scene.nodes[node];
    match node.parent.filter(|_| node.is_helper) {
        Some(owner) => format!("{} scale", scene.nodes[owner].name),
        None => node.name.clone(),
    }
}

/// The helper of each node.
fn helpers(scene: &Scene) -> Vec<Option<usize>> {
    let mut helpers = vec![None; scene.nodes.len()];
    for (index, node) in scene.nodes.iter().enumerate() {
        if let Some(owner) = node.parent.filter(|_| node.is_helper) {
            helpers[owner] = Some(index);
        }
    }
    helpers
}

/// The part of a bound transform that is a node's own: a helper has the scale of its node.
fn own_part(whole: Local, node: &Node, helper: Option<usize>) -> Local {
    if helper.is_some() {
        return Local {
            scale: DVec3::ONE,
            ..whole
        };
    }
    if node.is_helper {
        return Local {
            scale: whole.scale,
            ..Local::IDENTITY
        };
    }
    whole
}

struct Clusters {
    /// Nodes that clusters name.
    all: Vec<usize>,
    /// Bound transforms on which all skins agree.
    agreed: BTreeMap<usize, DAffine3>,
}

fn bound(reader: &mut Reader<'_>) -> Clusters {
    let scene = reader.scene;
    let mut found: BTreeMap<usize, Option<DAffine3>> = BTreeMap::new();
    let mut meshes: Vec<usize> = scene.nodes.iter().filter_map(|n| n.mesh).collect();
    meshes.sort_unstable();
    meshes.dedup();
    for skin in meshes.iter().flat_map(|mesh| scene.skins(*mesh)) {
        for cluster in skin.clusters() {
            let Some(bone) = cluster.bone.filter(|_| cluster.bound.is_finite()) else {
                continue;
            };
            let known = found.entry(bone).or_insert(Some(cluster.bound));
            if known.is_some_and(|known| !known.abs_diff_eq(cluster.bound, SAME)) {
                *known = None;
                let what =
                    "skins are bound to a bone in different poses; its stored pose is its rest";
                let at = || format!("node \"{}\"", scene.nodes[bone].name);
                reader.kinds.note(at, what);
            }
        }
    }
    Clusters {
        all: found.keys().copied().collect(),
        agreed: found
            .into_iter()
            .filter_map(|(bone, world)| Some((bone, world?)))
            .collect(),
    }
}

/// Which nodes are joints of the skeleton; a helper's node is one in its place.
fn joints(scene: &Scene, clustered: &[usize], moving: &[bool]) -> Vec<bool> {
    let mut is_joint = vec![false; scene.nodes.len()];
    let bones = scene.nodes.iter().enumerate().filter(|(_, n)| n.is_bone);
    let bones: Vec<usize> = bones
        .map(|(i, _)| i)
        .chain(clustered.iter().copied())
        .collect();
    for &bone in &bones {
        let node = &scene.nodes[bone];
        let owner = node.parent.filter(|_| node.is_helper);
        is_joint[owner.unwrap_or(bone)] = true;
    }
    if bones.is_empty() {
        // Children come behind their parents.
        let mut leads = moving.to_vec();
        for index in (1..scene.nodes.len()).rev() {
            let node = &scene.nodes[index];
            let is_empty = node.mesh.is_none() && !node.is_camera_or_light && !node.is_helper;
            is_joint[index] = leads[index] && is_empty && !is_producer(&node.name);
            if let Some(parent) = node.parent.filter(|_| is_joint[index]) {
                leads[parent] = true;
            }
        }
    }
    is_joint[0] = false;
    is_joint
}

/// Whether it is a camera of MotionBuilder's own.
fn is_producer(name: &str) -> bool {
    name.starts_with("Producer ")
}

/// Which nodes are kept; all, if none is a joint, has a mesh or moves.
fn kept(reader: &Reader<'_>, in_skin: &[bool], moving: &[bool]) -> Vec<bool> {
    let scene = reader.scene;
    let shows = |mesh: usize| !scene.mesh(mesh).corners().is_empty();
    let is_left_out = |index: usize| {
        let node = &scene.nodes[index];
        node.is_camera_or_light || is_producer(&node.name)
    };
    let mut kept: Vec<bool> = (0..scene.nodes.len())
        .map(|i| {
            in_skin[i] || scene.nodes[i].mesh.is_some_and(shows) || moving[i] && !is_left_out(i)
        })
        .collect();
    if !kept.iter().skip(1).any(|k| *k) {
        kept = (0..scene.nodes.len()).map(|i| !is_left_out(i)).collect();
    }
    for index in (1..kept.len()).rev() {
        let node = &scene.nodes[index];
        // A helper is kept with its node, if bones hang from it.
        if let Some(parent) = node.parent.filter(|_| kept[index]) {
            kept[parent] = true;
        }
    }
    for index in 1..kept.len() {
        let node = &scene.nodes[index];
        kept[index] |= node.is_helper && node.parent.is_some_and(|p| kept[p]);
    }
    kept[0] = false;
    kept
}

/// Which parts of two transforms differ: translation, rotation, scale.
pub(super) fn differing(a: &Transform, b: &Transform) -> [bool; 3] {
    [
        a.translation.distance(b.translation) > 1e-6 * a.translation.length().max(1e-1),
        angle_between(a.rotation, b.rotation) > 1e-6,
        a.scale.distance(b.scale) > 1e-6 * a.scale.length().max(1e-3),
    ]
}

fn finite(local: &Local) -> Transform {
    let made = local.transform();
    match made.is_finite() {
        true => made,
        false => Transform::IDENTITY,
    }
}

/// The matrix of a transform, without further rounding.
fn exact(t: &Transform) -> DAffine3 {
    Local {
        translation: t.translation.as_dvec3(),
        rotation: t.rotation.as_dquat().normalize(),
        scale: t.scale.as_dvec3(),
    }
    .matrix()
}

fn is_rounded(a: &Local, b: &Local) -> bool {
    let turn = (a.rotation.inverse() * b.rotation).normalize();
    a.translation.distance(b.translation) <= ROUNDED_METRES
        && turn.xyz().length() <= ROUNDED
        && a.scale.distance(b.scale) <= ROUNDED * a.scale.length()
}

/// Translation, rotation and scale of a matrix; `None` if it is sheared or flat.
fn decomposed(matrix: &DAffine3) -> Option<Local> {
    if !matrix.is_finite() || matrix.matrix3.determinant().abs() < 1e-30 {
        return None;
    }
    let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
    let local = Local {
        translation,
        rotation: rotation.normalize(),
        scale,
    };
    let size = scale.abs().max_element();
    let back = local.matrix().matrix3;
    let apart = |c: usize| (back.col(c) - matrix.matrix3.col(c)).abs().max_element();
    let shear = (0..3).map(apart).fold(0.0, f64::max);
    (shear <= MAX_SHEAR * size).then_some(local)
}
