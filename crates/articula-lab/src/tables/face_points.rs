//! Errors of automatic feature points on random heads with published landmarks.
//!
//! The heads are the neutral head of ICT-FaceKit with its first ten identity modes, each weighted by a
//! seeded normal number. Truth are the 68 landmarks of the set, of which 42 are feature points or
//! lie midway between two landmarks. Errors are in percent of the height of the face: of the inner
//! brows above the chin.

use super::Run;
use super::random::Random;
use super::targets::{Target, section};
use anyhow::{Context, Result, ensure};
use articula::Figure;
use articula::face::face_layout;
use articula_core::feature_points::PointId;
use articula_core::source::Primitive;
use glam::Vec3;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

const FILE: &str = "face/ict_identity10.glb";
const HEADS: usize = 20;
const SMALL_HEADS: usize = 3;
/// Points that six clicks of a user give.
const CLICKS: [PointId; 6] = [(9, 3), (2, 1), (3, 7), (3, 12), (2, 4), (2, 5)];

/// Landmarks (numbered from 0 in the common order of 68) between which a point lies midway.
#[rustfmt::skip]
const TRUTH: [(PointId, usize, usize); 42] = [
    ((2, 1), 8, 8), ((2, 2), 62, 62), ((2, 3), 66, 66), ((2, 4), 64, 64), ((2, 5), 60, 60),
    ((2, 6), 63, 63), ((2, 7), 61, 61), ((2, 8), 65, 65), ((2, 9), 67, 67), ((2, 13), 12, 12),
    ((2, 14), 4, 4), ((3, 1), 43, 44), ((3, 2), 37, 38), ((3, 3), 46, 47), ((3, 4), 40, 41),
    ((3, 7), 45, 45), ((3, 8), 39, 39), ((3, 11), 42, 42), ((3, 12), 36, 36), ((4, 1), 22, 22),
    ((4, 2), 21, 21), ((4, 3), 24, 24), ((4, 4), 19, 19), ((4, 5), 26, 26), ((4, 6), 17, 17),
    ((8, 1), 51, 51), ((8, 2), 57, 57), ((8, 3), 54, 54), ((8, 4), 48, 48), ((8, 5), 53, 53),
    ((8, 6), 49, 49), ((8, 7), 55, 55), ((8, 8), 59, 59), ((8, 9), 50, 50), ((8, 10), 52, 52),
    ((9, 1), 35, 35), ((9, 2), 31, 31), ((9, 3), 30, 30), ((9, 4), 32, 32), ((9, 5), 34, 34),
    ((9, 12), 28, 28), ((9, 15), 33, 33),
];

/// Errors of one point on one head, in percent of the height of the face.
struct Measured {
    head: usize,
    point: PointId,
    /// From geometry and template; not of points that are given.
    alone: f32,
    /// With six points given; `None` for these.
    clicked: Option<f32>,
    /// What geometry alone shows, if it shows the point.
    seen: Option<f32>,
}

/// Measures all heads and writes the page.
pub(crate) fn write(run: &Run) -> Result<()> {
    let path = run.data.join(FILE);
    if !path.is_file() {
        println!("skipped: face-points: {} is missing", path.display());
        return Ok(());
    }
    let heads = if run.small { SMALL_HEADS } else { HEADS };
    let landmarks = landmarks(&path)?;
    let mut all = Vec::new();
    // Head 0 is the neutral one, from which the template was made.
    for head in 0..=heads {
        all.extend(measure(&path, &landmarks, head)?);
    }
    let page = page(&all, heads);
    run.save("face-points", &page, &csv(&all))
}

/// Vertices of the 68 landmarks, which the file names in the extras of its mesh.
fn landmarks(path: &Path) -> Result<Vec<usize>> {
    let bytes = std::fs::read(path)?;
    let length = bytes.get(12..16).context("a GLB file")?;
    let length = u32::from_le_bytes(length.try_into()?) as usize;
    let json: Value = serde_json::from_slice(bytes.get(20..20 + length).context("a GLB file")?)?;
    let list = &json["meshes"][0]["extras"]["landmarks68"];
    let list = list
        .as_array()
        .context("landmarks68 in the extras of the mesh")?;
    let numbers = list.iter().map(|n| n.as_u64().map(|n| n as usize));
    let numbers: Vec<usize> = numbers.collect::<Option<_>>().context("landmarks68")?;
    ensure!(numbers.len() == 68, "68 landmarks, not {}", numbers.len());
    Ok(numbers)
}

/// Moves the vertices of a head by random weights of its morph targets.
fn randomise(primitive: &mut Primitive, head: usize) {
    let mut random = Random(head as u64);
    for mode in &primitive.morphs {
        let weight = random.normal();
        for (at, offset) in primitive.positions.iter_mut().zip(&mode.positions) {
            *at += weight * *offset;
        }
    }
}

