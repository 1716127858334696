//! Sampling and model matrices at full detail, for several evaluators and numbers of characters.

use super::frame_order::Access;
use super::ours::{Batched, plain};
use super::{Bench, CrowdTables, Line};
use crate::measure::{Contestant, Timing, race};
use crate::peers::floor::{Floor, Kernel, Sampled};
use crate::peers::quoted::{FLOOR_THERE, QUOTED, Quoted};
use crate::peers::structs::Structs;
use crate::peers::three::{self, Effort, ThreeTimes};
use anyhow::Result;
use articula_core::{ClipSet, ClipStorage, JointLods, PaletteForm, PaletteMap};
use articula_report::{BarSeries, PlotOptions, bar_plot};
use std::hint::black_box;

/// Names of the rows to which bounds apply.
const STORED: &str = "ours, 3x4 f32";
const TILES: &str = "ours, in tiles";

/// Floor with which a row is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Against {
    Stored,
    Tiles,
}

/// Times of one evaluator for all numbers of characters.
struct Row {
    who: String,
    against: Against,
    /// Bytes written per joint.
    joint_bytes: usize,
    /// Bytes of the clip per joint and frame, where known.
    clip_bytes: Option<f64>,
    timings: Vec<Timing>,
}

/// Adds the section.
pub(super) fn add(bench: &Bench, report: &mut CrowdTables) -> Result<()> {
    let rows = measured(bench)?;
    let counts = bench.counts();
    report.heading(
        "Sampling and model matrices at full detail",
        "Evaluators that store their output are compared with the floor that stores 3x4 matrices, \
         those whose output is consumed in tiles with the floor in tiles. The floor and *ours* \
         (Articula) sample the channels that move; the rows with all rotations show the floor for a \
         clip in which every joint rotates. The floor fuses multiplications and additions; Articula does \
         not, since its bits are equal on all machines. *Unfused*: the floor without that.",
    );
    let mut head = vec!["evaluator".to_owned()];
    for (count, _) in &counts {
        head.extend([format!("{count} characters"), "× floor".to_owned()]);
    }
    report.head(&head.iter().map(String::as_str).collect::<Vec<_>>());
    for row in &rows {
        let mut cells = vec![row.who.clone()];
        for (i, (count, _)) in counts.iter().enumerate() {
            let floor_ns = floor_of(&rows, row.against)[i].median_ns;
            let timing = row.timings[i];
            cells.push(format!("{:.0} ({:.0})", timing.median_ns, timing.least_ns));
            cells.push(format!("{:.2}", timing.median_ns / floor_ns));
            targets(report, row, *count, (timing.median_ns, floor_ns));
            report.line(&Line {
                section: "evaluation",
                who: &row.who,
                count: *count,
                variant: "full",
                timing,
                floor_ns,
            });
        }
        report.row(&cells);
    }
    three_rows(bench, report, &rows)?;
    for quoted in QUOTED {
        report.row(&quoted_cells(quoted, &counts));
    }
    bytes(bench, report, &rows);
    report
        .plots
        .push(("crowd-evaluation", plot(&rows, &counts)));
    Ok(())
}

/// Bounds on the two forms of output in full precision: against the floor with any number of
/// characters, and with a thousand of them.
fn targets(report: &mut CrowdTables, row: &Row, count: usize, (ns, floor_ns): (f64, f64)) {
    let tight = match row.who.as_str() {
        STORED => 1.5,
        TILES => 1.15,
        _ => return,
    };
    let who = format!("{}, {count} characters", row.who);
    report.at_most(&who, "time / floor", 1.8, ns / floor_ns);
    if count == 1000 {
        report.at_most(&who, "time / floor, with 1000", tight, ns / floor_ns);
        report.at_most(&who, "ns per character", 303.0, ns);
    }
}

fn floor_of(rows: &[Row], against: Against) -> &[Timing] {
    // The floors are the first two rows.
    match against {
        Against::Stored => &rows[0].timings,
        Against::Tiles => &rows[1].timings,
    }
}

/// The floor that writes 3x4 matrices.
pub(super) fn floor_stored<'a>(bench: &Bench, count: usize) -> Result<Contestant<'a>> {
    floor(
        bench,
        "floor, 3x4 f32",
        (Sampled::Moving, Kernel::best()),
        count,
    )
}

fn floor<'a>(
    bench: &Bench,
    name: &str,
    (sampled, kernel): (Sampled, Kernel),
    count: usize,
) -> Result<Contestant<'a>> {
    let mut floor = Floor::with(&bench.asset.rig, bench.clip(), sampled, kernel)?;
    let mut out = vec![[0.0; 12]; count * floor.joints()];
    let frame = move |secs: &[f32]| {
        floor.store(secs, &mut out);
        black_box(&mut out);
    };
    Ok(Contestant {
        name: name.to_owned(),
        frame: Box::new(frame),
    })
}

fn floor_tiles<'a>(
    bench: &Bench,
    name: &str,
    (sampled, kernel): (Sampled, Kernel),
) -> Result<Contestant<'a>> {
    let mut floor = Floor::with(&bench.asset.rig, bench.clip(), sampled, kernel)?;
    let frame = move |secs: &[f32]| {
        floor.tiles(secs, |tile| {
            black_box(tile);
        });
    };
    Ok(Contestant {
        name: name.to_owned(),
        frame: Box::new(frame),
    })
}

