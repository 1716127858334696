//! Cached palettes that are shown as they are: the nearest in time, for whoever they are the cheapest
//! way, the same for any division into ranges and on any threads, without allocation.

use crate::crowd::{Square, camera, fixed_figure, model, palettes, with_cache};
use articula_core::crowd::{
    CacheUse, CharacterState, ClipState, Crowd, CrowdEvent, CrowdModel, Detail, Draw, DrawKind,
    Frame,
};
use articula_core::visibility::View;
use articula_core::{BlendRecord, CachedKeys, CachedRows, CachedSteps, PaletteRows, PoseCache};
use glam::{Quat, Vec3};

/// Palettes of each clip at each level but the finest.
const COUNT: u32 = 9;
/// Stated error of showing one as it is, and of a blend of `with_cache`.
pub(crate) const STEP_METRES: f32 = 0.02;
const BLEND_METRES: f32 = 0.005;

/// The model with palettes in its cache that are shown as they are.
pub(crate) fn with_steps(model: CrowdModel) -> CrowdModel {
    with_blended_steps(model, None)
}

/// The same with a stated error of blends of two of them.
fn with_blended_steps(model: CrowdModel, blend_error_metres: Option<f32>) -> CrowdModel {
    let clips = &model.parts().clips;
    let evaluator = model.evaluator();
    let mut scratch = evaluator.scratch();
    let mut cache = model.parts().cache.clone().unwrap();
    let CachedRows::Float(mut rows) = cache.rows().clone() else {
        panic!("cached in f32");
    };
    let levels = clips.joint_lods().levels();
    let mut keys = Vec::new();
    let mut steps = vec![vec![None; levels]; clips.clips()];
    for (clip, steps) in steps.iter_mut().enumerate() {
        keys.push((0..levels).map(|_| None).collect::<Vec<_>>());
        for (level, steps) in steps.iter_mut().enumerate().skip(1) {
            *steps = Some(CachedSteps {
                count: COUNT,
                first_matrix: (rows.len() / 3) as u32,
                error_metres: STEP_METRES,
                blend_error_metres,
            });
            for i in 0..COUNT {
                let secs = clips.duration_secs(clip) * i as f32 / (COUNT - 1) as f32;
                let mut palette = vec![[0.0; 4]; evaluator.rows(level)];
                let out = PaletteRows::Float(&mut palette);
                evaluator.evaluate(level, &[clips.cursor(clip, secs).into()], out, &mut scratch);
                rows.extend(palette);
            }
        }
    }
    // The keys of the cache are the first and the last pose of each clip, the levels in order.
    let mut first_matrix = 0;
    for (clip, keys) in keys.iter_mut().enumerate() {
        for (level, keys) in keys.iter_mut().enumerate().skip(1) {
            *keys = Some(CachedKeys {
                times_secs: cache.times_secs(clip, level).unwrap().collect(),
                first_matrix,
                error_metres: BLEND_METRES,
            });
            first_matrix += 2 * cache.matrices(level) as u32;
        }
    }
    let rows = CachedRows::Float(rows);
    cache = PoseCache::new(clips, &model.parts().palette, &keys, rows).unwrap();
    let mut parts = model.parts().clone();
    parts.cache = Some(cache.with_steps(clips, &steps).unwrap());
    CrowdModel::new(parts).unwrap()
}

fn stepped_model() -> CrowdModel {
    let (rig, clips, sets) = fixed_figure();
    with_steps(with_cache(model(&rig, &clips, &sets)))
}

/// The stepped draws of a frame, written in ranges of so many, the last one first.
pub(crate) fn steps(crowd: &Crowd, model: &CrowdModel, range: usize) -> Vec<Draw> {
    let mut all = vec![Draw::default(); crowd.draw_list().characters(DrawKind::Step).len()];
    let firsts: Vec<usize> = (0..all.len()).step_by(range).collect();
    for first in firsts.into_iter().rev() {
        let part = first..(first + range).min(all.len());
        crowd.evaluate_draws(model, part.clone(), &mut all[part]);
    }
    all
}

