//! Properties of batched evaluation: all backends give the same bits, within a stated bound of the
//! plain path, at every level, in every form, for full and partly filled batches, without
//! allocation.

use crate::random_rig::{Options, figure};
use articula_core::batch::{BatchEvaluator, BatchPose, MAX_LANES};
use articula_core::{
    Backend, Clip, ClipSet, ClipStorage, JointLods, ModelPose, PaletteForm, PaletteMap,
    PaletteRows, Rig, Wrap, blend, f32_from_half, local_to_model, sample,
};
use glam::{Affine3A, Quat, Vec3};
use proptest::prelude::*;

/// Bound in metres of the distance to the plain path for a chain of 24 joints, two metres long and
/// scaled up to twice: each rotation is unit to a few parts in 1e7.
const BOUND_METRES: f32 = 4e-5;

/// State of one character: first clip and its time, second clip and its time, weight of the second.
type Play = (usize, f32, usize, f32, f32);

fn play() -> impl Strategy<Value = Play> {
    let fade = prop_oneof![Just(0.0f32), 0.0f32..1.0];
    (0usize..2, -0.1f32..2.0, 0usize..2, -0.1f32..2.0, fade)
}

/// Model matrices of all joints by the plain path.
fn plain(rig: &Rig, clips: &[Clip], (a, ta, b, tb, fade): Play) -> ModelPose {
    let at = |clip: usize, secs: f32| {
        let mut pose = rig.rest_pose().clone();
        sample(
            &clips[clip],
            f64::from(secs),
            Wrap::Clamp,
            &rig.all(),
            &mut pose,
        );
        pose
    };
    let mut pose = at(a, ta);
    if fade != 0.0 {
        blend(&mut pose, &at(b, tb), fade, &rig.all());
    }
    let mut model = ModelPose::new(rig.len());
    local_to_model(rig, &pose, &mut model);
    model
}

fn shown(set: &ClipSet, (a, ta, b, tb, fade): Play) -> BatchPose {
    BatchPose {
        from: set.cursor(a, ta),
        to: set.cursor(b, tb),
        fade,
    }
}

