//! Impostors: shown to whoever they are within the tolerance of, in the pose of the clip's time, the
//! same for any division into ranges, without allocation.

use crate::crowd::{Square, camera, fixed_figure, parts};
use articula_core::crowd::{
    CacheUse, CharacterState, ClipState, Crowd, CrowdModel, DrawKind, Frame, ImpostorDraw,
};
use articula_core::visibility::View;
use articula_core::{ClipImpostors, Impostors};

/// Stated error, above that of every level, and the number of poses of each clip.
const ERROR_METRES: f32 = 0.2;
const POSES: u32 = 6;

/// A model whose first clip alone has impostors.
fn model() -> CrowdModel {
    let (rig, clips, sets) = fixed_figure();
    let mut parts = parts(&rig, &clips, &sets);
    let durations: Vec<f32> = (0..parts.clips.clips())
        .map(|c| parts.clips.duration_secs(c))
        .collect();
    let all = (0..durations.len()).map(|clip| {
        (clip == 0).then(|| ClipImpostors {
            poses: (0..POSES).map(|pose| 10 + pose).collect(),
            error_metres: ERROR_METRES,
        })
    });
    parts.impostors = Some(Impostors::new(all.collect(), &durations).unwrap());
    CrowdModel::new(parts).unwrap()
}

/// Characters at different times of two clips; some fade.
fn crowd(model: &CrowdModel, count: usize) -> Crowd {
    let clips = &model.parts().clips;
    let mut crowd = Crowd::new(model, count);
    for i in 0..count {
        let state = ClipState::new(clips, i % 2).at_secs(clips, 0.013 * i as f32);
        crowd.play(i, state.into());
        if i % 10 == 0 {
            let other = ClipState::new(clips, 1);
            crowd.play(i, CharacterState::fading(state, other, 0.25, 10.0));
        }
    }
    crowd
}

fn draws(crowd: &Crowd, model: &CrowdModel, range: usize) -> Vec<ImpostorDraw> {
    let count = crowd.draw_list().characters(DrawKind::Impostor).len();
    let mut all = vec![ImpostorDraw::default(); count];
    let firsts: Vec<usize> = (0..count).step_by(range).collect();
    for first in firsts.into_iter().rev() {
        let part = first..(first + range).min(count);
        crowd.evaluate_draws(model, part.clone(), &mut all[part]);
    }
    all
}

fn frame<'a>(square: &'a Square, views: &'a [View<'a>], cache: CacheUse) -> Frame<'a> {
    Frame {
        cache,
        ..square.frame(views, 2.0)
    }
}

#[test]
fn who_is_far_is_one_draw_of_the_pose_of_its_time() {
    let (model, square, camera) = (model(), Square::new(2000), camera());
    let views = [View::of(&camera)];
    let mut crowd = crowd(&model, 2000);
    for _ in 0..5 {
        let report = crowd.tick(&model, &frame(&square, &views, CacheUse::Cpu), &mut |_| ());
        let list = crowd.draw_list();
        assert!(report.impostors > 100, "{}", report.impostors);
        assert_eq!(report.impostors, list.characters(DrawKind::Impostor).len());
        assert_eq!(report.impostors + list.draws.len(), report.visible);
        assert!(report.bound_px <= 2.0 + 1e-4);
        let all = draws(&crowd, &model, usize::MAX);
        for draw in &all {
            let character = draw.character as usize;
            let state = crowd.state(character);
            assert!(state.next().is_none(), "nobody who fades is an impostor");
            assert_eq!(state.clip_state().clip(), 0);
            assert!(crowd.cull_result(character).pixels_per_metre * ERROR_METRES <= 2.0 + 1e-4);
            let span = model.parts().clips.duration_secs(0) / (POSES - 1) as f32;
            let time = (draw.pose - 10) as f32 * span;
            let apart = (time - state.clip_state().secs()).abs();
            assert!(apart <= 0.5 * span + 1e-4, "{apart} s of {span}");
        }
        assert_eq!(draws(&crowd, &model, 7), all);
        // Everyone of the clip who is within the tolerance is there.
        for character in 0..2000 {
            let state = crowd.state(character);
            let is_far = crowd.cull_result(character).pixels_per_metre * ERROR_METRES < 1.5;
            let could = state.clip_state().clip() == 0 && state.next().is_none() && is_far;
            if could && crowd.level(character).is_some() {
                assert!(
                    list.characters(DrawKind::Impostor)
                        .contains(&(character as u32)),
                    "{character}"
                );
            }
        }
    }
    let report = crowd.tick(
        &model,
        &frame(&square, &views, CacheUse::Never),
        &mut |_| (),
    );
    assert_eq!((report.impostors, report.visible), (0, report.own));
}

#[test]
fn a_frame_with_impostors_allocates_nothing() {
    let (model, square, camera) = (model(), Square::new(500), camera());
    let views = [View::of(&camera)];
    let mut crowd = crowd(&model, 500);
    let mut out = vec![ImpostorDraw::default(); 500];
    let mut play = || {
        crowd.tick(&model, &frame(&square, &views, CacheUse::Gpu), &mut |_| ());
        let count = crowd.draw_list().characters(DrawKind::Impostor).len();
        crowd.evaluate_draws(&model, 0..count, &mut out[..count]);
        count
    };
    play();
    let mut count = 0;
    let allocated = allocation_counter::measure(|| count = play());
    assert_eq!(allocated.count_total, 0);
    assert!(count > 0);
}
