//! Seeded mutations, and truncation at every byte, of small files in both encodings: for any bytes,
//! reading returns a value of bounded size or an error, and a value that was read can be written
//! and read again.

use articula_formats::x3d;
use articula_formats::{Limits, joint_map};
use articula_mutate::{Edit, Mutations, cut_off};

/// Number of mutations per file.
const TRIES: usize = 2000;

const XML: &str = "<?xml version='1.0'?><!DOCTYPE X3D SYSTEM 'x'><X3D version='4.0'><head>
<unit category='length' conversionFactor='0.5'/></head><Scene><Transform scale='2 2 2'>
<HAnimHumanoid DEF='h' name='ann' info='\"authorName=x\"'>
<HAnimJoint DEF='r' name='humanoid_root' center='0 1 0' containerField='skeleton'
 skinCoordIndex='0 1' skinCoordWeight='1 .5'>
<HAnimSegment name='s'><Coordinate DEF='c' point='0 0 0 1 0 0 0 1 0 1 1 0'/>
<HAnimDisplacer DEF='d' name='smile' coordIndex='2' displacements='0 0 3'/>
<Shape><Appearance><Material diffuseColor='1 0 0'/><ImageTexture url='\"a.png\"'/></Appearance>
<IndexedFaceSet convex='false' creaseAngle='1' coordIndex='0 1 3 2 -1'><Coordinate USE='c'/>
</IndexedFaceSet></Shape><Shape><Sphere radius='0.1'/></Shape></HAnimSegment>
<HAnimJoint DEF='k' name='l_hip' center='0 .5 0' rotation='1 0 0 .1' scale='1 2 1'
 scaleOrientation='0 0 1 .5' skinCoordIndex='1 2' skinCoordWeight='.5 1'>
<HAnimDisplacer name='bump' coordIndex='1' displacements='0 0 1'/>
<HAnimSite name='tip' translation='0 .1 0'/></HAnimJoint></HAnimJoint>
<Coordinate DEF='p' point='0 0 0 1 0 0 0 1 0' containerField='skinCoord'/>
<Shape containerField='skin'><IndexedTriangleSet index='0 1 2'><Coordinate USE='p'/>
</IndexedTriangleSet></Shape><HAnimJoint USE='r' containerField='joints'/>
<HAnimMotion name='m' joints='l_hip' channels='2 Xrotation Yposition' values='1 2 3 4'/>
<HAnimPose name='T' transitionDuration='1'><HAnimJoint name='l_hip' rotation='0 0 1 1'/></HAnimPose>
</HAnimHumanoid></Transform><TimeSensor DEF='t' cycleInterval='2'/>
<OrientationInterpolator DEF='i' key='0 .5 .5 1' keyValue='0 0 1 0 0 0 1 1 0 0 1 2 0 0 1 0'/>
<ROUTE fromNode='t' fromField='fraction_changed' toNode='i' toField='set_fraction'/>
<ROUTE fromNode='i' fromField='value_changed' toNode='k' toField='set_rotation'/>
<ROUTE fromNode='t' fromField='fraction_changed' toNode='d' toField='set_weight'/>
</Scene></X3D>";

