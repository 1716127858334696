//! Levels, counts and events of a crowd against a plain choice for each character, and what follows
//! from a change of a state, a bound or a cost.

use crate::crowd::{Square, camera, fixed_figure, model, parts, with_cache};
use articula_core::crowd::{
    CacheUse, CharacterState, ClipState, Crowd, CrowdEvent, CrowdModel, CrowdReport, Culling,
    Detail, DrawKind, Frame, Moved,
};
use articula_core::visibility::{View, Visibility};
use articula_core::{
    Attention, AttentionInterval, Bound, Camera, Clip, ClipBounds, ClipLodErrors, MotionBounds,
    Sphere, Tracks, Viewport,
};
use glam::{Quat, Vec3};

/// Every character visible at the depth of its position.
fn frame<'a>(places: &'a Square, views: &'a [View<'a>], detail: Detail) -> Frame<'a> {
    Frame {
        dt_secs: 0.0,
        detail,
        ..places.frame(views, 1.0)
    }
}

/// Characters one behind the other in front of the camera.
fn row(count: usize) -> Square {
    Square {
        positions: (0..count)
            .map(|i| Vec3::new(0.0, -1.0, -5.0 - 4.0 * i as f32))
            .collect(),
        rotations: vec![Quat::IDENTITY; count],
    }
}

/// Pixels that a displacement of a metre spans in a character's bound, a sphere of 1.2 m around the
/// point 1 m above its position, both times its scale: at the nearest depth, and at the greatest
/// distance from the axis. None is beyond the corner of the picture.
fn pixels_per_metre(position: Vec3, scale: f32) -> f32 {
    let depth = -position.z - 1.2 * scale;
    let aside = (position.y + scale).abs() + 1.2 * scale;
    let tangent = (0.5 * Viewport::default().fov_y_radians).tan();
    let corner = tangent * (1.0 + (16.0f32 / 9.0).powi(2)).sqrt();
    let secant = (aside / depth).min(corner).hypot(1.0);
    Viewport::default().pixels_per_metre(depth) * secant
}

fn levels(model: &CrowdModel) -> usize {
    model.parts().clips.joint_lods().levels()
}

#[test]
fn a_level_is_the_coarsest_within_the_tolerance() {
    let (rig, clips, sets) = fixed_figure();
    let model = model(&rig, &clips, &sets);
    let count = 40;
    let places = row(count);
    let scales: Vec<f32> = (0..count).map(|i| [1.0, 0.5, 0.9][i % 3]).collect();
    let importance: Vec<f32> = (0..count).map(|i| [1.0, 2.0, 0.5, 1.5][i % 4]).collect();
    let camera = camera();
    let views = [View::of(&camera)];
    let mut seen = vec![0; levels(&model)];
    for px in [0.3, 1.0, 3.1] {
        let mut crowd = Crowd::new(&model, count);
        let frame = Frame {
            scales: &scales,
            importance: &importance,
            ..frame(&places, &views, Detail::Tolerance { px })
        };
        let report = crowd.tick(&model, &frame, &mut |_| {});
        assert_eq!((report.visible, report.own), (count, count));
        let mut worst = 0.0_f32;
        for c in 0..count {
            // A centimetre for each level, in a character that is scaled.
            let span = pixels_per_metre(places.positions[c], scales[c]) * scales[c];
            let error_px = |level: usize| 0.01 * level as f32 * span;
            let fits = |level: &usize| error_px(*level) * importance[c] <= px;
            let expected = (0..levels(&model)).rev().find(fits).unwrap();
            assert_eq!(crowd.level(c), Some(expected), "character {c} at {px} px");
            worst = worst.max(error_px(expected));
            seen[expected] += 1;
        }
        assert!((report.bound_px / worst - 1.0).abs() < 1e-4);
    }
    assert!(seen.iter().all(|n| *n > 3), "{seen:?} at each level");
}

