//! Placeholder
use crate::console::Console;
/// x
#[derive(Debug, clap::Args)]
pub(crate) struct BuildArgs {}
pub(crate) fn run(_a: &BuildArgs, _c: &Console) -> anyhow::Result<()> {
    Ok(())
}
