//! The figure of the standard, with any rest rotations and any motion, in both schemes.

use super::*;
use articula_core::JointArticulation;
use articula_core::LocalPose;
use articula_core::hanim_table::{BODY_JOINTS, JOINTS};
use articula_core::source::{
    Channel, Expression, Interpolation, Joint, JointBinding, Primitive, Property, RawClip, RawMesh,
    Skin, evaluate,
};
use glam::{Affine3A, Quat};
use proptest::prelude::*;

/// A character with the articulation of its joints.
#[derive(Debug, Clone)]
struct Figure {
    character: Character,
    articulation: Articulation,
    ends: Vec<(usize, Vec3)>,
}

impl Figure {
    /// The body of the standard; joints rest with these turns and are scaled by `scale` in all.
    fn standard(turns: &[Quat], scale: f32) -> Self {
        let mut model: Vec<Affine3A> = Vec::new();
        let mut joints = Vec::new();
        for (j, row) in JOINTS[..BODY_JOINTS].iter().enumerate() {
            let own_scale = if j == 0 { scale } else { 1.0 };
            let place = Affine3A::from_scale_rotation_translation(
                Vec3::splat(scale),
                turns[j % turns.len()],
                row.center,
            );
            let above = row.parent.map_or(Affine3A::IDENTITY, |p| model[p]);
            let local = above.inverse() * place;
            let (_, rotation, translation) = local.to_scale_rotation_translation();
            joints.push(Joint {
                name: row.name.to_owned(),
                parent: row.parent,
                rest: Transform {
                    translation,
                    rotation,
                    scale: Vec3::splat(own_scale),
                },
                in_skin: true,
            });
            model.push(place);
        }
        let entry = |row: &HanimJoint| JointArticulation {
            hanim: Some(row.name.to_owned()),
            level: row.level,
            region: row.region,
        };
        Self {
            character: Character {
                skeleton: Skeleton { joints },
                ..Character::default()
            },
            articulation: Articulation {
                profile: "hanim".into(),
                joints: JOINTS[..BODY_JOINTS].iter().map(entry).collect(),
            },
            ends: vec![],
        }
    }

    fn plain() -> Self {
        Self::standard(&[Quat::IDENTITY], 1.0)
    }

    fn joint(&self, name: &str) -> usize {
        self.articulation.find(name).unwrap()
    }

    fn set(&mut self, scheme: JointScheme) -> Result<SchemeChange, Mismatch> {
        let Self {
            character,
            articulation,
            ends,
        } = self;
        set_joint_scheme(character, articulation, ends, scheme)
    }

    fn turn(&mut self, joint: &str, keys: &[Quat], interpolation: Interpolation) {
        let target = self.joint(joint);
        let rest = self.character.skeleton.joints[target].rest.rotation;
        let spline = interpolation == Interpolation::CubicSpline;
        let values = keys.iter().flat_map(|key| {
            let value = (*key * rest).to_array();
            if spline {
                [[0.0; 4], value, [0.0; 4]].concat()
            } else {
                value.to_vec()
            }
        });
        let channel = Channel {
            target,
            property: Property::Rotation,
            interpolation,
            times_secs: (0..keys.len()).map(|k| 0.1 * k as f32).collect(),
            values: values.collect(),
        };
        let clips = &mut self.character.clips;
        if clips.is_empty() {
            clips.push(RawClip::default());
        }
        let clip = &mut clips[0];
        clip.duration_secs = clip.duration_secs.max(*channel.times_secs.last().unwrap());
        clip.channels.push(channel);
    }

    fn model(&self, secs: f32) -> Vec<Affine3A> {
        let skeleton = &self.character.skeleton;
        let mut pose: LocalPose = skeleton.joints.iter().map(|j| j.rest).collect();
        evaluate::pose(&self.character.clips[0], skeleton, secs, &mut pose);
        let mut model: Vec<Affine3A> = Vec::new();
        for (j, joint) in skeleton.joints.iter().enumerate() {
            let above = joint.parent.map_or(Affine3A::IDENTITY, |p| model[p]);
            model.push(above * pose.get(j).to_affine());
        }
        model
    }

