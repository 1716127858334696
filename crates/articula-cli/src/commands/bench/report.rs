//! The result as JSON, as text and as a plot.

use crate::table::Table;
use articula::device::{
    Application, ApplicationResult, BenchmarkContent, BenchmarkRun, DeviceDescription, Grade,
    Workload,
};
use articula_report::{PlotOptions, Scale, Series, line_plot};
use serde::Serialize;

/// What was measured.
#[derive(Debug, Serialize)]
pub(super) struct BenchReport {
    pub(super) device: DeviceDescription,
    pub(super) results: Vec<Played>,
    /// Where it was sent.
    pub(super) sent: Option<String>,
    pub(super) written: Vec<String>,
}

/// An application that was played.
#[derive(Debug, Serialize)]
pub(super) struct Played {
    #[serde(flatten)]
    pub(super) result: ApplicationResult,
    /// Frame rate of all of the content, by the score.
    full_fps: f64,
    frames: usize,
    secs: f64,
    is_certain: bool,
    /// Size of each grade of `grades`.
    workloads: Vec<Workload>,
}

impl Played {
    pub(super) fn new(
        run: &BenchmarkRun,
        result: ApplicationResult,
        content: &BenchmarkContent,
    ) -> Self {
        let grades = Grade::all(result.application);
        let workloads = result.grades.iter();
        let workloads = workloads.map(|rate| content.workload(&grades[rate.grade]));
        Self {
            workloads: workloads.collect(),
            full_fps: result.full_fps(),
            frames: run.frames(),
            secs: run.secs(),
            is_certain: run.is_certain(),
            result,
        }
    }

    fn text(&self) -> String {
        let result = &self.result;
        let certain = match self.is_certain {
            true => "certain",
            false => "the time was over before it was certain; give more --seconds",
        };
        let mut text = format!(
            "\n{}: score {:.1}, {:.1} frames/s of all; {} frames in {:.1} s, {certain}\n",
            result.application, result.score, self.full_fps, self.frames, self.secs
        );
        let head = [
            "grade", "figures", "LoA", "joints", "vertices", "pixels", "frames/s", "runs",
        ];
        let mut table = Table::new(&head);
        let grades = Grade::all(result.application);
        for (rate, size) in result.grades.iter().zip(&self.workloads) {
            let grade = &grades[rate.grade];
            table.row([
                grade.number.to_string(),
                size.figures.to_string(),
                grade.loa.to_string(),
                size.joints.to_string(),
                size.vertices.to_string(),
                size.pixels.to_string(),
                format!("{:.1}", rate.fps),
                rate.runs.to_string(),
            ]);
        }
        text.push_str(&table.text());
        for held in &result.holds {
            let what = held.grade.as_ref().map_or_else(
                || "less than the coarsest grade; send a form in 2D".to_owned(),
                |grade| format!("grade {}, {}", grade.number, named(grade)),
            );
            text.push_str(&format!("  at {} frames/s: {what}\n", held.fps));
        }
        text
    }
}

/// A grade in words.
fn named(grade: &Grade) -> String {
    let (width, height) = grade.size_px;
    match grade.application {
        Application::Body => format!("LoA {}, {width}x{height} pixels", grade.loa),
        Application::Face => format!("face LoA {}, {width}x{height} pixels", grade.loa),
        Application::Crowd => format!("{} figures", grade.figures),
    }
}

impl BenchReport {
    pub(super) fn new(device: DeviceDescription) -> Self {
        Self {
            device,
            results: Vec::new(),
            sent: None,
            written: Vec::new(),
        }
    }

    pub(super) fn text(&self) -> String {
        let device = &self.device;
        let mut text = format!(
            "{}, {} cores, {} {}, {}, crowds on {} threads\n",
            device.cpu, device.cores, device.os, device.arch, device.backend, device.threads
        );
        for played in &self.results {
            text.push_str(&played.text());
        }
        if let Some(sent) = &self.sent {
            text.push_str(&format!("\nsent to {sent}\n"));
        }
        for path in &self.written {
            text.push_str(&format!("{path} written\n"));
        }
        text
    }

    /// Frame rates over grades as SVG, with the higher of the rates that are looked for.
    pub(super) fn plot(&self) -> String {
        let line = |played: &Played| Series {
            name: played.result.application.to_string(),
            points: (played.result.grades.iter())
                .map(|rate| (rate.grade as f64, rate.fps))
                .collect(),
            dashed: false,
        };
        let series: Vec<Series> = self.results.iter().map(line).collect();
        let options = PlotOptions {
            title: format!("Frame rates, {}", self.device.cpu),
            x_label: "grade, 0 is the finest".into(),
            y_label: "frames per second".into(),
            y_scale: Scale::Logarithmic,
            target: Some((60.0, "60 frames per second".into())),
            ..PlotOptions::default()
        };
        line_plot(&options, &series)
    }
}
