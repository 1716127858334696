//! The motion of one blend shape over the chart of the mouth.

use super::chart::{COLUMNS, MouthChart, Place, ROWS, cell};
use articula_core::Libm;
use glam::Vec3;

/// Displacements at the nodes of the chart, by the height of the face; the rows of each column in turn.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Motion {
    pub(super) nodes: Vec<Vec3>,
}

/// Shares by which the rows of a lip, outwards, give way to the other lip.
const LIP: [f32; 4] = [1.0, 0.7, 0.35, 0.1];
/// Room that lips need which slide on each other, by how far they do.
const SLIDE: f32 = 0.15;

/// The side of a face that a motion is taken to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Own,
    Mirrored,
}

/// The column at the mirrored side.
fn across(column: usize) -> usize {
    (COLUMNS + COLUMNS / 2 - column) % COLUMNS
}

fn mirrored(displacement: Vec3) -> Vec3 {
    Vec3::new(-displacement.x, displacement.y, displacement.z)
}

impl Motion {
    pub(super) fn still() -> Self {
        Self {
            nodes: vec![Vec3::ZERO; COLUMNS * ROWS],
        }
    }

    pub(super) fn is_still(&self) -> bool {
        self.nodes.iter().all(|d| *d == Vec3::ZERO)
    }

    /// The motion of the other side.
    pub(super) fn mirrored(&self) -> Self {
        let of = |column: usize| {
            let first = across(column) * ROWS;
            self.nodes[first..first + ROWS].iter().map(|d| mirrored(*d))
        };
        Self {
            nodes: (0..COLUMNS).flat_map(of).collect(),
        }
    }

    /// Sets those at the other side of some columns to their mirrored motions; a column in the middle is left.
    pub(super) fn copy_across(&mut self, columns: &[usize]) {
        for (own, other) in columns.iter().map(|c| (*c, across(*c))) {
            for row in 0..if own == other { 0 } else { ROWS } {
                self.nodes[other * ROWS + row] = mirrored(self.nodes[own * ROWS + row]);
            }
        }
    }

    /// The mean of some motions; that of none rests.
    pub(super) fn mean<'a>(all: impl Iterator<Item = &'a Self>) -> Self {
        let mut mean = Self::still();
        let mut count = 0.0_f32;
        for motion in all {
            let pairs = mean.nodes.iter_mut().zip(&motion.nodes);
            pairs.for_each(|(sum, d)| *sum += *d);
            count += 1.0;
        }
        mean.nodes.iter_mut().for_each(|d| *d /= count.max(1.0));
        mean
    }

    /// The motion with lips that do not go through each other: what the one is taken across the line between them beyond the
    /// other is shared by both. Lips that slide need some room.
    pub(super) fn with_lips_apart(mut self) -> Self {
        for column in 1..COLUMNS / 2 {
            for (row, share) in LIP.into_iter().enumerate() {
                let [upper, lower] = [column, COLUMNS - column].map(|c| c * ROWS + row);
                let apart = self.nodes[upper] - self.nodes[lower];
                let slides = apart.x.libm_hypot(apart.z);
                let lacks = 0.5 * share * (SLIDE * slides - apart.y).max(0.0);
                self.nodes[upper].y += lacks;
                self.nodes[lower].y -= lacks;
            }
        }
        self
    }

    /// The displacement at a column and a row, by cubic interpolation.
    fn at(&self, [column, row]: [f32; 2]) -> Vec3 {
        let (c, r) = (column.floor(), row.floor().min((ROWS - 1) as f32));
        let [of_columns, of_rows] = [cubic(column - c), cubic(row.min((ROWS - 1) as f32) - r)];
        let mut sum = Vec3::ZERO;
        for (i, of_column) in of_columns.into_iter().enumerate() {
            let column = (c as usize + COLUMNS + i - 1) % COLUMNS;
            for (j, of_row) in of_rows.into_iter().enumerate() {
                let row = (r as usize + j).saturating_sub(1).min(ROWS - 1);
                sum += of_column * of_row * self.nodes[column * ROWS + row];
            }
        }
        sum
    }

    /// The displacement at a place, by the height of the face.
    pub(super) fn of(&self, place: &Place, side: Side) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for (sheet, share) in [(0, 1.0 - place.lower), (1, place.lower)] {
            if share > 0.0 {
                let [column, row] = cell(place.flat, sheet);
                sum += share
                    * match side {
                        Side::Own => self.at([column, row]),
                        Side::Mirrored => {
                            let half = COLUMNS as f32 / 2.0;
                            let across = (3.0 * half - column).rem_euclid(2.0 * half);
                            mirrored(self.at([across, row]))
                        }
                    };
            }
        }
        place.share * sum
    }

    /// The displacements of all vertices of a surface, metres.
    pub(super) fn over(&self, chart: &MouthChart, side: Side) -> Vec<Vec3> {
        let mut all = vec![Vec3::ZERO; chart.count];
        for place in &chart.places {
            all[place.vertex as usize] = chart.height * self.of(place, side);
        }
        all
    }
}

