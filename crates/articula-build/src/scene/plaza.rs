//! The default scenes: a square of characters seen from its edge, with a fixed or a moving camera.
//!
//! Source: `docs/methods/runtime.md` part 4. The number of characters is free. The moving camera
//! goes straight to the centre and backs out again, so that a lap closes; of each five characters,
//! one drawn by the seed is in a permanent cross-fade.

use super::{ClipPlayback, CrossFade, Scene, SceneCharacter, SceneImportance, SceneView};
use crate::evaluate::CameraKey;
use crate::split_mix::SplitMix;
use articula_core::Viewport;
use glam::Vec3;
use std::f32::consts::TAU;

/// Number of characters of the plaza scene in published measurements: 100 rows of 100.
pub const PLAZA_COUNT: usize = 10_000;

/// Distance between neighbouring characters.
pub(crate) const SPACING_METRES: f32 = 2.0;

/// Height of the camera.
pub(crate) const EYE_METRES: f32 = 1.7;

/// Distance of the camera from the first row.
const OUTSIDE_METRES: f32 = 1.0;

/// Speed of the moving camera.
const DOLLY_METRES_PER_SEC: f32 = 5.0;

/// Changes the seed for the places in the cast.
const CASTING: u64 = 0x6361_7374;

/// One in this many characters is in a cross-fade.
const FADING_ONE_OF: usize = 5;

/// Duration of a cross-fade in one direction.
const FADE_SECS: f32 = 1.0;

/// Variant of the plaza, a benchmark scene: still or moving camera, phases of the clips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Plaza {
    /// Fixed camera, no cross-fades.
    #[default]
    Still,
    /// The camera drives at 5 m/s to the centre and back, and a fifth of the characters is in a
    /// cross-fade of two clips (of two phases of one clip if there is only one).
    Moving,
    /// As `Moving`, with all characters at phase 0 of their clips.
    InPhase,
}

/// Returns the plaza scene: a square of characters 2 m apart, each with its place in the cast, yaw,
/// clip and phase drawn from `seed`. `clips` has the number of clips of each character of the cast; an
/// empty one is a cast of a character without clips. The camera starts between two characters in the middle of the +Z side,
/// 1 m outside the first row and 1.7 m high, and looks level along -Z.
///
/// Rows are ordered from the camera; if `count` is not a square number, the last row is incomplete.
pub fn plaza(count: usize, clips: &[usize], seed: u64, kind: Plaza) -> Scene {
    match kind {
        Plaza::Still => still(count, clips, seed),
        Plaza::Moving | Plaza::InPhase => moving(count, clips, seed, kind == Plaza::InPhase),
    }
}

fn still(count: usize, clips: &[usize], seed: u64) -> Scene {
    let side = side_of(count);
    let mut random = SplitMix(seed);
    // Numbers of their own, so that a larger cast moves nobody.
    let mut casting = SplitMix(seed ^ CASTING);
    let members = (0..count).map(|i| {
        let character = casting.below(clips.len().max(1));
        member(
            i,
            side,
            (character, clips_of(clips, character)),
            &mut random,
        )
    });
    Scene {
        members: members.collect(),
        views: vec![SceneView {
            viewport: Viewport {
                width_px: 1920.0,
                height_px: 1080.0,
                fov_y_radians: std::f32::consts::FRAC_PI_4,
            },
            camera: vec![camera_key(side, 0.0, 0.0)],
            camera_loops: false,
        }],
        importance: SceneImportance::default(),
        walls: Vec::new(),
    }
}

fn moving(count: usize, clips: &[usize], seed: u64, in_phase: bool) -> Scene {
    let mut scene = still(count, clips, seed);
    let mut random = SplitMix(!seed);
    for group in scene.members.chunks_mut(FADING_ONE_OF) {
        let chosen = random.below(FADING_ONE_OF);
        let own = group.get(chosen);
        let character = own.map_or(0, |m| usize::from(m.character));
        let fade = cross_fade(own, clips_of(clips, character), &mut random);
        if let Some(member) = group.get_mut(chosen) {
            member.cross_fade = Some(fade);
        }
    }
    if in_phase {
        for member in &mut scene.members {
            member.play.phase = 0.0;
            if let Some(fade) = &mut member.cross_fade {
                fade.other.phase = 0.0;
                fade.start = 0.0;
            }
        }
    }
    let side = side_of(count);
    let way = half_metres(side) + OUTSIDE_METRES;
    let secs = f64::from(way / DOLLY_METRES_PER_SEC);
    for view in &mut scene.views {
        view.camera = vec![
            camera_key(side, 0.0, 0.0),
            camera_key(side, secs, way),
            camera_key(side, 2.0 * secs, 0.0),
        ];
        view.camera_loops = true;
    }
    scene
}