/// Greatest distance between the images under two matrices of points within 1 m of the origin.
fn apart(a: &Affine3A, b: &Affine3A) -> f32 {
    [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .map(|p| a.transform_point3(p).distance(b.transform_point3(p)))
        .fold(0.0, f32::max)
}

fn matrix(rows: &[[f32; 4]]) -> Affine3A {
    let column = |c: usize| Vec3::new(rows[0][c], rows[1][c], rows[2][c]);
    Affine3A::from_cols(
        column(0).into(),
        column(1).into(),
        column(2).into(),
        column(3).into(),
    )
}

fn rigid(rows: &[[f32; 4]]) -> Affine3A {
    let t = Vec3::new(rows[1][0], rows[1][1], rows[1][2]);
    Affine3A::from_rotation_translation(Quat::from_array(rows[0]), t)
}

/// Bindings for every second joint, with a matrix that rotates, translates and scales.
fn bindings(joint_lods: &JointLods, scale: f32) -> Vec<(u16, Affine3A)> {
    (0..joint_lods.joints().len() as u16)
        .step_by(2)
        .map(|place| {
            let turn = Quat::from_rotation_z(f32::from(place) * 0.3);
            let offset = Vec3::new(0.1, -0.2, 0.05) * f32::from(place % 3);
            let scale = Vec3::splat(scale);
            (
                place,
                Affine3A::from_scale_rotation_translation(scale, turn, offset),
            )
        })
        .collect()
}

/// Evaluates into f32 rows, for any form.
/// Those of this machine, and the one with sixteen lanes, which plain arrays replace elsewhere.
fn backends() -> impl Iterator<Item = Backend> {
    let has = |b: &Backend| b.is_available() || *b == Backend::Avx512;
    Backend::ALL.into_iter().filter(has)
}

fn evaluated(
    set: &ClipSet,
    map: &PaletteMap,
    (form, backend): (PaletteForm, Backend),
    level: usize,
    shown: &[BatchPose],
) -> Vec<[f32; 4]> {
    let evaluator = BatchEvaluator::new(set, map, form, backend).unwrap();
    let mut scratch = evaluator.scratch();
    let mut all = Vec::new();
    for shown in shown.chunks(evaluator.lanes()) {
        let len = evaluator.rows(level) * shown.len();
        let (mut halves, mut floats) = (vec![[0u16; 4]; len], vec![[0f32; 4]; len]);
        if form.is_half() {
            evaluator.evaluate(level, shown, PaletteRows::Half(&mut halves), &mut scratch);
            all.extend(halves.iter().map(|row| row.map(f32_from_half)));
        } else {
            evaluator.evaluate(level, shown, PaletteRows::Float(&mut floats), &mut scratch);
            all.extend(floats);
        }
    }
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn every_backend_level_and_form_follows_the_plain_path(
        (rig, clips, sets) in figure(Options { scaled: true, steps: true }),
        plays in prop::collection::vec(play(), 1..=MAX_LANES + 1),
    ) {
        let joint_lods = JointLods::of_sets(&rig, &sets, rig.rest_pose()).unwrap();
        let set = ClipSet::new(&rig, joint_lods.clone(), &clips, ClipStorage::Float).unwrap();
        let shown: Vec<BatchPose> = plays.iter().map(|p| shown(&set, *p)).collect();
        let truth: Vec<ModelPose> = plays.iter().map(|p| plain(&rig, &clips, *p)).collect();
        let skin = bindings(&joint_lods, 1.5);
        let maps = [PaletteMap::joints(&joint_lods), PaletteMap::skin(&joint_lods, &skin).unwrap()];
        for (map, level) in maps.iter().flat_map(|m| (0..joint_lods.levels()).map(move |l| (m, l))) {
            let float = evaluated(&set, map, (PaletteForm::Matrix, Backend::Scalar), level, &shown);
            for (i, rows) in float.chunks(3).enumerate() {
                let (character, entry) = (i / map.len(level), i % map.len(level));
                let place = if map == &maps[1] { usize::from(skin[entry].0) } else { entry };
                let joint = usize::from(joint_lods.joints()[place]);
                let mut expected = truth[character].matrices[joint];
                if map.len(0) == skin.len() && map == &maps[1] {
                    expected *= skin[entry].1;
                }
                let off = apart(&matrix(rows), &expected);
                prop_assert!(off < BOUND_METRES, "{off} m at joint {joint}, level {level}");
            }
            let half = evaluated(&set, map, (PaletteForm::HalfMatrix, Backend::Scalar), level, &shown);
            for (a, b) in float.iter().flatten().zip(half.iter().flatten()) {
                prop_assert!((a - b).abs() <= a.abs() / 2048.0 + 6e-8, "{a} as half is {b}");
            }
            for backend in backends() {
                for (form, expected) in [(PaletteForm::Matrix, &float), (PaletteForm::HalfMatrix, &half)] {
                    let rows = evaluated(&set, map, (form, backend), level, &shown);
                    prop_assert_eq!(&rows, expected, "{} differs", backend);
                }
            }
        }
    }

    #[test]
    fn rigid_forms_stand_for_the_same_matrices(
        (rig, clips, sets) in figure(Options { scaled: false, steps: false }),
        plays in prop::collection::vec(play(), 1..=MAX_LANES + 1),
    ) {
        let joint_lods = JointLods::of_sets(&rig, &sets, rig.rest_pose()).unwrap();
        let set = ClipSet::new(&rig, joint_lods.clone(), &clips, ClipStorage::Float).unwrap();
        let shown: Vec<BatchPose> = plays.iter().map(|p| shown(&set, *p)).collect();
        let map = PaletteMap::skin(&joint_lods, &bindings(&joint_lods, 1.0)).unwrap();
        let last = joint_lods.levels() - 1;
        for level in [0, last] {
            let best = (PaletteForm::Matrix, Backend::best());
            let matrices = evaluated(&set, &map, best, level, &shown);
            for backend in backends() {
                let rows = evaluated(&set, &map, (PaletteForm::Rigid, backend), level, &shown);
                for (m, r) in matrices.chunks(3).zip(rows.chunks(2)) {
                    prop_assert!(apart(&matrix(m), &rigid(r)) < BOUND_METRES);
                }
                let halves = evaluated(&set, &map, (PaletteForm::HalfRigid, backend), level, &shown);
                for (a, b) in rows.iter().flatten().zip(halves.iter().flatten()) {
                    prop_assert!((a - b).abs() <= a.abs() / 2048.0 + 6e-8);
                }
            }
        }
    }

    #[test]
    fn short_storage_stays_within_its_bound_and_tiles_are_the_same_matrices(
        (rig, clips, _) in figure(Options { scaled: false, steps: false }),
        plays in prop::collection::vec(play(), 1..=MAX_LANES + 1),
    ) {
        let joint_lods = JointLods::whole(&rig).unwrap();
        let float = ClipSet::new(&rig, joint_lods.clone(), &clips, ClipStorage::Float).unwrap();
        let short = ClipSet::new(&rig, joint_lods.clone(), &clips, ClipStorage::Short).unwrap();
        prop_assert_eq!(short.bytes() * 2, float.bytes());
        let map = PaletteMap::joints(&joint_lods);
        let shown_in = |set: &ClipSet| plays.iter().map(|p| shown(set, *p)).collect::<Vec<_>>();
        let best = (PaletteForm::Matrix, Backend::best());
        let wanted = evaluated(&float, &map, best, 0, &shown_in(&float));
        let found = evaluated(&short, &map, best, 0, &shown_in(&short));
        // Each joint rotates its descendants, which reach 2 m at most, and translates them with an
        // error of at most half a step of the translations' range.
        let each = 6.2e-5 * 2.0 + 4.0 / 65534.0;
        for (i, (a, b)) in wanted.chunks(3).zip(found.chunks(3)).enumerate() {
            let chain = rig.len().min(i % rig.len() + 1) as f32;
            let off = apart(&matrix(a), &matrix(b));
            prop_assert!(off < each * chain + BOUND_METRES, "{off} m after {chain} joints");
        }
        for backend in backends() {
            let same = evaluated(&short, &map, (PaletteForm::Matrix, backend), 0, &shown_in(&short));
            prop_assert_eq!(&same, &found);
        }
        for backend in backends() {
            let evaluator = BatchEvaluator::new(&float, &map, PaletteForm::Matrix, backend).unwrap();
            let mut scratch = evaluator.scratch();
            let batches = wanted.chunks(evaluator.lanes() * rig.len() * 3);
            for (shown, wanted) in shown_in(&float).chunks(evaluator.lanes()).zip(batches) {
                let tiles = evaluator.tile(0, shown, &mut scratch);
                for (i, rows) in wanted.chunks(3).enumerate() {
                    let (character, place) = (i / rig.len(), i % rig.len());
                    for (row, lanes) in rows.iter().zip(tiles.matrix(place)) {
                        prop_assert_eq!(*row, lanes.map(|lanes| lanes[character]));
                    }
                }
            }
        }
    }
}

#[test]
fn a_pose_does_not_depend_on_the_others_of_its_batch() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let options = Options {
        scaled: true,
        steps: true,
    };
    let tree = figure(options).new_tree(&mut runner).unwrap();
    let (rig, clips, sets) = proptest::strategy::ValueTree::current(&tree);
    let joint_lods = JointLods::of_sets(&rig, &sets, rig.rest_pose()).unwrap();
    let set = ClipSet::new(&rig, joint_lods, &clips, ClipStorage::Float).unwrap();
    let map = PaletteMap::joints(set.joint_lods());
    // Those that are not blended, among those that are.
    let shown: Vec<BatchPose> = (0..MAX_LANES)
        .map(|i| BatchPose {
            from: set.cursor(0, 0.07 * i as f32),
            to: set.cursor(1, 0.05 * i as f32),
            fade: if i % 3 == 0 { 0.4 } else { 0.0 },
        })
        .collect();
    for backend in backends() {
        let kind = (PaletteForm::Matrix, backend);
        let together = evaluated(&set, &map, kind, 0, &shown);
        let alone = shown
            .iter()
            .flat_map(|shown| evaluated(&set, &map, kind, 0, &[*shown]));
        let bits = |row: [f32; 4]| row.map(f32::to_bits);
        assert!(
            together.into_iter().map(bits).eq(alone.map(bits)),
            "{backend}"
        );
    }
}

