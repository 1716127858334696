//! Options of baking impostors.

use crate::render::Light;
use std::f32::consts::FRAC_PI_2;

/// The bound that decides how fine impostors are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ImpostorBound {
    /// At most this many bytes of pixels, four for each; the error is the least that they allow.
    Bytes(usize),
    /// About this error in metres, in as few bytes as it needs.
    Metres(f32),
}

/// Options of [`ImpostorPlan::new`](super::ImpostorPlan::new).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImpostorOptions {
    /// The bound that decides how fine the impostors are.
    pub bound: ImpostorBound,
    /// Lowest and highest pitch of the eyes that the errors hold for, radians: the angle of the eye
    /// above the horizon of the character. Eyes beyond are shown the nearest pictures.
    pub pitches_radians: [f32; 2],
    /// Light in the pictures, from directions that are fixed to the eye. Ambient light of strength
    /// 1 alone bakes the colours as they are.
    pub light: Light,
}

impl Default for ImpostorOptions {
    /// 4 MiB, eyes at any pitch, the light of [`render()`](crate::render()).
    fn default() -> Self {
        Self {
            bound: ImpostorBound::Bytes(4 << 20),
            pitches_radians: [-FRAC_PI_2, FRAC_PI_2],
            light: Light::default(),
        }
    }
}