/// Number of characters in a row of the smallest square that holds `count`.
fn side_of(count: usize) -> usize {
    let root = count.isqrt();
    root + usize::from(root * root < count)
}

/// Distance from the centre to the first row.
fn half_metres(side: usize) -> f32 {
    0.5 * SPACING_METRES * side.saturating_sub(1) as f32
}

/// Number of clips of a character of the cast.
fn clips_of(clips: &[usize], character: usize) -> usize {
    clips.get(character).copied().unwrap_or(0)
}

fn member(
    index: usize,
    side: usize,
    (character, clips): (usize, usize),
    random: &mut SplitMix,
) -> SceneCharacter {
    let (row, column) = (index / side, index % side);
    let half = half_metres(side);
    let x = SPACING_METRES * column as f32 - half;
    let z = half - SPACING_METRES * row as f32;
    SceneCharacter {
        character: character as u16,
        position: Vec3::new(x, 0.0, z),
        yaw_radians: TAU * random.unit(),
        scale: 1.0,
        play: play(random.below(clips), random),
        cross_fade: None,
    }
}

fn play(clip: usize, random: &mut SplitMix) -> ClipPlayback {
    ClipPlayback {
        clip,
        phase: random.unit(),
        speed: 1.0,
    }
}

/// A cross-fade from the character's own clip to another one.
fn cross_fade(member: Option<&SceneCharacter>, clips: usize, random: &mut SplitMix) -> CrossFade {
    let own = member.map_or(0, |m| m.play.clip);
    let further = 1 + random.below(clips.saturating_sub(1));
    CrossFade {
        other: play((own + further) % clips.max(1), random),
        fade_secs: FADE_SECS,
        start: random.unit(),
    }
}

