//! Opens any file of the data folder through the libraries, told by its extension.

use anyhow::{Context, Result};
use articula_build::joint_names::Mapping;
use articula_core::source::Character;
use articula_formats::mpeg4::{bap, epf, fap, fdp};
use articula_formats::{Limits, Warning, acclaim, bva, bvh, gltf, profile, x3d};
use glam::Vec3;
use std::path::Path;

/// What a file turned out to be.
pub(crate) enum Content {
    /// A character, or a motion with its skeleton.
    Figure(Box<Opened>),
    /// Numbers that move no joint by themselves.
    Data(Data),
}

/// A character that was opened.
pub(crate) struct Opened {
    pub(crate) character: Character,
    /// What its joints are.
    pub(crate) mapping: Mapping,
    /// The document behind a glTF file.
    pub(crate) behind: Option<gltf::GltfFile>,
    /// Joint and offset of end sites, of formats that have them.
    pub(crate) end_sites: Vec<(usize, Vec3)>,
    pub(crate) warnings: usize,
}

/// A file of parameters that was opened.
pub(crate) struct Data {
    /// What is in it, in a few words.
    pub(crate) what: String,
    /// Whether what is written of it reads the same; `None` if the format is not written.
    pub(crate) comes_back: Option<bool>,
    pub(crate) warnings: usize,
}

/// The formats, by the extensions of their files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Format {
    Glb,
    Gltf,
    Vrm,
    Vrma,
    Bvh,
    Bva,
    Asf,
    Amc,
    X3d,
    Bap,
    Fap,
    Epf,
    Fdp,
}

const FORMATS: [(&str, Format, &str); 14] = [
    ("glb", Format::Glb, "GLB"),
    ("gltf", Format::Gltf, "glTF"),
    ("vrm", Format::Vrm, "VRM"),
    ("vrma", Format::Vrma, "VRMA"),
    ("bvh", Format::Bvh, "BVH"),
    ("bva", Format::Bva, "BVA"),
    ("asf", Format::Asf, "ASF"),
    ("amc", Format::Amc, "AMC"),
    ("x3d", Format::X3d, "X3D"),
    ("wrl", Format::X3d, "X3D"),
    ("bap", Format::Bap, "BAP"),
    ("fap", Format::Fap, "FAP"),
    ("epf", Format::Epf, "EPF"),
    ("fdp", Format::Fdp, "FDP"),
];

/// Files that are no door of their own: notes, pictures, and what a door reads beside itself.
const BESIDE: [&str; 5] = ["md", "txt", "png", "bin", "json"];

impl Format {
    /// The format of a file's name; `None` for one that lies beside others.
    ///
    /// # Errors
    /// If nothing is known of the extension: a new door needs its reader here.
    pub(crate) fn of(path: &Path) -> Result<Option<Self>> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        let extension = extension.to_ascii_lowercase();
        if BESIDE.contains(&extension.as_str()) {
            return Ok(None);
        }
        let known = FORMATS.iter().find(|(name, ..)| *name == extension);
        let known = known.with_context(|| format!("{}: an unknown extension", path.display()))?;
        Ok(Some(known.1))
    }

    /// Whether it is glTF under one of its names.
    pub(crate) fn is_gltf(self) -> bool {
        matches!(self, Self::Glb | Self::Gltf | Self::Vrm | Self::Vrma)
    }

    /// Name as the table has it.
    pub(crate) fn name(self) -> &'static str {
        FORMATS
            .iter()
            .find(|row| row.1 == self)
            .map_or("", |row| row.2)
    }
}

/// Opens a file, with what lies beside it.
pub(crate) fn open(path: &Path) -> Result<Content> {
    let format = Format::of(path)?.context("this lies beside others")?;
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    let limits = Limits::default();
    Ok(match format {
        Format::Fap => Content::Data(faces(&bytes, &limits)?),
        Format::Epf => {
            let read = epf::read(&bytes, &limits)?;
            data(format!("{} frames", read.value.len()), None, &read.warnings)
        }
        Format::Fdp => {
            let read = fdp::read(&bytes, &limits)?;
            let (points, faps) = (read.value.points.len(), read.value.faps());
            data(
                format!("{points} feature points, {faps} FAPs"),
                None,
                &read.warnings,
            )
        }
        _ => Content::Figure(Box::new(figure(&bytes, format, path, Told::Nothing)?)),
    })
}

