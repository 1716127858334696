//! Morph levels of a crowd's faces: which targets each character shows, what it is told when they
//! change, and that neither threads nor ranges change a bit.

use crate::crowd::{Square, camera, fixed_figure, model, parts, with_cache};
use crate::crowd_morphs::{REST, by_hand, owners, weights, with_morphs};
use crate::crowd_steps::{STEP_METRES, steps, with_steps};
use articula_core::crowd::{
    CacheUse, CharacterState, ClipState, Crowd, CrowdEvent, CrowdModel, Detail, DrawKind, Frame,
    MorphClips, MorphLods,
};
use articula_core::visibility::View;
use articula_core::{BlendRecord, Clip};
use glam::{Quat, Vec3};

/// The targets that move, those first that are shown longest.
const ORDER: [u16; 3] = [3, 0, 1];
/// Targets of each morph level, and its error in both clips, metres.
const COUNTS: [u16; 3] = [3, 1, 0];
const ERRORS: [[f32; 3]; 2] = [[0.0, 0.004, 0.006], [0.0, 0.0, 0.009]];

fn lods(scale: f32) -> MorphLods {
    let errors = ERRORS.map(|e| e.map(|metres| scale * metres).to_vec());
    MorphLods::new(ORDER.to_vec(), COUNTS.to_vec(), &errors).unwrap()
}

/// A crowd's model of which the finest levels show morph targets, with a pose cache.
fn animated(levels: usize) -> (CrowdModel, Vec<Clip>) {
    animated_by(levels, 1.0)
}

/// The same with so many times the errors of faces.
fn animated_by(levels: usize, scale: f32) -> (CrowdModel, Vec<Clip>) {
    let (rig, clips, sets) = fixed_figure();
    let clips = with_morphs(&clips);
    let cached = with_steps(with_cache(model(&rig, &clips, &sets)));
    let mut parts = parts(&rig, &clips, &sets);
    parts.cache.clone_from(&cached.parts().cache);
    parts.morphs = Some(MorphClips::with_lods(&clips, &REST, levels, lods(scale)).unwrap());
    (CrowdModel::new(parts).unwrap(), clips)
}

/// Characters one behind the other, so that each needs less than the one before it.
fn row(count: usize) -> Square {
    Square {
        positions: (0..count)
            .map(|i| Vec3::new(0.0, -1.0, -4.0 - 0.1 * i as f32))
            .collect(),
        rotations: vec![Quat::IDENTITY; count],
    }
}

/// Ticks a crowd of which every fifth character fades.
fn played(model: &CrowdModel, places: &Square, (px, cache): (f32, CacheUse)) -> Crowd {
    let clips = &model.parts().clips;
    let mut crowd = Crowd::new(model, places.positions.len());
    for i in 0..places.positions.len() {
        let state = ClipState::new(clips, i % 2).at_secs(clips, i as f32 * 0.037);
        crowd.play(i, state.into());
        if i % 5 == 0 {
            let other = ClipState::new(clips, (i + 1) % 2);
            crowd.play(i, CharacterState::fading(state, other, 0.25, 10.0));
        }
    }
    for _ in 0..3 {
        let views = [View::of(&camera())];
        let frame = Frame {
            cache,
            ..places.frame(&views, px)
        };
        crowd.tick(model, &frame, &mut |_| {});
    }
    crowd
}