/// Key of the camera after `way_metres` towards the centre.
fn camera_key(side: usize, secs: f64, way_metres: f32) -> CameraKey {
    // With an odd number, the middle character is at 0.
    let x = if side.is_multiple_of(2) {
        0.0
    } else {
        0.5 * SPACING_METRES
    };
    let z = half_metres(side) + OUTSIDE_METRES - way_metres;
    CameraKey {
        secs,
        eye: Vec3::new(x, EYE_METRES, z),
        target: Vec3::new(x, EYE_METRES, z - 1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_published_square_by_hand() {
        let scene = plaza(PLAZA_COUNT, &[4], 1, Plaza::Still);
        let at = |i: usize| scene.members[i].position;
        assert_eq!(at(0), Vec3::new(-99.0, 0.0, 99.0));
        assert_eq!(at(99), Vec3::new(99.0, 0.0, 99.0));
        assert_eq!(at(9_999), Vec3::new(99.0, 0.0, -99.0));
        let camera = scene.camera_at(3.0).unwrap();
        assert_eq!(camera.eye, Vec3::new(0.0, 1.7, 100.0));
        assert!((camera.forward() - Vec3::NEG_Z).length() < 1e-6);
        // The neighbours are 1 m to the left and right, 1 m ahead.
        assert!((camera.view(at(49)) - Vec3::new(-1.0, -1.7, 1.0)).length() < 1e-4);
        assert!((camera.view(at(50)) - Vec3::new(1.0, -1.7, 1.0)).length() < 1e-4);
    }

    /// The three facts of `docs/methods/runtime.md` part 4.
    #[test]
    fn the_view_is_the_one_of_the_specification() {
        let scene = plaza(PLAZA_COUNT, &[4], 7, Plaza::Still);
        let camera = scene.camera_at(0.0).unwrap();
        // A body extends half a metre around its position, at the height of the camera.
        let mut depths: Vec<f32> = scene
            .members
            .iter()
            .map(|m| camera.view(m.position))
            .filter(|p| {
                let half_width = 0.5 * 1920.0 / camera.viewport.pixels_per_metre(p.z);
                p.z > 0.0 && p.x.abs() < half_width + 0.5
            })
            .map(|p| p.z)
            .collect();
        depths.sort_by(f32::total_cmp);
        let visible = depths.len();
        assert!((6_500..6_800).contains(&visible), "{visible} visible");
        let median = depths[visible / 2];
        assert!((125.0..135.0).contains(&median), "median depth {median} m");
        let near = depths.partition_point(|d| *d < 40.0) as f32 / visible as f32;
        assert!((0.04..0.06).contains(&near), "{near} nearer than 40 m");
    }

    #[test]
    fn a_fifth_is_in_a_cross_fade_of_two_clips() {
        let scene = plaza(PLAZA_COUNT, &[3], 5, Plaza::Moving);
        let fades: Vec<_> = scene
            .members
            .iter()
            .filter_map(|m| Some((m.play.clip, m.cross_fade?.other.clip)))
            .collect();
        assert_eq!(fades.len(), PLAZA_COUNT / 5);
        assert!(fades.iter().all(|(own, other)| own != other && *other < 3));
        let still = plaza(PLAZA_COUNT, &[3], 5, Plaza::Still);
        let same = |(a, b): (&SceneCharacter, &SceneCharacter)| {
            a.play == b.play && a.position == b.position
        };
        assert!(scene.members.iter().zip(&still.members).all(same));
    }

    #[test]
    fn a_larger_cast_changes_characters_and_clips_alone() {
        let clips = [3, 0, 5];
        let cast = plaza(900, &clips, 5, Plaza::Moving);
        let one = plaza(900, &[3], 5, Plaza::Moving);
        let mut of_each = [0; 3];
        for (m, alone) in cast.members.iter().zip(&one.members) {
            let character = usize::from(m.character);
            of_each[character] += 1;
            assert_eq!(
                (m.position, m.yaw_radians),
                (alone.position, alone.yaw_radians)
            );
            assert!(m.play.clip < clips[character].max(1));
            let other = m.cross_fade.map_or(0, |f| f.other.clip);
            assert!(other < clips[character].max(1));
        }
        // 300 each, with a standard deviation of 14.
        assert!(
            of_each.iter().all(|n| (240..360).contains(n)),
            "{of_each:?}"
        );
        assert!(one.members.iter().all(|m| m.character == 0));
    }

    #[test]
    fn equal_phases_are_equal() {
        let scene = plaza(100, &[3], 5, Plaza::InPhase);
        assert!(scene.members.iter().all(|m| m.play.phase == 0.0));
        let fades = scene.members.iter().filter_map(|m| m.cross_fade);
        assert!(
            fades
                .clone()
                .all(|f| f.other.phase == 0.0 && f.start == 0.0)
        );
        assert_eq!(fades.count(), 20);
    }

    #[test]
    fn the_dolly_drives_in_and_out_in_a_lap() {
        let scene = plaza(PLAZA_COUNT, &[1], 1, Plaza::Moving);
        assert!((scene.loop_secs() - 40.0).abs() < 1e-6, "200 m at 5 m/s");
        let eye = |secs| scene.camera_at(secs).unwrap().eye;
        assert!((eye(10.0) - Vec3::new(0.0, 1.7, 50.0)).length() < 1e-3);
        assert!((eye(20.0) - Vec3::new(0.0, 1.7, 0.0)).length() < 1e-3);
        assert!((eye(35.0) - Vec3::new(0.0, 1.7, 75.0)).length() < 1e-3);
        assert!((eye(41.0) - eye(1.0)).length() < 1e-3, "the lap closes");
        let step = |i: i32| eye(f64::from(i + 1) / 60.0) - eye(f64::from(i) / 60.0);
        let fastest = (0..2400).map(|i| step(i).length() * 60.0);
        assert!(fastest.fold(0.0, f32::max) < 5.01);
    }

    proptest! {
        #[test]
        fn any_number_stands_in_a_square(count in 0usize..600, clips in 0usize..5, seed in any::<u64>()) {
            let scene = plaza(count, &[clips], seed, Plaza::Moving);
            prop_assert_eq!(scene.members.len(), count);
            prop_assert_eq!(&scene, &plaza(count, &[clips], seed, Plaza::Moving));
            let half = half_metres(side_of(count)) + 1e-3;
            for (i, m) in scene.members.iter().enumerate() {
                prop_assert!(m.position.x.abs() <= half && m.position.z.abs() <= half);
                prop_assert!((0.0..TAU).contains(&m.yaw_radians));
                prop_assert!((0.0..1.0).contains(&m.play.phase));
                prop_assert!(m.play.clip < clips.max(1));
                let fade = m.cross_fade.map_or(0, |f| f.other.clip);
                prop_assert!(fade < clips.max(1));
                let others = &scene.members[..i];
                let apart = others.iter().all(|o| o.position.distance(m.position) > 1.99);
                prop_assert!(apart);
            }
            // The camera does not drive through any character.
            for secs in 0..20 {
                let eye = scene.camera_at(f64::from(secs)).unwrap().eye.with_y(0.0);
                prop_assert!(scene.members.iter().all(|m| m.position.distance(eye) > 0.99));
            }
        }
    }
}
