//! The node hierarchy as a checked forest.
//!
//! Source: glTF 2.0, 3.5.2: nodes form disjoint strict trees.

use super::place::Place;
use super::reader::Reader;
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::{Transform, normalised};
use glam::{Mat4, Quat, Vec3};

/// The nodes of a document: each has at most one parent, none is its own ancestor.
#[derive(Debug)]
pub(super) struct Tree {
    /// Parent of each node.
    pub(super) parents: Vec<Option<usize>>,
    /// All nodes, parents first, depth first in document order.
    pub(super) order: Vec<usize>,
    /// Whether a scene shows each node; all of them if there is no scene.
    pub(super) in_scene: Vec<bool>,
}

impl Tree {
    pub(super) fn len(&self) -> usize {
        self.parents.len()
    }
}

/// Reads and checks the hierarchy.
pub(super) fn read_tree(reader: &Reader<'_>) -> Result<Tree, ReadError> {
    let nodes = reader.root.entries("nodes")?;
    Limits::check("nodes", "nodes", nodes.len() as u64, reader.limits.nodes)?;
    let mut parents = vec![None; nodes.len()];
    let mut children = Vec::with_capacity(nodes.len());
    for (parent, node) in nodes.iter().enumerate() {
        children.push(read_children(node, parent, &mut parents)?);
    }
    let order = depth_first(&parents, &children, reader.limits)?;
    if order.len() < nodes.len() {
        // Every node has at most one parent, so nodes that no root reaches form cycles.
        let mut reached = vec![false; nodes.len()];
        order.iter().for_each(|&n| reached[n] = true);
        let lost = reached.iter().position(|r| !r).unwrap_or(0);
        return Err(nodes[lost].malformed("the node is part of a cycle, or below one"));
    }
    let in_scene = nodes_in_scenes(reader, &parents, &order)?;
    Ok(Tree {
        parents,
        order,
        in_scene,
    })
}

fn nodes_in_scenes(
    reader: &Reader<'_>,
    parents: &[Option<usize>],
    order: &[usize],
) -> Result<Vec<bool>, ReadError> {
    let scenes = reader.root.entries("scenes")?;
    let mut shown = vec![scenes.is_empty(); parents.len()];
    for scene in scenes {
        for node in scene.entries("nodes")? {
            shown[node.index_below(parents.len())?] = true;
        }
    }
    for &n in order {
        shown[n] |= parents[n].is_some_and(|parent| shown[parent]);
    }
    Ok(shown)
}

fn read_children(
    node: &Place<'_>,
    parent: usize,
    parents: &mut [Option<usize>],
) -> Result<Vec<usize>, ReadError> {
    let mut children = Vec::new();
    for entry in node.entries("children")? {
        let child = entry.index_below(parents.len())?;
        if let Some(other) = parents[child] {
            let what = format!("node {child} is already a child of node {other}");
            return Err(entry.malformed(what));
        }
        parents[child] = Some(parent);
        children.push(child);
    }
    Ok(children)
}

fn depth_first(
    parents: &[Option<usize>],
    children: &[Vec<usize>],
    limits: &Limits,
) -> Result<Vec<usize>, ReadError> {
    let mut order = Vec::with_capacity(parents.len());
    let roots = (0..parents.len()).rev().filter(|&n| parents[n].is_none());
    let mut stack: Vec<(usize, u64)> = roots.map(|n| (n, 1)).collect();
    while let Some((node, depth)) = stack.pop() {
        if depth > limits.depth {
            let at = format!("nodes[{node}]");
            Limits::check(&at, "levels of nodes", depth, limits.depth)?;
        }
        order.push(node);
        stack.extend(children[node].iter().rev().map(|&c| (c, depth + 1)));
    }
    Ok(order)
}

/// Reads a node's local transform; an invalid one is repaired.
pub(super) fn read_transform(
    reader: &mut Reader<'_>,
    node: &Place<'_>,
) -> Result<Transform, ReadError> {
    if let Some(columns) = node.floats::<16>("matrix")? {
        return Ok(split_matrix(reader, node, Mat4::from_cols_array(&columns)));
    }
    let mut transform = Transform::IDENTITY;
    if let Some(t) = node.floats::<3>("translation")? {
        transform.translation = Vec3::from_array(t);
    }
    if let Some(r) = node.floats::<4>("rotation")? {
        transform.rotation = repair_rotation(reader, node, Quat::from_array(r));
    }
    if let Some(s) = node.floats::<3>("scale")? {
        transform.scale = Vec3::from_array(s);
    }
    Ok(transform)
}

fn repair_rotation(reader: &mut Reader<'_>, node: &Place<'_>, rotation: Quat) -> Quat {
    match unit(rotation) {
        None => {
            reader.notes.add(
                node.path("rotation"),
                "a quaternion of length 0 is read as identity",
            );
            Quat::IDENTITY
        }
        Some(unit) => {
            let length = rotation.length();
            if (length - 1.0).abs() > 1e-3 {
                let what = format!("the quaternion has length {length}; normalised");
                reader.notes.add(node.path("rotation"), what);
            }
            unit
        }
    }
}

/// Returns the unit quaternion of the same direction; `None` if there is none. One that is already
/// unit to `f32` precision is returned unchanged.
pub(super) fn unit(rotation: Quat) -> Option<Quat> {
    if (rotation.length_squared() - 1.0).abs() <= 1e-6 {
        return Some(rotation);
    }
    // Scaled first, so that squares of very small or very large components stay in range.
    let largest = glam::Vec4::from(rotation).abs().max_element();
    if largest == 0.0 || !largest.is_finite() {
        return None;
    }
    let scaled = normalised(Quat::from_vec4(glam::Vec4::from(rotation) / largest));
    scaled.is_finite().then_some(scaled)
}

fn split_matrix(reader: &mut Reader<'_>, node: &Place<'_>, matrix: Mat4) -> Transform {
    let (transform, is_exact) = transform_of(matrix);
    if !is_exact {
        let at = node.path("matrix");
        let what = "the matrix is sheared or singular; the nearest translation, rotation and scale \
                    are used";
        reader.notes.add(at, what);
    }
    transform
}

/// Returns the transform of a matrix, and whether it is that matrix; else the nearest one.
pub(super) fn transform_of(matrix: Mat4) -> (Transform, bool) {
    let exact = Transform::from_matrix(matrix);
    (
        exact.unwrap_or_else(|| nearest_transform(matrix)),
        exact.is_some(),
    )
}

/// Returns the nearest transform: translation and column lengths are kept, and the columns are
/// orthonormalised by Gram-Schmidt; columns without length get a direction from the others.
fn nearest_transform(matrix: Mat4) -> Transform {
    let [a, b, c] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|v| v.truncate());
    let x = a.try_normalize().unwrap_or(Vec3::X);
    let y = (b - x * x.dot(b))
        .try_normalize()
        .unwrap_or_else(|| x.any_orthonormal_vector());
    let z = x.cross(y);
    let sign = if z.dot(c) < 0.0 { -1.0 } else { 1.0 };
    Transform {
        translation: matrix.w_axis.truncate(),
        rotation: normalised(Quat::from_mat3(&glam::Mat3::from_cols(x, y, z))),
        scale: Vec3::new(a.length(), b.length(), sign * c.length()),
    }
}
