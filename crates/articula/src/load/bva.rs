//! BVA files: segments without a hierarchy, put together if their names are known.

use super::{Loaded, Source};
use articula_formats::{Warning, bva};

/// Reads a BVA file.
pub(super) fn load(source: &Source<'_>) -> anyhow::Result<Loaded> {
    let options = bva::ReadOptions {
        scale_to_metres: source.args.unit_metres,
        up: source.args.up(),
    };
    let read = bva::read(source.bytes, &options, &source.limits)?;
    let mut warnings = read.warnings;
    let mut character = read.value.character.clone();
    if let Some(tree) =
        articula_build::joint_names::segments(&read.value.character.skeleton, source.profiles)
            .and_then(|s| bva::tree(&read.value, &s))
    {
        character = tree.character;
        warnings.extend(tree.warnings);
    } else {
        let what = "the format has no hierarchy, and the segments are not called like those of a human \
                    (--profile takes a map of your own); they move side by side";
        warnings.push(Warning::new("file", what));
    }
    Ok(source.loaded(character, warnings, None))
}
