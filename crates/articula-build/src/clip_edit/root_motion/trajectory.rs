//! The path of the hips over the ground, and their heading.

use super::super::grid::VERIFIED_HZ;
use super::super::heading::{wrapped, yaw};
use super::super::similarity::Similarity;
use super::super::subject::{EditSubject, Posed};
use articula_core::source::RawClip;
use glam::{DVec2, DVec3, Quat};

/// Displacement and turn of the root at a time, relative to the first frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TrajectoryKey {
    /// Seconds from the start of the clip.
    pub secs: f32,
    /// Displacement of the hips along +X, metres.
    pub x_metres: f32,
    /// Displacement of the hips along +Z, metres.
    pub z_metres: f32,
    /// Turn of the hips about the vertical, from +Z towards +X, radians; whole turns count.
    pub yaw_radians: f32,
}

/// Below this the heading is partly interpolated from the frames before and after: the body is
/// tilted by more than some 100 degrees from the first frame, as in a somersault, and close to
/// facing backwards by being upside down.
const SURE: f64 = 0.4;

/// Below this the heading is interpolated alone.
const UNSURE: f64 = 0.15;

/// The trajectory of one clip.
pub(in super::super) struct Trajectory<'a> {
    subject: &'a EditSubject<'a>,
    clip: &'a RawClip,
    hips: usize,
    /// Hips in the first frame.
    start: Place,
    first: Quat,
    /// Positions and headings at the ticks of [`VERIFIED_HZ`].
    ticks: Vec<Place>,
    is_smoothed: bool,
}

/// Position and heading of the hips at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    ground: DVec2,
    /// Relative to the start; without whole turns where it was not followed from there.
    yaw: f64,
    /// Share of the rotation that is about the vertical: 1 upright, 0 upside down.
    sure: f64,
}

impl<'a> Trajectory<'a> {
    /// With `smooth_secs` above 0, each sample is a weighted mean over that time around it (over
    /// less near the ends, so that these stay).
    pub(in super::super) fn new(
        subject: &'a EditSubject<'a>,
        clip: &'a RawClip,
        smooth_secs: f32,
    ) -> Self {
        let mut posed = subject.rest();
        subject.pose(clip, 0.0, &mut posed);
        let hips = subject.hips();
        let first = turn(subject, hips, &posed);
        let mut trajectory = Self {
            subject,
            clip,
            hips,
            start: place(subject, hips, &posed, first),
            first,
            ticks: Vec::new(),
            is_smoothed: smooth_secs > 0.0,
        };
        let ticks = (clip.duration_secs * VERIFIED_HZ).ceil() as usize + 1;
        let places = trajectory.followed(ticks);
        // A mean over half of the time, twice: triangular weights.
        let half = (0.25 * smooth_secs * VERIFIED_HZ).round() as usize;
        trajectory.ticks = means(&means(&places, half), half);
        trajectory
    }

    /// The transform from the hips in the first frame to the hips at a time.
    pub(super) fn step(&self, secs: f32, posed: &Posed) -> Similarity {
        let place = self.place(secs, posed);
        let flat = |p: DVec2| DVec3::new(p.x, 0.0, p.y);
        Similarity::on_ground(place.yaw, flat(self.start.ground), flat(place.ground))
    }

    /// The trajectory at ascending times.
    pub(in super::super) fn keys(&self, times: &[f32]) -> Vec<TrajectoryKey> {
        let mut posed = self.subject.rest();
        let mut sampler = self.subject.sampler(self.clip);
        let mut yaw = 0.0;
        let key = |secs: &f32| {
            let at = (&mut sampler, *secs);
            self.subject.next_pose_above(at, self.hips, &mut posed);
            let place = self.place(*secs, &posed);
            yaw = followed(yaw, place.yaw);
            let way = place.ground - self.start.ground;
            TrajectoryKey {
                secs: *secs,
                x_metres: way.x as f32,
                z_metres: way.y as f32,
                yaw_radians: yaw as f32,
            }
        };
        times.iter().map(key).collect()
    }

    fn place(&self, secs: f32, posed: &Posed) -> Place {
        let nearby = between(&self.ticks, secs);
        if self.is_smoothed {
            return nearby;
        }
        let exact = place(self.subject, self.hips, posed, self.first);
        let t = ((exact.sure - UNSURE) / (SURE - UNSURE)).clamp(0.0, 1.0);
        let off = f64::from(wrapped((exact.yaw - nearby.yaw) as f32));
        Place {
            yaw: nearby.yaw + off * t * t * (3.0 - 2.0 * t),
            ..exact
        }
    }

