//! Small pairs with positions computed by hand.

use super::{AMC, ASF, at_rest, plain, world};
use articula_core::source::{Character, Property};
use articula_formats::acclaim;
use articula_formats::{Limits, joint_map};
use articula_formats::{ReadOptions, UpAxis};
use glam::{Quat, Vec3};

fn place(character: &Character, name: &str, time_secs: f32) -> Vec3 {
    world(character, time_secs)[character.skeleton.find(name).unwrap()]
}

fn near(a: Vec3, b: Vec3) -> bool {
    a.distance(b) < 1e-5
}

#[test]
fn a_leg_and_an_arm() {
    let file = plain(ASF, Some(AMC)).unwrap();
    assert!(file.warnings.is_empty(), "{:?}", file.warnings);
    let file = file.value;
    let character = &file.character;
    assert_eq!(
        (character.name.as_str(), file.frame_time_secs),
        ("TEST", 0.5)
    );
    let joints = &character.skeleton.joints;
    let names: Vec<&str> = joints.iter().map(|j| j.name.as_str()).collect();
    assert_eq!(names, ["root", "joint", "arm", "thigh", "shin"]);
    let parents: Vec<_> = joints.iter().map(|j| j.parent).collect();
    assert_eq!(parents, [None, Some(0), Some(1), Some(0), Some(3)]);

    // A joint is the start of its bone.
    let rest = at_rest(character);
    let wanted = [[0.0, 0.0], [0.0, 0.0], [3.0, 4.0], [0.0, 0.0], [0.0, -4.0]];
    for (place, [x, y]) in rest.iter().zip(wanted) {
        assert!(near(*place, Vec3::new(x, y, 0.0)), "{place}");
    }
    // Leaf bones end at end sites: (2, 0, 0) and (0, -3, 0) in the axes of the figure. The arm's
    // axes are rotated about x, then about z: C = Rz(90) Rx(90), so C⁻¹ x̂ = -ŷ of Rz, which
    // Rx(-90) rotates to ẑ.
    assert_eq!(file.end_sites.len(), 2);
    assert_eq!((file.end_sites[0].0, file.end_sites[1].0), (2, 4));
    assert!(near(file.end_sites[0].1, Vec3::new(0.0, 0.0, 2.0)));
    assert!(near(file.end_sites[1].1, Vec3::new(-3.0, 0.0, 0.0)));

    // Second frame. The root rotates about x, then about z: x̂ -> ŷ, ŷ -> ẑ, ẑ -> x̂. The thigh's
    // own x axis is the figure's y axis, so its own bone does not move; the shin rotates about the
    // same axis.
    let at = |name| place(character, name, 0.5);
    let root = Vec3::new(1.0, 7.0, 2.0);
    assert!(near(at("root"), root));
    assert!(near(at("shin"), root + Vec3::new(0.0, 0.0, -4.0)));
    // The arm moves by 1 along its own x axis, which is the figure's y axis: (3, 5, 0).
    assert!(
        near(at("arm"), root + Vec3::new(0.0, 3.0, 5.0)),
        "{}",
        at("arm")
    );
}

/// The arm's end shows its rotation: about its z axis, which C = Rz(90) Rx(90) puts at +x of the
/// figure. So the arm, which lies along x, rotates about itself.
#[test]
fn a_bone_turns_about_its_own_axes() {
    let end = |amc: &str| {
        let mut file = plain(ASF, Some(amc)).unwrap().value;
        let (joint, offset) = file.end_sites[0];
        let mut tip = file.character.skeleton.joints[joint].clone();
        tip.name = "tip".to_owned();
        tip.parent = Some(joint);
        tip.rest = articula_core::Transform::from_translation(offset);
        file.character.skeleton.joints.push(tip);
        place(&file.character, "tip", 0.5)
    };
    let one = |values: &str| format!("1\n{values}");
    assert!(near(end(&one("arm 0 0")), Vec3::new(5.0, 4.0, 0.0)));
    assert!(near(end(&one("arm 0 30")), Vec3::new(5.0, 4.0, 0.0)));
    // With rx instead: about +y of the figure, which takes +x to -z.
    let asf = ASF.replace("dof tx rz", "dof tx rx");
    let file = plain(&asf, Some(&one("arm 0 90"))).unwrap().value;
    let rotation = Quat::from_slice(&file.character.clips[0].channels[1].values);
    let axes =
        Quat::from_rotation_z(90f32.to_radians()) * Quat::from_rotation_x(90f32.to_radians());
    let wanted = axes * Quat::from_rotation_x(90f32.to_radians());
    assert!(
        rotation.dot(wanted).abs() > 1.0 - 1e-6,
        "the parent's axes are the figure's"
    );
    let way = rotation * file.end_sites[0].1;
    assert!(near(way, Vec3::new(0.0, 0.0, -2.0)), "{way}");
}

