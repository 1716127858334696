//! Updates saved, error and cost as line and bar plots (SVG).
//!
//! Source: thesis figures 6.14 and 6.15; `docs/methods/motion-lod.md` part 12.

use crate::motion_sheet::MotionLine;
use crate::plot::{BarSeries, Plot, PlotOptions, Scale, Series, ValueFormat, bar_plot, line_plot};
use articula::build::evaluate::{ClipEvaluator, PathFrame, PathRun, play};
use articula::core::JointSet;
use articula::evaluate::{Cost, Costs, MethodRow, MethodTable, ScheduleReport, ScheduleRow};

/// Plots the joint updates saved over distance, one line for each method.
pub fn gain_plot(tables: &[MethodTable], heading: &str) -> Plot {
    let options = PlotOptions {
        title: format!("Joint updates saved, {heading}"),
        x_label: "distance (m)".into(),
        y_label: "joint updates saved".into(),
        x: Scale::Logarithmic,
        y: ValueFormat::Percent,
        ..PlotOptions::default()
    };
    Plot {
        name: "gain.svg",
        svg: line_plot(&options, &series(tables, |r| r.joint_update_gain)),
    }
}

/// Plots the p95 error over distance, one line for each method; `limit_px` is drawn as a line.
pub fn error_plot(tables: &[MethodTable], heading: &str, limit_px: Option<f32>) -> Plot {
    let options = PlotOptions {
        title: format!("Error in pixels (p95), {heading}"),
        x_label: "distance (m)".into(),
        y_label: "p95 error (px)".into(),
        x: Scale::Logarithmic,
        y: ValueFormat::Plain,
        target: limit_px.map(|l| (f64::from(l), format!("target {l} px"))),
        ..PlotOptions::default()
    };
    Plot {
        name: "error.svg",
        svg: line_plot(&options, &series(tables, |r| r.error_px.p95)),
    }
}

/// A value of every row over distance; `skin-px` is drawn solid, the baselines dashed.
fn series(tables: &[MethodTable], value: impl Fn(&MethodRow) -> f32) -> Vec<Series> {
    let point = |r: &MethodRow| (f64::from(r.distance_m), f64::from(value(r)));
    let line = |table: &MethodTable| Series {
        name: table.method.label(),
        points: table.rows.iter().map(point).collect(),
        dashed: table.method.method.name() != "skin-px",
    };
    tables.iter().map(line).collect()
}

/// Plots the costs by zone, depth and level of complexity.
pub fn cost_plots(costs: &Costs, heading: &str) -> [Plot; 3] {
    [
        cost_plot(CostBy::Zone, &costs.zones, heading),
        cost_plot(CostBy::Depth, &costs.depths, heading),
        cost_plot(CostBy::Complexity, &costs.complexities, heading),
    ]
}

/// Property by which a cost plot groups joints.
#[derive(Clone, Copy)]
enum CostBy {
    Zone,
    Depth,
    Complexity,
}

/// Joints in each set, joints sampled and matrices changed per frame, side by side.
fn cost_plot(by: CostBy, costs: &[Cost], heading: &str) -> Plot {
    let (name, by, x) = match by {
        CostBy::Zone => ("cost-by-zone.svg", "zone", "zone"),
        CostBy::Depth => ("cost-by-depth.svg", "depth", "joints of smaller depth"),
        CostBy::Complexity => ("cost-by-complexity.svg", "level of complexity", "level"),
    };
    let options = PlotOptions {
        title: format!("Cost by {by}, {heading}"),
        x_label: x.into(),
        y_label: "joints per frame".into(),
        ..PlotOptions::default()
    };
    let names: Vec<String> = costs.iter().map(|c| c.name.clone()).collect();
    let bars = |name: &str, of: fn(&Cost) -> f32| BarSeries {
        name: name.into(),
        values: costs.iter().map(|c| f64::from(of(c))).collect(),
    };
    let series = [
        bars("in the set", |c| c.joints as f32),
        bars("sampled", |c| c.joints_sampled),
        bars("matrices changed", |c| c.fk_joints),
    ];
    Plot {
        name,
        svg: bar_plot(&options, &names, &series),
    }
}

