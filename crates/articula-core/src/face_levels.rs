//! Levels of articulation of faces: which facial animation parameters (FAP) a level keeps.
//!
//! Each of the eight regions of a face has one of four levels. With all regions at the same level,
//! high, medium, low and very low keep 68, 44, 26 and 14 parameters. A parameter that is not kept
//! copies the value of another one of its region and unit, or is neutral. Of a pair of left and
//! right the right one is kept. Source and choice of the groups: `docs/methods/face-levels.md`.

use crate::Mismatch;
use crate::fap_table::{FAP_COUNT, LOW_FAP_COUNT, LOW_FAPS};
use FaceRegion::{Cheeks, Ears, Eyeballs, Eyebrows, Head, HighLevel, Jaw, Nose};
use std::fmt;
use std::str::FromStr;

/// A level of articulation of a face or of a region of it, finest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FaceLevel {
    /// All parameters.
    High,
    /// Some parameters copy others.
    Medium,
    /// More copy others, and some are neutral.
    Low,
    /// Both sides of the face are equal, and most parameters are neutral.
    VeryLow,
}

impl FaceLevel {
    /// All levels, finest first.
    pub const ALL: [Self; 4] = [Self::High, Self::Medium, Self::Low, Self::VeryLow];

    /// Name in expressions and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::High => "high",
            Self::Medium => "medium",
            Self::Low => "low",
            Self::VeryLow => "very-low",
        }
    }
}

/// Writes the name.
impl fmt::Display for FaceLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A region of the face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FaceRegion {
    /// Visemes and expressions, FAP 1 and 2.
    HighLevel,
    /// Jaw, chin, tongue, inner and outer lips.
    Jaw,
    /// Eyeballs, pupils and eyelids.
    Eyeballs,
    /// Eyebrows.
    Eyebrows,
    /// Cheeks.
    Cheeks,
    /// Rotation of the head.
    Head,
    /// Nose.
    Nose,
    /// Ears.
    Ears,
}

impl FaceRegion {
    /// All regions, in the order of their first parameters but for the jaw's.
    pub const ALL: [Self; 8] = [HighLevel, Jaw, Eyeballs, Eyebrows, Cheeks, Head, Nose, Ears];

    /// Name in expressions and reports.
    pub fn name(self) -> &'static str {
        match self {
            HighLevel => "high-level",
            Jaw => "jaw",
            Eyeballs => "eyeballs",
            Eyebrows => "eyebrows",
            Cheeks => "cheeks",
            Head => "head",
            Nose => "nose",
            Ears => "ears",
        }
    }

    /// Region of a FAP, by its number; `None` for numbers other than 1 to 68.
    pub fn of(fap: usize) -> Option<Self> {
        Some(row_of(fap)?.region)
    }
}

/// Writes the name.
impl fmt::Display for FaceRegion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// What becomes of a parameter at a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FapRole {
    /// It has a value of its own.
    Own,
    /// It has the value of another parameter, by its number, which has one of its own.
    Copied(u8),
    /// It is neutral.
    Removed,
}

/// A level for each region of a face.
///
/// Written as a level, or as a level and those of some regions: `low, jaw=high, cheeks=medium`.
///
/// ```
/// use articula_core::face_levels::FaceLevels;
///
/// // Speech as in the thesis: fine at the mouth, coarse elsewhere.
/// let speech: FaceLevels = "low, jaw=high, cheeks=medium".parse()?;
/// assert_eq!(speech.roles().kept(), 47);
/// # Ok::<(), articula_core::Mismatch>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaceLevels([FaceLevel; FaceRegion::ALL.len()]);

impl FaceLevels {
    /// The same level for all regions.
    pub fn all(level: FaceLevel) -> Self {
        Self([level; FaceRegion::ALL.len()])
    }

    /// Returns the level of a region.
    pub fn level(&self, region: FaceRegion) -> FaceLevel {
        self.0[region as usize]
    }

