//! Faces on a device without a graphics card: three meshes beside two portraits (the thesis' table 6.6).

use super::Run;
use crate::measure::median;
use crate::peers::node;
use anyhow::{Context, Result, bail};
use articula::flatten::{PortraitShot, portrait};
use articula::{Executor, Figure, Viewport};
use articula_flat::portrait::{PageOptions, PortraitOptions, page};
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The picture, pixels: that of the thesis' device.
const SIZE_PX: [u32; 2] = [240, 320];
/// Frames of a subject in a round, and rounds.
const EFFORT: [usize; 2] = [60, 5];
const SMALL_EFFORT: [usize; 2] = [2, 1];

/// What is shown of a head.
enum Form {
    /// Its mesh, as it is in the file.
    Mesh,
    /// A portrait with about so many triangles, or as many as it needs, and so many views.
    Portrait(Option<usize>, usize),
}

const SUBJECTS: [(&str, &str, Form); 5] = [
    ("3D, high", "face/ict_facekit_expressions.glb", Form::Mesh),
    ("3D, medium", "glb/ict_head_talk_1095.glb", Form::Mesh),
    ("3D, low", "glb/ict_head_talk_554.glb", Form::Mesh),
    (
        "2D, as the command makes it",
        "glb/ict_head_talk_1095.glb",
        Form::Portrait(None, 3),
    ),
    (
        "2D, one view of about 94 triangles",
        "glb/ict_head_talk_554.glb",
        Form::Portrait(Some(94), 1),
    ),
];

#[derive(Serialize)]
struct Job {
    width: u32,
    height: u32,
    frames: usize,
    rounds: usize,
    subjects: Vec<Subject>,
}

#[derive(Serialize)]
struct Subject {
    kind: &'static str,
    file: PathBuf,
}

/// What was measured of a subject.
#[derive(Deserialize)]
struct Timed {
    triangles: usize,
    vertices: usize,
    /// Milliseconds of a frame in each round.
    ms: Vec<f64>,
}

impl Timed {
    fn median_ms(&self) -> f64 {
        median(&mut self.ms.clone())
    }
}

/// Measures and writes the page.
pub(crate) fn write(run: &Run) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let mut named = Vec::new();
    let mut subjects = Vec::new();
    for (index, (name, file, form)) in SUBJECTS.iter().enumerate() {
        let path = run.data.join(file);
        if !path.is_file() {
            println!("skipped: portrait-times: {}", path.display());
            continue;
        }
        let subject = match form {
            Form::Mesh => Subject {
                kind: "mesh",
                file: path,
            },
            Form::Portrait(triangles, views) => {
                let file = folder.path().join(format!("{index}.html"));
                let text = portrait_page(&path, *triangles, *views)?;
                std::fs::write(&file, text).with_context(|| file.display().to_string())?;
                Subject {
                    kind: "portrait",
                    file,
                }
            }
        };
        let bytes = std::fs::metadata(&subject.file)?.len();
        named.push((*name, bytes));
        subjects.push(subject);
    }
    let [frames, rounds] = if run.small { SMALL_EFFORT } else { EFFORT };
    let [width, height] = SIZE_PX;
    let job = Job {
        width,
        height,
        frames,
        rounds,
        subjects,
    };
    let Some(timed) = timed(&job)? else {
        println!("skipped: portrait-times: no node with three.js and Chromium");
        return Ok(());
    };
    let (page, csv) = pages(&named, &timed)?;
    run.save("portrait-times", &page, &csv)
}

