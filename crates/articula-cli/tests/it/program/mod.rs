//! Runs the program in a folder of its own, as a user would.

use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Mutex, OnceLock};

/// A new folder for the files of one test, under a name that no other test uses.
pub(crate) fn folder(name: &str) -> PathBuf {
    static USED: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let is_new = USED.lock().unwrap().insert(name.to_owned());
    assert!(is_new, "two tests write into {name}");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Result of one run.
pub(crate) struct Ran {
    pub(crate) status: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

/// Runs the program with arguments, in a folder.
pub(crate) fn articula(folder: &Path, words: &[&str]) -> Ran {
    let output: Output = Command::new(env!("CARGO_BIN_EXE_articula"))
        .args(words)
        .current_dir(folder)
        .output()
        .unwrap();
    Ran {
        status: output.status.code().unwrap_or(-1),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// Runs it with `--json`, expects success, and parses the result. Outputs of earlier runs of a test
/// are replaced.
pub(crate) fn json(folder: &Path, words: &[&str]) -> Value {
    let mut words = words.to_vec();
    words.push("--json");
    if !words.contains(&"--force") {
        words.push("--force");
    }
    let ran = articula(folder, &words);
    assert_eq!(ran.status, 0, "{words:?}: {}", ran.err);
    serde_json::from_str(&ran.out).unwrap()
}

/// Runs it, expects this status and one line on standard error; returns the line.
pub(crate) fn fault(folder: &Path, status: i32, words: &[&str]) -> String {
    let ran = articula(folder, words);
    assert_eq!(ran.status, status, "{words:?}: {} {}", ran.out, ran.err);
    assert_eq!(ran.err.lines().count(), 1, "{words:?}: {}", ran.err);
    assert!(ran.err.starts_with("error: "), "{}", ran.err);
    assert_eq!(ran.out, "", "an error gives no half result");
    ran.err
}

/// The reference human with few triangles, made once for all tests of one process.
pub(crate) fn human() -> &'static Path {
    static HUMAN: OnceLock<PathBuf> = OnceLock::new();
    HUMAN.get_or_init(|| {
        let folder = folder(&format!("human-{}", std::process::id()));
        let ran = articula(
            &folder,
            &["human", "--mannequin", "--triangles", "2500", "human.glb"],
        );
        assert_eq!(ran.status, 0, "{}", ran.err);
        folder.join("human.glb")
    })
}

/// Seconds of each clip of [`short`] and [`small`].
const SHORT: &str = "..0.4";

/// The reference human with the first 0.4 s of each of its clips, made once for all tests of one
/// process: for what holds for clips of any length.
pub(crate) fn short() -> &'static Path {
    static SHORT_HUMAN: OnceLock<PathBuf> = OnceLock::new();
    SHORT_HUMAN.get_or_init(|| {
        let words = ["convert", word(human()), "human.glb", "--trim", SHORT];
        made("short", &[&words])
    })
}

/// The same with a tenth of the triangles: for what holds for any surface, too.
pub(crate) fn small() -> &'static Path {
    static SMALL: OnceLock<PathBuf> = OnceLock::new();
    SMALL.get_or_init(|| {
        let levels = ["build", word(short()), "all.glb", "--targets", "100,10"];
        let coarse = ["convert", "all.glb", "human.glb", "--mesh-level", "1"];
        made("small", &[&levels, &coarse])
    })
}

/// The reference human as an asset with five mesh levels. A crowd of it is that of the human
/// (`assets` compares the two on short clips) and need not make the tables first.
pub(crate) fn prepared() -> &'static Path {
    static PREPARED: OnceLock<PathBuf> = OnceLock::new();
    PREPARED.get_or_init(|| {
        let words = ["build", word(human()), "human.glb", "--levels", "5"];
        made("prepared", &[&words])
    })
}

/// `human.glb` in a folder of this process, as commands leave it.
fn made(name: &str, commands: &[&[&str]]) -> PathBuf {
    let folder = folder(&format!("{name}-{}", std::process::id()));
    for words in commands {
        let ran = articula(&folder, words);
        assert_eq!(ran.status, 0, "{words:?}: {}", ran.err);
    }
    folder.join("human.glb")
}

/// A path as an argument.
pub(crate) fn word(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A figure of five joints that nods and lifts an arm, as BVH.
pub(crate) const BVH: &str = "HIERARCHY
ROOT Hips
{
  OFFSET 0 90 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Spine
  {
    OFFSET 0 30 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT Head
    {
      OFFSET 0 30 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 20 0
      }
    }
    JOINT LeftArm
    {
      OFFSET 20 25 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      JOINT LeftForeArm
      {
        OFFSET 28 0 0
        CHANNELS 3 Zrotation Xrotation Yrotation
        End Site
        {
          OFFSET 25 0 0
        }
      }
    }
  }
}
MOTION
Frames: 4
Frame Time: 0.0333333
0 90 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0
0 90 1 0 0 0 0 5 0 0 10 0 20 0 0 30 0 0
0 90 2 0 0 0 0 5 0 0 20 0 40 0 0 60 0 0
0 90 3 0 0 0 0 0 0 0 10 0 60 0 0 90 0 0
";

/// Writes a GLB file with an edited document; its binary part stays.
pub(crate) fn edited(glb: &Path, out: &Path, edit: impl FnOnce(&mut Value)) {
    let bytes = std::fs::read(glb).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut document: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    edit(&mut document);
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let rest = &bytes[20 + length..];
    let mut made = b"glTF".to_vec();
    for number in [2, (20 + text.len() + rest.len()) as u32, text.len() as u32] {
        made.extend(number.to_le_bytes());
    }
    made.extend(b"JSON");
    made.extend(text);
    made.extend(rest);
    std::fs::write(out, made).unwrap();
}
