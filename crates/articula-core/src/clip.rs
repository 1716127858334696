//! A motion at a uniform rate: what the frame samples.

use crate::Mismatch;
use glam::{Quat, Vec3};

/// Values of one joint property, one for each frame of the clip, or one for all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Track<T> {
    /// Joint index (or morph slot) that it drives.
    pub target: u16,
    /// Whether a value holds until the next frame instead of blending towards it.
    pub step: bool,
    /// `frames` values, or a single one if the property does not move.
    pub values: Vec<T>,
}

/// A motion of one rig, sampled at a uniform rate. Joints without a track stay at rest.
///
/// Frame `i` is the pose at `i / rate_hz` seconds; the last frame is the end of the clip.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// Name as the source has it.
    pub name: String,
    /// Frames per second.
    rate_hz: f32,
    /// Number of frames, at least 1.
    frames: usize,
    /// Number of joints of the rig it was made for.
    joints: usize,
    /// Frames for each key of the source, at least 1.
    frames_per_key: usize,
    pub(crate) tracks: Tracks,
}

/// The tracks of a [`Clip`], as its builder gives them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tracks {
    /// Local translations, metres.
    pub translations: Vec<Track<Vec3>>,
    /// Local rotations; unit, each in the hemisphere of the one before.
    pub rotations: Vec<Track<Quat>>,
    /// Local scales.
    pub scales: Vec<Track<Vec3>>,
    /// Morph weights, by morph slot of the mesh.
    pub morphs: Vec<Track<f32>>,
}

impl Clip {
    /// Checks the tracks against the rig's size and the frame count.
    ///
    /// # Errors
    /// A [`Mismatch`] if the rate is not positive and finite, there is no frame, or a track
    /// names a joint beyond `joints` or has neither one value nor one for each frame.
    pub fn new(
        name: impl Into<String>,
        rate_hz: f32,
        frames: usize,
        joints: usize,
        tracks: Tracks,
    ) -> Result<Self, Mismatch> {
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            let what = format!("{rate_hz} is not a positive rate");
            return Err(Mismatch::new("rate_hz", what));
        }
        if frames == 0 {
            return Err(Mismatch::new("frames", "a clip needs at least one frame"));
        }
        check("translations", &tracks.translations, frames, joints)?;
        check("rotations", &tracks.rotations, frames, joints)?;
        check("scales", &tracks.scales, frames, joints)?;
        check("morphs", &tracks.morphs, frames, usize::MAX)?;
        Ok(Self {
            name: name.into(),
            rate_hz,
            frames,
            joints,
            frames_per_key: 1,
            tracks,
        })
    }

    /// The same clip, noting that its source had a key at every `frames`-th frame only.
    #[must_use]
    pub fn with_frames_per_key(mut self, frames: usize) -> Self {
        self.frames_per_key = frames.max(1);
        self
    }

    /// The clip at the rate of its source's keys, every frame in between left out. A last frame
    /// that is no key is dropped.
    #[must_use]
    pub fn at_key_rate(&self) -> Self {
        let every = self.frames_per_key;
        if every == 1 {
            return self.clone();
        }
        Self {
            name: self.name.clone(),
            rate_hz: self.rate_hz / every as f32,
            frames: (self.frames - 1) / every + 1,
            joints: self.joints,
            frames_per_key: 1,
            tracks: Tracks {
                translations: thinned(&self.tracks.translations, every),
                rotations: thinned(&self.tracks.rotations, every),
                scales: thinned(&self.tracks.scales, every),
                morphs: thinned(&self.tracks.morphs, every),
            },
        }
    }

    /// Frames per second.
    pub fn rate_hz(&self) -> f32 {
        self.rate_hz
    }

    /// Number of frames, at least 1.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Number of joints of the rig that it was made for.
    pub fn joints(&self) -> usize {
        self.joints
    }

    /// Time of the last frame; 0 for a single pose.
    pub fn duration_secs(&self) -> f32 {
        (self.frames - 1) as f32 / self.rate_hz
    }

    /// Its tracks: one for each joint whose rotation, translation or scale differs from rest, and
    /// one for each morph slot that is driven.
    pub fn tracks(&self) -> &Tracks {
        &self.tracks
    }
}

fn thinned<T: Copy>(tracks: &[Track<T>], every: usize) -> Vec<Track<T>> {
    tracks
        .iter()
        .map(|track| Track {
            target: track.target,
            step: track.step,
            values: track.values.iter().copied().step_by(every).collect(),
        })
        .collect()
}

fn check<T>(
    which: &str,
    tracks: &[Track<T>],
    frames: usize,
    targets: usize,
) -> Result<(), Mismatch> {
    for (t, track) in tracks.iter().enumerate() {
        if usize::from(track.target) >= targets {
            let what = format!("joint {} of {targets}", track.target);
            return Err(Mismatch::new(format!("{which}[{t}].target"), what));
        }
        if track.values.len() != 1 && track.values.len() != frames {
            let what = format!("{} values for {frames} frames", track.values.len());
            return Err(Mismatch::new(format!("{which}[{t}].values"), what));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn validity_table() {
        let at = |r: Result<Clip, Mismatch>| r.unwrap_err().at;
        let none = Tracks::default;
        assert_eq!(at(Clip::new("c", 0.0, 1, 1, none())), "rate_hz");
        assert_eq!(at(Clip::new("c", f32::NAN, 1, 1, none())), "rate_hz");
        assert_eq!(at(Clip::new("c", 30.0, 0, 1, none())), "frames");
        let track = |target, count| Tracks {
            rotations: vec![Track {
                target,
                step: false,
                values: vec![Quat::IDENTITY; count],
            }],
            ..none()
        };
        assert_eq!(
            at(Clip::new("c", 30.0, 3, 1, track(1, 3))),
            "rotations[0].target"
        );
        assert_eq!(
            at(Clip::new("c", 30.0, 3, 1, track(0, 2))),
            "rotations[0].values"
        );
        let clip = Clip::new("c", 30.0, 31, 1, track(0, 1)).unwrap();
        assert!((clip.duration_secs() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_key_rate_leaves_out_what_lies_between_keys() {
        let tracks = Tracks {
            morphs: vec![Track {
                target: 0,
                step: false,
                values: (0..8).map(|i| i as f32).collect(),
            }],
            ..Tracks::default()
        };
        let clip = Clip::new("c", 60.0, 8, 1, tracks)
            .unwrap()
            .with_frames_per_key(3);
        let thin = clip.at_key_rate();
        assert_eq!((thin.rate_hz(), thin.frames()), (20.0, 3));
        assert_eq!(thin.tracks().morphs[0].values, [0.0, 3.0, 6.0]);
        assert_eq!(thin.at_key_rate(), thin);
    }
}
