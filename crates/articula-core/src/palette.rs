//! Palettes: the joint matrices that evaluation writes for a character, and their format.
//!
//! Source: `docs/methods/runtime.md` part 3 (output choices). A palette holds one entry for each
//! joint that a level keeps, or for each binding of a skin; entries are sorted by
//! [place](JointLods::place), so the palette of a level is a prefix of the full one.

use crate::Mismatch;
use crate::joint_lods::JointLods;
use glam::{Affine3A, Quat, Vec3};

/// Format of a palette entry: rows of four numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum PaletteForm {
    /// Three rows of a 3x4 matrix, f32: 48 bytes.
    #[default]
    Matrix,
    /// Three rows of a 3x4 matrix, half floats: 24 bytes; exact to 1/2048 of each number.
    HalfMatrix,
    /// Unit quaternion (x, y, z, w), then translation and a one, f32: 32 bytes. Only for joints
    /// without scale, in themselves or above.
    Rigid,
    /// [`PaletteForm::Rigid`] in half floats: 16 bytes.
    HalfRigid,
}

impl PaletteForm {
    /// Number of rows of four numbers per entry.
    pub fn rows(self) -> usize {
        match self {
            Self::Matrix | Self::HalfMatrix => 3,
            Self::Rigid | Self::HalfRigid => 2,
        }
    }

    /// Number of bytes per entry.
    pub fn bytes(self) -> usize {
        match self {
            Self::Matrix => 48,
            Self::Rigid => 32,
            Self::HalfMatrix => 24,
            Self::HalfRigid => 16,
        }
    }

    /// Whether the numbers are half floats.
    pub fn is_half(self) -> bool {
        matches!(self, Self::HalfMatrix | Self::HalfRigid)
    }

    /// Whether an entry holds only a rotation and a translation.
    pub fn is_rigid(self) -> bool {
        matches!(self, Self::Rigid | Self::HalfRigid)
    }
}

/// Output buffer for palettes, as rows of four numbers.
#[derive(Debug)]
pub enum PaletteRows<'a> {
    /// For the forms in f32.
    Float(&'a mut [[f32; 4]]),
    /// For the forms in half floats, as bits.
    Half(&'a mut [[u16; 4]]),
}

impl PaletteRows<'_> {
    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Float(rows) => rows.len(),
            Self::Half(rows) => rows.len(),
        }
    }

    /// Reborrows a range of the rows.
    ///
    /// # Panics
    /// If the range reaches beyond the rows.
    pub fn part(&mut self, range: std::ops::Range<usize>) -> PaletteRows<'_> {
        match self {
            Self::Float(rows) => PaletteRows::Float(&mut rows[range]),
            Self::Half(rows) => PaletteRows::Half(&mut rows[range]),
        }
    }
}

/// An inverse bind matrix, prepared for matrix and rigid forms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bind {
    /// Rows of the 3x4 matrix.
    pub(crate) rows: [[f32; 4]; 3],
    /// Rotation and translation; only read where the matrix is rigid.
    pub(crate) rotation: Quat,
    pub(crate) translation: Vec3,
}

/// One entry of a palette.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Entry {
    /// Place of the joint in the LOD order.
    pub(crate) place: u16,
    /// Inverse bind matrix that the joint's matrix is multiplied by, if any.
    pub(crate) bind: Option<Bind>,
}

/// Layout of a palette: the joint and inverse bind matrix of each entry, and the number of entries
/// at each level.
#[derive(Debug, Clone, PartialEq)]
pub struct PaletteMap {
    entries: Vec<Entry>,
    counts: Vec<usize>,
    rigid: bool,
}

impl PaletteMap {
    /// Model-from-joint matrices of the joints that a level keeps, in LOD order.
    pub fn joints(joint_lods: &JointLods) -> Self {
        let entry = |place| Entry { place, bind: None };
        Self {
            entries: (0..joint_lods.joints().len() as u16).map(entry).collect(),
            counts: (0..joint_lods.levels())
                .map(|l| joint_lods.joint_count(l))
                .collect(),
            rigid: true,
        }
    }

