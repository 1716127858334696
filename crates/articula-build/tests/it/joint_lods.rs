//! Properties of merged levels, on random rigs, skins and clips.

use crate::random_figure::{FRAMES, RATE, Row, character_of, flat, rows};
use crate::reference_human::asset_of_4000;
use articula_build::ClipOptions;
use articula_build::{Asset, character};
use articula_build::{
    JointLodOptions, MergedLevels, joint_lods, level_skins, lod_errors, mean_pose, merged_levels,
    named_joint_lods,
};
use articula_core::loa::LoaExpression;
use articula_core::source::{
    Channel, Character, Interpolation, Joint, Property, RawClip, Skeleton,
};
use articula_core::{
    JointLods, JointSet, LevelSkins, LocalPose, Mesh, ModelPose, PosedMesh, SkinnedMesh, Transform,
    Wrap, local_to_model, sample,
};
use glam::{Quat, Vec3};
use proptest::prelude::*;

/// Rounding of f32 positions of up to some metres, after several products.
const ROUNDING_METRES: f32 = 5e-5;

fn asset(rows: &[Row]) -> Asset {
    let source = character_of(rows);
    let opts = ClipOptions {
        rate_hz: Some(RATE),
    };
    character(&source, Some(flat(rows.len())), &opts).unwrap()
}

fn options() -> JointLodOptions {
    JointLodOptions {
        min_joints: 1,
        first_metres: 1e-3,
        ..JointLodOptions::default()
    }
}

fn posed(asset: &Asset, mesh: &Mesh, pose: &LocalPose) -> SkinnedMesh {
    let mut posed = PosedMesh::new(&asset.rig, mesh);
    posed.pose(pose).skinned(&mesh.morph_weights)
}

fn at_frame(asset: &Asset, frame: usize) -> LocalPose {
    let mut pose = asset.rig.rest_pose().clone();
    let secs = frame as f64 / f64::from(RATE);
    sample(
        &asset.clips[0],
        secs,
        Wrap::Clamp,
        &asset.rig.all(),
        &mut pose,
    );
    pose
}

fn model(asset: &Asset, pose: &LocalPose) -> ModelPose {
    let mut model = ModelPose::new(asset.rig.len());
    local_to_model(&asset.rig, pose, &mut model);
    model
}