#[test]
fn three_rotations_turn_in_the_order_of_the_degrees_of_freedom() {
    let asf = ASF.replace(
        "axis 0 0 90 XYZ\n    dof rx ry rz",
        "axis 0 0 0 XYZ\n    dof rz rx",
    );
    let file = plain(&asf, Some("1\nthigh 90 90\n")).unwrap().value;
    // Down, rotated about z first, points to +x; about x that stays. In the other order it would
    // point to -z and stay there.
    let shin = place(&file.character, "shin", 0.0);
    assert!(near(shin, Vec3::new(4.0, 0.0, 0.0)), "{shin}");
}

#[test]
fn angles_may_be_radians() {
    let quarter = std::f32::consts::FRAC_PI_2.to_string();
    let half_degrees = ASF.replace("angle deg", "angle rad");
    let half = half_degrees
        .replace("axis 0 0 90", &format!("axis 0 0 {quarter}"))
        .replace("axis 90 0 90", &format!("axis {quarter} 0 {quarter}"));
    let radians = AMC.replace("90", &quarter).replace(":DEGREES\n", "");
    let all = plain(&half, Some(&radians)).unwrap().value;
    // The motion's unit overrides the skeleton's.
    let mixed = plain(&half, Some(AMC)).unwrap().value;
    let other = plain(ASF, Some(&format!(":RADIANS\n{radians}")))
        .unwrap()
        .value;
    let wanted = plain(ASF, Some(AMC)).unwrap().value;
    for file in [all, mixed, other] {
        for (a, b) in world(&file.character, 0.5)
            .iter()
            .zip(world(&wanted.character, 0.5))
        {
            assert!(near(*a, b), "{a} {b}");
        }
    }
}

#[test]
fn the_root_may_be_placed_and_turned() {
    let asf = ASF
        .replace("position 0 0 0", "position 0 0 5")
        .replace("orientation 0 0 0", "orientation 0 90 0");
    let file = plain(&asf, Some("1\nroot 1 0 0 0 0 90\n")).unwrap().value;
    let rest = at_rest(&file.character);
    // About y: +x of the figure points to -z.
    assert!(near(rest[2], Vec3::new(0.0, 4.0, 2.0)), "{}", rest[2]);
    // The motion rotates the figure before its orientation does: (3, 4, 0) -> (-4, 3, 0).
    let arm = place(&file.character, "arm", 0.0);
    assert!(near(arm, Vec3::new(1.0, 3.0, 9.0)), "{arm}");
}

#[test]
fn joints_without_a_row_hold() {
    let amc = "1\nroot 0 0 0 0 0 0\n2\nthigh 40 0 0\nroot 0 0 0 0 0 0\n3\n4\n5\nthigh 80 0 0\n6\n";
    let file = plain(ASF, Some(amc)).unwrap().value;
    let clip = &file.character.clips[0];
    assert_eq!(clip.duration_secs, 2.5);
    let thigh = file.character.skeleton.find("thigh").unwrap();
    let keys = clip
        .channels
        .iter()
        .find(|c| c.target == thigh && c.property == Property::Rotation)
        .unwrap();
    assert_eq!(keys.times_secs, [0.0, 0.5, 1.5, 2.0]);
    let rest = file.character.skeleton.joints[thigh].rest.rotation;
    let angle = |key: usize| {
        let q = Quat::from_slice(&keys.values[4 * key..]);
        articula_core::angle_between(rest, q).to_degrees().round()
    };
    assert_eq!(
        [angle(0), angle(1), angle(2), angle(3)],
        [0.0, 40.0, 40.0, 80.0]
    );
}

