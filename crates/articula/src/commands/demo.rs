//! Placeholder
use crate::console::Console;
/// x
#[derive(Debug, clap::Args)]
pub(crate) struct DemoArgs {}
pub(crate) fn run(_a: &DemoArgs, _c: &Console) -> anyhow::Result<()> {
    Ok(())
}
