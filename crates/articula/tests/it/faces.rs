//! FAP clips move the faces that the data has: blend shapes of ARKit, expressions of VRM, heads.

use crate::real;
use articula::face::{
    FaceColumns, FaceDetailOptions, FaceKind, FaceRig, FittedFace, GENERIC_BRIDGE, capture_of_clip,
    capture_to_faps, expand_face, face_detail, face_layout, fit_face,
};
use articula::glam::{Affine3A, Quat, Vec3};
use articula::{CharacterFile, Data, DataFormat, Executor, Figure, OpenOptions, fs, open_data};
use articula_build::face::arkit_shape;
use articula_core::face_levels::FaceLevels;
use articula_core::source::{
    Channel, Character, Expression, Joint, MorphBinding, MorphTarget, Primitive, Property, RawMesh,
    Skeleton, evaluate,
};
use articula_core::{PosedMesh, Transform, fap_table};
use articula_formats::mpeg4::fap::{FapClip, FapFrame, Viseme};
use std::sync::OnceLock;

/// A clip of the data in fewer frames, all of its motions among them.
fn fap(name: &str) -> Option<FapClip> {
    let bytes = real::bytes(name)?;
    let read = open_data(&bytes, name, DataFormat::Fap, &OpenOptions::default()).unwrap();
    match read.data {
        Data::Fap(clip) => Some(thinned(clip)),
        other => panic!("{other:?} is no FAP clip"),
    }
}

const ICT: &str = "face/ict_facekit_expressions.glb";
const WOMAN: &str = "glb/mh_female_default163_arkit52.glb";

/// One of the two heads with all shapes, opened once.
fn figure(name: &str) -> Option<&'static Figure> {
    static ICT_HEAD: OnceLock<Option<Figure>> = OnceLock::new();
    static WOMAN_HEAD: OnceLock<Option<Figure>> = OnceLock::new();
    let head = match name {
        ICT => &ICT_HEAD,
        _ => &WOMAN_HEAD,
    };
    let open = || Some(Figure::new(fs::open(real::file(name)?).unwrap()).unwrap());
    head.get_or_init(open).as_ref()
}

/// Every fourth frame of a clip, at a quarter of its rate.
fn thinned(mut clip: FapClip) -> FapClip {
    clip.frames = clip.frames.into_iter().step_by(4).collect();
    for (number, frame) in (0..).zip(&mut clip.frames) {
        frame.number = number;
    }
    clip.rate_hz /= 4.0;
    clip
}

/// A clip of frames at 10 Hz, with values of low-level parameters.
fn clip(frames: &[&[(usize, i32)]]) -> FapClip {
    let frame = |(number, values): (usize, &&[(usize, i32)])| {
        let mut frame = FapFrame {
            number: number as u32,
            ..FapFrame::default()
        };
        for (fap, value) in *values {
            frame.low[fap - 3] = *value;
        }
        frame
    };
    FapClip {
        name: "hand made".to_owned(),
        rate_hz: 10.0,
        coded: [true; fap_table::FAP_COUNT],
        frames: frames.iter().enumerate().map(frame).collect(),
        bridge: None,
    }
}

/// Weights of the morph target of the first mesh with a name, one for each key.
fn weights(head: &CharacterFile, made: &FittedFace, name: &str) -> Vec<f32> {
    let mesh = &head.character().meshes[0];
    let slot = mesh.morph_names.iter().position(|n| n == name).unwrap();
    let channel = of(made, Property::Weights, 0);
    let width = mesh.morph_names.len();
    channel.values.chunks(width).map(|all| all[slot]).collect()
}

fn of(made: &FittedFace, property: Property, target: usize) -> &Channel {
    let is_it = |c: &&Channel| c.property == property && c.target == target;
    made.fitted.clip.channels.iter().find(is_it).unwrap()
}

