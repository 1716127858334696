//! Skins: which joints move each vertex.
//!
//! A cluster is a bone, the matrix from the mesh to it when it was bound, and weights of control points. A point
//! without a weight follows the node of its mesh.

use super::scene::Skin as Source;
use super::skeleton::Bones;
use super::source::Reader;
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::source::{Primitive, Skin};
use glam::{Affine3A, DAffine3};
use std::collections::HashMap;

/// Maximum number of influences of a vertex.
const MOST: usize = 8;
/// Least sum of weights that is more than none.
const LEAST_SUM: f64 = 1e-6;

/// A skin of a mesh, with the influences on its control points.
pub(super) struct Influences<'s> {
    pub(super) skin: Skin,
    source: Source<'s>,
    /// Entry of the skin of each cluster.
    entries: Vec<u16>,
    /// Entry of the node of the mesh.
    own: u16,
}

/// Reads the skin of a node's mesh; `None` if it has none.
pub(super) fn read<'s>(
    reader: &mut Reader<'s>,
    bones: &Bones,
    node: usize,
    mesh: usize,
) -> Result<Option<Influences<'s>>, ReadError> {
    let skins = reader.scene.skins(mesh);
    let at = || format!("mesh \"{}\"", reader.scene.nodes[node].name);
    let mut filled = skins.iter().filter(|skin| !skin.clusters().is_empty());
    let Some(&source) = filled.next() else {
        return Ok(None);
    };
    let more = filled.count();
    let (place, geometry) = (at(), reader.scene.nodes[node].geometry);
    let kinds = &mut reader.kinds;
    kinds.note_all(
        || place.clone(),
        "a mesh has several skins; the first is used",
        more,
    );
    if !source.is_linear() {
        let what = "a skin is made for dual quaternions; it is blended linearly";
        kinds.note(|| place.clone(), what);
    }
    let clusters = source.clusters();
    Limits::check(
        &place,
        "joints of a skin",
        clusters.len() as u64,
        (1 << 16) - 2,
    )?;
    let mut skin = Skin::default();
    let mut entries = Vec::new();
    let mut add = |joint: usize, matrix: DAffine3| {
        let matrix = single(&matrix);
        let same = |at: &usize| skin.joints[*at] == joint && skin.inverse_bind[*at] == matrix;
        // The same bone twice stands nearly always next to itself.
        let known = (skin.joints.len().saturating_sub(4)..skin.joints.len()).find(same);
        let entry = known.unwrap_or(skin.joints.len());
        if entry == skin.joints.len() {
            skin.joints.push(joint);
            skin.inverse_bind.push(matrix);
        }
        entry as u16
    };
    let mut loose = 0;
    for cluster in &clusters {
        let joint = cluster.bone.and_then(|bone| bones.joint_of_node[bone]);
        entries.push(match joint {
            Some(joint) => add(joint, cluster.geometry_to_bone),
            None => {
                loose += 1;
                let root = bones.rest_world(0).inverse();
                add(0, root * cluster.bound * cluster.geometry_to_bone)
            }
        });
    }
    let what = "a cluster names no bone; its points follow the root";
    reader.kinds.note_all(|| place.clone(), what, loose);
    let own = bones.joint_of_node[node].unwrap_or(0);
    let own = add(own, geometry);
    Ok(Some(Influences {
        skin,
        source,
        entries,
        own,
    }))
}

/// A matrix in single precision; numbers beyond it become the identity.
fn single(matrix: &DAffine3) -> Affine3A {
    let matrix = Affine3A::from_cols_array(&matrix.to_cols_array().map(|x| x as f32));
    match matrix.is_finite() {
        true => matrix,
        false => Affine3A::IDENTITY,
    }
}

impl Influences<'_> {
    /// Writes the influences of a primitive's vertices; `points` has the control point of each.
    pub(super) fn apply(
        &self,
        reader: &mut Reader<'_>,
        points: &[u32],
        primitive: &mut Primitive,
    ) -> Result<(), ReadError> {
        let mut lost = 0.0_f64;
        let mut of_point: HashMap<u32, Vec<(u16, f32)>> = HashMap::new();
        for point in points {
            of_point.entry(*point).or_insert_with(|| {
                let (list, cut) = self.of_point(*point);
                lost = lost.max(cut);
                list
            });
        }
        if lost > 0.0 {
            let what = "a vertex has more than 8 joints; those with the least weights are left out";
            reader.kinds.note(|| "skins".to_owned(), what);
        }
        let most = of_point.values().map(Vec::len).max().unwrap_or(1);
        reader.charge("skin", points.len().saturating_mul(2 * most))?;
        primitive.influences = most;
        for point in points {
            let list = &of_point[point];
            for slot in 0..most {
                let (entry, weight) = list.get(slot).copied().unwrap_or((0, 0.0));
                primitive.joints.push(entry);
                primitive.weights.push(weight);
            }
        }
        Ok(())
    }

    /// Entries and weights of a control point, which sum to 1, and the share that was cut off.
    fn of_point(&self, point: u32) -> (Vec<(u16, f32)>, f64) {
        let mut list: Vec<(u16, f64)> = Vec::new();
        for (cluster, weight) in self.source.influences(point) {
            let Some(&entry) = self.entries.get(cluster) else {
                continue;
            };
            if !(weight > 0.0 && weight.is_finite()) {
                continue;
            }
            list.push((entry, weight));
        }
        // Equal joints stand beside each other, and become one.
        list.sort_by_key(|(entry, _)| *entry);
        list.dedup_by(|b, a| {
            let is_same = a.0 == b.0;
            a.1 += if is_same { b.1 } else { 0.0 };
            is_same
        });
        list.sort_by(|a, b| b.1.total_cmp(&a.1));
        let whole: f64 = list.iter().map(|l| l.1).sum();
        list.truncate(MOST);
        let sum: f64 = list.iter().map(|l| l.1).sum();
        if !(LEAST_SUM..f64::MAX).contains(&sum) {
            return (vec![(self.own, 1.0)], 0.0);
        }
        let list = list.into_iter().map(|(entry, w)| (entry, (w / sum) as f32));
        (list.collect(), whole - sum)
    }
}
