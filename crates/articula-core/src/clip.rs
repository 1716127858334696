//! Animation clips with a uniform frame rate, as sampled in each frame.

use crate::Mismatch;
use glam::{Quat, Vec3};
use std::sync::Arc;

/// The values of one property of one joint: one for each frame of the clip, or one for all frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Track<T> {
    /// Index of the animated joint (or morph slot).
    pub target: u16,
    /// Whether a value holds until the next frame instead of being interpolated.
    pub step: bool,
    /// `frames` values, or a single one if the property is constant.
    pub values: Vec<T>,
}

/// An animation clip of one rig with a uniform frame rate. Joints without a track stay in the rest
/// pose.
///
/// Frame `i` is the pose at `i / rate_hz` seconds; the last frame is the end of the clip. Clones share
/// the tracks, so that assets and players hold the same motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// Name as given by the source.
    pub name: String,
    /// Frames per second.
    rate_hz: f32,
    /// Number of frames, at least 1.
    frames: usize,
    /// Number of joints of the rig for which it was made.
    joints: usize,
    /// Number of frames per key of the source, at least 1.
    frames_per_key: usize,
    tracks: Arc<Tracks>,
}

/// The tracks of a [`Clip`], by property.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tracks {
    /// Local translations in metres.
    pub translations: Vec<Track<Vec3>>,
    /// Local rotations: unit quaternions, each in the hemisphere of the one before.
    pub rotations: Vec<Track<Quat>>,
    /// Local scales.
    pub scales: Vec<Track<Vec3>>,
    /// Morph target weights, by morph slot of the mesh.
    pub morphs: Vec<Track<f32>>,
}

impl Clip {
    /// Creates a clip, checking its tracks against the number of joints and frames.
    ///
    /// # Errors
    /// A [`Mismatch`] if the rate is not positive and finite, there is no frame, or a track targets
    /// a joint beyond `joints` or has neither one value nor one for each frame.
    pub fn new(
        name: impl Into<String>,
        rate_hz: f32,
        frames: usize,
        joints: usize,
        tracks: Tracks,
    ) -> Result<Self, Mismatch> {
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            let what = format!("must be positive and finite, found {rate_hz}");
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
            tracks: Arc::new(tracks),
        })
    }

    /// Returns the clip with the information that its source had keys only at every `frames`-th
    /// frame.
    #[must_use]
    pub fn with_frames_per_key(mut self, frames: usize) -> Self {
        self.frames_per_key = frames.max(1);
        self
    }

    /// Returns the number of frames per key of the source, at least 1.
    pub fn frames_per_key(&self) -> usize {
        self.frames_per_key
    }

    /// Returns the clip at the rate of its source's keys, without the frames in between. A last
    /// frame that is not a key is dropped.
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
            tracks: Arc::new(Tracks {
                translations: thinned(&self.tracks.translations, every),
                rotations: thinned(&self.tracks.rotations, every),
                scales: thinned(&self.tracks.scales, every),
                morphs: thinned(&self.tracks.morphs, every),
            }),
        }
    }

    /// Returns the number of frames per second.
    pub fn rate_hz(&self) -> f32 {
        self.rate_hz
    }

    /// Returns the number of frames, at least 1.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Returns the number of joints of the rig for which the clip was made.
    pub fn joints(&self) -> usize {
        self.joints
    }

    /// Returns the time of the last frame in seconds; 0 for a single pose.
    pub fn duration_secs(&self) -> f32 {
        (self.frames - 1) as f32 / self.rate_hz
    }

    /// Returns the tracks: one for each joint whose rotation, translation or scale differs from the
    /// rest pose, and one for each animated morph slot.
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
            let what = format!(
                "joint {} is out of range: the clip has {targets} joints",
                track.target
            );
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
