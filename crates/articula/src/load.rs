//! From a file's name to a character: the format is told by the bytes, then by the name.

use crate::arguments::{ReadArgs, UpAxis};
use crate::{fault, files};
use anyhow::{Context, bail};
use articula_core::source::Character;
use articula_formats::gltf::{self, Document};
use articula_formats::profile::{self, Mapping, Profile};
use articula_formats::{Limits, ReadError, Warning, bvh};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// A format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Format {
    Glb,
    Gltf,
    Vrm,
    Vrma,
    Bvh,
}

impl Format {
    /// The format that a file name's extension says.
    pub(crate) fn of_name(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match extension.as_str() {
            "glb" => Self::Glb,
            "gltf" => Self::Gltf,
            "vrm" => Self::Vrm,
            "vrma" => Self::Vrma,
            "bvh" => Self::Bvh,
            _ => return None,
        })
    }

    /// The format of the bytes; a container of glTF may be called by a more special name.
    fn of_bytes(bytes: &[u8], path: &Path) -> Option<Self> {
        let named = Self::of_name(path);
        let first = bytes.iter().position(|b| !b.is_ascii_whitespace());
        let text = &bytes[first.unwrap_or(bytes.len())..];
        // Some editors put a byte order mark before text.
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let gltf = |usual| match named {
            Some(Self::Vrm | Self::Vrma) => named,
            _ => Some(usual),
        };
        if bytes.starts_with(b"glTF") {
            gltf(Self::Glb)
        } else if text.starts_with(b"{") {
            gltf(Self::Gltf)
        } else if text.starts_with(b"HIERARCHY") {
            Some(Self::Bvh)
        } else {
            // The reader of that format can say best what is wrong with it.
            named
        }
    }

    /// Name as reports spell it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Gltf => "gltf",
            Self::Vrm => "vrm",
            Self::Vrma => "vrma",
            Self::Bvh => "bvh",
        }
    }
}

/// The document of a glTF file, and which of its nodes the character came from.
#[derive(Debug)]
pub(crate) struct Behind {
    pub(crate) document: Document,
    pub(crate) node_of_joint: Vec<usize>,
    pub(crate) node_of_mesh: Vec<usize>,
}

/// A file as it was read.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) path: PathBuf,
    pub(crate) format: Format,
    /// Length of the file itself.
    pub(crate) bytes: usize,
    pub(crate) character: Character,
    /// What the joints are, by the file's own map or by their names.
    pub(crate) mapping: Mapping,
    /// What stands behind a glTF file, to be passed through; `None` for other formats.
    pub(crate) behind: Option<Behind>,
    /// Joint and offset of each end site of a BVH file.
    pub(crate) end_sites: Vec<(usize, glam::Vec3)>,
    pub(crate) warnings: Vec<Warning>,
}

impl Loaded {
    /// What the reader found odd, each with its place.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let warnings = self.warnings.iter();
        warnings.map(|w| format!("{}: {}", w.at, w.what)).collect()
    }

    /// Puts the file's name in front of an error about its content.
    pub(crate) fn place(&self) -> String {
        files::shown(&self.path)
    }
}

/// Reads a character; profiles of the user are asked before the built-in ones.
pub(crate) fn character(path: &Path, args: &ReadArgs) -> anyhow::Result<Loaded> {
    let limits = Limits::default();
    let profiles = profiles(&args.profile, &limits)?;
    let bytes = files::read(path, limits.bytes)?;
    let place = || files::shown(path);
    let Some(format) = Format::of_bytes(&bytes, path) else {
        bail!(
            "{}: the start of the file: not a format that is read; give a .glb, .gltf, .vrm, .vrma or .bvh file",
            place()
        );
    };
    let mut loaded = if format == Format::Bvh {
        motion(&bytes, args, &limits).with_context(place)?
    } else {
        document(path, &bytes, &limits, &profiles).with_context(place)?
    };
    loaded.path = path.to_owned();
    loaded.format = format;
    loaded.bytes = bytes.len();
    if loaded.behind.is_none() {
        loaded.mapping = profile::map(&loaded.character.skeleton, &profiles, None);
    }
    Ok(loaded)
}

