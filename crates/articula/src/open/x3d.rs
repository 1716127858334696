//! H-Anim figures in X3D and VRML97.

use super::{CharacterFile, Input};
use crate::error::Result;
use articula_formats::x3d::{self, Site};
use std::collections::{BTreeMap, BTreeSet};

/// Reads an X3D file and the pictures that it refers to.
pub(super) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    let read = x3d::read(input.bytes, &input.options.limits, input.beside)?;
    let file = read.value;
    let mut opened = input.opened(file.character, read.warnings, None);
    opened.end_sites = end_sites(&opened, &file.sites);
    opened.scale_lengths(input.options.unit_metres);
    Ok(opened)
}

/// End of each leaf joint: the named site that is farthest from the joint.
fn end_sites(opened: &CharacterFile, sites: &[Site]) -> Vec<(usize, glam::Vec3)> {
    let joints = &opened.character.skeleton.joints;
    let parents: BTreeSet<usize> = joints.iter().filter_map(|j| j.parent).collect();
    let mut ends: BTreeMap<usize, glam::Vec3> = BTreeMap::new();
    for site in sites.iter().filter(|s| !parents.contains(&s.joint)) {
        let end = ends.entry(site.joint).or_default();
        if site.offset.length() > end.length() {
            *end = site.offset;
        }
    }
    ends.into_iter().collect()
}
