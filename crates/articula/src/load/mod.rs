//! From a file's name to a character: the format is told by the bytes, then by the name.

mod acclaim;
mod bap;
mod bva;
mod bvh;
pub(crate) mod data;
mod document;
mod format;
mod x3d;

pub(crate) use document::Behind;
pub(crate) use format::{Format, Writes, conversions, readable};

use crate::arguments::ReadArgs;
use crate::{fault, files};
use anyhow::{Context, bail};
use articula_build::joint_names::Mapping;
use articula_core::joint_names::Profile;
use articula_core::source::Character;
use articula_formats::mpeg4::bap::BapClip;
use articula_formats::profile;
use articula_formats::{Guess, Limits, Warning};
use std::path::{Path, PathBuf};

/// A file as it was read.
#[derive(Debug, Clone)]
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
    /// Joint and offset of each end site of a BVH or ASF file.
    pub(crate) end_sites: Vec<(usize, glam::Vec3)>,
    /// The parameters of a BAP file.
    pub(crate) parameters: Option<BapClip>,
    pub(crate) warnings: Vec<Warning>,
}

impl Loaded {
    /// What the reader found odd, each with its place.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let warnings = self.warnings.iter();
        warnings
            .map(|w| format!("{}: {}", w.at, advised(w)))
            .collect()
    }

    /// Puts the file's name in front of an error about its content.
    pub(crate) fn place(&self) -> String {
        files::shown(&self.path)
    }
}

/// What a loader is given.
struct Source<'a> {
    path: &'a Path,
    format: Format,
    bytes: &'a [u8],
    args: &'a ReadArgs,
    limits: Limits,
    profiles: &'a [Profile],
}

/// Turns the bytes of one format into a character; the caller names the file in errors.
type Loader = fn(&Source<'_>) -> anyhow::Result<Loaded>;

impl Source<'_> {
    /// A character as read; `given` is the map to VRM human bones that the file brings itself.
    fn loaded(
        &self,
        character: Character,
        warnings: Vec<Warning>,
        given: Option<&[(usize, String)]>,
    ) -> Loaded {
        Loaded {
            path: self.path.to_owned(),
            format: self.format,
            bytes: self.bytes.len(),
            mapping: articula_build::joint_names::map(&character.skeleton, self.profiles, given),
            character,
            behind: None,
            end_sites: Vec::new(),
            parameters: None,
            warnings,
        }
    }
}

/// Reads a character; profiles of the user are asked before the built-in ones.
pub(crate) fn character(path: &Path, args: &ReadArgs) -> anyhow::Result<Loaded> {
    let limits = Limits::default();
    let place = || files::shown(path);
    if let Some(data) = data::DataFormat::of_name(path) {
        bail!("{}: {}", place(), data.advice());
    }
    let profiles = profiles(&args.profile, &limits)?;
    let bytes = files::read(path, limits.bytes)?;
    let Some(format) = Format::of_bytes(&bytes, path) else {
        bail!(
            "{}: the start of the file: not a format that is read; give a {} file",
            place(),
            readable()
        );
    };
    let source = Source {
        path,
        format,
        bytes: &bytes,
        args,
        limits,
        profiles: &profiles,
    };
    format.loader()(&source).with_context(place)
}

/// What a warning says, and where a reader had to guess, the flag that decides.
pub(crate) fn advised(warning: &Warning) -> String {
    let flag = match warning.guess {
        None => return warning.what.clone(),
        Some(Guess::Unit) => "--unit-metres M",
        Some(Guess::UpAxis) => "--up y or --up z",
        Some(Guess::Rate) => "--amc-rate-hz HZ",
    };
    format!("{}; give {flag} if that is wrong", warning.what)
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
    fn a_guess_names_its_flag() {
        let guessed = |guess| advised(&Warning::guess("file", "inches", guess));
        let said = "inches; give --unit-metres M if that is wrong";
        assert_eq!(guessed(Guess::Unit), said);
        let said = "inches; give --up y or --up z if that is wrong";
        assert_eq!(guessed(Guess::UpAxis), said);
        let said = "inches; give --amc-rate-hz HZ if that is wrong";
        assert_eq!(guessed(Guess::Rate), said);
        assert_eq!(advised(&Warning::new("file", "odd")), "odd");
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
