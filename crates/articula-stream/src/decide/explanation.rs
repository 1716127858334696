//! Decisions in words.

use super::choice::Budget;
use super::decision::{Bound, Decision, NextStep, Outcome, PartDecision};
use super::part::PartKind;
use super::preference::{Preference, Rule};
use std::fmt::{Display, Formatter, Result};

impl Display for Bound {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Bytes => f.write_str("the bytes"),
            Self::FrameTime => f.write_str("the time per frame"),
            Self::Device => f.write_str("the device"),
            Self::Memory => f.write_str("the memory"),
            Self::View => f.write_str("what can be seen"),
            Self::Emphasis => f.write_str("the emphasis, which is none"),
            Self::Preference(preference) => preference.fmt(f),
            Self::Capability => f.write_str("what the client supports"),
        }
    }
}

impl Display for PartKind {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(match self {
            Self::BodyMotion => "body",
            Self::FaceMotion => "face",
            Self::Mesh => "mesh",
            Self::Texture => "textures",
            Self::Other => "others",
        })
    }
}

impl Display for Preference {
    /// What is wanted, such as `the limit "body: level of articulation 2 or less"`.
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let strength = if self.is_wish { "wish" } else { "limit" };
        write!(f, "the {strength} \"{}: ", self.part)?;
        match self.rule {
            Rule::FinestLevel(level) => write!(f, "level {level} or coarser")?,
            Rule::CoarsestLevel(level) => write!(f, "level {level} or finer")?,
            Rule::LoaAtMost(loa) => write!(f, "level of articulation {loa} or less")?,
            Rule::LoaAtLeast(loa) => write!(f, "level of articulation {loa} or more")?,
            Rule::RegionsWithin(mask) => write!(f, "no regions but {}", Regions(mask))?,
            Rule::RegionsWith(mask) => write!(f, "regions {}", Regions(mask))?,
        }
        f.write_str("\"")
    }
}

/// Numbers of the bits of a mask.
struct Regions(u32);

impl Display for Regions {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let bits = (0..u32::BITS).filter(|bit| self.0 >> bit & 1 == 1);
        let numbers: Vec<String> = bits.map(|bit| (bit + 1).to_string()).collect();
        match numbers.as_slice() {
            [] => f.write_str("none"),
            numbers => f.write_str(&numbers.join(", ")),
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
        f.write_str(" per frame, ")?;
        if let Some(ratio) = self.device_ratio {
            write!(
                f,
                "{:.1} % of that of everything, by the device, ",
                100.0 * ratio
            )?;
        }
        if of.budget.memory_bytes < Budget::UNBOUNDED {
            write!(f, "{} bytes of memory, ", of.budget.memory_bytes)?;
        }
        writeln!(f, "at {:.1} pixels per metre", of.pixels_per_metre)?;
        match &self.outcome {
            Outcome::Parts(choice) => {
                write!(f, "chosen: 3D, {} bytes, ", self.bytes)?;
                if choice.frame_ns > 0 {
                    write!(f, "{:.3} ms per frame, ", ms(choice.frame_ns as f64))?;
                }
                write!(f, "error at most {:.2} px", self.error_px)?;
                // Within what cannot be seen, fewer bytes are better than a smaller error.
                if choice.bound_px < choice.error_px && !choice.is_enough {
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
        for preference in &self.unmet {
            writeln!(f, "{preference} is not met")?;
        }
        Ok(())
    }
}

impl Display for PartDecision {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let (name, option) = (&self.name, &self.option_name);
        write!(f, "{name}: {option}, {} bytes, ", self.bytes)?;
        if self.frame_ns > 0 {
            write!(f, "{:.3} ms, ", ms(self.frame_ns as f64))?;
        }
        write!(f, "{:.2} px; ", self.error_px)?;
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
            "next {}: {:+} bytes, ",
            self.option_name, self.more_bytes
        )?;
        if self.more_frame_ns != 0 {
            write!(f, "{:+.3} ms, ", ms(self.more_frame_ns as f64))?;
        }
        write!(f, "{:.2} px less, ", self.gain_px)?;
        if self.bounds.is_empty() {
            f.write_str("gains less than what another part has for it")
        } else {
            write!(f, "prevented by {}", All(&self.bounds))
        }
    }
}
