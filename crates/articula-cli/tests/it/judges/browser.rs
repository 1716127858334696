//! Pictures of written files, taken by Chromium (`oracle/browser.mjs` lists the kinds).

use super::super::Picture;
use super::{ask_on, is_required, judges_are_here};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// A file to show, and the times.
#[derive(Debug, Clone)]
pub(crate) struct Item {
    /// `svg`, `smil`, `smil-img`, `player`, `lottie` or `dotlottie`.
    pub(crate) kind: &'static str,
    pub(crate) file: PathBuf,
    /// Width and height in pixels.
    pub(crate) size: [u32; 2],
    /// Times of the pictures.
    pub(crate) times_secs: Vec<f64>,
    /// Whether to test that the untouched file plays (`smil`, `smil-img`, `player`).
    pub(crate) plays: bool,
}

/// Pictures of an [`Item`].
#[derive(Debug, Clone)]
pub(crate) struct Seen {
    /// At the requested times.
    pub(crate) pictures: Vec<Picture>,
    /// Whether the untouched file moved by itself; false if that was not requested.
    pub(crate) plays: bool,
}

/// Number of the next file of this run, so that concurrent tests use different files.
fn next() -> String {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    format!("{}-{number}", std::process::id())
}

/// A folder of this test program.
fn folder() -> PathBuf {
    // Cargo provides a folder to integration tests, not to unit tests.
    let scratch = option_env!("CARGO_TARGET_TMPDIR").map_or_else(std::env::temp_dir, PathBuf::from);
    let folder = scratch.join("browser");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Writes a file for [`Item::file`]; the extension of the name matters.
pub(crate) fn write(name: &str, content: &[u8]) -> PathBuf {
    let file = folder().join(format!("{}-{name}", next()));
    std::fs::write(&file, content).unwrap();
    file
}

/// Pictures by Chromium, one answer per item; `None` if it (or node) is missing, which is printed,
/// or fails where tools are required.
pub(crate) fn shots(items: &[Item]) -> Option<Vec<Seen>> {
    if !is_here() {
        return None;
    }
    let item = |item: &Item| {
        let out = folder().join(format!("{}-shot", next()));
        json!({
            "kind": item.kind, "file": item.file, "times_secs": item.times_secs,
            "width": item.size[0], "height": item.size[1], "plays": item.plays,
            "out_prefix": out,
        })
    };
    let job: Vec<Value> = items.iter().map(item).collect();
    let (answer, good) = ask_on("browser.mjs", &json!({ "items": job }).to_string());
    assert!(good, "{answer}");
    let answer: Value = serde_json::from_str(answer.lines().next().unwrap()).unwrap();
    Some(
        answer["items"]
            .as_array()
            .unwrap()
            .iter()
            .map(seen)
            .collect(),
    )
}

/// Reads the pictures of an answer and deletes their files.
fn seen(answer: &Value) -> Seen {
    let picture = |path: &Value| {
        let path = path.as_str().unwrap();
        let bytes = std::fs::read(path).unwrap();
        std::fs::remove_file(path).unwrap();
        Picture::decode(&bytes).unwrap()
    };
    Seen {
        pictures: answer["paths"]
            .as_array()
            .unwrap()
            .iter()
            .map(picture)
            .collect(),
        plays: answer["plays"].as_bool().unwrap_or(false),
    }
}

/// Whether Chromium and the scripts are available; prints it once if not.
pub(crate) fn is_here() -> bool {
    static HERE: OnceLock<bool> = OnceLock::new();
    *HERE.get_or_init(found)
}

fn found() -> bool {
    if !judges_are_here() {
        return false;
    }
    let named = std::env::var_os("CHROMIUM").map(|program| program.into_string().unwrap());
    let known = ["chromium", "chromium-browser", "google-chrome"].map(str::to_owned);
    let programs = named.map_or_else(|| known.to_vec(), |program| vec![program]);
    let starts = |program: &String| Command::new(program).arg("--version").output().is_ok();
    let here = programs.iter().any(starts);
    assert!(
        here || !is_required("ARTICULA_REQUIRE_TOOLS"),
        "no Chromium"
    );
    if !here {
        println!("skipped: no Chromium");
    }
    here
}
