//! Long runs of keys that one straight piece approximates.

/// Splits `0..=last` into runs that fit and returns the end of each, the last one `last`. A run of
/// one step always fits. Each is found by doubling and then halving its length, so that the cost is
/// proportional to the runs and not quadratic.
pub(crate) fn long_runs(last: usize, fits: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let mut ends = Vec::new();
    let mut at = 0;
    while at < last {
        let fits = |to: usize| to <= last && fits(at, to);
        let (mut reached, mut step) = (at + 1, 1);
        while fits(reached + step) {
            reached += step;
            step *= 2;
        }
        while step > 1 {
            step /= 2;
            if fits(reached + step) {
                reached += step;
            }
        }
        ends.push(reached);
        at = reached;
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn the_longest_runs_by_hand() {
        assert_eq!(long_runs(12, |from, to| to - from <= 5), [5, 10, 12]);
        assert_eq!(long_runs(12, |from, to| to - from <= 6), [6, 12]);
        assert_eq!(long_runs(3, |_, _| false), [1, 2, 3]);
        assert_eq!(long_runs(0, |_, _| true), [0; 0]);
        // None crosses seven.
        assert_eq!(long_runs(9, |from, to| from >= 7 || to <= 7), [7, 9]);
    }

    #[test]
    fn a_run_is_found_in_logarithmic_time() {
        for longest in [1000, 1023, 1024] {
            let tests = Cell::new(0);
            let fits = |from, to| {
                tests.set(tests.get() + 1);
                to - from <= longest
            };
            assert_eq!(long_runs(longest, fits), [longest]);
            // Ten doublings and as many halvings.
            assert!(tests.get() <= 22, "{} tests", tests.get());
        }
    }
}
