//! Orders of clusters in which a level is few ranges.

/// Sort key of a cluster.
pub(super) type Place = (u8, u16, u16, u16);

/// The order of clusters in the index list.
///
/// Steps count from the coarsest level, 0, to the finest, `n`. `C(k,j)` are the triangles shown at
/// exactly the steps `k` to `j - 1`, `C(k,k)` those shown from `k` to the finest. Inside each,
/// regions ascend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClusterOrder {
    /// What each step adds: `C(0,1) .. C(0,n) C(0,0) | C(1,2) .. C(1,1) | ..`.
    ///
    /// Any number of first chunks is a complete mesh. A step shows a suffix of each chunk, so step
    /// `i` has at most `i + 1` ranges.
    Chunks,
    /// The finest level in one range, then what only coarser levels show, so that a reader that
    /// ignores levels draws the first range:
    /// `C(n,n) .. C(0,0) | C(0,n) .. C(0,1) | C(1,2) .. C(1,n) | C(2,n) .. C(2,3) | ..`.
    ///
    /// A step shows a suffix of the first list, a prefix of each list that falls in `j` and a
    /// suffix of each that rises, so ranges of neighbouring lists meet: step `i` has at most
    /// `1 + (i + 1) / 2` ranges, the finest one.
    Store,
}

impl ClusterOrder {
    /// Sort key of triangles that are shown from step `first` to `last` of `finest`.
    pub(super) fn place(self, first: u16, last: u16, region: u16, finest: u16) -> Place {
        match self {
            Self::Chunks => (0, first, last, region),
            Self::Store if last == finest => (0, finest - first, 0, region),
            Self::Store if first.is_multiple_of(2) => (1, first, finest - last, region),
            Self::Store => (1, first, last, region),
        }
    }
}
