//! The controls of a face: morph targets named as ARKit's blend shapes, expressions, or joints.

use super::joints::{FaceJoints, JointOffset};
#[cfg(feature = "speech")]
use super::named::NamedTarget;
use super::named::{control_of, named_controls};
use crate::error::{Context, Error, Result};
use crate::figure::Figure;
use articula_build::face::{
    FaceBridge, FapInterval, FapValues, blend_shape, control_column, opposite_controls, vrm_preset,
};
use articula_core::LibmQuat;
use articula_core::face_control::{FaceControl, ShapeSet};
use articula_core::fap_table::LOW_FAPS;
use articula_core::source::{Channel, Character, Expression, Interpolation, Property};
use glam::{Quat, Vec3};
use serde::Serialize;
use std::collections::BTreeMap;

/// What the controls of a face are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaceKind {
    /// Morph targets.
    MorphTargets,
    /// Expressions.
    Expressions,
    /// Joints below the head.
    Joints,
}

/// What the weights of a face's bridge drive.
#[derive(Debug)]
pub(super) struct FaceControls {
    bridge: FaceBridge,
    /// The values of each control at weight 1, by its name; `None` for parts of a table.
    columns: Option<Vec<FapValues>>,
    targets: Vec<Target>,
    /// Of joints: numbers of the parameters, and the share of their displacements that is shown.
    shares: Vec<(usize, f32)>,
}

/// Mesh and morph target; the same one in each of the meshes of a head.
type Slots = Vec<(usize, usize)>;

/// What one weight drives.
#[derive(Debug, Clone)]
enum Target {
    Morphs(Slots),
    /// Index of an expression.
    Expression(usize),
    /// Offsets of joints at weight 1.
    Joints(Vec<JointOffset>),
}

impl FaceControls {
    /// The known controls of a character: the morph targets of a face animation table; without one,
    /// its morph targets or its expressions with the names of blend shapes, or those with the names of
    /// VRM's presets, the kind that has the most. `None` if it has none.
    pub(super) fn of(character: &Character) -> Option<Self> {
        Self::table_of(character).or_else(|| Self::shapes_of(character))
    }

    /// The morph targets of a face animation table.
    fn table_of(character: &Character) -> Option<Self> {
        let (intervals, targets): (Vec<FapInterval>, Vec<Target>) =
            morphs(character, FapInterval::parse).into_iter().unzip();
        (!targets.is_empty()).then(|| Self {
            bridge: FaceBridge::of_table(intervals),
            columns: None,
            targets,
            shares: Vec::new(),
        })
    }

    fn shapes_of(character: &Character) -> Option<Self> {
        let kinds = [
            expressions(character, blend_shape),
            expressions(character, vrm_preset),
        ];
        // The first of several with as many.
        let most = kinds.into_iter().rev().max_by_key(Vec::len)?;
        let of_morphs = named_morphs(character, most.is_empty());
        let most = if of_morphs.len() < most.len() {
            most
        } else {
            of_morphs
        };
        let (columns, targets): (Vec<FapValues>, Vec<Target>) = most.into_iter().unzip();
        if targets.is_empty() {
            return None;
        }
        let shapes: Vec<_> = targets.iter().map(|t| shown_by(t, character)).collect();
        Some(Self {
            bridge: FaceBridge::new(columns.clone()).with_opposites(opposite_controls(&shapes)),
            columns: Some(columns),
            targets,
            shares: Vec::new(),
        })
    }

    /// Controls that are driven by weights of their own, whatever else the face has.
    #[cfg(feature = "speech")]
    pub(super) fn of_named(named: &[NamedTarget]) -> Self {
        let columns: Vec<FapValues> = named.iter().map(|n| control_column(n.control)).collect();
        let target = |named: &NamedTarget| match named.expression {
            Some(index) => Target::Expression(index),
            None => Target::Morphs(named.morphs.clone()),
        };
        Self {
            bridge: FaceBridge::new(columns.clone()),
            columns: Some(columns),
            targets: named.iter().map(target).collect(),
            shares: Vec::new(),
        }
    }

    /// Joints below the head of a figure.
    fn of_joints(figure: &Figure) -> Option<Self> {
        let FaceJoints { parts, shown } = FaceJoints::of(figure)?;
        let (intervals, offsets): (Vec<FapInterval>, Vec<_>) = parts.into_iter().unzip();
        Some(Self {
            bridge: FaceBridge::of_table(intervals),
            columns: None,
            targets: offsets.into_iter().map(Target::Joints).collect(),
            shares: shown,
        })
    }

    /// The morph targets that the known controls of a character move, as mesh and morph target.
    pub(super) fn morphs_of(character: &Character) -> Vec<(usize, usize)> {
        let targets = Self::of(character).map(|found| found.targets);
        let moved = targets.iter().flatten().flat_map(|target| match target {
            Target::Morphs(slots) => slots.clone(),
            Target::Expression(index) => {
                let morphs = character.expressions[*index].morphs.iter();
                morphs.map(|m| (m.mesh, m.target)).collect()
            }
            Target::Joints(_) => Vec::new(),
        });
        moved.collect()
    }

