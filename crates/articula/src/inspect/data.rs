//! Contents of MPEG-4 data files: parameters, their ranges and units.

use super::{
    AccessUnitsInspection, FaceInspection, MotionStreamInspection, TrackInspection,
    WarningInspection,
};
use crate::open::{Data, DataFile, DataFormat};
use articula_core::arkit_table::{BLEND_SHAPES, BlendShape};
use articula_core::fap_table::{FAP_COUNT, GROUPS, TABLE};
use articula_formats::live_link::LiveLinkClip;
use articula_formats::mpeg4::epf::EpfFrame;
use articula_formats::mpeg4::fap::FapClip;
use articula_formats::mpeg4::fdp::{self, FdpFile};
use serde::Serialize;

/// Contents of a data file. The fields common to all inspections come first; there is no skeleton
/// and no mesh.
#[derive(Debug, Default, Serialize)]
pub struct DataInspection {
    /// Name of the file, as in errors.
    pub file: String,
    /// Name of the format.
    pub format: &'static str,
    /// FAP files: name of the clip. Empty for other files.
    pub name: String,
    /// Size of the file in bytes.
    pub bytes: usize,
    skeletons: [(); 0],
    /// Motion of a FAP file.
    pub clips: Vec<DataClip>,
    meshes: [(); 0],
    /// Face animation data.
    pub face: Option<FaceInspection>,
    /// FAP files: groups of parameters.
    pub groups: Vec<FapGroup>,
    /// FAP files: parameters that the masks select. FDP files: parameters that move a vertex.
    pub parameters: Vec<FapParameter>,
    /// FDP files: neutral distances of the face, in the unit of its mesh.
    pub fapu: Option<FaceUnits>,
    /// FDP files: feature points.
    pub points: Vec<FeaturePointInspection>,
    /// CSV captures: blend shapes that have a column.
    pub shapes: Vec<CaptureShape>,
    /// EPF files: encoder settings.
    pub coding: Option<EncoderSettings>,
    /// AFP streams: how they can be cut.
    pub stream: Option<FaceStreamInspection>,
    /// Tracks of an MP4 file; left out of others.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tracks: Vec<TrackInspection>,
    /// Warnings.
    pub warnings: Vec<WarningInspection>,
}

/// How a face stream can be cut, by its profile.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum FaceStreamInspection {
    /// AFP-1 ([`inspect_access_units`](super::inspect_access_units)).
    Afp1(AccessUnitsInspection),
    /// AFP-2 ([`inspect_motion_stream`](super::inspect_motion_stream)).
    Afp2(Box<MotionStreamInspection>),
}

/// Motion of a FAP file.
#[derive(Debug, Serialize)]
pub struct DataClip {
    /// Name of the clip.
    pub name: String,
    /// Duration, in seconds.
    pub duration_secs: f32,
    /// Frames per second.
    pub fps: f32,
    /// Number of frames.
    pub frames: usize,
    /// Number of animated joints, always 0.
    pub joints_animated: usize,
}

/// A group of facial animation parameters.
#[derive(Debug, Serialize)]
pub struct FapGroup {
    /// Name of the group.
    pub name: &'static str,
    /// Number of parameters that the masks select.
    pub faps: usize,
    /// Number of them that are not always neutral.
    pub moving: usize,
}

/// A facial animation parameter.
#[derive(Debug, Serialize)]
pub struct FapParameter {
    /// Number in the standard, 1 to 68.
    pub fap: usize,
    /// Name in the standard.
    pub name: &'static str,
    /// Name of its group.
    pub group: &'static str,
    /// Unit in the standard; null for visemes and expressions.
    pub unit: Option<String>,
    /// Minimum value; null if the parameter has several values.
    pub min: Option<i32>,
    /// Maximum value; null if the parameter has several values.
    pub max: Option<i32>,
    /// Whether the parameter is not always neutral, or moves a vertex.
    pub moves: bool,
}

/// Neutral distances of a face, in the unit of its mesh.
#[derive(Debug, Serialize)]
pub struct FaceUnits {
    /// Distance between eyes and nose.
    #[serde(rename = "ENS0")]
    pub ens0: f32,
    /// Distance between the eyes.
    #[serde(rename = "ES0")]
    pub es0: f32,
    /// Diameter of the iris.
    #[serde(rename = "IRISD0")]
    pub irisd0: f32,
    /// Distance between mouth and nose.
    #[serde(rename = "MNS0")]
    pub mns0: f32,
    /// Width of the mouth.
    #[serde(rename = "MW0")]
    pub mw0: f32,
}

/// A feature point of a face.
#[derive(Debug, Serialize)]
pub struct FeaturePointInspection {
    /// Number in the standard, such as `3.5`.
    pub point: String,
    /// Number of vertices in its zone.
    pub vertices: usize,
    /// Numbers of the parameters that move it.
    pub faps: Vec<usize>,
}

/// A blend shape of a capture.
#[derive(Debug, Serialize)]
pub struct CaptureShape {
    /// Name in ARKit.
    pub name: &'static str,
    /// Minimum weight.
    pub min: f32,
    /// Maximum weight.
    pub max: f32,
}

