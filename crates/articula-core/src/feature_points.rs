//! The 84 feature points of a face, by which MPEG-4 places its facial animation parameters.
//!
//! Source: ISO/IEC 14496-2, facial definition parameters (`docs/formats/mpeg4.md`). Left and right
//! are the subject's. Distances between some of them are the units of the parameters
//! ([`FapUnit`](crate::fap_table::FapUnit)).

/// Group and number of a feature point: 2.10 is `(2, 10)`.
pub type PointId = (u8, u8);

/// A feature point of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FeaturePointEntry {
    /// Group and number.
    pub point: PointId,
    /// The point of the other side of the face; the point itself in the middle.
    pub mirror: PointId,
    /// Where it is.
    pub place: &'static str,
}

/// Number of feature points.
pub const FEATURE_POINT_COUNT: usize = 84;

/// The feature points in ascending order.
#[rustfmt::skip]
pub static FEATURE_POINTS: [FeaturePointEntry; FEATURE_POINT_COUNT] = [
    at(2, 1, (2, 1), "bottom of the chin"),
    at(2, 2, (2, 2), "middle of the inner upper lip contour"),
    at(2, 3, (2, 3), "middle of the inner lower lip contour"),
    at(2, 4, (2, 5), "left corner of the inner lip contour"),
    at(2, 5, (2, 4), "right corner of the inner lip contour"),
    at(2, 6, (2, 7), "midway between middle and left corner of the inner upper lip"),
    at(2, 7, (2, 6), "midway between middle and right corner of the inner upper lip"),
    at(2, 8, (2, 9), "midway between middle and left corner of the inner lower lip"),
    at(2, 9, (2, 8), "midway between middle and right corner of the inner lower lip"),
    at(2, 10, (2, 10), "chin boss"),
    at(2, 11, (2, 12), "left corner of the chin"),
    at(2, 12, (2, 11), "right corner of the chin"),
    at(2, 13, (2, 14), "left corner of the jaw bone"),
    at(2, 14, (2, 13), "right corner of the jaw bone"),
    at(3, 1, (3, 2), "centre of the upper inner left eyelid"),
    at(3, 2, (3, 1), "centre of the upper inner right eyelid"),
    at(3, 3, (3, 4), "centre of the lower inner left eyelid"),
    at(3, 4, (3, 3), "centre of the lower inner right eyelid"),
    at(3, 5, (3, 6), "centre of the left pupil"),
    at(3, 6, (3, 5), "centre of the right pupil"),
    at(3, 7, (3, 12), "left corner of the left eye"),
    at(3, 8, (3, 11), "left corner of the right eye"),
    at(3, 9, (3, 10), "centre of the lower outer left eyelid"),
    at(3, 10, (3, 9), "centre of the lower outer right eyelid"),
    at(3, 11, (3, 8), "right corner of the left eye"),
    at(3, 12, (3, 7), "right corner of the right eye"),
    at(3, 13, (3, 14), "centre of the upper outer left eyelid"),
    at(3, 14, (3, 13), "centre of the upper outer right eyelid"),
    at(4, 1, (4, 2), "right corner of the left eyebrow, the inner end"),
    at(4, 2, (4, 1), "left corner of the right eyebrow, the inner end"),
    at(4, 3, (4, 4), "uppermost point of the left eyebrow"),
    at(4, 4, (4, 3), "uppermost point of the right eyebrow"),
    at(4, 5, (4, 6), "left corner of the left eyebrow, the outer end"),
    at(4, 6, (4, 5), "right corner of the right eyebrow, the outer end"),
    at(5, 1, (5, 2), "centre of the left cheek"),
    at(5, 2, (5, 1), "centre of the right cheek"),
    at(5, 3, (5, 4), "left cheek bone"),
    at(5, 4, (5, 3), "right cheek bone"),
    at(6, 1, (6, 1), "tip of the tongue"),
    at(6, 2, (6, 2), "centre of the tongue body"),
    at(6, 3, (6, 4), "left border of the tongue"),
    at(6, 4, (6, 3), "right border of the tongue"),
    at(7, 1, (7, 1), "top of the spine, centre of head rotation"),
    at(8, 1, (8, 1), "middle of the outer upper lip contour"),
    at(8, 2, (8, 2), "middle of the outer lower lip contour"),
    at(8, 3, (8, 4), "left corner of the outer lip contour"),
    at(8, 4, (8, 3), "right corner of the outer lip contour"),
    at(8, 5, (8, 6), "midway between middle and left corner of the outer upper lip"),
    at(8, 6, (8, 5), "midway between middle and right corner of the outer upper lip"),
    at(8, 7, (8, 8), "midway between middle and left corner of the outer lower lip"),
    at(8, 8, (8, 7), "midway between middle and right corner of the outer lower lip"),
    at(8, 9, (8, 10), "right high point of Cupid's bow"),
    at(8, 10, (8, 9), "left high point of Cupid's bow"),
    at(9, 1, (9, 2), "left nostril border"),
    at(9, 2, (9, 1), "right nostril border"),
    at(9, 3, (9, 3), "nose tip"),
    at(9, 4, (9, 5), "bottom right edge of the nose"),
    at(9, 5, (9, 4), "bottom left edge of the nose"),
    at(9, 6, (9, 7), "right upper edge of the nose bone"),
    at(9, 7, (9, 6), "left upper edge of the nose bone"),
    at(9, 8, (9, 8), "top of the upper teeth"),
    at(9, 9, (9, 9), "bottom of the lower teeth"),
    at(9, 10, (9, 10), "bottom of the upper teeth"),
    at(9, 11, (9, 11), "top of the lower teeth"),
    at(9, 12, (9, 12), "middle lower edge of the nose bone"),
    at(9, 13, (9, 14), "left lower edge of the nose bone"),
    at(9, 14, (9, 13), "right lower edge of the nose bone"),
    at(9, 15, (9, 15), "bottom middle edge of the nose"),
    at(10, 1, (10, 2), "top of the left ear"),
    at(10, 2, (10, 1), "top of the right ear"),
    at(10, 3, (10, 4), "back of the left ear"),
    at(10, 4, (10, 3), "back of the right ear"),
    at(10, 5, (10, 6), "bottom of the left ear lobe"),
    at(10, 6, (10, 5), "bottom of the right ear lobe"),
    at(10, 7, (10, 8), "lower contact point of the left lobe and the face"),
    at(10, 8, (10, 7), "lower contact point of the right lobe and the face"),
    at(10, 9, (10, 10), "upper contact point of the left ear and the face"),
    at(10, 10, (10, 9), "upper contact point of the right ear and the face"),
    at(11, 1, (11, 1), "middle border of hair and forehead"),
    at(11, 2, (11, 3), "right border of hair and forehead"),
    at(11, 3, (11, 2), "left border of hair and forehead"),
    at(11, 4, (11, 4), "top of the skull"),
    at(11, 5, (11, 5), "top of the hair, above 11.4"),
    at(11, 6, (11, 6), "back of the skull"),
];

