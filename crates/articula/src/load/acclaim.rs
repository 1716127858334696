//! Acclaim files: a skeleton (`.asf`), or a motion (`.amc`) with the skeleton it was made for.

use super::{Format, Loaded, Source};
use crate::files;
use anyhow::{Context, bail};
use articula_formats::Warning;
use articula_formats::acclaim;
use std::path::{Path, PathBuf};

/// Reads a skeleton file by itself.
pub(super) fn load_skeleton(source: &Source<'_>) -> anyhow::Result<Loaded> {
    read(source, source.bytes, None)
}

/// Reads a motion and its skeleton.
pub(super) fn load_motion(source: &Source<'_>) -> anyhow::Result<Loaded> {
    let (skeleton, how) = skeleton(source)?;
    let place = files::shown(&skeleton);
    let bytes = files::read(&skeleton, source.limits.bytes)?;
    let loaded = read(source, &bytes, Some(source.bytes));
    let mut loaded = loaded.with_context(|| format!("with the skeleton {place}"))?;
    if let Some(how) = how {
        let name = skeleton.file_name().unwrap_or_default().to_string_lossy();
        let what = format!("{name} was taken, {how}; --skeleton F.asf names another");
        loaded.warnings.insert(0, Warning::new("skeleton", what));
    }
    Ok(loaded)
}

fn read(source: &Source<'_>, asf: &[u8], amc: Option<&[u8]>) -> anyhow::Result<Loaded> {
    let options = acclaim::ReadOptions {
        scale_to_metres: source.args.unit_metres,
        up: source.args.up(),
        rate_hz: source.args.amc_rate_hz,
    };
    let read = acclaim::read(asf, amc, &options, &source.limits)?;
    let mut loaded = source.loaded(read.value.character, read.warnings, None);
    loaded.end_sites = read.value.end_sites;
    Ok(loaded)
}

/// The skeleton of a motion, and why it is that one if that is a guess.
fn skeleton(source: &Source<'_>) -> anyhow::Result<(PathBuf, Option<&'static str>)> {
    if let Some(given) = &source.args.skeleton {
        return Ok((given.clone(), None));
    }
    let folder = source.path.parent().unwrap_or(Path::new(""));
    let here = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let mut beside = files::in_folder(here)?;
    beside.retain(|path| Format::of_name(path) == Some(Format::Asf));
    for path in &mut beside {
        *path = folder.join(path.file_name().unwrap_or_default());
    }
    if let Some((chosen, how)) = choose(source.path, &beside) {
        return Ok((chosen.clone(), how));
    }
    if beside.is_empty() {
        bail!(
            "the .asf file of this motion does not lie beside it; put it there or name it with --skeleton F.asf"
        );
    }
    let names = beside.iter().filter_map(|p| p.file_name());
    let names: Vec<_> = names.map(|n| n.to_string_lossy().into_owned()).collect();
    bail!(
        "none of the .asf files beside it is called like this motion ({}); name one with --skeleton F.asf",
        names.join(", ")
    )
}

/// The file of the same name; else the one with the longest name that the motion's begins
/// with; else the only one.
fn choose<'a>(motion: &Path, beside: &'a [PathBuf]) -> Option<(&'a PathBuf, Option<&'static str>)> {
    let stem = |path: &Path| {
        let stem = path.file_stem().unwrap_or_default();
        stem.to_string_lossy().to_lowercase()
    };
    let name = stem(motion);
    let begins = beside.iter().filter(|p| name.starts_with(&stem(p)));
    if let Some(best) = begins.max_by_key(|p| stem(p).len()) {
        let how = "since the motion's name begins like its name";
        return Some((best, (stem(best) != name).then_some(how)));
    }
    match beside {
        [only] => Some((
            only,
            Some("since no other .asf file lies beside the motion"),
        )),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_skeleton_is_called_like_the_motion() {
        let chosen = |motion: &str, beside: &[&str]| {
            let beside: Vec<PathBuf> = beside.iter().map(PathBuf::from).collect();
            let found = choose(Path::new(motion), &beside);
            found.map(|(path, how)| (path.display().to_string(), how.is_some()))
        };
        let some = |name: &str, guess| Some((name.to_owned(), guess));
        assert_eq!(
            chosen("walk.amc", &["a.asf", "walk.asf", "wal.asf"]),
            some("walk.asf", false)
        );
        assert_eq!(
            chosen("WALK.AMC", &["a.asf", "walk.ASF"]),
            some("walk.ASF", false)
        );
        assert_eq!(
            chosen("cmu_01_01.amc", &["cmu.asf", "cmu_01.asf", "cmu_02.asf"]),
            some("cmu_01.asf", true)
        );
        assert_eq!(chosen("walk.amc", &["man.asf"]), some("man.asf", true));
        assert_eq!(chosen("walk.amc", &["man.asf", "boy.asf"]), None);
        assert_eq!(chosen("walk.amc", &[]), None);
    }
}