/// What a user may say of a file that names neither its unit nor its up axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Told {
    /// Nothing: both are told from the figure.
    Nothing,
    /// Y up and, of BVH, centimetres: as they are written.
    AsWritten,
}

impl Told {
    fn up(self) -> bvh::Up {
        if self == Self::Nothing {
            bvh::Up::Auto
        } else {
            bvh::Up::Y
        }
    }
}

/// Reads the bytes of a character; `path` says where the files beside it lie.
pub(crate) fn figure(bytes: &[u8], format: Format, path: &Path, told: Told) -> Result<Opened> {
    let limits = Limits::default();
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let mut beside = |uri: &str| std::fs::read(folder.join(uri)).map_err(|e| e.to_string());
    match format {
        Format::Bvh => {
            let options = bvh::ReadOptions {
                scale_to_metres: (told == Told::AsWritten).then_some(0.01),
                up: told.up(),
            };
            let read = bvh::read(bytes, &options, &limits)?;
            let file = read.value;
            Ok(opened(file.character, None, file.end_sites, &read.warnings))
        }
        Format::Bva => {
            let read = bva::read(bytes, &bva::ReadOptions::default(), &limits)?;
            Ok(opened(
                read.value.character,
                None,
                Vec::new(),
                &read.warnings,
            ))
        }
        Format::Asf => pair(bytes, None, told),
        Format::Amc => {
            let skeleton = skeleton_of(path)?;
            pair(&skeleton, Some(bytes), told)
        }
        Format::X3d => {
            let read = x3d::read(bytes, &limits, &mut beside)?;
            Ok(opened(
                read.value.character,
                None,
                Vec::new(),
                &read.warnings,
            ))
        }
        Format::Bap => {
            let read = bap::read(bytes, bap::Absent::default(), &limits)?;
            let character = bap::character(&read.value);
            Ok(opened(character, None, Vec::new(), &read.warnings))
        }
        _ => {
            let read = gltf::read(bytes, &limits, &mut beside)?;
            let file = read.value;
            let humanoid = file.humanoid.as_deref();
            let mut opened = opened(file.character.clone(), humanoid, Vec::new(), &read.warnings);
            opened.behind = Some(file);
            Ok(opened)
        }
    }
}

/// Reads an Acclaim skeleton and its motion.
pub(crate) fn pair(asf: &[u8], amc: Option<&[u8]>, told: Told) -> Result<Opened> {
    let options = acclaim::ReadOptions {
        up: told.up(),
        ..acclaim::ReadOptions::default()
    };
    let read = acclaim::read(asf, amc, &options, &Limits::default())?;
    let file = read.value;
    Ok(opened(file.character, None, file.end_sites, &read.warnings))
}

/// The skeleton beside a motion: `cmu_01.asf` is that of `cmu_01_01.amc`.
fn skeleton_of(motion: &Path) -> Result<Vec<u8>> {
    let stem = motion.file_stem().unwrap_or_default().to_string_lossy();
    let subject = stem
        .rsplit_once('_')
        .map_or(stem.as_ref(), |(subject, _)| subject);
    let path = motion.with_file_name(format!("{subject}.asf"));
    std::fs::read(&path).with_context(|| path.display().to_string())
}

fn opened(
    character: Character,
    given: Option<&[(usize, String)]>,
    end_sites: Vec<(usize, Vec3)>,
    warnings: &[Warning],
) -> Opened {
    Opened {
        mapping: articula_build::joint_names::map(&character.skeleton, profile::builtin(), given),
        character,
        behind: None,
        end_sites,
        warnings: warnings.len(),
    }
}

fn data(what: String, comes_back: Option<bool>, warnings: &[Warning]) -> Content {
    Content::Data(Data {
        what,
        comes_back,
        warnings: warnings.len(),
    })
}

fn faces(bytes: &[u8], limits: &Limits) -> Result<Data> {
    let absent = fap::Absent::default();
    let read = fap::read(bytes, absent, limits)?;
    let clip = read.value;
    let again = fap::read(&fap::write(&clip), absent, limits)?.value;
    let moving = clip.moving().iter().filter(|m| **m).count();
    Ok(Data {
        what: format!(
            "{} frames at {} Hz, {moving} FAPs move",
            clip.frames.len(),
            clip.rate_hz
        ),
        comes_back: Some(again.frames == clip.frames && again.rate_hz == clip.rate_hz),
        warnings: read.warnings.len(),
    })
}