/// A crowd whose characters are at different times of their clips; some fade.
fn crowd_of(model: &CrowdModel, count: usize) -> Crowd {
    let clips = &model.parts().clips;
    let mut crowd = Crowd::new(model, count);
    for i in 0..count {
        let state = ClipState::new(clips, i % 2).at_secs(clips, 0.013 * i as f32);
        crowd.play(i, state.into());
        if i % 11 == 0 {
            let other = ClipState::new(clips, (i + 1) % 2);
            crowd.play(i, CharacterState::fading(state, other, 0.25, 10.0));
        }
    }
    crowd
}

fn frame<'a>(square: &'a Square, views: &'a [View<'a>], px: f32) -> Frame<'a> {
    Frame {
        cache: CacheUse::Cpu,
        ..square.frame(views, px)
    }
}

#[test]
fn a_step_shows_the_cached_palette_nearest_in_time() {
    let model = stepped_model();
    let clips = &model.parts().clips;
    let square = Square::new(300);
    let camera = camera();
    let views = [View::of(&camera)];
    let mut crowd = crowd_of(&model, 300);
    let CachedRows::Float(cached) = model.parts().cache.as_ref().unwrap().rows() else {
        panic!("cached in f32");
    };
    let evaluator = model.evaluator();
    for _ in 0..5 {
        let report = crowd.tick(&model, &frame(&square, &views, 3.0), &mut |_| {});
        let list = crowd.draw_list();
        assert!(report.stepped > 60 && report.cached > 0 && report.own > 5);
        assert!(report.bound_px <= 3.0 + 1e-4);
        assert_eq!(report.stepped, list.characters(DrawKind::Step).len());
        assert_eq!(report.stepped + list.draws.len(), report.visible);
        assert_eq!(
            (report.stepped + report.cached + report.own),
            report.visible
        );
        let draws = steps(&crowd, &model, usize::MAX);
        assert_eq!(
            list.groups_of(DrawKind::Step).last().unwrap().range.end,
            draws.len()
        );
        for group in list.groups_of(DrawKind::Step) {
            for draw in &draws[group.range.clone()] {
                let character = draw.character as usize;
                assert_eq!(crowd.level(character), Some(group.level));
                assert_eq!(group.matrices, model.parts().palette.len(group.level));
                let state = crowd.state(character);
                assert!(state.next().is_none(), "nobody who fades is stepped");
                let (clip, secs) = (state.clip_state().clip(), state.clip_state().secs());
                let span = clips.duration_secs(clip) / (COUNT - 1) as f32;
                let nearest = (0..COUNT).map(|i| i as f32 * span);
                let apart = |key: f32| (key - secs).abs();
                let nearest = nearest
                    .min_by(|a, b| apart(*a).total_cmp(&apart(*b)))
                    .unwrap();
                let mut truth = vec![[0.0; 4]; evaluator.rows(group.level)];
                evaluator.evaluate(
                    group.level,
                    &[clips.cursor(clip, nearest).into()],
                    PaletteRows::Float(&mut truth),
                    &mut evaluator.scratch(),
                );
                let first = 3 * draw.first_matrix as usize;
                let shown = &cached[first..first + truth.len()];
                // Half-way between two, rounding may choose either.
                let is_between = (apart(nearest) / span - 0.5).abs() < 1e-3;
                assert!(
                    is_between || shown == truth,
                    "character {character} at {secs} s"
                );
            }
        }
    }
}