#[test]
fn evaluating_allocates_nothing() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let options = Options {
        scaled: false,
        steps: true,
    };
    let tree = figure(options).new_tree(&mut runner).unwrap();
    let (rig, clips, sets) = proptest::strategy::ValueTree::current(&tree);
    let joint_lods = JointLods::of_sets(&rig, &sets, rig.rest_pose()).unwrap();
    let set = ClipSet::new(&rig, joint_lods, &clips, ClipStorage::Float).unwrap();
    let map = PaletteMap::joints(set.joint_lods());
    for backend in backends() {
        let evaluator = BatchEvaluator::new(&set, &map, PaletteForm::Matrix, backend).unwrap();
        let mut scratch = evaluator.scratch();
        let shown = vec![BatchPose::from(set.cursor(0, 0.3)); evaluator.lanes() - 3];
        let mut rows = vec![[0.0; 4]; evaluator.rows(0) * shown.len()];
        let counted = allocation_counter::measure(|| {
            evaluator.evaluate(0, &shown, PaletteRows::Float(&mut rows), &mut scratch);
        });
        assert_eq!(counted.count_total, 0, "{backend}");
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let options = Options {
        scaled: true,
        steps: false,
    };
    let tree = figure(options).new_tree(&mut runner).unwrap();
    let (rig, clips, _) = proptest::strategy::ValueTree::current(&tree);
    let joint_lods = JointLods::whole(&rig).unwrap();
    let set = ClipSet::new(&rig, joint_lods.clone(), &clips, ClipStorage::Float).unwrap();
    let map = PaletteMap::joints(&joint_lods);
    if set.is_scaled() {
        let rigid = BatchEvaluator::new(&set, &map, PaletteForm::Rigid, Backend::Scalar);
        assert_eq!(rigid.unwrap_err().at, "form");
    }
    let none = ClipSet::new(&rig, joint_lods, &[], ClipStorage::Float).unwrap();
    assert_eq!((none.clips(), none.duration_secs(0)), (1, 0.0));
    let at = none.cursor(0, f32::NAN);
    let rest = evaluated(
        &none,
        &map,
        (PaletteForm::Matrix, Backend::best()),
        0,
        &[at.into()],
    );
    let mut model = ModelPose::new(rig.len());
    local_to_model(&rig, rig.rest_pose(), &mut model);
    for (place, rows) in rest.chunks(3).enumerate() {
        let joint = usize::from(set.joint_lods().joints()[place]);
        assert!(apart(&matrix(rows), &model.matrices[joint]) < BOUND_METRES);
    }
}
