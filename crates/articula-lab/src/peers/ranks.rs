//! Update rates by rank of distance, the method of several engines for crowds.
//!
//! The nearest visible characters are evaluated at every frame, the next ones at a fixed rate with
//! their last pose held between, all others are frozen or show a pose that was baked beforehand.
//! Several engines ship such ranks. This module decides the time that each character shows and
//! evaluates nothing.

use articula_core::Camera;
use glam::Vec3;

/// Radius of the ball around the middle of a body by which its visibility is tested, metres.
const BODY_RADIUS_METRES: f32 = 1.0;

/// Pose of the characters beyond all ranks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Beyond {
    /// The pose at the beginning of the scene.
    Frozen,
    /// The nearest of the poses baked at this rate; it costs no evaluation.
    Baked { hz: f64 },
}

/// Numbers of characters and rates of the ranks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ranks {
    /// Number of nearest characters that are evaluated at every frame.
    pub(crate) full: usize,
    /// Number of next characters, whose pose is held between evaluations.
    pub(crate) reduced: usize,
    /// Rate of these evaluations, hertz.
    pub(crate) reduced_hz: f64,
    pub(crate) beyond: Beyond,
}

impl Default for Ranks {
    /// 8 at every frame, 32 at 20 Hz, the others frozen.
    fn default() -> Self {
        Self {
            full: 8,
            reduced: 32,
            reduced_hz: 20.0,
            beyond: Beyond::Frozen,
        }
    }
}

/// Rank of a character.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rank {
    /// Outside of the picture.
    Hidden,
    Full,
    Reduced,
    Beyond,
}

/// Rank and shown time of a character.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moment {
    pub(crate) rank: Rank,
    /// Time of the scene whose pose the character shows, seconds.
    pub(crate) secs: f64,
}

impl Ranks {
    /// Rank and shown time of each character at a time of the scene. A pure function of its
    /// arguments: held characters are evaluated at multiples of their interval, each shifted by its
    /// index so that they do not all fall into one frame.
    pub(crate) fn moments(&self, camera: &Camera, positions: &[Vec3], secs: f64) -> Vec<Moment> {
        let near = |p: &Vec3| is_visible(camera, *p).then(|| p.distance_squared(camera.eye));
        self.moments_of(positions.iter().map(near), secs)
    }

    /// The same by the squared distance of each character, `None` of those outside of the pictures.
    pub(crate) fn moments_of(
        &self,
        distances: impl Iterator<Item = Option<f32>>,
        secs: f64,
    ) -> Vec<Moment> {
        let (mut moments, mut nearest) = (Vec::new(), Vec::new());
        for (i, distance) in distances.enumerate() {
            nearest.extend(distance.map(|d| (d, i)));
            moments.push(Moment {
                rank: Rank::Hidden,
                secs,
            });
        }
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (rank, (_, i)) in nearest.into_iter().enumerate() {
            moments[i] = self.moment(rank, i, secs);
        }
        moments
    }

    fn moment(&self, rank: usize, index: usize, secs: f64) -> Moment {
        if rank < self.full {
            return Moment {
                rank: Rank::Full,
                secs,
            };
        }
        if rank - self.full < self.reduced {
            // The golden ratio spreads any number of characters evenly over an interval.
            let shift = (index as f64 * 0.618_033_988_749_895).fract();
            let step = (secs * self.reduced_hz + shift).floor() - shift;
            return Moment {
                rank: Rank::Reduced,
                secs: step / self.reduced_hz,
            };
        }
        let shown = match self.beyond {
            Beyond::Frozen => 0.0,
            Beyond::Baked { hz } => (secs * hz).round() / hz,
        };
        Moment {
            rank: Rank::Beyond,
            secs: shown,
        }
    }
}

