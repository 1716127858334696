//! Sections of a crowd on any threads, and clocks that advance eight at a time, against the plain
//! way: one section after the other, and one character after the other.

use crate::crowd::{fixed_figure, palettes, parts, records, with_cache};
use articula_core::crowd::{
    CacheUse, CharacterState, ClipEvent, ClipState, Crowd, CrowdEvent, CrowdModel, CrowdReport,
    CrowdSection, Culling, Frame, Moved, RootDelta, RootTrajectory,
};
use articula_core::visibility::View;
use articula_core::{Camera, Clip, Tracks, Viewport};
use glam::{Quat, Vec3};
use proptest::prelude::*;

/// A model with events in all clips and root motion in the second; two move, and others are single poses.
fn eventful(poses: usize) -> CrowdModel {
    let (rig, mut clips, sets) = fixed_figure();
    clips.truncate(2);
    let pose = Clip::new("pose", 30.0, 1, rig.len(), Tracks::default()).unwrap();
    clips.extend(std::iter::repeat_n(pose, poses));
    let mut parts = parts(&rig, &clips, &sets);
    let event = |part: f32| ClipEvent {
        secs: clips[0].duration_secs().min(clips[1].duration_secs()) * part,
        id: (100.0 * part) as u32,
    };
    parts.events = vec![vec![event(0.5)], vec![event(0.0), event(0.75)]];
    parts.events.resize(clips.len(), vec![event(0.0)]);
    let ahead = RootDelta {
        offset: Vec3::Z,
        yaw_radians: 0.1,
    };
    let rate_hz = 1.0 / clips[1].duration_secs();
    let path = RootTrajectory::new(rate_hz, vec![RootDelta::default(), ahead]).unwrap();
    parts.paths = vec![None, Some(path)];
    parts.paths.resize(clips.len(), None);
    CrowdModel::new(parts).unwrap()
}

fn clip_state(model: &CrowdModel) -> impl Strategy<Value = ClipState> + use<> {
    let model = model.clone();
    let speed = prop_oneof![Just(0.0f32), Just(-0.0f32), -3.0f32..3.0];
    (0usize..3, 0.0f32..1.0, speed, any::<bool>()).prop_map(move |(clip, at, speed, once)| {
        let state = ClipState::new(&model, clip).at_speed(speed);
        let state = state.at_secs(&model, at * 3.0);
        if once { state.once() } else { state }
    })
}

