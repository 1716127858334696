//! Removes root motion from clips and keeps it apart.
//!
//! A scene fixes where each character stands, so a walk with root motion would leave its position
//! and jump back at the end of each cycle. Clips that stay within [`ROOM_METRES`] of their start
//! are left alone: the sway and steps of a dance belong to it.

use articula_build::clip_edit::EditSubject;
use articula_build::clip_edit::{
    RootMotionMode, RootMotionOptions, TrajectoryKey, split_root_motion,
};
use articula_core::Libm;
use articula_core::crowd::{RootDelta, RootTrajectory};
use articula_core::source::Character;
use articula_core::{Articulation, Clip, Mismatch};
use glam::Vec3;

/// Maximum distance that a clip may move its character from the first frame: half the distance
/// between neighbours in the plaza scene.
const ROOM_METRES: f32 = 1.0;

/// Window of the moving average that defines root motion, so that hip sway stays in the clip.
const SMOOTH_SECS: f32 = 1.0;

/// Puts clips with root motion in place; returns the root motion of each such clip, relative to its
/// start, and warnings about clips that travel but could not be changed. `end_sites` as in
/// [`EditSubject::new`].
pub fn put_in_place(
    character: &mut Character,
    articulation: Articulation,
    end_sites: &[(usize, Vec3)],
) -> (Vec<Option<Vec<TrajectoryKey>>>, Vec<String>) {
    let mut clips = std::mem::take(&mut character.clips);
    let subject = EditSubject::new(character, articulation, end_sites);
    let mut warnings = Vec::new();
    let mut ways = vec![None; clips.len()];
    // Clips of a character that cannot be split into root and body stay unchanged.
    if let Ok(subject) = subject {
        for (clip, way) in clips.iter_mut().zip(&mut ways) {
            let told = split_root_motion(&subject, clip, &RootMotionOptions::default());
            if !told.is_ok_and(|t| farthest(&t.trajectory) > ROOM_METRES) {
                continue;
            }
            let opts = RootMotionOptions {
                mode: RootMotionMode::InPlace,
                smooth_secs: SMOOTH_SECS,
                is_unmeasured: true,
            };
            match split_root_motion(&subject, clip, &opts) {
                Ok(out) => {
                    *clip = out.clip;
                    *way = Some(out.trajectory);
                }
                Err(e) => warnings.push(format!(
                    "the root motion of clip \"{}\" is not extracted: {e}",
                    clip.name
                )),
            }
        }
    }
    character.clips = clips;
    (ways, warnings)
}

fn farthest(way: &[TrajectoryKey]) -> f32 {
    let off = way.iter().map(|k| k.x_metres.libm_hypot(k.z_metres));
    off.fold(0.0, f32::max)
}

/// Samples root motion at the frames of a clip.
///
/// # Errors
/// A [`Mismatch`] if a value is not finite.
pub(super) fn root_path(way: &[TrajectoryKey], clip: &Clip) -> Result<RootTrajectory, Mismatch> {
    let rate = clip.rate_hz();
    let places = (0..clip.frames()).map(|frame| place(way, frame as f32 / rate));
    RootTrajectory::new(rate, places.collect())
}

/// Root displacement at a time, interpolated linearly.
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
        // A cycle continues where the previous one ended.
        assert!((path.step(0.75, 0.25, 1).offset.x - 1.0).abs() < 1e-6);
    }
}
