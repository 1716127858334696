//! Flags of `crowd` that say who matters and what hides whom.

use crate::fault;
use anyhow::Context;
use articula::build::{IMPORTANCE_RANGE, Scene};
use articula::core::Clip;
use articula::crowd::Hiders;
use clap::{Args, ValueEnum};
use std::str::FromStr;

/// Who matters, and what hides whom.
#[derive(Debug, Clone, Args)]
pub(crate) struct ImportanceArgs {
    /// Role of characters from the beginning (repeatable): main, secondary, audience or one of the
    /// scene file, then their numbers, such as main=0,17,40-49
    #[arg(long, value_name = "ROLE=N,N-N,…", value_parser = of_role)]
    role: Vec<RoleOf>,
    /// Importance of who plays a clip (repeatable), such as wave=2: 1 is neutral, 2 halves the tolerance
    #[arg(long, value_name = "CLIP=I", value_parser = of_clip)]
    clip_importance: Vec<ClipImportance>,
    /// What hides characters, which are then not evaluated
    #[arg(long, value_enum, default_value = "walls")]
    hiders: HidersName,
}

#[derive(Debug, Clone)]
struct RoleOf {
    role: String,
    /// First and last number of each range.
    ranges: Vec<(usize, usize)>,
}

#[derive(Debug, Clone)]
struct ClipImportance {
    clip: String,
    importance: f32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum HidersName {
    /// Nothing
    None,
    /// The walls of the scene
    Walls,
    /// The walls, and the nearest characters
    All,
}

impl ImportanceArgs {
    /// What hides characters.
    pub(super) fn hiders(&self) -> Hiders {
        match self.hiders {
            HidersName::None => Hiders::Nothing,
            HidersName::Walls => Hiders::Walls,
            HidersName::All => Hiders::Everything,
        }
    }

    /// Adds the roles and the importance of clips to a scene; `clips` has those of each character of the cast.
    pub(super) fn apply(&self, scene: &mut Scene, clips: &[&[Clip]]) -> anyhow::Result<()> {
        let count = scene.members.len();
        let importance = &mut scene.importance;
        for RoleOf { role, ranges } in &self.role {
            let names = importance.roles.iter().map(|r| r.name.as_str());
            let at = articula::choose("role", role, names).context("--role")?;
            importance.role_of.resize(count, None);
            for (first, last) in ranges {
                let Some(of) = importance.role_of.get_mut(*first..=*last) else {
                    let what = format!("--role {role}: there is no character {last}");
                    let mend = format!("they are counted from 0 to {}", count.max(1) - 1);
                    return Err(fault::usage(format!("{what}; {mend}")));
                };
                of.fill(Some(at as u16));
            }
        }
        for ClipImportance {
            clip,
            importance: i,
        } in &self.clip_importance
        {
            let names = clips.iter();
            let names = names.map(|clips| clips.iter().map(|c| c.name.as_str()).collect());
            let names: Vec<Vec<&str>> = names.collect();
            if !importance.mark_clips(&names, clip, *i) {
                let all = names.iter().flatten().copied();
                articula::choose("clip", clip, all).context("--clip-importance")?;
            }
        }
        Ok(())
    }
}

fn of_role(text: &str) -> Result<RoleOf, String> {
    let (role, numbers) = text.split_once('=').ok_or("give ROLE=N,N-N,…")?;
    let number = |n: &str| usize::from_str(n.trim()).map_err(|_| format!("{n}: not a number"));
    let range = |text: &str| match text.split_once('-') {
        Some((first, last)) => match (number(first)?, number(last)?) {
            (first, last) if first <= last => Ok((first, last)),
            _ => Err(format!("{text}: the first number is above the last")),
        },
        None => number(text).map(|n| (n, n)),
    };
    Ok(RoleOf {
        role: role.to_owned(),
        ranges: numbers.split(',').map(range).collect::<Result<_, _>>()?,
    })
}

fn of_clip(text: &str) -> Result<ClipImportance, String> {
    let (clip, importance) = text.rsplit_once('=').ok_or("give CLIP=IMPORTANCE")?;
    let importance = f32::from_str(importance).map_err(|_| "the importance is no number")?;
    if !IMPORTANCE_RANGE.contains(&importance) {
        return Err("give an importance from 1/64 to 64".to_owned());
    }
    Ok(ClipImportance {
        clip: clip.to_owned(),
        importance,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_ranges_of_a_role() {
        let found = of_role("main=3,10-12, 20").unwrap();
        assert_eq!(found.role, "main");
        assert_eq!(found.ranges, [(3, 3), (10, 12), (20, 20)]);
        for bad in [
            "main",
            "main=",
            "main=a",
            "main=5-3",
            "main=-1",
            "main=1-2-3",
        ] {
            assert!(of_role(bad).is_err(), "{bad}");
        }
        let found = of_clip("a=b=2").unwrap();
        assert_eq!((found.clip.as_str(), found.importance), ("a=b", 2.0));
        for bad in ["wave", "wave=", "wave=0", "wave=NaN", "wave=100"] {
            assert!(of_clip(bad).is_err(), "{bad}");
        }
    }
}
