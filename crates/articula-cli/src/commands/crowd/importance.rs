//! Flags of `crowd` that say who matters and what hides whom.

use crate::fault;
use anyhow::Context;
use articula::build::Scene;
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

    /// Adds the roles to a scene.
    pub(super) fn apply(&self, scene: &mut Scene) -> anyhow::Result<()> {
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
    }
}
