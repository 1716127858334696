//! The parts of a parameter's range over which a table is straight.

use super::FaceTable;
use crate::face::fap_values::FapValues;
use crate::face::intervals::FapInterval;
use articula_core::arkit_table::{BLEND_SHAPES, outer_lip};
use articula_core::fap_table::TABLE;
use glam::Vec3;

/// Distance up to which a straight line stands for the table, by the height of the face: 0.3 mm on
/// an average one.
const STRAIGHT: f32 = 2.2e-3;
/// That distance for lids, which lie closer to the eye: 0.1 mm.
const LID_STRAIGHT: f32 = 0.75e-3;
/// Maximum number of intervals on either side of 0.
const MOST: i32 = 16;
/// Largest value of parameters that no blend shape moves.
const USUAL: i32 = 300;
/// Largest roll of the tongue, which is an angle: 30°.
const TONGUE_ROLL: i32 = 52_360;
/// Ends of the upper lids' range: a closed and a wide eye.
const LID: [i32; 2] = [1080, -540];

impl FaceTable {
    /// Returns the intervals of a parameter between whose ends its displacements, alone, are straight
    /// lines within 0.0022 heights of the face, for lids within 0.00075; none for a parameter that the
    /// table does not show.
    ///
    /// The outermost ends are values of a strong expression, not limits.
    pub fn intervals(&self, fap: usize) -> Vec<FapInterval> {
        if !self.moves(fap) {
            return Vec::new();
        }
        let at = |value: f32| self.displacements(&FapValues::alone(fap, value));
        let limit = match fap {
            19..=22 => LID_STRAIGHT * self.height,
            _ => STRAIGHT * self.height,
        };
        let [high, low] = ends(fap);
        let upper = pieces(&at, high, limit);
        let is_two_sided = TABLE[fap - 1].action.is_some_and(|a| a.two_sided);
        let lower = if is_two_sided {
            pieces(&at, low, limit)
        } else {
            Vec::new()
        };
        let is_straight = || {
            let (a, b) = (at(high as f32), at(low as f32));
            let share = low as f32 / high as f32;
            let mirrored: Vec<Vec3> = a.iter().map(|a| share * *a).collect();
            distance(&mirrored, &b) <= limit
        };
        let both = [upper, lower];
        let sides = if both.iter().all(|s| s.len() == 1) && is_straight() {
            &both[..1]
        } else {
            &both[..]
        };
        let intervals = sides.iter().flatten();
        intervals
            .map(|(from, to)| FapInterval {
                fap,
                from: *from,
                to: *to,
            })
            .collect()
    }
}

/// Values of a strong expression, above and below 0.
fn ends(fap: usize) -> [i32; 2] {
    match fap {
        19 | 20 => return LID,
        47 => return [TONGUE_ROLL, -TONGUE_ROLL],
        _ => {}
    }
    let faps = BLEND_SHAPES.iter().flat_map(|shape| shape.faps);
    let own = faps.filter(|(f, _)| {
        let f = usize::from(*f);
        f == fap || outer_lip(f) == Some(fap)
    });
    let largest = own.map(|(_, value)| value.abs()).max().unwrap_or(USUAL);
    [largest, -largest]
}

/// The ends of equal parts between 0 and `end`, as few as are straight.
fn pieces(at: &impl Fn(f32) -> Vec<Vec3>, end: i32, limit: f32) -> Vec<(i32, i32)> {
    let cut = |count: i32| {
        let part = move |i: i32| (f64::from(end) * f64::from(i) / f64::from(count)).round() as i32;
        (0..count).map(move |i| (part(i), part(i + 1)))
    };
    let is_straight = |(from, to): (i32, i32)| {
        let [a, b] = [from, to].map(|v| at(v as f32));
        let line: Vec<Vec3> = a.iter().zip(&b).map(|(a, b)| 0.5 * (*a + *b)).collect();
        distance(&line, &at(0.5 * (from as f32 + to as f32))) <= limit
    };
    let few = (1..MOST).find(|count| cut(*count).all(is_straight));
    cut(few.unwrap_or(MOST)).collect()
}

fn distance(a: &[Vec3], b: &[Vec3]) -> f32 {
    let squared = a.iter().zip(b).map(|(a, b)| a.distance_squared(*b));
    squared.fold(0.0, f32::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_are_cut_until_they_are_straight() {
        // A quarter of a circle of 10 mm, over 900 units: n parts have a sagitta of 10 mm times
        // 1 - cos(45° / n): 2.9, 0.76, 0.34, 0.19 mm. At the middle of a chord that is the distance.
        let turn = |v: f32| {
            let angle = v / 900.0 * std::f32::consts::FRAC_PI_2;
            vec![0.01 * Vec3::new(angle.sin(), angle.cos() - 1.0, 0.0)]
        };
        assert_eq!(pieces(&turn, 900, 3e-3), [(0, 900)]);
        assert_eq!(
            pieces(&turn, 900, 0.5e-3),
            [(0, 300), (300, 600), (600, 900)]
        );
        assert_eq!(pieces(&turn, -900, 0.3e-3).len(), 4);
        assert_eq!(pieces(&turn, -900, 0.3e-3)[3], (-675, -900));
        assert_eq!(pieces(&turn, 900, 0.0).len(), 16);
    }

    #[test]
    fn ends_are_values_of_blend_shapes() {
        assert_eq!(ends(3), [1000, -1000]);
        assert_eq!(ends(51), ends(4));
        assert_eq!(ends(19), LID);
        assert_eq!(ends(64), [300, -300]);
    }
}
