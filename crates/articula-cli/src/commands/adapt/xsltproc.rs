//! The installed xsltproc, which transforms descriptions by the stylesheet of an item.

use crate::files;
use anyhow::{Context, bail};
use articula::item::STYLESHEET;
use articula::stream::description::stylesheet;
use std::path::Path;
use std::process::Command;

/// xsltproc with the stylesheet, in a folder that is removed in the end.
pub(super) struct Xsltproc {
    folder: tempfile::TempDir,
}

impl Xsltproc {
    /// Checks that xsltproc is installed, and that the stylesheet of an item is the one that this
    /// program writes: others could read files of this machine, so they are not run.
    pub(super) fn new(item: &Path) -> anyhow::Result<Self> {
        let ours = stylesheet();
        let own = item.join(STYLESHEET);
        if own.exists() {
            let limit = 16 * ours.len() as u64;
            if files::read(&own, limit)? != ours.as_bytes() {
                bail!(
                    "{}: not the stylesheet that articula writes, so it is not run; replace it by \
                     articula gbsd stylesheet",
                    files::shown(&own)
                );
            }
        }
        let version = Command::new("xsltproc").arg("--version").output();
        version.context(
            "--engine xslt: xsltproc is not installed (Debian: apt install xsltproc); --engine \
             native needs nothing",
        )?;
        let folder = tempfile::tempdir().context("a temporary folder for xsltproc")?;
        std::fs::write(folder.path().join(STYLESHEET), ours).context("a temporary stylesheet")?;
        Ok(Self { folder })
    }

    /// Transforms a description.
    pub(super) fn transform(
        &mut self,
        description: &str,
        parameters: &[(&'static str, String)],
    ) -> Result<String, String> {
        const NAME: &str = "gbsd.xml";
        let failed = |e: std::io::Error| format!("xsltproc: {e}");
        std::fs::write(self.folder.path().join(NAME), description).map_err(failed)?;
        let mut command = Command::new("xsltproc");
        command
            .current_dir(self.folder.path())
            .args(["--nonet", "--nowrite", "--nomkdir"]);
        for (name, value) in parameters {
            command.args(["--stringparam", name, value]);
        }
        let output = command.args([STYLESHEET, NAME]).output().map_err(failed)?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let first = said.lines().next().unwrap_or("it failed");
            return Err(format!("xsltproc: {first}"));
        }
        String::from_utf8(output.stdout).map_err(|e| format!("xsltproc: {e}"))
    }
}
