//! Fewer joints for each vertex: the largest weights kept, the rest shared out among them.

/// Weights closer than this count as equal, so that vertices at one place that differ by
/// rounding keep the same joints and no seam opens.
const WEIGHT_STEPS: f32 = 4096.0;

/// Keeps the `count` largest of (index, weight) pairs and scales them to the sum that all had.
///
/// Of equal weights the smaller index stays. What is left is in the order of falling weight if
/// anything was cut, and untouched otherwise. At least one stays.
pub fn keep_largest(influences: &mut Vec<(u16, f32)>, count: usize) {
    let count = count.max(1);
    if influences.len() <= count {
        return;
    }
    let sum = |list: &[(u16, f32)]| list.iter().map(|(_, w)| *w).sum::<f32>();
    let all = sum(influences);
    influences.sort_by_key(|(index, weight)| {
        let steps = (weight * WEIGHT_STEPS).round() as i64;
        (std::cmp::Reverse(steps), *index)
    });
    influences.truncate(count);
    let left = sum(influences);
    if left > 0.0 {
        for (_, weight) in influences.iter_mut() {
            *weight *= all / left;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_stay_and_share_what_is_cut() {
        let mut list = vec![(7, 0.1), (3, 0.5), (2, 0.1), (9, 0.3)];
        keep_largest(&mut list, 4);
        assert_eq!(list[0], (7, 0.1), "nothing to cut");
        keep_largest(&mut list, 3);
        let indices: Vec<u16> = list.iter().map(|i| i.0).collect();
        assert_eq!(indices, [3, 9, 2], "of equal ones the smaller index stays");
        assert!((list.iter().map(|i| i.1).sum::<f32>() - 1.0).abs() < 1e-6);
        keep_largest(&mut list, 0);
        assert_eq!(list.len(), 1);
        assert!((list[0].1 - 1.0).abs() < 1e-6);
        let mut rounding = vec![(5, 0.500_000_1), (4, 0.499_999_9)];
        keep_largest(&mut rounding, 1);
        assert_eq!(rounding[0].0, 4, "a seam's two vertices agree");
        let mut none: Vec<(u16, f32)> = vec![];
        keep_largest(&mut none, 1);
        assert!(none.is_empty());
    }
}
