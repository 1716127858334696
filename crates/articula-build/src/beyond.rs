//! How many values lie beyond their 95th percentile.

/// Number of values of `count` that may exceed their 95th percentile as `percentile` interpolates
/// it: those beyond the upper of its two neighbours.
pub(crate) fn points_beyond(count: usize) -> usize {
    let below = (0.95 * count.saturating_sub(1) as f32) as usize;
    count.saturating_sub(below + 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::percentile;

    #[test]
    fn the_count_beyond_is_that_of_the_percentile() {
        assert_eq!(
            [0, 1, 2, 20, 30, 700].map(points_beyond),
            [0, 0, 0, 0, 1, 34]
        );
        for count in [1, 2, 19, 20, 21, 30, 100, 700] {
            let beyond = points_beyond(count);
            let mut values = vec![1.0; count];
            values[..beyond].fill(9.0);
            assert_eq!(percentile(&mut values.clone(), 0.95), 1.0, "{count}");
        }
    }
}
