//! Captures of blend shapes as facial animation parameters, and back.

use super::frames::{face_frames, file_name, moving, rounded};
use super::rig::{CaptureBridge, GENERIC_BRIDGE};
use crate::error::{Context, Error, Result};
use crate::open::CharacterFile;
use articula_build::face::{FapValues, arkit_shape};
use articula_build::sampling_rate_hz;
use articula_core::arkit_table::{BLEND_SHAPE_COUNT, BLEND_SHAPES};
use articula_core::fap_table::{ANGLE_UNIT, FAP_COUNT, LOW_FAP_COUNT, LOW_FAPS};
use articula_core::source::{Channel, Character, Property, RawClip, evaluate};
use articula_formats::live_link::{ANGLE_COUNT, LiveLinkClip, LiveLinkFrame};
use articula_formats::mpeg4::fap::{FapClip, FapFrame};
use serde::Serialize;

/// FAPs of yaw, pitch and roll of the head, with the signs of the capture's angles in them: a capture's
/// yaw is towards the right of the subject and its roll towards the left, as in Unreal's left-handed
/// space (`docs/formats/live-link.md`); FAPs are the other way round.
const HEAD: [(usize, f32); 3] = [(49, -1.0), (48, 1.0), (50, -1.0)];
/// FAPs of yaw and pitch of each eye, their columns among the angles, and the sign.
const EYES: [(usize, usize, f32); 4] = [(23, 3, -1.0), (25, 4, 1.0), (24, 6, -1.0), (26, 7, 1.0)];

/// How well parameters hold a capture, or blend shapes hold parameters.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct CaptureReport {
    /// Number of frames.
    pub frames: usize,
    /// Frames per second.
    pub rate_hz: f32,
    /// Name of the columns of the blend shapes: `generic`, or a hash of those of a face.
    pub columns: String,
    /// Number of blend shapes that move.
    pub shapes_moving: usize,
    /// Number of parameters that move.
    pub faps_moving: usize,
    /// Of a capture: moving shapes by what is lost when the parameters are turned back into shapes, the
    /// worst first.
    pub shapes: Vec<ShapeLoss>,
    /// Of parameters: numbers of those that move and that no blend shape shows.
    pub not_shown: Vec<usize>,
}

/// What a blend shape loses on the way through parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShapeLoss {
    /// Name in ARKit.
    pub name: &'static str,
    /// Mean of the error of its weight over the frames, in percent of the range.
    pub mean_percent: f32,
    /// Greatest error.
    pub max_percent: f32,
}

/// Values of the parameters of one row, not rounded.
pub(crate) fn row_values(bridge: &CaptureBridge, frame: &LiveLinkFrame) -> FapValues {
    let mut values = bridge.values(&frame.shapes);
    for ((fap, sign), angle) in HEAD.iter().zip(frame.angles) {
        values.set(*fap, sign * angle / ANGLE_UNIT);
    }
    values
}

/// Turns a capture into facial animation parameters by the columns of the blend shapes
/// (`docs/methods/faces.md`): the generic ones, or those of a face. `name` becomes that of the clip,
/// which tells the columns too.
///
/// # Errors
/// [`Error::Unsupported`] if the capture has no row.
pub fn capture_to_faps(
    capture: &LiveLinkClip,
    name: &str,
    bridge: &CaptureBridge,
) -> Result<(FapClip, CaptureReport)> {
    if capture.frames.is_empty() {
        return Err(Error::unsuited("the capture has no row"));
    }
    let mut solver = bridge.bridge().solver([true; LOW_FAP_COUNT]);
    let mut clip = FapClip {
        name: file_name(name),
        rate_hz: capture.rate_hz as f32,
        coded: [false; FAP_COUNT],
        frames: Vec::with_capacity(capture.frames.len()),
        bridge: Some(bridge.name().to_owned()),
    };
    let mut sums = [0.0_f32; BLEND_SHAPE_COUNT];
    let mut most = [0.0_f32; BLEND_SHAPE_COUNT];
    for frame in &capture.frames {
        let values = row_values(bridge, frame);
        let low = rounded(&values);
        let number = (frame.secs * capture.rate_hz).round() as u32;
        if clip.frames.last().is_some_and(|last| last.number == number) {
            clip.frames.pop();
        }
        clip.frames.push(FapFrame {
            number,
            low,
            ..FapFrame::default()
        });
        let back = solver.solve(&FapValues(low.map(|v| v as f32)));
        let back = bridge.shapes(&back.weights);
        for (shape, (a, b)) in frame.shapes.iter().zip(&back).enumerate() {
            sums[shape] += (a - b).abs();
            most[shape] = most[shape].max((a - b).abs());
        }
    }
    clip.coded = clip.moving();
    let moves = |shape: &usize| capture.frames.iter().any(|f| f.shapes[*shape] != 0.0);
    let moving: Vec<usize> = (0..BLEND_SHAPE_COUNT).filter(moves).collect();
    let mut shapes: Vec<ShapeLoss> = moving
        .iter()
        .map(|shape| ShapeLoss {
            name: BLEND_SHAPES[*shape].name,
            mean_percent: 100.0 * sums[*shape] / capture.frames.len() as f32,
            max_percent: 100.0 * most[*shape],
        })
        .collect();
    shapes.sort_by(|a, b| b.mean_percent.total_cmp(&a.mean_percent));
    let report = CaptureReport {
        frames: clip.frames.len(),
        rate_hz: clip.rate_hz,
        columns: bridge.name().to_owned(),
        shapes_moving: moving.len(),
        faps_moving: clip.moving().iter().filter(|m| **m).count(),
        shapes,
        not_shown: Vec::new(),
    };
    Ok((clip, report))
}

