//! What mesh levels keep of faces: feature points that survive, and errors while the face moves.
//!
//! Levels are made with the feature points locked and errors weighted where the face moves, and
//! without. Two heads are also simplified after their morph targets were taken away; their errors
//! are then measured with these morph targets, which the simplifier did not see.

use super::Run;
use super::targets::{Target, section};
use anyhow::{Context, Result};
use articula::face::face_layout;
use articula::{
    CharacterFile, Executor, Figure, MeshLevelOptions, PrepareOptions, PreparedMeshLevels, prepare,
};
use articula_build::{LevelDistances, measure_levels};
use articula_core::Mesh;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

/// Name, file, and whether its morph targets are taken away.
const FIGURES: [(&str, &str, bool); 8] = [
    ("pab_arnaud", "glb/pab_arnaud.glb", false),
    ("MakeHuman man", "glb/mh_male_cmu31.glb", false),
    (
        "MakeHuman woman",
        "glb/mh_female_default163_arkit52.glb",
        false,
    ),
    (
        "MakeHuman woman, no morph targets",
        "glb/mh_female_default163_arkit52.glb",
        true,
    ),
    ("ICT head, 554", "glb/ict_head_talk_554.glb", false),
    ("ICT head, 1095", "glb/ict_head_talk_1095.glb", false),
    ("ICT-FaceKit", "face/ict_facekit_expressions.glb", false),
    (
        "ICT-FaceKit, no morph targets",
        "face/ict_facekit_expressions.glb",
        true,
    ),
];
/// The figure of a small run.
const SMALL: &str = "ICT head, 1095";
const LEVELS: usize = 5;

/// One level as it was made.
#[derive(Debug, Clone, Copy)]
struct Made {
    triangles: usize,
    /// Number of feature points that are left.
    survive: usize,
    /// Largest and mean error in motion, by the size of the figure, percent.
    largest: f64,
    mean: f64,
}

/// One level, made both ways: without and with what is kept of the face.
struct Row {
    figure: &'static str,
    level: usize,
    /// Feature points on the skin.
    points: usize,
    made: [Made; 2],
}

/// Measures all figures and writes the page.
pub(crate) fn write(run: &Run) -> Result<()> {
    let mut rows = Vec::new();
    for (name, file, is_bare) in FIGURES {
        let path = run.data.join(file);
        if run.small && name != SMALL {
            continue;
        }
        if !path.is_file() {
            println!("skipped: face-mesh-levels: {} is missing", path.display());
            return Ok(());
        }
        rows.extend(measure(name, &path, is_bare).with_context(|| file)?);
    }
    run.save("face-mesh-levels", &page(&rows), &csv(&rows))
}

fn measure(name: &'static str, path: &Path, is_bare: bool) -> Result<Vec<Row>> {
    let whole = Figure::new(articula::fs::open(path)?)?;
    let mesh = &whole.asset.mesh;
    let layout = face_layout(&Figure::new(figure_file(path, is_bare)?)?, &[])?;
    let points: Vec<u32> = layout.points.iter().filter_map(|p| p.vertex).collect();
    let mut made: Vec<Vec<Made>> = Vec::new();
    for keep_face in [false, true] {
        let options = PrepareOptions {
            mesh_levels: PreparedMeshLevels::New(MeshLevelOptions {
                max_error: None,
                keep_face,
                ..MeshLevelOptions::levels(LEVELS)
            }),
            ..PrepareOptions::default()
        };
        let opened = figure_file(path, is_bare)?;
        let levels = prepare(opened, &options, &Executor::default())?.mesh_levels;
        let levels = levels.context("no mesh levels")?.levels;
        let triangles = levels.triangles(mesh);
        let lists: Vec<&[[u32; 3]]> = triangles.iter().map(Vec::as_slice).collect();
        let (errors, _) = measure_levels(
            &whole.asset,
            &lists,
            &articula_build::MeshLevelOptions::default(),
        )?;
        let size = f64::from(levels.size_metres);
        let share = |metres: f32| 100.0 * f64::from(metres) / size;
        let level = |(triangles, error): (&Vec<[u32; 3]>, &LevelDistances)| Made {
            triangles: triangles.len(),
            survive: surviving(mesh, triangles, &points),
            largest: share(error.motion.max_metres.max(error.rest.max_metres)),
            mean: share(error.motion.mean_metres),
        };
        made.push(triangles.iter().zip(&errors).map(level).collect());
    }
    let [free, kept] = [&made[0], &made[1]];
    let row = |(level, (free, kept)): (usize, (&Made, &Made))| Row {
        figure: name,
        level,
        points: points.len(),
        made: [*free, *kept],
    };
    Ok(free.iter().zip(kept).enumerate().map(row).collect())
}

