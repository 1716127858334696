//! The motions of all blend shapes of the lower face, and their file.

use super::super::points::{FacePoints, FaceSurface};
use super::super::table::{FaceTable, still_below_least};
use super::super::unfold::SkinFolds;
use super::chart::{COLUMNS, MouthChart, ROWS};
use super::measure;
use super::motion::{Motion, Side};
use glam::Vec3;
use thiserror::Error;

/// The mean motions of ICT-FaceKit (USC Institute for Creative Technologies, MIT licence) and of the woman of MakeHuman
/// (CC0), written by `articula-lab made-shapes --motions` (`docs/methods/faces.md`).
static STORED: &[u8] = include_bytes!("motions.bin");
/// A unit of the file, by the height of the face.
const UNIT: f32 = 2e-5;

/// Blend shapes that are alike on both sides.
const EVEN: [&str; 10] = [
    "jawForward",
    "jawOpen",
    "mouthClose",
    "mouthFunnel",
    "mouthPucker",
    "mouthRollLower",
    "mouthRollUpper",
    "mouthShrugLower",
    "mouthShrugUpper",
    "cheekPuff",
];
/// Blend shapes of one side, without it.
const SIDED: [&str; 11] = [
    "jaw",
    "mouth",
    "mouthSmile",
    "mouthFrown",
    "mouthDimple",
    "mouthStretch",
    "mouthPress",
    "mouthLowerDown",
    "mouthUpperUp",
    "cheekSquint",
    "noseSneer",
];

/// Bytes are no motions of blend shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("motions of the mouth have {expected} bytes, not {found}")]
pub struct BrokenMotions {
    expected: usize,
    found: usize,
}

/// How the lower face moves with each blend shape of jaw, mouth, cheeks and nose, on any head.
#[derive(Debug, Clone, PartialEq)]
pub struct MouthMotions {
    /// In the order of [`EVEN`] and [`SIDED`], these of the left side.
    motions: Vec<Motion>,
}

/// The columns that are stored: all, or those of the left side.
fn columns(index: usize) -> Vec<usize> {
    let is_left = |c: &usize| *c <= COLUMNS / 4 || *c >= 3 * COLUMNS / 4;
    (0..COLUMNS)
        .filter(|c| index >= EVEN.len() || is_left(c))
        .collect()
}

/// What the nodes before the next one let expect of it: a parallelogram with its neighbours in its row and its column.
fn predicted(before: &[i16]) -> i16 {
    let place = before.len();
    let back = |by: usize| before[place - by];
    match (place >= ROWS, !place.is_multiple_of(ROWS)) {
        (true, true) => back(ROWS)
            .wrapping_add(back(1))
            .wrapping_sub(back(ROWS + 1)),
        (true, false) => back(ROWS),
        (false, true) => back(1),
        (false, false) => 0,
    }
}

/// A number with its sign as the lowest bit, so that small ones have small bytes.
fn folded(number: i16) -> u16 {
    ((number << 1) ^ (number >> 15)) as u16
}

fn unfolded(number: u16) -> i16 {
    (number >> 1) as i16 ^ -((number & 1) as i16)
}

impl MouthMotions {
    /// The motions that are kept with the program.
    pub fn stored() -> Self {
        Self::read(STORED).unwrap_or_else(|_| Self::mean(&[]))
    }

    /// The motions that a head shows, with the mean of both sides; those of blend shapes that it does not have rest. `None`
    /// if its feature points lie in a plane, or the tip of the nose (9.3) is not among them.
    pub fn measured(surface: &FaceSurface, points: &FacePoints) -> Option<Self> {
        let chart = MouthChart::new(surface, points)?;
        let fits = measure::fits(&chart);
        let of = |shape: String| {
            let found = surface.shapes.iter().find(|(name, _)| *name == shape);
            Some(measure::motion(&chart, &fits, &found?.1))
        };
        let even = EVEN.iter().map(|name| {
            let motion = of((*name).to_owned());
            [motion.as_ref().map(Motion::mirrored), motion]
        });
        let sided = SIDED.iter().map(|name| {
            let right = of(format!("{name}Right"));
            [
                of(format!("{name}Left")),
                right.as_ref().map(Motion::mirrored),
            ]
        });
        // A closed mouth is one whose jaw is open: alone, it presses the lips together.
        let motion = |(index, sides): (usize, [Option<Motion>; 2])| {
            let mean = Motion::mean(sides.iter().flatten());
            match EVEN.get(index) {
                Some(&"mouthClose") => mean,
                _ => mean.with_lips_apart(),
            }
        };
        let both = even.chain(sided).enumerate();
        Some(Self {
            motions: both.map(motion).collect(),
        })
    }

