//! One level of several, from the limits of network, device, view and user.
//!
//! Source: thesis 3.2 (constraints are grouped and given to one decision).

/// Who limits a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LimitSource {
    /// The bandwidth.
    Network,
    /// The time per frame on the device.
    Device,
    /// What can be seen from here.
    View,
    /// What the user allows.
    User,
}

/// The finest level that somebody allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LevelLimit {
    /// Who.
    pub source: LimitSource,
    /// The level, 0 is the finest; `None` if not even the coarsest is allowed.
    pub finest: Option<usize>,
}

/// A level and who keeps it from being finer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LevelChoice {
    /// The level; `None` if a limit allows none, so that another representation is needed.
    pub level: Option<usize>,
    /// Whose limit it is; `None` at level 0.
    pub bound: Option<LimitSource>,
}

/// Returns the finest level of `count` that all limits allow.
///
/// Of equal limits the first is named. A view or a user that allows only levels coarser than the
/// coarsest gets the coarsest: there is nothing to save. A network or a device that does so gets
/// none.
///
/// ```
/// use articula_stream::decide::{LevelLimit, LimitSource, combine};
///
/// let limit = |source, level| LevelLimit { source, finest: Some(level) };
/// let limits = [limit(LimitSource::Network, 1), limit(LimitSource::View, 2)];
/// let choice = combine(&limits, 4);
/// assert_eq!((choice.level, choice.bound), (Some(2), Some(LimitSource::View)));
/// ```
pub fn combine(limits: &[LevelLimit], count: usize) -> LevelChoice {
    let mut choice = LevelChoice {
        level: (count > 0).then_some(0),
        bound: None,
    };
    for limit in limits {
        let soft = matches!(limit.source, LimitSource::View | LimitSource::User);
        let finest = match limit.finest {
            Some(level) if level < count => Some(level),
            _ if soft => count.checked_sub(1),
            _ => None,
        };
        let coarser = match (finest, choice.level) {
            (_, None) => false,
            (None, Some(_)) => true,
            (Some(new), Some(level)) => new > level,
        };
        if coarser {
            choice = LevelChoice {
                level: finest,
                bound: Some(limit.source),
            };
        }
    }
    choice
}

#[cfg(test)]
mod tests {
    use super::*;
    use LimitSource::{Device, Network, User, View};

    fn limits(all: &[(LimitSource, Option<usize>)]) -> Vec<LevelLimit> {
        let limit = |&(source, finest): &_| LevelLimit { source, finest };
        all.iter().map(limit).collect()
    }

    #[test]
    fn the_coarsest_limit_binds_and_is_named() {
        let all = limits(&[
            (Network, Some(1)),
            (Device, Some(3)),
            (View, Some(2)),
            (User, Some(3)),
        ]);
        let choice = combine(&all, 5);
        assert_eq!((choice.level, choice.bound), (Some(3), Some(Device)));
        let none = combine(&limits(&[(Network, Some(0))]), 5);
        assert_eq!((none.level, none.bound), (Some(0), None));
        assert_eq!(combine(&[], 5).level, Some(0));
        assert_eq!(combine(&[], 0).level, None);
    }

    #[test]
    fn too_little_bandwidth_needs_another_representation_and_a_far_view_does_not() {
        let poor = combine(&limits(&[(Network, None), (View, Some(2))]), 3);
        assert_eq!((poor.level, poor.bound), (None, Some(Network)));
        let far = combine(&limits(&[(View, Some(9))]), 3);
        assert_eq!((far.level, far.bound), (Some(2), Some(View)));
    }
}