    fn place(&self, joint: &str, secs: f32) -> Affine3A {
        self.model(secs)[self.joint(joint)]
    }
}

/// Largest difference of transforms between joints of equal H-Anim names, at a time: of positions in
/// metres, and of axes.
fn apart(a: &Figure, b: &Figure, secs: f32, is_turn_kept: impl Fn(&str) -> bool) -> (f32, f32) {
    let (before, after) = (a.model(secs), b.model(secs));
    let (mut metres, mut axes) = (0.0_f32, 0.0_f32);
    for (joint, entry) in a.articulation.joints.iter().enumerate() {
        let name = entry.hanim.as_deref().unwrap();
        let Some(other) = b.articulation.find(name) else {
            continue;
        };
        metres = metres.max(before[joint].translation.distance(after[other].translation));
        if is_turn_kept(name) {
            let difference = before[joint].matrix3 - after[other].matrix3;
            axes = axes.max(
                difference
                    .to_cols_array()
                    .into_iter()
                    .fold(0.0, |m, x| m.max(x.abs())),
            );
        }
    }
    (metres, axes)
}

#[test]
fn a_subtalar_that_turns_goes_on_in_the_ankle() {
    let mut figure = Figure::plain();
    let turn = Quat::from_rotation_x(0.5);
    figure.turn("l_subtalar", &[Quat::IDENTITY, turn], Interpolation::Linear);
    figure.turn(
        "l_ankle",
        &[Quat::from_rotation_y(0.2)],
        Interpolation::Linear,
    );
    let before = figure.clone();
    let change = figure.set(JointScheme::Thesis).unwrap();
    let names: Vec<&str> = change.edits.iter().map(name).collect();
    assert_eq!(names, ["l_subtalar", "l_thumb0", "r_subtalar", "r_thumb0"]);
    assert_eq!(figure.articulation.joints.len(), BODY_JOINTS);
    assert!(figure.articulation.find("l_subtalar").is_none());
    // The ankle stays in its place, and turns as the subtalar did.
    let (was, is) = (
        before.place("l_subtalar", 0.1),
        figure.place("l_ankle", 0.1),
    );
    assert!(
        (was.matrix3 - is.matrix3)
            .to_cols_array()
            .iter()
            .all(|x| x.abs() < 1e-6)
    );
    let (metres, axes) = apart(&before, &figure, 0.1, |name| name != "l_ankle");
    assert!(metres < 1e-6 && axes < 1e-6, "{metres} {axes}");
    assert!(change.joints_metres < 2e-4, "{}", change.joints_metres);
    let ankle = figure.joint("l_ankle");
    let turns = |c: &&Channel| c.target == ankle && c.property == Property::Rotation;
    assert_eq!(
        figure.character.clips[0]
            .channels
            .iter()
            .filter(turns)
            .count(),
        1
    );
}

fn name(edit: &JointEdit) -> &str {
    match edit {
        JointEdit::Inserted(inserted) => &inserted.name,
        JointEdit::Merged(merged) => &merged.name,
    }
}

