//! Skins of all levels, on one palette.

use super::blocks::Tally;
use super::fold::{Correction, fold};
use super::measure::{WatchedSkin, measure};
use super::plan::Plan;
use super::prefixes::Prefixes;
use super::watch::Watched;
use super::{JointLodOptions, check, check_tolerances};
use crate::character::Asset;
use articula_core::{Binding, JointLods, LevelSkin, LevelSkins, Mesh, Mismatch, PaletteMap};
use glam::Affine3A;

/// Numbers of influences that a coarser level tries, besides all of them.
const INFLUENCES: [usize; 3] = [1, 2, 4];

/// Share of a level's own error that fewer influences may add.
const MIN_SHARE: f32 = 0.1;

/// Added error in metres that is always accepted for fewer influences.
const UNSEEN_METRES: f32 = 1e-4;

/// Skins of a character without a mesh.
pub(super) fn no_skins(joint_lods: &JointLods) -> Result<LevelSkins, Mismatch> {
    Ok(LevelSkins {
        bindings: Vec::new(),
        palette: PaletteMap::skin(joint_lods, &[])?,
        levels: vec![LevelSkin::default(); joint_lods.levels()],
    })
}

/// Mesh of the given vertices of a level's skin.
pub(crate) fn skin_part(skin: &LevelSkin, bindings: &[Binding], vertices: &[u32]) -> Mesh {
    let of = |v: &u32| {
        let first = *v as usize * skin.influences;
        first..first + skin.influences
    };
    Mesh {
        positions: vertices
            .iter()
            .map(|v| skin.positions[*v as usize])
            .collect(),
        influences: skin.influences,
        binding_indices: vertices
            .iter()
            .flat_map(|v| skin.binding_indices[of(v)].iter().copied())
            .collect(),
        weights: vertices
            .iter()
            .flat_map(|v| skin.weights[of(v)].iter().copied())
            .collect(),
        bindings: bindings.to_vec(),
        ..Mesh::default()
    }
}

/// Computes the skin of every level. The skins are empty for a character without a mesh.
///
/// The number of influences of a coarser level (1, 2, 4 or all) is the smallest that adds little to
/// its error. O(levels x vertices).
///
/// # Errors
/// A [`Mismatch`] if a clip, the mesh or the joint LODs belong to another rig, or more than 65535
/// bindings are needed.
pub fn level_skins(
    asset: &Asset,
    joint_lods: &JointLods,
    opts: &JointLodOptions,
) -> Result<LevelSkins, Mismatch> {
    check(asset)?;
    check_tolerances(asset, joint_lods)?;
    if asset.mesh.is_empty() {
        return no_skins(joint_lods);
    }
    let placed = placed_skins(
        asset,
        &asset.mesh,
        &Prefixes::of(&asset.rig, joint_lods),
        opts,
    )?;
    placed.on(joint_lods, |binding, _| binding)
}

/// Skins of levels whose bindings are sorted by position in the joint order and refer to the full
/// rig.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlacedSkins {
    pub(super) bindings: Vec<Binding>,
    places: Vec<u16>,
    pub(super) levels: Vec<LevelSkin>,
}

impl PlacedSkins {
    /// The skins for joint LODs; `named` maps a binding and its position to the stored binding.
    pub(super) fn on(
        &self,
        joint_lods: &JointLods,
        named: impl Fn(Binding, u16) -> Binding,
    ) -> Result<LevelSkins, Mismatch> {
        let matrices = self.bindings.iter().map(|b| b.inverse_bind);
        let placed: Vec<(u16, Affine3A)> = self.places.iter().copied().zip(matrices).collect();
        let all = self.bindings.iter().zip(&self.places);
        Ok(LevelSkins {
            palette: PaletteMap::skin(joint_lods, &placed)?,
            bindings: all.map(|(b, place)| named(*b, *place)).collect(),
            levels: self.levels.clone(),
        })
    }
}