    /// Number of the controls.
    pub(super) fn len(&self) -> usize {
        self.targets.len()
    }

    /// The relation to parameters by the names of the controls.
    pub(super) fn bridge(&self) -> &FaceBridge {
        &self.bridge
    }

    /// The values of each control at weight 1, by its name; `None` for parts of a table.
    pub(super) fn columns(&self) -> Option<&[FapValues]> {
        self.columns.as_deref()
    }

    /// As [`FaceControls::of`], or the joints of a figure's face if there are none; with an error that
    /// names the file without these too.
    pub(super) fn known(figure: &Figure) -> Result<Self> {
        let what = "face: no morph target has the name of a blend shape of ARKit (jawOpen, \
                    eyeBlinkLeft, ...) no expression that of a preset of VRM (aa, blink, ...), \
                    and no joint below the head moves a closed face, so nothing shows a face clip; convert --face-shapes and --face-shapes=fat make morph targets \
                    for a closed face";
        let found = Self::of(figure.opened.character()).or_else(|| Self::of_joints(figure));
        let found = found.ok_or_else(|| Error::unsuited(what));
        found.context(figure.opened.name())
    }

    /// What the controls are.
    pub(super) fn kind(&self) -> FaceKind {
        match self.targets[0] {
            Target::Morphs(_) => FaceKind::MorphTargets,
            Target::Expression(_) => FaceKind::Expressions,
            Target::Joints(_) => FaceKind::Joints,
        }
    }

    /// Of joints: numbers of the parameters, and the share of the displacements of the face animation
    /// table, by their squares, that they show.
    pub(super) fn shares(&self) -> &[(usize, f32)] {
        &self.shares
    }

    /// The blend shapes of ARKit that each control shows, at least in part; `None` if one shows none.
    pub(super) fn shapes(&self, character: &Character) -> Option<Vec<ShapeSet>> {
        let shapes = |target| shown_by(target, character);
        self.targets.iter().map(shapes).collect()
    }

    /// The channels that set the controls to the weights of each frame.
    pub(super) fn channels(
        &self,
        character: &Character,
        times_secs: &[f32],
        frames: &[Vec<f32>],
    ) -> Vec<Channel> {
        let channel = |target, property, values| Channel {
            target,
            property,
            interpolation: Interpolation::Linear,
            times_secs: times_secs.to_vec(),
            values,
        };
        let mut channels = Vec::new();
        let mut of_mesh: BTreeMap<usize, Slots> = BTreeMap::new();
        let mut of_joint: BTreeMap<usize, Vec<(JointOffset, usize)>> = BTreeMap::new();
        for (control, target) in self.targets.iter().enumerate() {
            match target {
                Target::Morphs(slots) => {
                    for (mesh, slot) in slots {
                        of_mesh.entry(*mesh).or_default().push((*slot, control));
                    }
                }
                Target::Expression(index) => {
                    let values = frames.iter().map(|weights| weights[control]).collect();
                    channels.push(channel(*index, Property::Expression, values));
                }
                Target::Joints(offsets) => {
                    let moves = frames.iter().any(|weights| weights[control] != 0.0);
                    for offset in offsets.iter().filter(|_| moves) {
                        let of = of_joint.entry(offset.joint).or_default();
                        of.push((*offset, control));
                    }
                }
            }
        }
        for (mesh, slots) in of_mesh {
            let rest = &character.meshes[mesh].morph_weights;
            let mut values = Vec::with_capacity(rest.len() * frames.len());
            for weights in frames {
                let first = values.len();
                values.extend_from_slice(rest);
                for (slot, control) in &slots {
                    values[first + slot] = weights[*control];
                }
            }
            channels.push(channel(mesh, Property::Weights, values));
        }
        for (joint, offsets) in of_joint {
            let rest = character.skeleton.joints[joint].rest;
            let sum = |weights: &Vec<f32>, of: fn(&JointOffset) -> Vec3| {
                let all = offsets.iter().map(|(o, control)| weights[*control] * of(o));
                all.sum::<Vec3>()
            };
            let turn = |weights| {
                let turn = Quat::libm_scaled_axis(sum(weights, |o| o.rotation));
                (rest.rotation * turn).normalize().to_array()
            };
            let values = frames.iter().flat_map(turn).collect();
            channels.push(channel(joint, Property::Rotation, values));
            if offsets.iter().any(|(o, _)| o.translation != Vec3::ZERO) {
                let shift = |weights| rest.translation + sum(weights, |o| o.translation);
                let values = frames.iter().flat_map(|w| shift(w).to_array()).collect();
                channels.push(channel(joint, Property::Translation, values));
            }
        }
        channels
    }
}

