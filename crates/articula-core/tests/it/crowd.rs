//! Properties of a crowd: acceptance test 9 of `docs/methods/motion-lod.md` part 10, palettes at
//! the positions given by the draws, the same bytes for any division into ranges of batches,
//! complete events for hidden characters, no allocation in a frame.

use crate::random_rig::{Options, figure};
use articula_core::crowd::{
    CacheUse, CharacterState, ClipEvent, ClipState, Crowd, CrowdEvent, CrowdModel, CrowdParts,
    CrowdReport, Culling, Detail, DrawKind, Frame, Moved, RootDelta, RootTrajectory,
};
use articula_core::visibility::View;
use articula_core::{
    BlendRecord, Bound, CachedKeys, CachedRows, Camera, Clip, ClipBounds, ClipLodErrors, ClipSet,
    ClipStorage, JointLods, JointSet, LodErrors, ModelPose, MotionBounds, PaletteForm, PaletteMap,
    PaletteRows, PoseCache, Rig, Sphere, Viewport, Wrap, local_to_model, sample,
};
use glam::{Affine3A, Quat, Vec3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;

const PLAIN: Options = Options {
    scaled: false,
    steps: false,
};

/// A rig with two clips and up to four levels, with a stated error of 1 cm more for each.
pub(crate) fn parts(rig: &Rig, clips: &[Clip], sets: &[JointSet]) -> CrowdParts {
    let joint_lods = JointLods::of_sets(rig, sets, rig.rest_pose()).unwrap();
    let levels: Vec<f32> = (0..joint_lods.levels()).map(|l| l as f32 * 0.01).collect();
    let errors = LodErrors {
        clips: vec![
            ClipLodErrors {
                levels_metres: levels.clone(),
                worst_metres: levels,
                speed_metres_per_sec: 2.0,
                seam_metres: 0.3,
            };
            clips.len()
        ],
    };
    let around = Bound {
        sphere: Sphere {
            centre: Vec3::Y,
            radius: 1.2,
        },
        least: Vec3::splat(-1.2),
        greatest: Vec3::splat(1.2),
    };
    let bounds = clips.iter().map(|clip| {
        let count = ClipBounds::count(clip.duration_secs());
        ClipBounds::new(clip.duration_secs(), vec![around; count], around.sphere).unwrap()
    });
    let bounds = MotionBounds {
        clips: bounds.collect(),
        reach_metres: 1.2,
    };
    let palette = PaletteMap::joints(&joint_lods);
    let clips = ClipSet::new(rig, joint_lods, clips, ClipStorage::Float).unwrap();
    CrowdParts::new(clips, palette, errors, bounds)
}

pub(crate) fn model(rig: &Rig, clips: &[Clip], sets: &[JointSet]) -> CrowdModel {
    CrowdModel::new(parts(rig, clips, sets)).unwrap()
}

pub(crate) fn fixed_figure() -> (Rig, Vec<Clip>, Vec<JointSet>) {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    loop {
        let tree = figure(PLAIN).new_tree(&mut runner).unwrap();
        let (rig, clips, sets) = tree.current();
        if rig.len() > 9 && sets.len() > 1 && clips.iter().all(|c| c.duration_secs() > 0.2) {
            return (rig, clips, sets);
        }
    }
}

/// Characters in rows in front of a camera at the origin, which faces -Z.
pub(crate) struct Square {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) rotations: Vec<Quat>,
}

impl Square {
    pub(crate) fn new(count: usize) -> Self {
        let place = |i: usize| Vec3::new((i % 9) as f32 - 4.0, -1.0, 4.0 - 3.0 * (i / 9) as f32);
        Self {
            positions: (0..count).map(place).collect(),
            rotations: (0..count)
                .map(|i| Quat::from_rotation_y(i as f32))
                .collect(),
        }
    }

