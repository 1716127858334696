//! Face animation tables made from feature points alone, beside the expressions of the same faces.
//!
//! The morph targets of a face are taken away, its points found and its table made; then each
//! expression is shown by the table and compared with the morph target, vertex by vertex, over the
//! vertices that are seen from outside and that either of them moves by more than 5 % of the
//! expression's largest displacement. Errors are in percent of that largest displacement.

use super::Run;
use super::lids::Lids;
use super::seen::seen;
use super::targets::{Target, section};
use anyhow::{Context, Result};
use articula::Figure;
use articula::face::HeadSurface;
use articula_build::face::{FacePoints, FaceSurface, FaceTable, FapValues};
use articula_core::fap_table::{FapDirection, FapUnit, LOW_FAPS, TABLE};
use articula_core::feature_points::PointId;
use glam::Vec3;
use std::collections::HashMap;
use std::fmt::Write as _;

/// Name, file, and limits of the errors: weights alone, and with the rules, mean in percent.
const HEADS: [(&str, &str, [f64; 2]); 2] = [
    (
        "ICT-FaceKit",
        "face/ict_facekit_expressions.glb",
        [11.0, 18.0],
    ),
    (
        "MakeHuman",
        "glb/mh_female_default163_arkit52.glb",
        [12.0, 18.0],
    ),
];

/// The expressions: the left ones of pairs.
const EXPRESSIONS: [&str; 26] = [
    "browDownLeft",
    "browOuterUpLeft",
    "cheekSquintLeft",
    "eyeBlinkLeft",
    "eyeSquintLeft",
    "eyeWideLeft",
    "jawForward",
    "jawLeft",
    "jawOpen",
    "mouthClose",
    "mouthDimpleLeft",
    "mouthFrownLeft",
    "mouthFunnel",
    "mouthLeft",
    "mouthLowerDownLeft",
    "mouthPressLeft",
    "mouthPucker",
    "mouthRollLower",
    "mouthRollUpper",
    "mouthShrugLower",
    "mouthShrugUpper",
    "mouthSmileLeft",
    "mouthStretchLeft",
    "mouthUpperUpLeft",
    "noseSneerLeft",
    "browInnerUp",
];

const UPPER_LIP: [PointId; 6] = [(2, 2), (2, 6), (2, 7), (8, 1), (8, 5), (8, 6)];
const LOWER_LIP: [PointId; 6] = [(2, 3), (2, 8), (2, 9), (8, 2), (8, 7), (8, 8)];
const LOWER_JAW: [PointId; 4] = [(2, 1), (2, 10), (2, 11), (2, 12)];
const CORNERS: [PointId; 4] = [(2, 4), (2, 5), (8, 3), (8, 4)];

/// Errors of one expression, percent of its largest displacement.
struct Shown {
    name: &'static str,
    largest_mm: f32,
    nothing: f32,
    weights: [f32; 2],
    rules: [f32; 2],
}

/// What was measured on a head.
struct Head {
    name: &'static str,
    limits: [f64; 2],
    shown: Vec<Shown>,
    /// Largest error of a point that its own parameter moves, percent of what the parameter says.
    points: f32,
    /// Largest difference between the motions by a parameter and, mirrored, by that of the other
    /// side, percent of the height of the face.
    sides: f32,
    /// What is left of the openings of the eyes while the lids are closed, percent of their height at
    /// rest, and the number of vertices that lids take into an eyeball.
    lids: Lids,
    /// Largest motion of the upper lip while the lower jaw opens, by that of the lower lip.
    upper_lip: f32,
}

/// Measures both heads and writes the page.
pub(crate) fn write(run: &Run) -> Result<()> {
    let mut heads = Vec::new();
    for (name, file, limits) in HEADS {
        let path = run.data.join(file);
        if !path.is_file() {
            println!("skipped: face-tables: {} is missing", path.display());
            return Ok(());
        }
        let figure = Figure::new(articula::fs::open(&path)?)?;
        heads.push(measure(name, limits, &figure).with_context(|| file)?);
    }
    run.save("face-tables", &page(&heads), &csv(&heads))
}

fn measure(name: &'static str, limits: [f64; 2], figure: &Figure) -> Result<Head> {
    let full = HeadSurface::of(figure).surface;
    let bare = FaceSurface {
        shapes: Vec::new(),
        ..full.clone()
    };
    let points = FacePoints::find(&bare, &[])?;
    let table = FaceTable::new(&bare, &points).context("no table")?;
    let seen = seen(&bare, points.height());
    let mut shown = Vec::new();
    let mut jaw_open = None;
    for expression in EXPRESSIONS {
        let Some((_, truth)) = full.shapes.iter().find(|(name, _)| *name == expression) else {
            continue;
        };
        if expression == "jawOpen" {
            jaw_open = Some(truth);
        }
        let weights = table.displacements_of_handles(|v| truth[v as usize]);
        let rules = table.displacements(&table.values(&points, truth));
        let still = vec![Vec3::ZERO; truth.len()];
        shown.push(Shown {
            name: expression,
            largest_mm: 1e3 * largest(truth, &seen),
            nothing: errors(truth, &still, &seen)[0],
            weights: errors(truth, &weights, &seen),
            rules: errors(truth, &rules, &seen),
        });
    }
    let jaw_open = jaw_open.context("jawOpen is missing")?;
    Ok(Head {
        name,
        limits,
        shown,
        points: own_points(&points, &table),
        sides: sides(&bare, &points, &table),
        lids: Lids::of(&bare, &table),
        upper_lip: upper_lip(&bare, &points, &table, jaw_open),
    })
}