/// The skins of a mesh: the character's own or its substitute from [`skin_of`](super::skin_of).
pub(super) fn placed_skins(
    asset: &Asset,
    mesh: &Mesh,
    prefixes: &Prefixes<'_>,
    opts: &JointLodOptions,
) -> Result<PlacedSkins, Mismatch> {
    let mut plan = Plan::new(asset, mesh, prefixes);
    let candidates = candidates(&mut plan);
    if plan.bindings().len() > usize::from(u16::MAX) {
        let what = "more than 65535 bindings, including those of merged joints";
        return Err(Mismatch::new("mesh.bindings", what));
    }
    let levels = choose(asset, mesh, &plan, candidates, opts);
    Ok(assemble(&plan, levels))
}

/// Every level with each number of influences to try, fewest first; the last one has all.
fn candidates(plan: &mut Plan<'_>) -> Vec<Vec<LevelSkin>> {
    let all = plan.mesh.influences;
    let mut out = Vec::new();
    for level in 0..plan.prefixes.levels() {
        let whole = plan.prefixes.is_whole(level);
        let tries = INFLUENCES.iter().copied().filter(|n| *n < all && !whole);
        let mut skins: Vec<LevelSkin> = tries.map(|n| skin_at(plan, level, n)).collect();
        skins.push(skin_at(plan, level, usize::MAX));
        out.push(skins);
    }
    out
}

/// Selects the smallest number of influences whose extra error is a small share of the level's own.
fn choose(
    asset: &Asset,
    mesh: &Mesh,
    plan: &Plan<'_>,
    candidates: Vec<Vec<LevelSkin>>,
    opts: &JointLodOptions,
) -> Vec<LevelSkin> {
    let watched = Watched::draw(mesh, asset.rig.len(), opts.vertices, opts.seed);
    let reduced = candidates.iter().flatten();
    let reduced: Vec<WatchedSkin> = reduced
        .map(|s| WatchedSkin {
            mesh: skin_part(s, plan.bindings(), &watched.vertices),
            watched: watched.clone(),
        })
        .collect();
    let mut tallies = vec![Tally::default(); reduced.len()];
    for clip in measure(asset, mesh, &reduced, opts.frames) {
        for (all, one) in tallies.iter_mut().zip(clip) {
            *all = all.worst_of(one);
        }
    }
    let mut tallies = tallies.into_iter();
    let mut chosen = Vec::with_capacity(candidates.len());
    for mut skins in candidates {
        let of: Vec<Tally> = tallies.by_ref().take(skins.len()).collect();
        let own = of[of.len() - 1];
        let enough = |t: &Tally| {
            let within = |e: f32, own: f32| e <= own * (1.0 + MIN_SHARE) + UNSEEN_METRES;
            within(t.percentile_metres, own.percentile_metres)
                && within(t.worst_metres, own.worst_metres)
        };
        let first = of.iter().position(enough).unwrap_or(of.len() - 1);
        chosen.push(skins.swap_remove(first));
    }
    chosen
}

/// Skin of one level with at most `most` influences; binding indices are those of the plan.
fn skin_at(plan: &mut Plan<'_>, level: usize, most: usize) -> LevelSkin {
    let mesh = plan.mesh;
    let mut skin = LevelSkin {
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        morphs: mesh.morphs.clone(),
        ..LevelSkin::default()
    };
    let mut lists = Vec::with_capacity(mesh.len());
    let mut corrections: Vec<Option<(Correction, f64)>> = vec![None; mesh.len()];
    for (v, corrected) in corrections.iter_mut().enumerate() {
        let Some(folded) = fold(plan, level, v, most) else {
            lists.push(plan.influences(v));
            continue;
        };
        if let Some(c) = folded.correction {
            let (normal, scale) = c.normal(mesh.normals[v]);
            skin.positions[v] = c.position(mesh.positions[v]);
            skin.normals[v] = normal;
            *corrected = Some((c, scale));
        }
        lists.push(folded.influences);
    }
    for morph in &mut skin.morphs {
        for (i, v) in morph.vertices.iter().enumerate() {
            if let Some((c, scale)) = &corrections[*v as usize] {
                morph.positions[i] = c.offset(morph.positions[i]);
                morph.normals[i] = c.normal_offset(morph.normals[i], *scale);
            }
        }
    }
    skin.influences = lists.iter().map(Vec::len).max().unwrap_or(1);
    for list in &lists {
        // Padding repeats the first binding of the vertex, with weight 0.
        let filler = (list[0].0, 0.0);
        let padded = list.iter().copied().chain(std::iter::repeat(filler));
        for (binding, weight) in padded.take(skin.influences) {
            skin.binding_indices.push(binding);
            skin.weights.push(weight);
        }
    }
    skin
}

