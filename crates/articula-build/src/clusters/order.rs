//! In which order clusters lie, so that what a level shows is few ranges.

/// A place in the list of clusters.
pub(super) type Place = (u8, u16, u16, u16);

/// The order of clusters in the index list.
///
/// Steps count from the coarsest level, 0, to the finest, `n`. `C(k,j)` are the triangles that
/// steps `k` to `j - 1` show, `C(k,k)` those that live to the finest. Inside each, regions rise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClusterOrder {
    /// What each step adds: `C(0,1) .. C(0,n) C(0,0) | C(1,2) .. C(1,1) | ..`.
    /// Any first chunks make a mesh; of chunk `k` a step shows one suffix, so step `i` has at
    /// most `i + 1` ranges.
    Chunks,
    /// The finest level in one piece, then what only coarser levels show, so that who knows
    /// nothing of levels draws the first piece:
    /// `C(n,n) .. C(0,0) | C(0,n) .. C(0,1) | C(1,2) .. C(1,n) | C(2,n) .. C(2,3) | ..`.
    ///
    /// What a step shows of each list is a prefix of those that fall and a suffix of those that
    /// rise, so they meet: step `i` has at most `1 + (i + 1) / 2` ranges, the finest one.
    Store,
}

impl ClusterOrder {
    /// Where triangles lie that live from step `first` to `last` of `finest`.
    pub(super) fn place(self, first: u16, last: u16, region: u16, finest: u16) -> Place {
        match self {
            Self::Chunks => (0, first, last, region),
            Self::Store if last == finest => (0, finest - first, 0, region),
            Self::Store if first.is_multiple_of(2) => (1, first, finest - last, region),
            Self::Store => (1, first, last, region),
        }
    }
}
