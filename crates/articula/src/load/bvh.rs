//! BVH files.

use super::{Loaded, Source};
use crate::arguments::UpAxis;
use articula_formats::bvh;

/// Reads a BVH file; the unit and the up axis are the user's or a guess.
pub(super) fn load(source: &Source<'_>) -> anyhow::Result<Loaded> {
    let options = bvh::ReadOptions {
        scale_to_metres: source.args.unit_metres,
        up: match source.args.up {
            None => bvh::Up::Auto,
            Some(UpAxis::Y) => bvh::Up::Y,
            Some(UpAxis::Z) => bvh::Up::Z,
        },
    };
    let read = bvh::read(source.bytes, &options, &source.limits)?;
    let mut loaded = source.loaded(read.value.character, read.warnings, None);
    loaded.end_sites = read.value.end_sites;
    Ok(loaded)
}
