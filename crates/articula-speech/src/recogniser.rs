//! Samples in, frames of visemes out, while the sound arrives.

use crate::HOP;
use crate::bands::{BANDS, Bands, PRE_EMPHASIS, WINDOW};
use crate::frame::VisemeFrame;
use crate::network::{Network, RunningNetwork};
use crate::normaliser::Normaliser;
use articula_core::viseme::VISEME_COUNT;
use std::collections::VecDeque;

/// From a frame's middle to the last sound that it needs.
pub const LOOK_AHEAD_SECS: f32 = 0.0525;
/// Samples of a window before the [`HOP`] that it stands for.
const LEAD: usize = (WINDOW - HOP) / 2;

/// Recognises the visemes of one voice, in any language, without calibration.
///
/// Frame `t` is the sound from `t` to `t + 1` hundredths of a second; it comes once
/// [`LOOK_AHEAD_SECS`] more have been given. In blocks of any size the same samples give the same
/// frames.
#[derive(Debug, Clone)]
pub struct Recogniser {
    bands: Bands,
    normaliser: Normaliser,
    network: RunningNetwork,
    /// Emphasised samples from the window of the next frame on.
    pending: VecDeque<f32>,
    last_sample: f32,
    received: usize,
    /// Frames that the network has been given.
    framed: usize,
    /// Levels of the frames that are still inside the network.
    levels_db: VecDeque<f32>,
}

impl Default for Recogniser {
    fn default() -> Self {
        Self::new()
    }
}

impl Recogniser {
    /// A recogniser that has heard nothing.
    pub fn new() -> Self {
        let network = Network::stored();
        let mut mean = [0.0; BANDS];
        mean.copy_from_slice(&network.mean);
        Self {
            bands: Bands::new(),
            normaliser: Normaliser::new(mean),
            network: RunningNetwork::new(network),
            pending: VecDeque::from(vec![0.0; LEAD]),
            last_sample: 0.0,
            received: 0,
            framed: 0,
            levels_db: VecDeque::new(),
        }
    }

    /// Takes the next samples of one channel at 16 kHz, between -1 and 1, and gives the frames for
    /// which enough has come. What is no number counts as silence.
    pub fn push(&mut self, samples: &[f32]) -> Vec<VisemeFrame> {
        self.received += samples.len();
        self.take(samples.iter().copied(), usize::MAX)
    }

    /// Ends the sound: the frames that are left, with silence after it.
    pub fn finish(mut self) -> Vec<VisemeFrame> {
        let frames = self.received / HOP;
        let mut out = self.take(std::iter::repeat_n(0.0, WINDOW), frames);
        let rest = self.network.finish();
        let levels = self.levels_db;
        out.extend(
            rest.into_iter()
                .zip(levels)
                .map(|(weights, level_db)| VisemeFrame { weights, level_db }),
        );
        out
    }

    /// Takes samples while fewer than `most` frames have been framed.
    fn take(&mut self, samples: impl Iterator<Item = f32>, most: usize) -> Vec<VisemeFrame> {
        let mut out = Vec::new();
        for sample in samples {
            let sample = if sample.is_finite() {
                sample.clamp(-8.0, 8.0)
            } else {
                0.0
            };
            self.pending
                .push_back(sample - PRE_EMPHASIS * self.last_sample);
            self.last_sample = sample;
            if self.pending.len() == WINDOW && self.framed < most {
                out.extend(self.frame());
            }
        }
        out
    }

    /// Frames the window that has come whole.
    fn frame(&mut self) -> Option<VisemeFrame> {
        let logs = self.bands.log_powers(self.pending.make_contiguous());
        self.pending.drain(..HOP);
        self.framed += 1;
        let frame = self.normaliser.next(&logs);
        self.levels_db.push_back(frame.level_db);
        let weights: [f32; VISEME_COUNT] = self.network.push(&frame.features)?;
        let level_db = self.levels_db.pop_front()?;
        Some(VisemeFrame { weights, level_db })
    }
}