#[test]
fn jaws_and_lids_follow_their_parameters_on_the_heads_of_the_data() {
    let clips = [
        "fap/expressions_synthetic.fap",
        "fap/speech_synthetic.fap",
        "fap/xface_joy.fap",
        "fap/xface_anger.fap",
    ];
    // Each clip measures the face, which takes long for the first with its many vertices.
    let heads = [
        (ICT, "eyeBlink_L", &clips[..2]),
        (WOMAN, "eyeBlinkLeft", &clips),
    ];
    for (head, blink, clips) in heads {
        let Some(head) = figure(head).map(|figure| &figure.opened) else {
            continue;
        };
        for name in clips {
            let Some(mut clip) = fap(name) else {
                continue;
            };
            clip.bridge = Some(GENERIC_BRIDGE.to_owned());
            let made = fit_face(&clip, name, head).unwrap();
            assert_eq!(made.report.columns, FaceColumns::Generic);
            // FAP 3 moves with jawOpen alone (1000 at weight 1), FAP 19 most of all with the blink
            // (950), whatever the other 50 shapes do.
            let (jaw, lid) = (weights(head, &made, "jawOpen"), weights(head, &made, blink));
            assert_eq!(jaw.len(), clip.frames.len());
            for ((frame, jaw), lid) in clip.frames.iter().zip(jaw).zip(lid) {
                let open = (frame.low[0] as f32 / 1000.0).clamp(0.0, 1.0);
                assert!((jaw - open).abs() < 0.12, "{name}: {jaw}, not {open}");
                let closed = frame.low[19 - 3] as f32 / 950.0;
                if closed > 0.6 {
                    assert!(
                        (lid - closed.min(1.0)).abs() < 0.25,
                        "{name}: {lid}, not {closed}"
                    );
                }
            }
            assert!(
                made.report.error_mm_mean < 0.25,
                "{name}: {:?}",
                made.report
            );
        }
    }
}

#[test]
fn chins_go_as_far_down_as_the_parameter_says_in_the_units_of_the_face() {
    for name in [ICT, WOMAN] {
        let (Some(head), Some(clip)) = (figure(name), fap("fap/speech_synthetic.fap")) else {
            continue;
        };
        let made = fit_face(&clip, "speech.fap", &head.opened).unwrap();
        assert_eq!(made.report.columns, FaceColumns::Measured);
        let layout = face_layout(head, &[]).unwrap();
        let unit = |name: &str| {
            layout
                .units
                .iter()
                .find(|u| u.name == name)
                .unwrap()
                .distance_m
                / 1024.0
        };
        let chin = layout.points.iter().find(|p| p.name == "2.1").unwrap();
        let mesh = &head.asset.mesh;
        let mut posed = PosedMesh::new(&head.asset.rig, mesh);
        posed.pose(head.asset.rig.rest_pose());
        let (mut off, mut largest) = (0.0, 0.0_f32);
        for (index, frame) in clip.frames.iter().enumerate() {
            let mut morphs = mesh.morph_weights.clone();
            let channels = made.fitted.clip.channels.iter();
            for channel in channels.filter(|c| c.property == Property::Weights) {
                let first = mesh.morph_slots[channel.target];
                let count = head.opened.character().meshes[channel.target]
                    .morph_names
                    .len();
                let values = &channel.values[index * count..(index + 1) * count];
                morphs[first..first + count].copy_from_slice(values);
            }
            let at = posed.skinned(&morphs).positions[chin.vertex.unwrap() as usize];
            let down = f32::max(0.0, frame.low[0] as f32) * unit("MNS");
            largest = largest.max(down);
            off += (chin.place_m[1] - at.y - down).abs() / clip.frames.len() as f32;
        }
        // What lips and cheeks want at the same time leaves a part of it.
        assert!(
            largest > 4e-3 && off < 0.15 * largest,
            "{name}: {off} of {largest}"
        );
    }
}

