//! Results of benchmarks on a device and on the machine that content was measured on.
//!
//! Source: thesis 3.2.2.

use super::is_word;
use articula_core::Mismatch;

/// Most benchmarks of a context.
const MOST: usize = 64;

/// A benchmark: its score on the device, which a client knows, and what the reference machine reaches,
/// which a server knows.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(
    feature = "json",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Benchmark {
    /// Name, by which the results of both ends are put together.
    pub name: String,
    /// Score of the device; a larger one is faster.
    pub score: Option<f64>,
    /// Score of the reference machine in the same benchmark.
    pub reference_score: Option<f64>,
    /// Frames per second that the reference machine reaches with all of the content.
    pub reference_fps: Option<f64>,
    /// Share of the device that the content may use, 0 to 1.
    pub share: Option<f64>,
}

impl Benchmark {
    /// What the client tells, with what the server tells of the same one.
    fn or(&self, other: Option<&Self>) -> Self {
        let of = |own: Option<f64>, get: fn(&Self) -> Option<f64>| own.or(other.and_then(get));
        Self {
            name: self.name.clone(),
            score: of(self.score, |b| b.score),
            reference_score: of(self.reference_score, |b| b.reference_score),
            reference_fps: of(self.reference_fps, |b| b.reference_fps),
            share: of(self.share, |b| b.share),
        }
    }

    /// Its numbers with the names that they have in XML.
    pub(super) fn numbers(&mut self) -> [(&'static str, &mut Option<f64>); 4] {
        [
            ("score", &mut self.score),
            ("referenceScore", &mut self.reference_score),
            ("referenceFps", &mut self.reference_fps),
            ("share", &mut self.share),
        ]
    }

    pub(super) fn check(&self) -> Result<(), Mismatch> {
        let at = |field: &str| format!("benchmarks \"{}\": {field}", self.name);
        if !is_word(&self.name) {
            let what = "expected a name without white space or control characters";
            return Err(Mismatch::new(at("name"), what));
        }
        for (field, value) in self.clone().numbers() {
            let (most, expected) = match field {
                "share" => (1.0, "0 to 1"),
                _ => (f64::MAX, "a finite number from 0 on"),
            };
            if let Some(found) = value.filter(|v| !(0.0..=most).contains(v)) {
                let what = format!("found {found}, expected {expected}");
                return Err(Mismatch::new(at(field), what));
            }
        }
        Ok(())
    }
}

/// The benchmarks of both ends: those of the client in their order, then those that only the server
/// knows.
pub(super) fn both(client: &[Benchmark], server: &[Benchmark]) -> Vec<Benchmark> {
    let named = |of: &[Benchmark], name: &str| of.iter().find(|b| b.name == name).cloned();
    let own = client.iter().map(|b| b.or(named(server, &b.name).as_ref()));
    let others = server.iter().filter(|b| named(client, &b.name).is_none());
    own.chain(others.cloned()).collect()
}

/// Checks that there are not too many.
pub(super) fn check_count(all: &[Benchmark]) -> Result<(), Mismatch> {
    if all.len() <= MOST {
        return Ok(());
    }
    let what = format!("{}, at most {MOST} are read", all.len());
    Err(Mismatch::new("benchmarks", what))
}

/// Checks all of them; a name stands once.
pub(super) fn check(all: &[Benchmark]) -> Result<(), Mismatch> {
    check_count(all)?;
    for (number, benchmark) in all.iter().enumerate() {
        benchmark.check()?;
        if all[..number]
            .iter()
            .any(|other| other.name == benchmark.name)
        {
            let at = format!("benchmarks \"{}\"", benchmark.name);
            return Err(Mismatch::new(at, "is told twice"));
        }
    }
    Ok(())
}