fn character_state(model: &CrowdModel) -> impl Strategy<Value = CharacterState> + use<> {
    let (from, to) = (clip_state(model), clip_state(model));
    (from, to, 0u8..4, 0.0f32..1.5).prop_map(|(from, to, kind, amount)| match kind {
        0 => from.into(),
        1 => CharacterState::blend(from, to, amount),
        2 => CharacterState::fading(from, to, amount - 0.5, 0.4),
        _ => CharacterState::fading(from, to, 0.0, amount),
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A state that was just set is advanced one by one, so a crowd in which all are set again in
    /// every frame is the plain way.
    #[test]
    fn clocks_are_those_of_one_character_after_the_other(
        states in prop::collection::vec(character_state(&eventful(1)), 1..20),
        steps in prop::collection::vec(prop_oneof![Just(0.0f32), 0.0f32..0.2, Just(1.0 / 60.0)], 1..60),
    ) {
        let model = eventful(1);
        let count = states.len();
        let mut crowds = [Crowd::new(&model, count), Crowd::new(&model, count)];
        for crowd in &mut crowds {
            for (character, state) in states.iter().enumerate() {
                crowd.play(character, *state);
            }
        }
        let (positions, rotations) = (vec![Vec3::ZERO; count], vec![Quat::IDENTITY; count]);
        let [fast, plain] = &mut crowds;
        for dt_secs in steps {
            for character in 0..count {
                plain.play(character, plain.state(character));
            }
            let frame = Frame {
                dt_secs,
                culling: Culling::Off,
                ..still(&positions, &rotations)
            };
            let mut told = [Vec::new(), Vec::new()];
            for (crowd, told) in [&mut *fast, &mut *plain].into_iter().zip(&mut told) {
                crowd.tick(&model, &frame, &mut |event| {
                    if matches!(event, CrowdEvent::Clip { .. }) {
                        told.push(event);
                    }
                });
            }
            prop_assert_eq!(&told[0], &told[1]);
            for character in 0..count {
                prop_assert_eq!(fast.state(character), plain.state(character));
                prop_assert_eq!(fast.root_delta(&model, character), plain.root_delta(&model, character));
            }
        }
    }
}

fn still<'a>(positions: &'a [Vec3], rotations: &'a [Quat]) -> Frame<'a> {
    Frame {
        dt_secs: 1.0 / 60.0,
        positions,
        rotations,
        cache: CacheUse::Gpu,
        ..Frame::default()
    }
}

/// One way to run the sections.
type Run = fn(&mut [CrowdSection], &(dyn Fn(&mut CrowdSection) + Sync));

/// From the last to the second, on two threads; the first is left out.
fn on_threads(sections: &mut [CrowdSection], tick: &(dyn Fn(&mut CrowdSection) + Sync)) {
    let (left, right) = sections[1..].split_at_mut(1);
    std::thread::scope(|threads| {
        threads.spawn(|| right.iter_mut().rev().for_each(tick));
        left.iter_mut().for_each(tick);
    });
}

/// Ten frames of 3,500 characters in four sections, some of whom walk, fade and matter more, seen
/// by a camera that turns; everything that is told and shown.
fn played(cache: CacheUse, run: Option<Run>) -> Vec<(CrowdReport, Vec<CrowdEvent>, Vec<u8>)> {
    const COUNT: usize = 3500;
    let model = with_cache(eventful(0));
    let mut crowd = Crowd::new(&model, COUNT);
    for character in 0..COUNT {
        let state = ClipState::new(&model, character % 2);
        crowd.play(
            character,
            state.at_secs(&model, 0.013 * character as f32).into(),
        );
    }
    let mut positions: Vec<Vec3> = (0..COUNT)
        .map(|i| Vec3::new((i % 50) as f32 - 25.0, -1.0, -1.0 - (i / 50) as f32))
        .collect();
    let rotations = vec![Quat::IDENTITY; COUNT];
    let importance: Vec<f32> = (0..COUNT).map(|i| 0.5 + (i % 5) as f32).collect();
    let mut frames = Vec::new();
    for i in 0..10 {
        let moved: Vec<u32> = (0..40)
            .map(|m| ((m * 97 + i * 1033) % COUNT) as u32)
            .collect();
        for character in &moved {
            positions[*character as usize] += Vec3::new(0.5, 0.0, -4.0);
            crowd.fade_to(*character as usize, ClipState::new(&model, 1), 0.05);
        }
        let camera = Camera {
            orientation: Quat::from_rotation_y(0.3 * i as f32),
            ..Camera::looking_at(Vec3::ZERO, Vec3::NEG_Z, Viewport::default())
        };
        // The last ones stand behind a wall.
        let hidden: Vec<f32> = (0..COUNT)
            .map(|c| if c > 3000 { 1.0 } else { 0.0 })
            .collect();
        let views = [View::of(&camera).with_occluded(&hidden)];
        let frame = Frame {
            moved: Moved::These(&moved),
            importance: if i < 5 { &[] } else { &importance },
            culling: Culling::Views(&views),
            cache,
            ..still(&positions, &rotations)
        };
        let mut events = Vec::new();
        let tell = &mut |event| events.push(event);
        let report = match run {
            Some(run) => crowd.tick_on(&model, &frame, tell, run),
            None => crowd.tick(&model, &frame, tell),
        };
        let rows = palettes(&crowd, &model).into_iter().flatten();
        let mut bytes: Vec<u8> = rows.flat_map(f32::to_le_bytes).collect();
        let draws = crowd.draw_list().draws.iter();
        bytes.extend(draws.flat_map(|d| d.character.to_le_bytes()));
        let records = records(&crowd, &model).into_iter();
        bytes.extend(records.flat_map(|r| {
            r.character
                .to_le_bytes()
                .into_iter()
                .chain(r.blend.to_le_bytes())
        }));
        frames.push((report, events, bytes));
    }
    frames
}

#[test]
fn sections_on_threads_give_the_same_frames() {
    for cache in [CacheUse::Gpu, CacheUse::Never] {
        let plain = played(cache, None);
        assert!(plain.iter().any(|f| f.0.visible > 500 && !f.1.is_empty()));
        // Nothing is run, all on threads.
        let runs: [Run; 2] = [|_, _| {}, on_threads];
        for run in runs {
            assert_eq!(played(cache, Some(run)), plain);
        }
    }
}