#[test]
fn a_face_shows_its_own_parameters_as_they_were() {
    let Some(path) = real::file("glb/ict_head_talk_554.glb") else {
        return;
    };
    let head = fs::open(&path).unwrap();
    let capture = capture_of_clip(&head, &head.character().clips[0]).unwrap();
    let rig = FaceRig::new(&head).unwrap();
    let own = rig.capture_bridge(&head).unwrap();
    assert!(own.name() != GENERIC_BRIDGE && own.name() == rig.name());
    let (clip, report) = capture_to_faps(&capture, "own", &own).unwrap();
    assert_eq!(
        (clip.bridge.as_deref(), &*report.columns),
        (Some(own.name()), own.name())
    );
    let made = fit_face(&clip, "own.fap", &head).unwrap();
    let names = &head.character().meshes[0].morph_names;
    let mut sum = 0.0;
    for name in names {
        let shape = arkit_shape(name).unwrap();
        let back = weights(&head, &made, name);
        for (frame, back) in capture.frames.iter().zip(&back) {
            sum += (frame.shapes[shape] - back).abs();
        }
    }
    let mean = sum / (names.len() * capture.frames.len()) as f32;
    assert!(mean < 0.015, "{mean}");
}

/// A mesh with one morph target, and a neck with a head.
fn head(morph: &str) -> CharacterFile {
    let joint = |name: &str, parent, rest| Joint {
        name: name.to_owned(),
        parent,
        rest,
        in_skin: true,
    };
    let tilted = Transform {
        translation: Vec3::Y,
        rotation: Quat::from_rotation_x(0.4),
        scale: Vec3::ONE,
    };
    let character = Character {
        skeleton: Skeleton {
            joints: vec![joint("Neck", None, tilted), joint("Head", Some(0), tilted)],
        },
        meshes: vec![RawMesh {
            morph_names: vec![morph.to_owned()],
            morph_weights: vec![0.0],
            ..RawMesh::default()
        }],
        ..Character::default()
    };
    mapped(character, &[(1, "skullbase")])
}

/// A character of which some joints are known.
fn mapped(mut character: Character, known: &[(usize, &str)]) -> CharacterFile {
    let by_name = CharacterFile::from_character("head.glb", character.clone());
    let mut articulation = by_name.articulation();
    for (joint, hanim) in known {
        articulation.joints[*joint].hanim = Some((*hanim).to_owned());
    }
    character.articulation = Some(articulation);
    CharacterFile::from_character("head.glb", character)
}

#[test]
fn heads_turn_and_what_nothing_shows_is_listed() {
    let quarter = (std::f32::consts::FRAC_PI_2 * 1e5) as i32;
    let head = head("jaw_open");
    let made = fit_face(
        &clip(&[&[], &[(3, 500), (49, quarter), (46, 300)]]),
        "a/talk.fap",
        &head,
    )
    .unwrap();
    assert_eq!(made.fitted.clip.name, "talk");
    let report = &made.report;
    assert_eq!((report.frames, report.duration_secs), (2, 0.1));
    assert_eq!((report.controls, report.controls_moved), (1, 1));
    assert_eq!(report.joints, ["Head"]);
    let missing: Vec<usize> = report.not_driven.iter().map(|n| n.fap).collect();
    assert_eq!(missing, [46]);
    // 300 / 1024 of the height between mouth and nose, 21.2 mm.
    assert!((report.not_driven[0].mm - 6.21).abs() < 0.01);

    // The head rests turned by 0.8 radians from the world, with its face along +Z; it looks left.
    let turned = of(&made, Property::Rotation, 1);
    let mut local = [0.0; 4];
    evaluate::channel(turned, 0.0, &mut local);
    let rest = Quat::from_rotation_x(0.4);
    assert!(Quat::from_array(local).angle_between(rest) < 1e-5);
    evaluate::channel(turned, 0.1, &mut local);
    let nose = Quat::from_rotation_x(-0.8) * Vec3::Z;
    let looks = rest * Quat::from_array(local) * nose;
    assert!((looks - Vec3::X).length() < 1e-4, "{looks}");
}