/// Returns the index of a point in [`FEATURE_POINTS`]; `None` if there is no such point.
pub fn feature_point_index(point: PointId) -> Option<usize> {
    FEATURE_POINTS
        .binary_search_by_key(&point, |p| p.point)
        .ok()
}

const fn at(group: u8, number: u8, mirror: PointId, place: &'static str) -> FeaturePointEntry {
    FeaturePointEntry {
        point: (group, number),
        mirror,
        place,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fap_table::TABLE;

    #[test]
    fn in_order_and_mirrored_in_pairs() {
        assert!(FEATURE_POINTS.is_sorted_by_key(|p| p.point));
        for (index, entry) in FEATURE_POINTS.iter().enumerate() {
            assert_eq!(feature_point_index(entry.point), Some(index));
            let mirror = &FEATURE_POINTS[feature_point_index(entry.mirror).unwrap()];
            assert_eq!(mirror.mirror, entry.point);
            // The words of the two sides differ by left and right alone.
            let swapped = entry.place.replace("left", "#").replace("right", "left");
            assert_eq!(mirror.place, swapped.replace('#', "right"));
        }
        assert_eq!(feature_point_index((2, 15)), None);
    }

    #[test]
    fn every_low_level_parameter_moves_one() {
        let points = TABLE.iter().filter_map(|fap| fap.action);
        assert_eq!(points.clone().count(), 66);
        for action in points {
            assert!(feature_point_index(action.point).is_some());
        }
    }
}
