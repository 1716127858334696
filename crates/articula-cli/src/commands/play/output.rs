//! Where pictures go.

use super::screen::Screen;
use crate::console::Console;
use crate::files;
use articula::flat::Picture;
use std::path::Path;

/// Width and height of pictures that are written.
const WRITTEN_PX: (u32, u32) = (480, 640);

/// Where pictures go.
pub(super) enum Output<'a> {
    Terminal(Screen),
    Folder(&'a Console, &'a Path),
    /// Drawn, and measured alone.
    Nowhere,
}

impl Output<'_> {
    /// Width and height of a picture, with a monitor below it or one line.
    pub(super) fn size(&self, has_monitor: bool) -> (u32, u32) {
        match self {
            Self::Terminal(screen) => screen.size(has_monitor),
            Self::Folder(..) | Self::Nowhere => WRITTEN_PX,
        }
    }

    pub(super) fn show(
        &mut self,
        number: usize,
        picture: &Picture,
        below: &[String],
    ) -> anyhow::Result<()> {
        match self {
            Self::Terminal(screen) => screen.show(picture, below),
            Self::Folder(console, folder) => {
                let path = folder.join(format!("{number:05}.png"));
                files::write_png(&console.files, &path, picture).map(drop)
            }
            Self::Nowhere => Ok(()),
        }
    }
}
