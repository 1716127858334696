//! The 68 facial animation parameters (FAP) of MPEG-4, generated from ISO/IEC 14496-2 table C-1
//! (`docs/formats/mpeg4.md`).
//!
//! A low-level FAP moves one feature point along one direction by value x unit, where the unit is a
//! distance of the neutral face divided by 1024, or 1e-5 rad. Left and right are the subject's. FAP
//! 1 and 2 are high level: they select visemes and expressions.
//!
//! The ranges of FAP 47 (tongue_roll) are doubtful: sources differ.

use std::fmt;

/// The unit of the values of a FAP. The numbers in the descriptions are feature points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FapUnit {
    /// IRISD: diameter of the iris, 3.1 to 3.3, divided by 1024.
    IrisDiameter,
    /// ES: separation of the eyes, 3.5 to 3.6, divided by 1024.
    EyeSeparation,
    /// ENS: eye to nose, height from 3.5 to 9.15, divided by 1024.
    EyeNose,
    /// MNS: mouth to nose, height from 9.15 to 2.2, divided by 1024.
    MouthNose,
    /// MW: width of the mouth, 8.3 to 8.4, divided by 1024.
    MouthWidth,
    /// AU: 1e-5 radians.
    Angle,
}

/// Length of an angle unit ([`FapUnit::Angle`]), radians.
pub const ANGLE_UNIT: f32 = 1e-5;

impl FapUnit {
    /// The units that are distances of a face.
    pub const DISTANCES: [Self; 5] = [
        Self::IrisDiameter,
        Self::EyeSeparation,
        Self::EyeNose,
        Self::MouthNose,
        Self::MouthWidth,
    ];
}

/// Writes the abbreviation of the standard.
impl fmt::Display for FapUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::IrisDiameter => "IRISD",
            Self::EyeSeparation => "ES",
            Self::EyeNose => "ENS",
            Self::MouthNose => "MNS",
            Self::MouthWidth => "MW",
            Self::Angle => "AU",
        })
    }
}

/// The direction of a positive value, from the subject's point of view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FapDirection {
    /// Up; also of the rim of the tongue in a roll.
    Up,
    /// Down; for a pitch, looking down.
    Down,
    /// To the subject's left; for a yaw, looking left.
    Left,
    /// To the subject's right; for a roll, the top of the head moves to the right.
    Right,
    /// Out of the face.
    Forward,
    /// The pupil grows.
    Growth,
    /// The borders of the tongue rise.
    Curl,
}

/// The effect of a low-level FAP.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FapAction {
    /// Unit of the value.
    pub unit: FapUnit,
    /// Direction of a positive value.
    pub direction: FapDirection,
    /// Group and number of the feature point (2.10 is `(2, 10)`); the left one of two.
    pub point: (u8, u8),
    /// Whether negative values are allowed.
    pub two_sided: bool,
}

/// One facial animation parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fap {
    /// Name as in the standard, lower case with underscores.
    pub name: &'static str,
    /// Group, 1 to 10; see [`GROUPS`].
    pub group: u8,
    /// Effect of the parameter; `None` for FAP 1 and 2.
    pub action: Option<FapAction>,
    /// Quantiser step before the global scale.
    pub step: u16,
    /// Maximum quantised magnitude in an intra frame, and in a predicted one.
    pub largest: (u16, u16),
}

/// Number of facial animation parameters.
pub const FAP_COUNT: usize = 68;
/// Numbers of the low-level parameters.
pub const LOW_FAPS: std::ops::RangeInclusive<usize> = 3..=FAP_COUNT;
/// Number of low-level parameters.
pub const LOW_FAP_COUNT: usize = 66;

/// Name and number of FAPs of each group; the groups are contiguous in [`TABLE`].
pub const GROUPS: [(&str, usize); 10] = [
    ("viseme and expression", 2),
    ("jaw, chin and inner lips", 16),
    ("eyeballs, pupils and eyelids", 12),
    ("eyebrows", 8),
    ("cheeks", 4),
    ("tongue", 5),
    ("head rotation", 3),
    ("outer lips", 10),
    ("nose", 4),
    ("ears", 4),
];

