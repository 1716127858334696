//! Motions of bodies and faces as streams: what is shown after a round trip, and after a cut.

use crate::crowd;
use crate::real;
use crate::short::shortened;
use articula::clip_streams::{StreamKind, abp1, abp2, afp1, afp2, fba};
use articula::convert::{AbpProfile, AfpProfile, ConvertOptions, write_faps};
use articula::face::{expand_face, reduce_face};
use articula::glam::Quat;
use articula::glam::{Affine3A, Vec3};
use articula::{
    CharacterFile, Data, DataFormat, Executor, Figure, Format, OpenOptions, convert, fs, open,
    open_data,
};
use articula_core::LocalPose;
use articula_core::face_levels::{FaceLevel, FaceLevels, FaceRegion};
use articula_core::fap_table::{TABLE, unit_mm};
use articula_core::source::{
    Channel, Character, Interpolation, Joint, Property, RawClip, RawMesh, Skeleton, evaluate,
};
use articula_core::{Articulation, PosedMesh, Transform, Wrap, sample_morphs};
use articula_formats::Limits;
use articula_formats::mpeg4::fap::{FapClip, FapFrame, Viseme};
use articula_stream::abp1::{Abp1Options, TrackKind, unit};
use articula_stream::abp2::{MotionHead, MotionOptions};
use articula_stream::afp1::Afp1Options;
use articula_stream::fba::FbaOptions;
use articula_stream::{CutRule, FaceReadOptions, StreamLimits, Unit, cut};
use std::path::PathBuf;

fn opened(bytes: &[u8], name: &str) -> CharacterFile {
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    open(bytes, name, &OpenOptions::default(), nothing).unwrap()
}

/// Transforms of all joints in the space of the model.
fn places(character: &Character, clip: usize, secs: f32) -> Vec<Affine3A> {
    let skeleton = &character.skeleton;
    let mut pose: LocalPose = skeleton.joints.iter().map(|j| j.rest).collect();
    evaluate::pose(&character.clips[clip], skeleton, secs, &mut pose);
    let mut model: Vec<Affine3A> = Vec::new();
    for (j, joint) in skeleton.joints.iter().enumerate() {
        let above = joint.parent.map_or(Affine3A::IDENTITY, |p| model[p]);
        model.push(above * pose.get(j).to_affine());
    }
    model
}

/// Largest distance of a joint between the clip of a character and the first clip of another, over
/// some frames of the other.
fn largest_distance(a: &Character, clip: usize, b: &Character) -> f32 {
    let channel = b.clips[0]
        .channels
        .iter()
        .max_by_key(|c| c.times_secs.len());
    let times = channel.map(|c| c.times_secs.clone()).unwrap_or_default();
    let mut most = 0.0_f32;
    for secs in times.iter().step_by(7) {
        let (a, b) = (places(a, clip, *secs), places(b, 0, *secs));
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(&b) {
            most = most.max(a.translation.distance(b.translation));
        }
    }
    most
}

/// Largest distance of a joint from the origin at rest.
fn size(character: &Character) -> f32 {
    let places = character.skeleton.model_rest();
    let distances = places.iter().map(|place| place.translation.length());
    distances.fold(0.0, f32::max)
}

#[test]
fn a_character_moves_the_same_after_abp1() {
    let human = crowd::human();
    let mut files: Vec<PathBuf> = Vec::new();
    for folder in ["glb", "bvh", "vrm"] {
        let all = real::real_data().map(|data| fs::in_folder(&data.join(folder)).unwrap());
        files.extend(all.into_iter().flatten());
    }
    // Without a clip, or of a form that is not read.
    let with_clips = |path: &PathBuf| {
        fs::open(path)
            .ok()
            .filter(|f| !f.character().clips.is_empty())
            .map(|f| shortened(f, 2.0))
    };
    let files = files.iter().filter_map(with_clips);
    for file in [human].into_iter().chain(files) {
        let articulation = file.articulation();
        let options = Abp1Options::default();
        let bytes = abp1::write(file.character(), &articulation, 0, &options).unwrap();
        assert_eq!(StreamKind::of(&bytes), Some(StreamKind::Abp1));
        let again = opened(&bytes, "a.abp");
        assert_eq!(again.format(), Format::Abp);
        // Each ancestor turns and moves by up to two steps of 0.0001 more or less.
        let most = largest_distance(file.character(), 0, again.character());
        let bound = 1e-3 * size(file.character()).max(1.0);
        assert!(most < bound, "{}: {most} m, at most {bound}", file.name());
        let of_joint = |file: &CharacterFile| -> Vec<_> {
            let joints = file.articulation().joints;
            joints.iter().map(|j| (j.level, j.region)).collect()
        };
        assert_eq!(of_joint(&file), of_joint(&again));
    }
}

