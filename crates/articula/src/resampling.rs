//! How far clips of uniform rate are from the keys of their file.

use crate::error::{Context, Result};
use articula_build::clip_edit::resample_keys;
use articula_build::{
    ClipOptions, Played, resampling_error, sampled_clip, sampling_bound_metres, sampling_rate_hz,
};
use articula_core::source::{Character, RawClip, Skeleton};
use articula_core::{Clip, Mesh};
use serde::Serialize;

/// Maximum rate that is proposed, in frames per second.
const MAX_RATE_HZ: f32 = 240.0;

/// The frames of a clip, and their distance from the keys of the file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClipResampling {
    /// Name of the clip.
    pub clip: String,
    /// Rate of the frames per second; null if the keys of the file are kept.
    pub rate_hz: Option<f32>,
    /// Greatest displacement of the skin from the file in millimetres; of joints where there is no
    /// mesh.
    pub resampling_mm: f64,
    /// Displacement in millimetres from which on a warning is given: 0.1, in figures beyond 2 m a share of their extent.
    #[serde(skip)]
    pub told_mm: f64,
}

impl ClipResampling {
    /// Returns what a user should know of a clip whose frames are [`told_mm`](Self::told_mm) or more from its
    /// file.
    pub fn warning(&self) -> Option<String> {
        let (name, mm) = (&self.clip, self.resampling_mm);
        let rate = self.rate_hz.filter(|_| mm >= self.told_mm)?;
        let mend = match (2.0 * rate).min(MAX_RATE_HZ) {
            finer if finer > 1.01 * rate => {
                format!("convert it with --rate {} first", finer.ceil())
            }
            _ => "its keys are closer than frames".to_owned(),
        };
        Some(format!(
            "clip \"{name}\": the skin is up to {mm:.1} mm from the file at {rate} frames per second; \
             {mend}"
        ))
    }
}

/// Measures the clips that are made of a character for playback and streams against its keys.
///
/// # Errors
/// An [`Error`](crate::Error) that names the clip that cannot be used.
pub fn clip_resampling(character: &Character) -> Result<Vec<ClipResampling>> {
    let mesh = mesh(character)?;
    let measured = character.clips.iter().map(|file| {
        let clip = sampled_clip(character, file, &mesh, &ClipOptions::default());
        let clip = clip.with_context(|| format!("clip \"{}\"", file.name))?;
        Ok(of_frames(character, &mesh, file, &clip))
    });
    measured.collect()
}

/// Measures a clip that is played against the keys of a file.
pub(crate) fn of_frames(
    character: &Character,
    mesh: &Mesh,
    file: &RawClip,
    clip: &Clip,
) -> ClipResampling {
    let error = resampling_error(character, mesh, file, Played::Frames(clip));
    ClipResampling {
        clip: file.name.clone(),
        rate_hz: Some(clip.rate_hz()),
        resampling_mm: 1e3 * error.metres,
        told_mm: told_mm(&character.skeleton),
    }
}

/// The displacement of a figure's skin in millimetres from which on it is told.
pub(crate) fn told_mm(skeleton: &Skeleton) -> f64 {
    1e3 * f64::from(sampling_bound_metres(skeleton))
}

/// Returns the rate of the frames of the first clip of a character in hertz; 30 without clips.
pub(crate) fn first_clip_rate_hz(character: &Character) -> f32 {
    match character.clips.first() {
        Some(clip) => sampling_rate_hz(clip, &character.skeleton),
        None => 30.0,
    }
}

/// The greatest displacement of keys at a rate from a clip of a character, in millimetres.
pub(crate) fn keyed_mm(character: &Character, file: &RawClip, rate_hz: f32) -> Result<f64> {
    let clip = resample_keys(file, rate_hz)?;
    played_mm(character, file, &clip, rate_hz)
}

/// The greatest displacement of a clip with keys at a rate from another one, in millimetres.
pub(crate) fn played_mm(
    character: &Character,
    file: &RawClip,
    clip: &RawClip,
    rate_hz: f32,
) -> Result<f64> {
    let played = Played::Keys { clip, rate_hz };
    let error = resampling_error(character, &mesh(character)?, file, played);
    Ok(1e3 * error.metres)
}

fn mesh(character: &Character) -> Result<Mesh> {
    let joints = character.skeleton.joints.len();
    Ok(Mesh::new(&character.meshes, joints)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_large_figures_miss_is_told_from_more_on() {
        let of = |told_mm| ClipResampling {
            clip: "walk".to_owned(),
            rate_hz: Some(30.0),
            resampling_mm: 0.2,
            told_mm,
        };
        let told = of(0.1).warning().unwrap();
        assert!(
            told.contains("0.2 mm") && told.contains("--rate 60"),
            "{told}"
        );
        assert_eq!(of(4.0).warning(), None);
    }
}
