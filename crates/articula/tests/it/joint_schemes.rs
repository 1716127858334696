//! The joints of H-Anim and of the thesis: regions, files of all formats, streams that are cut.

use crate::crowd::human;
use crate::real::real_data;
use crate::short::shortened;
use articula::clip_streams::abp1;
use articula::convert::{AbpProfile, ConvertOptions, write};
use articula::glam::{Affine3A, Quat, Vec3};
use articula::{CharacterFile, Executor, Format, OpenOptions, convert, fs, open};
use articula_build::JointScheme;
use articula_core::source::{Channel, Character, Interpolation, Property, RawClip, evaluate};
use articula_core::{LocalPose, Region, Zone};
use articula_stream::abp1::Abp1Options;
use articula_stream::{CutRule, StreamLimits, cut};
use std::collections::BTreeMap;

fn opened(bytes: &[u8], name: &str) -> CharacterFile {
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    open(bytes, name, &OpenOptions::default(), nothing).unwrap()
}

fn through(file: &CharacterFile, format: Format) -> CharacterFile {
    let written = write(file, format).unwrap();
    opened(&written.bytes, &format!("written.{}", format.name()))
}

/// Number of joints of a character.
fn joints(file: &CharacterFile) -> usize {
    file.character().skeleton.joints.len()
}

fn thesis() -> CharacterFile {
    let mut human = human();
    human.set_joint_scheme(JointScheme::Thesis).unwrap();
    human
}

/// The reference human as read from a GLB, so that there is a document behind it.
fn stored_human() -> CharacterFile {
    through(&human(), Format::Glb)
}

/// Model matrices of the joints at a time of a clip, by H-Anim name.
fn places(file: &CharacterFile, clip: usize, secs: f32) -> BTreeMap<String, Affine3A> {
    let Character {
        skeleton, clips, ..
    } = file.character();
    let mut pose: LocalPose = skeleton.joints.iter().map(|j| j.rest).collect();
    if let Some(clip) = clips.get(clip) {
        evaluate::pose(clip, skeleton, secs, &mut pose);
    }
    let mut model: Vec<Affine3A> = Vec::new();
    for (j, joint) in skeleton.joints.iter().enumerate() {
        let above = joint.parent.map_or(Affine3A::IDENTITY, |p| model[p]);
        model.push(above * pose.get(j).to_affine());
    }
    let joints = file.articulation().joints.into_iter().zip(model);
    joints
        .filter_map(|(entry, model)| Some((entry.hanim?, model)))
        .collect()
}

/// Largest distance of joints that both files have. A subtalar that was inserted anew has no known
/// place.
fn apart(a: &CharacterFile, b: &CharacterFile, clip: usize, secs: f32) -> f32 {
    let (a, b) = (places(a, clip, secs), places(b, clip, secs));
    let kept = a.iter().filter(|(name, _)| !name.ends_with("subtalar"));
    let pairs = kept.filter_map(|(name, a)| Some((a, b.get(name)?)));
    pairs
        .map(|(a, b)| a.translation.distance(b.translation))
        .fold(0.0, f32::max)
}

/// A clip of two seconds in which all joints turn, with keys ten times a second.
fn all_moving(file: &mut CharacterFile) {
    let joints = &file.character().skeleton.joints;
    let channel = |joint: usize| {
        let axis = Vec3::new((joint as f32).sin(), 1.0, (joint as f32).cos()).normalize();
        let turn = |k: i32| Quat::from_axis_angle(axis, 0.2 * (k as f32 + joint as f32).sin());
        let rest = joints[joint].rest.rotation;
        Channel {
            target: joint,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: (0..21).map(|k| 0.1 * k as f32).collect(),
            values: (0..21).flat_map(|k| (turn(k) * rest).to_array()).collect(),
        }
    };
    let clip = RawClip {
        name: "all".into(),
        duration_secs: 2.0,
        channels: (0..joints.len()).map(channel).collect(),
    };
    file.set_clips(vec![clip]);
}

