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
