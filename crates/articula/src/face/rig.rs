//! What drives a face, and the parameters that each of its controls amounts to.

use super::controls::FaceControls;
use super::fields::control_fields;
use super::found::FoundFace;
use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::open::CharacterFile;
use articula_build::face::{FaceBridge, FapValues, blend_shape, opposite_controls};
use articula_core::arkit_table::{BLEND_SHAPE_COUNT, BLEND_SHAPES, BlendShape};
use articula_core::face_control::ShapeSet;
use glam::Vec3;
use serde::Serialize;

/// Name, in FAP files, of the columns that do not depend on a face.
pub const GENERIC_BRIDGE: &str = "generic";

/// Parameters whose effect is taken from the generic columns: eyeballs and tongue, whose points have
/// no vertex of the skin.
pub(super) const NOT_MEASURED: [std::ops::RangeInclusive<usize>; 2] = [23..=30, 43..=47];

/// How the parameters that a face's controls amount to are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FaceColumns {
    /// By the names of the controls, for a face of average proportions.
    Generic,
    /// By the motion of the face's own feature points.
    Measured,
    /// The controls are parts of a face animation table, or joints that show it.
    Table,
}

/// The controls of a character's face: morph targets, expressions or joints whose effect is known.
#[derive(Debug)]
pub struct FaceRig {
    pub(super) controls: FaceControls,
    /// Columns by the face's own feature points, and their name.
    own: Option<(FaceBridge, String)>,
}

impl FaceRig {
    /// Finds the controls of a character, and measures them on its face if it has feature points.
    ///
    /// # Errors
    /// [`Error::Unsupported`](crate::Error::Unsupported) that names the file, if nothing of the face
    /// is known.
    pub fn new(character: &CharacterFile) -> Result<Self> {
        let of_table = FaceControls::of(character.character()).filter(|c| c.columns().is_none());
        if let Some(controls) = of_table {
            return Ok(Self {
                controls,
                own: None,
            });
        }
        let figure = Figure::new(character.clone())?;
        let controls = FaceControls::known(&figure)?;
        if controls.columns().is_none() {
            return Ok(Self {
                controls,
                own: None,
            });
        }
        let fields = control_fields(&controls, &figure).context(character.name())?;
        Ok(Self::measured(controls, &figure, &fields))
    }

    /// As [`FaceRig::new`], of a figure; with the displacement of each of its vertices under each
    /// control.
    pub(super) fn of_figure(figure: &Figure) -> Result<(Self, Vec<Vec<Vec3>>)> {
        let controls = FaceControls::known(figure)?;
        let fields = control_fields(&controls, figure).context(figure.opened.name())?;
        Ok((Self::measured(controls, figure, &fields), fields))
    }

    fn measured(controls: FaceControls, figure: &Figure, fields: &[Vec<Vec3>]) -> Self {
        let generic = controls.columns();
        let own = generic.and_then(|columns| own(columns, fields, figure));
        let own = own.map(|columns| {
            let name = name_of(&columns);
            let opposites = controls.bridge().opposites().to_vec();
            (FaceBridge::new(columns).with_opposites(opposites), name)
        });
        Self { controls, own }
    }

    /// How the effect of the controls on a clip is known that was made by the columns of a name.
    pub fn columns(&self, made_by: Option<&str>) -> FaceColumns {
        match self.own_for(made_by) {
            _ if self.controls.columns().is_none() => FaceColumns::Table,
            Some(_) => FaceColumns::Measured,
            None => FaceColumns::Generic,
        }
    }

    /// The relation between parameters and controls for a clip that was made by the columns of a
    /// name ([`FapClip::bridge`](articula_formats::mpeg4::fap::FapClip::bridge)): the generic one for
    /// clips made by it, and the face's own for all others, if it could be measured.
    pub fn bridge(&self, made_by: Option<&str>) -> &FaceBridge {
        let own = self.own_for(made_by);
        own.map_or(self.controls.bridge(), |(own, _)| own)
    }

    /// Name of the columns by which this face turns its shapes into parameters.
    pub fn name(&self) -> &str {
        self.own.as_ref().map_or(GENERIC_BRIDGE, |(_, name)| name)
    }

