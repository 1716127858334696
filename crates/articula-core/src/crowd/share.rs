//! Shared poses: characters whose poses agree within their tolerance show one palette.
//!
//! Source: `docs/methods/motion-lod.md` part 6. Each clip has one clock. The phases relative to it
//! are cut into equal buckets, as few as keep half a bucket within the tolerance; all characters of
//! a bucket show one shared pose, whose phase is the middle of the bucket. Shared poses advance
//! with the clock, so a character that plays at the clip's own speed never changes its bucket and
//! shows no jump.

/// Minimum number of buckets of a clip, as a power of two: with fewer distinct poses a crowd looks
/// cloned (McDonnell et al., "Clone attack!", 2008).
const FEWEST: u32 = 3;
/// Maximum, as a power of two: more are as expensive as evaluating every character.
const MOST: u32 = 9;
/// Entries of one clip and level: the buckets for every power of two.
const ENTRIES: usize = 1 << (MOST + 1);

/// A shared pose of this frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Leader {
    pub(crate) clip: u16,
    pub(crate) level: u8,
    pub(crate) secs: f32,
}

/// The shared poses of all clips and levels.
#[derive(Debug, Clone)]
pub(crate) struct Sharing {
    levels: usize,
    /// Time of the common clock of each clip in seconds.
    clocks: Vec<f32>,
    /// For each bucket, the frame in which its shared pose was added, and the index of that pose.
    buckets: Vec<(u32, u32)>,
    frame: u32,
    leaders: Vec<Leader>,
}

/// A character that may show a shared pose.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Follower {
    pub(crate) clip: usize,
    pub(crate) level: usize,
    pub(crate) secs: f32,
    /// Allowed distance of its skin from its own pose, metres.
    pub(crate) slack_metres: f32,
}

/// Quantities of a clip that bound the error of shared poses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClipWay {
    pub(crate) duration_secs: f32,
    pub(crate) speed_metres_per_sec: f32,
    pub(crate) seam_metres: f32,
}

impl Sharing {
    pub(crate) fn new(clips: usize, levels: usize, characters: usize) -> Self {
        Self {
            levels,
            clocks: vec![0.0; clips],
            buckets: vec![(0, 0); clips * levels * ENTRIES],
            frame: 0,
            leaders: Vec::with_capacity(characters),
        }
    }

    /// Advances the clocks and clears the shared poses of the frame before.
    pub(crate) fn begin(&mut self, dt_secs: f32, durations: &[f32]) {
        self.frame = self.frame.wrapping_add(1);
        if self.frame == 0 {
            // After two years of play the counter wraps, and old stamps would look current.
            self.buckets.fill((0, 0));
            self.frame = 1;
        }
        self.leaders.clear();
        for (clock, duration) in self.clocks.iter_mut().zip(durations) {
            *clock += dt_secs;
            if *clock >= *duration {
                *clock = if *duration > 0.0 {
                    clock.rem_euclid(*duration)
                } else {
                    0.0
                };
            }
        }
    }

    pub(crate) fn leaders(&self) -> &[Leader] {
        &self.leaders
    }