    /// Returns these levels with another one for a region.
    #[must_use]
    pub fn with(mut self, region: FaceRegion, level: FaceLevel) -> Self {
        self.0[region as usize] = level;
        self
    }

    /// Returns what becomes of each parameter.
    pub fn roles(&self) -> FapRoles {
        FapRoles(std::array::from_fn(|index| {
            let row = &TABLE[index];
            match self.level(row.region) {
                FaceLevel::High => OWN,
                FaceLevel::Medium => row.roles[0],
                FaceLevel::Low => row.roles[1],
                FaceLevel::VeryLow => row.roles[2],
            }
        }))
    }
}

/// Writes the level of most regions, then the regions with another one.
impl fmt::Display for FaceLevels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = |level: &FaceLevel| self.0.iter().filter(|l| *l == level).count();
        // The finest of several with as many.
        let most = FaceLevel::ALL.into_iter().rev().max_by_key(count);
        let most = most.unwrap_or(FaceLevel::High);
        f.write_str(most.name())?;
        for region in FaceRegion::ALL {
            if self.level(region) != most {
                write!(f, ", {region}={}", self.level(region))?;
            }
        }
        Ok(())
    }
}

/// Reads a level and those of regions, separated by commas; regions without a level have that of
/// all, or high.
impl FromStr for FaceLevels {
    type Err = Mismatch;

    fn from_str(text: &str) -> Result<Self, Mismatch> {
        let level = |name: &str| {
            let found = FaceLevel::ALL.into_iter().find(|l| l.name() == name);
            found.ok_or_else(|| expected("level", name, FaceLevel::ALL.map(FaceLevel::name)))
        };
        let mut all = None;
        let mut regions: Vec<(FaceRegion, FaceLevel)> = Vec::new();
        for entry in text.split(',').map(str::trim) {
            let Some((name, of_region)) = entry.split_once('=') else {
                if all.replace(level(entry)?).is_some() {
                    return Err(Mismatch::new(entry, "a second level of all regions"));
                }
                continue;
            };
            let name = name.trim();
            let region = FaceRegion::ALL.into_iter().find(|r| r.name() == name);
            let names = FaceRegion::ALL.map(FaceRegion::name);
            let region = region.ok_or_else(|| expected("region", name, names))?;
            if regions.iter().any(|(r, _)| *r == region) {
                return Err(Mismatch::new(name, "a second level of this region"));
            }
            regions.push((region, level(of_region.trim())?));
        }
        let all = Self::all(all.unwrap_or(FaceLevel::High));
        let with = |levels: Self, (region, level)| levels.with(region, level);
        Ok(regions.into_iter().fold(all, with))
    }
}

fn expected<const N: usize>(what: &str, found: &str, names: [&str; N]) -> Mismatch {
    Mismatch::new(
        format!("\"{found}\""),
        format!("no {what}; expected {}", names.join(", ")),
    )
}

/// What becomes of each parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FapRoles([FapRole; FAP_COUNT]);

impl FapRoles {
    /// The roles where some parameters are kept (index 0 is FAP 1) and all others are neutral.
    pub fn keeping(kept: &[bool; FAP_COUNT]) -> Self {
        Self(kept.map(|kept| if kept { OWN } else { GONE }))
    }

    /// Returns the role of a FAP, by its number; numbers other than 1 to 68 are removed.
    pub fn role(&self, fap: usize) -> FapRole {
        let role = fap.checked_sub(1).and_then(|i| self.0.get(i));
        role.copied().unwrap_or(GONE)
    }

    /// Returns whether a FAP, by its number, has a value of its own.
    pub fn keeps(&self, fap: usize) -> bool {
        self.role(fap) == OWN
    }

    /// Returns the number of parameters that have a value of their own.
    pub fn kept(&self) -> usize {
        self.0.iter().filter(|r| **r == OWN).count()
    }

