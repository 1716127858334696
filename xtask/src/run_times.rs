//! What the steps of `cargo xtask test` took: the table at its end, and `target/xtask/steps.json`.

use crate::test_programs::TestTime;
use crate::workspace::target;
use anyhow::{Context, Result};
use serde::Serialize;
use std::fmt;
use std::time::Duration;

/// Number of slow tests that are told.
const SLOWEST: usize = 20;

/// What a run took.
#[derive(Debug, Serialize)]
pub(crate) struct RunTimes {
    wall_secs: f64,
    steps: Vec<StepTime>,
    slowest_tests: Vec<TestTime>,
}

/// What a step took; times in seconds.
#[derive(Debug, Serialize)]
pub(crate) struct StepTime {
    pub(crate) name: &'static str,
    pub(crate) wall_secs: f64,
    /// Of the programs that it called; its own is not counted.
    pub(crate) processor_secs: f64,
    pub(crate) budget_secs: f64,
    /// `done`, `skipped` or `failed`.
    pub(crate) outcome: &'static str,
}

impl RunTimes {
    /// Puts together what a run took; of the tests the slowest are kept.
    pub(crate) fn new(wall: Duration, steps: Vec<StepTime>, mut tests: Vec<TestTime>) -> Self {
        tests.sort_by(|a, b| b.secs.total_cmp(&a.secs));
        tests.truncate(SLOWEST);
        Self {
            wall_secs: wall.as_secs_f64(),
            steps,
            slowest_tests: tests,
        }
    }

    pub(crate) fn has_skipped(&self) -> bool {
        self.steps.iter().any(|step| step.outcome == "skipped")
    }

    /// Writes `steps.json`.
    pub(crate) fn write(&self) -> Result<()> {
        let folder = target().join("xtask");
        std::fs::create_dir_all(&folder)
            .and_then(|()| {
                std::fs::write(folder.join("steps.json"), serde_json::to_vec_pretty(self)?)
            })
            .with_context(|| format!("cannot write steps.json in {}", folder.display()))
    }
}

/// The tables of slow tests and of steps, and the steps that took more than their budget.
impl fmt::Display for RunTimes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.slowest_tests.is_empty() {
            writeln!(f, "\nslowest tests")?;
        }
        for TestTime {
            program,
            test,
            secs,
        } in &self.slowest_tests
        {
            writeln!(f, "{secs:9.1} s  {program} {test}")?;
        }
        writeln!(f, "\n     wall  processor")?;
        for step in &self.steps {
            let skipped = if step.outcome == "done" {
                ""
            } else {
                step.outcome
            };
            let (wall, processor) = (step.wall_secs, step.processor_secs);
            writeln!(f, "{wall:7.1} s {processor:7.1} s  {} {skipped}", step.name)?;
        }
        let processor: f64 = self.steps.iter().map(|step| step.processor_secs).sum();
        writeln!(f, "{:7.1} s {processor:7.1} s  all", self.wall_secs)?;
        for step in self
            .steps
            .iter()
            .filter(|s| s.processor_secs > s.budget_secs)
        {
            let [took, budget] = [step.processor_secs, step.budget_secs].map(|secs| secs / 60.0);
            let name = step.name;
            writeln!(
                f,
                "over budget: {name} took {took:.1} of {budget:.1} processor minutes"
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tells_slow_tests_and_steps_over_their_budget() {
        let step = |name, processor_secs| StepTime {
            name,
            wall_secs: 5.0,
            processor_secs,
            budget_secs: 60.0,
            outcome: "done",
        };
        let test = |i: u32| TestTime {
            program: "a it".to_owned(),
            test: format!("t{i}"),
            secs: f64::from(i),
        };
        let steps = vec![step("one", 60.0), step("two", 90.0)];
        let run = RunTimes::new(Duration::from_secs(9), steps, (0..30).map(test).collect());
        let text = run.to_string();
        assert!(text.contains("     29.0 s  a it t29\n"), "{text}");
        assert!(
            text.contains("a it t10\n") && !text.contains("a it t9\n"),
            "{text}"
        );
        assert!(text.contains("    9.0 s   150.0 s  all\n"), "{text}");
        let over = "over budget: two took 1.5 of 1.0 processor minutes\n";
        assert!(text.ends_with(over) && !text.contains("one took"), "{text}");
    }
}