/// Plots the joints updated at each frame of the clip, for each method at its parameter.
pub fn updates_plot(stage: &ClipEvaluator<'_>, lines: &[MotionLine<'_>], heading: &str) -> Plot {
    let rate = f64::from(stage.clip.rate_hz());
    let line = |line: &MotionLine<'_>| {
        let playback = play(stage, line.method, line.parameter)
            .1
            .into_iter()
            .next();
        let updated = playback.map_or(Vec::new(), |p| p.updated);
        let point = |(frame, set): (usize, &JointSet)| (frame as f64 / rate, set.len() as f64);
        Series {
            name: line.label.clone(),
            // Nothing is updated at the first frame: every method starts from the true pose.
            points: updated.iter().enumerate().skip(1).map(point).collect(),
            dashed: line.method.name() != "skin-px",
        }
    };
    let mut series: Vec<Series> = lines.iter().map(line).collect();
    let last = (stage.clip.frames() - 1) as f64 / rate;
    let moving = stage.moving.len() as f64;
    series.push(Series {
        name: "all moving joints".into(),
        points: vec![(1.0 / rate, moving), (last.max(1.0 / rate), moving)],
        dashed: true,
    });
    let options = PlotOptions {
        title: format!("Joints updated over the clip, {heading}"),
        x_label: "time in the clip (s)".into(),
        y_label: "joints updated".into(),
        ..PlotOptions::default()
    };
    Plot {
        name: "over-the-clip.svg",
        svg: line_plot(&options, &series),
    }
}

/// Plots distance, joints updated and error over the time of a path; `bound_px` is the upper bound of
/// the error of a single joint, if there is one.
pub fn path_plots(run: &PathRun, bound_px: Option<f32>, heading: &str) -> Vec<Plot> {
    let plot = |name, y: &str, target: Option<(f64, String)>, of: &dyn Fn(&PathFrame) -> f64| {
        let options = PlotOptions {
            title: format!("{y}, {heading}"),
            x_label: "time (s)".into(),
            y_label: y.into(),
            target,
            ..PlotOptions::default()
        };
        let series = Series {
            points: run.frames.iter().skip(1).map(|f| (f.secs, of(f))).collect(),
            ..Series::default()
        };
        Plot {
            name,
            svg: line_plot(&options, &[series]),
        }
    };
    let bound = bound_px.map(|px| (f64::from(px), format!("bound per joint {px} px")));
    vec![
        plot(
            "path-distance.svg",
            "Distance to the root (m)",
            None,
            &|f| f64::from(f.distance_m),
        ),
        plot("path-updates.svg", "Joints updated", None, &|f| {
            f.updated.len() as f64
        }),
        plot(
            "path-joint-error.svg",
            "Maximum joint error (px)",
            bound,
            &|f| f64::from(f.joint_error_px),
        ),
        plot(
            "path-error.svg",
            "Error of the skin (px, p95 over vertices)",
            None,
            &|f| f64::from(f.error_px),
        ),
    ]
}

/// Plots error, joints sampled and jump per frame over the time of a schedule, one line for each kind of
/// transition.
pub fn schedule_plots(schedule: &[ScheduleReport], heading: &str) -> Vec<Plot> {
    let plot = |name, y: &str, of: fn(&ScheduleRow) -> f64| {
        let options = PlotOptions {
            title: format!("{y}, {heading}"),
            x_label: "time (s)".into(),
            y_label: y.into(),
            ..PlotOptions::default()
        };
        let line = |played: &ScheduleReport| Series {
            name: match played.transition {
                "none" => "no transition".to_owned(),
                kind => format!("{kind} transition"),
            },
            points: played.frames.iter().map(|f| (f.t, of(f))).collect(),
            dashed: played.transition == "none",
        };
        let series: Vec<Series> = schedule.iter().map(line).collect();
        Plot {
            name,
            svg: line_plot(&options, &series),
        }
    };
    vec![
        plot(
            "schedule-error.svg",
            "Error of the skin (px, p95 over vertices)",
            |f| f64::from(f.error_px),
        ),
        plot("schedule-joints.svg", "Joints sampled", |f| {
            f.joints_sampled as f64
        }),
        plot(
            "schedule-jump.svg",
            "Largest jump of a joint per frame (degrees)",
            |f| f64::from(f.jump_deg),
        ),
    ]
}