#[test]
fn a_second_look_changes_nothing() {
    let (rig, clips, sets) = fixed_figure();
    let model = with_cache(model(&rig, &clips, &sets));
    let places = row(60);
    let camera = camera();
    let views = [View::of(&camera)];
    for cache in [CacheUse::Never, CacheUse::Cpu, CacheUse::Gpu] {
        let mut crowd = Crowd::new(&model, 60);
        crowd.fade_to(3, ClipState::new(&model.parts().clips, 1), 5.0);
        let frame = Frame {
            cache,
            ..frame(&places, &views, Detail::Tolerance { px: 2.5 })
        };
        let mut events = 0;
        let first = crowd.tick(&model, &frame, &mut |_| events += 1);
        assert_eq!(events, 60, "each appears");
        let shown = |crowd: &Crowd| {
            let mut draws = crowd.draw_list().draws.clone();
            draws.sort_by_key(|draw| draw.character);
            (
                draws.len(),
                crowd.draw_list().characters(DrawKind::Record).len(),
                crowd.draw_list().matrices,
            )
        };
        let before = shown(&crowd);
        for _ in 0..3 {
            let again = crowd.tick(&model, &frame, &mut |event| panic!("{event:?}"));
            assert_eq!(shown(&crowd), before);
            assert!((again.bound_px / first.bound_px - 1.0).abs() < 1e-5);
            let bound_px = first.bound_px;
            assert_eq!(CrowdReport { bound_px, ..again }, first);
        }
        assert!(first.bound_px <= 2.5 + 1e-4);
    }
}

#[test]
fn work_and_bounds_are_those_of_evaluated_poses() {
    let (rig, clips, sets) = fixed_figure();
    let model = with_cache(model(&rig, &clips, &sets));
    let places = row(30);
    let camera = camera();
    let views = [View::of(&camera)];
    let joint_lods = model.parts().clips.joint_lods();
    for level in 0..levels(&model) {
        let mut crowd = Crowd::new(&model, 30);
        let frame = frame(&places, &views, Detail::Level(level));
        let report = crowd.tick(&model, &frame, &mut |_| {});
        let joints = joint_lods.joint_count(level) as u64;
        let work = report.work;
        assert_eq!(
            (work.characters, work.fk_joints, work.matrices),
            (30, 30 * joints, 30 * joints)
        );
        assert!(work.sampled_joints <= work.fk_joints && work.sampled_joints.is_multiple_of(30));
        assert_eq!(crowd.draw_list().matrices as u64, work.matrices);
        assert_eq!(report.blended, 0);
    }
    // Beyond the coarsest level is the coarsest.
    let mut crowd = Crowd::new(&model, 30);
    crowd.tick(
        &model,
        &frame(&places, &views, Detail::Level(99)),
        &mut |_| {},
    );
    assert_eq!(crowd.level(0), Some(levels(&model) - 1));
    let costs: Vec<f32> = (0..levels(&model))
        .map(|level| {
            let frame = frame(&places, &views, Detail::Level(level));
            let report = Crowd::new(&model, 30).tick(&model, &frame, &mut |_| {});
            (report.work.cost_ns() / 30.0) as f32
        })
        .collect();
    // Cached poses cost no work; of those blended by the GPU nothing is written either.
    for cache in [CacheUse::Cpu, CacheUse::Gpu] {
        let mut crowd = Crowd::new(&model, 30);
        let frame = Frame {
            cache,
            ..frame(&places, &views, Detail::Tolerance { px: 3.0 })
        };
        let report = crowd.tick(&model, &frame, &mut |_| {});
        assert!(report.cached > 0 && report.own > 0);
        assert_eq!(report.cached + report.own, 30);
        assert_eq!(report.work.characters, report.own as u64);
        // A pose of the cache is 5 mm farther off.
        let recorded = crowd.draw_list().characters(DrawKind::Record);
        let drawn = |c: usize| cache == CacheUse::Cpu || recorded.iter().all(|r| *r as usize != c);
        let all = (0..30).filter(|c| drawn(*c)).count();
        assert_eq!(crowd.draw_list().draws.len(), all);
        let (mut worst, mut cached) = (0.0_f32, 0);
        for c in 0..30 {
            let span = pixels_per_metre(places.positions[c], 1.0);
            let within = |level: usize, more: f32| (0.01 * level as f32 + more) * span <= 3.0;
            // Every level, and every one but the finest from the cache.
            let evaluated = (0..levels(&model)).map(|l| (l, 0.0, costs[l]));
            let from_cache = (1..levels(&model)).map(|l| {
                let matrices = joint_lods.joint_count(l) as f32;
                let by_cpu = cache == CacheUse::Cpu;
                (l, 0.005, if by_cpu { 2.0 + 1.1 * matrices } else { 4.0 })
            });
            let within = evaluated.chain(from_cache).filter(|o| within(o.0, o.1));
            // Of equal costs the coarser level.
            let rank = |o: &(usize, f32, f32)| (o.2, usize::MAX - o.0);
            let cheapest = within.min_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap());
            let (level, more, _) = cheapest.unwrap();
            assert_eq!(crowd.level(c), Some(level), "character {c}, {cache:?}");
            cached += usize::from(more > 0.0);
            worst = worst.max((0.01 * level as f32 + more) * span);
        }
        assert_eq!(report.cached, cached);
        assert!((report.bound_px / worst - 1.0).abs() < 1e-4);
    }
}

