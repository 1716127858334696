//! The files of the demo, in the order in which they are made.

use articula::Result;
use articula::flat::Picture;

/// A file: its name and its bytes.
pub type DemoFile = (&'static str, Vec<u8>);

/// The files so far.
#[derive(Debug, Default)]
pub(super) struct DemoFiles(pub(super) Vec<DemoFile>);

impl DemoFiles {
    pub(super) fn add(&mut self, name: &'static str, bytes: impl Into<Vec<u8>>) {
        self.0.push((name, bytes.into()));
    }

    pub(super) fn add_png(&mut self, name: &'static str, picture: &Picture) -> Result<()> {
        self.add(name, picture.to_png()?);
        Ok(())
    }
}