/// Arrays of structs, one evaluator state per character.
pub(super) fn structs<'a>(bench: &Bench, count: usize) -> Result<Contestant<'a>> {
    let structs = Structs::new(&bench.asset.rig, bench.clip())?;
    let mut characters = vec![structs.character(); count];
    let frame = move |secs: &[f32]| {
        for (secs, character) in secs.iter().zip(&mut characters) {
            structs.evaluate(*secs, character);
        }
        black_box(&mut characters);
    };
    Ok(Contestant {
        name: "arrays of structs".to_owned(),
        frame: Box::new(frame),
    })
}

/// Articula's clip in both storages, and the palette of all joints.
struct Ours {
    floats: ClipSet,
    shorts: ClipSet,
    map: PaletteMap,
}

impl Ours {
    fn new(bench: &Bench) -> Result<Self> {
        let rig = &bench.asset.rig;
        let joint_lods = JointLods::whole(rig)?;
        let clip = std::slice::from_ref(bench.clip());
        Ok(Self {
            map: PaletteMap::joints(&joint_lods),
            floats: ClipSet::new(rig, joint_lods.clone(), clip, ClipStorage::Float)?,
            shorts: ClipSet::new(rig, joint_lods, clip, ClipStorage::Short)?,
        })
    }

    fn played<'a>(&'a self, clips: &'a ClipSet) -> Batched<'a> {
        Batched {
            clips,
            map: &self.map,
            clip: 0,
            level: 0,
        }
    }
}

/// A contestant and its known sizes.
struct Candidate<'a> {
    contestant: Contestant<'a>,
    against: Against,
    joint_bytes: usize,
    /// Bytes of the whole clip, where it is one array.
    clip_bytes: Option<usize>,
}

/// All evaluators that run in this process, the floors first.
fn candidates<'a>(bench: &'a Bench, ours: &'a Ours, count: usize) -> Result<Vec<Candidate<'a>>> {
    let of = |contestant, against, joint_bytes, clip_bytes| Candidate {
        contestant,
        against,
        joint_bytes,
        clip_bytes,
    };
    let bytes_of = |sampled| -> Result<Option<usize>> {
        let floor = Floor::new(&bench.asset.rig, bench.clip(), sampled)?;
        Ok(Some(floor.clip_bytes()))
    };
    let (moving, whole) = (Sampled::Moving, Sampled::AllRotations);
    let (best, unfused) = (Kernel::best(), Kernel::unfused());
    let stored = floor(bench, "floor, all rotations, 3x4 f32", (whole, best), count)?;
    let tiles = floor_tiles(bench, "floor, all rotations, in tiles", (whole, best))?;
    let apart = floor(bench, "floor, unfused, 3x4 f32", (moving, unfused), count)?;
    let apart_tiles = floor_tiles(bench, "floor, unfused, in tiles", (moving, unfused))?;
    let mut all = vec![
        of(
            floor_stored(bench, count)?,
            Against::Stored,
            48,
            bytes_of(moving)?,
        ),
        of(
            floor_tiles(bench, "floor, in tiles", (moving, best))?,
            Against::Tiles,
            0,
            bytes_of(moving)?,
        ),
        of(apart, Against::Stored, 48, bytes_of(moving)?),
        of(apart_tiles, Against::Tiles, 0, bytes_of(moving)?),
        of(stored, Against::Stored, 48, bytes_of(whole)?),
        of(tiles, Against::Tiles, 0, bytes_of(whole)?),
    ];
    let (float, short) = (ours.played(&ours.floats), ours.played(&ours.shorts));
    let bytes = Some(ours.floats.bytes());
    for (name, form) in [
        (STORED, PaletteForm::Matrix),
        ("ours, 3x4 half", PaletteForm::HalfMatrix),
        ("ours, rigid f32", PaletteForm::Rigid),
        ("ours, rigid half", PaletteForm::HalfRigid),
    ] {
        // Rigid forms store a rotation and a translation, no scale.
        if !(form.is_rigid() && ours.floats.is_scaled()) {
            let contestant = float.stored(name, form, count)?;
            all.push(of(contestant, Against::Stored, form.bytes(), bytes));
        }
    }
    let form = PaletteForm::Matrix;
    let contestant = short.stored("ours, 3x4 f32, 16-bit clip", form, count)?;
    let bytes_short = Some(ours.shorts.bytes());
    all.push(of(contestant, Against::Stored, form.bytes(), bytes_short));
    all.push(of(float.tiles(TILES)?, Against::Tiles, 0, bytes));
    all.push(of(plain(bench, count), Against::Stored, 64, None));
    all.push(of(structs(bench, count)?, Against::Stored, 64, None));
    Ok(all)
}

