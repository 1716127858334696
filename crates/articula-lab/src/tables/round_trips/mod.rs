//! Round trips of every data file: whether it opens, its contents, and the output of every writer.

mod compare;
mod judge;
#[cfg(test)]
mod manifest;
mod page;
mod written;

use super::Run;
use crate::open::{self, Content, Kind, Parameters};
use anyhow::{Context, Result};
use articula::CharacterFile;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use written::Trip;

/// Maximum size of the files of a small run in bytes.
const SMALL_BYTES: u64 = 200_000;

/// Folders of third-party texts and test files of unsupported formats, which are not read.
const NOT_READ: [&str; 2] = ["licences", "lottie_spec"];

/// Files that must be refused, and a word of the reason.
const REFUSED: [(&str, &str); 1] = [("glb/Quaternius_Astronaut_Barbara_draco.glb", "Draco")];

/// One file.
struct RoundTrip {
    path: PathBuf,
    /// Path below the data folder.
    name: String,
    kind: Kind,
    /// Contents, or the reason why the file was refused.
    found: Result<Found>,
    trips: Vec<Trip>,
}

/// Contents of a file that opens.
enum Found {
    Figure(Counts),
    Data(Parameters),
}

/// Counts of a character file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Counts {
    /// Distinct joints of the skins, or all joints if there is no skin.
    joints: usize,
    /// Joints that correspond to one of the standard.
    mapped: usize,
    clips: usize,
    meshes: usize,
    vertices: usize,
    triangles: usize,
    morphs: usize,
    expressions: usize,
    warnings: usize,
}

impl Counts {
    /// The columns of the table, in order.
    fn columns(&self) -> [usize; 8] {
        [
            self.joints,
            self.mapped,
            self.clips,
            self.meshes,
            self.triangles,
            self.morphs,
            self.expressions,
            self.warnings,
        ]
    }

    /// Counts the contents of a file.
    fn of(opened: &CharacterFile) -> Self {
        let character = opened.character();
        let primitives = || character.meshes.iter().flat_map(|m| &m.primitives);
        let skeleton = &character.skeleton.joints;
        let skin = skeleton.iter().filter(|j| j.in_skin).count();
        Self {
            joints: if skin == 0 { skeleton.len() } else { skin },
            mapped: opened.mapping().articulation.mapped(),
            clips: character.clips.len(),
            meshes: character.meshes.len(),
            vertices: primitives().map(|p| p.positions.len()).sum(),
            triangles: primitives().map(|p| p.triangles.len()).sum(),
            morphs: character.meshes.iter().map(|m| m.morph_weights.len()).sum(),
            expressions: character.expressions.len(),
            warnings: open::warnings(opened),
        }
    }
}

/// The files of the data folder in a format that is read, in order.
fn files(data: &Path) -> Result<Vec<(PathBuf, Kind)>> {
    let mut all = Vec::new();
    let mut open = vec![data.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if path.is_dir() && !NOT_READ.contains(&name.as_ref()) {
                open.push(path);
            } else if path.is_file()
                && let Some(kind) = Kind::of(&path)?
            {
                all.push((path, kind));
            }
        }
    }
    all.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(all)
}

/// Opens one file, and writes it with every writer into a folder.
fn round_trip(data: &Path, path: &Path, kind: Kind, folder: &Path) -> Result<RoundTrip> {
    let name = path
        .strip_prefix(data)
        .unwrap_or(path)
        .display()
        .to_string();
    let mut trips = Vec::new();
    let found = match open::open(path) {
        Ok(Content::Figure(opened)) => {
            let stem = folder.join(name.replace(['/', '\\', '.'], "-"));
            trips = written::trips(&opened, path, &stem)?;
            Ok(Found::Figure(Counts::of(&opened)))
        }
        Ok(Content::Data(data)) => Ok(Found::Data(data)),
        Err(fault) => Err(fault),
    };
    Ok(RoundTrip {
        path: path.to_owned(),
        name,
        kind,
        found,
        trips,
    })
}