#[test]
fn a_cut_holds_still_what_it_drops() {
    let human = crowd::human();
    let bytes = abp1::write(
        human.character(),
        &human.articulation(),
        0,
        &Abp1Options::default(),
    );
    let bytes = bytes.unwrap();
    let limits = StreamLimits::default();
    let map = unit(&bytes, &limits).unwrap();
    let rule = CutRule::default().at_most("loa", 1);
    let cut = cut(&bytes, &map, |unit| rule.keeps(unit)).unwrap();
    assert!(cut.bytes.len() < bytes.len());
    let (all, fewer) = (opened(&bytes, "a.abp"), opened(&cut.bytes, "b.abp"));
    let articulation = all.articulation();
    let moving = |file: &CharacterFile, joint: usize| {
        let mut channels = file.character().clips[0].channels.iter();
        channels.any(|c| c.target == joint)
    };
    let mut kept = 0;
    for (joint, of_joint) in articulation.joints.iter().enumerate() {
        let expected = of_joint.level <= 1 && moving(&all, joint);
        assert_eq!(moving(&fewer, joint), expected);
        kept += usize::from(expected);
    }
    assert!(kept > 3, "only {kept} joints were kept");
}

/// A root and a child with turned and scaled rest poses, that move in all ways.
fn turned() -> Character {
    let joint = |parent, translation, rotation, scale| Joint {
        name: String::new(),
        parent,
        rest: Transform {
            translation,
            rotation,
            scale: Vec3::splat(scale),
        },
        in_skin: true,
    };
    let (x, z) = (Quat::from_rotation_x(-1.57), Quat::from_rotation_z(0.7));
    let keys = |target, property, values: Vec<f32>| Channel {
        target,
        property,
        interpolation: Interpolation::Linear,
        times_secs: vec![0.0, 0.5, 1.0],
        values,
    };
    let turns = |by: [f32; 3]| {
        let turn = |a: f32| (Quat::from_rotation_y(a) * z).to_array();
        by.map(turn).concat()
    };
    Character {
        skeleton: Skeleton {
            joints: vec![
                joint(None, Vec3::ZERO, x, 0.01),
                joint(Some(0), Vec3::new(0.0, 5.0, 90.0), z, 1.0),
                joint(Some(1), Vec3::new(20.0, 1.0, 0.0), z, 2.0),
                joint(Some(2), Vec3::new(10.0, 0.0, 0.0), x, 1.0),
            ],
        },
        clips: vec![RawClip {
            name: "all".into(),
            duration_secs: 1.0,
            channels: vec![
                keys(
                    1,
                    Property::Translation,
                    vec![0.0, 5.0, 90.0, 9.0, 5.0, 80.0, 0.0, 0.0, 90.0],
                ),
                keys(1, Property::Rotation, turns([0.0, 3.0, 6.0])),
                keys(2, Property::Rotation, turns([0.0, -2.0, 1.0])),
                keys(2, Property::Scale, [2.0, 3.0, 2.0].map(|s| [s; 3]).concat()),
            ],
        }],
        ..Character::default()
    }
}

#[test]
fn turned_and_scaled_joints_move_the_same() {
    let character = turned();
    let file = CharacterFile::from_character("turned", character.clone());
    let articulation: Articulation = file.articulation();
    let clip = abp1::from_character(&character, &articulation, 0).unwrap();
    let (again, warnings) = abp1::to_character(&clip);
    assert!(warnings.is_empty());
    let most = largest_distance(&character, 0, &again);
    assert!(most < 1e-5, "{most} m");
    // 3 and 6 rad, in frames half a second apart: 6 rad is not wound back to -0.28.
    let turned = clip.tracks[1].get(TrackKind::Rotation).unwrap();
    let steps = turned.windows(2).map(|pair| {
        let [a, b] = [pair[0], pair[1]].map(Vec3::from);
        a.distance(b)
    });
    assert!(steps.fold(0.0, f32::max) < 3.1);
    assert!(Vec3::from(turned[turned.len() - 1]).length() > 5.9);
    assert!(clip.tracks[0] == Default::default());
}