    /// Gives each of the low-level values, FAP 3 first, that are not kept the value that they copy,
    /// or the neutral one.
    pub fn expand<T: Copy + Default>(&self, values: &mut [T; LOW_FAP_COUNT]) {
        let first = *LOW_FAPS.start();
        for fap in LOW_FAPS {
            values[fap - first] = match self.role(fap) {
                FapRole::Own => continue,
                // What is copied is kept, so the order does not matter.
                FapRole::Copied(leader) => values[usize::from(leader) - first],
                FapRole::Removed => T::default(),
            };
        }
    }
}

struct Row {
    region: FaceRegion,
    /// At medium, low and very low; at high all are own.
    roles: [FapRole; 3],
}

fn row_of(fap: usize) -> Option<&'static Row> {
    fap.checked_sub(1).and_then(|index| TABLE.get(index))
}

const OWN: FapRole = FapRole::Own;
const GONE: FapRole = FapRole::Removed;

const fn of(leader: u8) -> FapRole {
    FapRole::Copied(leader)
}

const fn row(region: FaceRegion, roles: [FapRole; 3]) -> Row {
    Row { region, roles }
}

/// Region and roles at medium, low and very low of each FAP.
#[rustfmt::skip]
static TABLE: [Row; FAP_COUNT] = [
    row(HighLevel, [OWN, OWN, OWN]), // 1 viseme
    row(HighLevel, [OWN, OWN, OWN]), // 2 expression
    row(Jaw, [OWN, OWN, OWN]), // 3 open_jaw
    row(Jaw, [OWN, OWN, OWN]), // 4 lower_t_midlip
    row(Jaw, [OWN, OWN, OWN]), // 5 raise_b_midlip
    row(Jaw, [OWN, OWN, of(7)]), // 6 stretch_l_cornerlip
    row(Jaw, [OWN, OWN, OWN]), // 7 stretch_r_cornerlip
    row(Jaw, [of(9), of(4), of(4)]), // 8 lower_t_lip_lm
    row(Jaw, [OWN, of(4), of(4)]), // 9 lower_t_lip_rm
    row(Jaw, [of(11), of(5), of(5)]), // 10 raise_b_lip_lm
    row(Jaw, [OWN, of(5), of(5)]), // 11 raise_b_lip_rm
    row(Jaw, [OWN, OWN, of(13)]), // 12 raise_l_cornerlip
    row(Jaw, [OWN, OWN, OWN]), // 13 raise_r_cornerlip
    row(Jaw, [OWN, GONE, GONE]), // 14 thrust_jaw
    row(Jaw, [OWN, GONE, GONE]), // 15 shift_jaw
    row(Jaw, [OWN, of(17), GONE]), // 16 push_b_lip
    row(Jaw, [OWN, OWN, GONE]), // 17 push_t_lip
    row(Jaw, [OWN, OWN, GONE]), // 18 depress_chin
    row(Eyeballs, [OWN, OWN, of(20)]), // 19 close_t_l_eyelid
    row(Eyeballs, [OWN, OWN, OWN]), // 20 close_t_r_eyelid
    row(Eyeballs, [OWN, of(19), of(20)]), // 21 close_b_l_eyelid
    row(Eyeballs, [OWN, of(20), of(20)]), // 22 close_b_r_eyelid
    row(Eyeballs, [of(24), of(24), of(24)]), // 23 yaw_l_eyeball
    row(Eyeballs, [OWN, OWN, OWN]), // 24 yaw_r_eyeball
    row(Eyeballs, [of(26), of(26), of(26)]), // 25 pitch_l_eyeball
    row(Eyeballs, [OWN, OWN, OWN]), // 26 pitch_r_eyeball
    row(Eyeballs, [of(28), GONE, GONE]), // 27 thrust_l_eyeball
    row(Eyeballs, [OWN, GONE, GONE]), // 28 thrust_r_eyeball
    row(Eyeballs, [of(30), GONE, GONE]), // 29 dilate_l_pupil
    row(Eyeballs, [OWN, GONE, GONE]), // 30 dilate_r_pupil
    row(Eyebrows, [OWN, OWN, of(32)]), // 31 raise_l_i_eyebrow
    row(Eyebrows, [OWN, OWN, OWN]), // 32 raise_r_i_eyebrow
    row(Eyebrows, [of(35), of(31), of(32)]), // 33 raise_l_m_eyebrow
    row(Eyebrows, [of(36), of(32), of(32)]), // 34 raise_r_m_eyebrow
    row(Eyebrows, [OWN, of(36), GONE]), // 35 raise_l_o_eyebrow
    row(Eyebrows, [OWN, OWN, GONE]), // 36 raise_r_o_eyebrow
    row(Eyebrows, [of(38), of(38), GONE]), // 37 squeeze_l_eyebrow
    row(Eyebrows, [OWN, OWN, GONE]), // 38 squeeze_r_eyebrow
    row(Cheeks, [of(40), GONE, GONE]), // 39 puff_l_cheek
    row(Cheeks, [OWN, GONE, GONE]), // 40 puff_r_cheek
    row(Cheeks, [of(42), of(42), GONE]), // 41 lift_l_cheek
    row(Cheeks, [OWN, OWN, GONE]), // 42 lift_r_cheek
    row(Jaw, [OWN, GONE, GONE]), // 43 shift_tongue_tip
    row(Jaw, [OWN, OWN, GONE]), // 44 raise_tongue_tip
    row(Jaw, [OWN, OWN, GONE]), // 45 thrust_tongue_tip
    row(Jaw, [OWN, of(44), GONE]), // 46 raise_tongue
    row(Jaw, [OWN, GONE, GONE]), // 47 tongue_roll
    row(Head, [OWN, OWN, OWN]), // 48 head_pitch
    row(Head, [OWN, OWN, OWN]), // 49 head_yaw
    row(Head, [OWN, OWN, OWN]), // 50 head_roll
    row(Jaw, [of(4), of(4), of(4)]), // 51 lower_t_midlip_o
    row(Jaw, [of(5), of(5), of(5)]), // 52 raise_b_midlip_o
    row(Jaw, [of(6), of(6), of(7)]), // 53 stretch_l_cornerlip_o
    row(Jaw, [of(7), of(7), of(7)]), // 54 stretch_r_cornerlip_o
    row(Jaw, [of(9), of(4), of(4)]), // 55 lower_t_lip_lm_o
    row(Jaw, [of(9), of(4), of(4)]), // 56 lower_t_lip_rm_o
    row(Jaw, [of(11), of(5), of(5)]), // 57 raise_b_lip_lm_o
    row(Jaw, [of(11), of(5), of(5)]), // 58 raise_b_lip_rm_o
    row(Jaw, [of(12), of(12), of(13)]), // 59 raise_l_cornerlip_o
    row(Jaw, [of(13), of(13), of(13)]), // 60 raise_r_cornerlip_o
    row(Nose, [of(62), GONE, GONE]), // 61 stretch_l_nose
    row(Nose, [OWN, GONE, GONE]), // 62 stretch_r_nose
    row(Nose, [OWN, OWN, GONE]), // 63 raise_nose
    row(Nose, [OWN, GONE, GONE]), // 64 bend_nose
    row(Ears, [of(66), GONE, GONE]), // 65 raise_l_ear
    row(Ears, [OWN, GONE, GONE]), // 66 raise_r_ear
    row(Ears, [of(68), GONE, GONE]), // 67 pull_l_ear
    row(Ears, [OWN, GONE, GONE]), // 68 pull_r_ear
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fap_table::{self, FapDirection, FapUnit};

    const FAPS: std::ops::RangeInclusive<usize> = 1..=FAP_COUNT;

    fn followers() -> Vec<(FaceLevel, usize, usize)> {
        let mut found = Vec::new();
        for level in FaceLevel::ALL {
            let roles = FaceLevels::all(level).roles();
            for fap in FAPS {
                if let FapRole::Copied(leader) = roles.role(fap) {
                    found.push((level, fap, usize::from(leader)));
                }
            }
        }
        found
    }

    #[test]
    fn levels_keep_68_44_26_and_14() {
        let totals = [68, 44, 26, 14];
        let regions = [
            (HighLevel, [2, 2, 2, 2]),
            (Jaw, [31, 19, 11, 5]),
            (Eyeballs, [12, 8, 4, 3]),
            (Eyebrows, [8, 5, 4, 1]),
            (Cheeks, [4, 2, 1, 0]),
            (Head, [3, 3, 3, 3]),
            (Nose, [4, 3, 1, 0]),
            (Ears, [4, 2, 0, 0]),
        ];
        for ((level, all), index) in FaceLevel::ALL.into_iter().zip(totals).zip(0..) {
            let roles = FaceLevels::all(level).roles();
            assert_eq!(roles.kept(), all, "{level}");
            for (region, counts) in regions {
                let of_region = FAPS.filter(|fap| FaceRegion::of(*fap) == Some(region));
                let kept = of_region.filter(|fap| roles.keeps(*fap)).count();
                assert_eq!(kept, counts[index], "{region} at {level}");
            }
        }
    }

    #[test]
    fn regions_are_groups_of_the_standard() {
        for fap in FAPS {
            let group = fap_table::TABLE[fap - 1].group;
            let region = match group {
                1 => HighLevel,
                2 | 6 | 8 => Jaw,
                3 => Eyeballs,
                4 => Eyebrows,
                5 => Cheeks,
                7 => Head,
                9 => Nose,
                _ => Ears,
            };
            assert_eq!(FaceRegion::of(fap), Some(region), "FAP {fap}");
        }
        assert_eq!([0, 69].map(FaceRegion::of), [None, None]);
        let order: Vec<usize> = FaceRegion::ALL.iter().map(|r| *r as usize).collect();
        assert_eq!(order, (0..8).collect::<Vec<usize>>());
    }

    #[test]
    fn followers_copy_what_moves_alike() {
        for (level, fap, leader) in followers() {
            let what = format!("FAP {fap} copies {leader} at {level}");
            assert!(FaceLevels::all(level).roles().keeps(leader), "{what}");
            assert_eq!(FaceRegion::of(fap), FaceRegion::of(leader), "{what}");
            let [follower, copied] = [fap, leader].map(|f| &fap_table::TABLE[f - 1]);
            let (a, b) = (follower.action.unwrap(), copied.action.unwrap());
            assert_eq!(a.unit, b.unit, "{what}");
            // Left and right mirror each other, but both eyes look to the same side; an upper eyelid
            // that goes down and a lower one that goes up both close the eye.
            let closes = |f: &fap_table::Fap| f.name.starts_with("close_");
            let mirrored = match a.direction {
                FapDirection::Left => FapDirection::Right,
                FapDirection::Right => FapDirection::Left,
                other => other,
            };
            let other_side = follower.name.contains("_l_") && copied.name.contains("_r_");
            let wanted = if other_side && a.unit != FapUnit::Angle {
                mirrored
            } else {
                a.direction
            };
            let alike = b.direction == wanted || closes(follower) && closes(copied);
            assert!(alike, "{what}");
            assert_eq!(a.two_sided, b.two_sided, "{what}");
        }
    }

    #[test]
    fn the_right_side_leads() {
        let side = |fap: usize| {
            let name = fap_table::TABLE[fap - 1].name;
            let is = |marks: [&str; 2]| marks.iter().any(|m| name.contains(m));
            (is(["_l_", "_lm"]), is(["_r_", "_rm"]))
        };
        let mut across = 0;
        for (level, fap, leader) in followers() {
            let (from, to) = (side(fap), side(leader));
            assert!(
                !(from == (false, true) && to == (true, false)),
                "right FAP {fap} copies left {leader} at {level}"
            );
            across += usize::from(from == (true, false) && to == (false, true));
        }
        assert!(across > 20, "{across}");
        // Very low has no left parameter of its own.
        let coarsest = FaceLevels::all(FaceLevel::VeryLow).roles();
        assert!(FAPS.filter(|f| coarsest.keeps(*f)).all(|f| !side(f).0));
    }

    #[test]
    fn levels_nest_and_nothing_removed_comes_back() {
        for pair in FaceLevel::ALL.windows(2) {
            let [fine, coarse] = [pair[0], pair[1]].map(|l| FaceLevels::all(l).roles());
            for fap in FAPS {
                assert!(!coarse.keeps(fap) || fine.keeps(fap), "FAP {fap}");
                let gone = fine.role(fap) == FapRole::Removed;
                assert!(!gone || coarse.role(fap) == FapRole::Removed, "FAP {fap}");
            }
        }
        let medium = FaceLevels::all(FaceLevel::Medium).roles();
        assert!(
            FAPS.into_iter()
                .all(|fap| medium.role(fap) != FapRole::Removed),
            "it only groups"
        );
    }

    #[test]
    fn values_are_copied_and_removed_by_hand() {
        let mut values = [0; LOW_FAP_COUNT];
        for fap in LOW_FAPS {
            values[fap - 3] = fap as i32;
        }
        let own = values;
        FaceLevels::all(FaceLevel::High).roles().expand(&mut values);
        assert_eq!(values, own);
        let levels: FaceLevels = "very-low, eyebrows=medium, nose=low".parse().unwrap();
        levels.roles().expand(&mut values);
        let of = |fap: usize| values[fap - 3];
        assert_eq!((of(3), of(6), of(53), of(55)), (3, 7, 7, 4));
        assert_eq!((of(14), of(16), of(19), of(21), of(23)), (0, 0, 20, 20, 24));
        assert_eq!((of(33), of(34), of(37), of(31)), (35, 36, 38, 31));
        assert_eq!((of(61), of(63), of(39), of(68), of(50)), (0, 63, 0, 0, 50));
        // What was expanded stays as it is.
        let once = values;
        levels.roles().expand(&mut values);
        assert_eq!(values, once);

        let mut kept = [false; FAP_COUNT];
        kept[7 - 1] = true;
        let mut values = own;
        FapRoles::keeping(&kept).expand(&mut values);
        assert!(
            LOW_FAPS
                .into_iter()
                .all(|fap| values[fap - 3] == if fap == 7 { 7 } else { 0 })
        );
        assert_eq!([0, 69].map(|f| FapRoles::keeping(&kept).role(f)), [GONE; 2]);
    }

    #[test]
    fn levels_of_regions_are_written_and_read() {
        let speech: FaceLevels = "low,jaw=high , cheeks= medium".parse().unwrap();
        assert_eq!(speech.to_string(), "low, jaw=high, cheeks=medium");
        assert_eq!(speech.to_string().parse(), Ok(speech));
        assert_eq!(speech.roles().kept(), 2 + 31 + 4 + 4 + 2 + 3 + 1);
        assert_eq!(speech.level(Cheeks), FaceLevel::Medium);
        assert_eq!(
            "nose=very-low".parse(),
            Ok(FaceLevels::all(FaceLevel::High).with(Nose, FaceLevel::VeryLow))
        );
        for level in FaceLevel::ALL {
            assert_eq!(level.to_string().parse(), Ok(FaceLevels::all(level)));
        }
        let said = |text: &str| text.parse::<FaceLevels>().unwrap_err().to_string();
        assert_eq!(
            said("lowest"),
            "\"lowest\": no level; expected high, medium, low, very-low"
        );
        assert!(said("chin=low").starts_with("\"chin\": no region; expected high-level, jaw"));
        for bad in [
            "",
            "low,",
            "low,high",
            "jaw",
            "jaw=",
            "jaw=low,jaw=high",
            "low;jaw=high",
        ] {
            assert!(bad.parse::<FaceLevels>().is_err(), "{bad}");
        }
    }
}
