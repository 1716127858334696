//! Every feature by a file small enough to compute by hand, in both encodings where they differ.

use super::compare::globals;
use articula_core::source::{Channel, Character, Property};
use articula_formats::x3d::{self, X3dFile};
use articula_formats::{Limits, Parsed, ReadError};
use glam::{DVec3, Quat, Vec3, Vec4};

/// Reads text without external files.
pub(crate) fn read(text: &str) -> Result<Parsed<X3dFile>, ReadError> {
    let mut alone = |name: &str| Err(format!("{name}: nothing lies here"));
    x3d::read(text.as_bytes(), &Limits::default(), &mut alone)
}

/// Returns the content of a scene in XML, which must be read without warning.
fn shown(scene: &str) -> X3dFile {
    let read = read(&format!("<X3D version='4.0'><Scene>{scene}</Scene></X3D>")).unwrap();
    assert_eq!(read.warnings, []);
    read.value
}

/// Returns the first warning about a scene in XML.
fn warned(scene: &str) -> String {
    let read = read(&format!(
        "<X3D version='4.0'>\n<Scene>{scene}</Scene></X3D>"
    ))
    .unwrap();
    let first = read.warnings.first().expect("something is odd");
    format!("{}: {}", first.at, first.what)
}

fn positions(character: &Character, clip: Option<usize>, time: f32) -> Vec<DVec3> {
    let clip = clip.map(|c| &character.clips[c]);
    let all = globals(character, clip, time);
    all.iter().map(|g| g.translation).collect()
}

fn near(found: DVec3, wanted: [f64; 3]) {
    assert!(
        found.distance(DVec3::from_array(wanted)) < 1e-6,
        "{found} is not {wanted:?}"
    );
}

const LEG: &str =
    "<HAnimJoint DEF='root' name='humanoid_root' center='0 1 0' containerField='skeleton'>
    <HAnimJoint DEF='hip' name='l_hip' center='0.1 0.9 0'>
    <HAnimJoint DEF='knee' name='l_knee' center='0.1 0.5 0'/></HAnimJoint></HAnimJoint>";

fn humanoid(fields: &str, inside: &str) -> String {
    format!("<HAnimHumanoid name='ann' {fields}>{LEG}{inside}</HAnimHumanoid>")
}

#[test]
fn joints_stand_at_their_centers_unturned() {
    let character = shown(&humanoid("", "")).character;
    assert_eq!(character.name, "ann");
    let joints = &character.skeleton.joints;
    assert!(
        joints
            .iter()
            .all(|j| j.rest.rotation == Quat::IDENTITY && j.in_skin)
    );
    near(positions(&character, None, 0.0)[2], [0.1, 0.5, 0.0]);
    assert!(character.clips.is_empty());
}

#[test]
fn what_stands_above_is_in_metres() {
    // 100 units of a centimetre, rotated upright, and moved.
    let scene = format!(
        "<Transform translation='0 0 5' rotation='1 0 0 -1.5707963267948966'>{}</Transform>",
        humanoid("scale='2 2 2'", "")
    );
    let unit = "<unit category='length' name='cm' conversionFactor='0.01'/>";
    let text = format!("<X3D version='4.0'><head>{unit}</head><Scene>{scene}</Scene></X3D>");
    let character = read(&text).unwrap().value.character;
    near(
        positions(&character, None, 0.0)[2],
        [0.002, 0.0, 0.05 - 0.01],
    );
    let rests = character.skeleton.joints.iter().map(|j| j.rest.scale);
    assert!(rests.into_iter().all(|s| s.distance(Vec3::ONE) < 1e-6));
}

#[test]
fn a_stretched_humanoid_gets_a_joint_on_top() {
    let character = shown(&humanoid("scale='1 3 1'", "")).character;
    assert_eq!(character.skeleton.joints.len(), 4);
    assert!(!character.skeleton.joints[0].in_skin);
    near(positions(&character, None, 0.0)[3], [0.1, 1.5, 0.0]);
}

