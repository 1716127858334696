//! Morph target weights of a crowd: those of each character's own clips and times, for the levels
//! that show them, the same for any division into ranges, without allocation.

use crate::crowd::{Square, camera, fixed_figure, model, parts, with_cache};
use crate::crowd_steps::with_steps;
use articula_core::crowd::{
    CacheUse, CharacterState, ClipState, Crowd, CrowdModel, DrawKind, DrawList, Frame, MorphClips,
};
use articula_core::visibility::View;
use articula_core::{Clip, Track, Tracks, Wrap, sample_morphs};

/// Default weights of the mesh's targets; the third one never moves.
pub(crate) const REST: [f32; 4] = [0.0, 0.125, 0.75, 0.5];

/// The clips with morph tracks: an interpolated and a held one in the first, a constant one and one
/// of a target that the mesh does not have in the second.
pub(crate) fn with_morphs(clips: &[Clip]) -> Vec<Clip> {
    let with = |(c, clip): (usize, &Clip)| {
        let wave = |f: usize| (f as f32 * 0.7 + c as f32).sin();
        let values: Vec<f32> = (0..clip.frames()).map(wave).collect();
        let track = |target, step, values: &[f32]| Track {
            target,
            step,
            values: values.to_vec(),
        };
        let morphs = match c {
            0 => vec![track(3, true, &values), track(0, false, &values)],
            _ => vec![
                track(1, false, &[0.25]),
                track(0, false, &values),
                track(9, false, &[1.0]),
            ],
        };
        let tracks = Tracks {
            morphs,
            ..clip.tracks().clone()
        };
        let (rate_hz, frames) = (clip.rate_hz(), clip.frames());
        Clip::new(clip.name.clone(), rate_hz, frames, clip.joints(), tracks).unwrap()
    };
    clips.iter().enumerate().map(with).collect()
}

/// A crowd's model whose first levels show morph targets, with a pose cache, and its clips.
fn animated(levels: usize) -> (CrowdModel, Vec<Clip>) {
    let (rig, clips, sets) = fixed_figure();
    let clips = with_morphs(&clips);
    let cached = with_steps(with_cache(model(&rig, &clips, &sets)));
    let mut parts = parts(&rig, &clips, &sets);
    parts.cache.clone_from(&cached.parts().cache);
    parts.morphs = Some(MorphClips::new(&clips, &REST, levels).unwrap());
    (CrowdModel::new(parts).unwrap(), clips)
}

/// Ticks a crowd in which some characters fade, play backwards or stand at the end of their clip.
fn played(model: &CrowdModel, square: &Square, cache: CacheUse) -> Crowd {
    let clips = &model.parts().clips;
    let mut crowd = Crowd::new(model, square.positions.len());
    for i in 0..square.positions.len() {
        let state = ClipState::new(clips, i % 2)
            .at_secs(clips, i as f32 * 0.037)
            .at_speed([1.0, 0.5, -1.0, 2.0][i % 4]);
        crowd.play(i, if i % 7 == 0 { state.once() } else { state }.into());
        if i % 5 == 0 {
            let other = ClipState::new(clips, (i + 1) % 2);
            crowd.play(i, CharacterState::fading(state, other, 0.25, 10.0));
        }
    }
    for _ in 0..9 {
        let views = [View::of(&camera())];
        let frame = Frame {
            cache,
            ..square.frame(&views, 2.0)
        };
        crowd.tick(model, &frame, &mut |_| {});
    }
    crowd
}

pub(crate) fn weights(crowd: &Crowd, model: &CrowdModel) -> Vec<f32> {
    let sets = crowd.draw_list().morph_sets();
    let mut out = vec![f32::NAN; sets * REST.len()];
    crowd.evaluate_morphs(model, 0..sets, &mut out);
    out
}

/// Character and level of each set, as a renderer finds them.
pub(crate) fn owners(list: &DrawList) -> Vec<(usize, usize)> {
    let of_kind = |kind| {
        let all = list.groups_of(kind).flat_map(move |group| {
            let characters = &list.characters(kind)[group.range.clone()];
            characters.iter().map(|c| (*c as usize, group.level))
        });
        all.take(list.with_morphs(kind))
    };
    DrawKind::ALL.into_iter().flat_map(of_kind).collect()
}

/// Weights by the plain sampler, each clip over the defaults, then blended.
pub(crate) fn by_hand(state: &CharacterState, clips: &[Clip]) -> Vec<f32> {
    later_by_hand(state, clips, 0.0)
}

/// The same a little later.
fn later_by_hand(state: &CharacterState, clips: &[Clip], later_secs: f64) -> Vec<f32> {
    let one = |state: &ClipState| {
        let mut out = REST.to_vec();
        let secs = f64::from(state.secs()) + later_secs;
        sample_morphs(&clips[state.clip()], secs, Wrap::Clamp, &mut out);
        out
    };
    let mut out = one(state.clip_state());
    if let Some(next) = state.next() {
        let to = one(next);
        for (weight, to) in out.iter_mut().zip(to) {
            *weight += (to - *weight) * state.fade();
        }
    }
    out
}