/// Weights of four nodes for a place between the second and the third (Catmull and Rom 1974).
fn cubic(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        0.5 * (2.0 * t2 - t - t3),
        0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
        0.5 * (t + 4.0 * t2 - 3.0 * t3),
        0.5 * (t3 - t2),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use proptest::prelude::*;

    fn place(x: f32, y: f32) -> Place {
        Place {
            vertex: 0,
            flat: Vec2::new(x, y),
            lower: if y < 0.0 { 1.0 } else { 0.0 },
            share: 1.0,
            inside: 0.0,
            is_seen: true,
        }
    }

    fn some_motion(seed: u32) -> Motion {
        let value = |i: u32| ((i.wrapping_mul(2_654_435_761) >> 8) % 1000) as f32 / 1000.0 - 0.5;
        let node = |n: u32| Vec3::new(value(n), value(n + 1), value(n + 2));
        Motion {
            nodes: (0..(COLUMNS * ROWS) as u32)
                .map(|n| node(3 * n + seed))
                .collect(),
        }
    }

    #[test]
    fn nodes_are_met() {
        let motion = some_motion(1);
        for (column, row) in [(0, 0), (3, 4), (16, 2), (31, 15)] {
            let found = motion.at([column as f32, row as f32]);
            assert!(found.distance(motion.nodes[column * ROWS + row]) < 1e-6);
        }
        // Beyond the last column is the first one again, beyond the last row the last one.
        assert!(motion.at([32.0, 3.0]).distance(motion.nodes[3]) < 1e-6);
        assert!(
            motion
                .at([2.0, 40.0])
                .distance(motion.nodes[2 * ROWS + ROWS - 1])
                < 1e-6
        );
    }

    proptest! {
        #[test]
        fn the_other_side_is_the_mirrored_motion(seed in 0_u32..100, x in -3.0_f32..3.0, y in -3.0_f32..3.0) {
            let motion = some_motion(seed);
            let here = motion.of(&place(x, y), Side::Mirrored);
            prop_assert!(here.distance(mirrored(motion.of(&place(-x, y), Side::Own))) < 1e-3);
            prop_assert!(here.distance(motion.mirrored().of(&place(x, y), Side::Own)) < 1e-3);
        }

        #[test]
        fn lips_do_not_go_through_each_other(seed in 0_u32..100) {
            let before = some_motion(seed);
            let motion = before.clone().with_lips_apart();
            for column in 1..COLUMNS / 2 {
                let [upper, lower] = [column, COLUMNS - column].map(|c| motion.nodes[c * ROWS]);
                let apart = upper - lower;
                prop_assert!(apart.y >= SLIDE * apart.x.hypot(apart.z) - 1e-5, "{column}: {apart}");
                // What both do together stays, and what lies beyond the lips.
                let [a, b] = [column, COLUMNS - column].map(|c| before.nodes[c * ROWS]);
                prop_assert!((upper + lower).distance(a + b) < 1e-5);
                prop_assert_eq!(motion.nodes[column * ROWS + LIP.len()], before.nodes[column * ROWS + LIP.len()]);
            }
        }

        #[test]
        fn a_motion_that_is_even_is_the_same_everywhere(x in -3.0_f32..3.0, y in -3.0_f32..3.0) {
            let even = Motion { nodes: vec![Vec3::new(0.1, -0.2, 0.3); COLUMNS * ROWS] };
            prop_assert!(even.of(&place(x, y), Side::Own).distance(Vec3::new(0.1, -0.2, 0.3)) < 1e-6);
        }
    }
}
