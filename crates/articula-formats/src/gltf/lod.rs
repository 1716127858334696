//! Levels of detail in a file: nodes that replace another one when it is small on the screen.
//!
//! Source: MSFT_lod, for nodes. A coarser node takes the parent of the finest, with its own
//! transform instead of the finest's; one that a scene shows keeps its own parent. Restrictions:
//! levels of materials are left out. Levels belong to one mesh here: a coarser node with a single
//! mesh in its branch replaces the finest node's own mesh; other branches are paired mesh by mesh,
//! and left out if their number of meshes differs from the finest.

use super::node::{self, Tree};
use super::node_meshes::{Given, NodeMeshes, joint_skin, read_parts, skin_of};
use super::place::Place;
use super::reader::Reader;
use super::skeleton::{Skeletal, node_place};
use crate::error::ReadError;
use articula_core::source::{Primitive, RawMeshLevel, Skin};
use glam::Affine3A;

/// A node and those that replace it, the finest first.
#[derive(Debug)]
struct Chain {
    finest: usize,
    coarser: Vec<usize>,
    /// Minimum screen coverage of the finest and of each coarser level.
    coverages: Vec<Option<f32>>,
}

/// Levels of detail of a document.
#[derive(Debug)]
pub(super) struct Lods {
    /// Whether each node belongs to a coarser level, and so shows nothing itself.
    pub(super) is_coarser: Vec<bool>,
    chains: Vec<Chain>,
    parents: Vec<Option<usize>>,
    children: Vec<Vec<usize>>,
}

/// Reads which nodes replace which. Broken entries are left out with a warning.
pub(super) fn read(reader: &mut Reader<'_>, tree: &Tree) -> Lods {
    let mut lods = Lods {
        is_coarser: vec![false; tree.len()],
        chains: Vec::new(),
        parents: tree.parents.clone(),
        children: vec![Vec::new(); tree.len()],
    };
    for &n in &tree.order {
        if let Some(parent) = tree.parents[n] {
            lods.children[parent].push(n);
        }
    }
    for (n, place) in reader
        .root
        .entries("nodes")
        .unwrap_or_default()
        .iter()
        .enumerate()
    {
        if place.dig(&["extensions", "MSFT_lod"]).is_some() && tree.in_scene[n] {
            let chain = lods.read_chain(reader, place, n);
            lods.chains.push(chain);
        }
    }
    for chain in &lods.chains {
        chain
            .coarser
            .iter()
            .for_each(|&m| lods.is_coarser[m] = true);
    }
    for &n in &tree.order {
        lods.is_coarser[n] |= tree.parents[n].is_some_and(|parent| lods.is_coarser[parent]);
    }
    // A coarser level may list levels too; they are ignored.
    lods.chains.retain(|chain| !lods.is_coarser[chain.finest]);
    lods
}

impl Lods {
    fn read_chain(&self, reader: &mut Reader<'_>, place: &Place<'_>, finest: usize) -> Chain {
        let extension = place.dig(&["extensions", "MSFT_lod"]);
        let ids = extension.map_or(Ok(Vec::new()), |e| e.entries("ids"));
        let ids = ids.unwrap_or_else(|error| {
            reader.warn(place, format!("the levels are left out: {error}"));
            Vec::new()
        });
        let extras = place.get("extras");
        let stated = extras.map_or(Ok(Vec::new()), |e| e.entries("MSFT_screencoverage"));
        let stated = stated.unwrap_or_default();
        let coverage = |i: usize| {
            let stated = stated.get(i)?.float().ok()?;
            (stated >= 0.0).then_some(stated)
        };
        let mut chain = Chain {
            finest,
            coarser: Vec::new(),
            coverages: vec![coverage(0)],
        };
        for (i, id) in ids.iter().enumerate() {
            match self.coarser_node(id, finest) {
                Ok(node) => {
                    chain.coarser.push(node);
                    chain.coverages.push(coverage(i + 1));
                }
                Err(error) => reader.warn(id, format!("the level is left out: {error}")),
            }
        }
        chain
    }

    fn coarser_node(&self, id: &Place<'_>, finest: usize) -> Result<usize, ReadError> {
        let node = id.index_below(self.parents.len())?;
        let mut above = Some(finest);
        while let Some(n) = above {
            if n == node {
                return Err(id.malformed("the level is the node itself or an ancestor of it"));
            }
            above = self.parents[n];
        }
        Ok(node)
    }

    /// Returns the nodes of a branch that have a mesh, depth first.
    fn meshes_below(&self, reader: &mut Reader<'_>, top: usize) -> Result<Vec<usize>, ReadError> {
        let mut found = Vec::new();
        let mut stack = vec![top];
        while let Some(n) = stack.pop() {
            let node = node_place(reader, n)?;
            // Charged, since a branch may be referenced any number of times.
            reader.charge(&node, 0)?;
            if node.get("mesh").is_some() {
                found.push(n);
            }
            stack.extend(self.children[n].iter().rev());
        }
        Ok(found)
    }

