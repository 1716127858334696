//! The directions from which a character is baked, and the direction that an eye sees.
//!
//! Directions lie in rows of equal pitch that cover the sphere from below to above. A row shows eyes
//! whose pitch lies between its border and that of the next row, from evenly spaced yaws, the first
//! of which is the front (+Z).

use glam::{Affine3A, Mat3, Quat, Vec3};
use std::f32::consts::TAU;

/// A row of directions of equal pitch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewRow {
    /// Least pitch of the eyes that the row is shown to, radians. The first row is shown to lower ones
    /// too.
    pub from_radians: f32,
    /// Pitch of the directions, radians, positive if the eye is above.
    pub pitch_radians: f32,
    /// Lean of the plane: 0 for a plane across the direction, the tangent of the pitch for an upright
    /// one.
    pub lean: f32,
    /// Number of yaws, evenly spaced from 0.
    pub yaws: u32,
}

impl ViewRow {
    /// Direction and plane of one yaw.
    pub fn view(&self, yaw: u32) -> ImpostorView {
        let yaw_radians = TAU * yaw as f32 / self.yaws.max(1) as f32;
        ImpostorView::new(yaw_radians, self.pitch_radians, self.lean)
    }
}

/// All rows, by pitch.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ImpostorViews {
    /// The rows, from the lowest.
    pub rows: Vec<ViewRow>,
    /// Highest pitch of the eyes that the rows are made for, radians.
    pub to_radians: f32,
}

impl ImpostorViews {
    /// Number of directions.
    pub fn len(&self) -> usize {
        self.rows.iter().map(|r| r.yaws as usize).sum()
    }

    /// Whether there is no direction.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All directions, row by row.
    pub fn iter(&self) -> impl Iterator<Item = ImpostorView> + '_ {
        let rows = self.rows.iter();
        rows.flat_map(|row| (0..row.yaws).map(|yaw| row.view(yaw)))
    }

    /// Index of the direction that is shown to an eye in this direction from the centre, in the
    /// space of the character. The length does not matter.
    pub fn nearest(&self, to_eye: Vec3) -> usize {
        let pitch = to_eye.y.atan2(to_eye.x.hypot(to_eye.z));
        let row = self.rows.iter().rposition(|r| r.from_radians <= pitch);
        let row = row.unwrap_or(0);
        let first: u32 = self.rows[..row].iter().map(|r| r.yaws).sum();
        let yaws = self.rows.get(row).map_or(1, |r| r.yaws.max(1));
        let turn = to_eye.x.atan2(to_eye.z) / TAU;
        let yaw = (turn * yaws as f32).round().rem_euclid(yaws as f32) as u32;
        (first + yaw % yaws) as usize
    }

    /// Directions of eyes at the corners of what each direction is shown to, where the error is
    /// greatest; four for each direction, in their order.
    pub(super) fn corners(&self) -> Vec<[Vec3; 4]> {
        let mut all = Vec::with_capacity(self.len());
        for (i, row) in self.rows.iter().enumerate() {
            let next = self.rows.get(i + 1);
            let to = next.map_or(self.to_radians, |r| r.from_radians);
            if row.yaws == 1 {
                // Around a pole, the border of the cap.
                let border = if row.pitch_radians > 0.0 {
                    row.from_radians
                } else {
                    to
                };
                all.push([0.0, 0.25, 0.5, 0.75].map(|turn| direction(TAU * turn, border)));
                continue;
            }
            for yaw in 0..row.yaws {
                let corner = |pitch: f32, half: f32| {
                    direction(TAU * (yaw as f32 + half) / row.yaws as f32, pitch)
                };
                all.push([
                    corner(row.from_radians, -0.5),
                    corner(row.from_radians, 0.5),
                    corner(to, -0.5),
                    corner(to, 0.5),
                ]);
            }
        }
        all
    }
}

/// A direction, and the plane on which what is seen from it is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImpostorView {
    /// Unit vector towards the eye, in the space of the character.
    pub to_eye: Vec3,
    /// Unit vector of the picture's x axis, horizontal.
    pub right: Vec3,
    /// Unit vector of the picture's y axis, across the direction.
    pub up: Vec3,
    /// Displacement on the plane for one metre of the picture's y axis.
    pub plane_up: Vec3,
}

impl ImpostorView {
    /// The direction with a yaw and a pitch in radians, and a plane with the lean of a [`ViewRow`].
    pub fn new(yaw_radians: f32, pitch_radians: f32, lean: f32) -> Self {
        let turn = orientation(yaw_radians, pitch_radians);
        let (right, up, to_eye) = (turn * Vec3::X, turn * Vec3::Y, turn * Vec3::Z);
        Self {
            to_eye,
            right,
            up,
            plane_up: up + lean * to_eye,
        }
    }

    /// The transform of points around a centre to where they are shown.
    pub fn flattened(&self, centre: Vec3) -> Affine3A {
        let columns = Vec3::AXES.map(|axis| self.shown(axis));
        let matrix = Mat3::from_cols(columns[0], columns[1], columns[2]);
        Affine3A::from_mat3_translation(matrix, centre - matrix * centre)
    }

    /// Where a point, relative to the centre, is shown: on the plane.
    pub fn shown(&self, point: Vec3) -> Vec3 {
        self.right * self.right.dot(point) + self.plane_up * self.up.dot(point)
    }
}

/// Rotation of a camera that looks at the character from a yaw and a pitch.
pub(super) fn orientation(yaw_radians: f32, pitch_radians: f32) -> Quat {
    Quat::from_rotation_y(yaw_radians) * Quat::from_rotation_x(-pitch_radians)
}

/// Unit vector towards an eye.
pub(super) fn direction(yaw_radians: f32, pitch_radians: f32) -> Vec3 {
    orientation(yaw_radians, pitch_radians) * Vec3::Z
}
