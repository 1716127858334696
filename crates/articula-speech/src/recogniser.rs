//! Samples in, frames of visemes out, while the sound arrives.

use crate::frame::VisemeFrame;
use crate::network::{Network, RunningNetwork};
use crate::normaliser::{Normalised, Normaliser};
use crate::windows::Windows;
use std::collections::VecDeque;

/// From a frame's middle to the last sound that it needs.
pub const LOOK_AHEAD_SECS: f32 = 0.0525;

/// Recognises the visemes of one voice, in any language, without calibration.
///
/// Frame `t` is the sound from `t` to `t + 1` hundredths of a second; it comes once
/// [`LOOK_AHEAD_SECS`] more have been given. In blocks of any size the same samples give the same
/// frames.
#[derive(Debug, Clone)]
pub struct Recogniser {
    windows: Windows,
    normaliser: Normaliser,
    network: RunningNetwork,
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
        Self::with_network(Network::stored())
    }

    /// The same by another network than the stored one.
    pub fn with_network(network: Network) -> Self {
        Self {
            windows: Windows::new(),
            normaliser: Normaliser::new(network.mean),
            network: RunningNetwork::new(network),
            levels_db: VecDeque::new(),
        }
    }

    /// Takes the next samples of one channel at 16 kHz, between -1 and 1, and gives the frames for
    /// which enough has come. What is no number counts as silence.
    pub fn push(&mut self, samples: &[f32]) -> Vec<VisemeFrame> {
        let mut heard = Vec::new();
        let normaliser = &mut self.normaliser;
        self.windows
            .push(samples, |logs| heard.push(normaliser.next(&logs)));
        self.recognise(&heard)
    }

    /// Ends the sound: the frames that are left, with silence after it.
    pub fn finish(mut self) -> Vec<VisemeFrame> {
        let mut heard = Vec::new();
        let normaliser = &mut self.normaliser;
        self.windows
            .finish(|logs| heard.push(normaliser.next(&logs)));
        let mut out = self.recognise(&heard);
        let rest = self.network.finish().into_iter().zip(self.levels_db);
        out.extend(rest.map(|(weights, level_db)| VisemeFrame { weights, level_db }));
        out
    }

    fn recognise(&mut self, heard: &[Normalised]) -> Vec<VisemeFrame> {
        let recognised = heard.iter().filter_map(|frame| {
            self.levels_db.push_back(frame.level_db);
            let weights = self.network.push(&frame.features)?;
            let level_db = self.levels_db.pop_front()?;
            Some(VisemeFrame { weights, level_db })
        });
        recognised.collect()
    }
}
