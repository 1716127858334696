//! A motion stream that is decoded onto the character that it was made from.

use super::{CharacterFile, Format};
use crate::clip_streams::abp2;
use crate::error::{Context, Result};
use articula_core::Rig;
use articula_formats::Limits;

impl CharacterFile {
    /// Decodes a motion stream (ABP-2), or a prefix of one, onto the character that it was made from.
    /// The result is this character with the clip alone; `name` identifies the stream in errors.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) that names the file: the bytes are no ABP-2 stream or are malformed, or the stream
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
