//! ABP files: the motion of a skeleton as a stream that can be cut, and its text.

use crate::clip_streams::{AccessUnitCount, StreamKind, abp1, abp2, stream_limits};
use crate::error::{Error, Result};
use crate::open::{CharacterFile, Input};
use articula_core::Rig;
use articula_core::source::Character;
use articula_stream::abp1::{Abp1Clip, AbsentBone, read, read_text};
use articula_stream::abp2::CarriedSkeleton;

/// Reads a stream, by how it begins.
pub(in crate::open) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
    match StreamKind::of(input.bytes) {
        Some(StreamKind::Abp1) => {
            let limits = stream_limits(&input.options.limits);
            opened(input, &read(input.bytes, AbsentBone::Rest, &limits)?)
        }
        Some(StreamKind::Abp2) => open_motion(input),
        _ => Err(Error::unsuited(
            "the file does not begin as a stream of a motion does, with ABPF or ABP2",
        )),
    }
}

/// Reads a motion stream that carries the skeleton.
fn open_motion(input: &Input<'_, '_>) -> Result<CharacterFile> {
    let limits = &input.options.limits;
    let of_streams = stream_limits(limits);
    let Some(carried) = CarriedSkeleton::open(input.bytes, &of_streams)? else {
        return Err(Error::unsuited(
            "this motion stream (ABP-2) does not carry the skeleton, as those that are written with \
             --stream skeleton=yes; give the character that it was made from, as in `articula convert \
             walk.abp out.glb --onto figure.glb`",
        ));
    };
    let CarriedSkeleton {
        skeleton,
        articulation,
    } = carried;
    let rig = Rig::new(&skeleton, articulation.clone())?;
    let clip = abp2::decode(input.bytes, &rig, "its own skeleton", limits)?;
    let count = AccessUnitCount::in_stream(input.bytes, &of_streams)?;
    let warnings = count.and_then(|count| count.warning());
    let character = Character {
        name: clip.name.clone(),
        skeleton,
        clips: vec![abp2::raw_clip(&clip, &[])],
        ..Character::default()
    };
    let mut opened = input.opened(character, warnings.into_iter().collect(), None);
    let mut known = opened.mapping().articulation.clone();
    for (joint, carried) in known.joints.iter_mut().zip(&articulation.joints) {
        (joint.level, joint.region) = (carried.level, carried.region);
    }
    opened.character.articulation = Some(known);
    opened.scale_lengths(input.options.unit_metres);
    Ok(opened)
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
    let mut articulation = opened.mapping().articulation.clone();
    abp1::set_articulation(&clip.bones, &mut articulation);
    opened.character.articulation = Some(articulation);
    opened.scale_lengths(input.options.unit_metres);
    Ok(opened)
}
