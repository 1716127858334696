//! What a crowd shows against one character at a time: [`cull`], a wrapped clock, and a level chosen
//! by its error. Covers cells that are skipped, kept levels, cameras that stand still and characters
//! that are listed as moved.

use crate::crowd::{fixed_figure, model, with_cache};
use articula_core::crowd::{
    CacheUse, ClipState, Crowd, CrowdEvent, CrowdModel, Culling, Detail, Frame, Moved,
};
use articula_core::visibility::{Bodies, CullResult, View, Visibility, cull};
use articula_core::{Camera, Sphere, Viewport};
use glam::{Quat, Vec3};
use proptest::prelude::*;

/// Characters in a row of the grid, a little more than a cell.
const ROW: usize = 70;
const COUNT: usize = 10 * ROW;

/// Step of the camera and of some characters.
#[derive(Debug, Clone)]
struct Step {
    /// `None`: the camera stands still.
    camera: Option<(Vec3, f32)>,
    moved: Vec<(usize, Vec3)>,
    px: f32,
    margin: f32,
}

fn step() -> impl Strategy<Value = Step> {
    let place = |size: f32| prop::array::uniform3(-size..size).prop_map(Vec3::from);
    let camera = prop::option::of((place(60.0), -3.2f32..3.2));
    // Coordinates with few bits, so that they are carried without rounding.
    let coordinate = -400..400;
    let place =
        prop::array::uniform3(coordinate).prop_map(|c| Vec3::from(c.map(|c| c as f32 / 8.0)));
    let moved = prop::collection::vec((0..COUNT, place), 0..4);
    let px = prop_oneof![3 => Just(1.0f32), 1 => 0.2f32..6.0];
    let margin = prop_oneof![Just(0.0f32), 0.0f32..9.0];
    (camera, moved, px, margin).prop_map(|(camera, moved, px, margin)| Step {
        camera,
        moved,
        px,
        margin,
    })
}