#[test]
fn every_face_shows_its_own_clips_and_times() {
    let square = Square::new(240);
    let (mut posed, mut recorded, mut stepped, mut faded) = (0, 0, 0, 0);
    // Where coarser levels without faces are cheaper, nobody steps at one with a face.
    let all = fixed_figure().2.len() + 1;
    for levels in [1, 2, all] {
        let (model, clips) = animated(levels);
        for cache in [CacheUse::Never, CacheUse::Cpu, CacheUse::Gpu] {
            let crowd = played(&model, &square, cache);
            let list = crowd.draw_list();
            let owners = owners(list);
            let visible = (0..240).filter_map(|c| Some((c, crowd.level(c)?)));
            let near = visible.filter(|(_, level)| *level < levels).count();
            assert_eq!((owners.len(), list.morph_sets()), (near, near));
            assert!(near > 10, "{near} of 240 at the first {levels} levels");
            let found = weights(&crowd, &model);
            let sets = found.chunks_exact(REST.len());
            for ((character, level), found) in owners.into_iter().zip(sets) {
                assert_eq!(crowd.level(character), Some(level));
                let state = crowd.state(character);
                // At a frame, such as the last one, rounding decides about a weight that is held.
                let expected = [0.0, 1e-6].map(|later| later_by_hand(&state, &clips, later));
                let near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-5;
                let is_near = |expected: &Vec<f32>| found.iter().zip(expected).all(near);
                assert!(
                    expected.iter().any(is_near),
                    "character {character}: {found:?} instead of {expected:?}"
                );
                faded += usize::from(state.next().is_some());
            }
            posed += list.with_morphs(DrawKind::Palette);
            recorded += list.with_morphs(DrawKind::Record);
            stepped += list.with_morphs(DrawKind::Step);
        }
    }
    assert!(posed > 0 && recorded > 0 && stepped > 0 && faded > 0);
}

#[test]
fn ranges_of_sets_give_the_same_bits_in_any_order() {
    let (model, _) = animated(2);
    let crowd = played(&model, &Square::new(240), CacheUse::Gpu);
    let whole = weights(&crowd, &model);
    let sets = crowd.draw_list().morph_sets();
    for step in [1, 7, 1000] {
        let mut out = vec![f32::NAN; whole.len()];
        let firsts: Vec<usize> = (0..sets).step_by(step).collect();
        for first in firsts.into_iter().rev() {
            let range = first..(first + step).min(sets);
            let part = range.start * REST.len()..range.end * REST.len();
            crowd.evaluate_morphs(&model, range, &mut out[part]);
        }
        assert_eq!(out, whole);
    }
}

/// Tracks of a clip with one that holds a target at its default weight.
fn with_rest_tracks(clip: &Clip) -> Tracks {
    let held = Track {
        target: 2,
        step: false,
        values: vec![REST[2]],
    };
    Tracks {
        morphs: vec![held],
        ..clip.tracks().clone()
    }
}

#[test]
fn nothing_is_written_where_no_face_moves() {
    let (rig, clips, sets) = fixed_figure();
    let square = Square::new(60);
    let mut resting = clips.clone();
    for clip in &mut resting {
        let tracks = with_rest_tracks(clip);
        *clip = Clip::new(
            "rests",
            clip.rate_hz(),
            clip.frames(),
            clip.joints(),
            tracks,
        )
        .unwrap();
    }
    for clips in [&clips, &resting] {
        let still = MorphClips::new(clips, &REST, 4).unwrap();
        assert_eq!((still.levels(), still.bytes()), (0, 0));
    }
    let still = MorphClips::new(&resting, &REST, 4).unwrap();
    let moving = MorphClips::new(&with_morphs(&clips), &REST, 0).unwrap();
    for morphs in [None, Some(still), Some(moving)] {
        let mut parts = parts(&rig, &clips, &sets);
        parts.morphs = morphs;
        let model = CrowdModel::new(parts).unwrap();
        let crowd = played(&model, &square, CacheUse::Never);
        assert!(!crowd.draw_list().draws.is_empty());
        assert!(weights(&crowd, &model).is_empty());
    }
    let mut few = parts(&rig, &clips, &sets);
    few.morphs = Some(MorphClips::new(&clips[..1], &REST, 1).unwrap());
    assert_eq!(CrowdModel::new(few).unwrap_err().at, "morphs");
    let track = |values: &[f32]| Tracks {
        morphs: vec![Track {
            target: 0,
            step: false,
            values: values.to_vec(),
        }],
        ..Tracks::default()
    };
    let bad = Clip::new("c", 30.0, 2, 1, track(&[0.0, f32::NAN])).unwrap();
    assert_eq!(MorphClips::new(&[bad], &REST, 1).unwrap_err().at, "clips");
}

#[test]
fn writing_weights_allocates_nothing() {
    let (model, _) = animated(2);
    let square = Square::new(120);
    let mut crowd = played(&model, &square, CacheUse::Gpu);
    let camera = camera();
    let mut out = vec![0.0; 120 * REST.len()];
    let mut written = 0;
    let counted = allocation_counter::measure(|| {
        for i in 0..60 {
            let views = [View::of(&camera)];
            let frame = Frame {
                cache: CacheUse::Gpu,
                ..square.frame(&views, 0.1 * i as f32)
            };
            crowd.tick(&model, &frame, &mut |_| {});
            let sets = crowd.draw_list().morph_sets();
            crowd.evaluate_morphs(&model, 0..sets, &mut out[..sets * REST.len()]);
            written += sets;
        }
    });
    assert_eq!(counted.count_total, 0);
    assert!(written > 1000);
}