#[test]
fn a_thumb_base_that_turns_goes_on_in_the_thumb() {
    let mut figure = Figure::plain();
    figure.set(JointScheme::Thesis).unwrap();
    let base = figure.joint("r_thumb0");
    let joints = &figure.character.skeleton.joints;
    assert_eq!(joints[base].rest, Transform::IDENTITY);
    assert_eq!(joints[base].parent, Some(figure.joint("r_wrist")));
    assert_eq!(joints[figure.joint("r_thumb1")].parent, Some(base));
    figure.turn(
        "r_thumb0",
        &[Quat::from_rotation_z(0.6)],
        Interpolation::Linear,
    );
    figure.turn(
        "r_thumb1",
        &[Quat::from_rotation_x(0.3)],
        Interpolation::Linear,
    );
    let thesis = figure.clone();
    let change = figure.set(JointScheme::Hanim).unwrap();
    let (metres, axes) = apart(&thesis, &figure, 0.0, |_| true);
    assert!(metres < 1e-6 && axes < 1e-6, "{metres} {axes}");
    assert!(change.joints_metres < 1e-6);
    // The subtalars are back in the places of the standard.
    let plain = Figure::plain();
    for (a, b) in plain
        .articulation
        .joints
        .iter()
        .zip(&figure.articulation.joints)
    {
        assert_eq!(a, b);
    }
    let rests = [&plain, &figure].map(|f| f.character.skeleton.model_rest());
    for (a, b) in rests[0].iter().zip(&rests[1]) {
        assert!(a.translation.distance(b.translation) < 1e-6);
    }
}

#[test]
fn what_is_in_a_scheme_stays_as_it_is() {
    let mut figure = Figure::plain();
    assert_eq!(
        figure.set(JointScheme::Hanim).unwrap(),
        SchemeChange::default()
    );
    figure.set(JointScheme::Thesis).unwrap();
    let before = figure.clone();
    assert_eq!(
        figure.set(JointScheme::Thesis).unwrap(),
        SchemeChange::default()
    );
    assert_eq!(before.character, figure.character);
}

/// Most rigs of games have neither subtalars nor midtarsals, and a thumb of three joints.
#[test]
fn a_rig_without_feet_or_thumbs_gets_no_joint() {
    let only = |names: &[&str]| {
        let mut figure = Figure::plain();
        for entry in &mut figure.articulation.joints {
            entry.hanim = entry
                .hanim
                .take()
                .filter(|name| names.iter().any(|n| name.ends_with(n)));
        }
        figure
    };
    let mut bare = only(&["ankle", "wrist"]);
    for scheme in JointScheme::ALL {
        assert!(bare.set(scheme).unwrap().edits.is_empty());
    }
    let mut toes = only(&["ankle", "_metatarsal"]);
    let change = toes.set(JointScheme::Hanim).unwrap();
    let [JointEdit::Inserted(left), JointEdit::Inserted(_)] = &change.edits[..] else {
        panic!("{change:?}");
    };
    // Directly below the ankle, and where the standard has it.
    assert_eq!(left.parent_name, "l_ankle");
    let place = toes.character.skeleton.model_rest()[left.joint].translation;
    assert!(
        Vec3::from(place).distance(Vec3::new(0.1086, 0.0001, -0.0368)) < 1e-5,
        "{place}"
    );
}

#[test]
fn a_foot_of_several_toes_gets_no_subtalar() {
    let mut figure = Figure::plain();
    figure.set(JointScheme::Thesis).unwrap();
    let toe = Joint {
        name: "toe".into(),
        parent: Some(figure.joint("l_ankle")),
        rest: Transform::IDENTITY,
        in_skin: true,
    };
    figure.character.skeleton.joints.push(toe);
    figure.articulation.joints.push(JointArticulation {
        hanim: Some("l_metatarsophalangeal_1".into()),
        level: 5,
        region: articula_core::Region::Feet,
    });
    let change = figure.set(JointScheme::Hanim).unwrap();
    let names: Vec<&str> = change.edits.iter().map(name).collect();
    assert_eq!(names, ["l_thumb0", "r_thumb0", "r_subtalar"]);
}