#[test]
fn odd_spelling_is_read_alike() {
    let wanted = plain(ASF, Some(AMC)).unwrap().value;
    let asf = ASF
        .replace('\n', "\r\n")
        .replace("     ", "\t")
        .replace(":bonedata", ":BONEDATA # the bones")
        .replace("dof rx", "DOF RX")
        .replace("direction 0 -1 0", "direction (0, -2, 0)")
        .replace("begin", "Begin");
    let amc = AMC.replace('\n', "\r\n\r\n").replace("root", "Root");
    let found = plain(&format!("\u{feff}{asf}"), Some(&amc)).unwrap();
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    assert_eq!(found.value, wanted);
}

#[test]
fn the_rate_may_stand_in_the_file() {
    let rate = |amc: &str, rate_hz: Option<f32>| {
        let options = ReadOptions {
            rate_hz,
            scale_to_metres: Some(1.0),
            ..ReadOptions::default()
        };
        let read = acclaim::read(
            ASF.as_bytes(),
            Some(amc.as_bytes()),
            &options,
            &Limits::default(),
        );
        let read = read.unwrap();
        (read.value.frame_time_secs, read.warnings.len())
    };
    assert_eq!(rate(AMC, None), (1.0 / 120.0, 1));
    assert_eq!(rate(AMC, Some(60.0)), (1.0 / 60.0, 0));
    assert_eq!(
        rate(&format!(":SAMPLES-PER-SECOND 30\n{AMC}"), None),
        (1.0 / 30.0, 0)
    );
    assert_eq!(
        rate(&format!("# samples-per-second 25.5\n{AMC}"), None),
        (1.0 / 25.5, 0)
    );
}

/// The unit is guessed from `length` and the size of the figure.
#[test]
fn the_unit_is_told_and_said() {
    let unit = |length: &str, asf: &str| {
        let asf = asf.replace("length 1.0\n", &format!("length {length}\n"));
        let read = acclaim::read(
            asf.as_bytes(),
            None,
            &ReadOptions::default(),
            &Limits::default(),
        );
        let read = read.unwrap();
        let joints = &read.value.character.skeleton.joints;
        let said = read.warnings.iter().any(|w| w.what.contains("1 unit"));
        (joints[4].rest.translation.length() / 4.0, said)
    };
    let (found, said) = unit("0.45", ASF);
    assert!((found - 0.0254 / 0.45).abs() < 1e-7 && said, "{found}");
    // The longest path is 3 + 4 + 5 + 2 units, that of a human of 14 / 1.56 = 9.0 units. With
    // 0.0254 / 0.16 m for a unit that is 1.42 m: an adult, so `length` is accepted.
    let (found, said) = unit("0.16", ASF);
    assert!((found - 0.0254 / 0.16).abs() < 1e-6 && said, "{found}");
    // One leg and one arm are no human, whose height would tell the unit.
    let (found, said) = unit("1.0", ASF);
    assert!((found - 0.01).abs() < 1e-6 && said, "{found}");
}

#[test]
fn a_figure_along_z_is_turned_upright() {
    let asf = "\
:root
order TX TY TZ RX RY RZ
:bonedata
begin
name spine
direction 0 0 1
length 0.5
dof rx ry rz
end
begin
name head
direction 0 1 0
length 0.2
end
:hierarchy
begin
root spine
spine head
end
";
    let read = |up, amc: Option<&str>| {
        let options = ReadOptions {
            up,
            scale_to_metres: Some(1.0),
            rate_hz: Some(1.0),
        };
        let amc = amc.map(str::as_bytes);
        acclaim::read(asf.as_bytes(), amc, &options, &Limits::default()).unwrap()
    };
    let told = read(UpAxis::Auto, Some("1\nroot 1 2 3 0 0 0\nspine 90 0 0"));
    assert!(told.warnings.iter().any(|w| w.what.contains("+Z is up")));
    let told = told.value.character;
    assert!(near(at_rest(&told)[2], Vec3::new(0.0, 0.5, 0.0)));
    // z points up, y backwards: (1, 2, 3) -> (1, 3, -2); the spine rotates z to -y, so to +z.
    let head = place(&told, "head", 0.0);
    assert!(near(head, Vec3::new(1.0, 3.0, -1.5)), "{head}");
    let left = read(UpAxis::Y, None).value.character;
    assert!(near(at_rest(&left)[2], Vec3::new(0.0, 0.0, 0.5)));
    assert!(!articula_build::joint_names::map(&left.skeleton, joint_map::builtin(), None).humanoid);
}
