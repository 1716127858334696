//! Decisions in words.

use super::choice::Budget;
use super::decision::{Bound, Decision, NextStep, Outcome, PartDecision};
use std::fmt::{Display, Formatter, Result};

impl Display for Bound {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Bytes => f.write_str("the bytes"),
            Self::FrameTime => f.write_str("the time per frame"),
            Self::View => f.write_str("what can be seen"),
            Self::Preference(index) => write!(f, "preference {}", index + 1),
            Self::Capability => f.write_str("what the client supports"),
        }
    }
}

/// Bounds joined by `and`.
struct All<'a>(&'a [Bound]);

impl Display for All<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        for (i, bound) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str(" and ")?;
            }
            bound.fmt(f)?;
        }
        Ok(())
    }
}

fn ms(ns: f64) -> f64 {
    ns / 1e6
}

impl Display for Decision {
    /// The budget, what was chosen, what limits it, and a line for each part.
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let of = &self.request;
        match of.budget.bytes {
            Budget::UNBOUNDED.. => f.write_str("allowed: any number of bytes")?,
            bytes => write!(f, "allowed: {bytes} bytes for {} s", of.window_secs)?,
        }
        match of.budget.frame_ns {
            Budget::UNBOUNDED.. => f.write_str(", any time")?,
            ns => write!(f, ", {:.3} ms", ms(ns as f64))?,
        }
        writeln!(
            f,
            " per frame, at {:.1} pixels per metre",
            of.pixels_per_metre
        )?;
        match &self.outcome {
            Outcome::Parts(choice) => {
                let (bytes, time) = (self.bytes, ms(choice.frame_ns as f64));
                write!(f, "chosen: 3D, {bytes} bytes, {time:.3} ms per frame, ")?;
                write!(f, "error at most {:.2} px", self.error_px)?;
                if choice.bound_px < choice.error_px {
                    let least = choice.bound_px;
                    write!(
                        f,
                        " (weighted {:.2}, least possible {least:.2} px)",
                        choice.error_px
                    )?;
                }
                writeln!(f)?;
            }
            Outcome::Representation(_) => writeln!(
                f,
                "chosen: {}, {} bytes, error {:.2} px",
                self.modality, self.bytes, self.error_px
            )?,
            Outcome::Nothing => writeln!(f, "chosen: nothing, no representation fits")?,
        }
        match (&self.outcome, self.bounds.as_slice()) {
            (Outcome::Parts(_), []) => writeln!(f, "limited by: nothing, the error is the least")?,
            (_, []) => writeln!(f, "limited by: nothing, this kind was asked for")?,
            (Outcome::Parts(_), bounds) => writeln!(f, "limited by: {}", All(bounds))?,
            (_, bounds) => writeln!(f, "not 3D because of {}", All(bounds))?,
        }
        for part in &self.parts {
            writeln!(f, "{part}")?;
        }
        for index in &self.unmet {
            writeln!(f, "preference {} is not met", index + 1)?;
        }
        Ok(())
    }
}

impl Display for PartDecision {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(
            f,
            "{}: {}, {} bytes, {:.3} ms, {:.2} px; ",
            self.name,
            self.option_name,
            self.bytes,
            ms(self.frame_ns as f64),
            self.error_px
        )?;
        match &self.next {
            Some(next) => next.fmt(f),
            None => f.write_str("the finest"),
        }
    }
}

impl Display for NextStep {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(
            f,
            "next {}: {:+} bytes, {:+.3} ms, {:.2} px less, ",
            self.option_name,
            self.more_bytes,
            ms(self.more_frame_ns as f64),
            self.gain_px
        )?;
        if self.bounds.is_empty() {
            f.write_str("gains less than what another part has for it")
        } else {
            write!(f, "prevented by {}", All(&self.bounds))
        }
    }
}