#[test]
fn stored_fields_are_a_pose() {
    let turned = LEG.replace(
        "name='l_hip'",
        "name='l_hip' rotation='0 0 1 1.5707963267948966'",
    );
    let scene = format!("<HAnimHumanoid>{turned}</HAnimHumanoid>");
    let character = shown(&scene).character;
    assert!(character.clips.is_empty(), "{:?}", character.clips);
    // 0.4 below the hip becomes 0.4 to its left.
    near(positions(&character, None, 0.0)[2], [0.5, 0.9, 0.0]);
    // Clips hold it; then the rest pose is that of the standard.
    let pose = "<HAnimPose name='raised'><HAnimJoint name='humanoid_root' translation='0 1 0'/></HAnimPose>";
    let scene = format!("<HAnimHumanoid>{turned}{pose}</HAnimHumanoid>");
    let character = shown(&scene).character;
    assert_eq!(character.clips.len(), 1);
    near(positions(&character, None, 0.0)[2], [0.1, 0.5, 0.0]);
    near(positions(&character, Some(0), 9.0)[2], [0.5, 1.9, 0.0]);
}

#[test]
fn offsets_as_translations_are_the_shape() {
    let scene = "<HAnimHumanoid>
        <HAnimJoint name='a' translation='0 1 0' containerField='skeleton'>
        <HAnimJoint name='b' translation='0.5 0 0' rotation='0 1 0 1'/></HAnimJoint></HAnimHumanoid>";
    let what = warned(scene);
    assert!(what.contains("no joint has a center"), "{what}");
    let text = format!("<X3D version='4.0'><Scene>{scene}</Scene></X3D>");
    let character = read(&text).unwrap().value.character;
    near(positions(&character, None, 0.0)[1], [0.5, 1.0, 0.0]);
    assert!(character.clips.is_empty());
}

#[test]
fn scale_orientations_are_exact() {
    // Twice as long along the diagonal of X and Y: 0.4 below the hip is half along it.
    let quarter = std::f64::consts::FRAC_PI_4;
    let turned = LEG.replace(
        "name='l_hip'",
        &format!("name='l_hip' scale='2 1 1' scaleOrientation='0 0 1 {quarter}'"),
    );
    let character = shown(&format!("<HAnimHumanoid>{turned}</HAnimHumanoid>")).character;
    // (0, -0.4) has -0.2828 along the diagonal; that much again is (-0.2, -0.2).
    near(positions(&character, None, 0.0)[2], [-0.1, 0.3, 0.0]);
}

const TRIANGLE: &str = "<Shape><IndexedFaceSet coordIndex='0 1 2 -1'>
    <Coordinate point='0 0 0 1 0 0 0 1 0'/></IndexedFaceSet></Shape>";

#[test]
fn segments_follow_their_joint() {
    let inside = format!(
        "<HAnimSegment name='l_calf'><Transform translation='0 0.5 0'>{TRIANGLE}</Transform>
         </HAnimSegment><HAnimSite name='l_toe_tip' translation='0.1 0 0.2'/>"
    );
    let leg = LEG.replace(
        "<HAnimJoint DEF='knee' name='l_knee' center='0.1 0.5 0'/>",
        &format!("<HAnimJoint DEF='knee' name='l_knee' center='0.1 0.5 0'>{inside}</HAnimJoint>"),
    );
    let file = shown(&format!(
        "<HAnimHumanoid scale='2 2 2'>{leg}</HAnimHumanoid>"
    ));
    let mesh = &file.character.meshes[0];
    assert_eq!(
        (mesh.name.as_str(), &mesh.skin.joints[..]),
        ("l_calf", &[2][..])
    );
    assert_eq!(mesh.primitives[0].positions[1], Vec3::new(2.0, 1.0, 0.0));
    let corner = super::compare::corners(&file.character, 0, None, 0.0)[1];
    near(corner, [2.0, 1.0, 0.0]);
    assert_eq!(
        (file.sites[0].joint, &*file.sites[0].name),
        (2, "l_toe_tip")
    );
    assert!(file.sites[0].offset.distance(Vec3::new(0.0, -1.0, 0.4)) < 1e-6);
}