const CLASSIC: &str = "#VRML V2.0 utf8\nPROTO Joint [ field SFVec3f center 0 0 0 ] { Group {} }
Humanoid { name \"ann\" scale 2 2 2 humanoidBody [ DEF r Joint { name \"HumanoidRoot\" # c
center 0 1 0 children [ Segment { name \"s\" children [ Shape { geometry IndexedFaceSet {
coord DEF c Coordinate { point [ 0 0 0, 1 0 0, 0 1 0 ] } coordIndex [ 0 1 2 -1 ] } } ]
coord USE c displacers Displacer { name \"d\" coordIndex [ 1 ] displacements [ 0 0 1 ] } }
DEF k Joint { name \"l_hip\" center 0 .5 0 rotation 1 0 0 .1 } ] } ] joints [ USE r USE k ] }
DEF t TimeSensor { cycleInterval 2 loop TRUE } DEF i PositionInterpolator { key [ 0, 1 ]
keyValue [ 0 0 0, 0 1 0 ] } ROUTE t.fraction_changed TO i.set_fraction
ROUTE i.value_changed TO k.set_translation";

/// Words of the format, inserted at random.
const WORDS: [&str; 20] = [
    "<Group>",
    "</Group>",
    "<HAnimJoint USE='r'/>",
    "USE='c'",
    "&amp;",
    "<!--",
    "]]>",
    "-1",
    "1e9",
    "-1e9",
    "99999999999",
    "NaN",
    "0",
    "{",
    "}",
    "[",
    "\"",
    "DEF r",
    "USE k",
    "#",
];

/// The numeric ones of them.
const NUMBERS: &[&str] = &["-1", "1e9", "-1e9", "99999999999", "NaN", "0"];

const MUTATIONS: Mutations<'_> = Mutations {
    edits: &[
        Edit::Truncate,
        Edit::InsertByte,
        Edit::RepeatTail,
        Edit::Word(&WORDS),
        Edit::Delete(12),
        Edit::Number(NUMBERS),
        Edit::Number(NUMBERS),
        Edit::Number(NUMBERS),
    ],
    most: 3,
};

/// Returns whether the bytes were read; panics if the value violates a guarantee.
fn survives(bytes: &[u8]) -> bool {
    let limits = Limits {
        bytes: 1 << 20,
        elements: 1 << 18,
        nodes: 1 << 10,
        ..Limits::default()
    };
    let mut picture = |_: &str| Ok(b"\x89PNG".to_vec());
    let Ok(read) = x3d::read(bytes, &limits, &mut picture) else {
        return false;
    };
    assert!(read.warnings.len() <= 1001);
    let character = read.value.character;
    for (index, joint) in character.skeleton.joints.iter().enumerate() {
        assert!(joint.parent.is_none_or(|p| p < index));
        assert!(joint.rest.is_finite());
    }
    for channel in character.clips.iter().flat_map(|c| &c.channels) {
        assert!(!channel.times_secs.is_empty());
        assert!(channel.times_secs.windows(2).all(|w| w[0] < w[1]));
        assert!(channel.values.iter().all(|v| v.is_finite()));
    }
    for mesh in &character.meshes {
        assert_eq!(mesh.skin.joints.len(), mesh.skin.inverse_bind.len());
        assert!(mesh.skin.inverse_bind.iter().all(|m| m.is_finite()));
        for primitive in &mesh.primitives {
            let vertices = primitive.positions.len();
            assert!(primitive.positions.iter().all(|p| p.is_finite()));
            assert!(primitive.normals.iter().all(|n| n.is_finite()));
            assert_eq!(primitive.weights.len(), vertices * primitive.influences);
            assert_eq!(primitive.morphs.len(), mesh.morph_names.len());
            let corners = primitive.triangles.iter().flatten();
            assert!(corners.into_iter().all(|v| (*v as usize) < vertices));
        }
    }
    let mapping = articula_build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
    let written = x3d::write(&character, &mapping.articulation, &read.value.sites).unwrap();
    let again = x3d::read(&written.bytes, &Limits::default(), &mut picture);
    // The extent of a figure may be the maximum number, and exceed it after writing by what joints
    // add.
    assert!(again.is_ok() || is_huge(&again.unwrap_err().to_string()));
    true
}

fn is_huge(error: &str) -> bool {
    error.contains("a number up to 1e9") || error.contains("too large")
}

fn check(good: &str) {
    let read = MUTATIONS.read_of(good.as_bytes(), TRIES, survives);
    // At least one mutant in ten must be read, or the test would cover little.
    assert!(
        read > TRIES / 10 && read < TRIES,
        "{read} mutants were read"
    );
}

#[test]
fn mutated_xml() {
    check(XML);
}

#[test]
fn mutated_classic_files() {
    check(CLASSIC);
}

#[test]
fn files_cut_off_at_every_byte() {
    for good in [XML, CLASSIC] {
        for bytes in cut_off(good.as_bytes()) {
            survives(bytes);
        }
    }
}
