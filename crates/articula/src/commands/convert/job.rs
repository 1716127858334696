//! One file of a conversion: read, changed as asked for, written.

use super::plan::Job;
use super::report::Report;
use super::{ConvertArgs, reduction, written};
use crate::load::{self, Format, Loaded, Writes};
use crate::table::counted;
use crate::{fault, files};
use anyhow::Context;

/// Reads, changes and writes one file.
pub(super) fn run(job: &Job, args: &ConvertArgs) -> anyhow::Result<Report> {
    let input = &job.inputs[0];
    let mut loaded = load::character(&input.path, &args.names)?;
    check_pair(loaded.format, job.format)?;
    let place = loaded.place();
    if input.found && files::same(&input.path, &job.out) {
        anyhow::bail!("{place}: it would be replaced by what is made of it; name another folder");
    }
    let dropped = choose_clips(args, &mut loaded, job.format).context(place.clone())?;
    let reduction = reduction::apply(args, &mut loaded)?;
    let reduced = reduction.is_some();
    let changed = dropped > 0 || reduced;
    let mut made = written::written(&mut loaded, &job.out, job.format, changed).context(place)?;
    for (path, bytes) in &made.files {
        files::write(path, bytes)?;
    }
    if dropped > 0 && args.clip.is_none() {
        let dropped = counted(dropped, "clip", "clips");
        let format = job.format.name();
        made.left_out.push(format!(
            "{dropped} (a .{format} file holds one; --clip NAME chooses)"
        ));
    }
    let beside = made.files[1..].iter();
    let clips = loaded.character.clips.iter();
    Ok(Report {
        input: loaded.place(),
        out: files::shown(&job.out),
        format_in: loaded.format.name(),
        format_out: job.format.name(),
        bytes_in: loaded.bytes,
        bytes_out: made.files.iter().map(|(_, bytes)| bytes.len()).sum(),
        beside: beside.map(|(path, _)| files::shown(path)).collect(),
        clips: clips.map(|c| c.name.clone()).collect(),
        reduction,
        left_out: made.left_out,
        warnings: warnings(&loaded, job.format, reduced),
    })
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

/// Keeps the clips that go into the output; says how many were dropped.
fn choose_clips(args: &ConvertArgs, loaded: &mut Loaded, out: Format) -> anyhow::Result<usize> {
    let clips = &mut loaded.character.clips;
    let index = match &args.clip {
        Some(name) => load::choose("clip", name, clips.iter().map(|c| c.name.as_str()))?,
        None if written::holds_one_clip(out) && !clips.is_empty() => 0,
        None if written::holds_one_clip(out) => {
            anyhow::bail!("clips: there is none to write; give a file that has one")
        }
        None => return Ok(0),
    };
    let dropped = clips.len() - 1;
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
