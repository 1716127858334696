//! Errors by role.

use super::lod_error::ErrorSample;
use super::scene_player::ScenePlayer;
use super::spread::Spread;
use articula_build::Scene;
use serde::Serialize;

/// Error of the characters of one role over the measured frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RoleError {
    /// Name of the role.
    pub role: String,
    /// Importance of the role; 1 is neutral.
    pub importance: f32,
    /// Measured characters over all measured frames.
    pub measured: usize,
    /// 95th percentile over these, pixels.
    pub p95_px: f64,
    /// Maximum over these, pixels.
    pub max_px: f64,
}

/// Errors of the measured characters by role.
#[derive(Debug)]
pub(super) struct RoleTally {
    errors_px: Vec<Vec<f64>>,
}

impl RoleTally {
    pub(super) fn new(scene: &Scene) -> Self {
        Self {
            errors_px: vec![Vec::new(); scene.importance.roles.len()],
        }
    }

    pub(super) fn add(&mut self, scene: &ScenePlayer, sample: &ErrorSample) {
        for character in &sample.characters {
            if let Some(role) = scene.role(character.character) {
                self.errors_px[role].push(character.p95_px);
            }
        }
    }

    /// The roles that any measured character had.
    pub(super) fn roles(self, scene: &Scene) -> Vec<RoleError> {
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