#[test]
fn uneven_scale_goes_along_the_axes_of_the_joint() {
    let mut character = turned();
    character.clips[0].channels[3].values[3] = 5.0;
    let file = CharacterFile::from_character("uneven", character.clone());
    let mut clip = abp1::from_character(&character, &file.articulation(), 0).unwrap();
    let (again, warnings) = abp1::to_character(&clip);
    assert!(warnings.is_empty());
    let most = largest_distance(&character, 0, &again);
    assert!(most < 1e-5, "{most} m");
    let axes = clip.tracks[2].0[TrackKind::ScaleOrientation as usize].as_mut();
    axes.unwrap()[1] = [0.5, 0.0, 0.0];
    let (_, warnings) = abp1::to_character(&clip);
    assert!(
        warnings[0]
            .what
            .starts_with("1 are scaled along axes that turn")
    );
}

#[test]
fn abp_files_are_converted_in_both_directions() {
    let human = crowd::human;
    let work = Executor::default();
    let abp1 = ConvertOptions {
        abp: Some(AbpProfile::Abp1(Abp1Options::default())),
        ..ConvertOptions::default()
    };
    let plain = ConvertOptions::default();
    let stream = convert(human(), Format::Abp, &abp1, &work).unwrap().written;
    let text = convert(human(), Format::Abpt, &plain, &work)
        .unwrap()
        .written;
    for (written, name) in [(&stream, "a.abp"), (&text, "a.abpt")] {
        let read = opened(&written.bytes, name);
        let glb = convert(read, Format::Glb, &plain, &work).unwrap().written;
        let again = opened(&glb.bytes, "a.glb");
        let most = largest_distance(human().character(), 0, again.character());
        assert!(most < 1.5e-3, "{name}: {most} m");
    }
    let error = convert(human(), Format::Glb, &abp1, &work).unwrap_err();
    assert!(error.is_argument(), "{error}");
}

/// Greatest distance of a vertex over the frames of the first clips of two figures.
fn farthest(a: &Figure, b: &Figure) -> f32 {
    let mut most = 0.0_f32;
    let clips = [&a.asset.clips[0], &b.asset.clips[0]];
    let mesh = &a.asset.mesh;
    let mut posed = PosedMesh::new(&a.asset.rig, mesh);
    for frame in 0..clips[0].frames() {
        let secs = frame as f64 / f64::from(clips[0].rate_hz());
        let [left, right] = clips.map(|clip| {
            let mut weights = mesh.morph_weights.clone();
            sample_morphs(clip, secs, Wrap::Clamp, &mut weights);
            posed
                .pose_at(clip, secs, Wrap::Clamp)
                .skinned(&weights)
                .positions
        });
        let distances = left.iter().zip(&right).map(|(a, b)| a.distance(*b));
        most = distances.fold(most, f32::max);
    }
    most
}

/// A clip as a motion stream, and the character that it shows.
fn streamed(file: &CharacterFile) -> (Vec<u8>, Figure, Figure) {
    let coded = abp2::write(
        file.character(),
        &file.articulation(),
        0,
        &MotionOptions::default(),
    )
    .unwrap();
    let mut one = file.clone();
    one.select_clips(&[0]);
    let read = one
        .decode_motion(&coded.bytes, "a.abp", &Limits::default())
        .unwrap();
    (
        coded.bytes,
        Figure::new(one).unwrap(),
        Figure::new(read).unwrap(),
    )
}

#[test]
fn a_character_shows_the_same_after_abp2() {
    let (_, before, after) = streamed(&shortened(crowd::human(), 1.0));
    let most = farthest(&before, &after);
    assert!(most > 0.0 && most < 1.01e-4, "{most} m");
    // Morph targets, expressions that turn them and joints, and animated scales.
    for name in [
        "glb/ict_head_talk_554.glb",
        "glb/AnimatedMorphCube.glb",
        "glb/RobotExpressive.glb",
    ] {
        let Some(path) = real::file(name) else {
            continue;
        };
        let (_, before, after) = streamed(&shortened(fs::open(&path).unwrap(), 1.0));
        let most = farthest(&before, &after);
        assert!(most > 0.0 && most < 1.01e-4, "{name}: {most} m");
    }
}