    pub(crate) fn frame<'a>(&'a self, views: &'a [View<'a>], px: f32) -> Frame<'a> {
        Frame {
            dt_secs: 1.0 / 60.0,
            positions: &self.positions,
            rotations: &self.rotations,
            culling: Culling::Views(views),
            detail: Detail::Tolerance { px },
            cache: CacheUse::Never,
            ..Frame::default()
        }
    }
}

pub(crate) fn camera() -> Camera {
    Camera::looking_at(Vec3::ZERO, Vec3::NEG_Z, Viewport::default())
}

pub(crate) fn palettes(crowd: &Crowd, model: &CrowdModel) -> Vec<[f32; 4]> {
    let mut rows = vec![[0.0; 4]; crowd.draw_list().matrices * 3];
    let mut scratch = model.evaluator().scratch();
    let all = 0..crowd.draw_list().batches;
    crowd.evaluate(model, all, PaletteRows::Float(&mut rows), &mut scratch);
    rows
}

/// The records of a frame, written in three parts.
pub(crate) fn records(crowd: &Crowd, model: &CrowdModel) -> Vec<BlendRecord> {
    let count = crowd.draw_list().characters(DrawKind::Record).len();
    let mut all = vec![BlendRecord::default(); count];
    for part in [0..count / 3, count / 3..count / 2, count / 2..count] {
        crowd.evaluate_draws(model, part.clone(), &mut all[part]);
    }
    all
}

fn origin(rows: &[[f32; 4]], matrix: usize) -> Vec3 {
    let at = &rows[matrix * 3..matrix * 3 + 3];
    Vec3::new(at[0][3], at[1][3], at[2][3])
}

/// Ticks a mixed crowd for some frames.
fn played(model: &CrowdModel, square: &Square, frames: usize) -> (Crowd, CrowdReport) {
    let mut crowd = Crowd::new(model, square.positions.len());
    for i in 0..square.positions.len() {
        let clip_state = ClipState::new(&model.parts().clips, i % 2)
            .at_secs(&model.parts().clips, i as f32 * 0.037)
            .at_speed([1.0, 0.5, -1.0, 2.0][i % 4]);
        crowd.play(i, clip_state.into());
        if i % 5 == 0 {
            crowd.fade_to(i, ClipState::new(&model.parts().clips, (i + 1) % 2), 10.0);
        }
    }
    let views = [View::of(&camera())];
    let mut report = CrowdReport::default();
    for _ in 0..frames {
        report = crowd.tick(model, &square.frame(&views, 2.0), &mut |_| {});
    }
    (crowd, report)
}

#[test]
fn draws_name_the_palette_of_their_character() {
    let (rig, clips, sets) = fixed_figure();
    let model = model(&rig, &clips, &sets);
    let square = Square::new(200);
    let (crowd, report) = played(&model, &square, 7);
    let rows = palettes(&crowd, &model);
    assert_eq!(crowd.draw_list().draws.len(), report.visible);
    assert_eq!(report.own, report.visible);
    assert_eq!(report.own as u64, report.work.characters);
    assert!(
        report.visible < square.positions.len(),
        "some stand behind the camera"
    );
    assert!(report.blended > 0);
    let mut drawn = vec![false; square.positions.len()];
    for group in &crowd.draw_list().groups {
        assert_eq!(group.matrices, model.parts().palette.len(group.level));
        for draw in &crowd.draw_list().draws[group.range.clone()] {
            let character = draw.character as usize;
            assert!(!std::mem::replace(&mut drawn[character], true));
            assert_eq!(crowd.level(character), Some(group.level));
            for place in 0..group.matrices {
                let joint = usize::from(model.parts().clips.joint_lods().joints()[place]);
                let truth = crowd.attachment(&model, character, joint).translation;
                let shown = origin(&rows, draw.first_matrix as usize + place);
                let off = shown.distance(truth.into());
                assert!(off <= 4e-5, "{off} m at matrix {place} of {character}");
            }
        }
    }
    // Every visible character once, the levels in order.
    let drawn = drawn.iter().filter(|d| **d).count();
    assert_eq!(drawn, report.visible);
    let levels = crowd.draw_list().groups.iter().map(|group| group.level);
    assert!(levels.is_sorted_by(|a, b| a < b));
}

