//! Opens files of the data folder and describes what the tables need of them.

use anyhow::{Context, Result, anyhow};
use articula::convert::write_data;
use articula::{CharacterFile, Data, DataFormat, Format, OpenOptions, fs, open_data};
use articula_formats::{Assumption, UpAxis, Warning};
use std::path::Path;

/// Contents of a file.
pub(crate) enum Content {
    /// A character, or a motion with its skeleton.
    Figure(Box<CharacterFile>),
    /// Parameters that move no joint by themselves.
    Data(Parameters),
}

/// An opened file of parameters.
pub(crate) struct Parameters {
    /// Short description of its contents.
    pub(crate) what: String,
    /// Whether the file reads the same after writing; `None` if the format is not written.
    pub(crate) comes_back: Option<bool>,
    pub(crate) warnings: usize,
}

/// Kind of a file, by its extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Figure(Format),
    Data(DataFormat),
}

/// Extensions of files that are not read by themselves: notes, pictures, and files that others
/// refer to.
const BESIDE: [&str; 5] = ["md", "txt", "png", "bin", "json"];

impl Kind {
    /// Kind of a file by its name; `None` for files that only accompany others.
    ///
    /// # Errors
    /// If the extension is unknown: a new format needs its reader.
    pub(crate) fn of(path: &Path) -> Result<Option<Self>> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        let extension = extension.to_ascii_lowercase();
        if BESIDE.contains(&extension.as_str()) {
            return Ok(None);
        }
        let name = path.display().to_string();
        let figure = Format::from_name(&name).map(Self::Figure);
        let known = figure.or_else(|| DataFormat::from_name(&name).map(Self::Data));
        known
            .map(Some)
            .with_context(|| format!("{name}: an unknown extension"))
    }

    /// Whether it is one of the glTF formats.
    pub(crate) fn is_gltf(self) -> bool {
        let gltf = [Format::Glb, Format::Gltf, Format::Vrm, Format::Vrma];
        matches!(self, Self::Figure(format) if gltf.contains(&format))
    }

    /// Name of the format in the table.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Figure(Format::Gltf) => "glTF".to_owned(),
            Self::Figure(Format::X3dv | Format::Wrl) => "X3D".to_owned(),
            Self::Figure(format) => format.name().to_uppercase(),
            Self::Data(format) => format.name().to_uppercase(),
        }
    }
}

/// Opens a file and the files that it refers to. Errors do not name the file.
pub(crate) fn open(path: &Path) -> Result<Content> {
    match Kind::of(path)?.context("this lies beside others")? {
        Kind::Data(format) => Ok(Content::Data(parameters(path, format)?)),
        Kind::Figure(_) => {
            let opened = fs::open(path).map_err(|e| cause(&e))?;
            Ok(Content::Figure(Box::new(opened)))
        }
    }
}

/// Number of warnings about a file, without the one about the choice of its skeleton.
pub(crate) fn warnings(opened: &CharacterFile) -> usize {
    let own = |w: &&Warning| w.guess != Some(Assumption::Skeleton);
    opened.warnings().iter().filter(own).count()
}

/// Unit and up axis given for a file that states neither.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Told {
    /// None: both are detected from the figure.
    Nothing,
    /// Y up and, for BVH, centimetres, as Articula writes them.
    AsWritten,
}

/// Reads the bytes of a character; `path` locates the files that it refers to. A motion needs
/// its skeleton.
pub(crate) fn figure(
    (bytes, skeleton): (&[u8], Option<Vec<u8>>),
    format: Format,
    path: &Path,
    told: Told,
) -> Result<CharacterFile> {
    let is_told = told == Told::AsWritten;
    let options = OpenOptions {
        unit_metres: (is_told && format == Format::Bvh).then_some(0.01),
        up: if is_told { UpAxis::Y } else { UpAxis::Auto },
        skeleton,
        ..OpenOptions::default()
    };
    let name = format!("written.{}", format.name());
    let files = fs::Files::new(fs::Existing::Kept);
    let mut beside = files.beside(path, options.limits.bytes);
    articula::open(bytes, &name, &options, &mut beside).map_err(|e| cause(&e))
}

/// The error without the name of the file.
fn cause(error: &articula::Error) -> anyhow::Error {
    anyhow!(error.cause().to_string())
}

fn parameters(path: &Path, format: DataFormat) -> Result<Parameters> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path).with_context(|| name.clone())?;
    let read = |bytes: &[u8]| {
        let read = open_data(bytes, &name, format, &OpenOptions::default());
        read.map_err(|e| cause(&e))
    };
    let opened = read(&bytes)?;
    let (what, comes_back) = match &opened.data {
        Data::Fap(clip) => {
            let again = read(&write_data(&opened.data)?.bytes)?.data;
            let moving = clip.moving().iter().filter(|m| **m).count();
            let (frames, rate_hz) = (clip.frames.len(), clip.rate_hz);
            let same = matches!(
                again,
                Data::Fap(again) if again.frames == clip.frames && again.rate_hz == rate_hz
            );
            let what = format!("{frames} frames at {rate_hz} Hz, {moving} FAPs move");
            (what, Some(same))
        }
        Data::LiveLink(capture) => {
            let again = read(&write_data(&opened.data)?.bytes)?.data;
            let same = matches!(again, Data::LiveLink(again) if again.frames.len() == capture.frames.len());
            (format!("{} frames", capture.frames.len()), Some(same))
        }
        Data::Epf(frames) => (format!("{} frames", frames.len()), None),
        Data::Fdp(face) => {
            let (points, faps) = (
                face.points.len(),
                face.moved().iter().filter(|m| **m).count(),
            );
            (format!("{points} feature points, {faps} FAPs"), None)
        }
    };
    Ok(Parameters {
        what,
        comes_back,
        warnings: opened.warnings.len(),
    })
}
