//! Another sampling rate as that of the recogniser.
//!
//! An own filter of 40 lines: the libraries for this choose vector code by the machine that they run
//! on, and the same recording shall give the same bits on all.

use crate::SAMPLE_RATE_HZ;
use articula_core::Libm;
use std::collections::VecDeque;
use std::f64::consts::PI;

/// Zero crossings of the filter to either side of a sample.
const CROSSINGS: f64 = 24.0;
/// Where the filter begins to fall, as a share of the lower of the two half rates.
const PASS: f64 = 0.94;
/// Entries of the filter's table; between them it is taken as straight.
const ENTRIES: usize = 24 * 256;

/// Makes samples at 16 kHz of those at another rate, while they arrive.
#[derive(Debug, Clone)]
pub struct Resampler {
    rate_hz: u32,
    /// The filter, from its middle to its end.
    filter: Vec<f32>,
    /// Samples from the first one that is needed on, and its number; those before 0 are silence.
    pending: VecDeque<f32>,
    first: i64,
    received: i64,
    made: i64,
}

impl Resampler {
    /// From `rate_hz` samples a second, at least 1.
    pub fn new(rate_hz: u32) -> Self {
        Self {
            rate_hz: rate_hz.max(1),
            filter: (0..=ENTRIES + 1).map(filter).collect(),
            pending: VecDeque::new(),
            first: 0,
            received: 0,
            made: 0,
        }
    }

    /// Takes the next samples and gives those for which enough has come.
    pub fn push(&mut self, samples: &[f32]) -> Vec<f32> {
        self.received += samples.len() as i64;
        self.pending.extend(samples);
        self.make(|this, at| at + this.reach() < this.received as f64)
    }

    /// Ends the sound: the samples that are left, with silence after it.
    pub fn finish(mut self) -> Vec<f32> {
        self.make(|this, at| at < this.received as f64)
    }

    /// Samples that come in for each that goes out.
    fn step(&self) -> f64 {
        f64::from(self.rate_hz) / f64::from(SAMPLE_RATE_HZ)
    }

    /// The filter's half width, in samples that come in.
    fn reach(&self) -> f64 {
        CROSSINGS * self.step().max(1.0)
    }

    fn make(&mut self, may: impl Fn(&Self, f64) -> bool) -> Vec<f32> {
        let mut out = Vec::new();
        if self.rate_hz == SAMPLE_RATE_HZ {
            self.made += self.pending.len() as i64;
            return self.pending.drain(..).collect();
        }
        loop {
            let at = self.made as f64 * self.step();
            if !may(self, at) {
                return out;
            }
            out.push(self.sample(at));
            self.made += 1;
            let needed = (at - self.reach()).ceil() as i64;
            while self.first < needed && self.pending.pop_front().is_some() {
                self.first += 1;
            }
        }
    }

    /// The sound at a time, in samples that came in.
    fn sample(&mut self, at: f64) -> f32 {
        let reach = self.reach();
        let low = ((at - reach).ceil() as i64).max(self.first);
        let taken = &self.pending.make_contiguous()[(low - self.first) as usize..];
        let scale = ENTRIES as f64 / reach;
        let within = taken.iter().zip(low..);
        let within = within.take_while(|(_, n)| *n as f64 <= at + reach);
        let sum: f32 = within
            .map(|(sample, n)| {
                let entry = (n as f64 - at).abs() * scale;
                let (index, share) = (entry as usize, entry.fract() as f32);
                let [a, b] = [self.filter[index], self.filter[index + 1]];
                sample * (a + (b - a) * share)
            })
            .sum();
        sum / self.step().max(1.0) as f32
    }
}

/// An entry of the filter: a sinc under a raised cosine, of gain 1 at the lower rate.
fn filter(entry: usize) -> f32 {
    let x = CROSSINGS * entry as f64 / ENTRIES as f64;
    let window = 0.5 + 0.5 * (PI * (x / CROSSINGS).min(1.0)).libm_cos();
    (PASS * sinc(PASS * x) * window) as f32
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        1.0
    } else {
        (PI * x).libm_sin() / (PI * x)
    }
}
