//! ABP files: the motion of a skeleton as a stream that can be cut, and its text.

use super::{CharacterFile, Format, Input};
use crate::error::{Context, Error, Result};
use crate::streams::{StreamKind, abp1, abp2, stream_limits};
use articula_core::Rig;
use articula_formats::Limits;
use articula_stream::abp1::{Abp1Clip, AbsentBone, read, read_text};

/// Reads a stream, by how it begins.
pub(super) fn open(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
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
pub(super) fn open_text(input: &mut Input<'_, '_>) -> Result<CharacterFile> {
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

impl CharacterFile {
    /// Decodes a motion stream (ABP-2), or a prefix of one, onto the character that it was made from.
    /// The result is this character with the clip alone; `name` identifies the stream in errors.
    ///
    /// # Errors
    /// An [`Error`] that names the file: the bytes are no ABP-2 stream or are malformed, or the stream
    /// was made for another character.
    pub fn decode_motion(&self, bytes: &[u8], name: &str, limits: &Limits) -> Result<Self> {
        let rig = Rig::new(&self.character.skeleton, self.articulation()).context(name)?;
        let clip = abp2::decode(bytes, &rig, &self.name, limits).context(name)?;
        let clip = abp2::raw_clip(&clip, &self.character.meshes);
        let mut opened = Self {
            name: name.to_owned(),
            format: Format::Abp,
            bytes: bytes.len(),
            warnings: Vec::new(),
            ..self.clone()
        };
        opened.set_clips(vec![clip]);
        Ok(opened)
    }
}