#[test]
fn the_face_of_a_motion_stream_is_cut_by_its_regions() {
    let mesh = |names: &[&str]| RawMesh {
        morph_names: names.iter().map(|name| (*name).to_owned()).collect(),
        morph_weights: vec![0.0; names.len()],
        ..RawMesh::default()
    };
    let meshes = [
        mesh(&["jawOpen", "eyeBlinkLeft"]),
        mesh(&["browInnerUp", "hat"]),
    ];
    let groups = abp2::morph_groups(&meshes);
    let regions: Vec<u8> = groups.iter().map(|group| group.region).collect();
    let of = |region: FaceRegion| region as u8;
    assert_eq!(
        regions,
        [
            of(FaceRegion::Jaw),
            of(FaceRegion::Eyeballs),
            of(FaceRegion::Eyebrows),
            0
        ]
    );
    // Jaw and lids move at every level, the other lid or not.
    assert_eq!([groups[0].loa, groups[1].loa, groups[3].loa], [0; 3]);

    let Some(path) = real::file("glb/ict_head_talk_554.glb") else {
        return;
    };
    let file = fs::open(&path).unwrap();
    let coded = abp2::write(
        file.character(),
        &file.articulation(),
        0,
        &MotionOptions::default(),
    )
    .unwrap();
    let jaw = u64::from(FaceRegion::Jaw as u8);
    let rule = CutRule::default().in_mask("face_region", !(1 << jaw));
    let part = cut(&coded.bytes, &coded.unit, |unit| rule.keeps(unit)).unwrap();
    assert!(part.bytes.len() < coded.bytes.len());
    let weights = |bytes: &[u8]| {
        let read = file
            .decode_motion(bytes, "a.abp", &Limits::default())
            .unwrap();
        Figure::new(read).unwrap().asset
    };
    let (whole, part) = (weights(&coded.bytes), weights(&part.bytes));
    let names: Vec<String> = file
        .character()
        .meshes
        .iter()
        .flat_map(|m| m.morph_names.clone())
        .collect();
    let mut counts = [0; 2];
    for (a, b) in whole.clips[0]
        .tracks()
        .morphs
        .iter()
        .zip(&part.clips[0].tracks().morphs)
    {
        let moves = |t: &articula_core::Track<f32>| t.values.iter().any(|w| *w != t.values[0]);
        let of_jaw = names[usize::from(a.target)].starts_with("jaw")
            || names[usize::from(a.target)].starts_with("mouth");
        if of_jaw && moves(a) {
            assert!(!moves(b), "{}", names[usize::from(a.target)]);
        } else if !of_jaw {
            assert_eq!(a.values, b.values);
        }
        counts[usize::from(of_jaw)] += usize::from(moves(a));
    }
    assert!(counts[0] > 1 && counts[1] > 1, "{counts:?}");
}

#[test]
fn a_motion_stream_knows_its_character() {
    let mut file = crowd::human();
    let (stream, ..) = streamed(&file);
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    let alone = open(&stream, "a.abp", &OpenOptions::default(), nothing);
    assert!(alone.unwrap_err().to_string().contains("--onto"));
    // Version 1 knew the character by another hash.
    let rig = Figure::new(file.clone()).unwrap().asset.rig.clone();
    let head = MotionHead::open(&stream, &StreamLimits::default()).unwrap();
    assert_eq!(head.version, 2);
    assert!(head.rig_hash != 0 && head.rig_hash != articula_build::rig_hash(&rig));
    // A prefix shows what is there.
    let whole = file
        .decode_motion(&stream, "a.abp", &Limits::default())
        .unwrap();
    let part = file.decode_motion(&stream[..stream.len() / 2], "a.abp", &Limits::default());
    assert_eq!(
        part.unwrap().character().clips[0].duration_secs,
        whole.character().clips[0].duration_secs
    );
    file.edit_character(|c| c.skeleton.joints[3].rest.translation.x += 0.01);
    let other = file.decode_motion(&stream, "a.abp", &Limits::default());
    let why = other.unwrap_err().to_string();
    assert!(
        why.contains("a.abp") && why.contains("another character"),
        "{why}"
    );
}