#[test]
fn a_viseme_is_the_preset_of_its_vowel() {
    let mut opened = head("mouth");
    let vowel = Expression {
        name: "aa".to_owned(),
        morphs: vec![MorphBinding {
            mesh: 0,
            target: 0,
            weight: 0.8,
        }],
        ..Expression::default()
    };
    opened.edit_character(|character| character.expressions = vec![vowel]);
    let mut said = clip(&[&[], &[]]);
    // The "a" of "car".
    said.frames[1].viseme = Viseme {
        select1: 10,
        blend: 63,
        ..Viseme::default()
    };
    let made = fit_face(&said, "a.fap", &opened).unwrap();
    assert_eq!(made.report.kind, FaceKind::Expressions);
    let weight = *weights(&opened, &made, "mouth").last().unwrap();
    assert!((weight - 0.8).abs() < 0.01, "{weight}");
    said.frames[1].viseme.blend = 21;
    let made = fit_face(&said, "a.fap", &opened).unwrap();
    let weight = *weights(&opened, &made, "mouth").last().unwrap();
    assert!((weight - 0.8 / 3.0).abs() < 0.01, "{weight}");
    // The low-level parameters of the frame define the viseme instead.
    said.frames[1].viseme.defines = true;
    let made = fit_face(&said, "a.fap", &opened).unwrap();
    assert!(weights(&opened, &made, "mouth").iter().all(|w| *w == 0.0));
}

#[test]
fn a_face_without_controls_and_a_clip_without_frames_are_refused() {
    let moved = clip(&[&[(3, 100)]]);
    let why = fit_face(&moved, "a.fap", &head("grin"))
        .unwrap_err()
        .to_string();
    assert!(why.starts_with("head.glb: face: no morph target"), "{why}");
    let why = fit_face(&clip(&[]), "a.fap", &head("jawOpen")).unwrap_err();
    assert_eq!(why.to_string(), "a.fap: the file has no frame");
}

#[test]
fn levels_and_parameters_stay_within_the_tolerance_on_the_heads_of_the_data() {
    for name in [ICT, WOMAN] {
        let (Some(head), Some(clip)) = (figure(name), fap("fap/speech_synthetic.fap")) else {
            continue;
        };
        let options = FaceDetailOptions {
            distances_m: vec![5.65, 1.0],
            ..FaceDetailOptions::default()
        };
        let work = Executor::default();
        let report = face_detail(&clip, "speech.fap", head, &options, &work).unwrap();
        let counts: Vec<usize> = report.levels.iter().map(|l| l.parameters).collect();
        // FAP 3 to 18 and 51 to 60 move; the table keeps 14, 9 and 5 of these.
        assert_eq!(counts, [26, 14, 9, 5]);
        assert_eq!(report.levels[0].error_mm, 0.0);
        let [near, far] = &report.rows[..] else {
            panic!("two distances");
        };
        assert_eq!((near.distance_m, far.distance_m), (1.0, 5.65));
        for row in [near, far] {
            assert!(row.regions_px <= 1.0 && row.chosen_px <= 1.0, "{row:?}");
        }
        assert!(far.chosen.iter().all(|fap| near.chosen.contains(fap)));
        assert!(far.chosen.len() < near.chosen.len());

        // The slow way: both clips as channels of the head, and all of its vertices in each frame.
        let levels: FaceLevels = "low".parse().unwrap();
        let (whole, low) = posed(head, &clip, &expand_face(&clip, &levels.roles()));
        let pairs = whole.iter().flatten().zip(low.iter().flatten());
        let slow = pairs.fold(0.0_f32, |most, (a, b)| most.max(a.distance(*b)));
        let stated = 1e-3 * report.levels[2].error_mm;
        assert!((slow - stated).abs() < 2e-5, "{slow} m, not {stated} m");
    }
}

