//! `articula adapt ITEM/ --trace TRACE.csv`: plays an item over a recorded bandwidth.

use crate::arguments::{number, settings};
use crate::console::Console;
use crate::table::Table;
use crate::{fault, files};
use anyhow::Context as _;
use articula::item::{
    AdaptOptions, Item, TraceOptions, TracePlayback, TracePlayer, TracePolicy, TraceSample,
};
use articula::stream::decide::BandwidthTrace;
use articula::stream::description::Context;
use articula_report::trace_plot;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Most bytes of a trace.
const MOST_BYTES: u64 = 64 << 20;
/// Rows of the table of moments.
const ROWS: usize = 24;

/// Playing over a trace.
#[derive(Debug, Clone, Args)]
pub(crate) struct TraceArgs {
    /// Play the item over a recorded bandwidth, by the joint choice, by the ratio of the thesis and by two
    /// other policies: lines of seconds and bits per second. Reports bytes, stalls, layers and the error
    /// of what receivers show
    #[arg(
        long,
        value_name = "TRACE.csv",
        conflicts_with_all = ["out", "aqos", "bandwidth_kbps", "engine"]
    )]
    trace: Option<PathBuf>,
    /// How the trace is played: secs=N to play [default: 60], clip=N, least seconds of each motion [8],
    /// sample=N, seconds between samples of the error [0.25], latency-ms=N from a request to its first
    /// byte [50]
    #[arg(long, value_name = "KEY=N,…", value_parser = played, requires = "trace")]
    play: Option<TraceOptions>,
    /// Write a plot of error, level of quality, bytes and bandwidth over time
    #[arg(long, value_name = "F.svg", requires = "trace")]
    plot: Option<PathBuf>,
}

/// Parses how a trace is played.
fn played(text: &str) -> Result<TraceOptions, String> {
    let above_0 = |text: &str| number(text, |n| n > 0.0, "a number above 0");
    settings(text, |to: &mut TraceOptions, key, value| {
        match key {
            "secs" => to.secs = above_0(value)?,
            "clip" => to.clip_secs = above_0(value)?,
            "sample" => to.sample_secs = above_0(value)?,
            "latency-ms" => to.latency_secs = 1e-3 * above_0(value)?,
            _ => return Ok(Some("secs, clip, sample, latency-ms")),
        }
        Ok(None)
    })
}

/// What `adapt --trace` prints.
#[derive(Debug, Serialize)]
struct TraceReport {
    item: String,
    trace: String,
    /// Time that was played, seconds.
    secs: f64,
    /// Time from which on errors are compared: all show something.
    compared_from_secs: f64,
    playbacks: Vec<PlaybackReport>,
    /// Files that were written.
    written: Vec<String>,
}

/// A playback, with its errors from the common time on.
#[derive(Debug, Serialize)]
struct PlaybackReport {
    #[serde(flatten)]
    playback: TracePlayback,
    mean_error_px: Option<f64>,
    p95_error_px: Option<f64>,
}

impl PlaybackReport {
    fn new(playback: TracePlayback, from_secs: f64) -> Self {
        let errors = playback.errors_from(from_secs);
        Self {
            mean_error_px: errors.map(|errors| errors[0]),
            p95_error_px: errors.map(|errors| errors[1]),
            playback,
        }
    }
}

impl TraceArgs {
    /// The trace, if one is played.
    pub(super) fn file(&self) -> Option<&Path> {
        self.trace.as_deref()
    }

    /// The plot that is written.
    pub(super) fn output(&self) -> Option<&Path> {
        self.plot.as_deref()
    }

