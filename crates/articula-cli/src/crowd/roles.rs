//! Errors by role.

use super::timing::Spread;
use articula::build::Scene;
use articula::crowd::{ErrorSample, ScenePlayer};
use serde::Serialize;

/// Error of the characters of one role over the measured frames.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct RoleError {
    pub(crate) role: String,
    pub(crate) importance: f32,
    /// Measured characters over all measured frames.
    pub(crate) measured: usize,
    /// 95th percentile over these, pixels.
    pub(crate) p95_px: f64,
    /// Maximum over these, pixels.
    pub(crate) max_px: f64,
}

/// Errors of the measured characters by role.
#[derive(Debug)]
pub(crate) struct RoleTally {
    errors_px: Vec<Vec<f64>>,
}

impl RoleTally {
    pub(crate) fn new(scene: &Scene) -> Self {
        Self {
            errors_px: vec![Vec::new(); scene.importance.roles.len()],
        }
    }

    pub(crate) fn add(&mut self, scene: &ScenePlayer, sample: &ErrorSample) {
        for character in &sample.characters {
            if let Some(role) = scene.role(character.character) {
                self.errors_px[role].push(character.p95_px);
            }
        }
    }

    /// The roles that any measured character had.
    pub(crate) fn roles(self, scene: &Scene) -> Vec<RoleError> {
        let roles = scene.importance.roles.iter().zip(self.errors_px);
        let measured = roles.filter(|(_, errors)| !errors.is_empty());
        let of = measured.map(|(role, errors)| RoleError {
            role: role.name.clone(),
            importance: role.importance,
            measured: errors.len(),
            max_px: errors.iter().copied().fold(0.0, f64::max),
            p95_px: Spread::of(errors).p95,
        });
        of.collect()
    }
}
