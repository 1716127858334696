//! A motion stream that is decoded onto the character that it was made from.

use super::{CharacterFile, Format};
use crate::clip_streams::{AccessUnitCount, abp2, stream_limits};
use crate::error::{Context, Result};
use articula_core::Rig;
use articula_formats::Limits;
use articula_stream::StreamLimits;
use articula_stream::abp2::MotionHead;

impl CharacterFile {
    /// Returns whether a motion stream (ABP-2) says that it was made from this character.
    pub fn is_of_motion(&self, stream: &[u8], limits: &StreamLimits) -> bool {
        let rig = Rig::new(&self.character.skeleton, self.articulation());
        let head = MotionHead::open(stream, limits);
        matches!((rig, head), (Ok(rig), Ok(head)) if abp2::is_of_rig(&head, &rig))
    }

    /// Decodes a motion stream (ABP-2), or a prefix of one, onto the character that it was made from.
    /// The result is this character with the clip alone, and with a warning if access units are missing;
    /// `name` identifies the stream in errors.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) that names the file: the bytes are no ABP-2 stream, or are malformed or damaged, or
    /// the stream was made for another character.
    pub fn decode_motion(&self, bytes: &[u8], name: &str, limits: &Limits) -> Result<Self> {
        let rig = Rig::new(&self.character.skeleton, self.articulation()).context(name)?;
        let clip = abp2::decode(bytes, &rig, &self.name, limits).context(name)?;
        let count = AccessUnitCount::in_stream(bytes, &stream_limits(limits)).context(name)?;
        let clip = abp2::raw_clip(&clip, &self.character.meshes);
        let mut opened = Self {
            name: name.to_owned(),
            format: Format::Abp,
            bytes: bytes.len(),
            warnings: count
                .and_then(|count| count.warning())
                .into_iter()
                .collect(),
            ..self.clone()
        };
        opened.set_clips(vec![clip]);
        Ok(opened)
    }
}