#[test]
fn a_change_of_level_tells_how_far_the_skin_may_jump() {
    let (rig, clips, sets) = fixed_figure();
    let model = model(&rig, &clips, &sets);
    let places = row(2);
    let camera = camera();
    let views = [View::of(&camera)];
    let mut crowd = Crowd::new(&model, 2);
    let mut told = Vec::new();
    for (views, level) in [
        (&views[..], 0),
        (&views, 2),
        (&views, 1),
        (&[], 1),
        (&[], 1),
    ] {
        let scaled = Frame {
            scales: &[1.0, 0.5],
            ..frame(&places, views, Detail::Level(level))
        };
        crowd.tick(&model, &scaled, &mut |event| {
            if let CrowdEvent::Level {
                character: 0,
                from,
                to,
                jump_px,
            } = event
            {
                told.push((from, to, jump_px));
            }
        });
        if views.is_empty() {
            assert_eq!(crowd.level(0), None);
            assert_eq!(crowd.cull_result(0).visibility, Visibility::Hidden);
        }
    }
    let span = pixels_per_metre(places.positions[0], 1.0);
    let expected = [
        (None, Some(0), 0.0),
        (Some(0), Some(2), 0.02 * span),
        (Some(2), Some(1), 0.03 * span),
        (Some(1), None, 0.0),
    ];
    assert_eq!(told.len(), expected.len());
    for (told, expected) in told.iter().zip(expected) {
        assert_eq!((told.0, told.1), (expected.0, expected.1));
        assert!((told.2 - expected.2).abs() < 1e-3, "{told:?}");
    }
}

#[test]
fn ranges_of_batches_write_about_as_much() {
    let (rig, clips, sets) = fixed_figure();
    let model = model(&rig, &clips, &sets);
    let places = row(240);
    let camera = camera();
    let views = [View::of(&camera)];
    let mut crowd = Crowd::new(&model, 240);
    let frame = frame(&places, &views, Detail::Tolerance { px: 2.0 });
    crowd.tick(&model, &frame, &mut |_| {});
    let (batches, matrices) = (crowd.draw_list().batches, crowd.draw_list().matrices);
    assert!(batches > 12);
    for parts in [1, 2, 3, 5, 1000] {
        let mut first = 0;
        while first < batches {
            let range = crowd.share_of_batches(first, parts);
            assert_eq!(range.start, first);
            let written = crowd.matrices_of(range.clone()).len();
            let but_one = crowd.matrices_of(first..range.end - 1).len();
            assert!(range.end == batches || written * parts >= matrices);
            assert!(but_one * parts < matrices, "{range:?} of {parts}");
            first = range.end;
        }
        assert_eq!(crowd.share_of_batches(batches, parts), batches..batches);
        assert_eq!(crowd.share_of_batches(batches + 9, parts), batches..batches);
    }
    assert_eq!(crowd.share_of_batches(0, 0), 0..batches);
}