/// The portrait of a head as a page of the size of its picture.
fn portrait_page(file: &Path, triangles: Option<usize>, views: usize) -> Result<String> {
    let figure = Figure::new(articula::fs::open(file)?)?;
    let [width, height] = SIZE_PX;
    let shot = PortraitShot {
        clip: None,
        triangles,
        viewport: Viewport {
            width_px: width as f32,
            height_px: height as f32,
            ..Viewport::default()
        },
        default_mouth: true,
        options: PortraitOptions {
            views,
            pitch_limit_degrees: 10.0,
            ..PortraitOptions::default()
        },
    };
    let (_, made) = portrait(&figure, &shot, &Executor::default())?;
    let options = PageOptions {
        title: "portrait".into(),
        background: Vec::new(),
        audio: None,
        controls: false,
    };
    Ok(page(&made, &options)?)
}

/// Times the subjects in turns; `None` where node, its packages or Chromium are missing and
/// `ARTICULA_REQUIRE_TOOLS` does not require them.
fn timed(job: &Job) -> Result<Option<Vec<Timed>>> {
    if !node::has(&["node_modules/three"])? {
        return Ok(None);
    }
    let mut child = Command::new("node")
        .arg(node::oracle().join("portrait_times.mjs"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .context("node does not start")?;
    let mut input = child.stdin.take().context("node has no input")?;
    input.write_all(&serde_json::to_vec(job)?)?;
    drop(input);
    let output = child.wait_with_output()?;
    match output.status.code() {
        Some(0) => Ok(Some(serde_json::from_slice(&output.stdout)?)),
        Some(3) if !node::required() => Ok(None),
        _ => bail!("portrait_times.mjs: {}", output.status),
    }
}

fn pages(named: &[(&str, u64)], timed: &[Timed]) -> Result<(String, String)> {
    let mut page = HEAD.to_owned();
    let mut csv = "subject,triangles,vertices,bytes,ms,times_the_first\n".to_owned();
    let first = timed.first().map_or(f64::NAN, Timed::median_ms);
    for ((name, bytes), timed) in named.iter().zip(timed) {
        let ms = timed.median_ms();
        let Timed {
            triangles,
            vertices,
            ..
        } = timed;
        writeln!(
            page,
            "| {name} | {triangles} | {vertices} | {:.0} | {:.0} | {:.1} |",
            *bytes as f64 / 1e3,
            1e3 / ms,
            first / ms,
        )?;
        writeln!(
            csv,
            "\"{name}\",{triangles},{vertices},{bytes},{ms:.3},{:.3}",
            first / ms
        )?;
    }
    Ok((page, csv))
}

const HEAD: &str = "\
# Faces without a graphics card

Made by `cargo run --release -p articula-lab -- portrait-times` (Chromium, `npm ci` in `oracle`). The thesis' table 6.6: a face in 3D
at three resolutions, and in 2D, on a device that draws by its processor.

Heads of ICT-FaceKit in a picture of 240 × 320, all in one run, in turns, each frame waited for: the meshes of the files by
three.js 0.180 with a graphics card made of software, their morph targets and the head in motion; the portraits by their own
player, all expressions and the head in motion. kB are those of the file. A frame rate is one of this machine; the last column
compares with the finest mesh of the same run. A portrait calls the canvas for each of its triangles, a mesh the graphics card
once: portraits gain by few triangles.

| | triangles | vertices | kB | pictures/s | times as fast |
| --- | --- | --- | --- | --- | --- |
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_is_compared_with_the_first_one() {
        let timed = |ms: [f64; 3]| Timed {
            triangles: 7,
            vertices: 9,
            ms: ms.to_vec(),
        };
        let named = [("fine", 2_000), ("coarse", 1_500)];
        let (page, csv) = pages(
            &named,
            &[timed([90.0, 100.0, 300.0]), timed([5.0, 4.0, 1.0])],
        )
        .unwrap();
        assert!(
            page.ends_with(
                "| fine | 7 | 9 | 2 | 10 | 1.0 |\n| coarse | 7 | 9 | 2 | 250 | 25.0 |\n"
            ),
            "{page}"
        );
        assert!(csv.ends_with("\"coarse\",7,9,1500,4.000,25.000\n"), "{csv}");
    }
}