    pub(super) fn check(&self) -> anyhow::Result<()> {
        let Some(plot) = &self.plot else {
            return Ok(());
        };
        if plot
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("svg"))
        {
            return Ok(());
        }
        let path = files::shown(plot);
        let what = format!("--plot {path}: plots are SVG; name a .svg file");
        Err(fault::usage(what))
    }

    /// Plays an item, and reports.
    pub(super) fn run(
        &self,
        path: &Path,
        (item, item_name): (&Item, String),
        context: &Context,
        adapt: &AdaptOptions,
        console: &Console,
    ) -> anyhow::Result<()> {
        let bytes = files::read(path, MOST_BYTES)?;
        let text = String::from_utf8_lossy(&bytes);
        let trace = BandwidthTrace::read(&text).with_context(|| files::shown(path))?;
        let options = TraceOptions {
            adapt: *adapt,
            ..self.play.unwrap_or_default()
        };
        let mut player =
            TracePlayer::new(item, context, &options).with_context(|| item_name.clone())?;
        let playbacks: Vec<TracePlayback> = TracePolicy::ALL
            .into_iter()
            .map(|policy| player.play(&trace, policy))
            .collect::<Result<_, _>>()
            .with_context(|| item_name.clone())?;
        let mut written = Vec::new();
        if let Some(plot) = &self.plot {
            let svg = trace_plot(&item.manifest.name, &playbacks);
            console.files.write(plot, svg.as_bytes())?;
            written.push(files::shown(plot));
        }
        let from = TracePlayback::all_shown_secs(&playbacks);
        let playbacks = playbacks.into_iter();
        let report = TraceReport {
            item: item_name,
            trace: files::shown(path),
            secs: options.secs,
            compared_from_secs: from,
            playbacks: playbacks.map(|p| PlaybackReport::new(p, from)).collect(),
            written,
        };
        console.result(&report, TraceReport::text)
    }
}

fn shown(number: Option<f64>) -> String {
    number.map_or("-".to_owned(), |n| format!("{n:.2}"))
}

fn level<T: ToString>(level: Option<T>) -> String {
    level.map_or("-".to_owned(), |level| level.to_string())
}

impl TraceReport {
    fn text(&self) -> String {
        let mut text = format!("{} over {}, {} s\n\n", self.item, self.trace, self.secs);
        let mut table = Table::new(&[
            "decision",
            "start, s",
            "stalls",
            "stalled, s",
            "mean error, px",
            "p95, px",
            "bytes",
            "unused",
        ]);
        for report in &self.playbacks {
            let p = &report.playback;
            table.row([
                p.policy.name().to_owned(),
                shown(p.startup_secs),
                p.stalls.to_string(),
                format!("{:.2}", p.stall_secs),
                shown(report.mean_error_px),
                shown(report.p95_error_px),
                p.bytes.to_string(),
                p.unused_bytes.to_string(),
            ]);
        }
        text.push_str(&table.text());
        text.push_str(&format!(
            "\nErrors are those of what receivers show, from {:.2} s on, when all show something.\n",
            self.compared_from_secs
        ));
        for report in self.playbacks.iter().take(1) {
            let playback = &report.playback;
            text.push_str(&format!("\n{}, over time:\n\n", playback.policy.name()));
            text.push_str(&moments(playback).text());
        }
        for file in &self.written {
            text.push_str(&format!("\nwrote {file}\n"));
        }
        text
    }
}

/// Samples evenly from those that differ from the one before in what came or is shown, and the last one.
fn told(samples: &[TraceSample]) -> Vec<&TraceSample> {
    let what = |s: &TraceSample| (s.bytes, s.level, s.is_playing, s.bandwidth_bps.to_bits());
    let mut changes: Vec<&TraceSample> = Vec::new();
    for sample in samples {
        if changes.last().is_none_or(|last| what(last) != what(sample)) {
            changes.push(sample);
        }
    }
    let every = changes.len().div_ceil(ROWS).max(1);
    let mut told: Vec<&TraceSample> = changes.into_iter().step_by(every).collect();
    let last = samples
        .last()
        .filter(|last| told.last().is_some_and(|t| t.secs < last.secs));
    told.extend(last);
    told
}

/// A playback at some moments.
fn moments(playback: &TracePlayback) -> Table {
    let mut table = Table::new(&[
        "s",
        "kbit/s",
        "bytes",
        "buffer, s",
        "shows",
        "mesh",
        "texture",
        "loa",
        "tier",
        "error, px",
    ]);
    for sample in told(&playback.samples) {
        table.row([
            format!("{:.1}", sample.secs),
            format!("{:.0}", sample.bandwidth_bps / 1e3),
            sample.bytes.to_string(),
            format!("{:.1}", sample.buffer_secs),
            match (sample.is_playing, sample.error_px) {
                (true, _) => format!("{} of {}", sample.level, playback.levels),
                (false, None) => "nothing yet".to_owned(),
                (false, Some(_)) => "waits".to_owned(),
            },
            level(sample.mesh_level),
            level(sample.texture_px),
            level(sample.loa),
            level(sample.tier),
            shown(sample.error_px),
        ]);
    }
    table
}
