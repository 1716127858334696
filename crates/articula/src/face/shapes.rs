//! Morph targets for a face, made from its feature points: the blend shapes of ARKit for one without
//! any, or a face animation table.

use super::around::Around;
use super::found::FoundFace;
use super::named::{NamedTarget, named_controls};
use super::targets::{Existing, add_targets};
use crate::error::{Context, Error, Result};
use crate::figure::Figure;
use crate::open::CharacterFile;
use articula_build::face::{
    FacePoints, FaceTable, FapInterval, FapValues, MouthChart, MouthMotions, SkinFolds, blend_shape,
};
use articula_core::arkit_table::BLEND_SHAPES;
use articula_core::face_control::FaceControl;
use articula_core::fap_table::LOW_FAPS;
use articula_core::feature_points::PointId;
use glam::Vec3;
use serde::Serialize;

/// Share of the values of `cheekPuff` that its shape shows. They are 24 mm on an average face; the own
/// shapes of faces puff the cheeks by 4 to 6 mm.
const PUFF: f32 = 0.25;
/// The same of brows, whose values are 13 to 17 mm; those of faces go by 5 to 9 mm.
const BROWS: f32 = 0.45;

/// Shares of the opening by which the upper lid goes down and the lower one up, of shapes of the eyes: the mean of what
/// the own shapes of ICT-FaceKit and of the woman of MakeHuman show. Lids follow the gaze.
const LIDS: [(&str, [f32; 2]); 5] = [
    ("eyeBlink", [1.0, 0.0]),
    ("eyeLookDown", [0.5, -0.1]),
    ("eyeLookUp", [-0.23, 0.19]),
    ("eyeSquint", [0.0, 0.25]),
    ("eyeWide", [-0.35, 0.0]),
];
/// Those of them that move nothing but lids.
const LIDS_ALONE: [&str; 3] = ["eyeBlink", "eyeSquint", "eyeWide"];

/// Points of the inner contour of the lower and of the upper lip, across from each other.
const LIPS: [[PointId; 2]; 3] = [[(2, 3), (2, 2)], [(2, 8), (2, 6)], [(2, 9), (2, 7)]];
/// Least and greatest factor of `mouthClose`.
const CLOSES: [f32; 2] = [0.7, 1.4];

/// Blend shapes that were made for a face.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceShapes {
    /// Names in ARKit of the shapes that were made.
    pub made: Vec<&'static str>,
    /// Names of those that nothing of the face shows.
    pub not_made: Vec<&'static str>,
    /// Those that would be shown wrongly, and why.
    pub refused: Vec<RefusedShape>,
    /// Number of vertices that any of them moves.
    pub vertices: usize,
    /// Units of the face that may be wrong.
    pub doubtful: Vec<String>,
}

/// A blend shape that is not made, as it would be shown wrongly.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RefusedShape {
    /// Its name in ARKit.
    pub shape: &'static str,
    /// Why it is not made.
    pub why: String,
}

/// A face animation table that was made for a face.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceTableTargets {
    /// Numbers of the parameters that it shows.
    pub faps: Vec<usize>,
    /// Numbers of those that nothing of the face shows.
    pub not_shown: Vec<usize>,
    /// Number of morph targets, one for each interval of a parameter.
    pub targets: usize,
    /// Number of vertices that any of them moves.
    pub vertices: usize,
    /// Units of the face that may be wrong.
    pub doubtful: Vec<String>,
}

/// Adds the blend shapes of ARKit to a character without any, beside other morph targets, made by the
/// face animation table of its feature points (`docs/methods/faces.md`). `given` are points that are
/// known, with their places in model space.
///
/// # Errors
/// [`Error::Unsupported`] that names the file, if a mesh of the head has morph targets that show blend shapes, or the figure
/// shows too little of a face; the character is then unchanged.
pub fn add_face_shapes(
    opened: &mut CharacterFile,
    given: &[(PointId, Vec3)],
) -> Result<FaceShapes> {
    add_face_shapes_by(opened, given, &MouthMotions::stored())
}

/// As [`add_face_shapes`], with the lower face by other motions than those that are kept with the program.
///
/// # Errors
/// As [`add_face_shapes`].
pub fn add_face_shapes_by(
    opened: &mut CharacterFile,
    given: &[(PointId, Vec3)],
    motions: &MouthMotions,
) -> Result<FaceShapes> {
    made_shapes(opened, given, motions).with_context(|| opened.name().to_owned())
}

/// Adds a face animation table to a character, as morph targets named by parameter and interval
/// ([`FapInterval`]). Those that its meshes have stay, but FAP clips drive the table from then on.
///
/// # Errors
/// [`Error::Unsupported`] that names the file, if the figure shows too little of a face; the character
/// is then unchanged.
pub fn add_face_table(
    opened: &mut CharacterFile,
    given: &[(PointId, Vec3)],
) -> Result<FaceTableTargets> {
    made_table(opened, given).with_context(|| opened.name().to_owned())
}

