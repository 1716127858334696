//! Up axis and length unit of a motion file; most files state neither.
//!
//! Source: measured on the files of five families of writers; see `docs/formats/bvh.md`.

use crate::error::{Assumption, ReadError, Warning};
use glam::{Quat, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Largest number that is meaningful in any unit; sums and products of such numbers stay finite.
pub(crate) const MAX_NUMBER: f32 = 1e9;

/// Number of frames that are sampled to detect the up axis.
const FRAMES_LOOKED_AT: usize = 32;

/// The axis that points up in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UpAxis {
    /// Detected from the position of the head.
    #[default]
    Auto,
    /// +Y, as in most files.
    Y,
    /// +Z, as in files from Blender and some capture systems.
    Z,
}

/// Heights at rest that need no scale, in metres.
const METRES: std::ops::RangeInclusive<f32> = 0.5..=3.0;
/// Heights of joints of adults, in metres.
pub(crate) const ADULT: std::ops::RangeInclusive<f32> = 1.3..=2.1;
/// Height that a figure of unknown unit is scaled to, in metres.
const ASSUMED_METRES: f32 = 1.7;
/// Known units, the most common first: name and metres.
const UNITS: [(&str, f32); 5] = [
    ("centimetres", 0.01),
    ("inches", 0.0254),
    ("decimetres", 0.1),
    ("the CMU unit (inch / 0.45)", 0.0254 / 0.45),
    ("millimetres", 0.001),
];

/// Returns the scale that the caller gives, else the guess (with a description that becomes a
/// warning).
///
/// # Errors
/// [`ReadError::Malformed`] if the caller's scale is not a valid scale.
pub(crate) fn scale_to_metres(
    given: Option<f32>,
    guess: impl FnOnce() -> (f32, Option<String>),
    warnings: &mut Vec<Warning>,
) -> Result<f32, ReadError> {
    match given {
        Some(scale) if scale > 0.0 && scale <= MAX_NUMBER => Ok(scale),
        Some(scale) => {
            let what = format!("the scale must be above 0, found {scale} m");
            Err(ReadError::malformed("options", what))
        }
        None => {
            let (scale, how) = guess();
            warnings.extend(how.map(|what| Warning::guess("file", what, Assumption::Unit)));
            Ok(scale)
        }
    }
}

/// Returns metres per unit, and how that was determined; `height` is that of the rest figure in
/// file units. `None` as description means that nothing was guessed.
pub(crate) fn scale(height: f32) -> (f32, Option<String>) {
    if METRES.contains(&height) || height < 1e-9 {
        return (1.0, None);
    }
    let adult = UNITS
        .iter()
        .find(|(_, unit)| ADULT.contains(&(height * unit)));
    // A child or a giant is far more often in centimetres than in anything else.
    let centimetres = || Some(&UNITS[0]).filter(|(_, unit)| METRES.contains(&(height * unit)));
    let (how, scale) = match adult.or_else(centimetres) {
        Some((name, unit)) => (format!("read as {name}"), *unit),
        None => (
            format!("of an unknown unit, scaled to {ASSUMED_METRES} m"),
            ASSUMED_METRES / height,
        ),
    };
    let what = format!("the figure is {height} units high at rest, {how}: 1 unit = {scale} m");
    (scale, Some(what))
}

/// Returns the rotation that turns +Z up into +Y up.
pub(crate) fn y_from_z() -> Quat {
    Quat::from_rotation_x(-FRAC_PI_2)
}

/// The figure at rest, in file units, from which its posture is determined.
pub(crate) struct Figure<'a> {
    pub(crate) names: Vec<&'a str>,
    /// Parents before children.
    pub(crate) parents: Vec<Option<usize>>,
    pub(crate) places: Vec<Vec3>,
}

/// Returns the positions of head and root in one frame; the chain leads from head to root.
type HeadAndRoot<'a> = dyn Fn(usize, &[usize]) -> (Vec3, Vec3) + 'a;

/// The motion of a figure.
pub(crate) struct Motion<'a> {
    pub(crate) frames: usize,
    pub(crate) head_and_root: &'a HeadAndRoot<'a>,
}