/// Opens all files, and writes them into a folder.
fn round_trips(run: &Run, folder: &Path) -> Result<Vec<RoundTrip>> {
    let mut files = files(&run.data)?;
    if run.small {
        files.retain(|(path, _)| path.metadata().is_ok_and(|m| m.len() <= SMALL_BYTES));
    }
    let all = files.par_iter();
    all.map(|(path, kind)| round_trip(&run.data, path, *kind, folder))
        .collect()
}

/// A temporary folder for the written files.
fn scratch() -> Result<PathBuf> {
    static MADE: AtomicU32 = AtomicU32::new(0);
    let (process, made) = (std::process::id(), MADE.fetch_add(1, Ordering::Relaxed));
    let folder = std::env::temp_dir().join(format!("articula-round-trips-{process}-{made}"));
    std::fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// Runs the table and writes it.
pub(crate) fn write(run: &Run) -> Result<()> {
    let folder = scratch()?;
    let round_trips = round_trips(run, &folder)?;
    let errors = if run.small {
        None
    } else {
        judge::errors(&page::judged(&round_trips))?
    };
    std::fs::remove_dir_all(&folder)?;
    if errors.is_none() && !run.small {
        println!("skipped: the validator (no node, or `npm ci` was not run in oracle)");
    }
    run.save(
        "round-trips",
        &page::page(&round_trips, errors.as_ref())?,
        &page::csv(&round_trips)?,
    )?;
    run.save_csv(
        "round-trips-written",
        &page::csv_written(&round_trips, errors.as_ref())?,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data;

    /// Every file of the folder opens or is refused for the right reason; the output of each writer
    /// opens again within its bound; and the counts are those that another parser measured.
    #[test]
    fn every_door_opens_and_every_writer_comes_back() {
        let Some(data) = data::folder(None, false).unwrap() else {
            println!("skipped: no data");
            return;
        };
        let manifest = std::fs::read_to_string(data.join("MANIFEST.md")).unwrap();
        let run = Run {
            data,
            out: PathBuf::new(),
            small: false,
        };
        let folder = scratch().unwrap();
        let round_trips = round_trips(&run, &folder).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        for round_trip in &round_trips {
            check(round_trip);
        }
        for (name, _) in REFUSED {
            assert!(
                round_trips.iter().any(|d| d.name == name),
                "{name} is not there"
            );
        }
        let mut compared = 0;
        for listed in manifest::listed(&manifest) {
            let round_trip = round_trips.iter().find(|d| d.name == listed.name);
            let round_trip = round_trip.unwrap_or_else(|| panic!("{} is not there", listed.name));
            let Ok(Found::Figure(found)) = &round_trip.found else {
                continue;
            };
            for (what, found, expected) in [
                ("joints", found.joints, listed.joints),
                ("vertices", found.vertices, listed.vertices),
                ("triangles", found.triangles, listed.triangles),
                ("clips", found.clips, listed.clips),
            ] {
                let expected = expected.unwrap_or(found);
                assert_eq!(found, expected, "{what} of {}", listed.name);
            }
            compared += 1;
        }
        assert!(
            compared > 20,
            "only {compared} rows of the list were understood"
        );
    }

    fn check(round_trip: &RoundTrip) {
        let refused = REFUSED.iter().find(|(name, _)| *name == round_trip.name);
        match (&round_trip.found, refused) {
            (Err(why), Some((_, word))) => {
                assert!(why.to_string().contains(word), "{}: {why}", round_trip.name);
            }
            (Err(why), None) => panic!("{}: {why}", round_trip.name),
            (Ok(_), Some(_)) => panic!("{} should be refused", round_trip.name),
            (Ok(Found::Data(data)), None) => {
                assert_ne!(data.comes_back, Some(false), "{}", round_trip.name);
            }
            (Ok(Found::Figure(_)), None) => {}
        }
        for trip in &round_trip.trips {
            let (name, writer) = (&round_trip.name, trip.writer.name());
            assert!(trip.holds(), "{name}, {writer}: {:?}", trip.apart);
        }
    }
}
