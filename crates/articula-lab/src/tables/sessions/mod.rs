//! A server under load: sessions at once with their latency, and objects beside nginx.
//!
//! Server and clients run in one process on all processors, over the loopback address, so each costs the other.
//!
//! - `load`: clients of sessions
//! - `objects`: requests for objects, ours and of nginx

mod load;
mod objects;

use super::Run;
use super::served::Served;
use anyhow::{Context, Result};
use clap::Args;
use load::Load;

use std::path::Path;

/// The character that is served.
const CHARACTER: &str = "glb/KayKit_Knight.glb";
/// The same where only the repository's own files are.
const SMALL: &str = "base.glb";

/// How much is asked of the server.
#[derive(Debug, Clone, Args)]
pub(crate) struct Choice {
    /// Sessions at once
    #[arg(long, default_value_t = 1000)]
    sessions: usize,
    /// Bandwidth of each session, kbit/s
    #[arg(long, default_value_t = 26.0)]
    kbps: f64,
    /// Seconds of load
    #[arg(long, default_value_t = 60.0)]
    secs: f64,
}

/// Writes the page.
pub(crate) fn write(run: &Run, choice: &Choice) -> Result<()> {
    let choice = match run.small {
        true => Choice {
            sessions: 20,
            kbps: 26.0,
            secs: 2.0,
        },
        false => choice.clone(),
    };
    let name = if run.small { SMALL } else { CHARACTER };
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("character.glb");
    let source = run.data.join(name);
    std::fs::copy(&source, &file).with_context(|| source.display().to_string())?;
    let served = Served::start(folder.path())?;
    let load = Load::run(&served, choice.sessions, 1e3 * choice.kbps, choice.secs)?;
    let objects = objects::compare(&served, folder.path(), if run.small { 200 } else { 20_000 })?;
    let mut page = String::new();
    page.push_str(INTRODUCTION);
    load.write(&mut page, &choice_line(&choice, name));
    objects.write(&mut page);
    let csv = load.csv();
    run.save("sessions", &page, &csv)
}

fn choice_line(choice: &Choice, name: &str) -> String {
    let name = Path::new(name)
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy();
    format!(
        "{} sessions of {name} at {} kbit/s each for {} s",
        choice.sessions, choice.kbps, choice.secs
    )
}

const INTRODUCTION: &str = "# Sessions and objects under load\n\n\
Made by `articula-lab sessions`. Server and clients run in one process and share its processors, over the \
loopback address. A session has the figure, the mesh and the textures, asks for the motions at its bandwidth, forgets them when all have come, and moves nearer or farther once a second; the latency is the time from that message to the decision \
about it. Clients read messages and decode nothing.\n\n";