    fn own_for(&self, made_by: Option<&str>) -> Option<&(FaceBridge, String)> {
        self.own
            .as_ref()
            .filter(|_| made_by != Some(GENERIC_BRIDGE))
    }

    /// The blend shapes of captures, by the columns of this face; `None` if its controls are others.
    pub fn capture_bridge(&self, character: &CharacterFile) -> Option<CaptureBridge> {
        let shapes = self.controls.shapes(character.character())?;
        Some(CaptureBridge {
            bridge: self.bridge(None).clone(),
            shapes,
            name: self.name().to_owned(),
        })
    }
}

/// The relation between the blend shapes of captures and parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct CaptureBridge {
    bridge: FaceBridge,
    /// The shapes of each control; halves of one shape follow it.
    shapes: Vec<ShapeSet>,
    name: String,
}

impl CaptureBridge {
    /// The generic columns of all 52 shapes.
    pub fn generic() -> Self {
        let column = |shape: &BlendShape| blend_shape(shape.name).unwrap_or_default();
        let shapes: Vec<ShapeSet> = (0..BLEND_SHAPE_COUNT)
            .map(|shape| ShapeSet::of([shape]))
            .collect();
        let opposites = opposite_controls(&shapes.iter().copied().map(Some).collect::<Vec<_>>());
        let bridge = FaceBridge::new(BLEND_SHAPES.iter().map(column).collect());
        Self {
            bridge: bridge.with_opposites(opposites),
            shapes,
            name: GENERIC_BRIDGE.to_owned(),
        }
    }

    /// Name of the columns, for FAP files.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The relation; its controls are not in the order of the shapes.
    pub(super) fn bridge(&self) -> &FaceBridge {
        &self.bridge
    }

    /// Values of the parameters that show weights of the shapes.
    pub(super) fn values(&self, shapes: &[f32; BLEND_SHAPE_COUNT]) -> FapValues {
        let weights: Vec<f32> = self.shapes.iter().map(|s| weight_of(*s, shapes)).collect();
        self.bridge.faps(&weights)
    }

    /// Weights of the shapes, from those of the controls.
    pub(super) fn shapes(&self, weights: &[f32]) -> [f32; BLEND_SHAPE_COUNT] {
        let mut shapes = [0.0_f32; BLEND_SHAPE_COUNT];
        for (of_control, weight) in self.shapes.iter().zip(weights) {
            for shape in of_control.iter() {
                shapes[shape] = shapes[shape].max(*weight);
            }
        }
        shapes
    }
}

/// Weight of a control that shows several shapes together: their mean.
pub(super) fn weight_of(of_control: ShapeSet, shapes: &[f32; BLEND_SHAPE_COUNT]) -> f32 {
    let count = of_control.iter().count().max(1) as f32;
    of_control.iter().map(|shape| shapes[shape]).sum::<f32>() / count
}

/// The columns of a face's controls, from the motion of its feature points. `None` if it has none, or
/// they may be wrong.
fn own(generic: &[FapValues], fields: &[Vec<Vec3>], figure: &Figure) -> Option<Vec<FapValues>> {
    let face = FoundFace::of(figure, &[]).ok()?;
    if !face.doubtful().is_empty() {
        return None;
    }
    let table = face.table().ok()?;
    let to_head = face.head.model_from_head.inverse();
    let column = |(generic, field): (&FapValues, &Vec<Vec3>)| {
        let of_head = face
            .head
            .vertices
            .iter()
            .map(|v| to_head * field[*v as usize]);
        let offsets: Vec<Vec3> = of_head.collect();
        let mut values = table.values(&face.points, &offsets);
        for fap in NOT_MEASURED.into_iter().flatten() {
            values.set(fap, generic.get(fap));
        }
        values
    };
    Some(generic.iter().zip(fields).map(column).collect())
}

/// Name of columns: a hash of their values in whole units, 16 hexadecimal digits.
fn name_of(columns: &[FapValues]) -> String {
    let mut hash = blake3::Hasher::new();
    for value in columns.iter().flat_map(|column| column.0) {
        hash.update(&(value.round() as i32).to_le_bytes());
    }
    hash.finalize().to_hex()[..16].to_owned()
}
