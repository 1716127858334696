//! FAP files, written again with masks that mark the parameters that move.

use super::report::{self, ConvertReport};
use super::{ConvertArgs, face_level};
use crate::console::Console;
use crate::open;
use crate::{fault, files};
use articula::convert::write_data;
use articula::face::reduce_face;
use articula::{Data, DataFormat};

/// Whether the input or output is named as a file of facial data that is to be written again; with a
/// character, a FAP file is a motion like any other.
pub(super) fn is_meant(args: &ConvertArgs) -> bool {
    let named = |path| files::data_format(path).is_some();
    let only = args.inputs.len() == 1 && args.onto.is_none();
    named(&args.out) || only && named(&args.inputs[0])
}

/// Writes a FAP file again; anything else is refused with a hint at what is possible.
pub(super) fn run(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    let format = check(args)?;
    let input = &args.inputs[0];
    console.files.plan(args.inputs(), [args.out.as_path()])?;
    let mut opened = open::data(input, format, &args.names)?;
    let mut face_level = None;
    if let Data::Fap(clip) = opened.data {
        let (clip, report) = face_level::applied(clip, args, reduce_face);
        (opened.data, face_level) = (Data::Fap(clip), report);
    }
    let written = write_data(&opened.data)?;
    console.files.write(&args.out, &written.bytes)?;
    let clips = match &opened.data {
        Data::Fap(clip) => vec![clip.name.clone()],
        _ => Vec::new(),
    };
    let left_out = written.left_out.iter();
    let report = ConvertReport {
        input: files::shown(input),
        out: files::shown(&args.out),
        format_in: format.name().to_owned(),
        format_out: format.name(),
        bytes_in: opened.bytes,
        bytes_out: written.bytes.len(),
        beside: Vec::new(),
        left_out: left_out
            .map(|what| report::left_out(what, format.name()))
            .collect(),
        clips,
        onto: None,
        face_level,
        edits: Vec::new(),
        reduction: None,
        mesh: None,
        written: Vec::new(),
        warnings: open::warnings(&opened.warnings),
        failed: Vec::new(),
    };
    console.result(&report, |report| report.text(false))
}

/// The format, if it is one that can be written and no other flags are given.
fn check(args: &ConvertArgs) -> anyhow::Result<DataFormat> {
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
            "{place}: flags that choose or change body clips do not apply to a FAP file; leave them out"
        )));
    }
    Ok(format)
}
