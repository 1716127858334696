//! A character ready to be played: rig, mesh and clips built from what was opened.

use crate::error::{Context, Error, Result};
use crate::open::{CharacterFile, choose};
use articula_build::ClipOptions;
use articula_build::{Asset, character};

/// A character that was opened, and what a frame needs of it.
#[derive(Debug)]
pub struct Figure {
    /// The file as it was opened.
    pub opened: CharacterFile,
    /// Rig, mesh and clips at a uniform rate.
    pub asset: Asset,
}

impl Figure {
    /// Builds rig, mesh and clips.
    ///
    /// # Errors
    /// An [`Error`] that names the file and what of it does not fit: no joint and no mesh, a tree
    /// with circles, more motion than memory should hold.
    pub fn new(opened: CharacterFile) -> Result<Self> {
        if opened.character.skeleton.joints.is_empty() {
            let what = "nodes: no joint and no mesh; give a file that shows a character";
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

    /// The index of the clip of this name, or of the first; `None` if there is no clip.
    ///
    /// # Errors
    /// [`Error::Argument`] if no clip is called so; it lists those there are.
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
