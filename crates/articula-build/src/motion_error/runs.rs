//! Long runs of keys for which one straight piece is good enough.

/// Splits `0..=last` into runs that fit and gives the end of each, the last one `last`. A run
/// of one step always fits. Each is found by doubling and then halving its length, so that the
/// work grows with the runs and not with their squares.
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
