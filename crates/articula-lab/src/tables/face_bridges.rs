//! What blend shapes lose on the way through facial animation parameters.
//!
//! Random poses of blend shapes become parameters, quantised in the steps of the standard, and are
//! solved for weights again: with the generic columns of ARKit's shapes, with those measured on a
//! face's own morph targets at its feature points, and with the columns of another face.

use super::Run;
use super::random::Random;
use super::targets::{Target, section};
use anyhow::{Context, Result};
use articula::Figure;
use articula::face::HeadSurface;
use articula_build::face::{
    FaceBridge, FacePoints, FaceTable, FapValues, arkit_shape, blend_shape, opposite_controls,
};
use articula_core::arkit_table::{BLEND_SHAPES, are_opposite};
use articula_core::face_control::ShapeSet;
use articula_core::fap_table::{LOW_FAP_COUNT, LOW_FAPS, TABLE};
use std::fmt::Write as _;

/// Name and file of the faces whose own morph targets are measured.
const HEADS: [(&str, &str); 2] = [
    ("ICT-FaceKit", "face/ict_facekit_expressions.glb"),
    ("MakeHuman", "glb/mh_female_default163_arkit52.glb"),
];
const POSES: usize = 80;
/// Number of shapes that are active in a pose.
const ACTIVE: [usize; 2] = [6, 25];
/// Error of a weight up to which a shape counts as kept.
const KEPT: f32 = 0.03;
/// Shapes that are not opposites, as a face shows both, but undo each other.
const CLOSED: [&str; 2] = ["jawOpen", "mouthClose"];

/// Shapes with the parameters that each amounts to.
struct Columns {
    name: &'static str,
    shapes: Vec<(&'static str, FapValues)>,
}

/// Errors of a way through parameters, for one number of active shapes.
struct Way {
    made: &'static str,
    solved: &'static str,
    active: usize,
    /// Mean error of each shape's weight.
    shapes: Vec<(&'static str, f32)>,
}

impl Way {
    fn mean(&self) -> f64 {
        let sum: f32 = self.shapes.iter().map(|s| s.1).sum();
        f64::from(100.0 * sum) / self.shapes.len().max(1) as f64
    }

    fn kept(&self) -> usize {
        self.shapes.iter().filter(|s| s.1 <= KEPT).count()
    }