    /// Returns the transform of a node at rest relative to the parent of `top`.
    fn place_below(
        &self,
        reader: &mut Reader<'_>,
        skeletal: &Skeletal,
        (node, top): (usize, Option<usize>),
    ) -> Result<Affine3A, ReadError> {
        let mut place = Affine3A::IDENTITY;
        let mut at = Some(node);
        while let Some(n) = at {
            let local = match skeletal.joint_of_node[n] {
                Some(joint) => skeletal.skeleton.joints[joint].rest,
                None => {
                    let node = node_place(reader, n)?;
                    node::read_transform(reader, &node)?
                }
            };
            place = local.to_affine() * place;
            at = self.parents[n].filter(|_| top != Some(n));
        }
        Ok(place)
    }
}

/// Attaches coarser levels to the meshes.
pub(super) fn attach(
    reader: &mut Reader<'_>,
    given: &Given<'_>,
    lods: &Lods,
    shown: &mut NodeMeshes,
) -> Result<(), ReadError> {
    for chain in &lods.chains {
        let mesh_of_node = |n: &usize| shown.node_of_mesh.binary_search(n).ok();
        let own = mesh_of_node(&chain.finest);
        let fine = lods.meshes_below(reader, chain.finest)?;
        let fine: Vec<usize> = fine.iter().filter_map(mesh_of_node).collect();
        for &m in &fine {
            shown.meshes[m].screen_coverage = chain.coverages[0];
        }
        for (&top, coverage) in chain.coarser.iter().zip(&chain.coverages[1..]) {
            let coarse = lods.meshes_below(reader, top)?;
            // One mesh replaces one mesh, regardless of other nodes below the finest.
            let fine = match own.as_slice() {
                own @ [_] if coarse == [top] => own,
                _ => &fine,
            };
            if coarse.len() != fine.len() {
                let what = format!(
                    "a level with {} meshes is left out: the finest has {}",
                    coarse.len(),
                    fine.len()
                );
                reader.warn(&node_place(reader, top)?, what);
                continue;
            }
            for (&m, n) in fine.iter().zip(coarse) {
                let instead = Instead { chain, top, n };
                let level = read_level(reader, given, lods, (&instead, m, shown))?;
                shown.meshes[m]
                    .levels
                    .extend(level.map(|level| RawMeshLevel {
                        screen_coverage: *coverage,
                        ..level
                    }));
            }
        }
    }
    Ok(())
}

/// A node whose mesh replaces another, and its branch.
struct Instead<'a> {
    chain: &'a Chain,
    top: usize,
    n: usize,
}

/// Reads a node's mesh as a level of mesh `m`; `None`, with a warning, if that is impossible.
fn read_level(
    reader: &mut Reader<'_>,
    given: &Given<'_>,
    lods: &Lods,
    (instead, m, shown): (&Instead<'_>, usize, &NodeMeshes),
) -> Result<Option<RawMeshLevel>, ReadError> {
    let node = node_place(reader, instead.n)?;
    let (_, mut primitives) = read_parts(reader, &node, given)?;
    if primitives.is_empty() {
        reader.warn(&node, "the level has no triangles; left out");
        return Ok(None);
    }
    let mesh = &shown.meshes[m];
    let morphs = mesh.morph_weights.len();
    let is_other = |p: &Primitive| !p.morphs.is_empty() && p.morphs.len() != morphs;
    if primitives.iter().any(is_other) {
        let what = format!("the morph targets of the level are left out: the finest has {morphs}");
        reader.warn(&node, what);
        primitives.iter_mut().for_each(|p| p.morphs.clear());
    }
    let fine = shown.node_of_mesh[m];
    let skin = match skin_of(&node, given)? {
        Some(skin) => joint_skin(reader, instead.n, Some(skin), given.skeletal)?,
        None => match rigid_skin(reader, given, lods, (instead, fine))? {
            Some(skin) => skin,
            None => {
                reader.warn(
                    &node,
                    "the level cannot take the position of the finest; left out",
                );
                return Ok(None);
            }
        },
    };
    Ok(Some(RawMeshLevel {
        skin,
        primitives,
        screen_coverage: None,
    }))
}

/// Returns a skin with the joint of the rigid mesh that a level without skin replaces.
fn rigid_skin(
    reader: &mut Reader<'_>,
    given: &Given<'_>,
    lods: &Lods,
    (instead, fine): (&Instead<'_>, usize),
) -> Result<Option<Skin>, ReadError> {
    let is_skinned = skin_of(&node_place(reader, fine)?, given)?.is_some();
    let Some(joint) = given.skeletal.joint_of_node[fine].filter(|_| !is_skinned) else {
        return Ok(None);
    };
    let is_shown = given.skeletal.in_scene[instead.n];
    let tops = if is_shown {
        [None; 2]
    } else {
        [Some(instead.top), Some(instead.chain.finest)]
    };
    let coarse = lods.place_below(reader, given.skeletal, (instead.n, tops[0]))?;
    let fine = lods.place_below(reader, given.skeletal, (fine, tops[1]))?;
    let offset = if coarse == fine {
        Affine3A::IDENTITY
    } else {
        fine.inverse() * coarse
    };
    Ok(offset.is_finite().then(|| Skin {
        joints: vec![joint],
        inverse_bind: vec![offset],
    }))
}