fn measure(path: &Path, landmarks: &[usize], head: usize) -> Result<Vec<Measured>> {
    let mut opened = articula::fs::open(path)?;
    if head > 0 {
        opened.edit_character(|character| {
            randomise(&mut character.meshes[0].primitives[0], head);
        });
    }
    let primitive = &opened.character().meshes[0].primitives[0];
    let places: Vec<Vec3> = landmarks.iter().map(|v| primitive.positions[*v]).collect();
    let truth = TRUTH.map(|(point, a, b)| (point, 0.5 * (places[a] + places[b])));
    let at = |point: PointId| {
        truth
            .iter()
            .find(|t| t.0 == point)
            .map_or(Vec3::ZERO, |t| t.1)
    };
    let height = 0.5 * (at((4, 1)).y + at((4, 2)).y) - at((2, 1)).y;
    let figure = Figure::new(opened)?;
    let given = CLICKS.map(|point| (point, at(point)));
    let alone = face_layout(&figure, &[])?;
    let clicked = face_layout(&figure, &given)?;
    let measured = truth.iter().map(|(point, place)| {
        let error = |found: Vec3| 100.0 * found.distance(*place) / height;
        let of = |layout: &articula::face::FaceLayout| {
            let found = layout.points.iter().find(|p| p.point == *point);
            found.map_or(f32::NAN, |p| error(Vec3::from(p.place_m)))
        };
        let seen = alone.seen.iter().find(|(p, _)| p == point);
        Measured {
            head,
            point: *point,
            alone: of(&alone),
            clicked: (!CLICKS.contains(point)).then(|| of(&clicked)),
            seen: seen.map(|(_, at)| error(Vec3::from(*at))),
        }
    });
    Ok(measured.collect())
}

fn page(all: &[Measured], heads: usize) -> String {
    let random = || all.iter().filter(|m| m.head > 0);
    let neutral = || all.iter().filter(|m| m.head == 0).filter_map(|m| m.seen);
    let alone = Errors::of(random().map(|m| m.alone));
    let clicked = Errors::of(random().filter_map(|m| m.clicked));
    let seen = Errors::of(neutral());
    let template = Errors::of(all.iter().filter(|m| m.head == 0).map(|m| m.alone));
    let targets = [
        Target::at_most(
            ["neutral head, geometry and template", "largest, %"],
            0.3,
            template.largest,
        ),
        Target::at_most(["neutral head, geometry alone", "mean, %"], 2.0, seen.mean),
        Target::at_most(
            ["neutral head, geometry alone", "largest, %"],
            5.0,
            seen.largest,
        ),
        Target::at_most(["random heads, 42 points", "mean, %"], 2.0, alone.mean),
        Target::at_most(
            ["random heads, 42 points", "95th percentile, %"],
            6.0,
            alone.p95,
        ),
        Target::at_most(
            ["random heads, six points given", "mean of the others, %"],
            2.0,
            clicked.mean,
        ),
    ];
    let mut page = format!(
        "# Feature points of faces\n\nBy `articula-lab face-points`: {heads} random heads of ICT-FaceKit, \
         whose 68 landmarks tell 42 of the feature points ([faces](../methods/faces.md)). Errors are in \
         percent of the height of the face, from the chin to the inner brows; the template is the \
         neutral head of the same set, so that heads of other makes have larger ones. The points of \
         ears, hair, cheeks, teeth and tongue have no landmark and are not measured.\n"
    );
    let about = "What geometry shows by itself is measured on the neutral head, from which the template \
                 was made, and there geometry and template must \
                 agree; everything else on the random ones.";
    page.push_str(&section(about, &["heads", "error"], &targets));
    let _ = write!(
        page,
        "\n## All points together\n\n| way | mean | median | 95th percentile | largest | within 3 % |\n\
         | --- | --- | --- | --- | --- | --- |\n"
    );
    for (name, errors) in [
        (
            "geometry alone, where it shows a point",
            Errors::of(random().filter_map(|m| m.seen)),
        ),
        ("geometry and template", alone),
        ("six points given, the others", clicked),
    ] {
        let _ = writeln!(page, "| {name} | {} |", errors.cells());
    }
    page.push_str(
        "\n## By point\n\nGeometry and template.\n\n| point | mean | median | 95th percentile | largest | within 3 % |\n\
         | --- | --- | --- | --- | --- | --- |\n",
    );
    for (point, _, _) in TRUTH {
        let errors = Errors::of(random().filter(|m| m.point == point).map(|m| m.alone));
        let _ = writeln!(page, "| {}.{} | {} |", point.0, point.1, errors.cells());
    }
    page
}

fn csv(all: &[Measured]) -> String {
    let mut csv =
        "head,point,error_percent,error_percent_six_given,error_percent_geometry\n".to_owned();
    let cell = |x: Option<f32>| x.map_or(String::new(), |x| format!("{x:.3}"));
    for m in all {
        let (clicked, seen) = (cell(m.clicked), cell(m.seen));
        let (group, number) = m.point;
        let _ = writeln!(
            csv,
            "{},{group}.{number},{:.3},{clicked},{seen}",
            m.head, m.alone
        );
    }
    csv
}

/// Summary of errors in percent.
struct Errors {
    mean: f64,
    median: f64,
    p95: f64,
    largest: f64,
    /// Share of errors up to 3 %, in percent.
    good: f64,
}

impl Errors {
    fn of(errors: impl Iterator<Item = f32>) -> Self {
        let mut sorted: Vec<f64> = errors.map(f64::from).collect();
        sorted.sort_by(f64::total_cmp);
        let count = sorted.len().max(1) as f64;
        let at = |share: f64| {
            let index = (share * count) as usize;
            sorted
                .get(index.min(sorted.len().saturating_sub(1)))
                .copied()
                .unwrap_or(f64::NAN)
        };
        Self {
            mean: sorted.iter().sum::<f64>() / count,
            median: at(0.5),
            p95: at(0.95),
            largest: at(1.0),
            good: 100.0 * sorted.iter().filter(|e| **e <= 3.0).count() as f64 / count,
        }
    }

    fn cells(&self) -> String {
        let Self {
            mean,
            median,
            p95,
            largest,
            good,
        } = self;
        format!("{mean:.2} % | {median:.2} % | {p95:.2} % | {largest:.2} % | {good:.0} %")
    }
}