/// A centimetre for each level, and half of one for a cached pose.
fn plain_level(model: &CrowdModel, tolerance: f32, shown: Option<usize>) -> usize {
    let coarsest = model.parts().clips.joint_lods().levels() - 1;
    let error = |level: usize| 0.01 * level as f32;
    let mut level = shown.unwrap_or(0);
    while level > 0 && error(level) > tolerance {
        level -= 1;
    }
    if shown.is_none_or(|shown| shown == level) {
        let part = if shown.is_some() { 0.8 } else { 1.0 };
        while level < coarsest && error(level + 1) <= part * tolerance {
            level += 1;
        }
    }
    level
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_crowd_shows_what_each_character_alone_would(
        steps in prop::collection::vec(step(), 1..14),
        two_views in any::<bool>(),
        lists in any::<bool>(),
    ) {
        let (rig, clips, sets) = fixed_figure();
        let model = model(&rig, &clips, &sets);
        let duration = clips[0].duration_secs();
        let mut positions: Vec<Vec3> = (0..COUNT)
            .map(|i| Vec3::new((i % ROW) as f32 * 1.5 - 50.0, -1.0, 40.0 - 2.0 * (i / ROW) as f32))
            .collect();
        let rotations = vec![Quat::IDENTITY; COUNT];
        let mut crowd = Crowd::new(&model, COUNT);
        let mut secs: Vec<f32> = (0..COUNT).map(|i| (i as f32 * 0.011) % duration).collect();
        let speed = |i: usize| [1.0, 0.5, -1.0, 2.0][i % 4];
        for (i, secs) in secs.iter().enumerate() {
            let state = ClipState::new(&model, 0).at_secs(&model, *secs).at_speed(speed(i));
            crowd.play(i, state.into());
        }
        let mut camera = (Vec3::new(0.0, 0.5, 60.0), 0.0);
        let mut levels: Vec<Option<usize>> = vec![None; COUNT];
        let mut is_first = true;
        for step in &steps {
            camera = step.camera.unwrap_or(camera);
            let mut moved = Vec::new();
            for (character, place) in &step.moved {
                positions[*character] = *place;
                moved.push(*character as u32);
            }
            let camera = Camera {
                eye: camera.0,
                orientation: Quat::from_rotation_y(camera.1),
                viewport: Viewport::default(),
            };
            let behind = Camera { orientation: camera.orientation * Quat::from_rotation_y(2.0), ..camera };
            let views = [&camera, &behind].map(|c| View::of(c).with_cull_margin(step.margin, 0.05 * step.margin));
            let views = &views[..if two_views { 2 } else { 1 }];
            let frame = Frame {
                dt_secs: 1.0 / 32.0,
                positions: &positions,
                rotations: &rotations,
                moved: if lists && !is_first { Moved::These(&moved) } else { Moved::All },
                scales: &[],
                cull_margin_metres: &[],
                importance: &[],
                culling: Culling::Views(views),
                detail: Detail::Tolerance { px: step.px },
                cache: CacheUse::Never,
            };
            is_first = false;
            let mut told = Vec::new();
            let report = crowd.tick(&model, &frame, &mut |event| {
                if let CrowdEvent::Level { character, from, to, .. } = event {
                    told.push((character, from, to));
                }
            });
            let bounds: Vec<Sphere> = positions
                .iter()
                .map(|p| Sphere { centre: *p + Vec3::Y, radius: 1.2 })
                .collect();
            let mut seen = vec![CullResult::default(); COUNT];
            cull(views, Bodies::new(&bounds, &[0.0; COUNT]).unwrap(), &mut seen);
            let mut changes = Vec::new();
            for c in 0..COUNT {
                let next = secs[c] + speed(c) / 32.0;
                secs[c] = if (0.0..duration).contains(&next) {
                    next
                } else {
                    (next - (next / duration).floor() * duration).clamp(0.0, duration)
                };
                prop_assert_eq!(crowd.state(c).clip_state().secs(), secs[c]);
                let found = crowd.cull_result(c);
                prop_assert_eq!(found.visibility, seen[c].visibility, "character {}", c);
                let ratio = found.pixels_per_metre / seen[c].pixels_per_metre.max(1e-30);
                let both_zero = found.pixels_per_metre == 0.0 && seen[c].pixels_per_metre == 0.0;
                prop_assert!(both_zero || (ratio - 1.0).abs() < 1e-4, "character {}: {}", c, ratio);
                let now = crowd.level(c);
                prop_assert_eq!(now.is_some(), seen[c].visibility == Visibility::Visible);
                if let Some(level) = now {
                    let tolerance = step.px / seen[c].pixels_per_metre;
                    // Rounding may decide at the borders.
                    let either = [0.9999, 1.0001].map(|f| plain_level(&model, tolerance * f, levels[c]));
                    prop_assert!(either.contains(&level), "character {}: {}, not {:?}", c, level, either);
                }
                if now != levels[c] {
                    changes.push((c, levels[c], now));
                }
                levels[c] = now;
            }
            prop_assert_eq!(told, changes);
            let count = |v: Visibility| seen.iter().filter(|s| s.visibility == v).count();
            prop_assert_eq!(report.visible, count(Visibility::Visible));
            prop_assert_eq!(report.in_margin, count(Visibility::Margin));
            let exact = (0..COUNT).filter_map(|c| Some(0.01 * levels[c]? as f32 * seen[c].pixels_per_metre));
            let exact = exact.fold(0.0, f32::max);
            prop_assert!(report.bound_px >= exact * 0.9999 && report.bound_px <= step.px * 1.0001);
            // By level, and in the order of the characters.
            let mut expected: Vec<(usize, usize)> = (0..COUNT).filter_map(|c| Some((levels[c]?, c))).collect();
            expected.sort_unstable();
            let list = crowd.draw_list();
            let draws = list.groups.iter().flat_map(|g| {
                let draws = list.draws[g.range.clone()].iter();
                draws.map(|d| (g.level, d.character as usize))
            });
            prop_assert_eq!(draws.collect::<Vec<_>>(), expected);
        }
    }
}

/// The cache is a further option; all that is kept must be what a new choice would be.
#[test]
fn kept_options_are_those_of_a_new_choice() {
    let (rig, clips, sets) = fixed_figure();
    let model = with_cache(model(&rig, &clips, &sets));
    let place = |i: usize| Vec3::new((i % 40) as f32 - 20.0, -1.0, -4.0 - 4.0 * (i / 40) as f32);
    let positions: Vec<Vec3> = (0..1000).map(place).collect();
    let rotations = vec![Quat::IDENTITY; 1000];
    for cache in [CacheUse::Never, CacheUse::Cpu, CacheUse::Gpu] {
        let mut crowd = Crowd::new(&model, 1000);
        for step in 0..40 {
            let eye = Vec3::new(0.0, 0.0, 0.25 * step as f32);
            let views = [View::of(&Camera::looking_at(
                eye,
                eye + Vec3::NEG_Z,
                Viewport::default(),
            ))];
            let frame = Frame {
                dt_secs: 0.0,
                positions: &positions,
                rotations: &rotations,
                moved: if step == 0 {
                    Moved::All
                } else {
                    Moved::These(&[])
                },
                scales: &[],
                cull_margin_metres: &[],
                importance: &[],
                culling: Culling::Views(&views),
                detail: Detail::Tolerance { px: 3.0 },
                cache,
            };
            let kept = crowd.tick(&model, &frame, &mut |_| {});
            let new = Crowd::new(&model, 1000).tick(&model, &frame, &mut |_| {});
            assert_eq!(kept.visible, new.visible);
            assert!(kept.bound_px <= 3.0 + 1e-4);
            // Who moves away keeps a finer option until the next is within eight tenths.
            assert!(kept.work.fk_joints >= new.work.fk_joints, "step {step}");
        }
    }
}
