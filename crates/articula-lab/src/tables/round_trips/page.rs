//! The page of the format round trips, and its CSV files.

use super::judge::Errors;
use super::written::{Trip, Writer};
use super::{Found, REFUSED, RoundTrip};
use crate::open::Parameters;
use crate::tables::targets::{self, Target};
use anyhow::Result;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The files to validate: the written files and their sources.
pub(super) fn judged(round_trips: &[RoundTrip]) -> Vec<PathBuf> {
    let written = round_trips.iter().flat_map(|d| &d.trips);
    let mut all: Vec<PathBuf> = written.filter_map(|t| t.path.clone()).collect();
    let sources = round_trips
        .iter()
        .filter(|d| d.kind.is_gltf() && d.found.is_ok());
    all.extend(sources.map(|d| d.path.clone()));
    all
}

/// The Markdown page.
pub(super) fn page(round_trips: &[RoundTrip], errors: Option<&Errors>) -> Result<String> {
    let mut page = String::from(HEAD);
    let all = all_targets(round_trips, errors);
    page.push_str(&targets::section(TARGETS, &["files", "quantity"], &all));
    page.push_str(CONTENTS);
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

/// The bounds of reading and writing. A writer's distance is the maximum over its files.
fn all_targets(round_trips: &[RoundTrip], errors: Option<&Errors>) -> Vec<Target> {
    let count = |of: &dyn Fn(&RoundTrip) -> bool| round_trips.iter().filter(|r| of(r)).count();
    let is_known = |r: &RoundTrip| REFUSED.iter().any(|(name, _)| *name == r.name);
    let refused = count(&|r| r.found.is_err() && !is_known(r));
    let changed =
        count(&|r| matches!(&r.found, Ok(Found::Data(data)) if data.comes_back == Some(false)));
    let number = |label: [&str; 2], found: usize| Target::at_most(label, 0.0, found as f64);
    let mut all = vec![
        number(["all", "refused, other than Draco's"], refused),
        number(["parameters", "changed when read again"], changed),
    ];
    for writer in Writer::ALL {
        let trips = || {
            let trips = round_trips.iter().flat_map(|r| &r.trips);
            trips.filter(move |t| t.writer == writer)
        };
        let label = format!("{} ({} files)", writer.name(), trips().count());
        let incomplete = trips().filter(|t| !t.is_complete()).count();
        let read = trips().filter(|t| t.apart.is_ok());
        let worst = read.map(Trip::worst_mm).fold(0.0, f32::max);
        all.push(number(
            [&label, "unreadable, or joints or clips missing"],
            incomplete,
        ));
        // The bound is the nearest decimal number, not the 32-bit float.
        let bound_mm: f64 = writer.bound_mm().to_string().parse().unwrap_or(0.0);
        all.push(Target::at_most(
            [&label, "maximum distance, mm"],
            bound_mm,
            f64::from(worst),
        ));
    }
    if let Some(errors) = errors {
        let of = |path: &Path| errors.get(path).copied().unwrap_or(0);
        let more = |r: &RoundTrip| {
            let written = r.trips.iter().filter_map(|t| t.path.as_deref());
            written.map(of).max().is_some_and(|most| most > of(&r.path))
        };
        let what = "more validator errors than the source";
        all.push(number(["GLB", what], count(&more)));
    }
    all
}

/// The writers of text formats, in the order of the columns.
const TEXTS: [Writer; 3] = [Writer::Bvh, Writer::Acclaim, Writer::X3d];

/// Maximum distances of joints and skin, and the counts of missing joints or clips.
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

/// Maximum number of validator errors of the written files, and those of the source if any.
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

/// The contents of each file as CSV.
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

/// The round trips of each file as CSV.
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

const HEAD: &str = "# Format round trips

Made by `cargo run --release -p articula-lab -- round-trips` over every file of the data folder in a
format that is read.
";

const TARGETS: &str =
    "Every file opens, except one that needs Draco; what is written is read again with all
joints and clips that the format holds, within the stated distance, and has no errors of the Khronos
validator that the source does not have.";

const CONTENTS: &str = "
## What is in each file

Joints are the distinct ones of the skins (all joints where there is no skin); mapped ones correspond
to a joint of the H-Anim standard; morphs are counted over all meshes.

| file | format | opens | joints | mapped | clips | meshes | triangles | morphs | expressions | warnings |
| --- | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |
";

const BETWEEN: &str = "
## Written files, read again

Each file is written by every writer (GLB: the document passed through, the document with new clips,
and a new document; clips that drive expressions are written as morph weights), read again and compared
with the original: the joints in model space at up to 500 frames of every clip, the skinned vertices at
five frames of each. Cells have the maximum distances in millimetres, first of a joint, then of a
vertex. A test checks bounds of 0.001 mm for GLB and 0.1 mm for the text formats, over all joints and
clips that the format holds (X3D: joints that correspond to one of the standard; its vertices are in
another order). BVH and ASF files do not state unit and up axis, which are passed to the reader. The
last column counts the errors of the Khronos validator: the maximum of the written GLB files, and those
of the source.

| file | GLB | BVH | ASF, AMC | X3D | validator errors |
| --- | --- | --- | --- | --- | --- |
";