#[test]
fn a_fade_keeps_the_level_that_both_clips_need() {
    let (rig, clips, sets) = fixed_figure();
    let mut parts = parts(&rig, &clips, &sets);
    // The second clip needs all joints within any tolerance, the first none.
    let count = parts.clips.joint_lods().levels();
    for (errors, error) in parts.errors.clips.iter_mut().zip([0.0, 9.0]) {
        let mut levels_metres = vec![error; count];
        levels_metres[0] = 0.0;
        *errors = ClipLodErrors {
            worst_metres: levels_metres.clone(),
            levels_metres,
            ..errors.clone()
        };
    }
    let model = CrowdModel::new(parts).unwrap();
    let places = row(1);
    let camera = camera();
    let views = [View::of(&camera)];
    let mut crowd = Crowd::new(&model, 1);
    let frame = Frame {
        dt_secs: 0.25,
        ..frame(&places, &views, Detail::Tolerance { px: 1.0 })
    };
    let tick = |crowd: &mut Crowd| {
        let report = crowd.tick(&model, &frame, &mut |_| {});
        (crowd.level(0).unwrap(), report.blended)
    };
    let coarsest = count - 1;
    let plain = |clip| ClipState::new(&model.parts().clips, clip);
    assert_eq!(tick(&mut crowd), (coarsest, 0));
    crowd.fade_to(0, plain(1), 0.9);
    for _ in 0..3 {
        assert_eq!(tick(&mut crowd), (0, 1));
    }
    assert_eq!(tick(&mut crowd), (0, 0), "the second clip is left");
    crowd.fade_to(0, plain(0), 0.9);
    for _ in 0..3 {
        assert_eq!(tick(&mut crowd), (0, 1));
    }
    assert_eq!(tick(&mut crowd), (coarsest, 0));
    // Another state at once.
    let once = plain(1).once();
    crowd.play(0, once.into());
    assert_eq!(crowd.state(0), CharacterState::from(once));
    assert_eq!(tick(&mut crowd), (0, 0));
}

/// A bound of half a metre that far to the side of the root.
fn aside(x: f32) -> Bound {
    let centre = Vec3::new(x, 1.0, 0.0);
    Bound {
        sphere: Sphere {
            centre,
            radius: 0.5,
        },
        least: centre - 0.5,
        greatest: centre + 0.5,
    }
}

#[test]
fn bounds_are_those_of_the_time_shown() {
    let (rig, clips, sets) = fixed_figure();
    let long = || Clip::new("long", 0.1, 2, rig.len(), Tracks::default()).unwrap();
    // The long clip is in view in its fourth second of ten only, the other one always.
    let away = |second: usize| aside(if second == 3 { 0.0 } else { 500.0 });
    let ten = (0..10).map(away).collect();
    let secs = clips[0].duration_secs();
    let ahead = vec![aside(0.0); ClipBounds::count(secs)];
    let ahead = ClipBounds::new(secs, ahead, aside(0.0).sphere).unwrap();
    let far = ClipBounds::new(10.0, ten, aside(500.0).sphere).unwrap();
    // So many that the look-ups of the first frame are spread more than once over a second.
    let count = 1200;
    let near = row(40);
    let places = Square {
        positions: near.positions.into_iter().cycle().take(count).collect(),
        rotations: vec![Quat::IDENTITY; count],
    };
    let camera = camera();
    let views = [View::of(&camera)];
    let frame = Frame {
        dt_secs: 0.125,
        ..frame(&places, &views, Detail::Full)
    };
    for long_first in [false, true] {
        let mut both = [clips[0].clone(), long()];
        let mut bounds = vec![ahead.clone(), far.clone()];
        if long_first {
            both.reverse();
            bounds.reverse();
        }
        let mut parts = parts(&rig, &both, &sets);
        parts.bounds = MotionBounds {
            clips: bounds,
            reach_metres: 0.1,
        };
        let model = CrowdModel::new(parts).unwrap();
        let mut crowd = Crowd::new(&model, count);
        assert_eq!(crowd.level(0), None, "before the first frame");
        let tick = |crowd: &mut Crowd| crowd.tick(&model, &frame, &mut |_| {}).visible;
        let mut secs = 0.0;
        if !long_first {
            assert_eq!(tick(&mut crowd), count);
            for c in 0..count {
                crowd.play(c, ClipState::new(&model.parts().clips, 1).into());
            }
        }
        for _ in 0..160 {
            let visible = tick(&mut crowd);
            secs = (secs + 0.125_f32) % 10.0;
            // A bound holds for the second after it was looked up.
            if (3.0..4.0).contains(&secs) {
                assert_eq!(visible, count, "{secs} s");
            } else if !(1.9..5.1).contains(&secs) {
                assert_eq!(visible, 0, "{secs} s");
            }
        }
        // To the other clip, at once or in a fade.
        let other = ClipState::new(&model.parts().clips, usize::from(long_first));
        crowd.play(0, other.into());
        crowd.fade_to(1, other, 10.0);
        assert_eq!(tick(&mut crowd), 2);
    }
}