#[test]
fn skin_follows_the_joints_that_name_its_points() {
    let leg = LEG
        .replace(
            "name='l_hip'",
            "name='l_hip' skinCoordIndex='0 1 2' skinCoordWeight='1 0.5 1'",
        )
        .replace(
            "name='l_knee'",
            "name='l_knee' skinCoordIndex='1' skinCoordWeight='0.5'",
        );
    let scene = format!(
        "<HAnimHumanoid>{leg}<Coordinate DEF='points' containerField='skinCoord'
           point='0 0 0 1 0 0 0 1 0'/><Group DEF='body' containerField='skin'><Shape>
         <IndexedFaceSet coordIndex='0 1 2 -1'><Coordinate USE='points'/></IndexedFaceSet></Shape>
         </Group></HAnimHumanoid>"
    );
    let character = shown(&scene).character;
    let (mesh, primitive) = (&character.meshes[0], &character.meshes[0].primitives[0]);
    assert_eq!((mesh.name.as_str(), primitive.influences), ("body", 2));
    assert_eq!(primitive.joints, [1, 0, 1, 2, 1, 0]);
    assert_eq!(primitive.weights, [1.0, 0.0, 0.5, 0.5, 1.0, 0.0]);
    let odd = scene.replace("'1 0.5 1'", "'3 0.5 1'");
    assert!(warned(&odd).contains("the weights of 1 points do not sum to 1"));
    let lonely = scene.replace("skinCoordIndex='0 1 2'", "skinCoordIndex='1 2 9'");
    assert!(warned(&lonely).contains("1 point indices of joints are out of range"));
}

#[test]
fn displacers_are_morph_targets() {
    let inside = "<HAnimSegment name='face'><Coordinate DEF='c' point='0 0 0 1 0 0 0 1 0'/>
        <HAnimDisplacer DEF='d' name='smile' weight='0.25' coordIndex='2' displacements='0 0 3'/>
        <Shape><IndexedFaceSet coordIndex='0 1 2 -1'><Coordinate USE='c'/></IndexedFaceSet></Shape>
        </HAnimSegment></HAnimJoint>";
    let leg = LEG.replace(
        "center='0.1 0.5 0'/>",
        &format!("center='0.1 0.5 0'>{inside}"),
    );
    let moved = "<TimeSensor DEF='grin' cycleInterval='2'/>
        <ScalarInterpolator DEF='s' key='0 0.5 1' keyValue='0 1 0.5'/>
        <ROUTE fromNode='grin' fromField='fraction_changed' toNode='s' toField='set_fraction'/>
        <ROUTE fromNode='s' fromField='value_changed' toNode='d' toField='weight'/>";
    let character = shown(&format!("<HAnimHumanoid>{leg}</HAnimHumanoid>{moved}")).character;
    let mesh = &character.meshes[0];
    assert_eq!(
        (&mesh.morph_names[..], &mesh.morph_weights[..]),
        (&["smile".to_owned()][..], &[0.25][..])
    );
    assert_eq!(
        mesh.primitives[0].morphs[0].positions[2],
        Vec3::new(0.0, 0.0, 3.0)
    );
    let clip = &character.clips[0];
    assert_eq!((clip.name.as_str(), clip.duration_secs), ("grin", 2.0));
    assert_eq!(clip.channels[0].property, Property::Weights);
    assert_eq!(clip.channels[0].times_secs, [0.0, 1.0, 2.0]);
    assert_eq!(clip.channels[0].values, [0.0, 1.0, 0.5]);
}

fn routed(interpolator: &str, field: &str) -> String {
    let sensor = "<TimeSensor DEF='bend' cycleInterval='2'/>";
    let routes = format!(
        "<ROUTE fromNode='bend' fromField='fraction_changed' toNode='i' toField='set_fraction'/>
         <ROUTE fromNode='i' fromField='value_changed' toNode='hip' toField='{field}'/>"
    );
    format!("{}{sensor}{interpolator}{routes}", humanoid("", ""))
}

fn of_hip(character: &Character) -> &Channel {
    let channels = &character.clips[0].channels;
    channels
        .iter()
        .find(|c| c.target == 1)
        .expect("the hip moves")
}

