//! Meshes and skins that have one grid of positions.

use super::super::append::index;
use super::super::extension::VARIANTS;
use super::super::place::Place;
use crate::error::ReadError;
use std::collections::{BTreeMap, BTreeSet};

/// Meshes and skins that share vertices or bind matrices.
#[derive(Debug, Default)]
pub(super) struct Group {
    pub(super) meshes: BTreeSet<usize>,
    pub(super) skins: BTreeSet<usize>,
    /// Accessors of positions, and of offsets by morph targets with those of their positions.
    pub(super) positions: BTreeSet<usize>,
    pub(super) offsets: BTreeMap<usize, usize>,
    /// Whether something uses it that has no bind matrices, or uses its arrays for something else.
    pub(super) is_refused: bool,
}

/// Returns the groups of a document that has meshes of skins.
pub(super) fn groups(root: &Place<'_>) -> Result<Vec<Group>, ReadError> {
    let mut all: Vec<Group> = Vec::new();
    for (m, mesh) in root.entries("meshes")?.iter().enumerate() {
        let mut own = Group::default();
        own.meshes.insert(m);
        own.add_arrays(mesh)?;
        own.add_users(root, m)?;
        let (others, joined): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|group| !own.shares_with(group));
        all = others;
        for group in joined {
            own.join(group);
        }
        all.push(own);
    }
    let elsewhere = other_uses(root)?;
    for group in &mut all {
        let mut arrays = group.positions.iter().chain(group.offsets.keys());
        let is_both = group.offsets.keys().any(|a| group.positions.contains(a));
        group.is_refused |= is_both || arrays.any(|a| elsewhere.contains(a));
    }
    Ok(all)
}

impl Group {
    fn add_arrays(&mut self, mesh: &Place<'_>) -> Result<(), ReadError> {
        for primitive in mesh.entries("primitives")? {
            let extensions = primitive.get("extensions").map(|e| e.members());
            let mut names = extensions.unwrap_or_default().into_iter();
            self.is_refused |= names.any(|(name, _)| name != VARIANTS);
            let of = |place: &Place<'_>| index(place.value(), "POSITION");
            let Some(base) = primitive.get("attributes").as_ref().and_then(of) else {
                self.is_refused = true;
                continue;
            };
            self.positions.insert(base);
            for offset in primitive.entries("targets")?.iter().filter_map(of) {
                self.is_refused |= *self.offsets.entry(offset).or_insert(base) != base;
            }
        }
        Ok(())
    }

    /// Adds the skins of the nodes that show a mesh.
    fn add_users(&mut self, root: &Place<'_>, mesh: usize) -> Result<(), ReadError> {
        let nodes = root.entries("nodes")?;
        let users = nodes.iter().map(Place::value);
        for node in users.filter(|node| index(node, "mesh") == Some(mesh)) {
            match index(node, "skin") {
                Some(skin) => {
                    self.skins.insert(skin);
                }
                None => self.is_refused = true,
            }
        }
        Ok(())
    }

    fn shares_with(&self, other: &Self) -> bool {
        let has = |a: &usize| other.positions.contains(a) || other.offsets.contains_key(a);
        !self.skins.is_disjoint(&other.skins)
            || self.positions.iter().any(has)
            || self.offsets.keys().any(has)
    }

    fn join(&mut self, other: Self) {
        self.meshes.extend(other.meshes);
        self.skins.extend(other.skins);
        self.positions.extend(other.positions);
        for (offset, base) in other.offsets {
            self.is_refused |= *self.offsets.entry(offset).or_insert(base) != base;
        }
        self.is_refused |= other.is_refused;
    }
}

/// Accessors that are used for anything but positions.
fn other_uses(root: &Place<'_>) -> Result<BTreeSet<usize>, ReadError> {
    let mut out = BTreeSet::new();
    let mut add = |list: Option<Place<'_>>| {
        let members = list.map(|list| list.members()).unwrap_or_default();
        let others = members.into_iter().filter(|(name, _)| *name != "POSITION");
        out.extend(
            others
                .filter_map(|(_, i)| i.whole().ok())
                .map(|i| i as usize),
        );
    };
    for mesh in root.entries("meshes")? {
        for primitive in mesh.entries("primitives")? {
            add(primitive.get("attributes"));
            for target in primitive.entries("targets")? {
                add(Some(target));
            }
        }
    }
    for animation in root.entries("animations")? {
        for sampler in animation.entries("samplers")? {
            let of = |key: &str| index(sampler.value(), key);
            out.extend([of("input"), of("output")].into_iter().flatten());
        }
    }
    Ok(out)
}
