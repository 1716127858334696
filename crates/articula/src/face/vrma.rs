//! Facial animation parameters as a VRM animation of preset expressions, and back.

use super::capture::CaptureReport;
use super::frames::{face_frames, file_name, moving, rounded};
use super::rig::GENERIC_BRIDGE;
use crate::error::{Error, Result};
use articula_build::face::{FaceBridge, FapValues, vrm_preset};
use articula_build::sampling_rate_hz;
use articula_core::fap_table::{FAP_COUNT, LOW_FAPS};
use articula_core::source::{Channel, Character, Property, RawClip, evaluate};
use articula_formats::gltf::Document;
use articula_formats::mpeg4::fap::{FapClip, FapFrame};

/// The presets of VRM 1.0 that show parameters; `blink` is both of its sides.
const PRESETS: [&str; 16] = [
    "aa",
    "ih",
    "ou",
    "ee",
    "oh",
    "blinkLeft",
    "blinkRight",
    "happy",
    "angry",
    "sad",
    "relaxed",
    "surprised",
    "lookUp",
    "lookDown",
    "lookLeft",
    "lookRight",
];

/// Turns facial animation parameters into a VRM animation: for each frame, the weights of the preset
/// expressions that show them most closely by the generic columns. Presets that the clip does not
/// move have no track.
///
/// # Errors
/// [`Error::Unsupported`] if the clip has no frame, or no preset shows anything of it.
pub fn faps_to_vrma(clip: &FapClip) -> Result<(Vec<u8>, CaptureReport)> {
    let Some(first) = clip.frames.first() else {
        return Err(Error::unsuited("the file has no frame"));
    };
    let columns: Vec<FapValues> = PRESETS.iter().filter_map(|p| vrm_preset(p)).collect();
    let bridge = FaceBridge::new(columns);
    let frames = face_frames(clip);
    let values: Vec<FapValues> = (0..frames.low.len()).map(|f| frames.values(f)).collect();
    let mut solver = bridge.solver(frames.counted());
    let solved: Vec<Vec<f32>> = values.iter().map(|v| solver.solve(v).weights).collect();
    let time = |frame: &FapFrame| (frame.number - first.number) as f32 / clip.rate_hz;
    let times: Vec<f32> = clip.frames.iter().map(time).collect();
    let tracks = PRESETS.iter().enumerate().map(|(index, name)| {
        let weights: Vec<f32> = solved.iter().map(|w| w[index]).collect();
        (*name, weights)
    });
    let tracks: Vec<(&str, Vec<f32>)> = tracks
        .filter(|(_, weights)| weights.iter().any(|w| *w > 0.0))
        .collect();
    if tracks.is_empty() {
        let what = "no preset expression of VRM shows anything of the clip";
        return Err(Error::unsuited(what));
    }
    let document = Document::from_expressions(&clip.name, &times, &tracks)?;
    let moving = moving(&values);
    let report = CaptureReport {
        frames: times.len(),
        rate_hz: clip.rate_hz,
        columns: GENERIC_BRIDGE.to_owned(),
        shapes_moving: tracks.len(),
        faps_moving: moving.iter().filter(|m| **m).count(),
        shapes: Vec::new(),
        not_shown: LOW_FAPS
            .filter(|fap| moving[fap - LOW_FAPS.start()] && !bridge.moves(*fap))
            .collect(),
    };
    Ok((document.write_glb()?, report))
}

/// Turns the preset expressions that a clip drives into parameters, by the generic columns and at a
/// rate that follows its keys; `None` if it drives none.
pub fn presets_to_faps(character: &Character, clip: &RawClip) -> Option<FapClip> {
    let tracks = clip.channels.iter().filter_map(|channel| {
        let is_one = channel.property == Property::Expression && !channel.times_secs.is_empty();
        let name = is_one.then(|| &character.expressions[channel.target].name)?;
        Some((channel, vrm_preset(name)?))
    });
    let tracks: Vec<(&Channel, FapValues)> = tracks.collect();
    if tracks.is_empty() {
        return None;
    }
    let rate_hz = sampling_rate_hz(clip, &character.skeleton);
    let count = (clip.duration_secs * rate_hz).round() as usize + 1;
    let bridge = FaceBridge::new(tracks.iter().map(|(_, column)| *column).collect());
    let frame = |number: usize| {
        let secs = number as f32 / rate_hz;
        let weight = |(channel, _): &(&Channel, FapValues)| {
            let mut value = [0.0];
            evaluate::channel(channel, secs, &mut value);
            value[0].clamp(0.0, 1.0)
        };
        let weights: Vec<f32> = tracks.iter().map(weight).collect();
        FapFrame {
            number: number as u32,
            low: rounded(&bridge.faps(&weights)),
            ..FapFrame::default()
        }
    };
    let mut made = FapClip {
        name: file_name(&clip.name),
        rate_hz,
        coded: [false; FAP_COUNT],
        frames: (0..count).map(frame).collect(),
        bridge: Some(GENERIC_BRIDGE.to_owned()),
    };
    made.coded = made.moving();
    Some(made)
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_formats::{Limits, gltf};

    #[test]
    fn a_vowel_and_a_blink_come_back() {
        let mut frames = vec![FapFrame::default(); 3];
        for (number, frame) in frames.iter_mut().enumerate() {
            frame.number = number as u32;
        }
        let mouth = vrm_preset("aa").unwrap();
        let lids = vrm_preset("blinkLeft").unwrap();
        frames[1].low = mouth.0.map(|v| v.round() as i32);
        frames[2].low = lids.0.map(|v| v.round() as i32);
        let mut clip = FapClip {
            name: "talk".to_owned(),
            rate_hz: 25.0,
            coded: [true; FAP_COUNT],
            frames,
            bridge: None,
        };
        let (bytes, report) = faps_to_vrma(&clip).unwrap();
        assert_eq!(report.frames, 3);
        let file = gltf::read(
            &bytes,
            &Limits::default(),
            &mut |_: &str| Err(String::new()),
        );
        let character = file.unwrap().value.character;
        let back = presets_to_faps(&character, &character.clips[0]).unwrap();
        assert_eq!((back.rate_hz, back.frames.len()), (25.0, 3));
        for (frame, wanted) in [(1, mouth), (2, lids)] {
            for fap in LOW_FAPS {
                let found = back.frames[frame].low[fap - 3] as f32;
                // The solver prefers small weights a little.
                let off = 3.0 + 0.06 * wanted.get(fap).abs();
                assert!(
                    (found - wanted.get(fap)).abs() <= off,
                    "{frame}, FAP {fap}: {found}"
                );
            }
        }
        clip.frames.truncate(1);
        assert!(faps_to_vrma(&clip).is_err());
    }
}