    /// The mean of some heads; a blend shape is that of the heads that have it.
    pub fn mean(heads: &[Self]) -> Self {
        let of = |index: usize| {
            let all = heads.iter().map(|head| &head.motions[index]);
            Motion::mean(all.filter(|motion| !motion.is_still()))
        };
        Self {
            motions: (0..EVEN.len() + SIDED.len()).map(of).collect(),
        }
    }

    /// Reads what [`MouthMotions::write`] wrote.
    ///
    /// # Errors
    /// [`BrokenMotions`] if there are more or fewer bytes.
    pub fn read(bytes: &[u8]) -> Result<Self, BrokenMotions> {
        let all = EVEN.len() + SIDED.len();
        let expected = (0..all).map(|i| 6 * ROWS * columns(i).len()).sum();
        let found = bytes.len();
        if found != expected {
            return Err(BrokenMotions { expected, found });
        }
        let (low, high) = bytes.split_at(expected / 2);
        let mut differences = low
            .iter()
            .zip(high)
            .map(|(low, high)| unfolded(u16::from_le_bytes([*low, *high])));
        let mut motions = vec![Motion::still(); all];
        for (index, motion) in motions.iter_mut().enumerate() {
            let columns = columns(index);
            for axis in 0..3 {
                let mut units: Vec<i16> = Vec::with_capacity(columns.len() * ROWS);
                for difference in differences.by_ref().take(columns.len() * ROWS) {
                    units.push(difference.wrapping_add(predicted(&units)));
                }
                for (column, units) in columns.iter().zip(units.chunks_exact(ROWS)) {
                    for (node, unit) in motion.nodes[column * ROWS..].iter_mut().zip(units) {
                        node[axis] = UNIT * f32::from(*unit);
                    }
                }
            }
            if index < EVEN.len() {
                motion.copy_across(&columns);
            }
        }
        Ok(Self { motions })
    }

    /// The motions as bytes: for each blend shape and axis, the displacements of all nodes, column by column, in
    /// 50 000ths of the height of the face. Each is a difference of 16 bits from what the nodes before it let expect,
    /// with its sign as the lowest bit; the lower bytes of all come first. Of shapes that are alike on both sides there
    /// are the columns of the left one.
    pub fn write(&self) -> Vec<u8> {
        let mut differences = Vec::new();
        for (index, motion) in self.motions.iter().enumerate() {
            for axis in 0..3 {
                let mut units = Vec::new();
                for column in columns(index) {
                    for displacement in &motion.nodes[column * ROWS..(column + 1) * ROWS] {
                        let unit = (displacement[axis] / UNIT).round() as i16;
                        differences.push(folded(unit.wrapping_sub(predicted(&units))));
                        units.push(unit);
                    }
                }
            }
        }
        let bytes = differences.iter().map(|d| d.to_le_bytes());
        let low = bytes.clone().map(|[low, _]| low);
        low.chain(bytes.map(|[_, high]| high)).collect()
    }

    /// Returns the displacement of each vertex of a head by a blend shape, by its name in ARKit, metres; `None` if it is
    /// none of those that are known. `folds` are those of its skin.
    pub fn displacements(
        &self,
        shape: &str,
        chart: &MouthChart,
        folds: &SkinFolds,
        table: &FaceTable,
    ) -> Option<Vec<Vec3>> {
        let (motion, side) = self.find(shape)?;
        let mut skin = motion.over(chart, side);
        let jaw = shape
            .starts_with("jaw")
            .then(|| table.jaw_of(&skin))
            .flatten();
        for place in chart.places.iter().filter(|p| p.inside > 0.0) {
            let v = place.vertex as usize;
            let with_jaw = jaw.map_or(Vec3::ZERO, |jaw| place.lower * table.with_jaw(v, &jaw));
            skin[v] = skin[v].lerp(with_jaw, place.inside);
        }
        folds.unfold(&mut skin);
        let mut all = table.displacements_of_skin(&skin, jaw.as_ref());
        for place in &chart.others {
            all[place.vertex as usize] = chart.height * motion.of(place, side);
        }
        still_below_least(&mut all);
        Some(all)
    }

