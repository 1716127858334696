//! BVA files: segments without a hierarchy, which is rebuilt if their names are known.

use super::{CharacterFile, Input};
use crate::error::Result;
use articula_build::joint_names;
use articula_formats::{ReadOptions, Warning, bva, joint_map};

/// Reads a BVA file.
pub(super) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    let options = ReadOptions {
        scale_to_metres: input.options.unit_metres,
        up: input.options.up,
        ..ReadOptions::default()
    };
    let read = bva::read(input.bytes, &options, &input.options.limits)?;
    let mut warnings = read.warnings;
    let mut character = read.value.character.clone();
    let segments = |maps| joint_names::segments(&read.value.character.skeleton, maps);
    let known = segments(input.joint_maps).or_else(|| segments(joint_map::builtin()));
    if let Some(tree) = known.and_then(|s| bva::tree(&read.value, &s)) {
        character = tree.value;
        warnings.extend(tree.warnings);
    } else {
        let what = "the format has no hierarchy, and the names of the segments are unknown (give \
                    a joint map); the segments move independently";
        warnings.push(Warning {
            at: "file".to_owned(),
            what: what.to_owned(),
            guess: None,
        });
    }
    Ok(input.opened(character, warnings, None))
}
