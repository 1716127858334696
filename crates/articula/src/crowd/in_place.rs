//! Clips that carry their character away are played on the spot; the way is kept apart.
//!
//! A scene says where everyone stands, so a walk that travels would leave its place and jump back
//! at the end of each lap. What stays within [`ROOM_METRES`] of where it begins is left alone: the
//! sway and the steps of a dance belong to it.

use articula_build::clip_edit::EditSubject;
use articula_build::clip_edit::{RootMotionMode, RootMotionOptions, TrajectoryKey, split};
use articula_core::crowd::{RootDelta, RootTrajectory};
use articula_core::source::Character;
use articula_core::{Articulation, Clip, Mismatch};
use glam::Vec3;

/// How far a clip may carry its character from the first frame: half the way to its neighbour on
/// the plaza.
const ROOM_METRES: f32 = 1.0;

/// The way is the mean over so long, so that the sway of the hips stays with them.
const SMOOTH_SECS: f32 = 1.0;

/// Puts clips that travel on the spot; gives the way of each clip that did, from its start on, and warnings on
/// clips that travel and could not be put. `end_sites` as [`EditSubject::new`] takes them.
pub fn put_in_place(
    character: &mut Character,
    articulation: Articulation,
    end_sites: &[(usize, Vec3)],
) -> (Vec<Option<Vec<TrajectoryKey>>>, Vec<String>) {
    let mut clips = std::mem::take(&mut character.clips);
    let subject = EditSubject::new(character, articulation, end_sites);
    let mut warnings = Vec::new();
    let mut ways = vec![None; clips.len()];
    // A character without a figure to split has clips that stay as they are.
    if let Ok(subject) = subject {
        for (clip, way) in clips.iter_mut().zip(&mut ways) {
            let told = split(&subject, clip, &RootMotionOptions::default());
            if !told.is_ok_and(|t| farthest(&t.trajectory) > ROOM_METRES) {
                continue;
            }
            let opts = RootMotionOptions {
                mode: RootMotionMode::InPlace,
                smooth_secs: SMOOTH_SECS,
            };
            match split(&subject, clip, &opts) {
                Ok(out) => {
                    *clip = out.clip;
                    *way = Some(out.trajectory);
                }
                Err(e) => warnings.push(format!("clip \"{}\" travels: {e}", clip.name)),
            }
        }
    }
    character.clips = clips;
    (ways, warnings)
}

fn farthest(way: &[TrajectoryKey]) -> f32 {
    let off = way.iter().map(|k| k.x_metres.hypot(k.z_metres));
    off.fold(0.0, f32::max)
}

/// The way at the frames of a clip.
///
/// # Errors
/// A [`Mismatch`] if the way holds numbers that are not finite.
pub(super) fn root_path(way: &[TrajectoryKey], clip: &Clip) -> Result<RootTrajectory, Mismatch> {
    let rate = clip.rate_hz();
    let places = (0..clip.frames()).map(|frame| place(way, frame as f32 / rate));
    RootTrajectory::new(rate, places.collect())
}

/// The place at a time, straight between keys.
fn place(way: &[TrajectoryKey], secs: f32) -> RootDelta {
    let step = |k: &TrajectoryKey| RootDelta {
        offset: Vec3::new(k.x_metres, 0.0, k.z_metres),
        yaw_radians: k.yaw_radians,
    };
    let after = way.partition_point(|k| k.secs < secs);
    let next = way.get(after).or(way.last());
    let Some((before, next)) = way.get(after.saturating_sub(1)).zip(next) else {
        return RootDelta::default();
    };
    let (a, b) = (step(before), step(next));
    let span = next.secs - before.secs;
    let t = if span > 0.0 {
        ((secs - before.secs) / span).clamp(0.0, 1.0)
    } else {
        0.0
    };
    RootDelta {
        offset: a.offset.lerp(b.offset, t),
        yaw_radians: a.yaw_radians + (b.yaw_radians - a.yaw_radians) * t,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Tracks;

    #[test]
    fn the_way_is_sampled_at_the_frames() {
        let key = |secs, x_metres| TrajectoryKey {
            secs,
            x_metres,
            z_metres: 0.0,
            yaw_radians: 0.0,
        };
        let way = [key(0.0, 0.0), key(1.0, 2.0)];
        assert_eq!(farthest(&way), 2.0);
        assert_eq!(place(&way, 0.25).offset.x, 0.5);
        assert_eq!(place(&way, 3.0).offset.x, 2.0);
        assert_eq!(place(&[], 1.0), RootDelta::default());
        let clip = Clip::new("walk", 4.0, 5, 1, Tracks::default()).unwrap();
        let path = root_path(&way, &clip).unwrap();
        assert!((path.at(0.75).offset.x - 1.5).abs() < 1e-6);
        // A lap goes on where the last one ended.
        assert!((path.step(0.75, 0.25, 1).offset.x - 1.0).abs() < 1e-6);
    }
}
