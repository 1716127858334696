//! A device with its results, as JSON.

use super::grade::Application;
use super::result::{ApplicationResult, GradeRate};
use crate::error::{Error, Result};
use articula_core::Libm;
use articula_stream::description::{Benchmark, Context};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Most bytes of a report.
const MOST_BYTES: usize = 64 << 10;
/// Most characters of a word of a description.
const MOST_CHARACTERS: usize = 100;
/// Most cores and threads.
const MOST_CORES: usize = 65_536;
/// Frame rates that a device may tell, frames per second.
const FPS: std::ops::RangeInclusive<f64> = 1e-3..=1e6;
/// Most runs of a grade.
const MOST_RUNS: usize = 10_000;
/// Score of the reference machine.
const REFERENCE_SCORE: f64 = 100.0;

/// What a device is, for others of its kind to be found.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct DeviceDescription {
    /// Model of the processor.
    pub cpu: String,
    /// Number of its cores.
    pub cores: usize,
    /// Operating system, such as `linux`.
    pub os: String,
    /// Architecture, such as `x86_64`.
    pub arch: String,
    /// Version of the program.
    pub program: String,
    /// Instruction set of the kernels, such as `avx2`.
    pub backend: String,
    /// Number of threads that pose a crowd.
    pub threads: usize,
}

impl DeviceDescription {
    /// Returns how unlike two devices are, from 0 for the same: another architecture counts 8, no common
    /// word in the model 4, another backend 2, each doubling of cores and threads 1, another system 1/2,
    /// another version 1/4.
    pub fn distance(&self, other: &Self) -> f64 {
        let differs = |by: f64, a: &str, b: &str| if a.eq_ignore_ascii_case(b) { 0.0 } else { by };
        let doublings = |a: usize, b: usize| {
            let ratio = a.max(1) as f64 / b.max(1) as f64;
            ratio.libm_log2().abs()
        };
        let (own, others) = (words(&self.cpu), words(&other.cpu));
        let common = own.intersection(&others).count() as f64;
        let all = own.union(&others).count().max(1) as f64;
        differs(8.0, &self.arch, &other.arch)
            + 4.0 * (1.0 - if own == others { 1.0 } else { common / all })
            + differs(2.0, &self.backend, &other.backend)
            + doublings(self.cores, other.cores)
            + doublings(self.threads, other.threads)
            + differs(0.5, &self.os, &other.os)
            + differs(0.25, &self.program, &other.program)
    }

    fn check(&self) -> Result<()> {
        let texts = [
            ("cpu", &self.cpu),
            ("os", &self.os),
            ("arch", &self.arch),
            ("program", &self.program),
            ("backend", &self.backend),
        ];
        for (name, text) in texts {
            let is_plain = !text.chars().any(char::is_control);
            if !(1..=MOST_CHARACTERS).contains(&text.chars().count()) || !is_plain {
                let what = format!("expected 1 to {MOST_CHARACTERS} characters on one line");
                return Err(refused(&format!("device.{name}"), &what));
            }
        }
        for (name, number) in [("cores", self.cores), ("threads", self.threads)] {
            if !(1..=MOST_CORES).contains(&number) {
                let what = format!("expected 1 to {MOST_CORES}");
                return Err(refused(&format!("device.{name}"), &what));
            }
        }
        Ok(())
    }
}

/// The words of a model in small letters.
fn words(model: &str) -> BTreeSet<String> {
    let words = model.split(|c: char| !c.is_alphanumeric());
    let words = words.filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect()
}

fn refused(place: &str, what: &str) -> Error {
    Error::At {
        place: place.to_owned(),
        cause: Box::new(Error::Unsupported(what.to_owned())),
    }
}

/// A device and the results of its benchmarks.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeviceReport {
    /// The device.
    pub device: DeviceDescription,
    /// At most one result of each application.
    pub results: Vec<ApplicationResult>,
}

