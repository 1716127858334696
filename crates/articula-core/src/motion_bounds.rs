//! Bounds of an animated character for each second of its clips, for culling.
//!
//! Source: `docs/methods/motion-lod.md` part 5. The bound of an interval is the union of those of
//! its seconds. Each second has a box and a sphere, which is smaller than the one around its box. A
//! blend of clips has a separate bound, because a blend of two poses need not lie between them.
//!
//! Computed ahead of time by `articula-build`, from every vertex.

use crate::Mismatch;
use crate::sample::Wrap;
use crate::sphere::Sphere;
use glam::Vec3;

/// A sphere and a box in model space that both contain the same points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// The sphere.
    pub sphere: Sphere,
    /// Minimum corner of the box.
    pub least: Vec3,
    /// Maximum corner of the box.
    pub greatest: Vec3,
}

impl Bound {
    /// Returns a bound that contains both.
    #[must_use]
    pub(crate) fn union(self, other: Self) -> Self {
        Self {
            sphere: self.sphere.union(other.sphere),
            least: self.least.min(other.least),
            greatest: self.greatest.max(other.greatest),
        }
    }

    /// Whether both the sphere and the box contain a point.
    pub fn contains(&self, point: Vec3) -> bool {
        self.sphere.contains(point)
            && point.cmpge(self.least).all()
            && point.cmple(self.greatest).all()
    }
}

/// Bounds of a character in one clip.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipBounds {
    duration_secs: f64,
    seconds: Vec<Bound>,
    whole: Bound,
    anchors: Sphere,
}

impl ClipBounds {
    /// Combines measured bounds.
    ///
    /// - `seconds`: entry `k` contains the character from second `k` of the clip to second `k + 1`,
    ///   both included; the last one may be shorter
    /// - `anchors`: contains the joint from which all skin hangs, over the whole clip
    ///
    /// # Errors
    /// A [`Mismatch`] if the duration is negative or not finite, or the number of seconds is not
    /// [`ClipBounds::count`].
    pub fn new(duration_secs: f32, seconds: Vec<Bound>, anchors: Sphere) -> Result<Self, Mismatch> {
        if !(duration_secs.is_finite() && duration_secs >= 0.0) {
            let what = format!("must be finite and at least 0, found {duration_secs}");
            return Err(Mismatch::new("duration_secs", what));
        }
        let expected = Self::count(duration_secs);
        let Some(whole) = seconds.iter().copied().reduce(Bound::union) else {
            return Err(Mismatch::new("seconds", "must hold at least one bound"));
        };
        if seconds.len() != expected {
            let what = format!("{} bounds for {expected} seconds", seconds.len());
            return Err(Mismatch::new("seconds", what));
        }
        Ok(Self {
            duration_secs: f64::from(duration_secs),
            seconds,
            whole,
            anchors,
        })
    }

    /// Number of entries for a clip of this duration: its seconds rounded up, at least one.
    pub fn count(duration_secs: f32) -> usize {
        (duration_secs.ceil() as usize).max(1)
    }

    /// Duration of the clip in seconds.
    pub fn duration_secs(&self) -> f32 {
        self.duration_secs as f32
    }

    /// Bounds of the character in each second of the clip.
    pub fn seconds(&self) -> &[Bound] {
        &self.seconds
    }

    /// Bound of the joint from which all skin hangs, over the whole clip.
    pub fn anchors(&self) -> Sphere {
        self.anchors
    }

    /// Bound of the character at every time of the clip.
    pub fn whole(&self) -> &Bound {
        &self.whole
    }

    /// Returns a bound of the character from clip time `now_secs` for `horizon_secs` of playback at
    /// `speed` (negative plays backwards). Times that are not finite give the bound of the whole
    /// clip.
    ///
    /// O(seconds passed over); does not allocate.
    pub fn over(&self, now_secs: f64, horizon_secs: f32, speed: f32, wrap: Wrap) -> Bound {
        let then = now_secs + f64::from(speed) * f64::from(horizon_secs);
        if !(now_secs.is_finite() && then.is_finite()) {
            return self.whole;
        }
        // Longer than any rounding of a clock that has run for days, shorter than any frame.
        let rounding = 1e-6;
        let from = now_secs.min(then) - rounding;
        let length = (then - now_secs).abs() + 2.0 * rounding;
        let end = self.duration_secs;
        match wrap {
            Wrap::Clamp => self.between(from.clamp(0.0, end), (from + length).clamp(0.0, end)),
            Wrap::Loop if length >= end => self.whole,
            Wrap::Loop => {
                let from = from.rem_euclid(end);
                let to = from + length;
                if to < end {
                    self.between(from, to)
                } else {
                    self.between(from, end).union(self.between(0.0, to - end))
                }
            }
        }
    }

    /// The union of the seconds from one time of the clip to another.
    fn between(&self, from: f64, to: f64) -> Bound {
        let last = self.seconds.len() - 1;
        let first = (from as usize).min(last);
        let rest = &self.seconds[first + 1..=(to as usize).clamp(first, last)];
        rest.iter().fold(self.seconds[first], |a, b| a.union(*b))
    }
}

/// Bounds of a character in all its clips.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionBounds {
    /// One entry for each clip, in the order of the clips.
    pub clips: Vec<ClipBounds>,
    /// Maximum distance of any skin from the joint from which it hangs, for any rotations of the
    /// joints below; metres.
    pub reach_metres: f32,
}

