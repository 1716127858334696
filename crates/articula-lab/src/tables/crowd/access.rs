//! Forward, backward, random and skipping access: what each way through the clip costs.

use super::ours::{Batched, plain};
use super::{Bench, Line, Report, evaluation};
use crate::measure::{Contestant, race};
use anyhow::Result;
use articula_build::{Plaza, plaza};
use articula_core::{ClipSet, Ladder, PaletteForm, PaletteMap, Storage};

/// Ways through a clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Access {
    Forward,
    Backward,
    /// Half a second from frame to frame.
    Skipping,
    Random,
}

impl Access {
    const ALL: [Self; 4] = [Self::Forward, Self::Backward, Self::Skipping, Self::Random];

    fn name(self) -> &'static str {
        match self {
            Self::Forward => "forward",
            Self::Backward => "backward",
            Self::Skipping => "skipping",
            Self::Random => "random",
        }
    }

    /// Times within the clip of every character, frame by frame.
    pub(super) fn frames(self, bench: &Bench, count: usize, frames: usize) -> Vec<Vec<f32>> {
        let duration = bench.clip().duration_secs();
        let phases = bench.phases(count);
        let step = match self {
            Self::Forward => 1.0 / 60.0,
            Self::Backward => -1.0 / 60.0,
            Self::Skipping => 0.5,
            Self::Random => 0.0,
        };
        let frame = |f: usize| {
            let phases = match self {
                // Another seed at each frame: the phases of another crowd.
                Self::Random => {
                    let other = plaza(count, 1, f as u64 + 2, Plaza::Still);
                    other.members.iter().map(|m| m.play.phase).collect()
                }
                _ => phases.clone(),
            };
            let at = |phase: f32| (phase * duration + step * f as f32).rem_euclid(duration);
            phases.into_iter().map(at).collect()
        };
        (0..frames).map(frame).collect()
    }
}

/// Adds the section.
pub(super) fn add(bench: &Bench, report: &mut Report) -> Result<()> {
    let (count, frames) = bench.usual();
    let rig = &bench.asset.rig;
    let ladder = Ladder::whole(rig)?;
    let map = PaletteMap::joints(&ladder);
    let clips = ClipSet::new(rig, ladder, &bench.asset.clips, Storage::Float)?;
    let ours = Batched {
        clips: &clips,
        map: &map,
        clip: bench.clip,
        level: 0,
    };
    let mut contestants: Vec<Contestant<'_>> = vec![
        evaluation::floor_stored(bench, count)?,
        ours.stored("ours, 3x4 f32", PaletteForm::Matrix, count)?,
        plain(bench, count),
        evaluation::structs(bench, count)?,
    ];
    let timings: Vec<Vec<_>> = Access::ALL
        .iter()
        .map(|access| {
            race(
                &mut contestants,
                &access.frames(bench, count, frames),
                bench.rounds(),
            )
        })
        .collect();
    report.heading(
        "Ways through a clip",
        "Each time as a multiple of the same evaluator's forward one. Backward and forward step \
         1/60 s, skipping half a second, random anywhere.",
    );
    report.head(&["who", "forward, ns", "backward", "skipping", "random"]);
    for (who, contestant) in contestants.iter().enumerate() {
        let forward = timings[0][who].median_ns;
        let mut cells = vec![contestant.name.clone(), format!("{forward:.0}")];
        for (access, timings) in Access::ALL.iter().zip(&timings) {
            if *access != Access::Forward {
                cells.push(format!("{:.2}", timings[who].median_ns / forward));
            }
            report.line(&Line {
                section: "access",
                who: &contestant.name,
                count,
                variant: access.name(),
                timing: timings[who],
                floor_ns: timings[0].median_ns,
            });
        }
        report.row(&cells);
    }
    Ok(())
}
