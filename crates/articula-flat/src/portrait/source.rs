//! Input and options of a portrait: the figure, its coarse triangles, its expressions.

use super::clip::PortraitClip;
use super::error::{PortraitError, refuse};
use super::head::{Head, HeadPose, PortraitExpression};
use crate::appearance::Appearance;
use articula_core::{Camera, Mesh, Rig};

/// Maximum number of triangles of a 2D mesh.
pub(super) const MAX_TRIANGLES: usize = 20_000;
/// Maximum number of vertices of a 2D mesh; indices have 16 bits.
pub(super) const MAX_VERTICES: usize = 65_535;
/// Maximum number of expressions of one portrait.
pub(super) const MAX_EXPRESSIONS: usize = 512;

/// Input of a portrait.
#[derive(Debug, Clone)]
pub struct PortraitSource<'a> {
    /// The figure in full quality, for the view pictures.
    pub mesh: &'a Mesh,
    /// Joints of the figure.
    pub rig: &'a Rig,
    /// Materials and textures.
    pub appearance: &'a Appearance,
    /// Triangles of the 2D mesh: a few over the same vertices (any level of the mesh).
    pub triangles: &'a [[u32; 3]],
    /// Part of the figure that turns with the head.
    pub head: Head,
    /// Expressions of the face.
    pub expressions: &'a [PortraitExpression],
    /// Motions to store in the portrait.
    pub clips: &'a [PortraitClip],
    /// The camera; its viewport is the size of the portrait.
    pub camera: Camera,
}

/// Options of a portrait.
#[derive(Debug, Clone, PartialEq)]
pub struct PortraitOptions {
    /// Number of view pictures: 1 (front, as in the thesis), 3 (with both sides), or 5 (with above
    /// and below).
    pub views: usize,
    /// Yaw of the head in the side views, degrees.
    pub view_yaw_degrees: f32,
    /// Pitch of the head in the upper and lower view, degrees.
    pub view_pitch_degrees: f32,
    /// Maximum yaw that the portrait can show, degrees.
    pub yaw_limit_degrees: f32,
    /// Maximum pitch that the portrait can show, degrees.
    pub pitch_limit_degrees: f32,
    /// RMS error tolerance of the 2D positions in the tables, pixels.
    pub tolerance_px: f32,
}

impl Default for PortraitOptions {
    fn default() -> Self {
        Self {
            views: 3,
            view_yaw_degrees: 45.0,
            view_pitch_degrees: 20.0,
            yaw_limit_degrees: 60.0,
            pitch_limit_degrees: 30.0,
            tolerance_px: 0.1,
        }
    }
}

impl PortraitOptions {
    /// Pose of the head in each view, the front first.
    pub(crate) fn view_poses(&self) -> Vec<HeadPose> {
        let (yaw, pitch) = (self.view_yaw_degrees, self.view_pitch_degrees);
        let all = [
            (0.0, 0.0),
            (-yaw, 0.0),
            (yaw, 0.0),
            (0.0, -pitch),
            (0.0, pitch),
        ];
        let pose = |(yaw_degrees, pitch_degrees)| HeadPose {
            yaw_degrees,
            pitch_degrees,
            roll_degrees: 0.0,
        };
        all.into_iter().take(self.views).map(pose).collect()
    }

    fn check(&self) -> Result<(), PortraitError> {
        if !matches!(self.views, 1 | 3 | 5) {
            let what = format!("{} views; choose 1, 3 or 5", self.views);
            return Err(refuse("options.views", what));
        }
        let ranges = [
            ("view_yaw_degrees", self.view_yaw_degrees, 5.0, 80.0),
            ("view_pitch_degrees", self.view_pitch_degrees, 5.0, 60.0),
            ("yaw_limit_degrees", self.yaw_limit_degrees, 0.0, 89.0),
            ("pitch_limit_degrees", self.pitch_limit_degrees, 0.0, 80.0),
            ("tolerance_px", self.tolerance_px, 1e-3, 10.0),
        ];
        for (at, value, least, most) in ranges {
            // Also refuses NaN.
            if !(least..=most).contains(&value) {
                let what = format!("{value}, expected {least} to {most}");
                return Err(refuse(format!("options.{at}"), what));
            }
        }
        Ok(())
    }
}

impl PortraitSource<'_> {
    /// Checks that all parts match and the options are in range.
    pub(crate) fn check(&self, options: &PortraitOptions) -> Result<(), PortraitError> {
        options.check()?;
        let vertices = self.mesh.len();
        if self.triangles.is_empty() || vertices == 0 {
            return Err(refuse(
                "triangles",
                "must not be empty: there is nothing to show",
            ));
        }
        limit("triangles", self.triangles.len(), MAX_TRIANGLES)?;
        limit("expressions", self.expressions.len(), MAX_EXPRESSIONS)?;
        let outside = |t: &[u32; 3]| t.iter().any(|v| *v as usize >= vertices);
        if let Some(t) = self.triangles.iter().position(outside) {
            let what = format!(
                "{:?} names a vertex out of range: the mesh has {vertices} vertices",
                self.triangles[t]
            );
            return Err(refuse(format!("triangles[{t}]"), what));
        }
        let joints = self.rig.len();
        if let Some(b) = self
            .mesh
            .bindings
            .iter()
            .find(|b| usize::from(b.joint) >= joints)
        {
            let what = format!(
                "joint {} is out of range: the rig has {joints} joints",
                b.joint
            );
            return Err(refuse("mesh.bindings", what));
        }
        self.check_head(joints)?;
        for (e, expression) in self.expressions.iter().enumerate() {
            self.check_expression(expression)
                .map_err(|what| refuse(format!("expressions[{e}]"), what))?;
        }
        for (c, clip) in self.clips.iter().enumerate() {
            clip.check(self.expressions.len())
                .map_err(|what| refuse(format!("clips[{c}]"), what))?;
        }
        Ok(())
    }

    fn check_head(&self, joints: usize) -> Result<(), PortraitError> {
        match &self.head {
            Head::Whole { pivot } if !pivot.is_finite() => {
                Err(refuse("head.pivot", "must be finite"))
            }
            Head::Joints(list) if list.is_empty() => {
                Err(refuse("head", "must name at least one joint"))
            }
            Head::Joints(list) => match list.iter().find(|j| **j >= joints) {
                Some(j) => Err(refuse(
                    "head",
                    format!("joint {j} is out of range: the rig has {joints} joints"),
                )),
                None if list.windows(2).all(|w| w[0] < w[1]) => Ok(()),
                None => Err(refuse("head", "the joint indices must rise")),
            },
            Head::Whole { .. } => Ok(()),
        }
    }

    fn check_expression(&self, expression: &PortraitExpression) -> Result<(), String> {
        let slots = self.mesh.morph_weights.len();
        for (slot, weight) in &expression.morphs {
            if usize::from(*slot) >= slots || !weight.is_finite() {
                return Err(format!(
                    "morph slot {slot} (of {slots}) is out of range, or its weight {weight} is \
                     not finite"
                ));
            }
        }
        for turn in &expression.joints {
            if turn.joint >= self.rig.len() || !turn.rotation.is_normalized() {
                return Err(format!(
                    "joint {} is out of range, or its rotation is not of unit length",
                    turn.joint
                ));
            }
        }
        Ok(())
    }
}

pub(crate) fn limit(what: &'static str, count: usize, limit: usize) -> Result<(), PortraitError> {
    if count <= limit {
        return Ok(());
    }
    Err(PortraitError::LimitExceeded { what, count, limit })
}
