//! Files of MPEG-4 without a character: what moves, in which range, in which units.

use super::text::{head_line, warnings_text};
use crate::arguments::CharacterArgs;
use crate::console::Console;
use crate::open;
use crate::table::Table;
use crate::{fault, files};
use articula::inspect::{Face, Warning};
use articula::{Data, DataFormat};
use articula_core::fap_table::{FAPS, GROUPS, TABLE};
use articula_formats::mpeg4::epf::EpfFrame;
use articula_formats::mpeg4::fap::FapClip;
use articula_formats::mpeg4::fdp::FdpFile;
use serde::Serialize;

/// What was found. The fields that every `inspect` has come first; a file of data has no
/// skeleton and no mesh.
#[derive(Debug, Default, Serialize)]
pub(super) struct Findings {
    file: String,
    format: &'static str,
    name: String,
    bytes: usize,
    skeletons: [(); 0],
    clips: Vec<Clip>,
    meshes: [(); 0],
    face: Option<Face>,
    /// Of a FAP file: groups of parameters.
    groups: Vec<Group>,
    /// Of a FAP file: the parameters that its masks name. Of an FDP file: those that move some vertex.
    parameters: Vec<Parameter>,
    /// Of an FDP file: neutral distances of the face, in the unit of its mesh.
    fapu: Option<Units>,
    /// Of an FDP file: its feature points.
    points: Vec<Point>,
    /// Of an EPF file.
    coding: Option<Coding>,
    warnings: Vec<Warning>,
}

#[derive(Debug, Serialize)]
struct Clip {
    name: String,
    duration_secs: f32,
    fps: f32,
    frames: usize,
    joints_animated: usize,
}

#[derive(Debug, Serialize)]
struct Group {
    name: &'static str,
    /// Parameters that masks name.
    faps: usize,
    /// Those of them that are not neutral all the time.
    moving: usize,
}

#[derive(Debug, Serialize)]
struct Parameter {
    /// Number, 1 to 68.
    fap: usize,
    name: &'static str,
    group: &'static str,
    /// Unit of the standard, or null for visemes and expressions.
    unit: Option<&'static str>,
    /// Smallest and largest value; null where there is no single one.
    min: Option<i32>,
    max: Option<i32>,
    moves: bool,
}

#[derive(Debug, Serialize)]
struct Units {
    #[serde(rename = "ENS0")]
    ens0: f32,
    #[serde(rename = "ES0")]
    es0: f32,
    #[serde(rename = "IRISD0")]
    irisd0: f32,
    #[serde(rename = "MNS0")]
    mns0: f32,
    #[serde(rename = "MW0")]
    mw0: f32,
}

#[derive(Debug, Serialize)]
struct Point {
    point: String,
    vertices: usize,
    faps: Vec<usize>,
}

/// What an encoder is told.
#[derive(Debug, Serialize)]
struct Coding {
    frames: usize,
    intra: usize,
    face: usize,
    body: usize,
    fps: Option<f32>,
    quantiser_max: Option<i32>,
}

/// Reads the file and prints what was found.
pub(super) fn run(
    args: &CharacterArgs,
    format: DataFormat,
    map: bool,
    console: &Console,
) -> anyhow::Result<()> {
    if args.leaves_out() {
        return Err(fault::usage(format!(
            "--hide and --only choose meshes; a .{} file has none",
            format.name()
        )));
    }
    let opened = open::data(&args.file, format, &args.names)?;
    let mut found = match &opened.data {
        Data::Fap(clip) => of_fap(clip),
        Data::Epf(frames) => of_epf(frames),
        Data::Fdp(face) => of_fdp(face),
    };
    found.file = files::shown(&args.file);
    found.format = format.name();
    found.bytes = opened.bytes;
    let warnings = opened.warnings.into_iter();
    found.warnings = warnings
        .map(|w| Warning {
            at: w.at,
            what: w.what,
        })
        .collect();
    console.result(&found, |found| text(found, map))
}

fn of_fap(clip: &FapClip) -> Findings {
    let moving = clip.moving();
    let mut first = 0;
    let mut groups = Vec::new();
    for (name, count) in GROUPS {
        let range = first..first + count;
        groups.push(Group {
            name,
            faps: clip.coded[range.clone()].iter().filter(|c| **c).count(),
            moving: moving[range].iter().filter(|m| **m).count(),
        });
        first += count;
    }
    let coded = (0..FAPS).filter(|index| clip.coded[*index]);
    let parameters: Vec<Parameter> = coded
        .map(|index| parameter(index, clip.range(index + 1), moving[index]))
        .collect();
    Findings {
        name: clip.name.clone(),
        clips: vec![Clip {
            name: clip.name.clone(),
            duration_secs: clip.duration_secs(),
            fps: clip.rate_hz,
            frames: clip.frames.len(),
            joints_animated: 0,
        }],
        face: face(parameters.len()),
        groups,
        parameters,
        ..Findings::default()
    }
}

