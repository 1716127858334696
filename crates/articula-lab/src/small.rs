//! Every published table in its small setting: it runs to the end and writes its pages.
//!
//! These are unit tests of the program, so that they share its build with the other tests.

use crate::{Arguments, run};
use articula_build::{Asset, ClipOptions, character};
use articula_human::HumanOptions;
use clap::Parser;
use std::sync::LazyLock;

/// The reference human with few triangles, for all tests of the program.
pub(crate) fn human() -> &'static Asset {
    static HUMAN: LazyLock<Asset> = LazyLock::new(|| {
        let source = articula_human::human(&HumanOptions::mannequin(2_000)).unwrap();
        character(&source, None, &ClipOptions::default()).unwrap()
    });
    &HUMAN
}

/// Runs one table from its command line and returns the page. Where the full data is missing, the
/// repository's own characters are enough.
fn small(table: &str, page: &str) -> String {
    let out = std::env::temp_dir().join(format!("articula-small-{}-{table}", std::process::id()));
    let folder = out.display().to_string();
    let words = ["articula-lab", table, "--small", "--out", folder.as_str()];
    run(Arguments::try_parse_from(words).unwrap()).unwrap();
    let text = std::fs::read_to_string(out.join(page)).unwrap();
    std::fs::remove_dir_all(&out).unwrap();
    let rows = text.lines().filter(|l| l.starts_with("| ")).count();
    assert!(rows > 1, "{page} has {rows} rows");
    text
}

macro_rules! tables {
    ($($test:ident: $table:literal writes $page:literal;)*) => {$(
        #[test]
        fn $test() {
            small($table, $page);
        }
    )*};
}

tables! {
    adaptation: "adaptation" writes "adaptation.md";
    crowd: "crowd" writes "crowd.md";
    crowd_characters: "crowd-characters" writes "crowd-characters.md";
    crowd_errors: "crowd-errors" writes "crowd-errors.md";
    round_trips: "round-trips" writes "round-trips.md";
    loa_cost: "loa-cost" writes "loa-cost.md";
    merged_levels: "merged-levels" writes "merged-levels.md";
    mesh_levels: "mesh-levels" writes "mesh-levels.md";
    motion_lod: "motion-lod" writes "motion-lod.md";
    optimize: "optimize" writes "optimize.md";
    retargets: "retargets" writes "retargets.md";
    speech: "speech" writes "speech.md";
    streams: "streams" writes "streams.md";
    thesis_grid: "thesis-grid" writes "thesis-grid.md";
}

/// Feature points are as near to the landmarks of random heads as docs/methods/faces.md says. Their
/// file is not among those of the repository.
#[test]
fn feature_points_hold_the_targets() {
    let data = crate::data::folder(None, true).unwrap();
    if !data.is_some_and(|d| d.join("face/ict_identity10.glb").is_file()) {
        println!("skipped: no face/ict_identity10.glb");
        return;
    }
    let page = small("face-points", "face-points.md");
    assert!(page.contains("0 of 6 missed"), "{page}");
}

/// Blend shapes come back through parameters with a face's own columns; the generic ones miss the
/// target for poses in which half of all shapes are active.
#[test]
fn blend_shapes_come_back() {
    let data = crate::data::folder(None, true).unwrap();
    if !data.is_some_and(|d| d.join("face/ict_facekit_expressions.glb").is_file()) {
        println!("skipped: no face/ict_facekit_expressions.glb");
        return;
    }
    let page = small("face-bridges", "face-bridges.md");
    let missed: Vec<&str> = page.lines().filter(|l| l.contains("**missed**")).collect();
    assert!(
        missed.len() <= 1 && missed.iter().all(|l| l.starts_with("| generic | 25")),
        "{page}"
    );
}

/// Tables from feature points alone are as near to the expressions of the faces as
/// docs/methods/faces.md says.
#[test]
fn face_tables_hold_the_targets() {
    let data = crate::data::folder(None, true).unwrap();
    if !data.is_some_and(|d| d.join("face/ict_facekit_expressions.glb").is_file()) {
        println!("skipped: no face/ict_facekit_expressions.glb");
        return;
    }
    let page = small("face-tables", "face-tables.md");
    assert!(page.contains("0 of 20 missed"), "{page}");
}

/// The acceptance bounds 1 to 5 of a speaking face (docs/methods/vector.md, part 9) hold.
#[test]
fn a_speaking_face_holds_the_targets() {
    let page = small("flat", "flat.md");
    let mut rows = page.lines();
    rows.find(|l| l.starts_with("## Targets"));
    let targets: Vec<&str> = rows
        .take_while(|l| !l.starts_with("## "))
        .filter(|l| l.starts_with("| ") && !l.starts_with("| bound") && !l.starts_with("| ---"))
        .collect();
    for number in 1..=5 {
        let head = format!("| {number} |");
        assert!(targets.iter().any(|t| t.starts_with(&head)), "{targets:?}");
    }
    for target in targets {
        assert!(target.ends_with("| holds |"), "{target}");
    }
}