    /// Index of the shared pose that a character shows within its slack, added if needed; `None` if
    /// the character must be evaluated alone.
    #[inline]
    pub(crate) fn leader(&mut self, follower: Follower, way: ClipWay) -> Option<usize> {
        let Follower {
            clip,
            level,
            secs,
            slack_metres,
        } = follower;
        let duration = way.duration_secs;
        // The widest buckets of which half of one is within the slack.
        let count = duration * way.speed_metres_per_sec / (2.0 * slack_metres);
        let most = (1u32 << MOST) as f32;
        if !(duration > 0.0 && count <= most) {
            return None;
        }
        // The exponent, rounded up.
        let exponent = (count.max(1.0).to_bits() + 0x007f_ffff) >> 23;
        let power = exponent.saturating_sub(127).max(FEWEST);
        let buckets = (1u32 << power) as f32;
        let mut phase = (secs - self.clocks[clip]) / duration;
        if phase < 0.0 {
            phase += 1.0;
        }
        let bucket = (phase * buckets).clamp(0.0, buckets - 1.0).floor();
        let mut leads = self.clocks[clip] + (bucket + 0.5) / buckets * duration;
        if leads >= duration {
            leads -= duration;
        }
        // Across the seam the distance between the clip's ends adds to the motion.
        let apart = (leads - secs).abs();
        let around = duration - apart;
        if around < apart && around * way.speed_metres_per_sec + way.seam_metres > slack_metres {
            return None;
        }
        let entry = (clip * self.levels + level) * ENTRIES + (1 << power) + bucket as usize;
        let (stamp, leader) = &mut self.buckets[entry];
        if *stamp != self.frame {
            *stamp = self.frame;
            *leader = self.leaders.len() as u32;
            self.leaders.push(Leader {
                clip: clip as u16,
                level: level as u8,
                secs: leads,
            });
        }
        Some(*leader as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WAY: ClipWay = ClipWay {
        duration_secs: 2.0,
        speed_metres_per_sec: 3.0,
        seam_metres: 0.0,
    };

    fn follower(secs: f32, slack_metres: f32) -> Follower {
        Follower {
            clip: 0,
            level: 1,
            secs,
            slack_metres,
        }
    }

    proptest! {
        /// The shared pose is never farther off in time than the slack allows at full speed, and a
        /// character at the clip's own speed keeps it.
        #[test]
        fn leaders_are_within_the_slack_and_stay(
            secs in 0.0f32..2.0,
            slack in 0.001f32..5.0,
            start in 0.0f32..2.0,
            seam in prop_oneof![Just(0.0f32), 0.0f32..3.0],
        ) {
            let way = ClipWay { seam_metres: seam, ..WAY };
            let mut sharing = Sharing::new(1, 2, 4);
            sharing.begin(start, &[2.0]);
            let Some(leader) = sharing.leader(follower(secs, slack), way) else {
                // Too many shared poses would be needed, or the seam lies between.
                prop_assert!(2.0 * 3.0 / (2.0 * slack) > 511.0 || seam > 0.0);
                return Ok(());
            };
            let leads = sharing.leaders()[leader].secs;
            let apart = (leads - secs).abs();
            let off = (apart * 3.0).min((2.0 - apart) * 3.0 + seam);
            prop_assert!(off <= slack + 1e-4, "{off} m, {slack} allowed");
            let ahead = (leads - secs).rem_euclid(2.0);
            sharing.begin(0.3, &[2.0]);
            if let Some(next) = sharing.leader(follower((secs + 0.3) % 2.0, slack), way) {
                let now = (sharing.leaders()[next].secs - secs - 0.3).rem_euclid(2.0);
                let turned = (now - ahead).rem_euclid(2.0);
                let turned = turned.min(2.0 - turned);
                // On the border of two buckets rounding may decide for the neighbour.
                let at_border = (apart.min(2.0 - apart) - 1.0 / 8.0).abs() < 1e-4
                    || apart.min(2.0 - apart) * 3.0 > 0.49 * slack;
                prop_assert!(turned < 1e-4 || at_border, "turned by {turned} s");
            }
        }
    }

    #[test]
    fn buckets_by_hand() {
        // Half of a bucket of 2 s / 16 is 0.0625 s, in which the clip moves 0.1875 m.
        let mut sharing = Sharing::new(1, 2, 100);
        sharing.begin(0.5, &[2.0]);
        let leads = |sharing: &mut Sharing, secs: f32, slack: f32| {
            let leader = sharing.leader(follower(secs, slack), WAY).unwrap();
            sharing.leaders()[leader].secs
        };
        for slack in [0.1876, 0.37] {
            assert_eq!(leads(&mut sharing, 0.51, slack), 0.5625);
            assert_eq!(leads(&mut sharing, 0.62, slack), 0.5625);
            assert_eq!(leads(&mut sharing, 0.63, slack), 0.6875);
            // Behind the clock, and over the end of the clip.
            assert_eq!(leads(&mut sharing, 0.49, slack), 0.4375);
            assert_eq!(leads(&mut sharing, 1.99, slack), 1.9375);
            assert_eq!(leads(&mut sharing, 0.01, slack), 0.0625);
        }
        // One level's poses are not those of another.
        let count = sharing.leaders().len();
        let other = Follower {
            level: 0,
            ..follower(0.51, 0.37)
        };
        assert_eq!(sharing.leader(other, WAY), Some(count));
        assert_eq!(leads(&mut sharing, 0.51, 0.1874), 0.53125);
        // Nor those of one clip of another.
        let mut many = Sharing::new(3, 2, 100);
        many.begin(0.0, &[2.0; 3]);
        for (clip, level) in (0..6).map(|i| (i / 2, i % 2)) {
            let other = Follower {
                clip,
                level,
                ..follower(0.1, 1e9)
            };
            assert_eq!(many.leader(other, WAY), Some(2 * clip + level));
            assert_eq!(many.leaders()[2 * clip + level].clip, clip as u16);
        }
        // 512 buckets are the most: 6 m / (2 · 512).
        assert!(sharing.leader(follower(0.51, 0.00586), WAY).is_some());
        assert!(sharing.leader(follower(0.51, 0.00585), WAY).is_none());
        // Just behind the clock: the phase rounds to 1, which is in the last bucket.
        let mut sharing = Sharing::new(1, 2, 100);
        sharing.begin(1e-9, &[2.0]);
        assert_eq!(leads(&mut sharing, 0.0, 1e9), 1.875);
    }

    #[test]
    fn a_shared_pose_does_not_depend_on_those_before_it() {
        let fresh = || {
            let mut sharing = Sharing::new(1, 2, 1000);
            sharing.begin(0.7, &[2.0]);
            sharing
        };
        let mut sharing = fresh();
        for slack in [1e9, 0.37, 0.18, 0.09, 0.02] {
            for secs in (0..100).map(|i| 0.02 * i as f32) {
                let mut alone = fresh();
                let expected = alone.leader(follower(secs, slack), WAY).unwrap();
                let found = sharing.leader(follower(secs, slack), WAY).unwrap();
                assert_eq!(sharing.leaders()[found], alone.leaders()[expected]);
            }
        }
    }

    #[test]
    fn clocks_go_around() {
        let mut sharing = Sharing::new(3, 1, 1);
        sharing.begin(1.5, &[2.0, 1.0, 0.0]);
        assert_eq!(sharing.clocks, [1.5, 0.5, 0.0]);
        sharing.begin(0.5, &[2.0, 1.0, 0.0]);
        assert_eq!(sharing.clocks, [0.0, 0.0, 0.0]);
        // The poses of the frame before are gone.
        let way = ClipWay {
            duration_secs: 2.0,
            ..WAY
        };
        let at = Follower {
            level: 0,
            ..follower(0.1, 1e9)
        };
        for _ in 0..2 {
            sharing.begin(0.0, &[2.0, 1.0, 0.0]);
            assert_eq!(sharing.leader(at, way), Some(0));
            assert_eq!(sharing.leaders().len(), 1);
        }
        // A stamp of before the counter wrapped would be of this frame.
        sharing.frame = u32::MAX;
        sharing.buckets.fill((1, 99));
        sharing.begin(0.0, &[2.0, 1.0, 0.0]);
        assert_eq!(sharing.leader(at, way), Some(0));
    }

    #[test]
    fn over_the_seam_only_within_the_slack() {
        let way = |seam_metres| ClipWay { seam_metres, ..WAY };
        // 8 buckets of 0.25 s; the one around the seam is led by 0 s, 1.95 s is 0.05 s before it:
        // 0.15 m of motion and the seam.
        for (seam, shares) in [(0.8, true), (0.9, false)] {
            let mut sharing = Sharing::new(1, 2, 100);
            sharing.begin(1.875, &[2.0]);
            let leader = sharing.leader(follower(1.95, 1.0), way(seam));
            assert_eq!(leader.is_some(), shares, "a seam of {seam} m");
            assert!(sharing.leader(follower(1.8, 1.0), way(seam)).is_some());
        }
    }

    #[test]
    fn a_few_leaders_remain_however_far_away_and_standing_clips_share_too() {
        let mut sharing = Sharing::new(1, 2, 100);
        sharing.begin(0.0, &[2.0]);
        for i in 0..100 {
            let follower = follower(i as f32 * 0.02, 1e9);
            assert!(sharing.leader(follower, WAY).is_some());
        }
        assert_eq!(sharing.leaders().len(), 8);
        let still = ClipWay {
            duration_secs: 0.0,
            ..WAY
        };
        assert!(sharing.leader(follower(0.0, 1.0), still).is_none());
    }
}
