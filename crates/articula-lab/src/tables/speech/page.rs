//! The page: each set of voices, what each system shows of them, and the targets.

use super::super::Run;
use super::super::targets::{self, Target};
use super::Judged;
use super::corpus::{self, Synthesiser, missing, spoken};
use super::recordings::{self, Set};
use super::score::Score;
use super::systems::{self, System};
use anyhow::{Context, Result};
use articula_speech::training::Network;
use std::fmt::Write as _;

/// Seed of the sentences that are judged: no seed of a training is as large.
const JUDGED_SEED: u64 = 1 << 20;
/// Sentences of each synthetic set.
const JUDGED: usize = 80;
/// The same in a quick run.
const JUDGED_SMALL: usize = 4;

/// The synthetic sets: none of their sentences was in a training.
const SETS: [(&str, Synthesiser); 4] = [
    ("espeak-ng, voices of the training", corpus::NEW_TEXT),
    ("espeak-ng, other voices", corpus::NEW_VOICES),
    ("espeak-ng, five other languages", corpus::NEW_LANGUAGES),
    ("flite, another voice (slt)", corpus::NEW_FLITE),
];

/// Writes the page.
pub(super) fn write(run: &Run, options: &Judged) -> Result<()> {
    let lacking = missing();
    let count = if run.small { JUDGED_SMALL } else { JUDGED };
    let mut sets = match lacking {
        None => synthetic(count)?,
        Some(_) => Vec::new(),
    };
    sets.extend(recordings::of_people(options.people.as_deref())?);
    let mut systems = systems::own(network(options)?);
    if !run.small {
        let profile = match lacking {
            None => spoken(corpus::FLITE_TRAINING, count, JUDGED_SEED)?,
            Some(_) => Vec::new(),
        };
        systems.extend(systems::peers(&profile)?);
    }
    let mut page = HEAD.to_owned();
    if let Some(what) = &lacking {
        writeln!(page, "\nWithout {what}: no synthetic voices.")?;
    }
    let mut csv = format!("set,system,{}\n", COLUMNS.map(|(_, name)| name).join(","));
    let mut found = Vec::new();
    for set in &sets {
        section(&mut page, set)?;
        for system in &systems {
            let score = system.score(set)?;
            row(&mut page, &mut csv, set, system, &score)?;
            found.push((set.name, system.name, score));
        }
    }
    page += &targets::section(ABOUT_TARGETS, &["voices", "quantity"], &targets(&found));
    run.save("speech", &page, &csv)
}

fn network(options: &Judged) -> Result<Network> {
    let Some(path) = &options.weights else {
        return Ok(Network::stored());
    };
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    let read = Network::read(&bytes);
    read.with_context(|| format!("{}: no file of weights", path.display()))
}

fn synthetic(count: usize) -> Result<Vec<Set>> {
    let sets = SETS.into_iter().zip(JUDGED_SEED..);
    let set = |((name, by), seed)| Ok(Set::of_clips(name, spoken(by, count, seed)?));
    sets.map(set).collect()
}

const HEAD: &str = "\
# Speech

Made by `cargo run --release -p articula-lab -- speech` with python3 and the library of espeak-ng, flite, and the peers of
`oracle/peers` (`npm ci` there). [Method and limits](../methods/speech.md).

Every system gets the same samples and gives a hundred times a second the weights of 15 visemes; they are compared with the
phones that were spoken. Of synthetic voices the times of phones are exact; of people pocketsphinx found them, given the text.

- *frames right*: frames of speech whose strongest viseme is the wanted one; *without lag*: the same if the track came as much
  earlier as it lags; *groups*: one of the same of seven groups that one sees apart (silence, lips that touch, lip and teeth,
  tongue, open, spread, round).
- *opening*: correlation of how far the mouth is open with what is wanted, at the best lag of each recording (mean), and the
  median of these lags.
- *p b m*: share at which lips meet; *closed vowels*: share of vowels of 60 ms and more that are closed in their middle half;
  *f v*: share at which teeth touch the lip.

Systems: **sound**, the recogniser of this library; **phones**, its rules for phones whose times are known (they need no
sound); **loudness**, a jaw that opens by the level, which many programs have; **headaudio**
(@met4citizen/headaudio 0.1.0, its own node, processor and model; the node does not show class 0, `aa`); **wlipsync** 1.3.1, its
WebAssembly called as its node does. wLipSync has no profile of its own: it gets one of 14 classes made from flite's voices of
the training.
";