#[test]
fn ranges_and_threads_give_the_same_steps() {
    let model = stepped_model();
    let square = Square::new(2500);
    let camera = camera();
    let views = [View::of(&camera)];
    let mut crowds = [crowd_of(&model, 2500), crowd_of(&model, 2500)];
    let [plain, on_threads] = &mut crowds;
    for _ in 0..4 {
        let frame = frame(&square, &views, 2.0);
        let report = plain.tick(&model, &frame, &mut |_| {});
        let other = on_threads.tick_on(&model, &frame, &mut |_| {}, |sections, tick| {
            let (left, right) = sections.split_at_mut(1);
            std::thread::scope(|threads| {
                threads.spawn(|| left.iter_mut().for_each(tick));
                right.iter_mut().for_each(tick);
            });
        });
        assert_eq!(other, report);
        let whole = steps(plain, &model, usize::MAX);
        assert!(whole.len() > 1000);
        for range in [1, 7, 640] {
            assert_eq!(steps(on_threads, &model, range), whole);
        }
        assert_eq!(palettes(on_threads, &model), palettes(plain, &model));
    }
}

#[test]
fn the_cheapest_way_is_taken() {
    let model = stepped_model();
    let joint_lods = model.parts().clips.joint_lods();
    let levels = joint_lods.levels();
    let square = Square::new(300);
    let camera = camera();
    let views = [View::of(&camera)];
    let evaluated_ns = |level: usize| {
        let mut crowd = Crowd::new(&model, 300);
        let frame = Frame {
            detail: Detail::Level(level),
            ..frame(&square, &views, 1.0)
        };
        let report = crowd.tick(&model, &frame, &mut |_| {});
        report.work.cost_ns() as f32 / report.own as f32
    };
    let ns: Vec<f32> = (0..levels).map(evaluated_ns).collect();
    for px in [0.5, 2.0, 6.0] {
        for cache in [CacheUse::Never, CacheUse::Cpu, CacheUse::Gpu] {
            let mut crowd = Crowd::new(&model, 300);
            let frame = Frame {
                cache,
                ..frame(&square, &views, px)
            };
            let report = crowd.tick(&model, &frame, &mut |_| {});
            let mut stepped = 0;
            for c in (0..300).filter(|c| crowd.level(*c).is_some()) {
                let span = crowd.cull_result(c).pixels_per_metre;
                let evaluated = (0..levels).map(|l| (l, 0.0, ns[l]));
                let blended = (1..levels).filter_map(|l| match cache {
                    CacheUse::Never => None,
                    CacheUse::Cpu => {
                        let matrices = joint_lods.joint_count(l) as f32;
                        Some((l, BLEND_METRES, 2.0 + 1.1 * matrices))
                    }
                    CacheUse::Gpu => Some((l, BLEND_METRES, 4.0)),
                });
                // As they are, by the CPU alone: a record costs as much, and its error is less.
                let steps = (1..levels).filter(|_| cache == CacheUse::Cpu);
                let steps = steps.map(|l| (l, STEP_METRES, 3.5));
                let all = evaluated.chain(blended).chain(steps);
                let within = all.filter(|o| (0.01 * o.0 as f32 + o.1) * span <= px);
                // Of equal costs the coarser level.
                let rank = |o: &(usize, f32, f32)| (o.2, usize::MAX - o.0);
                let cheapest = within.min_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap());
                let (level, more, _) = cheapest.unwrap();
                assert_eq!(crowd.level(c), Some(level), "character {c}, {cache:?}");
                let is_step = crowd
                    .draw_list()
                    .characters(DrawKind::Step)
                    .contains(&(c as u32));
                assert_eq!(is_step, more == STEP_METRES, "character {c}, {cache:?}");
                stepped += usize::from(is_step);
            }
            assert_eq!(report.stepped, stepped);
            assert_eq!(stepped > 0, cache == CacheUse::Cpu);
        }
    }
}