/// The blend shapes of ARKit that a target shows by its name, at least in part.
fn shown_by(target: &Target, character: &Character) -> Option<ShapeSet> {
    let name = match target {
        Target::Morphs(slots) => {
            let (mesh, slot) = *slots.first()?;
            &character.meshes[mesh].morph_names[slot]
        }
        Target::Expression(index) => &character.expressions[*index].name,
        Target::Joints(_) => return None,
    };
    match control_of(character, name)?.control {
        FaceControl::Shapes(shapes, _) => Some(shapes),
        FaceControl::Viseme(_) | FaceControl::Emotion(_) => None,
    }
}

/// The morph targets that show blend shapes by their names; `with_visemes`, those of visemes too if
/// they move a parameter that no shape moves.
fn named_morphs(character: &Character, with_visemes: bool) -> Vec<(FapValues, Target)> {
    let named = named_controls(character);
    let of = |wanted: fn(&FaceControl) -> bool| {
        let own = named.iter().filter(move |n| wanted(&n.control));
        let own = own.filter(|n| !n.morphs.is_empty());
        own.map(|n| (control_column(n.control), Target::Morphs(n.morphs.clone())))
    };
    let mut found: Vec<_> = of(|c| matches!(c, FaceControl::Shapes(..))).collect();
    if with_visemes {
        let visemes: Vec<_> = of(|c| matches!(c, FaceControl::Viseme(_)))
            .filter(|(column, _)| *column != FapValues::default())
            .collect();
        let moves = |all: &[(FapValues, Target)], fap| all.iter().any(|(c, _)| c.get(fap) != 0.0);
        if LOW_FAPS
            .into_iter()
            .any(|fap| moves(&visemes, fap) && !moves(&found, fap))
        {
            found.extend(visemes);
        }
    }
    found
}

/// Morph targets with known names; those that mean the same, however they spell it, are one control.
fn morphs<T: PartialEq>(character: &Character, known: fn(&str) -> Option<T>) -> Vec<(T, Target)> {
    let mut found: Vec<(T, Slots)> = Vec::new();
    for (mesh, raw) in character.meshes.iter().enumerate() {
        for (slot, name) in raw.morph_names.iter().enumerate() {
            let Some(values) = known(name) else {
                continue;
            };
            match found.iter_mut().find(|(known, _)| *known == values) {
                Some((_, slots)) => slots.push((mesh, slot)),
                None => found.push((values, vec![(mesh, slot)])),
            }
        }
    }
    let target = |(values, slots)| (values, Target::Morphs(slots));
    found.into_iter().map(target).collect()
}

/// The expressions that move something and whose name is known.
fn expressions(
    character: &Character,
    values: fn(&str) -> Option<FapValues>,
) -> Vec<(FapValues, Target)> {
    let moves = |e: &Expression| !e.morphs.is_empty() || !e.joints.is_empty();
    let all = character.expressions.iter().enumerate();
    let known = all.filter(|(_, e)| moves(e));
    known
        .filter_map(|(index, e)| Some((values(&e.name)?, Target::Expression(index))))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::{MorphBinding, RawMesh};

    fn mesh(names: &[&str]) -> RawMesh {
        RawMesh {
            morph_names: names.iter().map(|n| (*n).to_owned()).collect(),
            morph_weights: vec![0.25; names.len()],
            ..RawMesh::default()
        }
    }

    #[test]
    fn meshes_of_a_head_share_a_control() {
        let head = Character {
            meshes: vec![mesh(&["jawOpen", "wink"]), mesh(&["teeth", "Jaw_Open"])],
            ..Character::default()
        };
        let controls = FaceControls::of(&head).unwrap();
        assert_eq!(controls.len(), 1);
        assert_eq!(controls.kind(), FaceKind::MorphTargets);
        let channels = controls.channels(&head, &[0.0, 1.0], &[vec![0.5], vec![1.0]]);
        let values: Vec<&[f32]> = channels.iter().map(|c| &*c.values).collect();
        // What is not driven keeps its own weight.
        assert_eq!(values, [[0.5, 0.25, 1.0, 0.25], [0.25, 0.5, 0.25, 1.0]]);
    }

    #[test]
    fn expressions_count_if_they_move_something() {
        let named = |name: &str, moves: bool| Expression {
            name: name.to_owned(),
            morphs: vec![
                MorphBinding {
                    mesh: 0,
                    target: 0,
                    weight: 1.0
                };
                usize::from(moves)
            ],
            ..Expression::default()
        };
        let mut head = Character {
            expressions: vec![named("aa", false), named("neutral", true)],
            ..Character::default()
        };
        assert!(FaceControls::of(&head).is_none());
        head.expressions.push(named("blink", true));
        let controls = FaceControls::of(&head).unwrap();
        assert_eq!(controls.kind(), FaceKind::Expressions);
        assert!(controls.bridge().moves(19));
        let channels = controls.channels(&head, &[0.0], &[vec![0.75]]);
        let channel = &channels[0];
        assert_eq!(
            (channel.target, channel.property),
            (2, Property::Expression)
        );
        assert_eq!(channel.values, [0.75]);
    }
}