fn farthest(a: &SkinnedMesh, b: &SkinnedMesh) -> f32 {
    let all = a.positions.iter().zip(&b.positions);
    all.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

/// Every prefix of the joint order as a level, up to the maximum number of levels.
fn all_prefixes(asset: &Asset) -> JointLods {
    let mean = mean_pose(asset);
    let joint_lods = joint_lods(asset, &mean, &options()).unwrap();
    let kept = (1..=asset.rig.len() as u16).rev().collect();
    JointLods::new(&asset.rig, joint_lods.joints().to_vec(), kept, &mean).unwrap()
}

fn check_palette(joint_lods: &JointLods, skins: &LevelSkins) {
    for (level, skin) in skins.levels.iter().enumerate() {
        let inside = |b: &u16| usize::from(*b) < skin.palette;
        assert!(
            skin.binding_indices.iter().all(inside),
            "a prefix is enough"
        );
        assert_eq!(skin.palette, skins.palette.len(level));
        let joints = skins.bindings[..skin.palette]
            .iter()
            .map(|b| usize::from(b.joint));
        for joint in joints {
            assert!(joint_lods.place(joint) < joint_lods.joint_count(level));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_mean_pose_is_exact_at_every_level(rows in rows()) {
        let asset = asset(&rows);
        let joint_lods = all_prefixes(&asset);
        let skins = level_skins(&asset, &joint_lods, &options()).unwrap();
        check_palette(&joint_lods, &skins);
        let mean = mean_pose(&asset);
        let truth = posed(&asset, &asset.mesh, &mean);
        for level in 0..joint_lods.levels() {
            let shown = posed(&asset, &skins.mesh(level, &asset.mesh), &mean);
            let apart = farthest(&truth, &shown);
            prop_assert!(apart < ROUNDING_METRES, "level {level}: {apart} m");
            for (t, s) in truth.normals.iter().zip(&shown.normals) {
                prop_assert!(t.dot(*s) > 0.999, "level {level}: {t} {s}");
            }
        }
    }

    #[test]
    fn the_first_level_is_the_character(rows in rows(), frame in 0..FRAMES) {
        let asset = asset(&rows);
        let levels = merged_levels(&asset, &options()).unwrap();
        let mesh = levels.skins.mesh(0, &asset.mesh);
        prop_assert_eq!(&mesh.positions, &asset.mesh.positions);
        let pose = at_frame(&asset, frame);
        let apart = farthest(&posed(&asset, &asset.mesh, &pose), &posed(&asset, &mesh, &pose));
        prop_assert_eq!(apart, 0.0);
        levels.errors.check(1, levels.joint_lods.levels()).unwrap();
    }

    #[test]
    fn errors_are_what_the_skins_show(rows in rows()) {
        let asset = asset(&rows);
        let joint_lods = all_prefixes(&asset);
        let skins = level_skins(&asset, &joint_lods, &options()).unwrap();
        let errors = lod_errors(&asset, &joint_lods, &skins, &options()).unwrap();
        let mut worst = 0.0f32;
        for level in 0..joint_lods.levels() {
            let mesh = skins.mesh(level, &asset.mesh);
            for frame in 0..FRAMES {
                let pose = at_frame(&asset, frame);
                let truth = posed(&asset, &asset.mesh, &pose);
                worst = worst.max(farthest(&truth, &posed(&asset, &mesh, &pose)));
            }
            let found = errors.clips[0].worst_metres[level];
            prop_assert!((found - worst).abs() < 1e-5, "level {level}: {found} for {worst}");
            prop_assert!(errors.clips[0].levels_metres[level] <= found);
        }
    }

    #[test]
    fn far_levels_follow_the_clip_and_keep_the_mean_pose(rows in rows()) {
        let asset = asset(&rows);
        let opts = JointLodOptions {
            far_from_metres: 0.0,
            ..options()
        };
        let levels = merged_levels(&asset, &opts).unwrap();
        let Some(far) = &levels.far else {
            return Ok(());
        };
        let all = levels.joint_lods.levels() + far.joint_lods.levels();
        levels.errors.check(1, all).unwrap();
        let far_asset = Asset {
            rig: far.rig.clone().into(),
            mesh: Mesh::default().into(),
            clips: far.clips.clone(),
        };
        let mut worst = vec![0.0f32; far.joint_lods.levels()];
        for frame in 0..FRAMES {
            let [full, near] = [&asset, &far_asset].map(|a| at_frame(a, frame));
            let [model, far_model] = [(&asset, &full), (&far_asset, &near)].map(|(a, p)| model(a, p));
            for (place, joint) in far.joints.iter().enumerate() {
                let (t, s) = (model.matrices[usize::from(*joint)], far_model.matrices[place]);
                prop_assert!(t.abs_diff_eq(s, ROUNDING_METRES), "{t} {s}");
            }
            let truth = posed(&asset, &asset.mesh, &full);
            for (level, worst) in worst.iter_mut().enumerate() {
                let shown = posed(&far_asset, &far.skins.mesh(level, &asset.mesh), &near);
                *worst = worst.max(farthest(&truth, &shown));
            }
        }
        for (level, worst) in worst.iter().enumerate() {
            let found = levels.errors.clips[0].worst_metres[levels.joint_lods.levels() + level];
            prop_assert!(found + ROUNDING_METRES >= *worst, "{found} for {worst}");
        }
        check_palette(&far.joint_lods, &far.skins);
        let truth = posed(&asset, &asset.mesh, &mean_pose(&asset));
        let at = |j: usize| far.joint_lods.mean()[far.joint_lods.place(j)];
        let far_mean: LocalPose = (0..far.rig.len()).map(at).collect();
        for level in 0..far.joint_lods.levels() {
            let shown = posed(&far_asset, &far.skins.mesh(level, &asset.mesh), &far_mean);
            prop_assert!(farthest(&truth, &shown) < ROUNDING_METRES);
        }
    }
}

/// The sample of vertices decides about the percentile alone: every vertex of a character is within
/// the maximum at every frame, and one of them is at it.
#[test]
fn the_maximum_is_that_of_every_vertex_at_every_frame() {
    let asset = asset_of_4000();
    let few = JointLodOptions {
        vertices: 50,
        ..JointLodOptions::default()
    };
    let levels = merged_levels(asset, &few).unwrap();
    assert!(levels.joint_lods.levels() > 3);
    for (clip, errors) in asset.clips.iter().zip(&levels.errors.clips) {
        let mut worst = 0.0f32;
        for level in 0..levels.joint_lods.levels() {
            let mesh = levels.skins.mesh(level, &asset.mesh);
            let [mut full, mut reduced] =
                [&asset.mesh, &mesh].map(|m| PosedMesh::new(&asset.rig, m));
            for frame in 0..clip.frames() {
                let secs = frame as f64 / f64::from(clip.rate_hz());
                let weights = &asset.mesh.morph_weights;
                let truth = full.pose_at(clip, secs, Wrap::Clamp).skinned(weights);
                let shown = reduced.pose_at(clip, secs, Wrap::Clamp).skinned(weights);
                worst = worst.max(farthest(&truth, &shown));
            }
            let told = errors.worst_metres[level];
            assert!(
                (told - worst).abs() < 1e-5,
                "level {level} of {}: {told} m for {worst}",
                clip.name
            );
        }
    }
}

/// A character from joints and one clip in which some of them turn.
fn figure(joints: Vec<Joint>, turning: &[usize], frames: usize) -> Character {
    let times: Vec<f32> = (0..frames).map(|i| i as f32 / RATE).collect();
    let channel = |&joint: &usize| Channel {
        target: joint,
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times_secs: times.clone(),
        values: (0..frames)
            .flat_map(|i| Quat::from_rotation_z(0.1 * (i + joint) as f32).to_array())
            .collect(),
    };
    Character {
        skeleton: Skeleton { joints },
        clips: vec![RawClip {
            name: "c".into(),
            duration_secs: times[frames - 1],
            channels: turning.iter().map(channel).collect(),
        }],
        ..Character::default()
    }
}

fn joint(parent: Option<usize>, rest: Transform) -> Joint {
    Joint {
        name: String::new(),
        parent,
        rest,
        in_skin: true,
    }
}

fn built(source: &Character) -> Asset {
    let flat = flat(source.skeleton.joints.len());
    character(source, Some(flat), &ClipOptions::default()).unwrap()
}

fn prepared(asset: &Asset, far_from_metres: f32) -> MergedLevels {
    let opts = JointLodOptions {
        far_from_metres,
        ..JointLodOptions::default()
    };
    let levels = merged_levels(asset, &opts).unwrap();
    let far = levels.far.as_ref().map_or(0, |f| f.joint_lods.levels());
    let all = levels.joint_lods.levels() + far;
    levels.errors.check(asset.clips.len(), all).unwrap();
    assert!(all <= opts.max_levels);
    levels
}

#[test]
fn the_smallest_characters_have_one_level() {
    let one = figure(vec![joint(None, Transform::IDENTITY)], &[0], 5);
    for far in [0.0, f32::INFINITY] {
        let levels = prepared(&built(&one), far);
        assert_eq!((levels.joint_lods.levels(), levels.far), (1, None));
        assert!(levels.errors.clips[0].speed_metres_per_sec >= 0.0);
    }
    let still = figure(vec![joint(None, Transform::IDENTITY)], &[0], 1);
    let levels = prepared(&built(&still), 0.0);
    let clip = &levels.errors.clips[0];
    assert_eq!((clip.speed_metres_per_sec, clip.seam_metres), (0.0, 0.0));
    let silent = Character {
        clips: Vec::new(),
        ..one
    };
    assert!(prepared(&built(&silent), 0.0).errors.clips.is_empty());
}

#[test]
fn a_thousand_joints_without_mesh_and_two_trees() {
    let up = Transform::from_translation(Vec3::Y * 0.01);
    let parent = |j: usize| match j {
        0 | 500 => None,
        j => Some(j - 1 - (j % 7).min(j % 500 - 1) / 2),
    };
    let joints = (0..1000).map(|j| joint(parent(j), up)).collect();
    let turning: Vec<usize> = (0..1000).step_by(3).collect();
    let asset = built(&figure(joints, &turning, 40));
    for far in [0.01, f32::INFINITY] {
        let levels = prepared(&asset, far);
        assert_eq!(levels.joint_lods.joint_count(0), 1000);
        assert!(levels.skins.bindings.is_empty());
    }
}

#[test]
fn mirrored_and_vanishing_scales_stay_finite() {
    let scaled = |scale| Transform {
        scale,
        ..Transform::from_translation(Vec3::Y * 0.3)
    };
    let scales = [
        Vec3::ONE,
        Vec3::new(1.0, -1.0, 1.0),
        Vec3::splat(2.0),
        Vec3::ZERO,
        Vec3::new(1.0, 0.2, 3.0),
    ];
    let chain = scales.iter().enumerate();
    let joints = chain
        .map(|(j, s)| joint(j.checked_sub(1), scaled(*s)))
        .collect();
    let asset = built(&figure(joints, &[1, 2, 4], 20));
    for far in [0.0, f32::INFINITY] {
        let opts = JointLodOptions {
            min_joints: 1,
            far_from_metres: far,
            ..JointLodOptions::default()
        };
        let levels = merged_levels(&asset, &opts).unwrap();
        let errors = &levels.errors.clips[0].worst_metres;
        assert!(errors.iter().all(|e| e.is_finite()));
    }
}

#[test]
fn sockets_and_named_levels_are_kept() {
    let up = Transform::from_translation(Vec3::Y * 0.1);
    let joints = (0..20).map(|j: usize| joint(j.checked_sub(1).map(|p| p / 2), up));
    let asset = built(&figure(joints.collect(), &[1, 2, 3, 9], 20));
    let attachment = JointSet::from_iter([19]);
    for far_from_metres in [0.0, f32::INFINITY] {
        let opts = JointLodOptions {
            protected: attachment,
            min_joints: 3,
            far_from_metres,
            ..JointLodOptions::default()
        };
        let levels = merged_levels(&asset, &opts).unwrap();
        let coarsest = levels
            .joint_lods
            .joint_count(levels.joint_lods.levels() - 1);
        assert!(
            [0, 19]
                .iter()
                .all(|j| levels.joint_lods.place(*j) < coarsest)
        );
        if let Some(far) = levels.far {
            let least = far.joint_lods.joint_count(far.joint_lods.levels() - 1);
            assert!(far.joints[..least].contains(&19));
        }
    }
    let named: Vec<LoaExpression> = ["depth(3)", "depth(1)"]
        .iter()
        .map(|e| e.parse::<LoaExpression>().unwrap())
        .collect();
    let joint_lods = named_joint_lods(&asset, &mean_pose(&asset), &named).unwrap();
    let kept: Vec<usize> = (0..joint_lods.levels())
        .map(|l| joint_lods.joint_count(l))
        .collect();
    assert_eq!(kept[0], 20);
    assert_eq!(kept[2], 1);
    let wrong = ["joint(nobody)".parse::<LoaExpression>().unwrap()];
    let at = named_joint_lods(&asset, &mean_pose(&asset), &wrong)
        .unwrap_err()
        .at;
    assert_eq!(at, "levels[0]");
}