/// The records for the GPU of a crowd within so many pixels, each of which is that of its character's time.
fn recorded(model: &CrowdModel, px: f32) -> Vec<BlendRecord> {
    let square = Square::new(300);
    let camera = camera();
    let views = [View::of(&camera)];
    let mut crowd = crowd_of(model, 300);
    let frame = Frame {
        cache: CacheUse::Gpu,
        ..frame(&square, &views, px)
    };
    let report = crowd.tick(model, &frame, &mut |_| {});
    assert!(report.bound_px <= px + 1e-4);
    let mut records = vec![BlendRecord::default(); report.cached];
    crowd.evaluate_draws(model, 0..records.len(), &mut records);
    let cache = model.parts().cache.as_ref().unwrap();
    for record in &records {
        let character = record.character as usize;
        let state = crowd.state(character);
        let state = state.clip_state();
        let level = crowd.level(character).unwrap();
        let expected = cache.record(state.clip(), level, state.secs()).unwrap();
        assert_eq!(
            (record.before, record.after),
            (expected.before, expected.after)
        );
        assert_eq!(record.blend, expected.blend);
    }
    records
}

#[test]
fn a_record_blends_steps_where_they_are_closer() {
    let (rig, clips, sets) = fixed_figure();
    let made = |error| with_blended_steps(with_cache(model(&rig, &clips, &sets)), error);
    let of_steps = |model: &CrowdModel, px| {
        let cache = model.parts().cache.as_ref().unwrap();
        let first = cache.nearest(0, 1, 0.0).unwrap();
        let found = recorded(model, px);
        // Palettes of steps come behind those of all keys.
        let of_steps = found.iter().filter(|r| r.before >= first).count();
        (of_steps, found.len())
    };
    for px in [0.5, 2.0, 6.0] {
        let (steps, all) = of_steps(&made(None), px);
        assert_eq!(steps, 0);
        let (steps, same) = of_steps(&made(Some(BLEND_METRES)), px);
        assert_eq!((steps, same), (0, all));
        let (steps, more) = of_steps(&made(Some(0.1 * BLEND_METRES)), px);
        assert!(steps == more && more >= all, "{more}, {all} of keys");
    }
    let counts = [None, Some(0.1 * BLEND_METRES)].map(|error| of_steps(&made(error), 0.5).1);
    assert!(counts[0] < counts[1], "{counts:?}");
}

#[test]
fn a_jump_counts_the_errors_of_the_sources() {
    let model = stepped_model();
    let square = Square {
        positions: vec![Vec3::new(0.0, -1.0, -40.0)],
        rotations: vec![Quat::IDENTITY],
    };
    let camera = camera();
    let views = [View::of(&camera)];
    let mut crowd = Crowd::new(&model, 1);
    let mut told = Vec::new();
    for (px, cache) in [
        (0.0, CacheUse::Cpu),
        (50.0, CacheUse::Cpu),
        (0.0, CacheUse::Cpu),
    ] {
        let frame = Frame {
            cache,
            ..frame(&square, &views, px)
        };
        crowd.tick(&model, &frame, &mut |event| {
            if let CrowdEvent::Level { from, jump_px, .. } = event {
                told.push((from.is_some(), jump_px));
            }
        });
    }
    let span = crowd.cull_result(0).pixels_per_metre;
    let coarsest = model.parts().clips.joint_lods().levels() - 1;
    let jump_px = (0.01 * coarsest as f32 + STEP_METRES) * span;
    assert_eq!(told.len(), 3);
    assert_eq!(told[0], (false, 0.0));
    for (is_change, px) in &told[1..] {
        assert!(
            *is_change && (px / jump_px - 1.0).abs() < 1e-4,
            "{told:?}, {jump_px}"
        );
    }
}

#[test]
fn a_stepped_frame_allocates_nothing() {
    let model = stepped_model();
    let square = Square::new(300);
    let camera = camera();
    let mut crowd = crowd_of(&model, 300);
    let mut out = vec![Draw::default(); 300];
    let mut seen = 0;
    let counted = allocation_counter::measure(|| {
        for i in 0..40 {
            let views = [View::of(&camera)];
            crowd.tick(&model, &frame(&square, &views, 0.1 * i as f32), &mut |_| {});
            let count = crowd.draw_list().characters(DrawKind::Step).len();
            crowd.evaluate_draws(&model, 0..count, &mut out[..count]);
            seen += count;
        }
    });
    assert_eq!(counted.count_total, 0);
    assert!(seen > 1000);
}