/// Tables 3.2 to 3.4 of the thesis on the whole reference human: what it prints of the totals, and
/// of each region and level what follows from its lists.
#[test]
fn the_reference_human_has_the_regions_of_the_thesis() {
    let human = thesis();
    let joints = human.articulation().joints;
    let count = |region: Option<Region>, level: u8| {
        let is = |r: Region| region.is_none_or(|wanted| wanted == r);
        joints
            .iter()
            .filter(|j| is(j.region) && j.level <= level)
            .count()
    };
    let levels = |region| [0, 1, 2, 3, 4, 5].map(|level| count(region, level));
    assert_eq!(levels(None), [5, 10, 24, 35, 51, 89]);
    let table = [
        (Region::Face, [0, 0, 0, 0, 0, 2]),
        (Region::Arms, [2, 4, 10, 10, 10, 10]),
        (Region::Torso, [0, 1, 2, 13, 13, 25]),
        (Region::Pelvis, [3, 3, 4, 4, 4, 4]),
        (Region::Legs, [0, 2, 4, 4, 4, 4]),
        (Region::Feet, [0, 0, 4, 4, 4, 4]),
        (Region::Hands, [0, 0, 0, 0, 16, 40]),
    ];
    for (region, counts) in table {
        assert_eq!(levels(Some(region)), counts, "{region}");
    }
    let predefined = [
        ("All", 127, 89),
        ("Face", 1, 2),
        ("FaceShoulders", 7, 37),
        ("UpperBody", 71, 77),
        ("LowerBody", 56, 12),
    ];
    for (name, mask, expected) in predefined {
        let zone: Zone = name.parse().unwrap();
        let bits = Region::ALL
            .iter()
            .enumerate()
            .filter(|(_, r)| zone.contains(**r));
        assert_eq!(bits.map(|(bit, _)| 1 << bit).sum::<u32>(), mask, "{name}");
        let found = joints.iter().filter(|j| zone.contains(j.region)).count();
        assert_eq!(found, expected, "{name}");
    }
}

/// A stream is cut by the mask of a predefined region: what is left moves, the rest stays at rest.
#[test]
fn a_stream_of_the_thesis_is_cut_to_its_upper_body() {
    let mut human = thesis();
    all_moving(&mut human);
    let options = ConvertOptions {
        abp: Some(AbpProfile::Abp1(Abp1Options::default())),
        ..ConvertOptions::default()
    };
    let made = convert(human, Format::Abp, &options, &Executor::default()).unwrap();
    let bytes = made.written.bytes;
    let map = articula_stream::abp1::unit(&bytes, &StreamLimits::default()).unwrap();
    let moving = |bytes: &[u8]| {
        let file = opened(bytes, "cut.abp");
        let channels = &file.character().clips[0].channels;
        let joints: std::collections::BTreeSet<usize> = channels.iter().map(|c| c.target).collect();
        joints.len()
    };
    assert_eq!(moving(&bytes), 89);
    for (mask, expected) in [(127, 89), (1, 2), (7, 37), (71, 77), (56, 12)] {
        // Regions count from 1, their bits from 0.
        let rule = CutRule::default().in_mask("region", mask << 1);
        let cut = cut(&bytes, &map, |unit| rule.keeps(unit)).unwrap();
        assert_eq!(moving(&cut.bytes), expected, "mask {mask}");
    }
}

#[test]
fn files_of_all_formats_keep_the_scheme_and_the_motion() {
    let mut human = stored_human();
    all_moving(&mut human);
    let hanim = human.clone();
    let report = human.set_joint_scheme(JointScheme::Thesis).unwrap();
    assert_eq!(
        (report.merged.len(), report.inserted.len(), report.joints),
        (2, 2, 89)
    );
    // Between keys the joints below the ankle are within what the pieces are made for.
    assert!(report.joints_m < 1e-3 && report.skin_m < 0.03, "{report:?}");
    for format in [Format::Glb, Format::Bvh, Format::X3d] {
        let mut file = through(&human, format);
        let regions = |file: &CharacterFile| {
            let joints = file.articulation().joints;
            joints
                .iter()
                .map(|j| (j.hanim.clone(), j.level, j.region))
                .collect::<Vec<_>>()
        };
        assert_eq!(regions(&file), regions(&human), "{format:?}");
        for key in [0, 3, 11, 20] {
            let off = apart(&hanim, &file, 0, 0.1 * key as f32);
            assert!(off < 1e-4, "{format:?}, key {key}: {off} m");
        }
        file.set_joint_scheme(JointScheme::Hanim).unwrap();
        let back = through(&file, format);
        for key in [0, 3, 11, 20] {
            let secs = 0.1 * key as f32;
            let off = apart(&hanim, &back, 0, secs);
            assert!(off < 2e-4, "{format:?}, key {key}: {off} m");
        }
    }
    let written = abp1::write(
        human.character(),
        &human.articulation(),
        0,
        &Abp1Options::default(),
    );
    let streamed = opened(&written.unwrap(), "a.abp");
    assert!(apart(&hanim, &streamed, 0, 1.1) < 2e-3);
}