/// Turns facial animation parameters into a capture: for each frame, the weights of blend shapes that
/// show them most closely by the generic columns.
///
/// # Errors
/// [`Error::Unsupported`] if the clip has no frame.
pub fn faps_to_capture(clip: &FapClip) -> Result<(LiveLinkClip, CaptureReport)> {
    let Some(first) = clip.frames.first() else {
        return Err(Error::unsuited("the file has no frame"));
    };
    let bridge = CaptureBridge::generic();
    let bridge = bridge.bridge();
    let frames = face_frames(clip);
    let values: Vec<FapValues> = (0..frames.low.len()).map(|f| frames.values(f)).collect();
    let moving = moving(&values);
    let mut solver = bridge.solver(frames.counted());
    let frames = clip.frames.iter().zip(&values).map(|(frame, values)| {
        let mut shapes = [0.0; BLEND_SHAPE_COUNT];
        shapes.copy_from_slice(&solver.solve(values).weights);
        let mut angles = [0.0; ANGLE_COUNT];
        for (angle, (fap, sign)) in angles.iter_mut().zip(HEAD) {
            *angle = sign * values.get(fap) * ANGLE_UNIT;
        }
        for (fap, angle, sign) in EYES {
            angles[angle] = sign * values.get(fap) * ANGLE_UNIT;
        }
        LiveLinkFrame {
            secs: f64::from(frame.number - first.number) / f64::from(clip.rate_hz),
            shapes,
            angles,
        }
    });
    let capture = LiveLinkClip {
        rate_hz: f64::from(clip.rate_hz),
        has_shapes: [true; BLEND_SHAPE_COUNT],
        frames: frames.collect(),
    };
    let shown = |fap: &usize| bridge.moves(*fap) || HEAD.iter().any(|(head, _)| head == fap);
    let moves = |fap: &usize| moving[fap - LOW_FAPS.start()];
    let shape_moves = |shape: &usize| capture.frames.iter().any(|f| f.shapes[*shape] != 0.0);
    let report = CaptureReport {
        frames: capture.frames.len(),
        rate_hz: clip.rate_hz,
        columns: GENERIC_BRIDGE.to_owned(),
        shapes_moving: (0..BLEND_SHAPE_COUNT).filter(shape_moves).count(),
        faps_moving: moving.iter().filter(|m| **m).count(),
        shapes: Vec::new(),
        not_shown: LOW_FAPS.filter(|f| moves(f) && !shown(f)).collect(),
    };
    Ok((capture, report))
}

/// Whether a clip of a character drives morph targets or expressions with the names of blend shapes.
pub fn drives_shapes(character: &Character, clip: &RawClip) -> bool {
    !tracks(character, clip).is_empty()
}

/// The channels of a clip that drive blend shapes, with the shape of each of their values.
fn tracks<'a>(own: &Character, clip: &'a RawClip) -> Vec<(&'a Channel, Vec<Option<usize>>)> {
    let mut tracks = Vec::new();
    for channel in clip.channels.iter().filter(|c| !c.times_secs.is_empty()) {
        let shapes: Vec<Option<usize>> = match channel.property {
            Property::Weights => {
                let names = &own.meshes[channel.target].morph_names;
                names.iter().map(|n| arkit_shape(n)).collect()
            }
            Property::Expression => vec![arkit_shape(&own.expressions[channel.target].name)],
            _ => continue,
        };
        if shapes.iter().any(Option::is_some) {
            tracks.push((channel, shapes));
        }
    }
    tracks
}

