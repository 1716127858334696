//! The packaged characters.

use crate::tables::Run;
use anyhow::{Context, Result};
use articula::item::{FaceMotion, Item, PackageOptions, package};
use articula::{Data, DataFormat, Executor, Figure, OpenOptions, fs, open_data};

/// A character to package.
pub(super) struct Case {
    /// Name on the page.
    pub(super) name: &'static str,
    file: &'static str,
    clips: &'static [&'static str],
    face: Option<&'static str>,
    /// Whether it is among the repository's own files.
    pub(super) is_small: bool,
}

const fn case(name: &'static str, file: &'static str, clips: &'static [&'static str]) -> Case {
    Case {
        name,
        file,
        clips,
        face: None,
        is_small: false,
    }
}

pub(super) const CASES: [Case; 5] = [
    case(
        "KayKit Knight",
        "glb/KayKit_Knight.glb",
        &[
            "Idle",
            "Walking_A",
            "Running_A",
            "Jump_Full_Long",
            "1H_Melee_Attack_Chop",
            "Block",
            "Hit_A",
            "Cheer",
        ],
    ),
    case("pab", "glb/pab_arnaud.glb", &[]),
    Case {
        is_small: true,
        ..case("RobotExpressive", "glb/RobotExpressive.glb", &[])
    },
    case("CesiumMan", "glb/CesiumMan.glb", &[]),
    Case {
        face: Some("fap/speech_synthetic.fap"),
        ..case("ICT head", "glb/ict_head_talk_1095.glb", &[])
    },
];

/// A character and its item.
pub(super) struct Packaged {
    pub(super) case: &'static Case,
    pub(super) figure: Figure,
    pub(super) item: Item,
    /// Size of the source file in bytes.
    pub(super) source_bytes: usize,
}

impl Packaged {
    /// Packages a character; `None` without its file.
    pub(super) fn new(run: &Run, case: &'static Case) -> Result<Option<Self>> {
        let path = run.data.join(case.file);
        if !path.is_file() {
            return Ok(None);
        }
        let opened = fs::open(&path)?;
        let faces = case.face.map(|file| face(run, file)).transpose()?;
        let clips = match run.small {
            // One is enough to see that it works.
            true => &["Robot_Walking"],
            false => case.clips,
        };
        let options = PackageOptions {
            clips: clips.iter().map(|name| (*name).to_owned()).collect(),
            faces: faces.into_iter().collect(),
            flat: false,
            ..PackageOptions::default()
        };
        let options = match run.small {
            true => PackageOptions {
                mesh_levels: 3,
                texture_distances_m: vec![3.0],
                ..options
            },
            false => options,
        };
        let source_bytes = opened.bytes();
        let item = package(opened.clone(), &options, &Executor::default())?;
        Ok(Some(Self {
            case,
            figure: Figure::new(opened)?,
            item,
            source_bytes,
        }))
    }
}

fn face(run: &Run, file: &str) -> Result<FaceMotion> {
    let path = run.data.join(file);
    let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
    let read = open_data(&bytes, file, DataFormat::Fap, &OpenOptions::default())?;
    match read.data {
        Data::Fap(clip) => Ok(FaceMotion {
            file: file.to_owned(),
            clip,
        }),
        _ => anyhow::bail!("{file}: expected facial animation parameters"),
    }
}