/// A mesh of three vertices on ankle, subtalar and both, and one on the toes.
fn shoe(figure: &Figure) -> RawMesh {
    let names = ["l_ankle", "l_subtalar", "l_midtarsal"];
    let joints: Vec<usize> = names.iter().map(|n| figure.joint(n)).collect();
    let rest = figure.character.skeleton.model_rest();
    RawMesh {
        name: "shoe".into(),
        skin: Skin {
            inverse_bind: joints.iter().map(|j| rest[*j].inverse()).collect(),
            joints,
        },
        primitives: vec![Primitive {
            positions: [0.05, 0.0, 0.02, 0.0]
                .map(|y| Vec3::new(0.1, y, 0.01))
                .to_vec(),
            influences: 2,
            joints: vec![0, 0, 1, 0, 0, 1, 2, 0],
            weights: vec![1.0, 0.0, 1.0, 0.0, 0.25, 0.75, 1.0, 0.0],
            triangles: vec![[0, 1, 2], [1, 2, 3]],
            ..Primitive::default()
        }],
        ..RawMesh::default()
    }
}

#[test]
fn skin_of_a_subtalar_follows_the_ankle() {
    let mut figure = Figure::plain();
    figure.character.meshes.push(shoe(&figure));
    figure.turn("l_subtalar", &[Quat::IDENTITY], Interpolation::Linear);
    let mut turned = figure.clone();
    let change = figure.set(JointScheme::Thesis).unwrap();
    let mesh = &figure.character.meshes[0];
    assert_eq!(
        mesh.skin.joints,
        ["l_ankle", "l_midtarsal"].map(|n| figure.joint(n))
    );
    let part = &mesh.primitives[0];
    assert_eq!(part.joints, [0, 0, 0, 0, 0, 0, 1, 0]);
    assert_eq!(part.weights, [1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
    assert!(change.skin_metres < 1e-6, "{}", change.skin_metres);
    // The vertex of the ankle alone is 0.085 m from its axis, and turns with it now; that of the
    // subtalar turned about the subtalar, 0.075 m away, and turns about the ankle now.
    turned.character.clips[0] = RawClip::default();
    turned.turn(
        "l_subtalar",
        &[Quat::from_rotation_x(0.2)],
        Interpolation::Linear,
    );
    let change = turned.set(JointScheme::Thesis).unwrap();
    let arc = |lever: f32| 2.0 * lever * (0.1_f32).sin();
    let ankle = Vec3::new(0.0, 0.0656 - 0.05, -0.0736 - 0.01).length();
    let subtalar = Vec3::new(0.0, 0.0655, 0.0368).length();
    let expected = arc(ankle).max(arc(subtalar));
    assert!(
        (change.skin_metres - expected).abs() < 1e-5,
        "{} {expected}",
        change.skin_metres
    );
}

#[test]
fn a_mesh_attached_to_a_subtalar_hangs_from_the_ankle() {
    let mut figure = Figure::plain();
    let subtalar = figure.joint("l_subtalar");
    let rest = figure.character.skeleton.model_rest();
    figure.character.meshes.push(RawMesh {
        skin: Skin {
            joints: vec![subtalar],
            inverse_bind: vec![Affine3A::IDENTITY],
        },
        ..RawMesh::default()
    });
    figure.ends.push((subtalar, Vec3::X));
    figure.set(JointScheme::Thesis).unwrap();
    let skin = &figure.character.meshes[0].skin;
    let ankle = figure.joint("l_ankle");
    assert_eq!(skin.joints, [ankle]);
    let place = figure.character.skeleton.model_rest()[ankle];
    assert!((place * skin.inverse_bind[0]).abs_diff_eq(rest[subtalar], 1e-6));
    assert_eq!(figure.ends[0].0, ankle);
    let end = place.transform_point3(figure.ends[0].1);
    assert!(end.distance(rest[subtalar].transform_point3(Vec3::X)) < 1e-6);
}

#[test]
fn what_cannot_be_converted_says_why_and_stays() {
    let mut stretched = Figure::plain();
    let subtalar = stretched.joint("r_subtalar");
    stretched.character.skeleton.joints[subtalar].rest.scale.x = 2.0;
    let before = stretched.character.clone();
    let why = stretched.set(JointScheme::Thesis).unwrap_err();
    assert!(
        why.to_string().contains("r_subtalar") && why.to_string().contains("scale"),
        "{why}"
    );
    assert_eq!(before, stretched.character);
    let mut driven = Figure::plain();
    driven.character.expressions.push(Expression {
        name: "stomp".into(),
        joints: vec![JointBinding {
            joint: subtalar,
            full: Transform::IDENTITY,
        }],
        ..Expression::default()
    });
    let why = driven.set(JointScheme::Thesis).unwrap_err();
    assert!(why.to_string().contains("stomp"), "{why}");
    let mut broken = Figure::plain();
    broken.ends.push((900, Vec3::X));
    assert!(broken.set(JointScheme::Thesis).is_err());
}

/// Joints that the conversions change or that are near them.
const MOVING: [&str; 9] = [
    "l_knee",
    "l_ankle",
    "l_subtalar",
    "l_midtarsal",
    "r_subtalar",
    "r_metatarsal",
    "l_wrist",
    "l_thumb1",
    "l_thumb2",
];

fn any_turn() -> impl Strategy<Value = Quat> {
    let component = || -1.0f32..1.0;
    let four = (component(), component(), component(), component());
    four.prop_filter_map("too short", |(x, y, z, w)| {
        let q = Quat::from_xyzw(x, y, z, w);
        (q.length() > 0.2).then(|| q.normalize())
    })
}

fn small_turn() -> impl Strategy<Value = Quat> {
    (any_turn(), 0.0f32..0.6).prop_map(|(q, t)| Quat::IDENTITY.slerp(q, t).normalize())
}

fn any_interpolation() -> impl Strategy<Value = Interpolation> {
    prop_oneof![
        Just(Interpolation::Linear),
        Just(Interpolation::Step),
        Just(Interpolation::CubicSpline),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn kept_joints_keep_their_places_there_and_back(
        turns in prop::collection::vec(any_turn(), 1..7),
        scale in prop_oneof![Just(1.0f32), Just(0.01), Just(100.0)],
        keys in prop::collection::vec(
            (prop::collection::vec(small_turn(), 1..5), any_interpolation()), MOVING.len()),
        base in prop::collection::vec(small_turn(), 1..4),
    ) {
        let mut figure = Figure::standard(&turns, scale);
        for (joint, (keys, interpolation)) in MOVING.iter().zip(&keys) {
            figure.turn(joint, keys, *interpolation);
        }
        let hanim = figure.clone();
        let times: Vec<f32> = (0..5).map(|k| 0.1 * k as f32).collect();
        let to_thesis = figure.set(JointScheme::Thesis).unwrap();
        let thesis = figure.clone();
        figure.set(JointScheme::Hanim).unwrap();
        for secs in &times {
            // The ankle takes the rotation of the subtalar; everything else has its own axes.
            let (metres, axes) = apart(&hanim, &thesis, *secs, |name| !name.ends_with("ankle"));
            prop_assert!(metres < 2e-5 && axes < 1e-4 * scale, "{secs}: {metres} m, {axes}");
            let (metres, axes) = apart(&thesis, &figure, *secs, |_| true);
            prop_assert!(metres < 2e-5 && axes < 1e-4 * scale, "{secs}: {metres} m, {axes}");
        }
        prop_assert!(to_thesis.joints_metres < 2e-3, "{}", to_thesis.joints_metres);
        // A thumb0 that moves goes on in the joints below it.
        let mut moved = thesis.clone();
        moved.turn("l_thumb0", &base, Interpolation::Linear);
        let mut back = moved.clone();
        back.set(JointScheme::Hanim).unwrap();
        for secs in &times {
            let (metres, axes) = apart(&moved, &back, *secs, |_| true);
            prop_assert!(metres < 2e-5 && axes < 1e-4 * scale, "{secs}: {metres} m, {axes}");
        }
    }
}
