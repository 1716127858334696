//! Which way is up in a BVH file, and how long its unit is: neither is written in it.
//!
//! Source: measured on the files of five families of writers; see `docs/formats/bvh.md`.

use glam::{Quat, Vec3};
use std::f32::consts::FRAC_PI_2;

/// The axis that points up in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Up {
    /// Told from where the head is.
    #[default]
    Auto,
    /// +Y, as most files have it.
    Y,
    /// +Z, as files from Blender and some capture systems have it.
    Z,
}

/// Heights at rest that need no scale, in metres.
const METRES: std::ops::RangeInclusive<f32> = 0.5..=3.0;
/// Heights of joints of adults, in metres.
const ADULT: std::ops::RangeInclusive<f32> = 1.3..=2.1;
/// Height that a figure of unknown unit is given, in metres.
const ASSUMED_METRES: f32 = 1.7;
/// Known units, the most usual first: name and metres.
const UNITS: [(&str, f32); 5] = [
    ("centimetres", 0.01),
    ("inches", 0.0254),
    ("decimetres", 0.1),
    ("the CMU unit (inch / 0.45)", 0.0254 / 0.45),
    ("millimetres", 0.001),
];

/// Metres of one unit, and how that was found; `height` is the rest figure's in file units.
/// No words if nothing had to be guessed.
pub(super) fn scale(height: f32) -> (f32, Option<String>) {
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
    let what = format!(
        "the figure is {height} units high at rest, {how}: 1 unit = {scale} m; \
         give the scale to metres if that is wrong"
    );
    (scale, Some(what))
}

/// Rotation that brings +Z up to +Y.
pub(super) fn y_from_z() -> Quat {
    Quat::from_rotation_x(-FRAC_PI_2)
}

/// Whether the way from the hips to the head goes along +Z rather than along Y.
pub(super) fn points_along_z(head_from_root: Vec3) -> bool {
    head_from_root.z > head_from_root.y.abs()
}

/// Whether a motion stands along +Z although its rest figure stands along +Y: the head is
/// above the hips along Z, and the hips are about as far from the floor as at rest. (A person
/// who lies on the floor of a +Y world fails the second test.)
pub(super) fn motion_stands_along_z(head_from_root: Vec3, root: Vec3, hip_height: f32) -> bool {
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
