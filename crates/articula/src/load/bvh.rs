//! BVH files.

use super::{Loaded, Source};
use articula_formats::bvh;

/// Reads a BVH file; the unit and the up axis are the user's or a guess.
pub(super) fn load(source: &Source<'_>) -> anyhow::Result<Loaded> {
    let options = bvh::ReadOptions {
        scale_to_metres: source.args.unit_metres,
        up: source.args.up(),
    };
    let read = bvh::read(source.bytes, &options, &source.limits)?;
    let mut loaded = source.loaded(read.value.character, read.warnings, None);
    loaded.end_sites = read.value.end_sites;
    Ok(loaded)
}
