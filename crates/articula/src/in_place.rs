//! Removal of root motion from the clips of a file.

use crate::crowd::put_in_place;
use crate::open::CharacterFile;
use articula_build::clip_edit::TrajectoryKey;

impl CharacterFile {
    /// Puts clips with root motion in place, as [`put_in_place`] does; returns the root motion of each
    /// such clip, relative to its start, and warnings about clips that travel but could not be changed.
    pub fn put_in_place(&mut self) -> (Vec<Option<Vec<TrajectoryKey>>>, Vec<String>) {
        let mut character = self.character().clone();
        let articulation = self.articulation();
        let (ways, warnings) = put_in_place(&mut character, articulation, self.end_sites());
        if ways.iter().any(Option::is_some) {
            self.set_clips(character.clips);
        }
        (ways, warnings)
    }
}
