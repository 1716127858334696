//! The fields of all facial animation parameters as channels: numbers that are coded as weights of
//! morph targets.
//!
//! Channels 0 to 65 are FAP 3 to 68, then come the four fields of FAP 1 and the six of FAP 2. Form:
//! `docs/formats/afp2.md`, part 2.

use super::Group;
use crate::face::levels::labels;
use articula_core::fap_table::{FAP_COUNT, FapUnit, LOW_FAP_COUNT, LOW_FAPS, TABLE, unit_mm};

/// Number of channels.
pub(crate) const COUNT: usize = LOW_FAP_COUNT + VISEME_FIELDS + EXPRESSION_FIELDS;
const VISEME_FIELDS: usize = 4;
const EXPRESSION_FIELDS: usize = 6;

/// FAP 48 to 50, the rotation of the head, whose lever is longer than that of an eye.
const HEAD: std::ops::RangeInclusive<usize> = 48..=50;
/// Levers of the head and of an eye in millimetres.
const HEAD_PER_EYE: f32 = 120.0 / 12.0;

/// The FAP of a channel, and which of its fields.
pub(crate) fn field_of(channel: usize) -> (usize, usize) {
    match channel.checked_sub(LOW_FAP_COUNT) {
        None => (LOW_FAPS.start() + channel, 0),
        Some(field) if field < VISEME_FIELDS => (1, field),
        Some(field) => (2, field - VISEME_FIELDS),
    }
}

/// Whether the channels of a FAP are numbers that mean nothing in between, such as that of a viseme.
pub(crate) fn is_exact(channel: usize) -> bool {
    channel >= LOW_FAP_COUNT
}

/// Weight of one unit of a FAP, a power of 2: 2^-10 of a distance's unit, so that a weight of 1 is
/// the distance, 2^-17 of an angle's, about a radian, 1 of the fields of FAP 1 and 2.
pub(crate) fn weight_of_unit(fap: usize) -> f32 {
    match TABLE[fap - 1].action.map(|action| action.unit) {
        None => 1.0,
        Some(FapUnit::Angle) => 1.0 / 131_072.0,
        Some(_) => 1.0 / 1024.0,
    }
}

/// Metres that a weight of 1 of a low-level FAP moves its feature point on an average face.
pub(crate) fn metres_per_weight(fap: usize) -> f32 {
    let lever = if HEAD.contains(&fap) {
        HEAD_PER_EYE
    } else {
        1.0
    };
    1e-3 * unit_mm(fap) * lever / weight_of_unit(fap)
}

/// The group of a FAP, by its labels.
pub(crate) fn group_of(fap: usize) -> Group {
    let [loa, region] = labels(fap).unwrap_or_default();
    Group {
        loa,
        region,
        joint: None,
    }
}

/// The index of the group of each channel, `u16::MAX` for none.
pub(crate) fn groups_of(groups: &[Group]) -> Vec<u16> {
    let of_channel = |channel: usize| {
        let group = group_of(field_of(channel).0);
        let at = groups.iter().position(|g| *g == group);
        at.map_or(u16::MAX, |at| at as u16)
    };
    (0..COUNT).map(of_channel).collect()
}

/// The FAPs (index 0 is FAP 1) of which the group is among those given.
pub(crate) fn faps_of(groups: &[Group]) -> [bool; FAP_COUNT] {
    std::array::from_fn(|index| groups.contains(&group_of(index + 1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_has_a_channel() {
        let fields: Vec<_> = (0..COUNT).map(field_of).collect();
        assert_eq!(fields[0], (3, 0));
        assert_eq!(fields[65], (68, 0));
        assert_eq!(fields[66..70], [(1, 0), (1, 1), (1, 2), (1, 3)]);
        assert_eq!(fields[75], (2, 5));
    }

    #[test]
    fn lengths_by_hand() {
        // 1024 units of open_jaw are the distance of mouth and nose, 21.2 mm.
        assert!((metres_per_weight(3) - 0.0212).abs() < 1e-6);
        // 2^17 units of an angle are 1.31072 rad, of an eye of 12 mm and a head of 120 mm.
        assert!((metres_per_weight(23) - 0.012 * 1.31072).abs() < 1e-6);
        assert!((metres_per_weight(48) - 0.12 * 1.31072).abs() < 1e-5);
    }

    #[test]
    fn channels_without_a_group_are_in_none() {
        let jaw = group_of(3);
        let groups = groups_of(&[jaw]);
        assert_eq!((groups[0], groups[19 - 3]), (0, u16::MAX));
        assert!(faps_of(&[jaw])[3 - 1] && !faps_of(&[jaw])[19 - 1]);
    }
}