/// Samples the blend shapes of a clip of a character: morph targets and expressions with their
/// names, at a rate that follows its keys.
///
/// # Errors
/// [`Error::Unsupported`] that names the file, if the clip drives none.
pub fn capture_of_clip(character: &CharacterFile, clip: &RawClip) -> Result<LiveLinkClip> {
    let tracks = tracks(character.character(), clip);
    if tracks.is_empty() {
        let what = format!(
            "clip \"{}\" drives no morph target or expression with the name of a blend shape of ARKit",
            clip.name
        );
        return Err(Error::unsuited(what)).context(character.name());
    }
    let skeleton = &character.character().skeleton;
    let rate_hz = f64::from(sampling_rate_hz(clip, skeleton));
    let count = (f64::from(clip.duration_secs) * rate_hz).round() as usize + 1;
    let mut capture = LiveLinkClip {
        rate_hz,
        has_shapes: [false; BLEND_SHAPE_COUNT],
        frames: Vec::with_capacity(count),
    };
    let known = tracks.iter().flat_map(|(_, shapes)| shapes).flatten();
    known.for_each(|shape| capture.has_shapes[*shape] = true);
    for index in 0..count {
        let secs = index as f64 / rate_hz;
        let mut shapes = [0.0_f32; BLEND_SHAPE_COUNT];
        for (channel, of) in &tracks {
            let mut values = vec![0.0; of.len()];
            evaluate::channel(channel, secs as f32, &mut values);
            for (shape, value) in of.iter().zip(values) {
                if let Some(shape) = shape {
                    // Meshes of one head share a shape, halves have the larger weight.
                    shapes[*shape] = shapes[*shape].max(value);
                }
            }
        }
        capture.frames.push(LiveLinkFrame {
            secs,
            shapes,
            angles: [0.0; ANGLE_COUNT],
        });
    }
    Ok(capture)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use proptest::prelude::*;

    /// Yaw, pitch and roll of Unreal's `FRotator` of a rotation in ARKit's space, by the conversion of
    /// quaternions and the formulas of Unreal for the angles of one.
    fn unreal_angles(arkit: Quat) -> [f32; 3] {
        let (x, y, z, w) = (-arkit.z, arkit.x, arkit.y, -arkit.w);
        [
            (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)),
            (2.0 * (z * x - w * y)).clamp(-1.0, 1.0).asin(),
            (-2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y)),
        ]
    }

    proptest! {
        #[test]
        fn the_head_turns_as_the_face_that_was_captured(
            yaw in -1.5f32..1.5, pitch in -1.2f32..1.2, roll in -1.0f32..1.0,
        ) {
            // +X is the subject's left, +Y up and +Z out of the face, in ARKit as for FAPs.
            let of = |yaw, pitch, roll| {
                Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch) * Quat::from_rotation_z(roll)
            };
            let face = of(yaw, pitch, roll);
            let mut frame = LiveLinkFrame {
                secs: 0.0,
                shapes: [0.0; BLEND_SHAPE_COUNT],
                angles: [0.0; ANGLE_COUNT],
            };
            frame.angles[..3].copy_from_slice(&unreal_angles(face));
            let values = row_values(&CaptureBridge::generic(), &frame);
            let fap = |fap: usize| values.get(fap) * ANGLE_UNIT;
            let turned = of(fap(49), fap(48), fap(50));
            prop_assert!(turned.angle_between(face) < 2e-3, "{turned} for {face}");
        }
    }

    #[test]
    fn eye_angles_and_shapes_tell_the_same_way() {
        let steps = -4..=4;
        let frames = steps.clone().map(|step| {
            let mut frame = FapFrame {
                number: (step + 4) as u32,
                ..FapFrame::default()
            };
            for fap in [23, 24, 25, 26] {
                frame.low[fap - LOW_FAPS.start()] = step * 5000;
            }
            frame
        });
        let mut clip = FapClip {
            name: "eyes".to_owned(),
            rate_hz: 30.0,
            coded: [false; FAP_COUNT],
            frames: frames.collect(),
            bridge: None,
        };
        clip.coded = clip.moving();
        let (capture, _) = faps_to_capture(&clip).unwrap();
        let shape = |name: &str| arkit_shape(name).unwrap();
        let difference = |more: &str, less: &str| -> Vec<f32> {
            let (more, less) = (shape(more), shape(less));
            capture
                .frames
                .iter()
                .map(|f| f.shapes[more] - f.shapes[less])
                .collect()
        };
        let angle = |column: usize| -> Vec<f32> {
            capture.frames.iter().map(|f| f.angles[column]).collect()
        };
        // In captures of the app both yaws fall as the eyes look to the left, and both pitches rise as
        // they look down.
        let sense = |shapes: Vec<f32>, angles: Vec<f32>| -> f32 {
            shapes.iter().zip(&angles).map(|(s, a)| s * a).sum()
        };
        assert!(sense(difference("eyeLookOutLeft", "eyeLookInLeft"), angle(3)) < -0.1);
        assert!(sense(difference("eyeLookInRight", "eyeLookOutRight"), angle(6)) < -0.1);
        assert!(sense(difference("eyeLookDownLeft", "eyeLookUpLeft"), angle(4)) > 0.1);
        assert!(sense(difference("eyeLookDownRight", "eyeLookUpRight"), angle(7)) > 0.1);
    }
}
