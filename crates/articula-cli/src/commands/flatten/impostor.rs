//! `articula flatten --profile impostor`: small pictures of every pose, and their table.

use super::arguments::ConvertArgs;
use crate::console::Console;
use crate::{files, open};
use articula::flat::impostor::{ImpostorBound, ImpostorOptions, ImpostorPlan, ImpostorTrial};
use articula::impostor::bake;
use serde::Serialize;
use std::fmt::Write as _;

#[derive(Debug, Serialize)]
struct ImpostorReport {
    out: String,
    table: String,
    profile: &'static str,
    /// Bytes of the pixels, four each.
    bytes: usize,
    /// Bytes of the two files.
    file_bytes: usize,
    size_px: (u32, u32),
    picture_px: [u32; 2],
    views: usize,
    poses: usize,
    clips: Vec<ClipReport>,
    /// What other numbers of bytes would bring.
    trials: Vec<TrialReport>,
}

#[derive(Debug, Serialize)]
struct ClipReport {
    name: String,
    poses: usize,
    error_m: f32,
}

#[derive(Debug, Serialize)]
struct TrialReport {
    error_m: f32,
    bytes: usize,
    views: usize,
    poses: usize,
    picture_px: [u32; 2],
}

/// Bakes the pictures, writes them and the table, and reports the errors.
pub(super) fn run(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    let table = args.out().with_extension("json");
    let outputs = [args.out(), table.as_path()];
    console.files.plan(args.inputs(), outputs)?;
    let figure = open::figure(&console.files, &args.character())?;
    let clip = match &args.motion.clip {
        Some(name) => figure.clip(Some(name))?,
        None => None,
    };
    let mut options = ImpostorOptions::default();
    if let Some(bytes) = args.quality.max_bytes {
        options.bound = ImpostorBound::Bytes(usize::try_from(bytes).unwrap_or(usize::MAX));
    }
    let clips: Vec<usize> = clip.into_iter().collect();
    let baked = console.work(|work| bake(&figure, &clips, &options, work))?;
    let png = baked.atlas.to_png()?;
    let name = args.out().file_name().unwrap_or_default();
    let json = baked.plan.to_json(&name.to_string_lossy()).into_bytes();
    let report = ImpostorReport {
        out: files::shown(args.out()),
        table: files::shown(&table),
        file_bytes: png.len() + json.len(),
        size_px: (baked.atlas.width(), baked.atlas.height()),
        ..ImpostorReport::of(&baked.plan)
    };
    console
        .files
        .write_all(&[(args.out(), &png), (table.as_path(), &json)])?;
    console.result(&report, ImpostorReport::text)
}

impl ImpostorReport {
    fn of(plan: &ImpostorPlan) -> Self {
        let trial = |t: &ImpostorTrial| TrialReport {
            error_m: t.error_m,
            bytes: t.bytes,
            views: t.views,
            poses: t.poses,
            picture_px: t.size_px,
        };
        Self {
            out: String::new(),
            table: String::new(),
            profile: "impostor",
            bytes: plan.bytes(),
            file_bytes: 0,
            size_px: (0, 0),
            picture_px: plan.cell.size_px,
            views: plan.views.len(),
            poses: plan.poses(),
            clips: plan
                .clips
                .iter()
                .map(|clip| ClipReport {
                    name: clip.name.clone(),
                    poses: clip.pose_secs.len(),
                    error_m: clip.error_m,
                })
                .collect(),
            trials: plan.trials.iter().map(trial).collect(),
        }
    }

    fn text(&self) -> String {
        let [width, height] = self.picture_px;
        let mut text = format!(
            "{}: impostor, {} pictures of {width} x {height} px: {} poses from {} directions\n\
             {:.1} kB of pixels, {:.1} kB in 2 files; table {}\n",
            self.out,
            self.poses * self.views,
            self.poses,
            self.views,
            self.bytes as f64 / 1e3,
            self.file_bytes as f64 / 1e3,
            self.table,
        );
        for clip in &self.clips {
            let name = if clip.name.is_empty() {
                "rest pose"
            } else {
                &clip.name
            };
            let _ = writeln!(
                text,
                "{name}: {} poses, error {:.1} cm",
                clip.poses,
                1e2 * clip.error_m
            );
        }
        text
    }
}
