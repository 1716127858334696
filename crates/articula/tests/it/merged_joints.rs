//! Files with fewer joints in their skins: which are merged, what follows them, and the error that is told.

use articula::core::Transform;
use articula::core::source::{
    Channel, Character, Interpolation, Joint, Primitive, Property, RawClip, RawMesh, Skeleton, Skin,
};
use articula::glam::{Affine3A, Quat, Vec3};
use articula::human::HumanOptions;
use articula::optimize::{
    ErrorBound, Fit, OptimizeLimits, OptimizeOptions, Optimized, optimize, optimize_to_fit,
};
use articula::{CharacterFile, Executor, Format, OpenOptions, convert, open};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

fn options() -> OptimizeOptions {
    OptimizeOptions {
        error: ErrorBound::Metres(1e-3),
        simplify: false,
        ..OptimizeOptions::default()
    }
}

fn fitted(source: &CharacterFile, max_joints: usize) -> articula::Result<(Optimized, Fit)> {
    let limits = OptimizeLimits {
        max_joints: Some(max_joints),
        ..OptimizeLimits::default()
    };
    optimize_to_fit(source, &options(), &limits, &Executor::default())
}

fn read(bytes: &[u8]) -> CharacterFile {
    let beside = &mut |uri: &str| Err(format!("{uri} does not lie beside it"));
    open(bytes, "file.glb", &OpenOptions::default(), beside).unwrap()
}

fn file(character: Character) -> CharacterFile {
    let opened = CharacterFile::from_character("file", character);
    read(&convert::write(&opened, Format::Glb).unwrap().bytes)
}

/// Three joints a metre apart along x. The last carries the vertex a metre beyond it, shares one with the
/// joint above, and turns by a right angle; that one turns by half of it.
fn arm() -> Character {
    let joint = |name: &str, parent: Option<usize>| Joint {
        name: name.to_owned(),
        parent,
        rest: Transform::from_translation(match parent {
            Some(_) => Vec3::X,
            None => Vec3::ZERO,
        }),
        in_skin: true,
    };
    let turn = |target: usize, angle: f32| Channel {
        target,
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times_secs: vec![0.0, 1.0],
        values: [Quat::IDENTITY, Quat::from_rotation_z(angle)]
            .iter()
            .flat_map(|q| q.to_array())
            .collect(),
    };
    let at = |x: f32| Affine3A::from_translation(-x * Vec3::X);
    Character {
        skeleton: Skeleton {
            joints: vec![
                joint("root", None),
                joint("arm", Some(0)),
                joint("hand", Some(1)),
            ],
        },
        meshes: vec![RawMesh {
            name: "arm".to_owned(),
            skin: Skin {
                joints: vec![0, 1, 2],
                inverse_bind: vec![at(0.0), at(1.0), at(2.0)],
            },
            primitives: vec![Primitive {
                positions: vec![Vec3::ZERO, Vec3::new(2.0, 0.5, 0.0), 3.0 * Vec3::X],
                normals: vec![Vec3::Z; 3],
                influences: 2,
                joints: vec![0, 0, 1, 2, 2, 0],
                weights: vec![1.0, 0.0, 0.5, 0.5, 1.0, 0.0],
                triangles: vec![[0, 2, 1]],
                ..Primitive::default()
            }],
            ..RawMesh::default()
        }],
        clips: vec![RawClip {
            name: "wave".to_owned(),
            duration_secs: 1.0,
            channels: vec![turn(1, FRAC_PI_4), turn(2, FRAC_PI_2)],
        }],
        ..Character::default()
    }
}

#[test]
fn a_merged_joint_stays_a_node_at_rest_and_its_skin_follows_the_one_above() {
    let source = file(arm());
    let (made, fit) = fitted(&source, 2).unwrap();
    assert_eq!(fit.too_large_at_mm, None);
    let merged = made.report.merged_joints.clone().unwrap();
    assert_eq!((merged.joints_in, merged.joints_out), (3, 2));
    assert_eq!(merged.merged, ["hand"]);
    // The vertex a metre from the hand misses a right angle.
    let metres = 1e-3 * merged.error_mm;
    assert!((metres - 2.0f32.sqrt()).abs() < 1e-4, "{metres}");
    assert!(made.report.error_mm <= 1.0);

    let shown = read(&made.glb).into_character();
    let mesh = &shown.meshes[0];
    let names: Vec<&str> = mesh
        .skin
        .joints
        .iter()
        .map(|j| shown.skeleton.joints[*j].name.as_str())
        .collect();
    assert_eq!(names, ["root", "arm"]);
    for (v, position) in mesh.primitives[0].positions.iter().enumerate() {
        let first = v * mesh.primitives[0].influences;
        let of = first..first + mesh.primitives[0].influences;
        let influences = mesh.primitives[0].joints[of.clone()].iter();
        let weights = influences.zip(&mesh.primitives[0].weights[of]);
        let of_arm: f32 = weights.filter(|(j, _)| **j == 1).map(|(_, w)| w).sum();
        assert_eq!(of_arm, if position.x > 1.0 { 1.0 } else { 0.0 });
    }
    // The joint above still turns.
    let moving: Vec<&str> = shown.clips[0]
        .channels
        .iter()
        .map(|c| shown.skeleton.joints[c.target].name.as_str())
        .collect();
    assert_eq!(moving, ["arm"]);
    let length = u32::from_le_bytes(made.glb[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&made.glb[20..20 + length]).unwrap();
    let nodes = json["nodes"].as_array().unwrap();
    assert!(nodes.iter().any(|node| node["name"] == "hand"));
}

#[test]
fn no_joint_is_merged_that_need_not_be_and_impossible_numbers_are_told() {
    let source = file(arm());
    let (whole, _) = fitted(&source, 3).unwrap();
    assert_eq!(whole.report.merged_joints, None);
    let usual = optimize(&source, &options(), &Executor::default()).unwrap();
    assert_eq!(whole.glb, usual.glb);
    let (one, _) = fitted(&source, 1).unwrap();
    assert_eq!(one.report.merged_joints.unwrap().merged, ["hand", "arm"]);
    let refused = fitted(&source, 0).unwrap_err().to_string();
    assert!(
        refused.contains("the skins have 3, allowed are 0, 1 are the fewest"),
        "{refused}"
    );
}

#[test]
fn a_human_with_fewer_joints_has_the_least_error_that_the_number_allows() {
    let mut character = articula::human::human(&HumanOptions::mannequin(2000)).unwrap();
    character.clips.truncate(1);
    let source = file(character);
    let skinned = |character: &Character| {
        let joints = character.skeleton.joints.iter();
        joints.filter(|joint| joint.in_skin).count()
    };
    let mut errors = Vec::new();
    for max in [40, 16] {
        let (made, _) = fitted(&source, max).unwrap();
        let merged = made.report.merged_joints.clone().unwrap();
        assert_eq!(merged.joints_in, skinned(source.character()));
        assert_eq!(merged.joints_out, max);
        assert_eq!(skinned(read(&made.glb).character()), max);
        errors.push(merged.error_mm);
    }
    assert!(0.0 < errors[0] && errors[0] < errors[1], "{errors:?}");
}
