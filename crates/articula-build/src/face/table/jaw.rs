//! How the lower jaw goes, by the motion of the chin: it turns about its hinge, and what is left of the motion is a shift.

use super::super::points::FacePoints;
use super::FaceTable;
use articula_core::{Libm, LibmQuat};
use glam::{Quat, Vec2, Vec3};

/// A motion of the lower jaw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JawMotion {
    turn: Quat,
    /// metres.
    shift: Vec3,
}

impl JawMotion {
    /// Returns the motion that takes a chin, relative to the [hinge](FacePoints::jaw_hinge), by a displacement. The turn
    /// lowers or raises it, the shift is level.
    pub fn of(chin: Vec3, moved: Vec3) -> Self {
        let arm = Vec2::new(chin.z, chin.y);
        let length = arm.length();
        let to = (chin.y + moved.y).clamp(-0.99 * length, 0.99 * length);
        let angle = chin.y.libm_atan2(chin.z) - to.libm_atan2((length * length - to * to).sqrt());
        let turn = Quat::libm_rotation_x(angle);
        let left = chin + moved - turn * chin;
        Self {
            turn,
            shift: Vec3::new(left.x, 0.0, left.z),
        }
    }

    /// Returns the displacement of a place of the lower jaw, relative to the hinge; metres.
    pub fn of_place(&self, from: Vec3) -> Vec3 {
        self.turn * from - from + self.shift
    }
}

impl FacePoints {
    /// Returns the middle between the hinges of the lower jaw, a quarter of the way from the lobes of the ears up to their
    /// tops.
    pub fn jaw_hinge(&self) -> Option<Vec3> {
        let place = |point| self.get(point).map(|p| p.place);
        let (left, right) = (place((10, 9))?, place((10, 10))?);
        let (lobe, top) = (place((10, 7))?, left);
        Some(Vec3::new(
            0.5 * (left.x + right.x),
            lobe.y + 0.25 * (top.y - lobe.y),
            0.5 * (left.z + right.z),
        ))
    }
}

impl FaceTable {
    /// The motion of the lower jaw by the displacements of all vertices; `None` if the chin is not known.
    pub(in crate::face) fn jaw_of(&self, moved: &[Vec3]) -> Option<JawMotion> {
        let of_chin = self.chin.and_then(|chin| moved.get(chin as usize));
        of_chin.map(|moved| JawMotion::of(self.frame.chin - self.frame.hinge, *moved))
    }

    /// The displacement of a vertex that goes with the lower jaw, metres.
    pub(in crate::face) fn with_jaw(&self, vertex: usize, jaw: &JawMotion) -> Vec3 {
        jaw.of_place(self.positions[vertex] - self.frame.hinge)
    }

    /// Displacements of all vertices by those of the skin: what is attached follows it, and what is inside of the mouth
    /// the jaw.
    pub(in crate::face) fn displacements_of_skin(
        &self,
        skin: &[Vec3],
        jaw: Option<&JawMotion>,
    ) -> Vec<Vec3> {
        let rows: Vec<Vec3> = self.vertices.iter().map(|v| skin[*v as usize]).collect();
        let mut all = self.spread(&rows);
        for (vertex, share) in &self.jaw {
            let with_jaw = jaw.map_or(Vec3::ZERO, |jaw| self.with_jaw(*vertex as usize, jaw));
            all[*vertex as usize] = *share * with_jaw;
        }
        still_below_least(&mut all);
        all
    }
}

/// Offsets that are too short to be seen are none.
pub(in super::super) fn still_below_least(all: &mut [Vec3]) {
    let short = |offset: &&mut Vec3| offset.length_squared() < super::LEAST * super::LEAST;
    all.iter_mut()
        .filter(short)
        .for_each(|offset| *offset = Vec3::ZERO);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_chin_has_no_shift() {
        let chin = Vec3::new(0.0, -0.08, 0.09);
        for angle in [0.3_f32, 0.1, -0.05] {
            let turn = Quat::from_rotation_x(angle);
            let jaw = JawMotion::of(chin, turn * chin - chin);
            assert!(jaw.shift.length() < 1e-6, "{}", jaw.shift);
            let tooth = Vec3::new(0.01, -0.05, 0.08);
            assert!(jaw.of_place(tooth).distance(turn * tooth - tooth) < 1e-6);
        }
    }

    #[test]
    fn a_level_motion_is_a_shift() {
        let jaw = JawMotion::of(Vec3::new(0.0, -0.08, 0.09), Vec3::new(0.01, 0.0, 0.008));
        let moved = jaw.of_place(Vec3::new(0.02, -0.04, 0.03));
        assert!(
            moved.distance(Vec3::new(0.01, 0.0, 0.008)) < 1e-6,
            "{moved}"
        );
    }
}