    fn is_same(&self) -> bool {
        self.made == self.solved
    }
}

/// Measures all ways and writes the page.
pub(crate) fn write(run: &Run) -> Result<()> {
    let mut columns = vec![generic()];
    for (name, file) in HEADS {
        let path = run.data.join(file);
        if !path.is_file() {
            println!("skipped: face-bridges: {} is missing", path.display());
            return Ok(());
        }
        let figure = Figure::new(articula::fs::open(&path)?)?;
        columns.push(own(name, &figure).context(file)?);
    }
    let [generic, ict, human] = &columns[..] else {
        unreachable!("three sets of columns");
    };
    let pairs = [
        (generic, generic),
        (ict, ict),
        (human, human),
        (ict, human),
        (generic, ict),
    ];
    let ways: Vec<Way> = pairs
        .iter()
        .flat_map(|(made, solved)| ACTIVE.map(|active| measured(made, solved, active)))
        .collect();
    run.save("face-bridges", &page(&ways), &csv(&ways))
}

/// The columns of the table of blend shapes.
fn generic() -> Columns {
    let shapes = BLEND_SHAPES.iter().filter(|s| s.name != "tongueOut");
    let column = |name| (name, blend_shape(name).unwrap_or_default());
    Columns {
        name: "generic",
        shapes: shapes.map(|s| column(s.name)).collect(),
    }
}

/// The columns of a face's own morph targets, from the motion of its feature points; gaze is taken
/// from the generic ones.
fn own(name: &'static str, figure: &Figure) -> Result<Columns> {
    let surface = HeadSurface::of(figure).surface;
    let points = FacePoints::find(&surface, &[])?;
    let table = FaceTable::new(&surface, &points).context("no table")?;
    let shapes = surface.shapes.iter().filter(|(n, _)| *n != "tongueOut");
    let column = |(name, offsets): &(&'static str, Vec<glam::Vec3>)| {
        let mut values = table.values(&points, offsets);
        let gaze = blend_shape(name).unwrap_or_default();
        for fap in 23..=26 {
            values.0[fap - LOW_FAPS.start()] = gaze.get(fap);
        }
        (*name, values)
    };
    Ok(Columns {
        name,
        shapes: shapes.map(column).collect(),
    })
}

/// Sends random poses of the shapes that both have through parameters.
fn measured(made: &Columns, solved: &Columns, active: usize) -> Way {
    let common: Vec<&'static str> = made
        .shapes
        .iter()
        .map(|s| s.0)
        .filter(|n| solved.shapes.iter().any(|s| s.0 == *n))
        .collect();
    let shapes: Vec<Option<usize>> = common.iter().map(|name| arkit_shape(name)).collect();
    let bridge = |columns: &Columns| {
        let of = |name: &&str| {
            let column = columns.shapes.iter().find(|s| s.0 == *name);
            column.map(|s| s.1).unwrap_or_default()
        };
        let shapes: Vec<_> = shapes
            .iter()
            .map(|s| s.map(|shape| ShapeSet::of([shape])))
            .collect();
        FaceBridge::new(common.iter().map(of).collect()).with_opposites(opposite_controls(&shapes))
    };
    let there = bridge(made);
    let undone = undone(&common, &shapes);
    let mut back = bridge(solved).solver([true; LOW_FAP_COUNT]);
    let mut random = Random(11);
    let mut errors = vec![0.0_f32; common.len()];
    for _ in 0..POSES {
        let weights = pose(&undone, active, &mut random);
        let found = back.solve(&quantised(there.faps(&weights)));
        for (error, (a, b)) in errors.iter_mut().zip(weights.iter().zip(&found.weights)) {
            *error += (a - b).abs() / POSES as f32;
        }
    }
    Way {
        made: made.name,
        solved: solved.name,
        active,
        shapes: common.into_iter().zip(errors).collect(),
    }
}

/// For each shape, those that it undoes.
fn undone(names: &[&str], shapes: &[Option<usize>]) -> Vec<Vec<usize>> {
    let undoes = |a: usize, b: usize| {
        let pair = [names[a], names[b]];
        let closes = pair == CLOSED || [pair[1], pair[0]] == CLOSED;
        closes || matches!([shapes[a], shapes[b]], [Some(a), Some(b)] if are_opposite(a, b))
    };
    let of = |a| (0..names.len()).filter(|b| undoes(a, *b)).collect();
    (0..names.len()).map(of).collect()
}

/// Weights of a pose without shapes that undo each other.
fn pose(undone: &[Vec<usize>], active: usize, random: &mut Random) -> Vec<f32> {
    let mut weights = vec![0.0; undone.len()];
    let mut left = active;
    // Each try is random; with half of all shapes active some tries are in vain.
    for _ in 0..100 * active {
        let shape = (random.unit() * undone.len() as f32) as usize % undone.len();
        let blocked = undone[shape].iter().any(|other| weights[*other] > 0.0);
        if left > 0 && weights[shape] == 0.0 && !blocked {
            weights[shape] = 0.05 + 0.95 * random.unit();
            left -= 1;
        }
    }
    weights
}

/// Whole steps of the standard's quantisers.
fn quantised(values: FapValues) -> FapValues {
    let mut values = values;
    for (value, fap) in values.0.iter_mut().zip(&TABLE[LOW_FAPS.start() - 1..]) {
        let step = f32::from(fap.step);
        *value = (*value / step).round() * step;
    }
    values
}

fn page(ways: &[Way]) -> String {
    let mut targets = Vec::new();
    for way in ways.iter().filter(|w| w.is_same()) {
        let (label, limit) = match way.active {
            6 => ("6 active shapes: mean error of a weight, %", 1.5),
            _ => ("25 active shapes: mean error of a weight, %", 3.0),
        };
        targets.push(Target::at_most([way.made, label], limit, way.mean()));
        if way.active == 6 {
            let label = "6 active shapes: share of shapes within 3 %, %";
            let share = 100.0 * way.kept() as f64 / way.shapes.len().max(1) as f64;
            targets.push(Target::at_least(
                [way.made, label],
                100.0 * 40.0 / 51.0,
                share,
            ));
        }
    }
    let mut page = format!(
        "# Blend shapes through facial animation parameters\n\nBy `articula-lab face-bridges`: {POSES} random poses of \
         blend shapes without `tongueOut` and without shapes that undo each other, as parameters in the steps of the \
         standard, and back to weights by least squares ([faces](../methods/faces.md)). *Generic*: the columns of \
         ARKit's shapes; the others are measured on the own morph targets of a face, at its feature points. ICT-FaceKit has \
         `browInnerUp` and `cheekPuff` in two halves, which are left out.\n"
    );
    let about = "A way is there and back with the same columns.";
    page.push_str(&section(about, &["columns", "quantity"], &targets));
    page.push_str(
        "\n## Ways\n\nWith other columns on the way back than on the way there, weights do not come back: \
         a stream is for the face that it was made for, or for its parameters.\n\n\
         | there | back | active | shapes | mean error | within 3 % |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    for way in ways {
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} | {:.1} % | {} |",
            way.made,
            way.solved,
            way.active,
            way.shapes.len(),
            way.mean(),
            way.kept()
        );
    }
    let lossy = ways.iter().find(|w| w.is_same() && w.active == 25);
    let lossy: Vec<&str> = lossy.map_or(Vec::new(), |w| {
        let lost = w.shapes.iter().filter(|s| s.1 > KEPT);
        lost.map(|s| s.0).collect()
    });
    let _ = write!(
        page,
        "\nWith 25 active shapes and the generic columns these lose more than 3 %: {}. `tongueOut` is left out.\n",
        lossy.join(", ")
    );
    page.push_str("\n## By shape\n\nMean error of the weight in percent of its range, 25 active shapes.\n\n| shape |");
    let shown: Vec<&Way> = ways.iter().filter(|w| w.active == 25).collect();
    for way in &shown {
        let _ = write!(page, " {} to {} |", way.made, way.solved);
    }
    page.push_str("\n| --- |");
    page.push_str(&" --- |".repeat(shown.len()));
    page.push('\n');
    for (name, _) in &ways[0].shapes {
        let _ = write!(page, "| {name} |");
        for way in &shown {
            match way.shapes.iter().find(|s| s.0 == *name) {
                Some((_, error)) => {
                    let _ = write!(page, " {:.1} % |", 100.0 * error);
                }
                None => page.push_str(" - |"),
            }
        }
        page.push('\n');
    }
    page
}

fn csv(ways: &[Way]) -> String {
    let mut csv = "there,back,active,shape,error\n".to_owned();
    for way in ways {
        for (name, error) in &way.shapes {
            let (made, solved, active) = (way.made, way.solved, way.active);
            let _ = writeln!(csv, "{made},{solved},{active},{name},{error:.4}");
        }
    }
    csv
}