#[test]
fn a_clip_of_two_seconds_has_one_bound_a_longer_one_has_not() {
    let (rig, _, sets) = fixed_figure();
    let places = row(1);
    let camera = camera();
    let views = [View::of(&camera)];
    for (secs, rate_hz, always) in [(2.0, 0.5, true), (2.5, 0.4, false)] {
        let clip = Clip::new("still", rate_hz, 2, rig.len(), Tracks::default()).unwrap();
        let mut parts = parts(&rig, &[clip.clone(), clip], &sets);
        // In view in the first second only.
        let bounds = (0..ClipBounds::count(secs)).map(|s| aside([0.0, 500.0, 500.0][s]));
        let bounds = ClipBounds::new(secs, bounds.collect(), aside(0.0).sphere).unwrap();
        parts.bounds.clips = vec![bounds; 2];
        let model = CrowdModel::new(parts).unwrap();
        let mut crowd = Crowd::new(&model, 1);
        let state = ClipState::new(&model, 0).at_secs(&model, 1.125);
        crowd.play(0, state.once().into());
        let frame = frame(&places, &views, Detail::Full);
        let seen = crowd.tick(&model, &frame, &mut |_| {}).visible == 1;
        assert_eq!(seen, always, "{secs} s");
    }
}

#[test]
fn levels_follow_importance_and_scale_while_nobody_moves() {
    let (rig, clips, sets) = fixed_figure();
    let model = model(&rig, &clips, &sets);
    let places = row(30);
    let camera = camera();
    let views = [View::of(&camera)];
    let (none, all): (&[f32], _) = (&[], [8.0; 30]);
    for (importance, scales) in [(&all[..], none), (none, &all[..])] {
        let mut crowd = Crowd::new(&model, 30);
        let plain = frame(&places, &views, Detail::Tolerance { px: 3.0 });
        let changed = Frame {
            importance,
            scales,
            ..plain
        };
        let levels = |frame: &Frame<'_>, crowd: &mut Crowd| -> Vec<_> {
            crowd.tick(&model, frame, &mut |_| {});
            (0..30).map(|c| crowd.level(c)).collect()
        };
        let fine = |factor| {
            let part: Vec<f32> = all.iter().map(|v| v * factor).collect();
            let frame = Frame {
                importance: if importance.is_empty() { none } else { &part },
                scales: if scales.is_empty() { none } else { &part },
                ..plain
            };
            levels(&frame, &mut Crowd::new(&model, 30))
        };
        // Neutral, eight times that, and neutral again but stated.
        levels(&plain, &mut crowd);
        assert_eq!(levels(&changed, &mut crowd), fine(1.0));
        assert_ne!(fine(1.0), fine(0.125));
        let eighth = [1.0 / 64.0; 30];
        let back = Frame {
            importance: if importance.is_empty() { none } else { &eighth },
            scales: if scales.is_empty() { none } else { &eighth },
            ..plain
        };
        let coarsest = levels(&back, &mut crowd);
        assert!(coarsest.iter().all(|l| *l == crowd.level(29)));
        assert_eq!(levels(&changed, &mut crowd), fine(1.0));
    }
}

