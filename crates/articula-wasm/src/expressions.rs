//! Expressions by name: those of the file, and morph targets that stand for one.

use crate::expression_names::is_named_for_face;
use crate::morphs;
use articula::Figure;
use articula::build::resolve;
use articula::core::source::{Expression, JointBinding};
use articula::core::{LocalPose, nlerp};
use articula::glam::Vec3;
use std::sync::Arc;

/// Weights of the expressions of one figure, and what follows from them.
#[derive(Debug)]
pub(crate) struct Expressions {
    figure: Arc<Figure>,
    /// Weights as set, one for each expression of the file.
    drivers: Vec<f32>,
    /// Weights as resolved: masked by each other.
    resolved: Vec<f32>,
    /// Morph targets that are expressions, by name, with their weights.
    named: Vec<(String, Vec<usize>, f32)>,
}

impl Expressions {
    pub(crate) fn new(figure: &Arc<Figure>) -> Self {
        let count = figure.opened.character().expressions.len();
        let mut named: Vec<(String, Vec<usize>, f32)> = Vec::new();
        for (slot, name) in morphs::names(figure).into_iter().enumerate() {
            if !is_named_for_face(&name) {
                continue;
            }
            match named.iter_mut().find(|known| known.0 == name) {
                Some((_, slots, _)) => slots.push(slot),
                None => named.push((name, vec![slot], 0.0)),
            }
        }
        Self {
            figure: figure.clone(),
            drivers: vec![0.0; count],
            resolved: vec![0.0; count],
            named,
        }
    }

    fn all(&self) -> &[Expression] {
        &self.figure.opened.character().expressions
    }

    /// Sets a weight; false if no expression has the name.
    pub(crate) fn set(&mut self, name: &str, weight: f32) -> bool {
        let weight = if weight.is_nan() { 0.0 } else { weight };
        if let Some(found) = self.all().iter().position(|e| e.name == name) {
            self.drivers[found] = weight;
            self.resolved = resolve(self.all(), &self.drivers);
            return true;
        }
        let found = self.named.iter_mut().find(|known| known.0 == name);
        found.map(|known| known.2 = weight).is_some()
    }

    /// Sets all weights to 0.
    pub(crate) fn clear(&mut self) {
        self.drivers.fill(0.0);
        self.resolved.fill(0.0);
        self.named.iter_mut().for_each(|known| known.2 = 0.0);
    }

    /// Adds what they move to morph target weights.
    pub(crate) fn add_to(&self, weights: &mut [f32]) {
        for (_, slots, weight) in self.named.iter().filter(|known| known.2 != 0.0) {
            for slot in slots {
                weights[*slot] += weight;
            }
        }
        let first = &self.figure.asset.mesh.morph_slots;
        for (expression, value) in self.shown() {
            for binding in &expression.morphs {
                let slot = first.get(binding.mesh).map(|first| first + binding.target);
                if let Some(weight) = slot.and_then(|slot| weights.get_mut(slot)) {
                    *weight += value * binding.weight;
                }
            }
        }
    }

    /// Adds what they move to a local pose.
    pub(crate) fn pose(&self, pose: &mut LocalPose) {
        for (expression, value) in self.shown() {
            for binding in &expression.joints {
                self.pose_joint(binding, value, pose);
            }
        }
    }

    /// Adds a share of the difference between full expression and rest.
    fn pose_joint(&self, binding: &JointBinding, value: f32, pose: &mut LocalPose) {
        let joint = binding.joint;
        let rest = self.figure.asset.rig.rest_pose().get(joint);
        let turned = nlerp(rest.rotation, binding.full.rotation, value);
        let mut shown = pose.get(joint);
        shown.rotation = shown.rotation * rest.rotation.conjugate() * turned;
        shown.translation += value * (binding.full.translation - rest.translation);
        shown.scale *= Vec3::ONE + value * (binding.full.scale - rest.scale);
        pose.set(joint, shown);
    }

    fn shown(&self) -> impl Iterator<Item = (&Expression, f32)> {
        let pairs = self.all().iter().zip(self.resolved.iter().copied());
        pairs.filter(|(_, value)| *value > 0.0)
    }
}