#[test]
fn ranges_of_batches_give_the_same_bytes_in_any_order() {
    let (rig, clips, sets) = fixed_figure();
    let model = model(&rig, &clips, &sets);
    let (crowd, _) = played(&model, &Square::new(300), 3);
    let whole = palettes(&crowd, &model);
    for parts in [2, 3, 7, 1000] {
        let mut ranges = Vec::new();
        let mut first = 0;
        while first < crowd.draw_list().batches {
            let range = crowd.share_of_batches(first, parts);
            first = range.end;
            ranges.push(range);
        }
        assert!(ranges.len() <= parts);
        let mut rows = vec![[f32::NAN; 4]; whole.len()];
        for range in ranges.into_iter().rev() {
            let matrices = crowd.matrices_of(range.clone());
            let part = &mut rows[matrices.start * 3..matrices.end * 3];
            let mut scratch = model.evaluator().scratch();
            crowd.evaluate(&model, range, PaletteRows::Float(part), &mut scratch);
        }
        assert_eq!(rows, whole);
    }
}

#[test]
fn a_frame_allocates_nothing() {
    let (rig, clips, sets) = fixed_figure();
    let events = [ClipEvent { secs: 0.1, id: 7 }];
    let mut parts = parts(&rig, &clips, &sets);
    parts.events = vec![Vec::new(); clips.len()];
    parts.events[0] = events.to_vec();
    let model = CrowdModel::new(parts).unwrap();
    let square = Square::new(120);
    let (mut crowd, _) = played(&model, &square, 2);
    let camera = camera();
    let mut rows = vec![[0.0; 4]; square.positions.len() * model.parts().palette.len(0) * 3];
    let mut scratch = model.evaluator().scratch();
    let mut heard = 0;
    let counted = allocation_counter::measure(|| {
        for i in 0..90 {
            let views = [View::of(&camera)];
            let frame = square.frame(&views, 0.1 * i as f32);
            crowd.tick(&model, &frame, &mut |_| heard += 1);
            let used = crowd.draw_list().matrices * 3;
            let all = 0..crowd.draw_list().batches;
            crowd.evaluate(
                &model,
                all,
                PaletteRows::Float(&mut rows[..used]),
                &mut scratch,
            );
        }
    });
    assert_eq!(counted.count_total, 0);
    assert!(heard > 100);
}