/// Sorts the used bindings by position in the joint order.
fn assemble(plan: &Plan<'_>, mut levels: Vec<LevelSkin>) -> PlacedSkins {
    let place = |b: &u16| {
        let joint = plan.bindings()[usize::from(*b)].joint;
        plan.prefixes.place(usize::from(joint))
    };
    let mut used: Vec<u16> = levels
        .iter()
        .flat_map(|l| l.binding_indices.iter().copied())
        .collect();
    used.sort_unstable();
    used.dedup();
    used.sort_by_key(place);
    let mut at = vec![0u16; plan.bindings().len()];
    for (i, binding) in used.iter().enumerate() {
        at[usize::from(*binding)] = i as u16;
    }
    for (level, skin) in levels.iter_mut().enumerate() {
        for index in &mut skin.binding_indices {
            *index = at[usize::from(*index)];
        }
        let kept = plan.prefixes.joint_count(level);
        skin.palette = used.partition_point(|b| place(b) < kept);
    }
    let bindings = used.iter().map(|b| plan.bindings()[usize::from(*b)]);
    PlacedSkins {
        bindings: bindings.collect(),
        places: used.iter().map(|b| place(b) as u16).collect(),
        levels,
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_figures::{arm, moving};
    use super::*;
    use articula_core::Morph;
    use glam::{Quat, Vec3};
    use std::sync::Arc;

    #[test]
    fn every_level_has_the_morphs_of_the_mesh() {
        let mut asset = arm(3);
        asset.clips = vec![moving(3, 2, &[-0.4, 0.4].map(Quat::from_rotation_z))];
        // The first vertex hangs on the root alone: no level changes its skin.
        let smile = Morph {
            slot: 0,
            vertices: vec![0],
            positions: vec![Vec3::X * 0.05],
            normals: vec![Vec3::Z * 0.1],
        };
        Arc::make_mut(&mut asset.mesh).morphs = vec![smile];
        let order: Vec<u16> = vec![0, 1, 2];
        let mean = super::super::mean_pose(&asset);
        let joint_lods = JointLods::new(&asset.rig, order, vec![3, 1], &mean).unwrap();
        let skins = level_skins(&asset, &joint_lods, &JointLodOptions::default()).unwrap();
        assert_eq!(skins.levels.len(), 2);
        for level in &skins.levels {
            assert_eq!(level.morphs, asset.mesh.morphs);
        }
    }

    #[test]
    fn a_part_of_a_skin_has_the_influences_of_its_vertices() {
        let skin = LevelSkin {
            positions: [0.0, 1.0, 2.0].map(|x| Vec3::X * x).to_vec(),
            influences: 2,
            binding_indices: vec![0, 1, 2, 3, 4, 5],
            weights: vec![0.5, 0.5, 0.25, 0.75, 1.0, 0.0],
            ..LevelSkin::default()
        };
        let found = skin_part(&skin, &[], &[2, 0]);
        assert_eq!(found.positions, [Vec3::X * 2.0, Vec3::ZERO]);
        assert_eq!(found.influences, 2);
        assert_eq!(found.binding_indices, [4, 5, 0, 1]);
        assert_eq!(found.weights, [1.0, 0.0, 0.5, 0.5]);
    }
}