/// A character, perhaps without its morph targets.
fn figure_file(path: &Path, is_bare: bool) -> Result<CharacterFile> {
    let mut opened = articula::fs::open(path)?;
    if is_bare {
        opened.edit_character(|character| {
            character.clips.clear();
            for mesh in &mut character.meshes {
                mesh.morph_names.clear();
                mesh.morph_weights.clear();
                mesh.primitives.iter_mut().for_each(|p| p.morphs.clear());
            }
        });
    }
    Ok(opened)
}

/// Number of feature points with a vertex of the level at their place.
fn surviving(mesh: &Mesh, triangles: &[[u32; 3]], points: &[u32]) -> usize {
    let place = |v: u32| mesh.positions[v as usize].to_array().map(f32::to_bits);
    let used: BTreeSet<_> = triangles.iter().flatten().map(|v| place(*v)).collect();
    points.iter().filter(|v| used.contains(&place(**v))).count()
}

fn page(rows: &[Row]) -> String {
    let lost = |row: &Row| row.points - row.made[1].survive;
    let lost: usize = rows.iter().map(lost).sum();
    let coarse: Vec<&Row> = rows.iter().filter(|r| r.level == 3).collect();
    let worse = |row: &&&Row| row.made[1].largest > row.made[0].largest;
    let mut text = String::from(
        "# Faces in mesh levels\n\n\
         `cargo run --release -p articula-lab -- face-mesh-levels`\n\n\
         Levels with 100, 50, 25, 10 and 1.5 % of the triangles, made without and with what `build --levels` keeps of a \
         face: feature points are locked, and errors count more where the face moves (by its morph targets, or by its face \
         animation table if it has none). The error is the largest and the mean distance of the original from the level, in \
         motion or at rest, in percent of the longest side of the figure. \"No morph targets\": they were taken away \
         before simplification, and given back for measuring.\n",
    );
    text.push_str(&section(
        "Of [faces](../methods/faces.md).",
        &["quantity", ""],
        &[Target::at_most(
            [
                "feature points that some level lost",
                "all figures and levels",
            ],
            0.0,
            lost as f64,
        )],
    ));
    let _ = write!(
        text,
        "\nKeeping the points makes the largest error of the level of 10 % larger on {} of {} figures.\n\n",
        coarse.iter().filter(worse).count(),
        coarse.len()
    );
    text.push_str(
        "| figure | level | triangles | points left, free | kept | largest error %, free | kept | mean %, free | kept |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows.iter().filter(|r| r.level > 0) {
        let [free, kept] = &row.made;
        let triangles = match free.triangles == kept.triangles {
            true => free.triangles.to_string(),
            false => format!("{}, {}", free.triangles, kept.triangles),
        };
        let _ = writeln!(
            text,
            "| {} | {} | {triangles} | {} of {} | {} | {:.2} | {:.2} | {:.3} | {:.3} |",
            row.figure,
            row.level,
            free.survive,
            row.points,
            kept.survive,
            free.largest,
            kept.largest,
            free.mean,
            kept.mean,
        );
    }
    text
}

fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "figure,level,points,triangles_free,triangles_kept,points_free,points_kept,largest_percent_free,\
         largest_percent_kept,mean_percent_free,mean_percent_kept\n",
    );
    for row in rows {
        let [free, kept] = &row.made;
        let _ = writeln!(
            text,
            "\"{}\",{},{},{},{},{},{},{:.4},{:.4},{:.5},{:.5}",
            row.figure,
            row.level,
            row.points,
            free.triangles,
            kept.triangles,
            free.survive,
            kept.survive,
            free.largest,
            kept.largest,
            free.mean,
            kept.mean,
        );
    }
    text
}
