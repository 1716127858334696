//! `articula convert IN OUT`: between formats, and to a reduced animation.

mod reduction;
mod written;

use crate::arguments::ReadArgs;
use crate::console::Console;
use crate::fault::clean;
use crate::load::{self, Format, Loaded, Writes};
use crate::play::saved;
use crate::table::counted;
use crate::{fault, files};
use anyhow::Context;
use articula_core::joint_state::PassivePolicy;
use clap::Args;
use reduction::Reduction;
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `convert`.
#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// File to read (.glb, .gltf, .vrm, .vrma, .bvh, ...)
    input: PathBuf,
    /// File to write; its extension names the format (.glb, .vrm, .vrma, .bvh, ...)
    out: PathBuf,
    /// Keep this clip alone [default: all; .bvh the first]
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
    /// Joints that may move, such as "loa(Low) + zone(hands)"; the others are held
    #[arg(long, value_name = "EXPR")]
    loa: Option<String>,
    /// Let every joint above one that may move, move too
    #[arg(long)]
    close_up: bool,
    /// The same from a saved selection
    #[arg(long, value_name = "F.json", conflicts_with = "loa")]
    loa_profile: Option<PathBuf>,
    /// What held joints show: hold, rest, key-pose, blend-to-rest:SECS [default: key-pose]
    #[arg(long, value_name = "POLICY", value_parser = saved::passive)]
    passive: Option<PassivePolicy>,
    #[command(flatten)]
    names: ReadArgs,
}

#[derive(Debug, Serialize)]
struct Report {
    #[serde(rename = "in")]
    input: String,
    out: String,
    format_in: &'static str,
    format_out: &'static str,
    bytes_in: usize,
    /// Of all files together.
    bytes_out: usize,
    /// Files that were written beside `out`.
    beside: Vec<String>,
    clips: Vec<String>,
    reduction: Option<Reduction>,
    /// What the format of the output cannot hold.
    left_out: Vec<String>,
    warnings: Vec<String>,
}

/// Reads, reduces if asked to, and writes.
pub(crate) fn run(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    let out = args.format_out()?;
    let mut loaded = load::character(&args.input, &args.names)?;
    check_pair(loaded.format, out)?;
    let place = loaded.place();
    let chosen = choose_clips(args, &mut loaded, out).context(place.clone())?;
    let reduction = reduction::apply(args, &mut loaded)?;
    let changed = chosen || reduction.is_some();
    let made = written::written(&mut loaded, &args.out, out, changed).context(place)?;
    for (path, bytes) in &made.files {
        files::write(path, bytes)?;
    }
    let reduced = reduction.is_some();
    let report = Report {
        input: loaded.place(),
        out: files::shown(&args.out),
        format_in: loaded.format.name(),
        format_out: out.name(),
        bytes_in: loaded.bytes,
        bytes_out: made.files.iter().map(|(_, bytes)| bytes.len()).sum(),
        beside: made.files[1..]
            .iter()
            .map(|(path, _)| files::shown(path))
            .collect(),
        clips: loaded
            .character
            .clips
            .iter()
            .map(|c| c.name.clone())
            .collect(),
        reduction,
        left_out: made.left_out,
        warnings: warnings(&loaded, out, reduced),
    };
    console.result(&report, text)
}

impl ConvertArgs {
    fn format_out(&self) -> anyhow::Result<Format> {
        let reduces = self.loa.is_some() || self.loa_profile.is_some();
        if (self.passive.is_some() || self.close_up) && !reduces {
            return Err(fault::usage(
                "--passive and --close-up need --loa EXPR or --loa-profile F.json",
            ));
        }
        Format::of_name(&self.out).ok_or_else(|| {
            let out = files::shown(&self.out);
            fault::usage(format!(
                "{out}: the extension names no format; converted are {}",
                load::conversions()
            ))
        })
    }
}

fn check_pair(input: Format, out: Format) -> anyhow::Result<()> {
    let fits = match out.writes() {
        Writes::Any => true,
        Writes::Back => input == out,
        Writes::Never => false,
    };
    if fits {
        return Ok(());
    }
    Err(fault::usage(format!(
        "{} to {} is not converted; converted are {}",
        input.name(),
        out.name(),
        load::conversions()
    )))
}

/// Keeps the clips that go into the output; says whether any was dropped.
fn choose_clips(args: &ConvertArgs, loaded: &mut Loaded, out: Format) -> anyhow::Result<bool> {
    let clips = &mut loaded.character.clips;
    let index = match &args.clip {
        Some(name) => load::choose("clip", name, clips.iter().map(|c| c.name.as_str()))?,
        None if written::holds_one_clip(out) && !clips.is_empty() => 0,
        None if written::holds_one_clip(out) => {
            anyhow::bail!("clips: there is none to write; give a file that has one")
        }
        None => return Ok(false),
    };
    let dropped = clips.len() > 1;
    *clips = vec![clips.swap_remove(index)];
    Ok(dropped)
}

fn warnings(loaded: &Loaded, out: Format, reduced: bool) -> Vec<String> {
    let mut list = loaded.warnings();
    if reduced && out == Format::Bvh {
        let what = "a BVH file stores every joint in every frame, so it gets no smaller; write .glb to save bytes";
        list.push(what.into());
    }
    list
}

fn text(report: &Report) -> String {
    let mut text = format!(
        "{} ({}, {} bytes) -> {} ({}, {} bytes), {}\n",
        clean(&report.input),
        report.format_in,
        report.bytes_in,
        clean(&report.out),
        report.format_out,
        report.bytes_out,
        counted(report.clips.len(), "clip", "clips")
    );
    for beside in &report.beside {
        text.push_str(&format!("beside it: {}\n", clean(beside)));
    }
    if let Some(reduction) = &report.reduction {
        text.push_str(&reduction.text());
    }
    for left in &report.left_out {
        text.push_str(&format!("left out: {}\n", clean(left)));
    }
    for warning in &report.warnings {
        text.push_str(&format!("warning: {}\n", clean(warning)));
    }
    text
}