fn made_shapes(
    opened: &mut CharacterFile,
    given: &[(PointId, Vec3)],
    motions: &MouthMotions,
) -> Result<FaceShapes> {
    let figure = Figure::new(opened.clone())?;
    let face = FoundFace::of(&figure, given)?;
    let around = Around::of(&figure, &face.head, face.points.height());
    let vertices = figure.in_character(&around.head.vertices)?;
    let table = face.table()?;
    let chart = MouthChart::new(&face.head.surface, &face.points);
    let folds = SkinFolds::of(&face.head.surface, &face.points);
    let measured = |name: &str| motions.displacements(name, chart.as_ref()?, &folds, &table);
    let of_table = |name: &str| {
        let mut moved = table.displacements(&parameters(name));
        folds.unfold(&mut moved);
        moved
    };
    let mut shapes: Vec<(String, Vec<Vec3>)> = Vec::new();
    let (mut made, mut not_made, mut refused) = (Vec::new(), Vec::new(), Vec::new());
    let mut jaw = Vec::new();
    for shape in &BLEND_SHAPES {
        if let Some(why) = without_lids(&table, shape.name) {
            let shape = shape.name;
            refused.push(RefusedShape { shape, why });
            continue;
        }
        let mut offsets = measured(shape.name).unwrap_or_else(|| of_table(shape.name));
        match shape.name {
            "jawOpen" => jaw.clone_from(&offsets),
            "mouthClose" => {
                let factor = closing(&face.points, &jaw, &offsets);
                offsets.iter_mut().for_each(|o| *o *= factor);
            }
            _ => {}
        }
        if offsets.iter().all(|o| *o == Vec3::ZERO) {
            not_made.push(shape.name);
            continue;
        }
        made.push(shape.name);
        shapes.push((shape.name.to_owned(), around.displacements(offsets)));
    }
    let existing = if shows_shapes(opened) {
        Existing::Refused
    } else {
        Existing::Kept
    };
    Ok(FaceShapes {
        vertices: add_targets(opened, (&around.head, &vertices), &shapes, existing)?,
        made,
        not_made,
        refused,
        doubtful: face.doubtful(),
    })
}

/// Factor of `mouthClose` by which it undoes, as far as it can, what `jawOpen` opens between the lips.
fn closing(points: &FacePoints, jaw: &[Vec3], close: &[Vec3]) -> f32 {
    let pairs = LIPS.iter().filter_map(|pair| {
        let [lower, upper] = pair.map(|point| Some(points.get(point)?.vertex? as usize));
        let (lower, upper) = (lower?, upper?);
        let apart = |moved: &[Vec3]| Some(*moved.get(lower)? - *moved.get(upper)?);
        Some([apart(jaw)?, apart(close)?])
    });
    let (along, square) = pairs.fold((0.0, 0.0), |(along, square), [jaw, close]| {
        (along - jaw.dot(close), square + close.length_squared())
    });
    if along <= 0.0 {
        return 1.0;
    }
    let [least, most] = CLOSES;
    (along / square).clamp(least, most)
}

/// Why the lids that a blend shape moves are not moved.
fn without_lids(table: &FaceTable, shape: &str) -> Option<String> {
    if !LIDS_ALONE.iter().any(|lids| shape.starts_with(lids)) {
        return None;
    }
    let why = table.without_lids(usize::from(shape.ends_with("Right")))?;
    Some(why.to_string())
}

/// The parameters that a blend shape is made by where no head showed it.
fn parameters(shape: &str) -> FapValues {
    let mut values = blend_shape(shape).unwrap_or_default();
    if let Some((_, [down, up])) = LIDS.iter().find(|(lids, _)| shape.starts_with(lids)) {
        let side = usize::from(shape.ends_with("Right"));
        values.set(19 + side, 1024.0 * down);
        values.set(21 + side, 1024.0 * up);
    }
    let share = match shape {
        "cheekPuff" => PUFF,
        _ if shape.starts_with("brow") => BROWS,
        _ => 1.0,
    };
    values.0.iter_mut().for_each(|v| *v *= share);
    values
}

/// Whether a morph target shows a blend shape by its name; others are of identities or poses.
fn shows_shapes(opened: &CharacterFile) -> bool {
    let named = named_controls(opened.character());
    let is_shape = |n: &NamedTarget| matches!(n.control, FaceControl::Shapes(..));
    named.iter().any(|n| is_shape(n) && !n.morphs.is_empty())
}

fn made_table(opened: &mut CharacterFile, given: &[(PointId, Vec3)]) -> Result<FaceTableTargets> {
    let has_one = opened
        .character()
        .meshes
        .iter()
        .flat_map(|m| &m.morph_names);
    if has_one
        .clone()
        .any(|name| FapInterval::parse(name).is_some())
    {
        let what = "face: it has a face animation table already; leave --face-shapes=fat out";
        return Err(Error::unsuited(what));
    }
    let figure = Figure::new(opened.clone())?;
    let face = FoundFace::of(&figure, given)?;
    let vertices = figure.in_character(&face.head.vertices)?;
    let table = face.table()?;
    // Eyes with joints are turned by these.
    let turned = |fap: &usize| (23..=26).contains(fap) && face.head.surface.eyes.is_some();
    let at = |fap: usize, value: i32| table.displacements(&FapValues::alone(fap, value as f32));
    let mut shapes: Vec<(String, Vec<Vec3>)> = Vec::new();
    let mut report = FaceTableTargets {
        faps: Vec::new(),
        not_shown: Vec::new(),
        targets: 0,
        vertices: 0,
        doubtful: face.doubtful(),
    };
    for fap in LOW_FAPS.filter(|fap| !turned(fap)) {
        let intervals = table.intervals(fap);
        if intervals.is_empty() {
            report.not_shown.push(fap);
            continue;
        }
        report.faps.push(fap);
        for interval in intervals {
            let [from, to] = [interval.from, interval.to].map(|value| at(fap, value));
            let offsets = to.iter().zip(&from).map(|(to, from)| *to - *from);
            shapes.push((interval.to_string(), offsets.collect()));
        }
    }
    report.targets = shapes.len();
    report.vertices = add_targets(opened, (&face.head, &vertices), &shapes, Existing::Kept)?;
    Ok(report)
}