/// Times them for every number of characters.
fn measured(bench: &Bench) -> Result<Vec<Row>> {
    let ours = Ours::new(bench)?;
    let joint_frames = (bench.clip().frames() * bench.asset.rig.len()) as f64;
    let mut rows: Vec<Row> = Vec::new();
    for (count, frames) in bench.counts() {
        let (new, mut contestants): (Vec<Row>, Vec<Contestant<'_>>) =
            candidates(bench, &ours, count)?
                .into_iter()
                .map(|c| {
                    let row = Row {
                        who: c.contestant.name.clone(),
                        against: c.against,
                        joint_bytes: c.joint_bytes,
                        clip_bytes: c.clip_bytes.map(|bytes| bytes as f64 / joint_frames),
                        timings: Vec::new(),
                    };
                    (row, c.contestant)
                })
                .unzip();
        if rows.is_empty() {
            rows = new;
        }
        let times = Access::Forward.frames(bench, count, frames);
        let timings = race(&mut contestants, &times, bench.rounds());
        for (row, timing) in rows.iter_mut().zip(timings) {
            row.timings.push(timing);
        }
    }
    Ok(rows)
}

/// Times three.js in node, a separate process that runs after the race.
fn three_rows(bench: &Bench, report: &mut CrowdTables, rows: &[Row]) -> Result<()> {
    let clip = bench.clip().name.as_str();
    let mut found: Vec<ThreeTimes> = Vec::new();
    for (count, _) in bench.counts() {
        let effort = Effort {
            count,
            frames: if bench.small { 1 } else { 5 },
            rounds: if bench.small { 1 } else { 5 },
        };
        let Some(times) = three::times(&bench.file, clip, effort)? else {
            println!("skipped: three.js (no node, or `npm ci` was not run in oracle)");
            return Ok(());
        };
        found.push(times);
    }
    let steps = [
        "three.js, mixer",
        "three.js, mixer and world",
        "three.js, mixer, world and joint matrices",
    ];
    for (step, who) in steps.into_iter().enumerate() {
        let mut cells = vec![format!("{who} ({} joints, node)", found[0].joints)];
        for (i, (count, _)) in bench.counts().iter().enumerate() {
            let (timing, floor_ns) = (found[i].steps()[step], rows[0].timings[i].median_ns);
            cells.push(format!("{:.0} ({:.0})", timing.median_ns, timing.least_ns));
            cells.push(format!("{:.0}", timing.median_ns / floor_ns));
            report.line(&Line {
                section: "evaluation",
                who,
                count: *count,
                variant: "full",
                timing,
                floor_ns,
            });
        }
        report.row(&cells);
    }
    Ok(())
}

fn quoted_cells(quoted: &Quoted, counts: &[(usize, usize)]) -> Vec<String> {
    let mut cells = vec![format!("*quoted:* {}, {}", quoted.who, quoted.work)];
    for (count, _) in counts {
        let times = quoted.times.iter().find(|(c, _)| c == count);
        let floor = FLOOR_THERE.iter().find(|(c, _)| c == count);
        let range = |(a, b): (f64, f64), digits: usize| {
            if a == b {
                format!("{a:.digits$}")
            } else {
                format!("{a:.digits$} to {b:.digits$}")
            }
        };
        match (times, floor) {
            (Some((_, ns)), Some((_, floor))) => {
                cells.push(range(*ns, 0));
                cells.push(range((ns.0 / floor, ns.1 / floor), 1));
            }
            _ => cells.extend(["–".to_owned(), "–".to_owned()]),
        }
    }
    cells
}

/// Bytes and nanoseconds per joint and frame (thesis 6.3.1).
fn bytes(bench: &Bench, report: &mut CrowdTables, rows: &[Row]) {
    let at = bench.counts().len().min(2) - 1;
    let joints = bench.asset.rig.len() as f64;
    report.heading(
        "Bytes and time per joint and frame",
        &format!(
            "With {} characters; bytes in the clip and bytes written per joint and frame.",
            bench.counts()[at].0
        ),
    );
    report.head(&["evaluator", "clip, bytes", "written, bytes", "ns"]);
    for row in rows {
        let clip = row.clip_bytes.map_or("–".to_owned(), |b| format!("{b:.1}"));
        let ns = format!("{:.2}", row.timings[at].median_ns / joints);
        report.row(&[row.who.clone(), clip, row.joint_bytes.to_string(), ns]);
    }
}

fn plot(rows: &[Row], counts: &[(usize, usize)]) -> String {
    let options = PlotOptions {
        title: "Sample and model matrices, 3x4 or in tiles".to_owned(),
        y_label: "ns for each character and frame".to_owned(),
        ..PlotOptions::default()
    };
    let shown = [
        "floor, 3x4 f32",
        "floor, in tiles",
        "ours, 3x4 f32",
        "ours, rigid half",
        "ours, in tiles",
        "arrays of structs",
    ];
    let series: Vec<BarSeries> = rows
        .iter()
        .filter(|r| shown.contains(&r.who.as_str()))
        .map(|r| BarSeries {
            name: r.who.clone(),
            values: r.timings.iter().map(|t| t.median_ns).collect(),
        })
        .collect();
    let names: Vec<String> = counts
        .iter()
        .map(|(c, _)| format!("{c} characters"))
        .collect();
    bar_plot(&options, &names, &series)
}