#[test]
fn routed_interpolators_are_clips() {
    let turn = "<OrientationInterpolator DEF='i' key='0 1'
        keyValue='0 0 1 0, 0 0 1 1.5707963267948966'/>";
    let character = shown(&routed(turn, "set_rotation")).character;
    assert_eq!(character.clips[0].name, "bend");
    near(positions(&character, Some(0), 2.0)[2], [0.5, 0.9, 0.0]);
    let half = 0.4 * std::f64::consts::FRAC_1_SQRT_2;
    near(
        positions(&character, Some(0), 1.0)[2],
        [0.1 + half, 0.9 - half, 0.0],
    );
    let slide = "<PositionInterpolator DEF='i' key='0 0.5' keyValue='0 0 0, 0 2 0'/>";
    let character = shown(&routed(slide, "translation")).character;
    assert_eq!(
        character.clips[0].duration_secs, 2.0,
        "the cycle, not the last key"
    );
    near(positions(&character, Some(0), 2.0)[2], [0.1, 2.5, 0.0]);
    // Two keys at one fraction form a jump.
    let jump = "<PositionInterpolator DEF='i' key='0 0.5 0.5 1'
        keyValue='0 0 0, 0 0 0, 0 2 0, 0 2 0'/>";
    let character = shown(&routed(jump, "translation")).character;
    let hip = of_hip(&character);
    assert_eq!(hip.times_secs, [0.0, 1.0f32.next_down(), 1.0, 2.0]);
    near(positions(&character, Some(0), 0.999)[1], [0.1, 0.9, 0.0]);
    near(positions(&character, Some(0), 1.0)[1], [0.1, 2.9, 0.0]);
    let back =
        "<PositionInterpolator DEF='i' key='0 0.5 0.2 7' keyValue='0 0 0, 0 1 0, 1 1 1, 1 1 1'/>";
    assert!(warned(&routed(back, "translation")).contains("2 keys decrease"));
    let colour = "<ColorInterpolator DEF='i' key='0' keyValue='0 0 0'/>";
    assert!(warned(&routed(colour, "translation")).contains("ColorInterpolator onto HAnimJoint"));
}

#[test]
fn motions_are_frames_of_angles() {
    let motion = "<HAnimMotion name='step' frameDuration='0.5' endFrame='1'
        joints='HumanoidRoot IGNORED l_knee l_hip'
        channels='3 Xposition Yposition Zposition 1 Xrotation 0 2 Zrotation Xrotation'
        values='0 0 0 99 0 0, 0 0 2 99 90 90' containerField='motions'/>";
    let character = shown(&humanoid("", motion)).character;
    let clip = &character.clips[0];
    assert_eq!((clip.name.as_str(), clip.duration_secs), ("step", 0.5));
    // Z before X: Z takes a vector that points down to +X after X has rotated it to -Z.
    let at_end = positions(&character, Some(0), 0.5);
    near(at_end[1], [0.1, 0.9, 2.0]);
    near(at_end[2], [0.1, 0.9, 1.6]);
    let lifted = motion
        .replace("0 0 0 99", "0 1 0 99")
        .replace("0 0 2 99", "0 1 2 99");
    assert!(warned(&humanoid("", &lifted)).contains("seem to be positions"));
    let unknown = motion.replace("l_hip", "tail");
    assert!(warned(&humanoid("", &unknown)).contains("there is no joint \"tail\""));
    let cut = motion.replace("99 90 90'", "99 90'");
    assert!(warned(&humanoid("", &cut)).contains("not a multiple of 6"));
    let off = motion.replace("joints=", "channelsEnabled='true true true false' joints=");
    let character = shown(&humanoid("", &off)).character;
    assert!(character.clips[0].channels.iter().all(|c| c.target == 0));
}

#[test]
fn poses_are_clips_that_take_them() {
    let poses = "<HAnimPose name='T' transitionDuration='2'><HAnimJoint name='l_hip'
        rotation='0 0 1 1.5707963267948966'/></HAnimPose>
        <HAnimPose name='now'><HAnimJoint name='l_hip' translation='0 0 1'/></HAnimPose>";
    let character = shown(&humanoid("", poses)).character;
    assert_eq!(
        (&*character.clips[0].name, character.clips[0].duration_secs),
        ("T", 2.0)
    );
    near(positions(&character, Some(0), 0.0)[2], [0.1, 0.5, 0.0]);
    near(positions(&character, Some(0), 2.0)[2], [0.5, 0.9, 0.0]);
    assert_eq!(character.clips[1].duration_secs, 0.0);
    near(positions(&character, Some(1), 0.0)[2], [0.1, 0.5, 1.0]);
    let off = "<HAnimPose name='T' enabled='false'/>";
    assert!(warned(&humanoid("", off)).contains("disabled"));
}