    /// The motion of a blend shape that is known, and the side it is taken to.
    fn find(&self, shape: &str) -> Option<(&Motion, Side)> {
        let even = EVEN.iter().position(|name| *name == shape);
        let of_side = |side: &str| {
            let name = shape.strip_suffix(side)?;
            Some(EVEN.len() + SIDED.iter().position(|sided| *sided == name)?)
        };
        let own = even.or_else(|| of_side("Left"));
        let (index, side) = match own {
            Some(index) => (index, Side::Own),
            None => (of_side("Right")?, Side::Mirrored),
        };
        let motion = &self.motions[index];
        (!motion.is_still()).then_some((motion, side))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stored(shape: &str) -> Motion {
        let motions = MouthMotions::stored();
        let (motion, side) = motions.find(shape).unwrap();
        match side {
            Side::Own => motion.clone(),
            Side::Mirrored => motion.mirrored(),
        }
    }

    /// The displacement at a column of the chart, 0 at the left corner, 8 at the middle of the upper lip, 24 of the lower.
    fn at(motion: &Motion, column: usize, row: usize) -> Vec3 {
        motion.nodes[column * ROWS + row]
    }

    #[test]
    fn the_file_holds_all_motions() {
        let motions = MouthMotions::stored();
        assert_eq!(motions.write(), STORED);
        assert!(motions.motions.iter().all(|motion| !motion.is_still()));
        let broken = MouthMotions::read(&STORED[1..]).unwrap_err();
        assert_eq!(
            broken.to_string(),
            format!(
                "motions of the mouth have {} bytes, not {}",
                STORED.len(),
                STORED.len() - 1
            )
        );
    }

    #[test]
    fn the_greatest_motions_are_kept() {
        let motion = |step: usize| {
            let unit = |i: usize| UNIT * f32::from([i16::MIN, i16::MAX, -1, 0, 2][i * step % 5]);
            let node = |n: usize| Vec3::new(unit(n), unit(n + 1), unit(n + 2));
            let nodes = (0..COLUMNS * ROWS).map(node).collect();
            Motion { nodes }
        };
        let motions = (1..=EVEN.len() + SIDED.len()).map(motion).collect();
        let mut all = MouthMotions { motions };
        for motion in &mut all.motions[..EVEN.len()] {
            motion.copy_across(&columns(0));
        }
        assert_eq!(MouthMotions::read(&all.write()).unwrap(), all);
    }

    #[test]
    fn even_shapes_are_their_own_mirror() {
        for shape in EVEN {
            let motion = stored(shape);
            for (a, b) in motion.nodes.iter().zip(&motion.mirrored().nodes) {
                assert!(a.distance(*b) < 2.0 * UNIT, "{shape}: {a} {b}");
            }
        }
        for shape in SIDED {
            let [left, right] = ["Left", "Right"].map(|side| stored(&format!("{shape}{side}")));
            assert_eq!(left.mirrored(), right, "{shape}");
        }
        assert!(MouthMotions::stored().find("eyeBlinkLeft").is_none());
    }

    #[test]
    fn the_brow_rests() {
        // The outermost row above the mouth is at the forehead.
        for shape in EVEN {
            let moved = at(&stored(shape), COLUMNS / 4, ROWS - 1).length();
            assert!(moved < 0.01, "{shape}: {moved}");
        }
    }

    #[test]
    fn an_open_jaw_takes_the_lower_lip_and_leaves_the_upper_one() {
        let motion = stored("jawOpen");
        let [upper, lower, chin] = [at(&motion, 8, 0), at(&motion, 24, 0), at(&motion, 24, 8)];
        // A human face is 135 mm high, and its chin goes down by 30 to 45 mm.
        assert!(
            (0.2..0.35).contains(&chin.length()) && chin.y < 0.0,
            "{chin}"
        );
        assert!(lower.y < 0.6 * chin.y && upper.length() < 0.1 * lower.length());
        // The opening is an oval: it narrows towards the corners.
        let open: Vec<f32> = (0..=8)
            .map(|c| at(&motion, c, 0).y - at(&motion, (32 - c) % 32, 0).y)
            .collect();
        assert!(
            open.windows(2).all(|pair| pair[0] <= pair[1] + 1e-3),
            "{open:?}"
        );
    }

    #[test]
    fn a_smile_lifts_its_corner_and_leaves_the_other() {
        let motion = stored("mouthSmileLeft");
        let [left, right] = [at(&motion, 0, 0), at(&motion, 16, 0)];
        assert!(left.x > 0.02 && left.y > 0.02, "{left}");
        assert!(right.length() < 0.3 * left.length(), "{right}");
    }

    #[test]
    fn a_pucker_draws_the_corners_in_and_the_lips_out() {
        let motion = stored("mouthPucker");
        let [left, upper, lower] = [at(&motion, 0, 0), at(&motion, 8, 1), at(&motion, 24, 1)];
        assert!(left.x < -0.02, "{left}");
        assert!(upper.z > 0.01 && lower.z > 0.01, "{upper} {lower}");
    }

    #[test]
    fn heads_without_a_shape_do_not_count_in_its_mean() {
        let stored = MouthMotions::stored();
        let mut without = stored.clone();
        without.motions[1] = Motion::still();
        let mean = MouthMotions::mean(&[stored.clone(), without]);
        assert_eq!(mean.motions[1], stored.motions[1]);
        assert!(MouthMotions::mean(&[]).find("jawOpen").is_none());
    }
}
