//! What is in files of MPEG-4 without a character: what moves, in which range, in which units.

use super::{Face, Warning};
use crate::open::{Data, DataFile, DataFormat};
use articula_core::fap_table::{FAPS, GROUPS, TABLE};
use articula_formats::mpeg4::epf::EpfFrame;
use articula_formats::mpeg4::fap::FapClip;
use articula_formats::mpeg4::fdp::{self, FdpFile};
use serde::Serialize;

/// What was found. The fields that every `inspect` has come first; a file of data has no
/// skeleton and no mesh.
#[derive(Debug, Default, Serialize)]
pub struct DataInspection {
    /// The file, as errors call it.
    pub file: String,
    /// Name of the format.
    pub format: &'static str,
    /// Its name.
    pub name: String,
    /// Length of the file.
    pub bytes: usize,
    skeletons: [(); 0],
    /// The motion of a FAP file.
    pub clips: Vec<DataClip>,
    meshes: [(); 0],
    /// What there is to animate a face with.
    pub face: Option<Face>,
    /// Of a FAP file: groups of parameters.
    pub groups: Vec<FapGroup>,
    /// Of a FAP file: the parameters that its masks name. Of an FDP file: those that move some vertex.
    pub parameters: Vec<FapParameter>,
    /// Of an FDP file: neutral distances of the face, in the unit of its mesh.
    pub fapu: Option<FaceUnits>,
    /// Of an FDP file: its feature points.
    pub points: Vec<FeaturePoint>,
    /// Of an EPF file.
    pub coding: Option<EncoderSettings>,
    /// What is odd.
    pub warnings: Vec<Warning>,
}

/// The motion of a FAP file.
#[derive(Debug, Serialize)]
pub struct DataClip {
    /// Its name.
    pub name: String,
    /// Length, seconds.
    pub duration_secs: f32,
    /// Frames a second.
    pub fps: f32,
    /// Frames.
    pub frames: usize,
    /// Joints that move: none.
    pub joints_animated: usize,
}

/// A group of facial animation parameters.
#[derive(Debug, Serialize)]
pub struct FapGroup {
    /// Its name.
    pub name: &'static str,
    /// Parameters that masks name.
    pub faps: usize,
    /// Those of them that are not neutral all the time.
    pub moving: usize,
}

/// A facial animation parameter.
#[derive(Debug, Serialize)]
pub struct FapParameter {
    /// Number, 1 to 68.
    pub fap: usize,
    /// Its name.
    pub name: &'static str,
    /// Group of the parameter.
    pub group: &'static str,
    /// Unit of the standard, or null for visemes and expressions.
    pub unit: Option<String>,
    /// Smallest value; null where there is no single one.
    pub min: Option<i32>,
    /// Largest value; null where there is no single one.
    pub max: Option<i32>,
    /// Whether it is not neutral all the time, or moves some vertex.
    pub moves: bool,
}

/// Neutral distances of a face, in the unit of its mesh.
#[derive(Debug, Serialize)]
pub struct FaceUnits {
    /// Between eyes and nose.
    #[serde(rename = "ENS0")]
    pub ens0: f32,
    /// Between the eyes.
    #[serde(rename = "ES0")]
    pub es0: f32,
    /// Diameter of the iris.
    #[serde(rename = "IRISD0")]
    pub irisd0: f32,
    /// Between mouth and nose.
    #[serde(rename = "MNS0")]
    pub mns0: f32,
    /// Width of the mouth.
    #[serde(rename = "MW0")]
    pub mw0: f32,
}

/// A feature point of a face.
#[derive(Debug, Serialize)]
pub struct FeaturePoint {
    /// Number in the standard, such as `3.5`.
    pub point: String,
    /// Vertices in its zone.
    pub vertices: usize,
    /// Parameters that move it.
    pub faps: Vec<usize>,
}

/// What an encoder is told.
#[derive(Debug, Serialize)]
pub struct EncoderSettings {
    /// Frames.
    pub frames: usize,
    /// Frames coded alone.
    pub intra: usize,
    /// Frames that code the face.
    pub face: usize,
    /// Frames that code the body.
    pub body: usize,
    /// Frames a second, if the file says it.
    pub fps: Option<f32>,
    /// Coarsest quantiser, if the file names one.
    pub quantiser_max: Option<i32>,
}

/// Looks at a file of data.
pub fn inspect_data(opened: DataFile, file: &str, format: DataFormat) -> DataInspection {
    let found = match &opened.data {
        Data::Fap(clip) => of_fap(clip),
        Data::Epf(frames) => of_epf(frames),
        Data::Fdp(face) => of_fdp(face),
    };
    let warning = |w: articula_formats::Warning| Warning {
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
    let coded = (0..FAPS).filter(|index| clip.coded[*index]);
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
    let point = |p: &fdp::FeaturePoint| FeaturePoint {
        point: format!("{}.{}", p.point.0, p.point.1),
        vertices: p.zone.len(),
        faps: p.influences.iter().map(|i| i.fap).collect(),
    };
    let parameters = (0..FAPS).filter(|index| moved[*index]);
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

fn face(faps: usize) -> Option<Face> {
    Some(Face { faps, morphs: 0 })
}