#[test]
fn the_older_words_of_the_classic_encoding_are_read() {
    let text = "#VRML V2.0 utf8 # a comment
        PROTO Joint [ exposedField SFVec3f center 0 0 0 field MFNode children [] ]
        { Transform { center IS center children IS children } }
        EXTERNPROTO Segment [ exposedField MFNode children ] [ \"urn:x\" \"y.wrl\" ]
        DEF Script1 Script { eventIn SFBool go field SFNode me USE Script1 url \"javascript: }\" }
        Humanoid { name \"Bob \\\"B\\\"\" version \"1.1\"
          humanoidBody [ DEF hanim_HumanoidRoot Joint { name \"HumanoidRoot\" center 0 1 0 # root
            children [ Joint { name \"l_hip\", center .1, .9, 0 children
                Segment { name \"l_thigh\" children [ Shape {
                    appearance Appearance { material DEF red Material { diffuseColor 1 0 0 } }
                    geometry IndexedFaceSet { solid FALSE coord Coordinate { point [ 0 0 0, # a
                        1 0 0 0 1 0 ] } coordIndex [ 0, 1, 2, -1 ] } } ] } } ] } ]
          joints [ USE hanim_HumanoidRoot ] }
        DEF t TimeSensor { cycleInterval 2 } DEF i OrientationInterpolator { key [ 0 1 ]
            keyValue [ 0 1 0 0, 0 1 0 1 ] }
        ROUTE t.fraction_changed TO i.set_fraction
        ROUTE i.value_changed TO hanim_HumanoidRoot.set_rotation";
    let read = read(text).unwrap();
    assert_eq!(read.warnings, []);
    let character = read.value.character;
    assert_eq!(character.name, "Bob \"B\"");
    near(positions(&character, None, 0.0)[1], [0.1, 0.9, 0.0]);
    let material = &character.materials[0];
    assert_eq!((&*material.name, material.double_sided), ("red", true));
    assert_eq!(material.base_color, Vec4::new(1.0, 0.0, 0.0, 1.0));
    assert_eq!(character.meshes[0].primitives[0].triangles, [[0, 1, 2]]);
    assert_eq!(character.clips[0].channels[0].times_secs, [0.0, 2.0]);
}

#[test]
fn both_encodings_say_the_same() {
    let xml =
        "<X3D version='3.3'><Scene><HAnimHumanoid name='a'><HAnimJoint name='x' center='0 1 0'
        containerField='skeleton'><HAnimJoint name='y' center='0 2 0'/></HAnimJoint>
        </HAnimHumanoid></Scene></X3D>";
    let classic = "#X3D V3.3 utf8\nPROFILE Immersive\nCOMPONENT HAnim:1\nMETA \"title\" \"\"
        UNIT angle radian 1.0\nHAnimHumanoid { name \"a\" skeleton HAnimJoint { name \"x\"
        center 0 1 0 children [ HAnimJoint { name \"y\" center 0 2 0 } ] } }";
    let of = |text: &str| read(text).unwrap().value;
    assert_eq!(of(xml), of(classic));
}

#[test]
fn pictures_are_asked_for_by_name() {
    let textured = |url: &str| {
        let look = format!(
            "<Shape><Appearance><Material diffuseColor='0 0 0'/><ImageTexture url='{url}'/></Appearance>"
        );
        let shape = TRIANGLE.replace("<Shape>", &look);
        let segment =
            format!("center='0.1 0.5 0'><HAnimSegment>{shape}</HAnimSegment></HAnimJoint>");
        let leg = LEG.replace("center='0.1 0.5 0'/>", &segment);
        format!("<X3D version='3.3'><Scene><HAnimHumanoid>{leg}</HAnimHumanoid></Scene></X3D>")
    };
    let of = |url: &str| {
        let mut asked = Vec::new();
        let mut resolver = |name: &str| {
            asked.push(name.to_owned());
            let known = name == "a b.png";
            known
                .then(|| b"\x89PNG".to_vec())
                .ok_or_else(|| "it is not there".to_owned())
        };
        let read = x3d::read(textured(url).as_bytes(), &Limits::default(), &mut resolver).unwrap();
        (read, asked)
    };
    let (read, asked) = of("\"x.jpg\" \"a%20b.png\"");
    assert_eq!(
        (asked, read.warnings.len()),
        (vec!["x.jpg".to_owned(), "a b.png".to_owned()], 0)
    );
    assert_eq!(read.value.character.images[0].mime_type, "image/png");
    // Up to X3D 3 a picture replaces the colour.
    assert_eq!(read.value.character.materials[0].base_color, Vec4::ONE);
    let (read, asked) = of("https://example.org/deep/a%20b.png");
    assert_eq!(asked, ["a b.png"]);
    assert!(read.warnings[0].what.contains("is not fetched"));
    let (read, _) = of("\"y.png\"");
    assert!(
        read.warnings[0]
            .what
            .contains("shown without its image: \"y.png\": it is not there")
    );
    let (read, asked) = of("data:image/png;base64,iVBORw0KGgo=");
    assert_eq!((asked.len(), read.value.character.images.len()), (0, 1));
}
