//! Cost of forward, backward, random and skipping access to a clip.

use super::frame_order::Access;
use super::ours::{Batched, plain};
use super::{Bench, CrowdTables, Line, evaluation};
use crate::measure::{Contestant, race};
use anyhow::Result;
use articula_core::{ClipSet, ClipStorage, JointLods, PaletteForm, PaletteMap};

/// Adds the section.
pub(super) fn add(bench: &Bench, report: &mut CrowdTables) -> Result<()> {
    let (count, frames) = bench.usual();
    let rig = &bench.asset.rig;
    let joint_lods = JointLods::whole(rig)?;
    let map = PaletteMap::joints(&joint_lods);
    let clips = ClipSet::new(rig, joint_lods, &bench.asset.clips, ClipStorage::Float)?;
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
        "Access patterns",
        "Each time divided by the forward time of the same evaluator. Backward and forward step \
         1/60 s, skipping half a second, random any time of the clip.",
    );
    report.head(&["evaluator", "forward, ns", "backward", "skipping", "random"]);
    for (who, contestant) in contestants.iter().enumerate() {
        let forward = timings[0][who].median_ns;
        let mut cells = vec![contestant.name.clone(), format!("{forward:.0}")];
        for (access, timings) in Access::ALL.iter().zip(&timings) {
            if *access != Access::Forward {
                let ratio = timings[who].median_ns / forward;
                cells.push(format!("{ratio:.2}"));
                if contestant.name.starts_with("ours") {
                    let what = format!("{} access / forward", access.name());
                    report.at_most(&contestant.name, &what, 1.15, ratio);
                }
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