impl MotionBounds {
    /// Returns a bound of the character in every blend of two clips, at any times and weights. A
    /// blended arm may lie outside the bounds of both poses.
    ///
    /// # Panics
    /// If there is no such clip.
    pub fn blended(&self, a: usize, b: usize) -> Sphere {
        let anchors = self.clips[a].anchors.union(self.clips[b].anchors);
        Sphere {
            radius: anchors.radius + self.reach_metres,
            ..anchors
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A point that moves along x at 1 m/s for `duration_secs`.
    fn walk(duration_secs: f32) -> ClipBounds {
        let second = |k: usize| {
            let (from, to) = (k as f32, ((k + 1) as f32).min(duration_secs));
            let (least, greatest) = (Vec3::X * from, Vec3::X * to);
            Bound {
                sphere: Sphere::from_corners(least, greatest),
                least,
                greatest,
            }
        };
        let seconds = (0..ClipBounds::count(duration_secs)).map(second).collect();
        ClipBounds::new(duration_secs, seconds, Sphere::default()).unwrap()
    }

    #[test]
    fn validity_table() {
        let one = walk(0.5).seconds;
        let at = |duration, seconds| {
            ClipBounds::new(duration, seconds, Sphere::default())
                .unwrap_err()
                .at
        };
        assert_eq!(at(f32::NAN, one.clone()), "duration_secs");
        assert_eq!(at(-1.0, one.clone()), "duration_secs");
        assert_eq!(at(0.0, vec![]), "seconds");
        assert_eq!(at(1.5, one.clone()), "seconds");
        assert!(ClipBounds::new(0.0, one, Sphere::default()).is_ok());
    }

    #[test]
    fn what_lies_ahead_by_hand() {
        let clip = walk(3.5);
        let x = |now, horizon, speed, wrap| {
            let bound = clip.over(now, horizon, speed, wrap);
            (bound.least.x, bound.greatest.x)
        };
        assert_eq!(x(0.2, 0.5, 1.0, Wrap::Loop), (0.0, 1.0));
        assert_eq!(x(0.8, 0.5, 1.0, Wrap::Loop), (0.0, 2.0));
        assert_eq!(
            x(0.8, 0.5, 4.0, Wrap::Loop),
            (0.0, 3.0),
            "four times as fast"
        );
        assert_eq!(x(2.2, 0.5, -1.0, Wrap::Loop), (1.0, 3.0), "backwards");
        assert_eq!(x(1.2 + 7.0 * 3.5, 0.5, 1.0, Wrap::Loop), (1.0, 2.0));
        assert_eq!(
            x(-2.2, 0.1, 1.0, Wrap::Loop),
            (1.0, 2.0),
            "1.3 from the start"
        );
        let over_the_seam = clip.over(3.2, 0.5, 1.0, Wrap::Loop);
        assert_eq!(
            (over_the_seam.least.x, over_the_seam.greatest.x),
            (0.0, 3.5)
        );
        assert_eq!(x(3.2, 0.5, 1.0, Wrap::Clamp), (3.0, 3.5));
        assert_eq!(x(-9.0, 0.5, 1.0, Wrap::Clamp), (0.0, 1.0));
        assert_eq!(x(99.0, 0.5, 1.0, Wrap::Clamp), (3.0, 3.5));
        for odd in [f64::NAN, f64::INFINITY] {
            assert_eq!(x(odd, 0.5, 1.0, Wrap::Loop), (0.0, 3.5));
        }
        assert_eq!(x(0.2, f32::INFINITY, 1.0, Wrap::Clamp), (0.0, 3.5));
        assert_eq!(x(0.2, f32::NAN, 1.0, Wrap::Loop), (0.0, 3.5));
        let still = walk(0.0);
        assert_eq!(still.over(5.0, 1.0, 1.0, Wrap::Loop), still.whole);
    }

    #[test]
    fn a_blend_reaches_from_wherever_it_hangs() {
        let hung = |x: f32| ClipBounds {
            anchors: Sphere {
                centre: Vec3::X * x,
                radius: 0.0,
            },
            ..walk(1.0)
        };
        let bounds = MotionBounds {
            clips: vec![hung(0.0), hung(2.0)],
            reach_metres: 1.5,
        };
        let both = bounds.blended(0, 1);
        assert!((both.centre - Vec3::X).length() < 1e-6 && (both.radius - 2.5).abs() < 1e-5);
        assert_eq!(bounds.blended(0, 0).radius, 1.5);
    }

    proptest! {
        #[test]
        fn no_time_ahead_is_missed(
            duration in 0.1f32..6.0,
            now in -50.0f64..50.0,
            horizon in 0.0f32..5.0,
            speed in -3.0f32..3.0,
            part in 0.0f64..1.0,
            wrap in prop::sample::select(vec![Wrap::Loop, Wrap::Clamp]),
        ) {
            let bound = walk(duration).over(now, horizon, speed, wrap);
            let at = now + f64::from(speed) * f64::from(horizon) * part;
            let end = f64::from(duration);
            let at = match wrap {
                Wrap::Loop => at.rem_euclid(end),
                Wrap::Clamp => at.clamp(0.0, end),
            };
            prop_assert!(bound.contains(Vec3::X * at as f32), "{at} s: {bound:?}");
        }
    }
}
