//! Gain, error and cost as curves and bars (SVG).
//!
//! Source: thesis figures 6.14 and 6.15; `spec/motion-lod.md` 12.

use super::costs::{Cost, Costs};
use super::rows::{Row, Table};
use super::{Scene, methods::Chosen};
use articula_build::evaluate::play;
use articula_report::{BarSeries, Plot, PlotOptions, Scale, Series, Values, bar_plot, line_plot};

/// Joint updates saved over distance.
pub(crate) fn gain(tables: &[Table], heading: &str) -> Plot {
    let title = format!("Joint updates saved, {heading}");
    let options = PlotOptions {
        title,
        x_label: "distance (m)".into(),
        y_label: "joint updates saved".into(),
        x: Scale::Logarithmic,
        y: Values::Percent,
        target: None,
    };
    Plot {
        name: "gain.svg",
        svg: line_plot(&options, &series(tables, |r| r.joint_update_gain)),
    }
}

/// p95 error over distance; `limit_px` is drawn as a line.
pub(crate) fn error(tables: &[Table], heading: &str, limit_px: Option<f32>) -> Plot {
    let title = format!("Error in pixels (p95), {heading}");
    let options = PlotOptions {
        title,
        x_label: "distance (m)".into(),
        y_label: "p95 error (px)".into(),
        x: Scale::Logarithmic,
        y: Values::Plain,
        target: limit_px.map(|l| (f64::from(l), format!("target {l} px"))),
    };
    Plot {
        name: "error.svg",
        svg: line_plot(&options, &series(tables, |r| r.error_px.p95)),
    }
}

fn series(tables: &[Table], value: impl Fn(&Row) -> f32) -> Vec<Series> {
    let line = |table: &Table| Series {
        name: table.chosen.label(),
        points: table
            .rows
            .iter()
            .map(|r| (f64::from(r.distance_m), f64::from(value(r))))
            .collect(),
        // Ours are drawn through, the baselines dashed.
        dashed: table.chosen.method.name() != "skin-px",
    };
    tables.iter().map(line).collect()
}

/// Joints sampled and matrices changed by zone, depth and level of complexity.
pub(crate) fn costs(costs: &Costs, heading: &str) -> Vec<Plot> {
    let plot = |name, by: &str, x: &str, costs: &[Cost]| {
        let title = format!("Cost by {by}, {heading}");
        let options = PlotOptions {
            title,
            x_label: x.into(),
            y_label: "joints a frame".into(),
            ..PlotOptions::default()
        };
        let names: Vec<String> = costs.iter().map(|c| c.name.clone()).collect();
        let bars = |name: &str, of: &dyn Fn(&Cost) -> f32| BarSeries {
            name: name.into(),
            values: costs.iter().map(|c| f64::from(of(c))).collect(),
        };
        let series = [
            bars("in the set", &|c| c.joints as f32),
            bars("sampled", &|c| c.joints_sampled),
            bars("matrices changed", &|c| c.fk_joints),
        ];
        Plot {
            name,
            svg: bar_plot(&options, &names, &series),
        }
    };
    vec![
        plot("cost-by-zone.svg", "zone", "zone", &costs.zones),
        plot(
            "cost-by-depth.svg",
            "depth",
            "joints of smaller depth",
            &costs.depths,
        ),
        plot(
            "cost-by-complexity.svg",
            "level of complexity",
            "level",
            &costs.complexities,
        ),
    ]
}

/// Joints updated at each frame of the clip, for each method at its parameter at one distance.
pub(crate) fn over_the_clip(
    scene: &Scene<'_>,
    tables: &[Table],
    distance: usize,
    heading: &str,
) -> Plot {
    let stage = scene.stage();
    let rate = f64::from(stage.clip.rate_hz());
    let line = |chosen: &Chosen, row: &Row| {
        let playback = play(&stage, &chosen.method, row.parameter)
            .1
            .into_iter()
            .next();
        let updated = playback.map_or(Vec::new(), |p| p.updated);
        let point = |(frame, set): (usize, &articula_core::JointSet)| {
            (frame as f64 / rate, set.len() as f64)
        };
        Series {
            name: chosen.label(),
            // Nothing is updated at the first frame: every method starts from the truth.
            points: updated.iter().enumerate().skip(1).map(point).collect(),
            dashed: chosen.method.name() != "skin-px",
        }
    };
    let shown = tables
        .iter()
        .filter_map(|t| Some((&t.chosen, t.rows.get(distance)?)));
    let mut series: Vec<Series> = shown.map(|(c, r)| line(c, r)).collect();
    let last = (stage.clip.frames() - 1) as f64 / rate;
    let moving = stage.moving.len() as f64;
    series.push(Series {
        name: "every moving joint".into(),
        points: vec![(1.0 / rate, moving), (last.max(1.0 / rate), moving)],
        dashed: true,
    });
    let title = format!("Joints updated over the clip, {heading}");
    let options = PlotOptions {
        title,
        x_label: "time in the clip (s)".into(),
        y_label: "joints updated".into(),
        ..PlotOptions::default()
    };
    Plot {
        name: "over-the-clip.svg",
        svg: line_plot(&options, &series),
    }
}