    /// Samples at the ticks of [`VERIFIED_HZ`], whole turns counted; where the heading is not
    /// reliable, it is interpolated linearly between the reliable ones on either side.
    fn followed(&self, ticks: usize) -> Vec<Place> {
        let mut posed = self.subject.rest();
        let mut sampler = self.subject.sampler(self.clip);
        let mut places: Vec<Place> = Vec::with_capacity(ticks);
        let mut sure = 0;
        for i in 0..ticks {
            let at = (&mut sampler, i as f32 / VERIFIED_HZ);
            self.subject.next_pose_above(at, self.hips, &mut posed);
            let mut place = place(self.subject, self.hips, &posed, self.first);
            let before = places.get(sure).map_or(0.0, |p| p.yaw);
            if place.sure < SURE {
                place.yaw = before;
            } else {
                place.yaw = followed(before, place.yaw);
                let steps = (i - sure) as f64;
                for (k, unsure) in places[sure..].iter_mut().enumerate().skip(1) {
                    unsure.yaw = before + (place.yaw - before) * k as f64 / steps;
                }
                sure = i;
            }
            places.push(place);
        }
        places
    }
}

/// The angle nearest to the one before that equals `yaw` up to whole turns.
fn followed(before: f64, yaw: f64) -> f64 {
    before + f64::from(wrapped((yaw - before) as f32))
}

/// Rotation of a joint in model space.
fn turn(subject: &EditSubject<'_>, joint: usize, posed: &Posed) -> Quat {
    let mut turn = posed.local.rotations[joint];
    let mut at = subject.rig.parent(joint);
    while let Some(j) = at {
        turn = posed.local.rotations[j] * turn;
        at = subject.rig.parent(j);
    }
    turn.normalize()
}

fn place(subject: &EditSubject<'_>, hips: usize, posed: &Posed, first: Quat) -> Place {
    let p = posed.model.position(hips);
    let turn = turn(subject, hips, posed) * first.conjugate();
    Place {
        ground: DVec2::new(f64::from(p.x), f64::from(p.z)),
        yaw: f64::from(yaw(turn)),
        sure: f64::from(turn.y * turn.y + turn.w * turn.w),
    }
}

/// Replaces each sample by the mean of those up to `half` away on either side, as far as both sides
/// reach.
fn means(places: &[Place], half: usize) -> Vec<Place> {
    let mut sums = vec![(DVec2::ZERO, 0.0)];
    for p in places {
        let (ground, yaw) = sums[sums.len() - 1];
        sums.push((ground + p.ground, yaw + p.yaw));
    }
    let mean = |i: usize| {
        let reach = half.min(i).min(places.len() - 1 - i);
        let (low, high) = (sums[i - reach], sums[i + reach + 1]);
        let count = (2 * reach + 1) as f64;
        Place {
            ground: (high.0 - low.0) / count,
            yaw: (high.1 - low.1) / count,
            ..places[i]
        }
    };
    (0..places.len()).map(mean).collect()
}

fn between(places: &[Place], secs: f32) -> Place {
    let at = f64::from(secs * VERIFIED_HZ).clamp(0.0, (places.len() - 1) as f64);
    let before = (at as usize).min(places.len() - 1);
    let after = (before + 1).min(places.len() - 1);
    let (a, b, t) = (places[before], places[after], at - before as f64);
    Place {
        ground: a.ground.lerp(b.ground, t),
        yaw: a.yaw + (b.yaw - a.yaw) * t,
        ..a
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_keep_lines_and_ends() {
        let line = |i: usize| Place {
            ground: DVec2::new(i as f64, 2.0 * i as f64),
            yaw: 0.1 * i as f64,
            sure: 1.0,
        };
        let mut places: Vec<Place> = (0..20).map(line).collect();
        for (a, b) in means(&places, 3).iter().zip(&places) {
            assert!((a.ground - b.ground).length() < 1e-9 && (a.yaw - b.yaw).abs() < 1e-9);
        }
        places[10].ground.x += 7.0;
        let smooth = means(&places, 3);
        // One of seven samples is 7 m off.
        assert!((smooth[10].ground.x - 11.0).abs() < 1e-9);
        for end in [0, 19] {
            assert!((smooth[end].ground - places[end].ground).length() < 1e-9);
        }
        let half = between(&places, 2.5 / VERIFIED_HZ);
        assert!((half.ground.x - 2.5).abs() < 1e-6);
    }

    #[test]
    fn whole_turns_are_followed() {
        let mut yaw = 0.0;
        for i in 0..100 {
            yaw = followed(yaw, f64::from(wrapped(0.1 * i as f32)));
        }
        assert!((yaw - 9.9).abs() < 1e-4);
    }
}
