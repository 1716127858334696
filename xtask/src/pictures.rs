//! `cargo xtask pictures`: makes the moving pictures of the readme from the repository's own assets, and the
//! picture of the reference human.

use crate::outcome::Outcome;
use crate::processes::run;
use crate::workspace::cargo;
use crate::{studio, web_pages};
use anyhow::{Context, Result};
use std::path::Path;

const CHARACTER: &str = "assets/glb/Quaternius_modular_men__Worker.glb";
const MOTION: &str = "assets/glb/pab_arnaud.glb";
const PICTURE: &str = "docs/pictures/walk.svg";
const TALK: &str = "docs/pictures/talk.png";

/// Writes the pictures.
pub(crate) fn pictures() -> Result<()> {
    let folder = std::env::temp_dir().join(format!("articula-pictures-{}", std::process::id()));
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    walk(&folder)?;
    talk(&folder)?;
    page()?;
    std::fs::remove_dir_all(&folder).with_context(|| folder.display().to_string())
}

/// Retargets a walk onto a clothed character and writes it as an animated SVG.
fn walk(folder: &Path) -> Result<()> {
    let walk = folder.join("walk.glb").display().to_string();
    let convert = ["convert", MOTION, &walk, "--onto", CHARACTER];
    let clip = ["--clip", "walk", "--root-motion", "in-place"];
    articula(&[&convert[..], &clip].concat())?;
    let flatten = ["flatten", &walk, PICTURE, "--clip", "walk"];
    let camera = ["--yaw-deg", "35", "--pitch-deg", "5"];
    let size = ["--size", "300x460", "--triangles", "620", "--force"];
    articula(&[&flatten[..], &camera, &size].concat())
}

/// Writes the painted human at moments while it talks.
fn talk(folder: &Path) -> Result<()> {
    let human = folder.join("human.glb").display().to_string();
    articula(&["human", &human, "--painted"])?;
    let sheet = format!("clip-sheet={TALK}");
    articula(&[
        "inspect", &human, "--clip", "talk", "--write", &sheet, "--force",
    ])
}

/// Records the studio, where Node and Chromium are.
fn page() -> Result<()> {
    for done in [studio::build, web_pages::record] {
        if let Outcome::Skipped(why) = done()? {
            println!("the studio is not recorded: {why}");
            break;
        }
    }
    Ok(())
}

fn articula(words: &[&str]) -> Result<()> {
    let program = ["run", "--release", "--quiet", "-p", "articula-cli", "--"];
    run(cargo().args(program).args(words))
}
