//! A clip of facial animation parameters as a clip of a character.

use super::capture;
use super::controls::{FaceControls, FaceKind};
use super::frames::{face_frames, moving};
use super::levels::FaceLevelReport;
#[cfg(feature = "speech")]
use super::named::NamedTarget;
use super::rig::{CaptureBridge, FaceColumns, FaceRig, GENERIC_BRIDGE, weight_of};
use super::turns::turns;
use crate::error::{Context, Error, Result};
use crate::open::{CharacterFile, ClipProvenance, FittedClip};
use articula_build::bake;
use articula_build::face::{FaceFrames, FapValues, ShownFace};
use articula_core::fap_table::{LOW_FAP_COUNT, LOW_FAPS, TABLE, unit_mm};
use articula_core::source::RawClip;
use articula_formats::live_link::LiveLinkClip;
use articula_formats::mpeg4::fap::{FapClip, FapFrame};
use serde::Serialize;
use std::borrow::Cow;
use std::path::Path;

/// A clip made for a character's face.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedFace {
    /// The clip; [`CharacterFile::put_clips`] adds it.
    pub fitted: FittedClip,
    /// How well it shows the parameters.
    pub report: FaceTransfer,
}

/// How well a character's face shows the parameters of a FAP clip.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceTransfer {
    /// Name of the FAP file.
    pub file: String,
    /// Name of the clip on the character.
    pub name: String,
    /// The level of articulation at which the clip was shown; `None` for all parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<FaceLevelReport>,
    /// Duration in seconds.
    pub duration_secs: f32,
    /// Number of frames.
    pub frames: usize,
    /// What drives the face.
    pub kind: FaceKind,
    /// How the effect of its controls is known.
    pub columns: FaceColumns,
    /// Number of the face's morph targets or expressions whose effect is known, or of the parts of its
    /// table that joints show.
    pub controls: usize,
    /// Number of them that the clip moves.
    pub controls_moved: usize,
    /// Names of the joints of head and eyes that it turns.
    pub joints: Vec<String>,
    /// Number of parameters that move in the clip, visemes and expressions as low-level ones.
    pub faps_moving: usize,
    /// Moving parameters that nothing of the face shows.
    pub not_driven: Vec<NotDriven>,
    /// Of a face driven by joints: how closely they follow its face animation table; empty otherwise.
    pub shown: Vec<ShownParameter>,
    /// Mean over frames and driven parameters of their errors, in millimetres on an average face.
    pub error_mm_mean: f32,
    /// Greatest error of a driven parameter.
    pub error_mm_max: f32,
    /// Number of the parameter that has it.
    pub error_fap: Option<usize>,
    /// Time at which it has it, in seconds.
    pub error_at_secs: f32,
}

/// A parameter that joints show.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShownParameter {
    /// Number of the parameter.
    pub fap: usize,
    /// Share of the squared displacements of the face animation table that joints show, percent.
    pub percent: f32,
}

/// A parameter that nothing of a face shows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NotDriven {
    /// Number of the parameter.
    pub fap: usize,
    /// Name in the standard.
    pub name: &'static str,
    /// Its greatest value in the clip, in millimetres on an average face.
    pub mm: f32,
}

impl ShownParameter {
    /// The moving parameters that joints show.
    fn of(controls: &FaceControls, moving: &[bool; LOW_FAP_COUNT]) -> Vec<Self> {
        let shares = controls.shares().iter();
        shares
            .filter(|(fap, _)| moving[fap - LOW_FAPS.start()])
            .map(|(fap, share)| Self {
                fap: *fap,
                percent: 100.0 * share,
            })
            .collect()
    }
}

impl NotDriven {
    fn of(fap: usize, values: &[FapValues]) -> Self {
        let largest = values
            .iter()
            .fold(0.0, |most, v| v.get(fap).abs().max(most));
        Self {
            fap,
            name: TABLE[fap - 1].name,
            mm: largest * unit_mm(fap),
        }
    }
}