fn motion(bytes: &[u8], args: &ReadArgs, limits: &Limits) -> Result<Loaded, ReadError> {
    let options = bvh::ReadOptions {
        scale_to_metres: args.unit_metres,
        up: match args.up {
            None => bvh::Up::Auto,
            Some(UpAxis::Y) => bvh::Up::Y,
            Some(UpAxis::Z) => bvh::Up::Z,
        },
    };
    let read = bvh::read(bytes, &options, limits)?;
    Ok(Loaded {
        path: PathBuf::new(),
        format: Format::Bvh,
        bytes: 0,
        mapping: profile::map(&read.value.character.skeleton, &[], None),
        character: read.value.character,
        end_sites: read.value.end_sites,
        behind: None,
        warnings: read.warnings,
    })
}

fn document(
    path: &Path,
    bytes: &[u8],
    limits: &Limits,
    profiles: &[Profile],
) -> Result<Loaded, ReadError> {
    let mut fetch = files::beside(path, limits.bytes);
    let read = gltf::read(bytes, limits, &mut fetch)?;
    let file = read.value;
    let given = profile::vrm_humanoid(&file.document.json).map(|bones| {
        let joint = |node: usize| file.node_of_joint.iter().position(|n| *n == node);
        let known = bones
            .into_iter()
            .filter_map(|(node, bone)| Some((joint(node)?, bone)));
        known.collect::<Vec<_>>()
    });
    Ok(Loaded {
        path: PathBuf::new(),
        format: Format::Glb,
        bytes: 0,
        mapping: profile::map(&file.character.skeleton, profiles, given.as_deref()),
        character: file.character,
        behind: Some(Behind {
            document: file.document,
            node_of_joint: file.node_of_joint,
            node_of_mesh: file.node_of_mesh,
        }),
        end_sites: Vec::new(),
        warnings: read.warnings,
    })
}

fn profiles(own: &[PathBuf], limits: &Limits) -> anyhow::Result<Vec<Profile>> {
    let mut all = Vec::new();
    for path in own {
        let bytes = files::read(path, limits.bytes)?;
        all.push(profile::parse(&bytes, limits).with_context(|| files::shown(path))?);
    }
    all.extend_from_slice(profile::builtin());
    Ok(all)
}

/// Finds a name among others, or says which there are.
pub(crate) fn choose<'a>(
    what: &str,
    wanted: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> anyhow::Result<usize> {
    if let Some(found) = names.clone().position(|n| n == wanted) {
        return Ok(found);
    }
    let mut known: Vec<String> = names.map(|n| format!("\"{n}\"")).collect();
    let count = known.len();
    known.truncate(30);
    if count > known.len() {
        known.push(format!(
            "and {} more (inspect lists them)",
            count - known.len()
        ));
    }
    let known = if count == 0 {
        "it has none".to_owned()
    } else {
        format!("it has {}", known.join(", "))
    };
    Err(fault::usage(format!(
        "no {what} is called \"{wanted}\"; {known}"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_decide_and_names_refine() {
        let of = |bytes: &[u8], name: &str| Format::of_bytes(bytes, Path::new(name));
        assert_eq!(of(b"glTF....", "a.bvh"), Some(Format::Glb));
        assert_eq!(of(b"glTF....", "a.VRM"), Some(Format::Vrm));
        assert_eq!(of(b" \n{\"asset\"", "a"), Some(Format::Gltf));
        assert_eq!(of(b"\xef\xbb\xbfHIERARCHY", "a.txt"), Some(Format::Bvh));
        assert_eq!(of(b"", "a.bvh"), Some(Format::Bvh));
        assert_eq!(of(b"\x89PNG", "a.png"), None);
    }

    #[test]
    fn a_wrong_name_is_answered_with_the_right_ones() {
        let names = ["walk", "run"];
        assert_eq!(choose("clip", "run", names.into_iter()).unwrap(), 1);
        let why = choose("clip", "fly", names.into_iter()).unwrap_err();
        assert!(why.to_string().contains("it has \"walk\", \"run\""));
        assert_eq!(fault::status(&why), 2);
    }
}
