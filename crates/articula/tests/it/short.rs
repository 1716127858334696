//! Clips cut short: what is tested shows in few frames.

use articula::CharacterFile;
use articula_build::clip_edit::trim;

/// Cuts all clips of a character to their beginning.
pub(crate) fn shortened(mut file: CharacterFile, secs: f32) -> CharacterFile {
    for clip in file.clips_mut() {
        if clip.duration_secs > secs {
            *clip = trim(clip, 0.0..=secs).unwrap();
        }
    }
    file
}
