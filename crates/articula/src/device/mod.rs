//! What a device can play: graded content, the run that plays it, and the result.
//!
//! Source: thesis 3.2.2; `docs/methods/adaptation.md` part 8. The caller has the clock: it plays what
//! [`BenchmarkRun::next_grade`] asks for, a frame at a time, and tells how long that took.
//!
//! ```text
//! Figure ─ BenchmarkContent::new ─▶ BenchmarkContent ─ play ─▶ a frame of a Grade
//! FirstGuess ─ BenchmarkRun::new ─▶ BenchmarkRun ─ next_grade, record (many times) ─▶ ApplicationResult
//! DeviceDescription, results ─ DeviceReport ─ add_to ─▶ Context; combined, with those of other runs
//! ```
//!
//! - [`Grade`]: a workload of known size, of a body, a face or a crowd
//! - [`BenchmarkContent`]: what a grade shows, frame by frame
//! - [`BenchmarkRun`]: which grade to play next, until the answer is certain
//! - [`DeviceReport`]: a device with its results, as JSON

mod content;
mod crowd;
mod drawn;
mod face;
mod grade;
mod guess;
mod median;
mod report;
mod rest;
mod result;
mod run;
mod workload;

pub use content::BenchmarkContent;
pub use grade::{Application, Grade};
pub use guess::{FirstGuess, calibrate};
pub use report::{DeviceDescription, DeviceReport};
pub use result::{ApplicationResult, GradeRate, Held, TARGETS_FPS};
pub use run::{BenchmarkOptions, BenchmarkRun};
pub use workload::Workload;
