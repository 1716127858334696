//! Up axis and length unit of a motion file; most files state neither.
//!
//! Source: measured on the files of five families of writers; see `docs/formats/bvh.md`.

use crate::error::{Assumption, ReadError, Warning};
use crate::stature::{Bones, Stature};
use articula_core::LibmQuat;
use glam::{Quat, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Largest number that is meaningful in any unit; sums and products of such numbers stay finite.
pub(crate) const MAX_NUMBER: f32 = 1e9;

/// Maximum number of frames that are sampled to detect the up axis and the lengths of bones.
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

/// Heights that need no scale, in metres.
const METRES: std::ops::RangeInclusive<f32> = 0.5..=3.0;
/// Heights of joints of adults, in metres.
pub(crate) const ADULT: std::ops::RangeInclusive<f32> = 1.3..=2.1;
/// Heights of children and giants, in metres.
const ANY_HUMAN: std::ops::RangeInclusive<f32> = 0.5..=10.0;
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
/// Least height of the head above the root, or above a toe, at rest, as a fraction of the bones
/// between them, of a figure whose trunk is upright, or that stands.
const UPRIGHT: f32 = 0.7;
/// Heights of a standing rest figure, as multiples of the stature by its bones.
const STANDING: std::ops::RangeInclusive<f32> = 0.8..=1.25;

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

/// Size of a figure, in file units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Size {
    /// A human whose rest figure stands and has this height.
    Standing(f32),
    /// A human whose rest figure does not stand; the stature by its bones.
    ByBones(f32),
    /// Not a human; the height of a human with the same longest path.
    Other(f32),
}

impl Size {
    pub(crate) fn height(self) -> f32 {
        match self {
            Self::Standing(height) | Self::ByBones(height) | Self::Other(height) => height,
        }
    }
}

/// Returns metres per unit, and how that was determined. `None` as description means that nothing
/// was guessed.
pub(crate) fn scale(size: Size) -> (f32, Option<String>) {
    let height = size.height();
    if METRES.contains(&height) || height < 1e-9 {
        return (1.0, None);
    }
    let centimetres = &UNITS[0];
    let read_as = |(name, unit): &(&str, f32)| (format!("read as {name}"), *unit);
    let fits = |range: std::ops::RangeInclusive<f32>| {
        move |(_, unit): &&(&str, f32)| range.contains(&(height * unit))
    };
    let (figure, (how, scale)) = match size {
        // The height of an animal says nothing about the unit; most files are in centimetres.
        Size::Other(_) => ("no human".to_owned(), read_as(centimetres)),
        Size::Standing(_) | Size::ByBones(_) => {
            let adult = UNITS.iter().find(fits(ADULT));
            // A child or a giant is far more often in centimetres than in anything else.
            let known = adult.or_else(|| Some(centimetres).filter(fits(ANY_HUMAN)));
            let unknown = || {
                let how = format!("of an unknown unit, scaled to {ASSUMED_METRES} m");
                (how, ASSUMED_METRES / height)
            };
            let measured = match size {
                Size::ByBones(_) => "tall by the lengths of its bones (it does not stand at rest)",
                _ => "high at rest",
            };
            let figure = format!("{height} units {measured}");
            (figure, known.map_or_else(unknown, read_as))
        }
    };
    let what = format!("the figure is {figure}, {how}: 1 unit = {scale} m");
    (scale, Some(what))
}

/// Returns the rotation that turns +Z up into +Y up.
pub(crate) fn y_from_z() -> Quat {
    Quat::libm_rotation_x(-FRAC_PI_2)
}