/// Transfers a FAP clip to the face of a character, which is not changed.
///
/// The face's morph targets with names of ARKit's blend shapes are driven, or its VRM expressions, or
/// joints below its head;
/// head and eyes turn by joints. Each frame gets the weights, between 0 and 1, that show the
/// parameters most closely in millimetres (`docs/methods/faces.md`). `file` names the clip's file.
///
/// # Errors
/// [`Error::Unsupported`] if the clip has no frame or nothing of the character's face is known, and
/// an error as from [`bake`] if an expression refers to something that does not exist or the clip
/// would exceed the memory limit.
pub fn fit_face(clip: &FapClip, file: &str, character: &CharacterFile) -> Result<FittedFace> {
    let Some(first) = clip.frames.first() else {
        return Err(Error::unsuited("the file has no frame")).context(file);
    };
    let rig = FaceRig::new(character)?;
    let bridge = rig.bridge(clip.bridge.as_deref());
    let frames = face_frames(clip);
    let values: Vec<FapValues> = (0..frames.low.len()).map(|f| frames.values(f)).collect();
    let time = |frame: &FapFrame| (frame.number - first.number) as f32 / clip.rate_hz;
    let times: Vec<f32> = clip.frames.iter().map(time).collect();
    let mut solver = bridge.solver(frames.counted());
    let shown = values.iter().map(|v| solver.solve(v)).collect();
    let motion = FaceMotion {
        from: clip.name.clone(),
        times,
        values,
        shown,
        columns: rig.columns(clip.bridge.as_deref()),
    };
    fitted(motion, file, character, &rig.controls)
}

/// Transfers a capture of blend shapes to the face of a character, as [`fit_face`] does. A face with
/// these shapes gets their weights as they are.
///
/// # Errors
/// As [`fit_face`].
pub fn fit_capture(
    capture: &LiveLinkClip,
    file: &str,
    character: &CharacterFile,
) -> Result<FittedFace> {
    if capture.frames.is_empty() {
        return Err(Error::unsuited("the capture has no row")).context(file);
    }
    let rig = FaceRig::new(character)?;
    let controls = &rig.controls;
    let generic = CaptureBridge::generic();
    let rows = capture.frames.iter();
    let values: Vec<FapValues> = rows.map(|f| capture::row_values(&generic, f)).collect();
    let shown = match controls.shapes(character.character()) {
        Some(shapes) => {
            let rows = capture.frames.iter();
            rows.map(|frame| ShownFace {
                weights: shapes
                    .iter()
                    .map(|s| weight_of(*s, &frame.shapes).clamp(0.0, 1.0))
                    .collect(),
                error_mm: [0.0; LOW_FAP_COUNT],
            })
            .collect()
        }
        None => {
            let frames = FaceFrames {
                high: vec![FapValues::default(); values.len()],
                low: values.clone(),
            };
            let bridge = rig.bridge(Some(GENERIC_BRIDGE));
            let mut solver = bridge.solver(frames.counted());
            values.iter().map(|v| solver.solve(v)).collect()
        }
    };
    let motion = FaceMotion {
        from: String::new(),
        times: capture.frames.iter().map(|f| f.secs as f32).collect(),
        values,
        shown,
        columns: rig.columns(Some(GENERIC_BRIDGE)),
    };
    fitted(motion, file, character, controls)
}

/// Weights of named controls over time, with the parameters that they and the turn of the head amount to.
#[cfg(feature = "speech")]
pub(crate) struct NamedMotion {
    pub(crate) times_secs: Vec<f32>,
    pub(crate) values: Vec<FapValues>,
    /// For each frame, the weight of each control.
    pub(crate) weights: Vec<Vec<f32>>,
}

/// Drives named controls of a character, of at least one, by weights of their own; joints turn head and eyes.
#[cfg(feature = "speech")]
pub(crate) fn fit_named(
    motion: NamedMotion,
    named: &[NamedTarget],
    file: &str,
    character: &CharacterFile,
) -> Result<FittedFace> {
    let shown = motion.weights.into_iter().map(|weights| ShownFace {
        weights,
        error_mm: [0.0; LOW_FAP_COUNT],
    });
    let motion = FaceMotion {
        from: String::new(),
        times: motion.times_secs,
        values: motion.values,
        shown: shown.collect(),
        columns: FaceColumns::Generic,
    };
    fitted(motion, file, character, &FaceControls::of_named(named))
}