/// What of a report is read; the rest follows from it.
#[derive(Deserialize)]
struct Told {
    device: DeviceDescription,
    results: Vec<ToldResult>,
}

#[derive(Deserialize)]
struct ToldResult {
    application: Application,
    grades: Vec<ToldRate>,
}

#[derive(Deserialize)]
struct ToldRate {
    grade: usize,
    fps: f64,
    runs: usize,
}

impl DeviceReport {
    /// Reads a report as `articula bench device --json` writes it. Scores and the grades that the device
    /// holds are computed anew from its frame rates; members that are not known are left out.
    ///
    /// # Errors
    /// [`Error::Unsupported`] with the place, for what is no report or is out of its bounds.
    pub fn read(json: &[u8]) -> Result<Self> {
        if json.len() > MOST_BYTES {
            let what = format!("longer than {} kB", MOST_BYTES >> 10);
            return Err(refused("device report", &what));
        }
        let told: Told = serde_json::from_slice(json)
            .map_err(|error| refused("device report", &error.to_string()))?;
        told.device.check()?;
        let mut results: Vec<ApplicationResult> = Vec::new();
        for (r, result) in told.results.into_iter().enumerate() {
            let place = format!("results[{r}]");
            let is_told = |known: &ApplicationResult| known.application == result.application;
            if results.iter().any(is_told) {
                let what = format!("{} is told twice", result.application);
                return Err(refused(&place, &what));
            }
            results.push(read_result(&place, result)?);
        }
        if results.is_empty() {
            return Err(refused("results", "expected the result of an application"));
        }
        Ok(Self {
            device: told.device,
            results,
        })
    }

    /// Returns the result of an application.
    pub fn result(&self, application: Application) -> Option<&ApplicationResult> {
        let mut results = self.results.iter();
        results.find(|result| result.application == application)
    }

    /// Returns several runs as one: of each grade the median of its frame rates. The device is that of the
    /// last run; `None` of none.
    pub fn combined(runs: &[Self]) -> Option<Self> {
        let of = |application| {
            let results = runs.iter().filter_map(|run| run.result(application));
            ApplicationResult::combined(application, &results.collect::<Vec<_>>())
        };
        Some(Self {
            device: runs.last()?.device.clone(),
            results: Application::ALL.into_iter().filter_map(of).collect(),
        })
    }

    /// Tells a context of the device: its scores as benchmarks, in place of those of the same names, and
    /// the level of articulation of the body that it holds at the wanted rate (60 frames per second
    /// unless told) as the finest.
    pub fn add_to(&self, context: &mut Context) {
        let told = &mut context.terminal.benchmarks;
        for result in &self.results {
            let name = format!("articula-{}", result.application);
            told.retain(|benchmark| benchmark.name != name);
            told.push(Benchmark {
                name,
                score: Some(result.score),
                reference_score: Some(REFERENCE_SCORE),
                reference_fps: Some(1.0 / result.application.full_grade().reference_secs()),
                share: None,
            });
        }
        let wanted = context.preferences.frame_rate_hz;
        let wanted = wanted.or(context.terminal.refresh_hz).unwrap_or(60.0);
        let body = self.result(Application::Body);
        let enough = |held: &&super::result::Held| held.fps >= wanted;
        let held = body.and_then(|body| body.holds.iter().find(enough).or(body.holds.last()));
        if let Some(grade) = held.and_then(|held| held.grade) {
            let finest = context.preferences.body_loa.unwrap_or(u8::MAX);
            context.preferences.body_loa = Some(grade.loa.min(finest));
        }
    }
}

