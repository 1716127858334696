//! The page of the doors, and its numbers.

use super::judge::Errors;
use super::written::{Trip, Writer};
use super::{Found, RoundTrip};
use crate::open::Parameters;
use anyhow::Result;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The files that the validator is asked for: what was written, and what it was made of.
pub(super) fn judged(round_trips: &[RoundTrip]) -> Vec<PathBuf> {
    let written = round_trips.iter().flat_map(|d| &d.trips);
    let mut all: Vec<PathBuf> = written.filter_map(|t| t.path.clone()).collect();
    let sources = round_trips
        .iter()
        .filter(|d| d.kind.is_gltf() && d.found.is_ok());
    all.extend(sources.map(|d| d.path.clone()));
    all
}

/// The page for people.
pub(super) fn page(round_trips: &[RoundTrip], errors: Option<&Errors>) -> Result<String> {
    let mut page = String::from(HEAD);
    for RoundTrip {
        name, kind, found, ..
    } in round_trips
    {
        let format = kind.name();
        match found {
            Ok(Found::Figure(counts)) => {
                let numbers = counts.columns().map(|n| n.to_string()).join(" | ");
                writeln!(page, "| {name} | {format} | yes | {numbers} |")?;
            }
            Ok(Found::Data(data)) => {
                let Parameters { what, warnings, .. } = data;
                let again = match data.comes_back {
                    None => "",
                    Some(true) => "; written and read again the same",
                    Some(false) => "; NOT the same when written and read again",
                };
                let blanks = "| ".repeat(7);
                writeln!(
                    page,
                    "| {name} | {format} | yes: {what}{again} {blanks}| {warnings} |"
                )?;
            }
            Err(fault) => {
                let why = fault.to_string().replace(['\n', '|'], " ");
                let blanks = "| ".repeat(8);
                writeln!(page, "| {name} | {format} | refused: {why} {blanks}|")?;
            }
        }
    }
    write!(page, "{BETWEEN}")?;
    for round_trip in round_trips.iter().filter(|d| !d.trips.is_empty()) {
        let glb = round_trip.trips.iter().filter(|t| t.writer.is_glb());
        let mut cells = vec![glb.max_by(|a, b| a.worst_mm().total_cmp(&b.worst_mm()))];
        cells.extend(TEXTS.map(|writer| round_trip.trips.iter().find(|t| t.writer == writer)));
        let cell = |trip: &Option<&Trip>| trip.map_or_else(|| "-".to_owned(), millimetres);
        let cells: Vec<String> = cells.iter().map(cell).collect();
        let (name, verdict) = (&round_trip.name, verdict(round_trip, errors));
        writeln!(page, "| {name} | {} | {verdict} |", cells.join(" | "))?;
    }
    Ok(page)
}

/// The writers of text formats, as the table has them.
const TEXTS: [Writer; 3] = [Writer::Bvh, Writer::Acclaim, Writer::X3d];

/// How far joints and skin are apart, and whether anything is missing.
fn millimetres(trip: &Trip) -> String {
    let apart = match &trip.apart {
        Ok(apart) => apart,
        Err(fault) => return format!("failed: {fault:#}").replace(['\n', '|'], " "),
    };
    let mut text = format!("{:.3}", apart.joints_mm);
    if let Some(skin) = apart.skin_mm {
        let _ = write!(text, "; {skin:.3}");
    }
    for (found, of, what) in [
        (apart.joints, trip.joints, "joints"),
        (apart.clips, trip.clips, "clips"),
    ] {
        if found != of {
            let _ = write!(text, " ({found} of {of} {what})");
        }
    }
    text
}

/// The most errors of a written file, and those of the source if it has any.
fn verdict(round_trip: &RoundTrip, errors: Option<&Errors>) -> String {
    let count = |path: &Path| errors.and_then(|e| e.get(path)).copied();
    let written = round_trip.trips.iter().filter_map(|t| t.path.as_deref());
    let Some(most) = written.filter_map(count).max() else {
        return "-".to_owned();
    };
    match count(&round_trip.path) {
        Some(source) if source > 0 => format!("{most} (source {source})"),
        _ => most.to_string(),
    }
}

