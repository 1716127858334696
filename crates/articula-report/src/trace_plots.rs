//! Playbacks of an item over a trace of bandwidth as line plots.

use crate::plot::{Plot, PlotOptions, Scale, Series, line_plot, stacked};
use articula::item::{TracePlayback, TracePolicy, TraceSample};

/// The least error that a logarithmic axis shows, pixels; smaller ones lie on its lower end.
const LEAST_PX: f64 = 0.01;

/// Returns error, level of quality, bytes and bandwidth over time below each other as one SVG, with a line
/// for each playback.
pub fn trace_plot(title: &str, playbacks: &[TracePlayback]) -> String {
    let levels = playbacks.iter().map(|p| p.levels).max().unwrap_or(0);
    let options = |title: String, y: &str, y_scale| PlotOptions {
        title,
        x_label: "time (s)".into(),
        y_label: y.into(),
        y_scale,
        ..PlotOptions::default()
    };
    let lines = |of: &dyn Fn(&TraceSample) -> f64| -> Vec<Series> {
        let line = |playback: &TracePlayback| Series {
            name: playback.policy.name().into(),
            points: playback.samples.iter().map(|s| (s.secs, of(s))).collect(),
            // Where lines lie on each other, all are seen.
            dashed: playback.policy != TracePolicy::Joint,
        };
        playbacks.iter().map(line).collect()
    };
    let plot = |name, options: &PlotOptions, lines: &[Series]| Plot {
        name,
        svg: line_plot(options, lines),
    };
    let error = |s: &TraceSample| s.error_px.map_or(f64::NAN, |px| px.max(LEAST_PX));
    let level = |s: &TraceSample| if s.is_playing { s.level as f64 } else { 0.0 };
    let bandwidth = Series {
        points: playbacks
            .first()
            .map(|p| p.samples.iter().map(|s| (s.secs, s.bandwidth_bps / 1e3)))
            .into_iter()
            .flatten()
            .collect(),
        ..Series::default()
    };
    stacked(&[
        plot(
            "error.svg",
            &options(
                format!("{title}: error of what is shown"),
                "error (px), 0.01 or less at the foot",
                Scale::Logarithmic,
            ),
            &lines(&error),
        ),
        plot(
            "level.svg",
            &options(
                format!("Level of quality, {levels} is all; 0: nothing yet, or it waits"),
                "level",
                Scale::Linear,
            ),
            &lines(&level),
        ),
        plot(
            "bytes.svg",
            &options("Bytes received".into(), "kB", Scale::Linear),
            &lines(&|s| s.bytes as f64 / 1e3),
        ),
        plot(
            "bandwidth.svg",
            &options("Bandwidth".into(), "kbit/s", Scale::Linear),
            &[bandwidth],
        ),
    ])
}
