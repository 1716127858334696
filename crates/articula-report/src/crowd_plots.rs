//! Time and error of a measured scene as line plots.

use crate::plot::{Plot, PlotOptions, Series, line_plot};
use articula::crowd::{ErrorSummary, SceneMeasurement};

/// Plots of frame time and error over the time of a scene.
pub fn crowd_plots(measured: &SceneMeasurement) -> Vec<Plot> {
    let options = |title: &str, y: &str, target| PlotOptions {
        title: title.into(),
        x_label: "time (s)".into(),
        y_label: y.into(),
        target,
        ..PlotOptions::default()
    };
    let target = measured.budget_ms;
    let target = target.map(|ms| (f64::from(ms), format!("budget {ms} ms")));
    let time = Series {
        points: measured.over_time.clone(),
        ..Series::default()
    };
    let line = |name: &str, of: &dyn Fn(&ErrorSummary) -> f64| Series {
        name: name.into(),
        points: measured
            .samples
            .iter()
            .map(|l| {
                let one = std::slice::from_ref(l);
                (l.secs, of(&ErrorSummary::of(one)))
            })
            .collect(),
        dashed: name != "p95 of visible characters",
    };
    let errors = [
        line("p95 of visible characters", &|s| s.p95),
        line("max", &|s| s.max),
        line("max within 20 m", &|s| s.near_max),
    ];
    vec![
        Plot {
            name: "frame-time.svg",
            svg: line_plot(
                &options("Processor time of a frame", "time (ms)", target),
                &[time],
            ),
        },
        Plot {
            name: "crowd-error.svg",
            svg: line_plot(&options("Error of the crowd", "error (px)", None), &errors),
        },
    ]
}
