//! Devices made of one machine, and the rates that `articula bench device` finds on each.

use anyhow::{Context, Result, bail};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};

/// Most seconds of frames of an application.
const SECONDS: &str = "120";
/// The processor that two programs share.
const SHARED: &str = "0";
/// Names of the emulator, the usual one first.
const EMULATORS: [&str; 2] = ["qemu-aarch64-static", "qemu-aarch64"];
const LINKER: &str = "aarch64-linux-gnu-gcc";

/// How a device is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Making {
    /// The program as it is, with these flags.
    Flags(&'static [&'static str]),
    /// On one core with another program of the same priority.
    Shared,
    /// The program of the development profile.
    Development,
    /// The program for AArch64 under emulation.
    Emulated,
    /// The module for web pages, in node.
    Node,
}

/// A device made of this machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Device {
    pub(super) name: &'static str,
    pub(super) making: Making,
}

/// The devices. Instruction sets matter to crowds alone.
pub(super) const DEVICES: [Device; 9] = [
    device("AVX-512", Making::Flags(&["--backend", "avx512"])),
    device("AVX2", Making::Flags(&["--backend", "avx2"])),
    device("SSE2", Making::Flags(&["--backend", "sse2"])),
    device("scalar", Making::Flags(&["--backend", "scalar"])),
    device("two threads", Making::Flags(&["--threads", "2"])),
    device("shared core", Making::Shared),
    device("development build", Making::Development),
    device("emulated AArch64", Making::Emulated),
    device("WebAssembly in node", Making::Node),
];

const fn device(name: &'static str, making: Making) -> Device {
    Device { name, making }
}

/// A frame rate that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rate {
    pub(super) fps: f64,
    pub(super) runs: usize,
}

/// What is read of a report, and of the result of the module.
#[derive(Deserialize)]
#[serde(untagged)]
enum Report {
    Device { results: Vec<Played> },
    Application(Played),
}

#[derive(Deserialize)]
struct Played {
    grades: Vec<GradeRate>,
}

#[derive(Deserialize)]
struct GradeRate {
    grade: usize,
    fps: f64,
    runs: usize,
}

/// A program that runs until it is dropped.
struct Neighbour(Child);

impl Drop for Neighbour {
    fn drop(&mut self) {
        // It has ended already, or ends now.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The programs of the build folder.
#[derive(Debug)]
pub(super) struct Programs(pub(super) PathBuf);

impl Programs {
    /// The rates of some grades of an application on a device, with another character in place of the
    /// mannequin if one is given.
    pub(super) fn rates(
        &self,
        device: &Device,
        application: &str,
        grades: &[usize],
        character: Option<&Path>,
    ) -> Result<Vec<Rate>> {
        let mut words = self.words(device.making)?;
        let neighbour = match device.making {
            Making::Shared => Some(neighbour()?),
            _ => None,
        };
        let list: Vec<String> = grades.iter().map(usize::to_string).collect();
        let list = list.join(",");
        if device.making == Making::Node {
            let file = match character {
                Some(path) => path.display().to_string(),
                None => self.human()?,
            };
            words.extend([file, application.to_owned(), list, SECONDS.to_owned()]);
        } else {
            words.extend(["--json", "bench", "device"].map(str::to_owned));
            words.extend(["--application", application, "--seconds", SECONDS].map(str::to_owned));
            words.extend(["--grades".to_owned(), list]);
            if let Making::Flags(flags) = device.making {
                words.extend(flags.iter().map(|flag| (*flag).to_owned()));
            }
            words.extend(character.map(|path| path.display().to_string()));
        }
        let output = Command::new(&words[0]).args(&words[1..]).output();
        let output = output.with_context(|| words[0].clone())?;
        drop(neighbour);
        if !output.status.success() {
            bail!(
                "{}: {}",
                words.join(" "),
                String::from_utf8_lossy(&output.stderr)
            );
        }
        let report: Report = serde_json::from_slice(&output.stdout)?;
        let played = match report {
            Report::Device { results } => results.into_iter().next().context("no result")?,
            Report::Application(played) => played,
        };
        let rate = |grade: &usize| {
            let mut found = played.grades.iter();
            let found = found.find(|rate| rate.grade == *grade);
            let found =
                found.with_context(|| format!("{application}: grade {grade} is too slow"))?;
            Ok(Rate {
                fps: found.fps,
                runs: found.runs,
            })
        };
        grades.iter().map(rate).collect()
    }

    /// The program that is called, and what it needs before its arguments.
    fn words(&self, making: Making) -> Result<Vec<String>> {
        let built = |folder: &str| -> Result<String> {
            let path = self.0.join(folder).join("articula");
            if !path.is_file() {
                bail!("{}: not built", path.display());
            }
            Ok(path.display().to_string())
        };
        Ok(match making {
            Making::Flags(_) => vec![built("release")?],
            Making::Shared => vec![
                "taskset".into(),
                "-c".into(),
                SHARED.into(),
                built("release")?,
            ],
            Making::Development => vec![built("debug")?],
            Making::Emulated => {
                let program = built("aarch64-unknown-linux-gnu/release")?;
                let runs = |name: &&str| Command::new(name).arg("--version").output().is_ok();
                let mut names = EMULATORS.into_iter();
                let emulator = names.find(runs).context("no qemu-aarch64")?;
                let libraries = libraries().context("no C library of AArch64")?;
                vec![emulator.into(), "-L".into(), libraries, program]
            }
            Making::Node => {
                let web = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../web");
                let modules = web.join("packages/core/wasm");
                if !modules.join("publish.js").is_file() {
                    bail!("{}: not built", modules.display());
                }
                let paths = [web.join("bench/device.mjs"), modules];
                let paths = paths.map(|path| path.display().to_string());
                [&["node".to_owned()], &paths[..]].concat()
            }
        })
    }

    /// A file of the mannequin, which the module is given.
    fn human(&self) -> Result<String> {
        let words = self.words(Making::Flags(&[]))?;
        let path = std::env::temp_dir().join("articula-mannequin.glb");
        let path = path.display().to_string();
        let output = Command::new(&words[0])
            .args(["--force", "human", "--mannequin", &path])
            .output();
        let output = output.with_context(|| words[0].clone())?;
        match output.status.success() {
            true => Ok(path),
            false => bail!("human: {}", String::from_utf8_lossy(&output.stderr)),
        }
    }
}

/// A program that is busy on the shared core for as long as it runs.
fn neighbour() -> Result<Neighbour> {
    let words = ["-c", SHARED, "sh", "-c", "while :; do :; done"];
    let child = Command::new("taskset").args(words).spawn();
    Ok(Neighbour(child.context("taskset")?))
}

/// The folder with the loader and the C library that the linker of AArch64 uses.
fn libraries() -> Option<String> {
    let named = Command::new(LINKER)
        .arg("-print-file-name=libc.so")
        .output();
    let file = String::from_utf8(named.ok()?.stdout).ok()?;
    let file = Path::new(file.trim()).canonicalize().ok()?;
    Some(file.parent()?.parent()?.display().to_string())
}