    /// Skinning matrices: each joint's matrix times an inverse bind matrix. `bindings` has the
    /// place ([`JointLods::place`]) and the inverse bind matrix of each entry, sorted by place.
    ///
    /// # Errors
    /// A [`Mismatch`] if a place is not in the LOD order or smaller than the one before, or a
    /// matrix is not finite.
    pub fn skin(joint_lods: &JointLods, bindings: &[(u16, Affine3A)]) -> Result<Self, Mismatch> {
        let mut entries = Vec::with_capacity(bindings.len());
        let mut rigid = true;
        for (i, (place, matrix)) in bindings.iter().enumerate() {
            let at = || format!("bindings[{i}]");
            let last = entries.last().map_or(0, |e: &Entry| e.place);
            if usize::from(*place) >= joint_lods.joints().len() || *place < last {
                let what = format!(
                    "joint index {place} must be below {} and not less than the one before",
                    joint_lods.joints().len()
                );
                return Err(Mismatch::new(at(), what));
            }
            if !matrix.is_finite() {
                return Err(Mismatch::new(
                    at(),
                    "the inverse bind matrix must be finite",
                ));
            }
            rigid &= is_rigid(matrix);
            entries.push(Entry {
                place: *place,
                bind: Some(bind(matrix)),
            });
        }
        let count = |level| {
            entries.partition_point(|e| usize::from(e.place) < joint_lods.joint_count(level))
        };
        Ok(Self {
            counts: (0..joint_lods.levels()).map(count).collect(),
            entries,
            rigid,
        })
    }

    /// Number of entries of a palette at a level.
    pub fn len(&self, level: usize) -> usize {
        self.counts[level]
    }

    /// Place of the joint of each entry.
    pub(crate) fn places(&self) -> impl ExactSizeIterator<Item = usize> + '_ {
        self.entries.iter().map(|e| usize::from(e.place))
    }

    /// Whether every inverse bind matrix is a rotation and a translation.
    pub(crate) fn is_rigid(&self) -> bool {
        self.rigid
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.counts.len()
    }

    pub(crate) fn entries(&self, level: usize) -> &[Entry] {
        &self.entries[..self.counts[level]]
    }
}

fn bind(matrix: &Affine3A) -> Bind {
    let (_, rotation, translation) = matrix.to_scale_rotation_translation();
    Bind {
        rows: rows_of(matrix),
        rotation,
        translation,
    }
}

/// The three rows of a 3x4 matrix.
pub(crate) fn rows_of(matrix: &Affine3A) -> [[f32; 4]; 3] {
    let m = matrix.matrix3.transpose();
    let t = Vec3::from(matrix.translation);
    let row = |r: glam::Vec3A, t: f32| [r.x, r.y, r.z, t];
    [row(m.x_axis, t.x), row(m.y_axis, t.y), row(m.z_axis, t.z)]
}

/// Whether a matrix preserves lengths and angles, within the precision of f32 files.
fn is_rigid(matrix: &Affine3A) -> bool {
    let m = matrix.matrix3;
    let product = m.transpose() * m;
    let off = product - glam::Mat3A::IDENTITY;
    let largest = [off.x_axis, off.y_axis, off.z_axis]
        .map(|c| c.abs().max_element())
        .into_iter()
        .fold(0.0, f32::max);
    largest < 1e-4 && m.determinant() > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_set::JointSet;
    use crate::rig::tests::rig_of;

    #[test]
    fn a_level_is_a_prefix_of_the_palette() {
        let rig = rig_of(&[
            (None, Vec3::ZERO, 0),
            (Some(0), Vec3::Y, 0),
            (Some(1), Vec3::Y, 0),
        ]);
        let sets = [JointSet::first(2)];
        let joint_lods = JointLods::of_sets(&rig, &sets, rig.rest_pose()).unwrap();
        let joints = PaletteMap::joints(&joint_lods);
        assert_eq!([joints.len(0), joints.len(1)], [3, 2]);
        // Two parts of a mesh are bound to the first joint, none to the second.
        let scaled = Affine3A::from_scale(Vec3::splat(2.0));
        let bindings = [
            (0, Affine3A::IDENTITY),
            (0, scaled),
            (2, Affine3A::IDENTITY),
        ];
        let skin = PaletteMap::skin(&joint_lods, &bindings).unwrap();
        assert_eq!([skin.len(0), skin.len(1)], [3, 2]);
        assert!(joints.is_rigid() && !skin.is_rigid());
        let falling = [(1, scaled), (0, scaled)];
        assert_eq!(
            PaletteMap::skin(&joint_lods, &falling).unwrap_err().at,
            "bindings[1]"
        );
        let beyond = [(3, scaled)];
        assert_eq!(
            PaletteMap::skin(&joint_lods, &beyond).unwrap_err().at,
            "bindings[0]"
        );
        let bad = [(0, Affine3A::from_scale(Vec3::splat(f32::NAN)))];
        assert_eq!(
            PaletteMap::skin(&joint_lods, &bad).unwrap_err().at,
            "bindings[0]"
        );
    }
}
