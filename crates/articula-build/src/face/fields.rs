//! How far the controls and the eyeballs of a face move its vertices.

use super::fap_values::FapValues;
use articula_core::LibmQuat;
use articula_core::fap_table::ANGLE_UNIT;
use glam::{Quat, Vec3};

/// Displacement below which a control does not move a vertex, in metres.
const STILL_M: f32 = 1e-7;

/// The vertices of a face that each control and each eyeball moves.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceFields {
    controls: Vec<Field>,
    eyes: Vec<Field>,
    /// FAPs of pitch and yaw of each eyeball.
    eye_faps: Vec<[usize; 2]>,
    vertices: usize,
}

/// Displacements of some vertices.
#[derive(Debug, Clone, PartialEq)]
struct Field {
    vertices: Vec<u32>,
    offsets: Vec<Vec3>,
}

impl Field {
    fn of(dense: &[Vec3]) -> Self {
        let moved = (0..).zip(dense).filter(|(_, o)| o.length() > STILL_M);
        let (vertices, offsets) = moved.map(|(v, o)| (v, *o)).unzip();
        Self { vertices, offsets }
    }

    fn add(&self, out: &mut [Vec3], change: impl Fn(Vec3) -> Vec3) {
        for (vertex, offset) in self.vertices.iter().zip(&self.offsets) {
            out[*vertex as usize] += change(*offset);
        }
    }
}

impl FaceFields {
    /// Creates fields from the displacement of each vertex, in metres, for each control at weight 1.
    ///
    /// # Panics
    /// If the controls differ in their number of vertices.
    pub fn new(controls: &[Vec<Vec3>]) -> Self {
        let vertices = controls.first().map_or(0, Vec::len);
        let is_like = |field: &Vec<Vec3>| field.len() == vertices;
        assert!(controls.iter().all(is_like), "one offset for each vertex");
        Self {
            controls: controls.iter().map(|dense| Field::of(dense)).collect(),
            eyes: Vec::new(),
            eye_faps: Vec::new(),
            vertices,
        }
    }

    /// Adds an eyeball that turns by the FAPs of its pitch (positive down) and its yaw (left).
    ///
    /// For each vertex, `offsets` has its position relative to the centre of the eyeball, in metres
    /// along the axes of the head (+X its left, +Y up, +Z forward), times the share with which it
    /// follows; zero for all others.
    ///
    /// # Panics
    /// If there are not as many offsets as vertices.
    pub fn add_eyeball(&mut self, [pitch, yaw]: [usize; 2], offsets: &[Vec3]) {
        assert_eq!(offsets.len(), self.vertices, "one offset for each vertex");
        self.eyes.push(Field::of(offsets));
        self.eye_faps.push([pitch, yaw]);
    }

    /// Returns the number of vertices.
    pub fn vertices(&self) -> usize {
        self.vertices
    }

    /// Adds the displacements under the weights of the controls, one for each.
    ///
    /// # Panics
    /// If there are not as many weights as controls, or displacements as vertices.
    pub fn add_weighted(&self, weights: &[f32], out: &mut [Vec3]) {
        assert_eq!(weights.len(), self.controls.len(), "a weight per control");
        assert_eq!(out.len(), self.vertices, "a displacement per vertex");
        for (field, weight) in self.controls.iter().zip(weights) {
            if *weight != 0.0 {
                field.add(out, |offset| *weight * offset);
            }
        }
    }

    /// Adds the displacements that lead from the turn of the eyeballs under some values to that
    /// under others.
    fn add_turns(&self, from: &FapValues, to: &FapValues, out: &mut [Vec3]) {
        for (field, faps) in self.eyes.iter().zip(&self.eye_faps) {
            if faps.iter().any(|fap| from.get(*fap) != to.get(*fap)) {
                let [from, to] = [from, to].map(|values| turn(faps, values));
                field.add(out, |offset| to * offset - from * offset);
            }
        }
    }

    /// Returns the greatest distance of a vertex between two faces, given by weights and values;
    /// `moved` is a buffer.
    pub(super) fn distance(
        &self,
        (from, from_values): (&[f32], &FapValues),
        (to, to_values): (&[f32], &FapValues),
        moved: &mut Vec<Vec3>,
    ) -> f32 {
        moved.clear();
        moved.resize(self.vertices, Vec3::ZERO);
        let change: Vec<f32> = to.iter().zip(from).map(|(b, a)| b - a).collect();
        self.add_weighted(&change, moved);
        self.add_turns(from_values, to_values, moved);
        let squared = |most: f32, o: &Vec3| most.max(o.length_squared());
        moved.iter().fold(0.0, squared).sqrt()
    }
}

/// Yaw, then pitch about the axis that the yaw has turned.
fn turn([pitch, yaw]: &[usize; 2], values: &FapValues) -> Quat {
    let [pitch, yaw] = [pitch, yaw].map(|fap| values.get(*fap) * ANGLE_UNIT);
    Quat::libm_rotation_y(yaw) * Quat::libm_rotation_x(pitch)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two vertices: the first control lifts the first by 1 cm, the second moves both by 2 cm.
    fn fields() -> FaceFields {
        FaceFields::new(&[
            vec![0.01 * Vec3::Y, Vec3::ZERO],
            vec![0.02 * Vec3::X, 0.02 * Vec3::X],
        ])
    }

    #[test]
    fn distances_by_hand() {
        let (fields, still) = (fields(), FapValues::default());
        let mut moved = Vec::new();
        let mut between =
            |a: [f32; 2], b: [f32; 2]| fields.distance((&a, &still), (&b, &still), &mut moved);
        assert_eq!(between([0.3, 0.6], [0.3, 0.6]), 0.0);
        assert!((between([0.0, 0.0], [0.5, 0.0]) - 0.005).abs() < 1e-7);
        // 1 cm up and 2 cm sideways.
        assert!((between([1.0, 1.0], [0.0, 0.0]) - 0.0005_f32.sqrt()).abs() < 1e-7);
        assert!((between([0.0, 0.25], [0.0, 1.0]) - 0.015).abs() < 1e-7);
    }

    #[test]
    fn an_eyeball_turns_its_pupil() {
        let mut fields = fields();
        // The pupil, 12 mm before the centre, is the second vertex.
        fields.add_eyeball([25, 23], &[Vec3::ZERO, 0.012 * Vec3::Z]);
        let mut looks = [FapValues::default(); 3];
        let quarter = std::f32::consts::FRAC_PI_2 / ANGLE_UNIT;
        looks[1].0[23 - 3] = quarter;
        looks[2].0[25 - 3] = quarter;
        let mut moved = Vec::new();
        let mut between = |a: usize, b: usize| {
            fields.distance((&[0.0; 2], &looks[a]), (&[0.0; 2], &looks[b]), &mut moved)
        };
        // Chords of a quarter of a circle; left and down are at a right angle too.
        let chord = 0.012 * 2.0_f32.sqrt();
        for (a, b) in [(0, 1), (0, 2), (1, 2)] {
            assert!((between(a, b) - chord).abs() < 1e-6, "{a} to {b}");
        }
        assert_eq!(between(1, 1), 0.0);
    }
}