#[test]
fn every_face_shows_the_targets_of_its_morph_level() {
    let places = row(400);
    for levels in [1, 2] {
        let (model, clips) = animated(levels);
        for cache in [CacheUse::Never, CacheUse::Cpu, CacheUse::Gpu] {
            let crowd = played(&model, &places, (1.0, cache));
            let list = crowd.draw_list();
            let owners = owners(list);
            let mut seen = [0; COUNTS.len()];
            let found = weights(&crowd, &model);
            let sets = found.chunks_exact(REST.len());
            assert_eq!(owners.len(), sets.len());
            for ((character, level), found) in owners.iter().zip(sets) {
                let state = crowd.state(*character);
                let morph_level = crowd.morph_level(&model, *character);
                assert_eq!(morph_level.is_some(), *level < levels);
                let shown = morph_level.unwrap_or(COUNTS.len() - 1);
                if state.next().is_some() {
                    assert_eq!(shown, 0, "a face that fades shows all");
                }
                seen[shown] += 1;
                let mut expected = by_hand(&state, &clips);
                for target in &ORDER[usize::from(COUNTS[shown])..] {
                    expected[usize::from(*target)] = REST[usize::from(*target)];
                }
                let near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-5;
                assert!(found.iter().zip(&expected).all(near), "{character}");
            }
            // Whoever shows a target has a set.
            for character in 0..400 {
                let shown = crowd.morph_level(&model, character);
                let shows = shown.is_some_and(|level| COUNTS[level] > 0);
                assert!(!shows || owners.iter().any(|o| o.0 == character));
            }
            let (shown, all) = (seen[0] + seen[1], owners.len());
            assert!(seen[0] > 10 && seen[1] > 2 && shown <= all && all < 400);
            if levels == 1 {
                assert_eq!(shown, all, "those at rest come last in their level");
            }
        }
    }
}

/// By the plain rule: of all levels with all morph levels the cheapest within the tolerance.
#[test]
fn options_have_the_errors_of_level_and_face_together() {
    let (model, _) = animated(2);
    let places = row(300);
    let (px, views) = (1.0, [View::of(&camera())]);
    let mut crowd = Crowd::new(&model, 300);
    let clips = &model.parts().clips;
    for i in 0..300 {
        crowd.play(i, ClipState::new(clips, i % 2).into());
    }
    let report = crowd.tick(&model, &places.frame(&views, px), &mut |_| {});
    assert!(report.bound_px <= px * 1.0001);
    let mut least = [[0.0_f32; 2]; 3];
    for i in 0..300 {
        let level = crowd.level(i).unwrap();
        let metres = px / crowd.cull_result(i).pixels_per_metre;
        let face = crowd.morph_level(&model, i);
        let error = model.error_metres(i % 2, i % 2, level)
            + face.map_or(0.0, |face| model.morph_error_metres(i % 2, i % 2, face));
        assert!(error <= metres * 1.0001, "character {i}");
        if let Some(face) = face {
            least[face][i % 2] = least[face][i % 2].max(metres);
        }
    }
    // In the second clip the single target costs nothing, so nobody shows all.
    assert!(least[0][0] > 0.0 && least[0][1] == 0.0, "{least:?}");
    assert!(least[1][1] > 0.0);
}

#[test]
fn a_change_of_the_face_alone_is_told_with_its_jump() {
    let (model, _) = animated(1);
    let mut parts = model.parts().clone();
    // Levels that nobody would choose.
    for clip in &mut parts.errors.clips {
        for level in 1..clip.levels_metres.len() {
            clip.levels_metres[level] = 100.0 + level as f32;
            clip.worst_metres[level] = 100.0 + level as f32;
        }
    }
    parts.cache = None;
    let model = CrowdModel::new(parts).unwrap();
    let mut crowd = Crowd::new(&model, 1);
    let mut told = Vec::new();
    let mut spans = Vec::new();
    let camera = camera();
    for depth in [2.0, 3.0, 30.0, 30.0, 2.0] {
        let places = Square {
            positions: vec![Vec3::new(0.0, -1.0, -depth)],
            rotations: vec![Quat::IDENTITY],
        };
        let views = [View::of(&camera)];
        let frame = Frame {
            dt_secs: 0.0,
            ..places.frame(&views, 0.5)
        };
        crowd.tick(&model, &frame, &mut |event| {
            if let CrowdEvent::Level {
                from, to, jump_px, ..
            } = event
            {
                told.push((from, to, jump_px));
            }
        });
        spans.push(crowd.cull_result(0).pixels_per_metre);
    }
    assert_eq!(crowd.morph_level(&model, 0), Some(0));
    let jump = |span: f32| 0.006 * span;
    let expected = [
        (None, Some(0), 0.0),
        (Some(0), Some(0), jump(spans[2])),
        (Some(0), Some(0), jump(spans[4])),
    ];
    assert_eq!(told.len(), expected.len(), "{told:?}");
    for (told, expected) in told.iter().zip(expected) {
        assert_eq!((told.0, told.1), (expected.0, expected.1));
        assert!((told.2 - expected.2).abs() < 1e-3, "{told:?} {expected:?}");
    }
    // All characters at a fixed level show all of their faces.
    let places = row(1);
    let views = [View::of(&camera)];
    let frame = Frame {
        detail: Detail::Level(0),
        ..places.frame(&views, 0.0)
    };
    crowd.tick(&model, &frame, &mut |_| {});
    assert_eq!(crowd.morph_level(&model, 0), Some(0));
    assert_eq!(crowd.draw_list().morph_sets(), 1);
}