/// The figure at rest, in file units, from which its posture and size are determined.
pub(crate) struct Figure<'a> {
    pub(crate) names: Vec<&'a str>,
    /// Parents before children.
    pub(crate) parents: Vec<Option<usize>>,
    pub(crate) places: Vec<Vec3>,
    /// Length of the bone that leads to each joint from its parent; 0 for a root, and for a joint
    /// that moves against its parent.
    pub(crate) lengths: Vec<f32>,
    /// Joint and offset (in model space, at rest) of the ends of bones without a joint.
    pub(crate) ends: Vec<(usize, Vec3)>,
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

    /// Returns the size; `z_up` is whether the rest figure has +Z up.
    pub(crate) fn size(&self, z_up: bool) -> Size {
        let up = if z_up { 2 } else { 1 };
        match self.bones().stature(self.head()) {
            Stature::Other(height) => Size::Other(height),
            stature @ Stature::Human(_) if self.stands(stature, up) => {
                Size::Standing(self.height(up))
            }
            Stature::Human(stature) => Size::ByBones(stature),
        }
    }

    /// Returns the extent of joints and end sites at rest along an axis.
    fn height(&self, axis: usize) -> f32 {
        let ends = self
            .ends
            .iter()
            .map(|(j, offset)| self.places[*j] + *offset);
        extent(self.places.iter().copied().chain(ends), axis)
    }

    /// Returns whether the rest figure stands along an axis: its trunk is upright, and a human is
    /// about as high as its bones say, with the head above the toes. (With all bones along one axis,
    /// the toes are as high as the chest.)
    fn stands(&self, stature: Stature, axis: usize) -> bool {
        let head = self.head();
        let upright = head.is_none_or(|head| self.is_upright(&self.chain(head), axis));
        upright
            && match stature {
                Stature::Human(stature) => {
                    let on_toes = head.is_none_or(|head| self.is_above_toes(head, axis));
                    on_toes && STANDING.contains(&(self.height(axis) / stature))
                }
                Stature::Other(_) => true,
            }
    }

    fn is_above_toes(&self, head: usize, axis: usize) -> bool {
        let (length, toe) = self.bones().path_from(head);
        let place = match toe.checked_sub(self.places.len()) {
            None => self.places[toe],
            Some(end) => {
                let (joint, offset) = self.ends[end];
                self.places[joint] + offset
            }
        };
        (self.places[head] - place)[axis] > UPRIGHT * length
    }

    fn bones(&self) -> Bones {
        let (ends, offsets): (Vec<usize>, Vec<Vec3>) = self.ends.iter().copied().unzip();
        let parents = self.parents.iter().copied();
        let lengths = self.lengths.iter().copied();
        Bones {
            parents: parents.chain(ends.into_iter().map(Some)).collect(),
            lengths: lengths.chain(offsets.iter().map(|o| o.length())).collect(),
        }
    }

    fn head(&self) -> Option<usize> {
        let is_head = |name: &&str| name.to_ascii_lowercase().contains("head");
        self.names.iter().position(is_head)
    }

    /// Returns the joints from one to its root.
    fn chain(&self, joint: usize) -> Vec<usize> {
        let mut chain = vec![joint];
        while let Some(parent) = self.parents[chain[chain.len() - 1]] {
            chain.push(parent);
        }
        chain
    }

    /// Returns whether the first joint of a chain is above the last at rest, with the bones between
    /// them nearly along the axis.
    fn is_upright(&self, chain: &[usize], axis: usize) -> bool {
        let [top, .., root] = *chain else {
            return false;
        };
        let bones = chain.windows(2);
        let length: f32 = bones
            .map(|b| self.places[b[0]].distance(self.places[b[1]]))
            .sum();
        (self.places[top] - self.places[root])[axis] > UPRIGHT * length
    }

    /// The motion decides where the rest figure does not stand, and where it stands along another
    /// axis than at rest.
    fn stands_along_z(&self, motion: Option<Motion<'_>>) -> (bool, bool) {
        let Some(head) = self.head() else {
            return (false, false);
        };
        let chain = self.chain(head);
        let root = chain[chain.len() - 1];
        let rest_is_along_z = points_along_z(self.places[head] - self.places[root]);
        let Some(motion) = motion.filter(|m| m.frames > 0) else {
            return (rest_is_along_z, rest_is_along_z);
        };
        let (head_from_root, place) = motion.mean_stand(&chain);
        let stature = self.bones().stature(Some(head));
        let stands = |axis| self.stands(stature, axis);
        let hip_height = |axis: usize| {
            let heights = self.places.iter().map(|p| p[axis]);
            self.places[root][axis] - heights.fold(f32::MAX, f32::min)
        };
        if rest_is_along_z && stands(2) {
            let in_y = stands_along(1, head_from_root, place, hip_height(2));
            (!in_y, !in_y)
        } else if !rest_is_along_z && stands(1) {
            (false, stands_along(2, head_from_root, place, hip_height(1)))
        } else {
            let z_up = points_along_z(head_from_root);
            (z_up, z_up)
        }
    }
}

impl Motion<'_> {
    /// Returns the mean offset from root to head, and the mean position of the root.
    fn mean_stand(&self, chain: &[usize]) -> (Vec3, Vec3) {
        let looked_at = frames_looked_at(self.frames);
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

/// Returns evenly spaced frames, at most as many as are sampled.
pub(crate) fn frames_looked_at(frames: usize) -> std::iter::StepBy<std::ops::Range<usize>> {
    (0..frames).step_by(frames.div_ceil(FRAMES_LOOKED_AT).max(1))
}

/// Returns the extent along an axis (0 to 2); 0 without points.
fn extent(points: impl Iterator<Item = Vec3>, axis: usize) -> f32 {
    let along = points.map(|p| p[axis]);
    let (low, high) = along.fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(v), h.max(v)));
    (high - low).max(0.0)
}

/// Returns whether the offset from hips to head points along +Z rather than along Y.
fn points_along_z(head_from_root: Vec3) -> bool {
    head_from_root.z > head_from_root.y.abs()
}

/// Returns whether a motion has +Y (1) or +Z (2) up although its rest figure stands along the other
/// axis: the head is above the hips along the axis, and the hips are about as far from the floor as
/// at rest. (A person who lies on the floor fails the second test.)
fn stands_along(axis: usize, head_from_root: Vec3, root: Vec3, hip_height: f32) -> bool {
    let other = 3 - axis;
    let standing = 0.5 * hip_height..1.5 * hip_height;
    head_from_root[axis] > head_from_root[other].abs()
        && standing.contains(&root[axis])
        && root[other].abs() < 0.5 * root[axis]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_figures_get_their_unit() {
        let unit = |height: f32| scale(Size::Standing(height)).0;
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
        let told = |size| scale(size).1;
        assert!(told(Size::Standing(1.7)).is_none() && told(Size::Standing(170.0)).is_some());
        assert_eq!(unit(430.0), 0.01, "a giant in centimetres");
        for size in [16.5, 64.0, 7800.0] {
            assert_eq!(scale(Size::Other(size)).0, 0.01, "an animal in centimetres");
        }
    }

    #[test]
    fn lying_on_the_floor_is_no_other_up() {
        let head = Vec3::new(0.0, 0.1, 0.6);
        assert!(!stands_along(2, head, Vec3::new(0.0, 0.1, 0.0), 0.9));
        assert!(stands_along(2, head, Vec3::new(0.3, 0.1, 0.9), 0.9));
        assert!((y_from_z() * Vec3::Z - Vec3::Y).length() < 1e-6);
    }
}