/// Values and weights of each frame of a face clip.
struct FaceMotion {
    /// Name of the clip in its file.
    from: String,
    times: Vec<f32>,
    values: Vec<FapValues>,
    shown: Vec<ShownFace>,
    columns: FaceColumns,
}

/// The clip and the report.
fn fitted(
    motion: FaceMotion,
    file: &str,
    character: &CharacterFile,
    controls: &FaceControls,
) -> Result<FittedFace> {
    let FaceMotion {
        from,
        times,
        values,
        shown,
        columns,
    } = motion;
    let bridge = controls.bridge();
    let moving = moving(&values);
    let eyes = !(23..=26).any(|fap| bridge.moves(fap));
    let mut turns = turns(character, eyes);
    turns.retain(|turn| turn.moves(&values));

    let is_driven = |fap: usize| bridge.moves(fap) || turns.iter().any(|t| t.has(fap));
    let not_driven = LOW_FAPS.filter(|fap| moving[fap - LOW_FAPS.start()] && !is_driven(*fap));
    let not_driven = not_driven.map(|fap| NotDriven::of(fap, &values));
    let judged: Vec<usize> = LOW_FAPS
        .filter(|fap| moving[fap - LOW_FAPS.start()] && bridge.moves(*fap))
        .collect();
    let errors = Errors::of(&judged, &shown, &times);
    let stem = Path::new(file).file_stem().unwrap_or_default();
    let name = stem.to_string_lossy().into_owned();
    let report = FaceTransfer {
        file: file.to_owned(),
        name: name.clone(),
        level: None,
        duration_secs: times.last().copied().unwrap_or(0.0),
        frames: times.len(),
        kind: controls.kind(),
        columns,
        controls: controls.len(),
        controls_moved: (0..controls.len())
            .filter(|c| shown.iter().any(|s| s.weights[*c] != 0.0))
            .count(),
        joints: turns.iter().map(|turn| turn.name(character)).collect(),
        faps_moving: moving.iter().filter(|m| **m).count(),
        not_driven: not_driven.collect(),
        shown: ShownParameter::of(controls, &moving),
        error_mm_mean: errors.mean_mm,
        error_mm_max: errors.max_mm,
        error_fap: errors.fap,
        error_at_secs: errors.at_secs,
    };

    let weights: Vec<Vec<f32>> = shown.into_iter().map(|s| s.weights).collect();
    let mut channels = controls.channels(character.character(), &times, &weights);
    let morph_channels = channels.len();
    channels.extend(turns.iter().map(|turn| turn.channel(&times, &values)));
    let made = RawClip {
        name: name.clone(),
        duration_secs: report.duration_secs,
        channels,
    };
    let made = match bake(character.character(), &made).context(character.name())? {
        Cow::Owned(baked) => baked,
        Cow::Borrowed(_) => made,
    };
    let fit = ClipProvenance {
        resampling: None,
        name,
        file: file.to_owned(),
        from,
        morph_channels,
        retargeted: None,
        by_name: None,
    };
    Ok(FittedFace {
        fitted: FittedClip { clip: made, fit },
        report,
    })
}

/// Errors of the parameters that a face shows.
#[derive(Default)]
struct Errors {
    mean_mm: f32,
    max_mm: f32,
    /// Number of the parameter with the greatest error, and its time.
    fap: Option<usize>,
    at_secs: f32,
}

impl Errors {
    /// Those of some parameters, by their numbers, over all frames.
    fn of(faps: &[usize], shown: &[ShownFace], times_secs: &[f32]) -> Self {
        let mut errors = Self::default();
        let mut sum = 0.0;
        for (face, time) in shown.iter().zip(times_secs) {
            for fap in faps {
                let error = face.error_mm[fap - LOW_FAPS.start()].abs();
                sum += f64::from(error);
                if error > errors.max_mm {
                    errors.max_mm = error;
                    errors.fap = Some(*fap);
                    errors.at_secs = *time;
                }
            }
        }
        errors.mean_mm = (sum / (faps.len() * shown.len()).max(1) as f64) as f32;
        errors
    }
}