/// The document of a glTF file changes with the character: read again, it shows the same.
#[test]
fn a_document_shows_what_its_character_has_become() {
    let mut files = vec![stored_human()];
    if let Some(data) = real_data() {
        for name in [
            "glb/mannequiny.glb",
            "glb/pab_arnaud.glb",
            "vrm/Godette_vrm_v4.vrm",
        ] {
            files.push(fs::open(data.join(name)).unwrap());
        }
    }
    for mut file in files {
        let name = file.name().to_owned();
        let before = file.clone();
        for scheme in [JointScheme::Hanim, JointScheme::Thesis, JointScheme::Hanim] {
            let report = file.set_joint_scheme(scheme).unwrap();
            assert!(report.joints_m < 1e-4, "{name}: {report:?}");
            let again = through(&file, file.format());
            let (a, b) = (file.character(), again.character());
            assert_eq!(file.articulation(), again.articulation(), "{name}");
            assert_eq!(a.skeleton.joints.len(), b.skeleton.joints.len(), "{name}");
            for (a, b) in a.skeleton.joints.iter().zip(&b.skeleton.joints) {
                assert_eq!(
                    (&a.name, a.parent, a.in_skin),
                    (&b.name, b.parent, b.in_skin)
                );
                let off = a.rest.translation.distance(b.rest.translation);
                assert!(
                    off <= 1e-6 * a.rest.translation.length().max(1.0),
                    "{name}: {}",
                    a.name
                );
            }
            for (a, b) in a.meshes.iter().zip(&b.meshes) {
                assert_eq!(a.skin.joints, b.skin.joints, "{name}");
                for (a, b) in a.skin.inverse_bind.iter().zip(&b.skin.inverse_bind) {
                    assert!(a.abs_diff_eq(*b, 1e-3), "{name}: {a} {b}");
                }
                for (a, b) in a.primitives.iter().zip(&b.primitives) {
                    assert_eq!(a.joints, b.joints, "{name}");
                    let close = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-6;
                    assert!(a.weights.iter().zip(&b.weights).all(close), "{name}");
                }
            }
            for clip in 0..a.clips.len().min(3) {
                for secs in [0.0, 0.4] {
                    let off = apart(&before, &again, clip, secs);
                    assert!(off < 1e-3, "{name}, clip {clip}: {off} m");
                }
            }
        }
    }
}

#[test]
fn what_was_prepared_for_other_joints_is_dropped() {
    let executor = Executor::default();
    let options = articula::PrepareOptions::default();
    let prepared = articula::prepare(shortened(stored_human(), 0.5), &options, &executor).unwrap();
    let mut file = opened(&prepared.glb, "asset.glb");
    let report = file.set_joint_scheme(JointScheme::Hanim).unwrap();
    assert!(!report.drops_prepared, "nothing changes");
    assert!(
        report
            .new_index
            .iter()
            .copied()
            .eq((0..joints(&file)).map(Some))
    );
    let report = file.set_joint_scheme(JointScheme::Thesis).unwrap();
    assert!(report.drops_prepared);
    let kept: Vec<usize> = report.new_index.iter().copied().flatten().collect();
    assert!(kept.is_sorted() && report.new_index.len() - kept.len() == report.merged.len());
    assert_eq!(kept.len() + report.inserted.len(), joints(&file));
    let again = through(&file, Format::Glb);
    assert!(
        again
            .gltf()
            .unwrap()
            .document
            .prepared_parts()
            .next()
            .is_none()
    );
}
