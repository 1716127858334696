//! Samples as the bands of a frame every hundredth of a second.

use crate::HOP;
use crate::bands::{BANDS, Bands, PRE_EMPHASIS, WINDOW};
use std::collections::VecDeque;

/// Samples of a window before the [`HOP`] that it stands for.
const LEAD: usize = (WINDOW - HOP) / 2;

/// Cuts sound into windows while it arrives.
#[derive(Debug, Clone)]
pub(crate) struct Windows {
    bands: Bands,
    /// Emphasised samples from the window of the next frame on.
    pending: VecDeque<f32>,
    last_sample: f32,
    received: usize,
    framed: usize,
}

impl Windows {
    pub(crate) fn new() -> Self {
        Self {
            bands: Bands::new(),
            pending: VecDeque::from(vec![0.0; LEAD]),
            last_sample: 0.0,
            received: 0,
            framed: 0,
        }
    }

    /// Takes the next samples at 16 kHz, between -1 and 1; what is no number counts as silence. Each
    /// window that has come whole is given to `frame`.
    pub(crate) fn push(&mut self, samples: &[f32], frame: impl FnMut([f32; BANDS])) {
        self.received += samples.len();
        self.take(samples.iter().copied(), usize::MAX, frame);
    }

    /// Ends the sound: the windows that are left, with silence after it.
    pub(crate) fn finish(&mut self, frame: impl FnMut([f32; BANDS])) {
        let frames = self.received / HOP;
        self.take(std::iter::repeat_n(0.0, WINDOW), frames, frame);
    }

    /// Takes samples while fewer than `most` frames have been framed.
    fn take(
        &mut self,
        samples: impl Iterator<Item = f32>,
        most: usize,
        mut frame: impl FnMut([f32; BANDS]),
    ) {
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
                let logs = self.bands.log_powers(self.pending.make_contiguous());
                self.pending.drain(..HOP);
                self.framed += 1;
                frame(logs);
            }
        }
    }
}