impl Figure<'_> {
    /// Returns whether the rest figure and the motion have +Z up. `up` decides unless it is
    /// [`UpAxis::Auto`]; a detected turn is reported as a warning.
    pub(crate) fn has_z_up(
        &self,
        up: UpAxis,
        motion: Option<Motion<'_>>,
        warnings: &mut Vec<Warning>,
    ) -> (bool, bool) {
        let (figure, world) = match up {
            UpAxis::Y => return (false, false),
            UpAxis::Z => return (true, true),
            UpAxis::Auto => self.stands_along_z(motion),
        };
        if world {
            let which = if figure {
                "the figure and its world"
            } else {
                "the world of the motion"
            };
            let what = format!("+Z is up; {which} are rotated to +Y");
            warnings.push(Warning::guess("file", what, Assumption::UpAxis));
        }
        (figure, world)
    }

    fn stands_along_z(&self, motion: Option<Motion<'_>>) -> (bool, bool) {
        let is_head = |name: &&str| name.to_ascii_lowercase().contains("head");
        let Some(head) = self.names.iter().position(is_head) else {
            return (false, false);
        };
        let mut chain = vec![head];
        while let Some(parent) = self.parents[chain[chain.len() - 1]] {
            chain.push(parent);
        }
        let root = chain[chain.len() - 1];
        if points_along_z(self.places[head] - self.places[root]) {
            return (true, true);
        }
        let Some(motion) = motion.filter(|m| m.frames > 0) else {
            return (false, false);
        };
        let lowest = self.places.iter().map(|p| p.y).fold(f32::MAX, f32::min);
        let (head_from_root, place) = motion.mean_stand(&chain);
        let hip_height = self.places[root].y - lowest;
        (
            false,
            motion_stands_along_z(head_from_root, place, hip_height),
        )
    }
}

impl Motion<'_> {
    /// Returns the mean offset from root to head, and the mean position of the root.
    fn mean_stand(&self, chain: &[usize]) -> (Vec3, Vec3) {
        let step = self.frames.div_ceil(FRAMES_LOOKED_AT);
        let looked_at = (0..self.frames).step_by(step);
        let share = 1.0 / looked_at.len() as f32;
        let mut head_from_root = Vec3::ZERO;
        let mut place = Vec3::ZERO;
        for frame in looked_at {
            let (head, root) = (self.head_and_root)(frame, chain);
            head_from_root += (head - root) * share;
            place += root * share;
        }
        (head_from_root, place)
    }
}

/// Returns the extent along an axis (0 to 2); 0 without points.
pub(crate) fn extent(points: impl Iterator<Item = Vec3>, axis: usize) -> f32 {
    let along = points.map(|p| p[axis]);
    let (low, high) = along.fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(v), h.max(v)));
    (high - low).max(0.0)
}

/// Returns whether the offset from hips to head points along +Z rather than along Y.
fn points_along_z(head_from_root: Vec3) -> bool {
    head_from_root.z > head_from_root.y.abs()
}

/// Returns whether a motion has +Z up although its rest figure has +Y up: the head is above the
/// hips along Z, and the hips are about as far from the floor as at rest. (A person who lies on the
/// floor of a +Y world fails the second test.)
fn motion_stands_along_z(head_from_root: Vec3, root: Vec3, hip_height: f32) -> bool {
    let standing = 0.5 * hip_height..1.5 * hip_height;
    points_along_z(head_from_root) && standing.contains(&root.z) && root.y.abs() < 0.5 * root.z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_figures_get_their_unit() {
        let unit = |height: f32| scale(height).0;
        assert_eq!(unit(1.7), 1.0);
        assert_eq!(unit(170.0), 0.01);
        assert_eq!(unit(64.0), 0.0254);
        assert_eq!(unit(16.5), 0.1);
        assert_eq!(unit(25.6), 0.0254 / 0.45);
        assert_eq!(unit(1700.0), 0.001);
        assert_eq!(unit(100.0), 0.01, "a child in centimetres");
        assert!(
            (unit(45.4) * 45.4 - 1.7).abs() < 1e-5,
            "FAIR1 files have no known unit"
        );
        assert!((unit(1e6) * 1e6 - 1.7).abs() < 1e-3);
        assert_eq!(unit(0.0), 1.0, "a point has no height");
        assert!(scale(1.7).1.is_none() && scale(170.0).1.is_some());
    }

    #[test]
    fn lying_on_the_floor_is_no_other_up() {
        let head = Vec3::new(0.0, 0.1, 0.6);
        assert!(!motion_stands_along_z(head, Vec3::new(0.0, 0.1, 0.0), 0.9));
        assert!(motion_stands_along_z(head, Vec3::new(0.3, 0.1, 0.9), 0.9));
        assert!((y_from_z() * Vec3::Z - Vec3::Y).length() < 1e-6);
    }
}