fn read_result(place: &str, told: ToldResult) -> Result<ApplicationResult> {
    let mut grades: Vec<GradeRate> = Vec::new();
    for (g, rate) in told.grades.into_iter().enumerate() {
        let place = format!("{place}.grades[{g}]");
        if rate.grade >= super::grade::GRADES || grades.iter().any(|r| r.grade == rate.grade) {
            let most = super::grade::GRADES - 1;
            return Err(refused(
                &place,
                &format!("grade: expected 0 to {most}, once"),
            ));
        }
        if !FPS.contains(&rate.fps) {
            let what = format!("fps: expected {} to {}", FPS.start(), FPS.end());
            return Err(refused(&place, &what));
        }
        if !(1..=MOST_RUNS).contains(&rate.runs) {
            return Err(refused(&place, &format!("runs: expected 1 to {MOST_RUNS}")));
        }
        grades.push(GradeRate {
            grade: rate.grade,
            fps: rate.fps,
            runs: rate.runs,
        });
    }
    let result = ApplicationResult::of(told.application, grades);
    result.ok_or_else(|| refused(place, "grades: expected the frame rate of a grade"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::Grade;
    use articula_mutate::{Edit, Mutations, cut_off};
    use articula_stream::decide::DeviceBenchmark;

    fn device() -> DeviceDescription {
        DeviceDescription {
            cpu: "Intel(R) Core(TM) i5-8250U CPU @ 1.60GHz".into(),
            cores: 4,
            os: "linux".into(),
            arch: "x86_64".into(),
            program: "0.1.0".into(),
            backend: "avx2".into(),
            threads: 1,
        }
    }

    /// A device that plays a grade of bodies at a multiple of the reference.
    fn report(times: f64) -> DeviceReport {
        let fps = times / Grade::of(Application::Body, 6).reference_secs();
        let grade = |grade, fps| GradeRate {
            grade,
            fps,
            runs: 6,
        };
        let result = ApplicationResult::of(Application::Body, vec![grade(6, fps)]);
        DeviceReport {
            device: device(),
            results: vec![result.unwrap()],
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let report = report(0.8);
        let json = serde_json::to_vec(&report).unwrap();
        let read = DeviceReport::read(&json).unwrap();
        assert_eq!(read.device, report.device);
        assert!((read.results[0].score - 80.0).abs() < 1e-9);
        assert_eq!(read.results[0].holds, report.results[0].holds);
    }

    #[test]
    fn a_score_that_does_not_follow_from_the_rates_is_not_believed() {
        let mut value = serde_json::to_value(report(0.8)).unwrap();
        value["results"][0]["score"] = 1e9.into();
        value["results"][0]["holds"] = "all".into();
        let read = DeviceReport::read(value.to_string().as_bytes()).unwrap();
        assert!((read.results[0].score - 80.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_out_of_bounds_is_refused_with_its_place() {
        let good = serde_json::to_value(report(1.0)).unwrap();
        let refused = |path: &str, value: serde_json::Value| {
            let mut bad = good.clone();
            *bad.pointer_mut(path).unwrap() = value;
            let error = DeviceReport::read(bad.to_string().as_bytes());
            error.unwrap_err().to_string()
        };
        let grade = "/results/0/grades/0";
        for (path, value, place) in [
            ("/device/cpu", "".into(), "device.cpu"),
            ("/device/cpu", "x".repeat(101).into(), "device.cpu"),
            ("/device/os", "a\u{1b}[2J".into(), "device.os"),
            ("/device/cores", 0.into(), "device.cores"),
            ("/device/threads", 100_000.into(), "device.threads"),
            ("/device/cores", (-1).into(), "device report"),
            ("/results", serde_json::json!([]), "results"),
            ("/results/0/grades", serde_json::json!([]), "results[0]"),
            ("/results/0/application", "nose".into(), "device report"),
            (&format!("{grade}/grade"), 12.into(), "results[0].grades[0]"),
            (&format!("{grade}/fps"), 0.into(), "results[0].grades[0]"),
            (&format!("{grade}/fps"), (-5).into(), "results[0].grades[0]"),
            (
                &format!("{grade}/fps"),
                1e300.into(),
                "results[0].grades[0]",
            ),
            (&format!("{grade}/runs"), 0.into(), "results[0].grades[0]"),
        ] {
            let error = refused(path, value);
            assert!(error.starts_with(place), "{path}: {error}");
        }
        let mut twice = good.clone();
        let again = twice["results"][0].clone();
        twice["results"].as_array_mut().unwrap().push(again);
        assert!(DeviceReport::read(twice.to_string().as_bytes()).is_err());
        for bad in [&b""[..], b"{}", b"[1]", b"\xff", &[b' '; MOST_BYTES + 1]] {
            assert!(DeviceReport::read(bad).is_err());
        }
    }

    #[test]
    fn what_is_read_of_damaged_reports_is_within_its_bounds() {
        let json = serde_json::to_vec(&report(0.8)).unwrap();
        let mutations = Mutations {
            edits: &[
                Edit::FlipBit,
                Edit::Delete(8),
                Edit::Repeat(40),
                Edit::Number(&[
                    "0",
                    "-1",
                    "1e99",
                    "1e-9",
                    "null",
                    "[]",
                    "18446744073709551615",
                ]),
            ],
            most: 3,
        };
        let read = mutations.read_of(&json, 2000, |bytes| {
            let Ok(report) = DeviceReport::read(bytes) else {
                return false;
            };
            for result in &report.results {
                assert!(result.score > 0.0 && result.full_fps().is_finite());
            }
            let json = serde_json::to_vec(&report).unwrap();
            assert_eq!(DeviceReport::read(&json).unwrap(), report);
            let both = DeviceReport::combined(&[report.clone(), report.clone()]).unwrap();
            both.add_to(&mut Context::default());
            report.device.distance(&both.device) == 0.0
        });
        assert!(read > 20, "{read}");
        assert!(cut_off(&json).all(|part| DeviceReport::read(part).is_err()));
    }

    #[test]
    fn a_context_is_told_what_the_device_bears() {
        let mut context = Context::default();
        report(0.5).add_to(&mut context);
        // Half as fast as the reference: its rate of the full grade, of 60 wanted, halved.
        let full = Application::Body.full_grade().reference_secs();
        context.check().unwrap();
        let ratio = DeviceBenchmark::of_context(&context).unwrap().ratio();
        assert!((ratio - 0.5 / full / 60.0).abs() < 1e-9, "{ratio}");
        report(0.25).add_to(&mut context);
        assert_eq!(context.terminal.benchmarks.len(), 1, "the newer one");
        // Grade 6 is the only one: it is held at 25 but not at 60.
        let mut context = Context::default();
        let grade = Grade::of(Application::Body, 6);
        let slow = report(40.0 * grade.reference_secs());
        slow.add_to(&mut context);
        assert_eq!(context.preferences.body_loa, None);
        context.preferences.frame_rate_hz = Some(24.0);
        slow.add_to(&mut context);
        assert_eq!(context.preferences.body_loa, Some(grade.loa));
        context.preferences.body_loa = Some(1);
        slow.add_to(&mut context);
        assert_eq!(context.preferences.body_loa, Some(1), "the user wants less");
    }

    #[test]
    fn the_nearest_device_is_the_one_of_the_same_kind() {
        let own = device();
        assert_eq!(own.distance(&own), 0.0);
        let with = |change: fn(&mut DeviceDescription)| {
            let mut other = device();
            change(&mut other);
            let distance = own.distance(&other);
            assert_eq!(distance, other.distance(&own));
            distance
        };
        let version = with(|d| d.program = "0.2.0".into());
        let sibling = with(|d| d.cpu = "Intel(R) Core(TM) i5-8350U CPU @ 1.70GHz".into());
        let stranger = with(|d| d.cpu = "AMD EPYC".into());
        let cores = with(|d| d.cores = 8);
        let arch = with(|d| d.arch = "aarch64".into());
        assert!(0.0 < version && version < cores && cores < sibling);
        assert!(sibling < stranger && stranger < arch);
        assert_eq!(
            with(|d| d.cpu = "intel core i5 8250u cpu 1 60ghz R TM".into()),
            0.0
        );
    }
}
