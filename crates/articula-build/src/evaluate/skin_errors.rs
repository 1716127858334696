//! Errors over the whole skin: the farthest vertex, and small parts of the body apart.
//!
//! The 95th percentile over a sample of the skin does not see a hand or a face, which have few
//! vertices and are what a viewer looks at. So all vertices are posed at all frames; this costs too
//! much for the search of a parameter and is done for the runs that are reported.

use super::method::Playback;
use super::skin_sample::SkinSample;
use super::stage::ClipEvaluator;
use super::statistics::{PartErrors, SkinErrors, across};
use crate::simplify::vertex_regions;
use articula_core::{Region, percentile};

/// The parts in the order of the fields of [`SkinErrors`].
const PARTS: [Region; 3] = [Region::Hands, Region::Face, Region::Feet];

impl ClipEvaluator<'_> {
    /// Measures a run over all vertices and all frames, in metres.
    pub fn skin_errors(&self, playbacks: &[Playback]) -> SkinErrors {
        let whole = SkinSample::whole(self.asset);
        let regions = vertex_regions(&self.asset.mesh, &self.asset.rig);
        let of = |part: Region| -> Vec<usize> {
            let all = regions.iter().enumerate();
            all.filter(|(_, r)| **r == part).map(|(v, _)| v).collect()
        };
        let mut parts = PARTS.map(of);
        let [_, face, _] = &mut parts;
        if face.is_empty() {
            face.extend(self.face.iter().map(|v| *v as usize));
        }
        let mut found = SkinErrors::default();
        let mut of_parts = [PartErrors::default(); PARTS.len()];
        for (playback, views) in self.seen(playbacks) {
            let mut frames = vec![[const { Vec::new() }; PARTS.len()]; views.len()];
            for f in 0..self.truth.len() {
                let offsets = self.offsets(&whole, playback, f);
                for (view, frames) in views.iter().zip(&mut frames) {
                    let lengths: Vec<f32> = offsets.iter().map(|d| across(*d, *view)).collect();
                    let worst = lengths.iter().copied().fold(0.0, f32::max);
                    found.worst_vertex = found.worst_vertex.max(worst);
                    let each = parts.iter().zip(frames).zip(&mut of_parts);
                    for ((part, frames), errors) in each {
                        let mut own: Vec<f32> = part
                            .iter()
                            .map(|v| lengths.get(*v).copied().unwrap_or(0.0))
                            .collect();
                        errors.worst_vertex =
                            own.iter().copied().fold(errors.worst_vertex, f32::max);
                        frames.push(percentile(&mut own, 0.95));
                    }
                }
            }
            for frames in &mut frames {
                for (frames, errors) in frames.iter_mut().zip(&mut of_parts) {
                    errors.frames.add(frames);
                }
            }
        }
        let [hands, face, feet] =
            std::array::from_fn(|p| (!parts[p].is_empty()).then_some(of_parts[p]));
        SkinErrors {
            hands,
            face,
            feet,
            ..found
        }
    }
}