const COLUMNS: [(&str, &str); 8] = [
    ("frames right", "right"),
    ("without lag", "right_without_lag"),
    ("groups", "groups"),
    ("opening", "opening_r"),
    ("lag, ms", "lag_ms"),
    ("p b m", "lips"),
    ("closed vowels", "closed_vowels"),
    ("f v", "teeth"),
];

fn section(page: &mut String, set: &Set) -> Result<()> {
    let heads = COLUMNS.map(|(head, _)| head).join(" | ");
    let secs = set.seconds();
    writeln!(page, "\n## {}\n\n{secs:.0} s.\n\n| | {heads} |", set.name)?;
    writeln!(page, "|{}", " --- |".repeat(COLUMNS.len() + 1))?;
    Ok(())
}

fn row(
    page: &mut String,
    csv: &mut String,
    set: &Set,
    system: &System,
    score: &Score,
) -> Result<()> {
    let (opening, lag) = score.opening();
    let frames = [
        score.right(),
        score.right_without_lag(),
        score.right_group(),
    ];
    let contacts = [score.lips(), score.closed_vowels(), score.teeth()];
    let percent = |share: f32| format!("{:.0} %", 100.0 * share);
    let exact = |share: f32| format!("{share:.4}");
    writeln!(
        page,
        "| {} | {} | {opening:.2} | {lag:.0} | {} |",
        system.name,
        frames.map(percent).join(" | "),
        contacts.map(percent).join(" | ")
    )?;
    writeln!(
        csv,
        "\"{}\",{},{},{opening:.4},{lag:.0},{}",
        set.name,
        system.name,
        frames.map(exact).join(","),
        contacts.map(exact).join(",")
    )?;
    Ok(())
}

const ABOUT_TARGETS: &str = "Of **sound**, in percent but for correlations; those of people on the recordings of the repository, \
which are 19 seconds of one reader.";

fn targets(found: &[(&str, &str, Score)]) -> Vec<Target> {
    let of = |set: &str, system: &str| {
        let row = found.iter().find(|(s, y, _)| *s == set && *y == system);
        row.map(|(.., score)| score)
    };
    let mut targets = Vec::new();
    let percent = |share: f32| f64::from(100.0 * share);
    let people = of(recordings::PEOPLE, systems::SOUND);
    if let Some(score) = people {
        let name = "people";
        let (opening, lag) = score.opening();
        targets.extend([
            Target::at_least([name, "frames right"], 55.0, percent(score.right())),
            Target::at_least([name, "groups"], 62.0, percent(score.right_group())),
            Target::at_least([name, "opening"], 0.75, f64::from(opening)),
            Target::at_most([name, "lag, ms"], 20.0, f64::from(lag.abs())),
            Target::at_least([name, "p b m"], 85.0, percent(score.lips())),
            Target::at_most([name, "closed vowels"], 5.0, percent(score.closed_vowels())),
            Target::at_least([name, "f v"], 60.0, percent(score.teeth())),
        ]);
        for changed in [recordings::SOFT, recordings::NOISY] {
            if let Some(score) = of(changed, systems::SOUND) {
                let lost = percent(people.map_or(0.0, Score::right)) - percent(score.right());
                targets.push(Target::at_most([changed, "frames right, lost"], 6.0, lost));
            }
        }
    }
    if let Some(score) = of(SETS[1].0, systems::SOUND) {
        targets.push(Target::at_least(
            [SETS[1].0, "frames right"],
            75.0,
            percent(score.right()),
        ));
    }
    if let Some(score) = of(SETS[3].0, systems::SOUND) {
        targets.push(Target::at_least(
            [SETS[3].0, "frames right"],
            50.0,
            percent(score.right()),
        ));
        targets.push(Target::at_least(
            [SETS[3].0, "p b m"],
            75.0,
            percent(score.lips()),
        ));
    }
    targets
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_people(system: &str) -> Score {
        let systems = systems::own(Network::stored());
        let system = systems.iter().find(|s| s.name == system).unwrap();
        system
            .score(&recordings::of_people(None).unwrap()[0])
            .unwrap()
    }

    #[test]
    fn the_stored_weights_hear_people_as_well_as_is_asked() {
        let found =
            [("people", systems::SOUND)].map(|(_, s)| (recordings::PEOPLE, s, of_people(s)));
        let targets = targets(&found);
        assert!(targets.len() >= 7);
        for target in targets {
            assert!(target.holds(), "{target:?}");
        }
    }

    #[test]
    fn phones_that_are_known_are_made() {
        let score = of_people("phones");
        assert_eq!([score.lips(), score.teeth()], [1.0, 1.0]);
    }
}