/// Acceptance test 9: a character that walks into view from the side is shown correctly in its
/// first visible frame, and all its events were delivered.
#[test]
fn who_comes_into_view_is_right_at_once_and_missed_no_event() {
    let (rig, clips, sets) = fixed_figure();
    let duration = clips[0].duration_secs();
    let marks = [(0.25, 1), (0.75, 2)].map(|(part, id)| ClipEvent {
        secs: duration * part,
        id,
    });
    // One metre ahead in each loop of the clip.
    let ahead = RootDelta {
        offset: Vec3::Z,
        yaw_radians: 0.0,
    };
    let path = RootTrajectory::new(1.0 / duration, vec![RootDelta::default(), ahead]).unwrap();
    let mut parts = parts(&rig, &clips, &sets);
    parts.events = vec![Vec::new(); clips.len()];
    parts.events[0] = marks.to_vec();
    parts.paths = vec![None; clips.len()];
    parts.paths[0] = Some(path);
    let model = CrowdModel::new(parts).unwrap();
    let mut crowd = Crowd::new(&model, 1);
    let facing = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let mut position = Vec3::new(-14.0, -1.0, -6.0);
    let camera = camera();
    let (mut secs, mut heard, mut first_seen) = (0.0f64, Vec::new(), None);
    for i in 0..2000 {
        let dt_secs = [1.0 / 60.0, 1.0 / 24.0, 0.11][i % 3];
        let views = [View::of(&camera)];
        let (positions, rotations) = ([position], [facing]);
        let frame = Frame {
            dt_secs,
            positions: &positions,
            rotations: &rotations,
            culling: Culling::Views(&views),
            detail: Detail::Full,
            cache: CacheUse::Never,
            ..Frame::default()
        };
        crowd.tick(&model, &frame, &mut |event| {
            if let CrowdEvent::Clip { id, .. } = event {
                heard.push(id);
            }
        });
        secs += f64::from(dt_secs);
        position += facing * crowd.root_delta(&model, 0).offset;
        if crowd.level(0).is_some() {
            first_seen = Some(i);
            break;
        }
    }
    assert!(first_seen.unwrap() > 20, "it begins out of view");
    // Root motion and events of all loops, though no pose was evaluated before.
    let laps = secs / f64::from(duration);
    assert!(
        (f64::from(position.x) + 14.0 - laps).abs() < 0.01,
        "{laps} laps"
    );
    let told = [0.25, 0.75].map(|mark| (laps - mark).floor() + 1.0);
    assert_eq!(heard.len(), (told[0] + told[1]) as usize);
    assert!(heard.windows(2).all(|w| w[0] != w[1]), "in turns");
    let rows = palettes(&crowd, &model);
    let mut pose = rig.rest_pose().clone();
    sample(
        &clips[0],
        secs.rem_euclid(f64::from(duration)),
        Wrap::Clamp,
        &rig.all(),
        &mut pose,
    );
    let mut truth = ModelPose::new(rig.len());
    local_to_model(&rig, &pose, &mut truth);
    for place in 0..rig.len() {
        let joint = usize::from(model.parts().clips.joint_lods().joints()[place]);
        // An f32 clock is accurate to some microseconds after some seconds.
        assert!(origin(&rows, place).distance(truth.position(joint)) < 1e-3);
    }
}

