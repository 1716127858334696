//! H-Anim figures in X3D and VRML97.

use super::{Loaded, Source};
use crate::files;
use articula_formats::x3d::{self, Site};
use std::collections::{BTreeMap, BTreeSet};

/// Reads an X3D file and the pictures that lie beside it.
pub(super) fn load(source: &Source<'_>) -> anyhow::Result<Loaded> {
    let mut fetch = files::beside(source.path, source.limits.bytes);
    let read = x3d::read(source.bytes, &source.limits, &mut fetch)?;
    let file = read.value;
    let mut loaded = source.loaded(file.character, read.warnings, None);
    loaded.end_sites = end_sites(&loaded, &file.sites);
    Ok(loaded)
}

/// The far end of each last joint, where the file names it: the site farthest from the joint.
fn end_sites(loaded: &Loaded, sites: &[Site]) -> Vec<(usize, glam::Vec3)> {
    let joints = &loaded.character.skeleton.joints;
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