/// Moves each point by its own parameter and compares it with what the parameter says.
fn own_points(points: &FacePoints, table: &FaceTable) -> f32 {
    const VALUE: f32 = 200.0;
    let mut worst = 0.0_f32;
    for fap in LOW_FAPS.filter(|fap| table.moves(*fap)) {
        let Some(action) = TABLE[fap - 1].action.filter(|a| a.unit != FapUnit::Angle) else {
            continue;
        };
        let along = match action.direction {
            FapDirection::Up => Vec3::Y,
            FapDirection::Down => -Vec3::Y,
            FapDirection::Left => Vec3::X,
            FapDirection::Right => -Vec3::X,
            _ => Vec3::Z,
        };
        let Some(vertex) = points.get(action.point).and_then(|p| p.vertex) else {
            continue;
        };
        let moved = table.displacements(&FapValues::alone(fap, VALUE))[vertex as usize].dot(along);
        let said = VALUE * points.units().distance(action.unit) / 1024.0;
        worst = worst.max(100.0 * (moved / said - 1.0).abs());
    }
    worst
}

/// Compares the tables of the two sides over the vertices that have a mirrored twin.
fn sides(surface: &FaceSurface, points: &FacePoints, table: &FaceTable) -> f32 {
    const PAIRS: [(usize, usize); 8] = [
        (6, 7),
        (8, 9),
        (12, 13),
        (19, 20),
        (31, 32),
        (35, 36),
        (39, 40),
        (61, 62),
    ];
    let key = |p: Vec3| p.to_array().map(|x| (1e5 * x).round() as i32);
    let mirrored = |p: Vec3| Vec3::new(-p.x, p.y, p.z);
    let at: HashMap<_, usize> = surface
        .positions
        .iter()
        .enumerate()
        .map(|(v, p)| (key(*p), v))
        .collect();
    let twins: Vec<(usize, usize)> = surface
        .positions
        .iter()
        .enumerate()
        .filter_map(|(v, p)| Some((v, *at.get(&key(mirrored(*p)))?)))
        .collect();
    let mut worst = 0.0_f32;
    for (left, right) in PAIRS {
        let [left, right] =
            [left, right].map(|fap| table.displacements(&FapValues::alone(fap, 200.0)));
        for (v, twin) in &twins {
            worst = worst.max(left[*v].distance(mirrored(right[*twin])));
        }
    }
    100.0 * worst / points.height()
}

/// Moves the lower jaw down, the corners of the lips by 0.3 of it, and compares the lips.
fn upper_lip(
    surface: &FaceSurface,
    points: &FacePoints,
    table: &FaceTable,
    jaw_open: &[Vec3],
) -> f32 {
    let vertex = |p: &PointId| points.get(*p).and_then(|p| p.vertex);
    let any = |list: &[PointId], v: u32| list.iter().any(|p| vertex(p) == Some(v));
    let moved = table.displacements_of_handles(|v| {
        if any(&LOWER_LIP, v) || any(&LOWER_JAW, v) {
            -Vec3::Y
        } else if any(&CORNERS, v) {
            -0.3 * Vec3::Y
        } else {
            Vec3::ZERO
        }
    });
    let height = points.height();
    let at = |p: &PointId| points.get(*p).map_or(Vec3::ZERO, |p| p.place);
    let near = |list: &[PointId], place: Vec3, most: f32| {
        list.iter().any(|p| at(p).distance(place) < most * height)
    };
    let open = jaw_open.iter().map(|d| d.length()).fold(0.0, f32::max);
    let mut most = [0.0_f32; 2];
    for (vertex, place) in surface.positions.iter().enumerate() {
        if near(&CORNERS, *place, 0.09) {
            continue;
        }
        let drop = jaw_open[vertex].length() / open;
        let (lip, counts) = if near(&UPPER_LIP, *place, 0.05) && drop < 0.25 {
            (0, true)
        } else {
            (1, near(&LOWER_LIP, *place, 0.05) && drop > 0.5)
        };
        if counts {
            most[lip] = most[lip].max(moved[vertex].length());
        }
    }
    100.0 * most[0] / most[1]
}

fn largest(truth: &[Vec3], seen: &[bool]) -> f32 {
    let all = truth.iter().zip(seen).filter(|(_, seen)| **seen);
    all.map(|(d, _)| d.length()).fold(0.0, f32::max)
}

