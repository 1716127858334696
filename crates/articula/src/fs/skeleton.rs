//! Selection of the skeleton file of a motion by file name.

use crate::error::{Error, Result};
use crate::open::Format;

/// Selects the skeleton of a motion from the file names in its folder, with a reason if it is a
/// guess: the file of the same name; else the one with the longest name that is a prefix of the
/// motion's; else the only one.
pub(super) fn skeleton_of<'a>(
    motion: &str,
    beside: &[&'a str],
) -> Result<(&'a str, Option<&'static str>)> {
    let is_skeleton = |name: &&&str| Format::from_name(name) == Some(Format::Asf);
    let beside: Vec<&'a str> = beside.iter().filter(is_skeleton).copied().collect();
    let name = stem(motion);
    let begins = beside.iter().filter(|p| name.starts_with(&stem(p)));
    if let Some(best) = begins.max_by_key(|p| stem(p).len()) {
        let how = "the name of the motion begins with its name";
        return Ok((best, (stem(best) != name).then_some(how)));
    }
    match beside[..] {
        [only] => Ok((
            only,
            Some("it is the only .asf file in the folder of the motion"),
        )),
        [] => Err(Error::Skeleton(
            "the .asf file of this motion is not in the same folder; put it there".into(),
        )),
        _ => Err(Error::Skeleton(format!(
            "no .asf file in the folder has a name that matches this motion ({})",
            beside.join(", ")
        ))),
    }
}

/// A file's name without its extension, in lower case.
fn stem(name: &str) -> String {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    stem.to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_skeleton_is_called_like_the_motion() {
        let chosen = |motion: &str, beside: &[&str]| {
            let found = skeleton_of(motion, beside).ok();
            found.map(|(name, how)| (name.to_owned(), how.is_some()))
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
        assert_eq!(
            chosen("walk.amc", &["man.asf", "man.txt"]),
            some("man.asf", true)
        );
        assert_eq!(chosen("walk.amc", &["man.asf", "boy.asf"]), None);
        assert_eq!(chosen("walk.amc", &[]), None);
    }
}
