//! Opens any file of the data folder through the libraries, told by its extension.

use anyhow::{Context, Result, bail};
use articula_core::source::Character;
use articula_formats::profile::Mapping;
use articula_formats::{Limits, bvh, gltf, profile};
use glam::Vec3;
use std::path::Path;

/// A file that was opened.
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

/// The formats, by the extensions of their files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Format {
    Glb,
    Gltf,
    Vrm,
    Vrma,
    Bvh,
    /// One that no reader is for.
    Unread,
}

/// Files that are no door of their own: notes, pictures, and what a door reads beside itself.
pub(crate) const BESIDE: [&str; 5] = ["md", "txt", "png", "bin", "json"];

impl Format {
    /// The format of a file's name; `None` for one that lies beside others.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        Some(match extension.to_ascii_lowercase().as_str() {
            "glb" => Self::Glb,
            "gltf" => Self::Gltf,
            "vrm" => Self::Vrm,
            "vrma" => Self::Vrma,
            "bvh" => Self::Bvh,
            beside if BESIDE.contains(&beside) => return None,
            _ => Self::Unread,
        })
    }

    /// Whether it is glTF under one of its names.
    pub(crate) fn is_gltf(self) -> bool {
        matches!(self, Self::Glb | Self::Gltf | Self::Vrm | Self::Vrma)
    }

    /// Name as the table has it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Glb => "GLB",
            Self::Gltf => "glTF",
            Self::Vrm => "VRM",
            Self::Vrma => "VRMA",
            Self::Bvh => "BVH",
            Self::Unread => "-",
        }
    }
}

/// Opens a file, with what lies beside it.
pub(crate) fn open(path: &Path) -> Result<Opened> {
    let format = Format::of(path).context("this lies beside others")?;
    if format == Format::Unread {
        bail!("no reader is for it");
    }
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    opened(&bytes, format, path, Told::Nothing)
}

/// What a user may say of a BVH file, which names neither its unit nor its up axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Told {
    /// Nothing: both are told from the figure.
    Nothing,
    /// Centimetres and Y up, as they are written.
    Centimetres,
}

/// Reads bytes of a known format; `path` says where the files beside them lie.
pub(crate) fn opened(bytes: &[u8], format: Format, path: &Path, told: Told) -> Result<Opened> {
    let limits = Limits::default();
    if format == Format::Bvh {
        let options = match told {
            Told::Nothing => bvh::ReadOptions::default(),
            Told::Centimetres => bvh::ReadOptions {
                scale_to_metres: Some(0.01),
                up: bvh::Up::Y,
            },
        };
        let read = bvh::read(bytes, &options, &limits)?;
        let mut opened = figure(read.value.character, None);
        opened.end_sites = read.value.end_sites;
        opened.warnings = read.warnings.len();
        return Ok(opened);
    }
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let mut beside = |uri: &str| std::fs::read(folder.join(uri)).map_err(|e| e.to_string());
    let read = gltf::read(bytes, &limits, &mut beside)?;
    let file = read.value;
    let mut opened = figure(file.character.clone(), file.humanoid.as_deref());
    opened.behind = Some(file);
    opened.warnings = read.warnings.len();
    Ok(opened)
}

fn figure(character: Character, given: Option<&[(usize, String)]>) -> Opened {
    Opened {
        mapping: profile::map(&character.skeleton, profile::builtin(), given),
        character,
        behind: None,
        end_sites: Vec::new(),
        warnings: 0,
    }
}