/// The parameters; FAP `n` has index `n - 1`.
#[rustfmt::skip]
pub static TABLE: [Fap; FAP_COUNT] = [
    high("viseme", 1, (63, 63)),
    high("expression", 1, (63, 63)),
    one_way("open_jaw", 2, (FapUnit::MouthNose, FapDirection::Down), (2, 1), 4, (1080, 360)),
    two_sided("lower_t_midlip", 2, (FapUnit::MouthNose, FapDirection::Down), (2, 2), 2, (600, 180)),
    two_sided("raise_b_midlip", 2, (FapUnit::MouthNose, FapDirection::Up), (2, 3), 2, (1860, 600)),
    two_sided("stretch_l_cornerlip", 2, (FapUnit::MouthWidth, FapDirection::Left), (2, 4), 2, (600, 180)),
    two_sided("stretch_r_cornerlip", 2, (FapUnit::MouthWidth, FapDirection::Right), (2, 5), 2, (600, 180)),
    two_sided("lower_t_lip_lm", 2, (FapUnit::MouthNose, FapDirection::Down), (2, 6), 2, (600, 180)),
    two_sided("lower_t_lip_rm", 2, (FapUnit::MouthNose, FapDirection::Down), (2, 7), 2, (600, 180)),
    two_sided("raise_b_lip_lm", 2, (FapUnit::MouthNose, FapDirection::Up), (2, 8), 2, (1860, 600)),
    two_sided("raise_b_lip_rm", 2, (FapUnit::MouthNose, FapDirection::Up), (2, 9), 2, (1860, 600)),
    two_sided("raise_l_cornerlip", 2, (FapUnit::MouthNose, FapDirection::Up), (2, 4), 2, (600, 180)),
    two_sided("raise_r_cornerlip", 2, (FapUnit::MouthNose, FapDirection::Up), (2, 5), 2, (600, 180)),
    one_way("thrust_jaw", 2, (FapUnit::MouthNose, FapDirection::Forward), (2, 1), 1, (600, 180)),
    two_sided("shift_jaw", 2, (FapUnit::MouthWidth, FapDirection::Right), (2, 1), 1, (1080, 360)),
    two_sided("push_b_lip", 2, (FapUnit::MouthNose, FapDirection::Forward), (2, 3), 1, (1080, 360)),
    two_sided("push_t_lip", 2, (FapUnit::MouthNose, FapDirection::Forward), (2, 2), 1, (1080, 360)),
    two_sided("depress_chin", 2, (FapUnit::MouthNose, FapDirection::Up), (2, 10), 1, (420, 180)),
    two_sided("close_t_l_eyelid", 3, (FapUnit::IrisDiameter, FapDirection::Down), (3, 1), 1, (1080, 600)),
    two_sided("close_t_r_eyelid", 3, (FapUnit::IrisDiameter, FapDirection::Down), (3, 2), 1, (1080, 600)),
    two_sided("close_b_l_eyelid", 3, (FapUnit::IrisDiameter, FapDirection::Up), (3, 3), 1, (600, 240)),
    two_sided("close_b_r_eyelid", 3, (FapUnit::IrisDiameter, FapDirection::Up), (3, 4), 1, (600, 240)),
    two_sided("yaw_l_eyeball", 3, (FapUnit::Angle, FapDirection::Left), (3, 5), 128, (1200, 420)),
    two_sided("yaw_r_eyeball", 3, (FapUnit::Angle, FapDirection::Left), (3, 6), 128, (1200, 420)),
    two_sided("pitch_l_eyeball", 3, (FapUnit::Angle, FapDirection::Down), (3, 5), 128, (900, 300)),
    two_sided("pitch_r_eyeball", 3, (FapUnit::Angle, FapDirection::Down), (3, 6), 128, (900, 300)),
    two_sided("thrust_l_eyeball", 3, (FapUnit::EyeSeparation, FapDirection::Forward), (3, 5), 1, (600, 180)),
    two_sided("thrust_r_eyeball", 3, (FapUnit::EyeSeparation, FapDirection::Forward), (3, 6), 1, (600, 180)),
    two_sided("dilate_l_pupil", 3, (FapUnit::IrisDiameter, FapDirection::Growth), (3, 5), 1, (420, 120)),
    two_sided("dilate_r_pupil", 3, (FapUnit::IrisDiameter, FapDirection::Growth), (3, 6), 1, (420, 120)),
    two_sided("raise_l_i_eyebrow", 4, (FapUnit::EyeNose, FapDirection::Up), (4, 1), 2, (900, 360)),
    two_sided("raise_r_i_eyebrow", 4, (FapUnit::EyeNose, FapDirection::Up), (4, 2), 2, (900, 360)),
    two_sided("raise_l_m_eyebrow", 4, (FapUnit::EyeNose, FapDirection::Up), (4, 3), 2, (900, 360)),
    two_sided("raise_r_m_eyebrow", 4, (FapUnit::EyeNose, FapDirection::Up), (4, 4), 2, (900, 360)),
    two_sided("raise_l_o_eyebrow", 4, (FapUnit::EyeNose, FapDirection::Up), (4, 5), 2, (900, 360)),
    two_sided("raise_r_o_eyebrow", 4, (FapUnit::EyeNose, FapDirection::Up), (4, 6), 2, (900, 360)),
    two_sided("squeeze_l_eyebrow", 4, (FapUnit::EyeSeparation, FapDirection::Right), (4, 1), 1, (900, 300)),
    two_sided("squeeze_r_eyebrow", 4, (FapUnit::EyeSeparation, FapDirection::Left), (4, 2), 1, (900, 300)),
    two_sided("puff_l_cheek", 5, (FapUnit::EyeSeparation, FapDirection::Left), (5, 1), 2, (900, 300)),
    two_sided("puff_r_cheek", 5, (FapUnit::EyeSeparation, FapDirection::Right), (5, 2), 2, (900, 300)),
    one_way("lift_l_cheek", 5, (FapUnit::EyeNose, FapDirection::Up), (5, 3), 2, (600, 180)),
    one_way("lift_r_cheek", 5, (FapUnit::EyeNose, FapDirection::Up), (5, 4), 2, (600, 180)),
    two_sided("shift_tongue_tip", 6, (FapUnit::MouthWidth, FapDirection::Right), (6, 1), 1, (1080, 420)),
    two_sided("raise_tongue_tip", 6, (FapUnit::MouthNose, FapDirection::Up), (6, 1), 1, (1080, 420)),
    two_sided("thrust_tongue_tip", 6, (FapUnit::MouthWidth, FapDirection::Forward), (6, 1), 1, (1080, 420)),
    two_sided("raise_tongue", 6, (FapUnit::MouthNose, FapDirection::Up), (6, 2), 1, (1080, 420)),
    one_way("tongue_roll", 6, (FapUnit::Angle, FapDirection::Curl), (6, 3), 512, (1080, 420)),
    two_sided("head_pitch", 7, (FapUnit::Angle, FapDirection::Down), (7, 1), 170, (1860, 600)),
    two_sided("head_yaw", 7, (FapUnit::Angle, FapDirection::Left), (7, 1), 170, (1860, 600)),
    two_sided("head_roll", 7, (FapUnit::Angle, FapDirection::Right), (7, 1), 170, (1860, 600)),
    two_sided("lower_t_midlip_o", 8, (FapUnit::MouthNose, FapDirection::Down), (8, 1), 2, (600, 180)),
    two_sided("raise_b_midlip_o", 8, (FapUnit::MouthNose, FapDirection::Up), (8, 2), 2, (1860, 600)),
    two_sided("stretch_l_cornerlip_o", 8, (FapUnit::MouthWidth, FapDirection::Left), (8, 3), 2, (600, 180)),
    two_sided("stretch_r_cornerlip_o", 8, (FapUnit::MouthWidth, FapDirection::Right), (8, 4), 2, (600, 180)),
    two_sided("lower_t_lip_lm_o", 8, (FapUnit::MouthNose, FapDirection::Down), (8, 5), 2, (600, 180)),
    two_sided("lower_t_lip_rm_o", 8, (FapUnit::MouthNose, FapDirection::Down), (8, 6), 2, (600, 180)),
    two_sided("raise_b_lip_lm_o", 8, (FapUnit::MouthNose, FapDirection::Up), (8, 7), 2, (1860, 600)),
    two_sided("raise_b_lip_rm_o", 8, (FapUnit::MouthNose, FapDirection::Up), (8, 8), 2, (1860, 600)),
    two_sided("raise_l_cornerlip_o", 8, (FapUnit::MouthNose, FapDirection::Up), (8, 3), 2, (600, 180)),
    two_sided("raise_r_cornerlip_o", 8, (FapUnit::MouthNose, FapDirection::Up), (8, 4), 2, (600, 180)),
    two_sided("stretch_l_nose", 9, (FapUnit::EyeNose, FapDirection::Left), (9, 1), 1, (540, 120)),
    two_sided("stretch_r_nose", 9, (FapUnit::EyeNose, FapDirection::Right), (9, 2), 1, (540, 120)),
    two_sided("raise_nose", 9, (FapUnit::EyeNose, FapDirection::Up), (9, 3), 1, (680, 180)),
    two_sided("bend_nose", 9, (FapUnit::EyeNose, FapDirection::Right), (9, 3), 1, (900, 180)),
    two_sided("raise_l_ear", 10, (FapUnit::EyeNose, FapDirection::Up), (10, 1), 1, (900, 240)),
    two_sided("raise_r_ear", 10, (FapUnit::EyeNose, FapDirection::Up), (10, 2), 1, (900, 240)),
    two_sided("pull_l_ear", 10, (FapUnit::EyeNose, FapDirection::Left), (10, 3), 1, (900, 300)),
    two_sided("pull_r_ear", 10, (FapUnit::EyeNose, FapDirection::Right), (10, 4), 1, (900, 300)),
];