#[test]
fn a_motion_stream_opens_with_the_skeleton_that_it_carries() {
    let file = shortened(crowd::human(), 1.0);
    let options = MotionOptions {
        skeleton: true,
        ..MotionOptions::default()
    };
    let coded = abp2::write(file.character(), &file.articulation(), 0, &options).unwrap();
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    let alone = open(&coded.bytes, "a.abp", &OpenOptions::default(), nothing).unwrap();
    let onto = file
        .decode_motion(&coded.bytes, "a.abp", &Limits::default())
        .unwrap();
    assert_eq!(alone.character().skeleton, file.character().skeleton);
    assert_eq!(alone.character().clips, onto.character().clips);
    let [own, given] = [alone.articulation(), file.articulation()];
    for (a, b) in own.joints.iter().zip(&given.joints) {
        assert_eq!((a.level, a.region), (b.level, b.region));
    }
    assert!(alone.warnings().is_empty());
    let part = &coded.bytes[..coded.bytes.len() - 1];
    let part = open(part, "a.abp", &OpenOptions::default(), nothing).unwrap();
    assert!(
        part.warnings()[0].what.starts_with("partial: "),
        "{:?}",
        part.warnings()
    );
}

fn read_faps(bytes: &[u8], name: &str, format: DataFormat) -> FapClip {
    match open_data(bytes, name, format, &OpenOptions::default())
        .unwrap()
        .data
    {
        Data::Fap(clip) => clip,
        other => panic!("{other:?} is no FAP clip"),
    }
}

#[test]
fn files_come_back_from_fba_within_half_a_step() {
    let names = [
        "speech_synthetic",
        "expressions_synthetic",
        "xface_anger",
        "xface_beg",
        "xface_disgust",
        "xface_joy",
    ];
    for name in names {
        let Some(bytes) = real::bytes(&format!("fap/{name}.fap")) else {
            return;
        };
        let clip = read_faps(&bytes, "a.fap", DataFormat::Fap);
        for quant in [1, 4, 8] {
            let options = FbaOptions {
                quant,
                intra_every: None,
            };
            let bytes = fba::write(&clip, &options).unwrap();
            let read = fba::read(&bytes, "a", &StreamLimits::default()).unwrap();
            assert_eq!(read.frames.len(), clip.frames.len());
            // With visemes or expressions, all quantisers are 1.
            let quant = if clip.coded[0] || clip.coded[1] {
                1
            } else {
                quant
            };
            for (a, b) in read.frames.iter().zip(&clip.frames) {
                let exact = |f: &FapFrame| (f.number, f.viseme, f.expression);
                assert_eq!(exact(a), exact(b));
                for (i, (a, b)) in a.low.iter().zip(&b.low).enumerate() {
                    let step = i32::from(TABLE[i + 2].step) * i32::from(quant);
                    assert!(2 * (a - b).abs() <= step, "{name}: FAP {}", i + 3);
                }
            }
        }
    }
}

#[test]
fn a_face_clip_shows_the_same_after_afp1() {
    let Some(bytes) = real::bytes("fap/speech_synthetic.fap") else {
        return;
    };
    let clip = read_faps(&bytes, "a.fap", DataFormat::Fap);
    let written = write_faps(
        &clip,
        DataFormat::Afp,
        &AfpProfile::Afp1(Afp1Options::default()),
    )
    .unwrap();
    assert_eq!(StreamKind::of(&written.bytes), Some(StreamKind::Afp1));
    let again = read_faps(&written.bytes, "a.afp", DataFormat::Afp);
    let high = FaceLevels::all(FaceLevel::High).roles();
    // The levels of a FAP clip give its inner lips the motion of the outer ones, as AFP-1 does.
    let expected = reduce_face(&clip, &high);
    let steps = Afp1Options::default();
    let close = |a: &FapClip, b: &FapClip| {
        assert_eq!(
            (&a.name, a.rate_hz, a.frames.len()),
            (&b.name, b.rate_hz, b.frames.len())
        );
        for (a, b) in a.frames.iter().zip(&b.frames) {
            assert_eq!((a.viseme, a.expression), (b.viseme, b.expression));
            for (fap, (a, b)) in (3..).zip(a.low.iter().zip(&b.low)) {
                // Half a step, or two where the transform was smaller.
                let most = 2.0 * steps.step(fap) + 1.0;
                assert!(f64::from((a - b).abs()) <= most, "FAP {fap}: {a} {b}");
            }
        }
    };
    close(&again, &expected);
    let limits = StreamLimits::default();
    let map = articula_stream::afp1::unit(&written.bytes, &limits).unwrap();
    for (loa, level) in [FaceLevel::VeryLow, FaceLevel::Low, FaceLevel::Medium]
        .into_iter()
        .enumerate()
    {
        let rule = CutRule::default().at_most("loa", loa as u32);
        let cut = cut(&written.bytes, &map, |unit: &Unit| rule.keeps(unit)).unwrap();
        let shown = afp1::read(&cut.bytes, &FaceReadOptions::default(), &limits).unwrap();
        let roles = FaceLevels::all(level).roles();
        assert_eq!(shown.frames, expand_face(&again, &roles).frames);
    }
}

