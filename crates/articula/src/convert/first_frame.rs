//! Removal of the first frame of clips.

use crate::error::{Context, Result};
use crate::open::CharacterFile;
use articula_build::clip_edit;

impl CharacterFile {
    /// Removes the first frame of every clip: captures often begin with a frame of the rest pose.
    /// Clips of fewer than three frames are unchanged.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) that names the file and the malformed clip.
    pub fn skip_first_frames(&mut self) -> Result<()> {
        for clip in &mut self.character.clips {
            *clip = clip_edit::skip_first_frame(clip).context(&self.name)?;
        }
        self.clips_changed = true;
        Ok(())
    }
}
