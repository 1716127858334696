//! ABP files: the motion of a skeleton as a stream that can be cut, and its text.

use crate::clip_streams::{StreamKind, abp1, stream_limits};
use crate::error::{Error, Result};
use crate::open::{CharacterFile, Input};
use articula_stream::abp1::{Abp1Clip, AbsentBone, read, read_text};

/// Reads a stream, by how it begins.
pub(in crate::open) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    match StreamKind::of(input.bytes) {
        Some(StreamKind::Abp1) => {
            let limits = stream_limits(&input.options.limits);
            opened(input, &read(input.bytes, AbsentBone::Rest, &limits)?)
        }
        Some(StreamKind::Abp2) => Err(Error::unsuited(
            "a motion stream (ABP-2) has no skeleton; give the character that it was made from, as \
             in `articula convert walk.abp out.glb --onto figure.glb`",
        )),
        _ => Err(Error::unsuited(
            "the file does not begin as a stream of a motion does, with ABPF or ABP2",
        )),
    }
}

/// Reads the text of an ABP-1 stream.
pub(in crate::open) fn open_text(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    let limits = stream_limits(&input.options.limits);
    opened(input, &read_text(input.bytes, &limits)?)
}

fn opened(input: &Input<'_, '_>, clip: &Abp1Clip) -> Result<CharacterFile> {
    if clip.bones.is_empty() {
        return Err(Error::unsuited("bones: the stream has none"));
    }
    let (character, warnings) = abp1::to_character(clip);
    let mut opened = input.opened(character, warnings, None);
    let mut articulation = opened.mapping.articulation.clone();
    abp1::set_articulation(&clip.bones, &mut articulation);
    opened.character.articulation = Some(articulation);
    opened.scale_lengths(input.options.unit_metres);
    Ok(opened)
}
