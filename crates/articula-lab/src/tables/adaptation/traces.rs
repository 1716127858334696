//! Items played over traces of bandwidth, by the joint choice and by others.

use super::cases::Packaged;
use crate::tables::Run;
use anyhow::Result;
use articula::item::{TraceOptions, TracePlayback, TracePlayer, TracePolicy};
use articula_report::trace_plot;
use articula_stream::decide::BandwidthTrace;
use articula_stream::description::Context;
use std::fmt::Write as _;

/// The items that are played: many motions, and large textures.
const ITEMS: [&str; 3] = ["KayKit Knight", "RobotExpressive", "CesiumMan"];
/// Distance in metres.
const DISTANCE_M: f64 = 3.0;
/// Seconds that are played.
const SECS: f64 = 60.0;
/// Trace whose plot is on the page.
const PLOTTED: &str = "nothing for 8 s";

/// Traces that do not carry an item at once.
fn traces() -> [(&'static str, BandwidthTrace); 5] {
    [
        ("step up", BandwidthTrace::step(32e3, 128e3, 15.0)),
        ("step down", BandwidthTrace::step(128e3, 24e3, 4.0)),
        (
            "square wave",
            BandwidthTrace::square(96e3, 16e3, 10.0, SECS),
        ),
        (PLOTTED, BandwidthTrace::drop_to_zero(96e3, 5.0, 13.0)),
        ("noise", BandwidthTrace::noisy(3, 48e3, SECS)),
    ]
}

/// What all playbacks found.
#[derive(Debug, Default)]
pub(super) struct Traces {
    /// Playbacks in which the joint choice stalls more often, or for longer, than the thesis' decision.
    pub(super) stalling: usize,
    /// Playbacks in which its error is not lower.
    pub(super) not_lower: usize,
}

pub(super) fn write(run: &Run, items: &[Packaged], page: &mut String) -> Result<Traces> {
    page.push_str(TRACES);
    let mut found = Traces::default();
    let mut csv = String::from(
        "item,trace,policy,start_secs,stalls,stall_secs,mean_error_px,p95_error_px,bytes\n",
    );
    let mut plots = Vec::new();
    for packaged in items.iter().filter(|p| ITEMS.contains(&p.case.name)) {
        let name = packaged.case.name;
        let mut context = Context::default();
        context.view.distance_m = Some(DISTANCE_M);
        // Every error counts.
        context.preferences.tolerance_px = Some(0.0);
        let options = TraceOptions {
            secs: if run.small { 15.0 } else { SECS },
            ..TraceOptions::default()
        };
        let mut player = TracePlayer::new(&packaged.item, &context, &options)?;
        for (trace_name, trace) in traces() {
            let all = TracePolicy::ALL.into_iter();
            let playbacks: Vec<TracePlayback> = all
                .map(|policy| player.play(&trace, policy))
                .collect::<Result<_, _>>()?;
            compare(&playbacks, &mut found);
            row((name, trace_name), &playbacks, page, &mut csv)?;
            if trace_name == PLOTTED {
                let slug = name.to_lowercase().replace(' ', "-");
                let file = format!("adaptation-trace-{slug}");
                let title = format!("{name}, {trace_name}");
                run.save_text(&file, "svg", &trace_plot(&title, &playbacks))?;
                plots.push(format!("![{title}]({file}.svg)"));
            }
        }
    }
    write!(page, "\nPlots:\n\n{}\n", plots.join("\n"))?;
    run.save_text("adaptation-traces", "csv", &csv)?;
    Ok(found)
}

fn compare(playbacks: &[TracePlayback], found: &mut Traces) {
    let of = |policy| playbacks.iter().find(|p| p.policy == policy);
    let (Some(ours), Some(thesis)) = (of(TracePolicy::Joint), of(TracePolicy::Thesis)) else {
        return;
    };
    let stalls_more = ours.stalls > thesis.stalls || ours.stall_secs > thesis.stall_secs;
    found.stalling += usize::from(stalls_more);
    let both = [ours.clone(), thesis.clone()];
    let from = TracePlayback::all_shown_secs(&both);
    let mean = |p: &TracePlayback| p.errors_from(from).map(|errors| errors[0]);
    let is_lower = match [mean(ours), mean(thesis)] {
        [Some(ours), Some(thesis)] => ours < thesis,
        _ => false,
    };
    found.not_lower += usize::from(!is_lower);
}

fn row(
    (item, trace): (&str, &str),
    playbacks: &[TracePlayback],
    page: &mut String,
    csv: &mut String,
) -> Result<()> {
    let from = TracePlayback::all_shown_secs(playbacks);
    let mut cells = Vec::new();
    for playback in playbacks {
        let [mean, p95] = playback.errors_from(from).unwrap_or([f64::NAN; 2]);
        let start = playback.startup_secs.unwrap_or(f64::NAN);
        let (stalls, secs) = (playback.stalls, playback.stall_secs);
        let stalled = match stalls {
            0 => String::new(),
            _ => format!(" ({stalls}: {secs:.1} s)"),
        };
        cells.push(format!("{start:.1} s: {mean:.2}, {p95:.2}{stalled}"));
        writeln!(
            csv,
            "{item},{trace},{},{start:.3},{stalls},{secs:.3},{mean:.4},{p95:.4},{}",
            playback.policy.name(),
            playback.bytes
        )?;
    }
    writeln!(page, "| {item} | {trace} | {} |", cells.join(" | "))?;
    Ok(())
}

const TRACES: &str = "
## Played over traces of bandwidth

A minute of each item at 3 m, its motions for 8 s each, over five traces; [method](../methods/adaptation.md#6-an-item-over-a-trace). In
each cell: seconds to the first picture, then the mean error of what the receivers show and the one that is not exceeded in 95 % of
the time, in px, from the moment on at which all four show something; in brackets number and length of stalls. Errors are measured
on the posed skin, those of textures as packaged. Step up: 32 to 128 kbit/s at 15 s; step down: 128 to 24 at 4 s; square wave: 96 and
16, each for 5 s; nothing from 5 to 13 s, else 96; noise around 48. The thesis' decision is told the bandwidth. The CSV file
`adaptation-traces.csv` has the bytes too.

| item | trace | joint choice | ratio of the thesis | levels by rate | levels by buffer |
| --- | --- | --- | --- | --- | --- |
";