#[test]
fn a_jump_counts_body_source_and_face() {
    let levels = fixed_figure().2.len() + 1;
    let (model, _) = animated(levels);
    assert_eq!(model.parts().clips.joint_lods().levels(), levels);
    let camera = camera();
    let views = [View::of(&camera)];
    let places = Square {
        positions: vec![Vec3::new(0.0, -1.0, -40.0)],
        rotations: vec![Quat::IDENTITY],
    };
    let mut crowd = Crowd::new(&model, 1);
    let mut told = Vec::new();
    for px in [0.0, 50.0, 0.0] {
        let frame = Frame {
            cache: CacheUse::Cpu,
            dt_secs: 0.0,
            ..places.frame(&views, px)
        };
        crowd.tick(&model, &frame, &mut |event| {
            if let CrowdEvent::Level { jump_px, .. } = event {
                told.push(jump_px);
            }
        });
        if px > 0.0 {
            let list = crowd.draw_list();
            assert_eq!(
                (list.characters(DrawKind::Step).len(), list.morph_sets()),
                (1, 0)
            );
        }
    }
    let span = crowd.cull_result(0).pixels_per_metre;
    let body = model.error_metres(0, 0, levels - 1);
    let jump_px = (body + STEP_METRES + 0.006) * span;
    assert!(body > 0.0 && told.len() == 3 && told[0] == 0.0);
    for px in &told[1..] {
        assert!((px / jump_px - 1.0).abs() < 1e-4, "{told:?}, {jump_px}");
    }
}

/// Tolerance of a frame.
fn tolerance_px(frame: usize) -> f32 {
    0.25 + 0.25 * (frame % 8) as f32
}

/// Rows of 50, near and far ones in every section.
fn rows() -> Square {
    let count = 2500;
    let place = |i: usize| {
        Vec3::new(
            (i % 50) as f32 - 25.0,
            -1.0,
            -2.0 - (i / 50 * 7 % 50) as f32,
        )
    };
    Square {
        positions: (0..count).map(place).collect(),
        rotations: vec![Quat::IDENTITY; count],
    }
}