/// The vertices of a head in each frame.
type Posed = Vec<Vec<Vec3>>;

/// The vertices of a head in each frame of two clips, by its morph targets at rest. One comes after the
/// other in one clip, so that the face is measured once.
fn posed(head: &Figure, first: &FapClip, second: &FapClip) -> (Posed, Posed) {
    let mut clip = first.clone();
    clip.frames.extend_from_slice(&second.frames);
    for (number, frame) in (0..).zip(&mut clip.frames) {
        frame.number = number;
    }
    let made = fit_face(&clip, "talk.fap", &head.opened).unwrap();
    let mesh = &head.asset.mesh;
    let mut posed = PosedMesh::new(&head.asset.rig, mesh);
    posed.pose(head.asset.rig.rest_pose());
    let weights = |frame: usize| {
        let mut all = mesh.morph_weights.clone();
        let channels = made.fitted.clip.channels.iter();
        for channel in channels.filter(|c| c.property == Property::Weights) {
            let count = head.opened.character().meshes[channel.target]
                .morph_weights
                .len();
            let first = mesh.morph_slots[channel.target];
            all[first..first + count].copy_from_slice(&channel.values[frame * count..][..count]);
        }
        all
    };
    let mut of = |frames: std::ops::Range<usize>| -> Posed {
        frames
            .map(|f| posed.skinned(&weights(f)).positions)
            .collect()
    };
    let (middle, end) = (first.frames.len(), clip.frames.len());
    (of(0..middle), of(middle..end))
}

#[test]
fn an_eyeball_without_a_shape_is_measured_by_its_joint() {
    let eye = Transform::from_translation(Vec3::Y);
    let joint = |name: &str, parent| Joint {
        name: name.to_owned(),
        parent,
        rest: eye,
        in_skin: true,
    };
    // A pupil 12 mm before the joint of the left eye, and a chin that the jaw lowers.
    let mut chin = RawMesh {
        morph_names: vec!["jawOpen".to_owned()],
        morph_weights: vec![0.0],
        ..RawMesh::default()
    };
    chin.skin.joints = vec![0, 1];
    let bind = |height: f32| Affine3A::from_translation(Vec3::Y * -height);
    chin.skin.inverse_bind = vec![bind(1.0), bind(2.0)];
    chin.primitives.push(Primitive {
        positions: vec![Vec3::Y, Vec3::new(0.0, 2.0, 0.012), Vec3::X],
        influences: 1,
        joints: vec![0, 1, 0],
        weights: vec![1.0; 3],
        triangles: vec![[0, 1, 2]],
        morphs: vec![MorphTarget {
            positions: vec![Vec3::Y * -0.03, Vec3::ZERO, Vec3::ZERO],
            ..MorphTarget::default()
        }],
        ..Primitive::default()
    });
    let character = Character {
        skeleton: Skeleton {
            joints: vec![joint("Head", None), joint("LeftEye", Some(0))],
        },
        meshes: vec![chin],
        ..Character::default()
    };
    let known = [(0, "skullbase"), (1, "l_eyeball_joint")];
    let head = Figure::new(mapped(character, &known)).unwrap();
    // The left eye looks left by a third of a right angle; the right one does not.
    let third = (std::f32::consts::FRAC_PI_6 * 1e5) as i32;
    let clip = clip(&[&[(23, third)]]);
    let work = Executor::default();
    let report = face_detail(&clip, "a.fap", &head, &FaceDetailOptions::default(), &work).unwrap();
    // At medium the left eye copies the right one: the pupil misses a chord of 30 degrees.
    let chord = 2.0 * 12.0 * (std::f32::consts::PI / 12.0).sin();
    let medium = report.levels[1].error_mm;
    assert!((medium - chord).abs() < 0.01, "{medium} mm, not {chord} mm");
    assert_eq!(report.rows[0].chosen, [23]);
    assert_eq!(report.rows[0].regions["eyeballs"], "high");
}
