//! Cost by joints kept: whether a level of articulation saves time in proportion to joints.

use super::frame_order::Access;
use super::ours::Batched;
use super::{Bench, CrowdTables, Line, evaluation};
use crate::measure::race;
use crate::tables::targets::Target;
use anyhow::Result;
use articula_build::{JointLodOptions, joint_lods, mean_pose};
use articula_core::{ClipSet, ClipStorage, JointLods, PaletteForm, PaletteMap};
use articula_report::{PlotOptions, Series, ValueFormat, line_plot};

/// Joints kept by the coarser levels, as in the published row.
const KEPT: [u16; 5] = [48, 32, 24, 16, 8];

/// Adds the section.
pub(super) fn add(bench: &Bench, report: &mut CrowdTables) -> Result<()> {
    let (count, frames) = bench.usual();
    let clips = clip_set(bench)?;
    let map = PaletteMap::joints(clips.joint_lods());
    let levels = clips.joint_lods().levels();
    let mut contestants = vec![evaluation::floor_stored(bench, count)?];
    for level in 0..levels {
        let ours = Batched {
            clips: &clips,
            map: &map,
            clip: 0,
            level,
        };
        contestants.push(ours.stored("ours, 3x4 f32", PaletteForm::Matrix, count)?);
        contestants.push(ours.tiles("ours, in tiles")?);
    }
    let times = Access::Forward.frames(bench, count, frames);
    let timings = race(&mut contestants, &times, bench.rounds());
    report.heading(
        "Cost by joints kept",
        &format!(
            "{count} characters, joints merged in the order computed from the clips. Gain: fraction of \
             time saved over fraction of joints saved; 1 where time is proportional to joints. Joints \
             that no clip moves, nor any joint below them, take less time than others and are left out \
             first, so that the first levels save less time than joints."
        ),
    );
    report.head(&["joints", "3x4 f32, ns", "gain", "in tiles, ns", "gain"]);
    let mut shares = [Vec::new(), Vec::new()];
    for level in 0..levels {
        let kept = clips.joint_lods().joint_count(level);
        let joints = kept as f64 / clips.joint_lods().joints().len() as f64;
        let mut cells = vec![kept.to_string()];
        for form in 0..2 {
            let (full, timing) = (timings[1 + form], timings[1 + 2 * level + form]);
            let time = timing.median_ns / full.median_ns;
            let gain = (1.0 - time) / (1.0 - joints);
            cells.push(format!("{:.0} ({:.0})", timing.median_ns, timing.least_ns));
            cells.push(if level == 0 {
                "–".to_owned()
            } else {
                let who = format!("{}, {kept} joints", contestants[1 + form].name);
                let what = "time saved / joints saved";
                let target = Target::at_least([&who, what], 0.85, gain);
                report.targets.push(target);
                format!("{gain:.2}")
            });
            shares[form].push((joints, time));
            report.line(&Line {
                section: "joints",
                who: &contestants[1 + form].name,
                count,
                variant: &kept.to_string(),
                timing,
                floor_ns: timings[0].median_ns,
            });
        }
        report.row(&cells);
    }
    report.plots.push(("crowd-joints", plot(shares)));
    Ok(())
}

/// The clip with joint LODs of the published numbers of joints.
fn clip_set(bench: &Bench) -> Result<ClipSet> {
    let asset = &bench.asset;
    let mean = mean_pose(asset);
    let order = joint_lods(asset, &mean, &JointLodOptions::default())?;
    let mut kept = vec![asset.rig.len() as u16];
    kept.extend(KEPT.iter().filter(|k| usize::from(**k) < asset.rig.len()));
    let joint_lods = JointLods::new(&asset.rig, order.joints().to_vec(), kept, &mean)?;
    let clip = std::slice::from_ref(bench.clip());
    Ok(ClipSet::new(
        &asset.rig,
        joint_lods,
        clip,
        ClipStorage::Float,
    )?)
}

fn plot([stored, tiles]: [Vec<(f64, f64)>; 2]) -> String {
    let options = PlotOptions {
        title: "Time by joints kept".to_owned(),
        x_label: "share of joints".to_owned(),
        y_label: "share of time".to_owned(),
        y: ValueFormat::Percent,
        ..PlotOptions::default()
    };
    let series = |name: &str, points, dashed| Series {
        name: name.to_owned(),
        points,
        dashed,
    };
    let equal = vec![(0.1, 0.1), (1.0, 1.0)];
    line_plot(
        &options,
        &[
            series("ours, 3x4 f32", stored, false),
            series("ours, in tiles", tiles, false),
            series("as joints fall", equal, true),
        ],
    )
}
