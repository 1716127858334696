//! Joint schemes: the two sets of 89 joints that make a whole body.
//!
//! Source: thesis 3.1.3, tables 3.2 to 3.4; `docs/methods/hanim.md` part 4. The regions of the
//! thesis count 4 joints of the feet and 40 of the hands, which no partition of the standard's 89
//! joints gives; without the subtalars and with a fourth joint in each thumb they fit.

use articula_core::Mismatch;
use articula_core::hanim_table::{BODY_JOINTS, HanimJoint, JOINTS, THUMB_BASES};
use std::fmt;
use std::str::FromStr;

/// A set of 89 joints of the body; the face joints of the full standard set are in both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum JointScheme {
    /// The body joints of H-Anim 1.1: 6 joints of the feet, 38 of the hands.
    #[default]
    Hanim,
    /// Those that the thesis counts: without subtalars, with `thumb0` joints; 4 joints of the feet,
    /// 40 of the hands.
    Thesis,
}

impl JointScheme {
    /// Both schemes.
    pub const ALL: [Self; 2] = [Self::Hanim, Self::Thesis];

    /// Returns the 89 joints of a body, parents before children. Parents are indices in
    /// [`JOINTS`], which has the standard's tree: the joints of the other scheme are not cut out of
    /// it.
    pub fn body(self) -> impl Iterator<Item = &'static HanimJoint> {
        let bases = THUMB_BASES.iter();
        let table = JOINTS[..BODY_JOINTS].iter();
        table
            .chain(bases.filter(move |_| self == Self::Thesis))
            .filter(move |joint| self.has(joint.name))
    }

    /// Returns whether a body of this scheme may have a joint of this H-Anim 1.1 name: not if it is
    /// one of the four by which the schemes differ and belongs to the other.
    pub fn has(self, hanim: &str) -> bool {
        let is_base = THUMB_BASES.iter().any(|base| base.name == hanim);
        match self {
            Self::Hanim => !is_base,
            Self::Thesis => !matches!(hanim, "l_subtalar" | "r_subtalar"),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Hanim => "hanim",
            Self::Thesis => "thesis",
        }
    }
}

/// Writes the name, `hanim` or `thesis`.
impl fmt::Display for JointScheme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Parses a name in any case.
impl FromStr for JointScheme {
    type Err = Mismatch;

    fn from_str(name: &str) -> Result<Self, Mismatch> {
        let is = |scheme: &Self| scheme.name().eq_ignore_ascii_case(name);
        Self::ALL.into_iter().find(is).ok_or_else(|| {
            let what = format!("unknown name \"{name}\"; the schemes are hanim and thesis");
            Mismatch::new("joint scheme", what)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::{Region, Zone};

    fn count(scheme: JointScheme, counts: impl Fn(&HanimJoint) -> bool) -> usize {
        scheme.body().filter(|joint| counts(joint)).count()
    }

    /// Table 3.3 of the thesis: the joints of each region, and those of all regions by level.
    #[test]
    fn the_scheme_of_the_thesis_has_its_regions_and_levels() {
        let thesis = JointScheme::Thesis;
        let regions = Region::ALL.map(|r| count(thesis, |j| j.region == r));
        assert_eq!(regions, [2, 10, 25, 4, 4, 4, 40]);
        for scheme in JointScheme::ALL {
            let levels = (0..=5).map(|level| count(scheme, |j| j.level <= level));
            assert_eq!(levels.collect::<Vec<_>>(), [5, 10, 24, 35, 51, 89]);
        }
    }

    /// Table 3.4 of the thesis; its masks are illegible, and follow from the numbers of the regions.
    #[test]
    fn predefined_regions_have_their_joints() {
        let counts = |scheme| {
            let zones = [
                Zone::ALL,
                Region::Face.into(),
                Zone::FACE_SHOULDERS,
                Zone::UPPER,
                Zone::LOWER,
            ];
            zones.map(|zone| count(scheme, |j| zone.contains(j.region)))
        };
        assert_eq!(counts(JointScheme::Thesis), [89, 2, 37, 77, 12]);
        assert_eq!(counts(JointScheme::Hanim), [89, 2, 37, 75, 14]);
    }

    #[test]
    fn names_are_read_as_they_are_written() {
        for scheme in JointScheme::ALL {
            assert_eq!(scheme.to_string().parse(), Ok(scheme));
        }
        assert!("mpeg".parse::<JointScheme>().is_err());
    }
}