/// Mean and 95th percentile of the errors, percent of the largest displacement.
fn errors(truth: &[Vec3], shown: &[Vec3], seen: &[bool]) -> [f32; 2] {
    let most = largest(truth, seen);
    let moved = |a: &Vec3, b: &Vec3| a.length().max(b.length()) > 0.05 * most;
    let pairs = truth.iter().zip(shown).zip(seen);
    let mut all: Vec<f32> = pairs
        .filter(|((a, b), seen)| **seen && moved(a, b))
        .map(|((a, b), _)| 100.0 * a.distance(*b) / most)
        .collect();
    all.sort_by(f32::total_cmp);
    let count = all.len().max(1);
    let p95 = all.get(95 * count / 100).copied().unwrap_or(f32::NAN);
    [all.iter().sum::<f32>() / count as f32, p95]
}

fn mean(shown: &[Shown], of: impl Fn(&Shown) -> f32) -> f64 {
    shown.iter().map(|s| f64::from(of(s))).sum::<f64>() / shown.len().max(1) as f64
}

fn targets(heads: &[Head]) -> Vec<Target> {
    let mut targets = Vec::new();
    for head in heads {
        let [weights, rules] = head.limits;
        let of = |f: fn(&Shown) -> f32| mean(&head.shown, f);
        targets.extend([
            Target::at_most(
                [head.name, "weights, true motion of the points: mean, %"],
                weights,
                of(|s| s.weights[0]),
            ),
            Target::at_most(
                [
                    head.name,
                    "weights, true motion of the points: 95th percentile, %",
                ],
                30.0,
                of(|s| s.weights[1]),
            ),
            Target::at_most(
                [head.name, "parameters and rules: mean, %"],
                rules,
                of(|s| s.rules[0]),
            ),
            Target::at_most(
                [head.name, "parameters and rules: 95th percentile, %"],
                48.0,
                of(|s| s.rules[1]),
            ),
            Target::at_most(
                [head.name, "a point moved by its own parameter, % off"],
                0.1,
                f64::from(head.points),
            ),
            Target::at_most(
                [
                    head.name,
                    "upper lip while the jaw opens, % of the lower lip",
                ],
                15.0,
                f64::from(head.upper_lip),
            ),
            Target::at_most(
                [head.name, "opening that closed lids leave, % of its height"],
                10.0,
                f64::from(head.lids.open_percent),
            ),
            Target::at_most(
                [
                    head.name,
                    "opening that closed lids leave as morph targets, % of its height",
                ],
                10.0,
                f64::from(head.lids.open_as_morphs_percent),
            ),
            Target::at_most(
                [
                    head.name,
                    "tables of the two sides, mirrored, % of the height of the face",
                ],
                0.01,
                f64::from(head.sides),
            ),
            Target::at_most(
                [head.name, "vertices that lids take into an eyeball"],
                0.0,
                head.lids.inside as f64,
            ),
        ]);
    }
    targets
}

fn page(heads: &[Head]) -> String {
    let targets = targets(heads);
    let mut page = "# Face animation tables\n\nBy `articula-lab face-tables`: tables made from feature points alone on \
                    heads whose morph targets were taken away, beside those morph targets \
                    ([faces](../methods/faces.md)). Errors are over the vertices that are seen from outside and that \
                    either moves by more than 5 % of the expression's largest displacement, in percent of \
                    it: means over the expressions, of each its mean and its 95th percentile.\n"
        .to_owned();
    let about = "The weights are measured with the true motion of every point; the rules with what parameters say of it, \
                 one component of each point.";
    page.push_str(&section(about, &["head", "quantity"], &targets));
    for head in heads {
        let _ = write!(
            page,
            "\n## {}\n\nAs morph targets, whose lines are straight, lids take {} vertices of the sockets into an eyeball.\n\n| expression | largest | nothing moves | weights | rules | rules, mean error |\n| --- | --- | --- | --- | --- | --- |\n",
            head.name, head.lids.inside_as_morphs
        );
        for s in &head.shown {
            let _ = writeln!(
                page,
                "| {} | {:.1} mm | {:.1} % | {:.1} % | {:.1} % | {:.2} mm |",
                s.name,
                s.largest_mm,
                s.nothing,
                s.weights[0],
                s.rules[0],
                s.largest_mm * s.rules[0] / 100.0
            );
        }
    }
    page
}

fn csv(heads: &[Head]) -> String {
    let mut csv = "head,expression,largest_mm,nothing_percent,weights_percent,weights_p95_percent,rules_percent,rules_p95_percent\n".to_owned();
    for head in heads {
        for s in &head.shown {
            let _ = writeln!(
                csv,
                "{},{},{:.3},{:.2},{:.2},{:.2},{:.2},{:.2}",
                head.name,
                s.name,
                s.largest_mm,
                s.nothing,
                s.weights[0],
                s.weights[1],
                s.rules[0],
                s.rules[1]
            );
        }
    }
    csv
}
