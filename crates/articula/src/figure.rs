//! A character ready for playback: rig, mesh and clips built from an opened file.

use crate::error::{Context, Error, Result};
use crate::open::{CharacterFile, choose};
use articula_build::ClipOptions;
use articula_build::{Asset, character};

/// An opened character with its runtime data: rig, mesh and clips.
#[derive(Debug)]
pub struct Figure {
    /// The editable character and the file that it was read from.
    pub opened: CharacterFile,
    /// Rig, mesh and uniformly sampled clips.
    pub asset: Asset,
}

impl Figure {
    /// Builds rig, mesh and clips.
    ///
    /// # Errors
    /// An [`Error`] that names the file and the cause: neither joint nor mesh, a cycle in the node
    /// hierarchy, or more motion than fits in memory.
    pub fn new(opened: CharacterFile) -> Result<Self> {
        if opened.character.skeleton.joints.is_empty() {
            let what = "nodes: the file has no joint and no mesh; give a file with a character";
            return Err(Error::unsuited(what)).context(&opened.name);
        }
        let articulation = opened.articulation();
        let asset = character(
            &opened.character,
            Some(articulation),
            &ClipOptions::default(),
        )
        .with_context(|| &opened.name)?;
        Ok(Self { opened, asset })
    }

    /// Returns the index of the clip called `name`, or of the first clip if `name` is `None`;
    /// `None` if there is no clip.
    ///
    /// # Errors
    /// [`Error::Argument`] if no clip has this name; the message lists the clips.
    pub fn clip(&self, name: Option<&str>) -> Result<Option<usize>> {
        let names = self.opened.character.clips.iter().map(|c| c.name.as_str());
        match name {
            Some(name) => choose("clip", name, names)
                .with_context(|| &self.opened.name)
                .map(Some),
            None => Ok((!self.asset.clips.is_empty()).then_some(0)),
        }
    }
}
