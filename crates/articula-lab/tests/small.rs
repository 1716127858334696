//! Every published table in its small setting: it runs to its end and writes its pages.

#![allow(
    clippy::unwrap_used,
    reason = "a test may fail loudly, and says what it skips"
)]

#[path = "../../articula-formats/tests/it/real/mod.rs"]
mod real;

use std::path::Path;
use std::process::Command;

/// Runs one table and looks at what it wrote.
fn check(table: &str, pages: &[&str]) {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("small-{table}"));
    let _ = std::fs::remove_dir_all(&out);
    let ran = Command::new(env!("CARGO_BIN_EXE_articula-lab"))
        .args([table, "--small", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{table}: {said}");
    if !real::data_is_here() {
        assert!(String::from_utf8_lossy(&ran.stdout).contains("skipped: no data"));
        return;
    }
    for page in pages {
        let text = std::fs::read_to_string(out.join(page)).unwrap();
        let rows = text.lines().filter(|l| l.starts_with("| ")).count();
        assert!(rows > 1, "{page} has {rows} rows");
    }
}

macro_rules! tables {
    ($($test:ident: $table:literal writes $($page:literal),+;)*) => {$(
        #[test]
        fn $test() {
            check($table, &[$($page),+]);
        }
    )*};
}

tables! {
    crowd: "crowd" writes "crowd.md";
    doors: "doors" writes "doors.md";
    flat: "flat" writes "flat.md";
    merged_levels: "merged-levels" writes "merged-levels.md";
    mesh_levels: "mesh-levels" writes "mesh-levels.md";
    motion_lod: "motion-lod" writes "motion-lod.md";
    retargets: "retargets" writes "retargets.md";
    thesis_grid: "thesis-grid" writes "thesis-grid.md";
}
