//! What the device of the page can play.

use super::Publisher;
use crate::error::{Fault, Result};
use crate::long_options::read;
use crate::opening::open_alone;
use crate::progress::{ProgressCallback, run};
use articula::core::Backend;
use articula::device::{
    Application, ApplicationResult, BenchmarkContent, BenchmarkOptions, BenchmarkRun, FirstGuess,
    Grade, calibrate,
};
use articula::{Error, Figure};
use serde::{Deserialize, Serialize};
use std::hint::black_box;
use std::ops::RangeInclusive;
use wasm_bindgen::prelude::*;

/// How often the calibration is timed.
const CALIBRATIONS: usize = 5;
/// Seconds that may be asked for.
const SECONDS: RangeInclusive<f64> = 0.1..=600.0;
/// Steps of progress for a second.
const STEPS_PER_SEC: f64 = 10.0;

#[wasm_bindgen]
extern "C" {
    /// Milliseconds on the clock of the page or worker.
    #[wasm_bindgen(js_namespace = performance, js_name = now)]
    fn now_ms() -> f64;
}

/// Options of `benchmark`.
#[derive(Debug, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
struct Benchmark {
    application: Application,
    seconds: f64,
    grades: Vec<usize>,
}

impl Default for Benchmark {
    fn default() -> Self {
        Self {
            application: Application::Body,
            seconds: BenchmarkOptions::default().most_secs,
            grades: Vec::new(),
        }
    }
}

/// A result, and what the reference machine does.
#[derive(Debug, Serialize)]
struct Benchmarked {
    #[serde(flatten)]
    result: ApplicationResult,
    /// Frames per second of the full grade, by the score.
    full_fps: f64,
    /// All grades, the finest first, with their rates on the reference machine.
    reference: Vec<ReferenceRate>,
}

/// A grade on the reference machine.
#[derive(Debug, Serialize)]
struct ReferenceRate {
    #[serde(flatten)]
    grade: Grade,
    fps: f64,
}

#[wasm_bindgen]
impl Publisher {
    /// Plays graded content of a figure until it is certain which grade this device holds at 25 and 60 frames per
    /// second, and returns JSON: the result as `articula bench device --json` tells it, `full_fps`, and `reference`, the
    /// rates of the reference machine. Scores of the reference human alone can be compared. `options` is JSON:
    /// `{application?: string, seconds?: number, grades?: number[]}`: "body", "face" or "crowd", the most seconds of
    /// frames, and the grades to play, 0 the finest to 11, in place of those around the two rates.
    pub fn benchmark(
        bytes: &[u8],
        name: &str,
        options: Option<String>,
        progress: Option<ProgressCallback>,
    ) -> Result<String, JsValue> {
        let Benchmark {
            application,
            seconds,
            grades,
        } = read(options.as_deref())?;
        if !SECONDS.contains(&seconds) {
            let what = format!("seconds: {seconds} found, expected 0.1 to 600");
            return Err(Fault::argument(what).into());
        }
        let count = Grade::all(application).len();
        if let Some(grade) = grades.iter().find(|grade| **grade >= count) {
            let what = format!("grades: {grade} found, expected 0 to {}", count - 1);
            return Err(Fault::argument(what).into());
        }
        run(progress, name, |work| {
            let mut character = open_alone(bytes, name)?;
            // What travels would leave the picture.
            character.put_in_place();
            let figure = Figure::new(character)?;
            let mut content = BenchmarkContent::new(application, figure, Backend::best(), work)?;
            let options = BenchmarkOptions {
                most_secs: seconds,
                grades,
                ..BenchmarkOptions::default()
            };
            let mut run = BenchmarkRun::new(application, &first_guess(), &options);
            let steps = (STEPS_PER_SEC * seconds).ceil() as usize;
            while let Some(grade) = run.next_grade() {
                let done = (STEPS_PER_SEC * run.secs()) as usize;
                work.step("playing", done.min(steps), steps)?;
                let start = now_ms();
                black_box(content.play(&grade, work)?);
                run.record(&grade, 1e-3 * (now_ms() - start));
            }
            let result = run.result();
            let result = result
                .ok_or_else(|| Error::Unsupported("no frame was played in this time".to_owned()))?;
            let reference = |grade: Grade| ReferenceRate {
                grade,
                fps: 1.0 / grade.reference_secs(),
            };
            let told = Benchmarked {
                full_fps: result.full_fps(),
                reference: Grade::all(application).into_iter().map(reference).collect(),
                result,
            };
            serde_json::to_string(&told).map_err(|error| Error::Write(Box::new(error)))
        })
    }
}

/// Times the calibration. A module has one thread.
fn first_guess() -> FirstGuess {
    let times = (0..CALIBRATIONS).map(|_| {
        let start = now_ms();
        black_box(calibrate());
        1e-3 * (now_ms() - start)
    });
    FirstGuess {
        calibration_secs: times.fold(f64::INFINITY, f64::min),
        cores: 1,
        threads: 1,
    }
}