#[test]
fn a_fade_ends_at_the_other_clip_and_both_tell_their_events() {
    let (rig, clips, sets) = fixed_figure();
    let mut parts = parts(&rig, &clips, &sets);
    let event = |clip| {
        vec![ClipEvent {
            secs: 0.0,
            id: clip as u32 + 1,
        }]
    };
    parts.events = (0..clips.len()).map(event).collect();
    let model = CrowdModel::new(parts).unwrap();
    let mut crowd = Crowd::new(&model, 1);
    crowd.fade_to(0, ClipState::new(&model.parts().clips, 1), 0.5);
    let square = Square::new(1);
    let mut heard = [false; 3];
    for step in 0..40 {
        let mut frame = square.frame(&[], 1.0);
        frame.dt_secs = 0.02;
        crowd.tick(&model, &frame, &mut |event| {
            if let CrowdEvent::Clip { id, weight, .. } = event {
                heard[id as usize] = true;
                assert!((0.0..=1.0).contains(&weight));
            }
        });
        let done = step as f32 * 0.02 + 0.02 >= 0.5 - 1e-6;
        assert_eq!(crowd.state(0).next().is_none(), done, "step {step}");
    }
    assert_eq!(heard, [false, true, true]);
    assert_eq!(crowd.state(0).clip_state().clip(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Every frame completes for any input, and its draws can be evaluated.
    #[test]
    fn odd_numbers_behave(
        (rig, clips, sets) in figure(PLAIN),
        count in 0usize..12,
        odd in prop::collection::vec(
            prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(-1e30f32), Just(0.0f32), -5.0f32..5.0],
            12,
        ),
        px in prop_oneof![Just(f32::NAN), Just(0.0f32), Just(f32::INFINITY), -1.0f32..9.0],
    ) {
        let model = model(&rig, &clips, &sets);
        let mut crowd = Crowd::new(&model, count);
        let positions: Vec<Vec3> = (0..count).map(|i| Vec3::new(odd[i], odd[11 - i], -3.0)).collect();
        let rotations = vec![Quat::IDENTITY; count];
        let scales: Vec<f32> = odd[..count].to_vec();
        for (i, o) in odd.iter().enumerate().take(count) {
            let clip_state = ClipState::new(&model.parts().clips, i % 2).at_speed(*o).at_secs(&model.parts().clips, *o);
            crowd.play(i, CharacterState::blend(clip_state, clip_state.once(), *o));
            if i % 3 == 0 {
                crowd.fade_to(i, clip_state, *o);
            }
        }
        let camera = camera();
        let views = [View::of(&camera)];
        for (i, dt_secs) in odd.iter().enumerate() {
            let frame = Frame {
                dt_secs: *dt_secs,
                positions: &positions,
                rotations: &rotations,
                moved: Moved::All,
                scales: &scales,
                cull_margin_metres: &scales,
                importance: &scales,
                culling: if i % 4 == 3 { Culling::Off } else { Culling::Views(&views) },
                detail: Detail::Tolerance { px },
                cache: CacheUse::Never,
            };
            let report = crowd.tick(&model, &frame, &mut |_| {});
            prop_assert_eq!(crowd.draw_list().draws.len(), report.visible);
            let rows = palettes(&crowd, &model);
            prop_assert!(rows.iter().flatten().all(|v| v.is_finite()));
            for draw in &crowd.draw_list().draws {
                let level = crowd.level(draw.character as usize).unwrap();
                let end = draw.first_matrix as usize + model.parts().palette.len(level);
                prop_assert!(end <= crowd.draw_list().matrices);
            }
        }
    }

    /// An attachment follows the joint of the full character, whatever level is shown.
    #[test]
    fn attachments_are_where_the_pose_has_them(
        (rig, clips, _) in figure(Options { scaled: true, steps: true }),
        secs in 0.0f32..1.0,
        joint in any::<prop::sample::Index>(),
    ) {
        let set = ClipSet::new(&rig, JointLods::whole(&rig).unwrap(), &clips, ClipStorage::Float).unwrap();
        let joint = joint.index(rig.len());
        let found = articula_core::crowd::attachment(&set, &set.cursor(0, secs).into(), joint);
        let mut pose = rig.rest_pose().clone();
        sample(&clips[0], f64::from(secs), Wrap::Clamp, &rig.all(), &mut pose);
        let mut truth = ModelPose::new(rig.len());
        local_to_model(&rig, &pose, &mut truth);
        let apart = |a: &Affine3A, b: &Affine3A, p: Vec3| a.transform_point3(p).distance(b.transform_point3(p));
        for p in [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z] {
            prop_assert!(apart(&found, &truth.matrices[joint], p) < 4e-5);
        }
    }
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let (rig, clips, sets) = fixed_figure();
    let parts = || parts(&rig, &clips, &sets);
    let at = |parts| CrowdModel::new(parts).unwrap_err().at;
    let mut few = parts();
    few.errors.clips.pop();
    assert_eq!(at(few), "errors.clips");
    let mut few = parts();
    few.bounds.clips.pop();
    assert_eq!(at(few), "bounds.clips");
    let mut other = parts();
    let whole = JointLods::whole(&rig).unwrap();
    other.palette = PaletteMap::joints(&whole);
    assert_eq!(at(other), "map");
    let mut many = parts();
    many.events = vec![Vec::new(); 9];
    assert_eq!(at(many), "events");
    let mut late = parts();
    late.events = vec![Vec::new(); clips.len()];
    late.events[0].push(ClipEvent { secs: 1e9, id: 0 });
    assert_eq!(at(late), "events[0][0].secs");
    let mut many = parts();
    many.paths = vec![None; 9];
    assert_eq!(at(many), "paths");
    let cached = with_cache(model(&rig, &clips, &sets));
    let mut other = parts();
    other.cache.clone_from(&cached.parts().cache);
    other.form = PaletteForm::HalfMatrix;
    assert_eq!(at(other), "cache");
    // Playback state, bound in the model and in the world, level and source, option, and the range
    // in which they are kept.
    assert_eq!(Crowd::BYTES_PER_CHARACTER, 20 + 16 + 16 + 1 + 1 + 8);
}

/// A cache of the first and last pose of each clip at every level but the finest, with a stated
/// error of 5 mm.
pub(crate) fn with_cache(model: CrowdModel) -> CrowdModel {
    let evaluator = model.evaluator();
    let mut scratch = evaluator.scratch();
    let mut rows = Vec::new();
    let mut keys = Vec::new();
    for clip in 0..model.parts().clips.clips() {
        let duration = model.parts().clips.duration_secs(clip);
        let mut of_clip = vec![None];
        for level in 1..model.parts().clips.joint_lods().levels() {
            let first_matrix = (rows.len() / 3) as u32;
            for secs in [0.0, duration] {
                let mut palette = vec![[0.0; 4]; evaluator.rows(level)];
                let shown = [model.parts().clips.cursor(clip, secs).into()];
                evaluator.evaluate(
                    level,
                    &shown,
                    PaletteRows::Float(&mut palette),
                    &mut scratch,
                );
                rows.extend(palette);
            }
            of_clip.push(Some(CachedKeys {
                times_secs: vec![0.0, duration],
                first_matrix,
                error_metres: 0.005,
            }));
        }
        keys.push(of_clip);
    }
    let rows = CachedRows::Float(rows);
    let cache = PoseCache::new(&model.parts().clips, &model.parts().palette, &keys, rows).unwrap();
    let mut parts = model.parts().clone();
    parts.cache = Some(cache);
    CrowdModel::new(parts).unwrap()
}

#[test]
fn cached_poses_are_blended_by_either_side() {
    let (rig, clips, sets) = fixed_figure();
    let model = with_cache(model(&rig, &clips, &sets));
    let square = Square::new(200);
    let camera = camera();
    let views = [View::of(&camera)];
    let mut crowd = Crowd::new(&model, 200);
    for i in 0..200 {
        let clip_state = ClipState::new(&model.parts().clips, i % 2)
            .at_secs(&model.parts().clips, 0.01 * i as f32);
        crowd.play(i, clip_state.into());
    }
    let mut frame = square.frame(&views, 3.0);
    frame.dt_secs = 0.0;
    frame.cache = CacheUse::Cpu;
    let by_cpu = crowd.tick(&model, &frame, &mut |_| {});
    let rows = palettes(&crowd, &model);
    let draws = crowd.draw_list().draws.to_vec();
    assert!(by_cpu.cached > 20 && by_cpu.own > 2);
    assert_eq!(
        (
            draws.len(),
            crowd.draw_list().characters(DrawKind::Record).len()
        ),
        (by_cpu.visible, 0)
    );
    assert!(by_cpu.bound_px <= 3.0);

    frame.cache = CacheUse::Gpu;
    let by_gpu = crowd.tick(&model, &frame, &mut |_| {});
    assert!(by_gpu.cached >= by_cpu.cached);
    assert_eq!(
        crowd.draw_list().draws.len() + crowd.draw_list().characters(DrawKind::Record).len(),
        by_gpu.visible
    );
    let CachedRows::Float(cached) = model.parts().cache.as_ref().unwrap().rows() else {
        panic!("cached in f32");
    };
    let all = records(&crowd, &model);
    let mut compared = 0;
    for group in crowd.draw_list().groups_of(DrawKind::Record) {
        for record in &all[group.range.clone()] {
            let level = crowd.level(record.character as usize);
            assert_eq!(level, Some(group.level));
            let mut of_character = draws.iter().filter(|d| d.character == record.character);
            let first = of_character.next().unwrap().first_matrix as usize;
            let after = origin(cached, record.after as usize);
            let blended = origin(cached, record.before as usize).lerp(after, record.blend);
            // The poses are equal only where the CPU used the cache too.
            let same = origin(&rows, first).distance(blended) < 1e-5;
            compared += usize::from(same);
        }
    }
    assert!(compared >= by_cpu.cached, "{compared} of {}", by_cpu.cached);
}
