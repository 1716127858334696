//! FBX motions and figures beside their twins in other formats.

use crate::real;
use articula::convert::{ConvertOptions, fit_clips};
use articula::{AddClipsOptions, CharacterFile, Executor, Format, OpenOptions, convert, fs, open};
use articula_core::source::{Character, evaluate};
use articula_core::{LocalPose, angle_between};
use articula_human::HumanOptions;
use glam::Affine3A;

/// Greatest difference of a retargeted motion from that of its twin: degrees and metres.
const DEGREES: f32 = 1.0;
const METRES: f32 = 2e-3;

fn opened(name: &str) -> Option<CharacterFile> {
    Some(fs::open(real::fbx_folder()?.join(name)).unwrap())
}

/// Local poses and model matrices of the first clip that is transferred to a character.
fn frames(source: &CharacterFile, onto: &CharacterFile) -> Vec<(LocalPose, Vec<Affine3A>)> {
    let options = AddClipsOptions {
        clip: Some("run".to_owned()),
        ..AddClipsOptions::default()
    };
    let fitted = fit_clips(source, onto, &options).unwrap();
    let Character { skeleton, .. } = onto.character();
    let frame = |frame: u8| {
        let mut pose: LocalPose = skeleton.joints.iter().map(|j| j.rest).collect();
        evaluate::pose(
            &fitted[0].clip,
            skeleton,
            f32::from(frame) / 30.0,
            &mut pose,
        );
        let mut model: Vec<Affine3A> = Vec::new();
        for (index, joint) in skeleton.joints.iter().enumerate() {
            let local = pose.get(index).to_affine();
            model.push(joint.parent.map_or(local, |p| model[p] * local));
        }
        (pose, model)
    };
    (0..=20).map(frame).collect()
}

/// The greatest differences of joints, in degrees and metres, of two files on a character.
fn apart(a: &CharacterFile, b: &CharacterFile, onto: &CharacterFile) -> (f32, f32) {
    let mut most = (0.0_f32, 0.0_f32);
    for ((pose, model), (pose_there, model_there)) in frames(a, onto).iter().zip(&frames(b, onto)) {
        for joint in 0..model.len() {
            let turned = angle_between(pose.rotations[joint], pose_there.rotations[joint]);
            let apart = model[joint]
                .translation
                .distance(model_there[joint].translation);
            most = (most.0.max(turned.to_degrees()), most.1.max(apart));
        }
    }
    most
}

#[test]
fn a_motion_is_retargeted_as_its_twins() {
    let (Some(fbx), Some(glb)) = (opened("pab_run.fbx"), real::file("glb/pab_arnaud.glb")) else {
        return;
    };
    // The same motion on its character, whose rest is another pose than the first frame.
    let figure = fs::open(&glb).unwrap();
    let (degrees, metres) = apart(&fbx, &figure, &figure);
    assert!(
        degrees < DEGREES && metres < METRES,
        "{degrees} degrees, {metres} m"
    );
    // The same file as GLB, on another figure.
    let converted = convert(
        fbx.clone(),
        Format::Glb,
        &ConvertOptions::default(),
        &Executor::default(),
    );
    let bytes = converted.unwrap().written.bytes;
    let mut alone = |name: &str| Err(format!("there is no {name}"));
    let written = open(&bytes, "run.glb", &OpenOptions::default(), &mut alone).unwrap();
    let human = articula_human::human(&HumanOptions::mannequin(2000)).unwrap();
    let human = CharacterFile::from_character("human", human);
    let (degrees, metres) = apart(&fbx, &written, &human);
    assert!(
        degrees < DEGREES && metres < METRES,
        "{degrees} degrees, {metres} m"
    );
}

#[test]
fn a_clip_of_mixamo_is_called_as_its_file_and_the_unit_can_be_told() {
    let file = br#"; FBX 7.4.0 project file
GlobalSettings:  {
    Properties70:  {
        P: "UnitScaleFactor", "double", "Number", "",1
    }
}
Objects:  {
    NodeAttribute: 1, "NodeAttribute::", "LimbNode" {
    }
    Model: 2, "Model::mixamorig:Hips", "LimbNode" {
        Properties70:  {
            P: "Lcl Translation", "Lcl Translation", "", "A",0,98,0
        }
    }
    AnimationStack: 3, "AnimStack::mixamo.com", "" {
        Properties70:  {
            P: "LocalStop", "KTime", "Time", "",46186158000
        }
    }
    AnimationLayer: 4, "AnimLayer::BaseLayer", "" {
    }
    AnimationCurveNode: 5, "AnimCurveNode::T", "" {
    }
    AnimationCurve: 6, "AnimCurve::", "" {
        KeyTime: *2 { a: 0,46186158000 }
        KeyValueFloat: *2 { a: 0,100 }
        KeyAttrFlags: *1 { a: 4 }
        KeyAttrDataFloat: *4 { a: 0,0,0,0 }
        KeyAttrRefCount: *1 { a: 2 }
    }
}
Connections:  {
    C: "OO",1,2
    C: "OO",2,0
    C: "OO",4,3
    C: "OO",5,4
    C: "OP",5,2,"Lcl Translation"
    C: "OP",6,5,"d|X"
}
"#;
    let mut alone = |name: &str| Err(format!("there is no {name}"));
    let mut opened = |unit_metres| {
        let options = OpenOptions {
            unit_metres,
            ..OpenOptions::default()
        };
        open(file, "Hip Hop.fbx", &options, &mut alone).unwrap()
    };
    let stated = opened(None);
    let clip = &stated.character().clips[0];
    assert_eq!((clip.name.as_str(), clip.duration_secs), ("Hip Hop", 1.0));
    let values = &clip.channels[0].values;
    assert!((values[values.len() - 3] - 1.0).abs() < 1e-6);
    assert!((stated.character().skeleton.joints[0].rest.translation.y - 0.98).abs() < 1e-6);
    let told = opened(Some(0.001));
    assert!((told.character().skeleton.joints[0].rest.translation.y - 0.098).abs() < 1e-6);
}
