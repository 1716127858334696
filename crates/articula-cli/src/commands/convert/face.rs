//! FAP files, rewritten with masks of what moves.

use super::ConvertArgs;
use super::report::Report;
use crate::console::Console;
use crate::open;
use crate::{fault, files};
use articula::{Data, DataFormat};
use articula_core::fap_table::FAPS;
use articula_formats::mpeg4::fap::{self, FapClip};

/// Whether a file that is named holds data of a face, or should.
pub(super) fn is_meant(args: &ConvertArgs) -> bool {
    let named = |path| files::data_format(path).is_some();
    named(&args.out) || args.inputs.len() == 1 && named(&args.inputs[0])
}

/// Rewrites a FAP file; anything else is refused with what can be done.
pub(super) fn run(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    let clip = check(args)?;
    let bytes = fap::write(&clip.0);
    files::write(&args.out, &bytes)?;
    let (clip, bytes_in, warnings) = clip;
    let report = Report {
        input: files::shown(&args.inputs[0]),
        out: files::shown(&args.out),
        format_in: DataFormat::Fap.name().to_owned(),
        format_out: DataFormat::Fap.name(),
        bytes_in,
        bytes_out: bytes.len(),
        beside: Vec::new(),
        left_out: still(&clip).into_iter().collect(),
        clips: vec![clip.name],
        onto: None,
        edits: Vec::new(),
        reduction: None,
        warnings,
        failed: Vec::new(),
    };
    console.result(&report, |report| report.text(false))
}

/// The clip, the length of its file and what is odd about it.
fn check(args: &ConvertArgs) -> anyhow::Result<(FapClip, usize, Vec<String>)> {
    let [input] = &args.inputs[..] else {
        return Err(fault::usage("a FAP file is written from one FAP file"));
    };
    let place = files::shown(input);
    let Some(format) = files::data_format(input) else {
        let out = files::shown(&args.out);
        return Err(fault::usage(format!(
            "{place} to {out} is not converted; a .fap file is written from a .fap file"
        )));
    };
    if files::data_format(&args.out) != Some(DataFormat::Fap) || format != DataFormat::Fap {
        return Err(fault::usage(format!("{place}: {}", format.advice())));
    }
    let chosen = args.clip.is_some() || args.loa.is_some() || args.loa_profile.is_some();
    let other = args.to.is_some() || args.onto.is_some() || args.khr_character;
    if chosen || other || args.hygiene.asks() {
        return Err(fault::usage(format!(
            "{place}: the flags that choose or change clips of a body say nothing of a FAP file; leave them out"
        )));
    }
    let opened = open::data(input, format, &args.names)?;
    let Data::Fap(clip) = opened.data else {
        anyhow::bail!("{place}: it is no FAP file");
    };
    let warnings = opened.warnings.iter();
    let warnings = warnings.map(|w| format!("{}: {}", w.at, w.what)).collect();
    Ok((clip, opened.bytes, warnings))
}

/// Parameters that masks name, but that never move.
fn still(clip: &FapClip) -> Option<String> {
    let moving = clip.moving();
    let still = (0..FAPS).filter(|fap| clip.coded[*fap] && !moving[*fap]);
    let count = still.count();
    (count > 0).then(|| format!("{count} of the parameters in its masks (they stay neutral)"))
}
