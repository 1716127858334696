//! The bandwidth of a client changes while it plays: what it shows, and how soon (the thesis' 6.2.3, table 6.4).

use super::Run;
use super::devices::Builds;
use super::served::Served;
use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

/// The character that is served.
const CHARACTER: &str = "glb/KayKit_Knight.glb";
/// The same where only the repository's own files are.
const SMALL: &str = "base.glb";
/// Movements of the slider: a name, seconds after the first picture with kbit/s, seconds in all.
const MOVEMENTS: [(&str, &str, &str); 2] = [
    (
        "From full to the least to a medium one",
        "0:full,6:16,12:64",
        "18",
    ),
    (
        "From the least to a medium one to full",
        "0:16,6:64,12:full",
        "18",
    ),
];
const SMALL_MOVEMENTS: [(&str, &str, &str); 1] = [("Up", "0:16,0.5:full", "1")];

/// What is read of a report of `articula play`.
#[derive(Deserialize)]
struct Played {
    phases: Vec<Phase>,
}

/// The time between two movements of the slider.
#[derive(Deserialize)]
struct Phase {
    slider_bps: Option<f64>,
    bytes_per_second: f64,
    fps: f64,
    frame_ms: f64,
    joints: f64,
    error_px: Option<f64>,
    memory_bytes: Option<u64>,
    stalls: u64,
    decided_secs: Option<f64>,
    shown_secs: Option<f64>,
}

/// Writes the page.
pub(crate) fn write(run: &Run, builds: &Builds) -> Result<()> {
    let program = builds.folder().join("release/articula");
    ensure!(program.is_file(), "{}: not built", program.display());
    let name = if run.small { SMALL } else { CHARACTER };
    let folder = tempfile::tempdir()?;
    let source = run.data.join(name);
    std::fs::copy(&source, folder.path().join("character.glb"))
        .with_context(|| source.display().to_string())?;
    let served = Served::start(folder.path())?;
    let url = format!("http://{}", served.at);
    let mut page = HEAD.to_owned();
    let mut csv = "movement,by,kbps,bytes_per_second,joints,fps,frame_ms,error_px,memory_bytes,stalls,decided_secs,shown_secs\n".to_owned();
    let movements: &[_] = if run.small {
        &SMALL_MOVEMENTS
    } else {
        &MOVEMENTS
    };
    for (title, slider, seconds) in movements {
        writeln!(page, "\n## {title}")?;
        for (by, flags) in [("session", &["--session"][..]), ("HTTP", &[])] {
            let words = [&["--slider", slider, "--seconds", seconds], flags].concat();
            let played = play(&program, &url, &words)?;
            section(&mut page, by, &played)?;
            for phase in &played.phases {
                rows(&mut csv, slider, by, phase)?;
            }
        }
    }
    run.save("slider", &page, &csv)
}

/// Plays the character, and returns the report.
fn play(program: &Path, url: &str, words: &[&str]) -> Result<Played> {
    let output = Command::new(program)
        .args(["--json", "play", url])
        .args(words)
        .output()
        .with_context(|| program.display().to_string())?;
    if !output.status.success() {
        bail!(
            "play {}: {}",
            words.join(" "),
            String::from_utf8_lossy(&output.stderr)
        );
    }
    Ok(serde_json::from_slice(&output.stdout)?)
}

fn section(page: &mut String, by: &str, played: &Played) -> Result<()> {
    writeln!(
        page,
        "\nBy {by}.\n\n\
         | kbit/s | kB/s | joints | pictures/s | ms each | error, px | memory, MB | stalls | decided after | shown after |\n\
         | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    )?;
    let secs = |secs: Option<f64>| secs.map_or("-".into(), |secs| format!("{secs:.2} s"));
    for phase in &played.phases {
        let (bps, error) = (phase.slider_bps, phase.error_px);
        writeln!(
            page,
            "| {} | {:.1} | {:.1} | {:.0} | {:.1} | {} | {} | {} | {} | {} |",
            bps.map_or("full".into(), |bps| format!("{:.0}", bps / 1e3)),
            phase.bytes_per_second / 1e3,
            phase.joints,
            phase.fps,
            phase.frame_ms,
            error.map_or("-".into(), |px| format!("{px:.2}")),
            phase
                .memory_bytes
                .map_or("-".into(), |bytes| format!("{:.0}", bytes as f64 / 1e6)),
            phase.stalls,
            secs(phase.decided_secs),
            secs(phase.shown_secs),
        )?;
    }
    Ok(())
}

fn rows(csv: &mut String, slider: &str, by: &str, phase: &Phase) -> Result<()> {
    let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    writeln!(
        csv,
        "\"{slider}\",{by},{},{:.0},{:.2},{:.1},{:.2},{},{},{},{},{}",
        number(phase.slider_bps.map(|bps| bps / 1e3)),
        phase.bytes_per_second,
        phase.joints,
        phase.fps,
        phase.frame_ms,
        number(phase.error_px),
        number(phase.memory_bytes.map(|bytes| bytes as f64)),
        phase.stalls,
        number(phase.decided_secs),
        number(phase.shown_secs),
    )?;
    Ok(())
}

const HEAD: &str = "# A slider of bandwidth

Made by `cargo run --release -p articula-lab -- slider`, after `cargo build --release -p articula-cli`.

The run of the thesis' table 6.4: a client plays a character of a server while the bandwidth that it may use is changed, in a
[session](../formats/session.md), in which the server decides, and over HTTP, where the client does. Server and client run on one machine; the client
draws each picture by software. *Joints* are those that were sampled, in the mean; *decided after* and *shown after* are the times until another level
was chosen and until something with another error played. What a client holds is never dropped when the slider falls, nor sent again when it rises: once
all of a clip has come, a lower rate costs nothing.
";