/// Settings of an encoder.
#[derive(Debug, Serialize)]
pub struct EncoderSettings {
    /// Number of frames.
    pub frames: usize,
    /// Number of intra-coded frames.
    pub intra: usize,
    /// Number of frames that code the face.
    pub face: usize,
    /// Number of frames that code the body.
    pub body: usize,
    /// Frames per second, if given.
    pub fps: Option<f32>,
    /// Coarsest quantiser, if given.
    pub quantiser_max: Option<i32>,
}

/// Summarises a data file.
pub fn inspect_data(opened: DataFile, file: &str, format: DataFormat) -> DataInspection {
    let found = match &opened.data {
        Data::Fap(clip) => of_fap(clip),
        Data::LiveLink(capture) => of_capture(capture),
        Data::Epf(frames) => of_epf(frames),
        Data::Fdp(face) => of_fdp(face),
    };
    let warning = |w: articula_formats::Warning| WarningInspection {
        at: w.at,
        what: w.what,
    };
    DataInspection {
        file: file.to_owned(),
        format: format.name(),
        bytes: opened.bytes,
        warnings: opened.warnings.into_iter().map(warning).collect(),
        ..found
    }
}

fn of_fap(clip: &FapClip) -> DataInspection {
    let ends = clip.frames.first().zip(clip.frames.last());
    let moving = clip.moving();
    let mut first = 0;
    let mut groups = Vec::new();
    for (name, count) in GROUPS {
        let range = first..first + count;
        groups.push(FapGroup {
            name,
            faps: clip.coded[range.clone()].iter().filter(|c| **c).count(),
            moving: moving[range].iter().filter(|m| **m).count(),
        });
        first += count;
    }
    let coded = (0..FAP_COUNT).filter(|index| clip.coded[*index]);
    let parameters: Vec<FapParameter> = coded
        .map(|index| parameter(index, clip.range(index + 1), moving[index]))
        .collect();
    DataInspection {
        name: clip.name.clone(),
        clips: vec![DataClip {
            name: clip.name.clone(),
            duration_secs: ends.map_or(0.0, |(a, b)| (b.number - a.number) as f32 / clip.rate_hz),
            fps: clip.rate_hz,
            frames: clip.frames.len(),
            joints_animated: 0,
        }],
        face: face(parameters.len()),
        groups,
        parameters,
        ..DataInspection::default()
    }
}

fn parameter(index: usize, range: Option<(i32, i32)>, moves: bool) -> FapParameter {
    let fap = &TABLE[index];
    FapParameter {
        fap: index + 1,
        name: fap.name,
        group: GROUPS[usize::from(fap.group) - 1].0,
        unit: fap.action.map(|action| action.unit.to_string()),
        min: range.map(|(min, _)| min),
        max: range.map(|(_, max)| max),
        moves,
    }
}

fn of_fdp(file: &FdpFile) -> DataInspection {
    let moved = file.moved();
    let units = file.fapu;
    let point = |p: &fdp::FeaturePoint| FeaturePointInspection {
        point: format!("{}.{}", p.point.0, p.point.1),
        vertices: p.zone.len(),
        faps: p.influences.iter().map(|i| i.fap).collect(),
    };
    let parameters = (0..FAP_COUNT).filter(|index| moved[*index]);
    let parameters: Vec<FapParameter> = parameters.map(|i| parameter(i, None, true)).collect();
    DataInspection {
        face: face(parameters.len()),
        parameters,
        fapu: Some(FaceUnits {
            ens0: units.ens0,
            es0: units.es0,
            irisd0: units.irisd0,
            mns0: units.mns0,
            mw0: units.mw0,
        }),
        points: file.points.iter().map(point).collect(),
        ..DataInspection::default()
    }
}

fn of_capture(capture: &LiveLinkClip) -> DataInspection {
    let shape = |(index, entry): (usize, &BlendShape)| {
        let weights = capture.frames.iter().map(|f| f.shapes[index]);
        CaptureShape {
            name: entry.name,
            min: weights.clone().fold(f32::INFINITY, f32::min),
            max: weights.fold(f32::NEG_INFINITY, f32::max),
        }
    };
    let known = BLEND_SHAPES.iter().enumerate();
    let known = known.filter(|(index, _)| capture.has_shapes[*index]);
    let shapes = if capture.frames.is_empty() {
        Vec::new()
    } else {
        known.map(shape).collect()
    };
    DataInspection {
        clips: vec![DataClip {
            name: String::new(),
            duration_secs: capture.frames.last().map_or(0.0, |f| f.secs as f32),
            fps: capture.rate_hz as f32,
            frames: capture.frames.len(),
            joints_animated: 0,
        }],
        shapes,
        ..DataInspection::default()
    }
}

fn of_epf(frames: &[EpfFrame]) -> DataInspection {
    let count = |is: fn(&EpfFrame) -> bool| frames.iter().filter(|f| is(f)).count();
    let quantisers = frames
        .iter()
        .flat_map(|f| [f.face.quantiser, f.body.quantiser]);
    DataInspection {
        coding: Some(EncoderSettings {
            frames: frames.len(),
            intra: count(|f| f.intra == Some(true)),
            face: count(|f| f.carries_face),
            body: count(|f| f.carries_body),
            fps: frames.iter().find_map(|f| f.rate_hz),
            quantiser_max: quantisers.flatten().max(),
        }),
        ..DataInspection::default()
    }
}

fn face(faps: usize) -> Option<FaceInspection> {
    Some(FaceInspection {
        faps,
        morphs: 0,
        driven_by: None,
    })
}
