//! Removal of the first frame of clips.

use crate::error::{Context, Result};
use crate::open::CharacterFile;
use articula_build::clip_edit;

impl CharacterFile {
    /// Removes the first frame of every clip: captures often begin with a frame of the rest pose.
    /// Clips of fewer than three frames are unchanged. Warnings about first frames are removed.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) that names the file and the malformed clip.
    pub fn skip_first_frames(&mut self) -> Result<()> {
        let clips = self.character().clips.iter();
        let skipped = clips.map(clip_edit::skip_first_frame).collect();
        let skipped: std::result::Result<Vec<_>, _> = skipped;
        let skipped = skipped.with_context(|| self.name())?;
        self.set_clips(skipped);
        self.forget_first_frames();
        Ok(())
    }
}
