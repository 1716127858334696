//! Fewer joints in the skins of a file: those that are missed least are merged into the joints above them.
//!
//! The order is that of merged levels, with joints at rest: `docs/methods/motion-lod.md` part 8.

use super::OptimizeOptions;
use super::errors::Errors;
use super::source::Source;
use crate::error::{Context, Error, Result};
use crate::work::Executor;
use articula_build::{ClipOptions, JointLodOptions, character, joint_lods};
use articula_core::source::{Character, Property};
use articula_core::{Articulation, JointSet};
use serde::Serialize;
use std::collections::BTreeSet;

/// Joints that were merged.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MergedJoints {
    /// Number of joints of all skins before.
    pub joints_in: usize,
    /// Number of joints of all skins after.
    pub joints_out: usize,
    /// Names of the joints that were merged. They stay as nodes, at rest.
    pub merged: Vec<String>,
    /// Greatest error of a vertex by it, at rest and over all clips, in millimetres.
    pub error_mm: f32,
}

/// The source with at most a number of joints in its skins.
pub(super) fn merged_joints(
    source: &Source,
    max: usize,
    options: &OptimizeOptions,
    work: &Executor<'_>,
) -> Result<(Source, MergedJoints)> {
    if source.keeps_arrays() {
        let what =
            "joints: an extension that is not known may refer to arrays, so skins stay as they are";
        return Err(Error::unsuited(what));
    }
    let (shown, joints_in) = (&source.character, skinned(&source.character).len());
    let ranked = |()| ranked(source);
    let ranked = work.map("ranking joints", vec![()], ranked)?;
    let Some(ranked) = ranked.into_iter().next() else {
        return Err(Error::unsuited("joints: there are none"));
    };
    let fits = (ranked.least..=ranked.order.len()).rev();
    let mut fits = fits.map(|count| Merge::new(shown, &ranked.order[..count]));
    let Some(merge) = fits.find(|merge| merge.skinned.len() <= max) else {
        let fewest = Merge::new(shown, &ranked.order[..ranked.least])
            .skinned
            .len();
        let what = format!(
            "joints: the skins have {joints_in}, allowed are {max}, {fewest} are the fewest"
        );
        return Err(Error::unsuited(what));
    };
    let fewer = merge.applied(source)?;
    let error = Errors::measured(source, &fewer, options, work)?;
    let name = |joint: &usize| shown.skeleton.joints[*joint].name.clone();
    let report = MergedJoints {
        joints_in,
        joints_out: merge.skinned.len(),
        merged: merge.into.iter().map(|(joint, _)| name(joint)).collect(),
        error_mm: 1e3 * error.greatest(),
    };
    Ok((fewer, report))
}

/// The joints of all skins.
fn skinned(character: &Character) -> BTreeSet<usize> {
    let joints = character.skeleton.joints.iter().enumerate();
    let skinned = joints.filter(|(_, joint)| joint.in_skin);
    skinned.map(|(joint, _)| joint).collect()
}

/// Joints in the order in which they are kept.
struct Ranked {
    order: Vec<usize>,
    /// Number of the first that are kept always.
    least: usize,
}

fn ranked(source: &Source) -> Result<Ranked> {
    let shown = &source.character;
    let own = Articulation::unmapped(shown.skeleton.joints.len());
    let asset = character(shown, Some(own), &ClipOptions::default())?;
    // Meshes without a skin hang from their node alone.
    let rigid = shown.meshes.iter().flat_map(|mesh| &mesh.skin.joints);
    let rigid = rigid.filter(|joint| !shown.skeleton.joints[**joint].in_skin);
    let mut protected = JointSet::EMPTY;
    rigid.for_each(|joint| protected.insert(*joint));
    let options = JointLodOptions {
        protected,
        max_levels: 1,
        ..JointLodOptions::default()
    };
    let found = joint_lods(&asset, asset.rig.rest_pose(), &options)?;
    let order: Vec<usize> = found.joints().iter().map(|j| usize::from(*j)).collect();
    let last = order.iter().rposition(|joint| protected.contains(*joint));
    Ok(Ranked {
        least: last.map_or(1, |last| last + 1).min(order.len()),
        order,
    })
}

/// Joints of skins that are merged, the last of the order first, each with the nearest kept joint above.
struct Merge {
    into: Vec<(usize, usize)>,
    /// Joints that do not move any more.
    still: BTreeSet<usize>,
    /// Joints of the skins that are left.
    skinned: BTreeSet<usize>,
}

impl Merge {
    fn new(character: &Character, kept: &[usize]) -> Self {
        let joints = &character.skeleton.joints;
        let mut is_kept = vec![false; joints.len()];
        kept.iter().for_each(|joint| is_kept[*joint] = true);
        let above = |joint: usize| {
            let parent = |joint: &usize| joints[*joint].parent.filter(|parent| parent < joint);
            std::iter::successors(Some(joint), parent).find(|joint| is_kept[*joint])
        };
        let (mut skinned, mut into) = (skinned(character), Vec::new());
        for joint in (0..joints.len()).rev() {
            let Some(above) = above(joint).filter(|above| *above != joint) else {
                continue;
            };
            if skinned.remove(&joint) {
                into.push((joint, above));
            }
        }
        skinned.extend(into.iter().map(|(_, above)| *above));
        let still = (0..joints.len()).filter(|joint| !is_kept[*joint]);
        Self {
            still: still.collect(),
            skinned,
            into,
        }
    }

    /// The source with these joints merged. Its vertices are the same.
    fn applied(&self, source: &Source) -> Result<Source> {
        let mut document = source.file.document.clone();
        let rest = source.character.skeleton.model_rest();
        let nodes = &source.file.node_of_joint;
        for (joint, above) in &self.into {
            let place = rest[*above].inverse() * rest[*joint];
            let given = document.give_skin(nodes[*joint], nodes[*above], place);
            given.context(&source.character.skeleton.joints[*joint].name)?;
        }
        let mut clips = source.character.clips.clone();
        for clip in &mut clips {
            let is_of_joint = |property| {
                matches!(
                    property,
                    Property::Translation | Property::Rotation | Property::Scale
                )
            };
            clip.channels
                .retain(|c| !is_of_joint(c.property) || !self.still.contains(&c.target));
        }
        document.replace_keys(&clips, nodes, &source.file.node_of_mesh)?;
        Source::as_stored(document)
    }
}