/// What is in each file, for machines.
pub(super) fn csv(round_trips: &[RoundTrip]) -> Result<String> {
    let mut csv = String::from(
        "file,format,opened,joints,mapped,clips,meshes,triangles,morphs,expressions,warnings,why\n",
    );
    for RoundTrip {
        name, kind, found, ..
    } in round_trips
    {
        let format = kind.name();
        match found {
            Ok(Found::Figure(counts)) => {
                let numbers = counts.columns().map(|n| n.to_string()).join(",");
                writeln!(csv, "{name},{format},1,{numbers},")?;
            }
            Ok(Found::Data(data)) => {
                let (what, warnings) = (data.what.replace(',', ";"), data.warnings);
                writeln!(csv, "{name},{format},1,,,,,,,,{warnings},{what}")?;
            }
            Err(fault) => {
                let why = fault.to_string().replace(['\n', '"'], " ");
                writeln!(csv, "{name},{format},0,,,,,,,,,\"{why}\"")?;
            }
        }
    }
    Ok(csv)
}

/// What came back of each written file, for machines.
pub(super) fn csv_written(round_trips: &[RoundTrip], errors: Option<&Errors>) -> Result<String> {
    let mut csv = String::from(
        "file,written,joints,joints_found,clips,clips_found,joints_apart_mm,skin_apart_mm,bound_mm,holds,validator_errors\n",
    );
    for round_trip in round_trips {
        for trip in &round_trip.trips {
            let errors = trip.path.as_deref().and_then(|p| errors?.get(p));
            let errors = errors.map_or_else(String::new, u64::to_string);
            let numbers = match &trip.apart {
                Ok(a) => {
                    let skin = a.skin_mm.map_or_else(String::new, |mm| format!("{mm:.5}"));
                    let (joints, clips) = (trip.joints, trip.clips);
                    format!(
                        "{joints},{},{clips},{},{:.5},{skin}",
                        a.joints, a.clips, a.joints_mm
                    )
                }
                Err(_) => ",,,,,".to_owned(),
            };
            writeln!(
                csv,
                "{},{},{numbers},{},{},{errors}",
                round_trip.name,
                trip.writer.name().replace(',', ";"),
                trip.writer.bound_mm(),
                u8::from(trip.holds()),
            )?;
        }
    }
    Ok(csv)
}

const HEAD: &str = "# Every door: what opens, and what comes back

Made by `cargo run --release -p articula-lab -- doors` over every file of the data folder that a
reader is for.

## What is in each file

Joints are the distinct ones of the skins (all, where there is no skin); mapped ones have a twin in
the H-Anim standard; morphs are counted over all meshes.

| file | format | opens | joints | mapped | clips | meshes | triangles | morphs | expressions | warnings |
| --- | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |
";

const BETWEEN: &str = "
## What is written opens again

Each file that opens is written in every way that there is (GLB: passed through, with its clips
written anew, made anew; clips that drive expressions are written out as morph weights); what was written is read again and
compared with what it was written from: the joints in model space at up to 500 frames of every clip,
the skinned vertices at five frames of each. Cells are the greatest distances found in millimetres,
first of a joint, then of a vertex. The bounds that a test holds are 0.001 mm for GLB and 0.1 mm for
the text formats, all joints and all clips that the format holds (X3D: joints that stand for one of
the standard; its vertices come in another order). BVH and ASF
files do not say their unit and up axis: the reader is told what was written. The last column counts
the errors of the Khronos validator: the most of any written GLB, and those of the source.

| file | GLB | BVH | ASF, AMC | X3D | validator errors |
| --- | --- | --- | --- | --- | --- |
";