#[test]
fn a_face_clip_shows_the_same_after_afp2() {
    let Some(bytes) = real::bytes("fap/speech_synthetic.fap") else {
        return;
    };
    let clip = read_faps(&bytes, "a.fap", DataFormat::Fap);
    let written = write_faps(&clip, DataFormat::Afp, &AfpProfile::default()).unwrap();
    assert_eq!(StreamKind::of(&written.bytes), Some(StreamKind::Afp2));
    let again = read_faps(&written.bytes, "a.afp", DataFormat::Afp);
    let expected = reduce_face(&clip, &FaceLevels::all(FaceLevel::High).roles());
    assert_eq!(again.frames.len(), expected.frames.len());
    for (a, b) in again.frames.iter().zip(&expected.frames) {
        assert_eq!((a.viseme, a.expression), (b.viseme, b.expression));
        for (fap, (a, b)) in (3..).zip(a.low.iter().zip(&b.low)) {
            // 0.1 mm on an average face, and half a unit of rounding; a head turns with ten times
            // the lever of an eye.
            let lever = if (48..=50).contains(&fap) { 10.0 } else { 1.0 };
            let unit = lever * unit_mm(fap);
            let mm = unit * (a - b).abs() as f32;
            assert!(mm <= 0.1001 + unit / 2.0, "FAP {fap}: {a} {b}");
        }
    }
    let limits = StreamLimits::default();
    let map = articula_stream::abp2::motion_map(&written.bytes, &limits).unwrap();
    for (loa, level) in [FaceLevel::VeryLow, FaceLevel::Low, FaceLevel::Medium]
        .into_iter()
        .enumerate()
    {
        let rule = CutRule::default().at_most("face_loa", loa as u32);
        let cut = cut(&written.bytes, &map, |unit: &Unit| rule.keeps(unit)).unwrap();
        let shown = afp2::read(&cut.bytes, &FaceReadOptions::default(), &limits).unwrap();
        let roles = FaceLevels::all(level).roles();
        assert_eq!(shown.frames, expand_face(&again, &roles).frames);
    }
    let [whole, coarser, _] = &written.tiers[..] else {
        panic!("three tiers");
    };
    assert!(whole.error_mm_max <= 0.1 && coarser.bytes < whole.bytes);
}

#[test]
fn missing_frame_numbers_hold_the_frame_before() {
    let frame = |number, value| {
        let mut frame = FapFrame {
            number,
            viseme: Viseme {
                select1: 3,
                blend: 63,
                ..Viseme::default()
            },
            ..FapFrame::default()
        };
        frame.low[0] = value;
        frame
    };
    let clip = FapClip {
        name: "gaps".into(),
        rate_hz: 25.0,
        coded: [true; 68],
        frames: vec![frame(7, 400), frame(10, 40), frame(11, 4)],
        bridge: Some("table-1".into()),
    };
    let bytes = afp1::write(&clip, &Afp1Options::default()).unwrap();
    let read = read_faps(&bytes, "a.afp", DataFormat::Afp);
    let jaw: Vec<i32> = read.frames.iter().map(|f| f.low[0]).collect();
    assert_eq!(jaw, [400, 400, 400, 40, 4]);
    assert_eq!(read.frames[4].number, 4);
    assert_eq!(read.frames[4].viseme, clip.frames[0].viseme);
    assert_eq!(read.bridge, clip.bridge);
    let far = FapClip {
        frames: vec![frame(0, 1), frame(1 << 20, 1)],
        ..clip
    };
    assert!(afp1::write(&far, &Afp1Options::default()).is_err());
}