/// Whether a body at a position is in the picture, by a ball around its middle.
pub(crate) fn is_visible(camera: &Camera, position: Vec3) -> bool {
    let p = camera.view(position + Vec3::Y * BODY_RADIUS_METRES);
    let slope_y = (0.5 * camera.viewport.fov_y_radians).tan();
    let slope_x = slope_y * camera.viewport.width_px / camera.viewport.height_px;
    // Signed distance to a side plane through the eye; a body farther outside than its radius is
    // hidden.
    let within = |across: f32, slope: f32| {
        across.abs() - slope * p.z <= BODY_RADIUS_METRES * slope.hypot(1.0)
    };
    p.z > -BODY_RADIUS_METRES && within(p.x, slope_x) && within(p.y, slope_y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Viewport;

    /// A row of bodies straight ahead, the farthest first, and one behind the camera.
    fn row(count: usize) -> (Camera, Vec<Vec3>) {
        let eye = Vec3::Y * 1.7;
        let camera = Camera::looking_at(eye, eye - Vec3::Z, Viewport::default());
        let mut positions: Vec<Vec3> = (0..count)
            .map(|i| Vec3::NEG_Z * (10.0 + 2.0 * (count - i) as f32))
            .collect();
        positions.push(Vec3::Z * 10.0);
        (camera, positions)
    }

    #[test]
    fn the_nearest_come_first() {
        let (camera, positions) = row(100);
        let moments = Ranks::default().moments(&camera, &positions, 7.01);
        let count = |rank| moments.iter().filter(|m| m.rank == rank).count();
        assert_eq!(count(Rank::Full), 8);
        assert_eq!(count(Rank::Reduced), 32);
        assert_eq!(count(Rank::Beyond), 60);
        assert_eq!(moments[100].rank, Rank::Hidden);
        assert!(
            moments[92..100]
                .iter()
                .all(|m| m.rank == Rank::Full && m.secs == 7.01)
        );
        assert!(moments[..60].iter().all(|m| m.secs == 0.0), "frozen");
    }

    #[test]
    fn held_poses_are_never_older_than_their_interval_and_are_spread() {
        let (camera, positions) = row(40);
        let mut changes = vec![0; 60];
        let mut before: Option<Vec<Moment>> = None;
        for (frame, changed) in changes.iter_mut().enumerate() {
            let secs = 3.0 + frame as f64 / 60.0;
            let now = Ranks::default().moments(&camera, &positions, secs);
            for (i, m) in now
                .iter()
                .enumerate()
                .filter(|(_, m)| m.rank == Rank::Reduced)
            {
                let age = secs - m.secs;
                assert!((-1e-9..0.05 + 1e-9).contains(&age), "{age} s old");
                if before.as_ref().is_some_and(|b| b[i].secs != m.secs) {
                    *changed += 1;
                }
            }
            before = Some(now);
        }
        // A third of 32 in each frame at 60 Hz, within two.
        assert!(
            changes[1..].iter().all(|c| (8..=13).contains(c)),
            "{changes:?}"
        );
    }

    #[test]
    fn baked_poses_are_the_nearest_ones() {
        let (camera, positions) = row(50);
        let ranks = Ranks {
            beyond: Beyond::Baked { hz: 10.0 },
            ..Ranks::default()
        };
        let moments = ranks.moments(&camera, &positions, 1.26);
        assert!((moments[0].secs - 1.3).abs() < 1e-9);
    }

    #[test]
    fn a_body_at_the_edge_is_seen_until_all_of_it_is_out() {
        let (camera, _) = row(0);
        // 720 px at 45 degrees, 1280 wide: the right edge is at 0.7364 of the depth.
        let edge = 0.736_37 * 20.0;
        assert!(is_visible(&camera, Vec3::new(edge + 1.2, 0.0, -20.0)));
        assert!(!is_visible(&camera, Vec3::new(edge + 1.3, 0.0, -20.0)));
        assert!(!is_visible(&camera, Vec3::new(0.0, 0.0, 2.0)));
    }
}