/// While importance, scales and the camera change and cells are skipped, nobody is coarser than its
/// tolerance, nor finer than the hysteresis keeps it.
#[test]
fn levels_hold_while_importance_and_scale_change() {
    let (rig, clips, sets) = fixed_figure();
    let model = model(&rig, &clips, &sets);
    let count = 300;
    let places = row(count);
    let mut crowd = Crowd::new(&model, count);
    let mut importance = vec![1.0; count];
    let mut scales = vec![1.0; count];
    for step in 0..60 {
        let eye = Camera {
            eye: camera().eye + Vec3::Z * (step / 4) as f32 * 0.5,
            ..camera()
        };
        let views = [View::of(&eye)];
        if step % 5 == 0 {
            importance[step * 7 % count] = [4.0, 0.5, 1.0][step % 3];
            scales[step * 13 % count] = [2.0, 0.5, 1.0][step % 3];
        }
        let frame = Frame {
            importance: &importance,
            scales: &scales,
            // Scales are told like places.
            moved: Moved::All,
            ..frame(&places, &views, Detail::Tolerance { px: 1.0 })
        };
        let report = crowd.tick(&model, &frame, &mut |_| {});
        let mut worst = 0.0_f32;
        for c in 0..count {
            let Some(level) = crowd.level(c) else {
                continue;
            };
            let span = crowd.cull_result(c).pixels_per_metre * scales[c];
            let error_px = |level: usize| 0.01 * level as f32 * span;
            let tolerance_px = 1.0 / importance[c];
            assert!(
                error_px(level) <= tolerance_px * 1.0001,
                "{c} in frame {step}"
            );
            let coarser = level + 1;
            if coarser < levels(&model) {
                assert!(
                    error_px(coarser) * 1.26 > tolerance_px,
                    "{c} in frame {step}"
                );
            }
            worst = worst.max(error_px(level));
        }
        assert!(report.bound_px >= worst * 0.9999, "frame {step}");
    }
}

#[test]
fn attention_needs_finer_levels_while_it_lasts() {
    let (rig, clips, sets) = fixed_figure();
    let secs = clips[0].duration_secs();
    let interval = AttentionInterval {
        start_secs: 0.5 * secs,
        end_secs: secs,
        factor: 0.25,
    };
    let mut parts = parts(&rig, &clips, &sets);
    let plain = CrowdModel::new(parts.clone()).unwrap();
    parts.attention = vec![Attention::new(secs, &[interval]).ok(), None];
    let marked = CrowdModel::new(parts).unwrap();
    let places = row(40);
    let camera = camera();
    let views = [View::of(&camera)];
    let levels = |crowd: &mut Crowd, model: &CrowdModel, px, dt_secs| -> Vec<_> {
        let frame = Frame {
            dt_secs,
            ..frame(&places, &views, Detail::Tolerance { px })
        };
        crowd.tick(model, &frame, &mut |_| {});
        (0..40).map(|c| crowd.level(c)).collect()
    };
    let fresh = |px| levels(&mut Crowd::new(&plain, 40), &plain, px, 0.0);
    let mut crowd = Crowd::new(&marked, 40);
    assert_eq!(levels(&mut crowd, &marked, 3.0, 0.2 * secs), fresh(3.0));
    assert_eq!(levels(&mut crowd, &marked, 3.0, 0.4 * secs), fresh(0.75));
    assert_ne!(fresh(3.0), fresh(0.75));
}

#[test]
fn only_those_in_the_margin_are_counted_as_such() {
    let (rig, clips, sets) = fixed_figure();
    let model = model(&rig, &clips, &sets);
    let places = Square {
        positions: vec![
            Vec3::new(0.0, -1.0, -8.0),
            Vec3::new(20.0, -1.0, -8.0),
            Vec3::new(20.0, -1.0, -8.0),
            Vec3::new(0.0, -1.0, 8.0),
        ],
        rotations: vec![Quat::IDENTITY; 4],
    };
    let camera = camera();
    let views = [View::of(&camera)];
    let mut crowd = Crowd::new(&model, 4);
    let frame = Frame {
        cull_margin_metres: &[0.0, 25.0, 0.0, 0.0],
        ..frame(&places, &views, Detail::Tolerance { px: 1.0 })
    };
    for _ in 0..2 {
        let report = crowd.tick(&model, &frame, &mut |_| {});
        assert_eq!((report.visible, report.in_margin, report.own), (1, 1, 1));
        let shown: Vec<bool> = (0..4).map(|c| crowd.level(c).is_some()).collect();
        assert_eq!(shown, [true, false, false, false]);
    }
    // Without culling all are visible, and so near that a tolerance allows nothing.
    let frame = Frame {
        culling: Culling::Off,
        ..frame
    };
    let report = crowd.tick(&model, &frame, &mut |_| {});
    assert_eq!((report.visible, report.in_margin), (4, 0));
    assert!((0..4).all(|c| crowd.level(c) == Some(0)));
}