const fn high(name: &'static str, step: u16, largest: (u16, u16)) -> Fap {
    Fap {
        name,
        group: 1,
        action: None,
        step,
        largest,
    }
}

const fn two_sided(
    name: &'static str,
    group: u8,
    (unit, direction): (FapUnit, FapDirection),
    point: (u8, u8),
    step: u16,
    largest: (u16, u16),
) -> Fap {
    let action = FapAction {
        unit,
        direction,
        point,
        two_sided: true,
    };
    Fap {
        name,
        group,
        action: Some(action),
        step,
        largest,
    }
}

const fn one_way(
    name: &'static str,
    group: u8,
    (unit, direction): (FapUnit, FapDirection),
    point: (u8, u8),
    step: u16,
    largest: (u16, u16),
) -> Fap {
    let action = FapAction {
        unit,
        direction,
        point,
        two_sided: false,
    };
    Fap {
        name,
        group,
        action: Some(action),
        step,
        largest,
    }
}

/// Returns the length of one unit of a FAP (3 to 68) on an average face, in millimetres.
///
/// Distances are those of the neutral head of ICT-FaceKit; angles count at 12 mm, the radius of an
/// eye.
pub fn unit_mm(fap: usize) -> f32 {
    let action = fap.checked_sub(1).and_then(|i| TABLE.get(i)?.action);
    let length = match action.map(|a| a.unit) {
        None => return 0.0,
        Some(FapUnit::Angle) => return 12.0e-5,
        Some(FapUnit::IrisDiameter) => 8.3,
        Some(FapUnit::EyeSeparation) => 62.3,
        Some(FapUnit::EyeNose) => 48.0,
        Some(FapUnit::MouthNose) => 21.2,
        Some(FapUnit::MouthWidth) => 50.7,
    };
    length / 1024.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_follow_each_other() {
        let mut first = 0;
        for (index, (name, count)) in GROUPS.iter().enumerate() {
            let group = &TABLE[first..first + count];
            assert!(
                group.iter().all(|f| usize::from(f.group) == index + 1),
                "{name}"
            );
            first += count;
        }
        assert_eq!(first, FAP_COUNT);
    }

    #[test]
    fn rows_that_everyone_knows() {
        let of = |fap: usize| {
            let action = TABLE[fap - 1].action.unwrap();
            (TABLE[fap - 1].name, action.unit, action.direction)
        };
        assert_eq!(of(3), ("open_jaw", FapUnit::MouthNose, FapDirection::Down));
        assert_eq!(
            of(19),
            (
                "close_t_l_eyelid",
                FapUnit::IrisDiameter,
                FapDirection::Down
            )
        );
        assert_eq!(
            of(37),
            (
                "squeeze_l_eyebrow",
                FapUnit::EyeSeparation,
                FapDirection::Right
            )
        );
        assert_eq!(of(48), ("head_pitch", FapUnit::Angle, FapDirection::Down));
        assert_eq!(
            of(68),
            ("pull_r_ear", FapUnit::EyeNose, FapDirection::Right)
        );
        // Five parameters go in one direction only: jaw open and thrust, cheeks up, tongue roll.
        let one_way = TABLE
            .iter()
            .filter(|f| f.action.is_some_and(|a| !a.two_sided));
        let names: Vec<&str> = one_way.map(|f| f.name).collect();
        assert_eq!(
            names,
            [
                "open_jaw",
                "thrust_jaw",
                "lift_l_cheek",
                "lift_r_cheek",
                "tongue_roll"
            ]
        );
        // Rotations: four of the eyeballs, the tongue's roll, three of the head.
        let angles = TABLE
            .iter()
            .filter(|f| f.action.is_some_and(|a| a.unit == FapUnit::Angle));
        assert_eq!(angles.count(), 8);
    }

    #[test]
    fn sides_mirror_each_other() {
        let mut pairs = 0;
        for left in &TABLE {
            let right = left.name.replace("_l_", "_r_").replace("_lm", "_rm");
            let Some(right) = TABLE
                .iter()
                .find(|f| f.name == right && f.name != left.name)
            else {
                continue;
            };
            pairs += 1;
            let (a, b) = (left.action.unwrap(), right.action.unwrap());
            assert_eq!((a.unit, a.two_sided), (b.unit, b.two_sided));
            assert_eq!((left.step, left.largest), (right.step, right.largest));
            let mirrored = match a.direction {
                // Both eyes look left.
                FapDirection::Left if a.unit == FapUnit::Angle => FapDirection::Left,
                FapDirection::Left => FapDirection::Right,
                FapDirection::Right => FapDirection::Left,
                other => other,
            };
            assert_eq!(b.direction, mirrored, "{}", left.name);
            assert_eq!(a.point.0, b.point.0);
            assert_eq!(a.point.1 + 1, b.point.1, "{}", left.name);
        }
        // 46 of 66 parameters come in pairs.
        assert_eq!(pairs, 23);
    }

    #[test]
    fn lengths_of_units() {
        // 1024 units of MNS are the distance between mouth and nose.
        assert!((1024.0 * unit_mm(3) - 21.2).abs() < 1e-4);
        // A quarter turn of an eye of 12 mm.
        let quarter = std::f32::consts::FRAC_PI_2 * 1e5;
        assert!((quarter * unit_mm(23) - 12.0 * std::f32::consts::FRAC_PI_2).abs() < 1e-3);
        assert_eq!([unit_mm(0), unit_mm(1), unit_mm(2), unit_mm(69)], [0.0; 4]);
    }
}