#[test]
fn threads_and_ranges_change_no_bit() {
    let (model, _) = animated(2);
    // Faces that are worth a set of weights where the body is shown by a step.
    let (of_steps, _) = animated_by(fixed_figure().2.len() + 1, 10.0);
    let (places, camera) = (rows(), camera());
    let bytes = |is_threaded: bool, (model, cache): (&CrowdModel, CacheUse)| {
        let mut crowd = played(model, &places, (1.0, cache));
        let mut all = Vec::new();
        for i in 0..8 {
            let views = [View::of(&camera)];
            let frame = Frame {
                cache,
                ..places.frame(&views, tolerance_px(i))
            };
            let mut events = Vec::new();
            let tell = &mut |event| events.push(event);
            if is_threaded {
                crowd.tick_on(model, &frame, tell, |sections, tick| {
                    std::thread::scope(|threads| {
                        for section in sections {
                            threads.spawn(|| tick(section));
                        }
                    });
                });
            } else {
                crowd.tick(model, &frame, tell);
            }
            let list = crowd.draw_list();
            let mut records = vec![BlendRecord::default(); list.characters(DrawKind::Record).len()];
            crowd.evaluate_draws(model, 0..records.len(), &mut records);
            let characters = records.iter().map(|r| r.character);
            assert!(characters.eq(list.characters(DrawKind::Record).iter().copied()));
            for (at, record) in records.iter().enumerate().step_by(3) {
                let mut alone = [BlendRecord::default()];
                crowd.evaluate_draws(model, at..at + 1, &mut alone);
                assert_eq!(alone[0], *record);
            }
            let stepped = steps(&crowd, model, usize::MAX);
            assert_eq!(steps(&crowd, model, 1), stepped);
            let characters = stepped.iter().map(|d| d.character);
            assert!(characters.eq(list.characters(DrawKind::Step).iter().copied()));
            let mut sets = vec![0.0; list.morph_sets() * REST.len()];
            for set in (0..list.morph_sets()).rev() {
                let out = &mut sets[set * REST.len()..][..REST.len()];
                crowd.evaluate_morphs(model, set..set + 1, out);
            }
            assert_eq!(sets, weights(&crowd, model));
            all.push((events, list.clone(), records, stepped, sets));
        }
        all
    };
    for (model, cache) in [(&model, CacheUse::Gpu), (&of_steps, CacheUse::Cpu)] {
        let plain = bytes(false, (model, cache));
        assert_eq!(plain, bytes(true, (model, cache)));
        // Of one level in the order of the sections, then once more: faces that are shown, and at rest.
        let is_split = plain.iter().any(|(_, list, ..)| match cache {
            CacheUse::Gpu => list.groups_of(DrawKind::Record).any(|g| {
                let characters = &list.characters(DrawKind::Record)[g.range.clone()];
                !characters.is_sorted_by_key(|c| c / 1024)
            }),
            _ => list.groups_of(DrawKind::Step).any(|g| {
                let characters = &list.characters(DrawKind::Step)[g.range.clone()];
                !characters.is_sorted_by_key(|c| c / 1024)
            }),
        });
        assert!(is_split, "{cache:?}");
    }
}

#[test]
fn faces_that_change_their_level_allocate_nothing() {
    let (model, _) = animated(2);
    let (places, camera) = (rows(), camera());
    let mut crowd = played(&model, &places, (1.0, CacheUse::Gpu));
    let mut out = vec![0.0; places.positions.len() * REST.len()];
    let counted = allocation_counter::measure(|| {
        for i in 0..16 {
            let views = [View::of(&camera)];
            let frame = Frame {
                cache: CacheUse::Gpu,
                ..places.frame(&views, tolerance_px(i))
            };
            crowd.tick(&model, &frame, &mut |_| {});
            let sets = crowd.draw_list().morph_sets();
            crowd.evaluate_morphs(&model, 0..sets, &mut out[..sets * REST.len()]);
        }
    });
    assert_eq!(counted.count_total, 0);
}

#[test]
fn levels_of_other_targets_or_clips_are_refused() {
    let (_, clips) = animated(1);
    let made = |lods| {
        MorphClips::with_lods(&clips, &REST, 1, lods)
            .unwrap_err()
            .at
    };
    let none = vec![vec![0.0]; 2];
    let other = MorphLods::new(vec![3, 0, 2], vec![3], &none).unwrap();
    assert_eq!(made(other), "lods");
    let few = MorphLods::new(ORDER.to_vec(), vec![3], &none[..1]).unwrap();
    assert_eq!(made(few), "lods");
    assert_eq!(MorphClips::moving(&clips, &REST), Ok(vec![0, 1, 3]));
}
