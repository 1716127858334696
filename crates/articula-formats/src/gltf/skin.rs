//! Skins: lists of joint nodes with their inverse bind matrices.
//!
//! Source: glTF 2.0, 3.7.3.

use super::place::Place;
use super::reader::Reader;
use crate::error::ReadError;
use glam::{Affine3A, Mat4};

/// A skin by nodes of the document.
#[derive(Debug)]
pub(super) struct NodeSkin {
    /// Node of each joint.
    pub(super) joints: Vec<usize>,
    pub(super) inverse_bind: Vec<Affine3A>,
}

/// Reads all skins in order.
pub(super) fn read_all(reader: &mut Reader<'_>, nodes: usize) -> Result<Vec<NodeSkin>, ReadError> {
    let skins = reader.root.entries("skins")?;
    skins
        .iter()
        .map(|skin| read_skin(reader, skin, nodes))
        .collect()
}

fn read_skin<'a>(
    reader: &mut Reader<'a>,
    skin: &Place<'a>,
    nodes: usize,
) -> Result<NodeSkin, ReadError> {
    let joints = skin
        .entries("joints")?
        .iter()
        .map(|joint| joint.index_below(nodes))
        .collect::<Result<Vec<_>, _>>()?;
    if joints.is_empty() {
        return Err(skin.malformed("a skin needs at least one joint"));
    }
    let at = skin.path("joints");
    reader.charge(&at, joints.len() as u64 * 16)?;
    let inverse_bind = match skin.get("inverseBindMatrices") {
        Some(index) => read_matrices(reader, &index, joints.len())?,
        None => vec![Affine3A::IDENTITY; joints.len()],
    };
    Ok(NodeSkin {
        joints,
        inverse_bind,
    })
}

fn read_matrices(
    reader: &mut Reader<'_>,
    index: &Place<'_>,
    joints: usize,
) -> Result<Vec<Affine3A>, ReadError> {
    let accessor = reader.accessor(index)?;
    accessor.expect_type(&["MAT4"])?;
    if accessor.count < joints {
        accessor.expect_count(joints, "joints")?;
    }
    let numbers = reader.floats(&accessor)?;
    let matrices = numbers.as_chunks::<16>().0.iter().take(joints);
    Ok(matrices
        .map(|m| Affine3A::from_mat4(Mat4::from_cols_array(m)))
        .collect())
}
