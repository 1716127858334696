//! The voices that systems are judged on.

use super::super::random::Random;
use super::corpus::Clip;
use anyhow::{Context, Result};
use articula_speech::training::segments;
use articula_speech::{Sound, read_phone_times};
use std::path::Path;

/// Names of the sets of people: as recorded, and changed.
pub(super) const PEOPLE: &str = "People: four sentences of LibriVox";
pub(super) const SOFT: &str = "The same, 26 dB softer";
pub(super) const NOISY: &str = "The same under noise, 15 dB below the voice";
const OTHERS: &str = "People: the given folder";

/// Recordings with their phones.
pub(super) struct Set {
    pub(super) name: &'static str,
    pub(super) clips: Vec<Clip>,
}

impl Set {
    pub(super) fn of_clips(name: &'static str, clips: Vec<Clip>) -> Self {
        Self { name, clips }
    }

    pub(super) fn seconds(&self) -> f32 {
        self.clips.iter().map(|c| c.sound.duration_secs()).sum()
    }

    /// The same with other samples.
    fn changed(&self, name: &'static str, change: impl Fn(&[f32]) -> Vec<f32>) -> Self {
        let clips = self.clips.iter().map(|clip| Clip {
            sound: Sound::new(
                &change(&clip.sound.samples),
                articula_speech::SAMPLE_RATE_HZ,
            ),
            segments: clip.segments.clone(),
            phones: clip.phones.clone(),
        });
        Self {
            name,
            clips: clips.collect(),
        }
    }
}

/// The recordings of the repository, these changed, and those of a folder.
pub(super) fn of_people(folder: Option<&Path>) -> Result<Vec<Set>> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/speech");
    let own = Set::of_clips(PEOPLE, recordings(&own)?);
    let gain = 10f32.powf(-26.0 / 20.0);
    let soft = own.changed(SOFT, |samples| samples.iter().map(|s| s * gain).collect());
    let noisy = own.changed(NOISY, |samples| {
        let power = samples.iter().map(|s| s * s).sum::<f32>() / samples.len().max(1) as f32;
        let deviation = power.sqrt() * 10f32.powf(-15.0 / 20.0);
        let mut random = Random(1);
        samples
            .iter()
            .map(|s| s + deviation * random.normal())
            .collect()
    });
    let mut sets = vec![own, soft, noisy];
    if let Some(folder) = folder {
        sets.push(Set::of_clips(OTHERS, recordings(folder)?));
    }
    Ok(sets)
}

/// All `NAME.wav` of a folder with the `NAME.lab` or `NAME.TextGrid` beside it, in the order of names.
fn recordings(folder: &Path) -> Result<Vec<Clip>> {
    let context = || folder.display().to_string();
    let entries = std::fs::read_dir(folder).with_context(context)?;
    let mut paths = Vec::new();
    for entry in entries {
        let path = entry.with_context(context)?.path();
        if path.extension().is_some_and(|e| e == "wav") {
            paths.push(path);
        }
    }
    paths.sort();
    let mut clips = Vec::new();
    for path in paths {
        let times = ["lab", "TextGrid"].map(|extension| path.with_extension(extension));
        let Some(times) = times.into_iter().find(|times| times.is_file()) else {
            eprintln!("{}: no .lab or .TextGrid beside it", path.display());
            continue;
        };
        let read = |path: &Path| std::fs::read(path).with_context(|| path.display().to_string());
        let sound = Sound::from_wav(&read(&path)?).with_context(|| path.display().to_string())?;
        let phones =
            read_phone_times(&read(&times)?).with_context(|| times.display().to_string())?;
        clips.push(Clip {
            sound,
            segments: segments(&phones),
            phones,
        });
    }
    Ok(clips)
}