fn parameter(index: usize, range: Option<(i32, i32)>, moves: bool) -> Parameter {
    let fap = &TABLE[index];
    Parameter {
        fap: index + 1,
        name: fap.name,
        group: GROUPS[usize::from(fap.group) - 1].0,
        unit: fap.action.map(|action| action.unit.name()),
        min: range.map(|(min, _)| min),
        max: range.map(|(_, max)| max),
        moves,
    }
}

fn of_fdp(file: &FdpFile) -> Findings {
    let moved = file.moved();
    let units = file.fapu;
    let point = |p: &articula_formats::mpeg4::fdp::Point| Point {
        point: format!("{}.{}", p.point.0, p.point.1),
        vertices: p.zone.len(),
        faps: p.influences.iter().map(|i| i.fap).collect(),
    };
    let parameters = (0..FAPS).filter(|index| moved[*index]);
    let parameters: Vec<Parameter> = parameters.map(|i| parameter(i, None, true)).collect();
    Findings {
        face: face(parameters.len()),
        parameters,
        fapu: Some(Units {
            ens0: units.ens0,
            es0: units.es0,
            irisd0: units.irisd0,
            mns0: units.mns0,
            mw0: units.mw0,
        }),
        points: file.points.iter().map(point).collect(),
        ..Findings::default()
    }
}

fn of_epf(frames: &[EpfFrame]) -> Findings {
    let count = |is: fn(&EpfFrame) -> bool| frames.iter().filter(|f| is(f)).count();
    let quantisers = frames
        .iter()
        .flat_map(|f| [f.face.quantiser, f.body.quantiser]);
    Findings {
        coding: Some(Coding {
            frames: frames.len(),
            intra: count(|f| f.intra == Some(true)),
            face: count(|f| f.carries_face),
            body: count(|f| f.carries_body),
            fps: frames.iter().find_map(|f| f.rate_hz),
            quantiser_max: quantisers.flatten().max(),
        }),
        ..Findings::default()
    }
}

fn face(faps: usize) -> Option<Face> {
    Some(Face { faps, morphs: 0 })
}

fn text(found: &Findings, map: bool) -> String {
    let mut text = head_line(&found.file, found.format, found.bytes, &found.name);
    for clip in &found.clips {
        text.push_str(&format!(
            "{} frames at {} fps, {:.3} s\n",
            clip.frames, clip.fps, clip.duration_secs
        ));
    }
    if let Some(units) = &found.fapu {
        text.push_str(&format!(
            "units of the face: ENS0 {}, ES0 {}, IRISD0 {}, MNS0 {}, MW0 {}\n{} feature points\n",
            units.ens0,
            units.es0,
            units.irisd0,
            units.mns0,
            units.mw0,
            found.points.len()
        ));
    }
    if let Some(coding) = &found.coding {
        text.push_str(&format!(
            "{} frames, {} of them intra; the face in {}, the body in {}\n",
            coding.frames, coding.intra, coding.face, coding.body
        ));
        if let Some(fps) = coding.fps {
            text.push_str(&format!("{fps} fps\n"));
        }
    }
    if let Some(face) = &found.face {
        text.push_str(&format!(
            "\nface: {} facial animation parameters\n",
            face.faps
        ));
    }
    if !found.groups.is_empty() {
        let mut table = Table::new(&["group", "in masks", "moving"]);
        for group in &found.groups {
            table.row([
                group.name.to_owned(),
                group.faps.to_string(),
                group.moving.to_string(),
            ]);
        }
        text.push_str(&table.text());
    }
    if map {
        text.push_str(&format!("\nparameters\n{}", parameters(found).text()));
    }
    text.push_str(&warnings_text(&found.warnings));
    text
}

fn parameters(found: &Findings) -> Table {
    let mut table = Table::new(&["FAP", "name", "unit", "min", "max", "moves"]);
    let number = |value: Option<i32>| value.map_or_else(|| "-".to_owned(), |v| v.to_string());
    for p in &found.parameters {
        table.row([
            p.fap.to_string(),
            p.name.to_owned(),
            p.unit.unwrap_or("-").to_owned(),
            number(p.min),
            number(p.max),
            if p.moves { "yes" } else { "no" }.to_owned(),
        ]);
    }
    table
}
