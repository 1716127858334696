//! Hostile files: each fault once, with the message that the user reads.

use super::features::read;
use articula_formats::x3d;
use articula_formats::{Limits, ReadError};

fn refused(bytes: &[u8]) -> ReadError {
    let mut asked = |name: &str| -> Result<Vec<u8>, String> { panic!("{name} was asked for") };
    x3d::read(bytes, &Limits::default(), &mut asked).unwrap_err()
}

fn check(text: &str, wanted: &str) {
    let error = refused(text.as_bytes()).to_string();
    assert!(error.contains(wanted), "{error} lacks {wanted}");
}

const JOINT: &str = "<HAnimJoint name='a' containerField='skeleton'/>";

#[test]
fn every_wrong_xml_file_is_told_why() {
    check("", "the first line is not");
    check("hello", "line 1: the first line is not");
    check("<svg/>", "begins with <svg>, expected <X3D>");
    check("<X3D><Scene>", "line 1: the file ends before </X3D>");
    check("<X3D>\n<Scene></X3D>", "line 2: malformed XML");
    check(
        "<X3D/>",
        "without an HAnimHumanoid is not supported; give a file with",
    );
    check(
        "<X3D><HAnimHumanoid/></X3D>",
        "no joint in its field \"skeleton\"",
    );
    check("<X3D a='1' a='2'/>", "a is given twice");
    check("<X3D a=1/>", "an attribute cannot be read");
    let odd =
        |fields: &str| format!("<X3D>\n<HAnimHumanoid {fields}>{JOINT}</HAnimHumanoid></X3D>");
    check(
        &odd("center='a b c'"),
        "line 2, HAnimHumanoid: center: \"a\" found",
    );
    check(&odd("center='1 2'"), "2 numbers found, 3 expected");
    check(&odd("center='1 2 nan'"), "\"nan\" found");
    check(&odd("center='1 2 1e10'"), "\"1e10\" found");
    check(&odd("scale='0 0 0'"), "the scale of the humanoid is 0");
    check(
        &odd("scale='1e9 1e9 1e9' translation='1e9 0 0'")
            .replace("name='a'", "name='a' center='1e9 0 0'"),
        "too large",
    );
}

#[test]
fn entities_and_document_types_go_nowhere() {
    // A document type as in every file: skipped, nothing is fetched.
    let good = format!(
        "<?xml version='1.0'?><!DOCTYPE X3D PUBLIC \"ISO//Web3D//DTD X3D 4.0//EN\"
         \"http://www.web3d.org/specifications/x3d-4.0.dtd\">
         <X3D><HAnimHumanoid name='&#65;&amp;&lt;'>{JOINT}</HAnimHumanoid></X3D>"
    );
    assert_eq!(read(&good).unwrap().value.character.name, "A&<");
    // Entities that grow, entities from files, entities from remote addresses.
    let lol = "<!DOCTYPE X3D [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;\">]>";
    check(
        &format!("{lol}<X3D name='&b;'/>"),
        "an internal subset is not supported",
    );
    let file = "<!DOCTYPE X3D [<!ENTITY a SYSTEM \"file:///etc/passwd\">]>";
    check(
        &format!("{file}<X3D>&a;</X3D>"),
        "remove the part in [ ] from <!DOCTYPE>",
    );
    check(
        "<!DOCTYPE X3D SYSTEM 'a' [ <!ENTITY % p SYSTEM 'b'> %p; ]><X3D/>",
        "an internal subset",
    );
    check(
        "<X3D><Scene>&xxe;</Scene></X3D>",
        "an entity that XML does not predefine",
    );
    check("<X3D a='&xxe;'/>", "an attribute cannot be read");
    check("<X3D a='&#x110000;'/>", "an attribute cannot be read");
}

#[test]
fn every_wrong_classic_file_is_told_why() {
    check(
        "#VRML V1.0 ascii\nSeparator {}",
        "VRML 1.0 is not supported; save it as",
    );
    let classic = |body: &str| format!("#X3D V3.3 utf8\n{body}");
    check(
        &classic("}"),
        "line 2: found \"}\", expected a node or a statement",
    );
    check(
        &classic("Group"),
        "found the end of the file, expected { after Group",
    );
    check(
        &classic("Group {"),
        "found the end of the file, expected a field of Group",
    );
    check(&classic("Group { children [ "), "] at the end of a list");
    check(&classic("Group { a [ 1 2"), "] at the end of a list");
    check(
        &classic("Group { a \"b"),
        "the string has no closing quotation mark",
    );
    check(
        &classic("Group { a \"b\\"),
        "the string has no closing quotation mark",
    );
    check(&classic("Group { a ]"), "expected a value of a");
    check(&classic("ROUTE a TO b"), "ROUTE node.field TO node.field");
    check(&classic("PROTO a [ { ] } { }"), "an HAnimHumanoid");
    check(&classic("PROTO a [ "), "expected a value");
    check(&classic("DEF { }"), "expected a name");
}

#[test]
fn other_encodings_name_the_mend() {
    let of = |bytes: &[u8]| refused(bytes).to_string();
    assert!(of(b"\x1f\x8b\x08").contains("gunzip"));
    assert!(of(b"\xe0\x00\x00\x01").contains("save it as .x3d"));
    assert!(of(b"\xff\xfe<\0").contains("UTF-8"));
}

#[test]
fn names_that_lead_nowhere_are_warnings() {
    let use_before = "<X3D><HAnimHumanoid DEF='h'><Group USE='g'/><Group DEF='g'>
        <Group USE='g'/></Group><HAnimJoint USE='j' containerField='skeleton'/>
        <HAnimJoint DEF='j' containerField='skeleton'><HAnimJoint USE='j'/></HAnimJoint>
        <HAnimJoint USE='j' containerField='skeleton'/></HAnimHumanoid>
        <ROUTE fromNode='x' fromField='a' toNode='h' toField='b'/></X3D>";
    let read = read(use_before).unwrap();
    let said: Vec<&str> = read.warnings.iter().map(|w| w.what.as_str()).collect();
    let nowhere = said
        .iter()
        .filter(|w| w.starts_with("no node before this one has the name"));
    assert_eq!(nowhere.count(), 5, "{said:?}");
    assert!(said.contains(&"the joint has two parents; only the first is used"));
    assert_eq!(read.value.character.skeleton.joints.len(), 1);
}

#[test]
fn a_thousand_levels_and_more_are_refused() {
    let deep = |open: &str, close: &str| {
        format!(
            "<X3D>{}{}</X3D>",
            open.repeat(100_000),
            close.repeat(100_000)
        )
    };
    check(
        &deep("<Group>", "</Group>"),
        "levels of nesting, the limit is 128",
    );
    let classic = format!("#X3D V3.3 utf8\n{}", "Group { children ".repeat(100_000));
    check(&classic, "levels of nesting, the limit is 128");
    let brackets = format!("#X3D V3.3 utf8\nPROTO a {}", "[".repeat(100_000));
    check(&brackets, "expected a value");
    // USE makes a chain of nodes that is deeper than the file.
    let mut chain = "<X3D><Group DEF='g0'/>".to_owned();
    for i in 1..1000 {
        chain.push_str(&format!(
            "<Group DEF='g{i}'><Group USE='g{}'/></Group>",
            i - 1
        ));
    }
    check(
        &format!("{chain}</X3D>"),
        "levels of nesting, the limit is 128",
    );
}

#[test]
fn doubling_by_use_meets_the_limits() {
    let mut bomb = "<X3D><Group DEF='g0'/>".to_owned();
    for i in 1..100 {
        let last = i - 1;
        bomb.push_str(&format!(
            "<Group DEF='g{i}'><Group USE='g{last}'/><Group USE='g{last}'/></Group>"
        ));
    }
    check(&format!("{bomb}</X3D>"), "visits of nodes");
}

#[test]
fn limits_hold() {
    let scene = format!(
        "<X3D><HAnimHumanoid><HAnimJoint name='a' containerField='skeleton'><HAnimSegment>
         {}</HAnimSegment></HAnimJoint><HAnimMotion joints='a' channels='1 Xrotation'
         values='{}'/></HAnimHumanoid></X3D>",
        "<Shape><IndexedFaceSet coordIndex='0 1 2'><Coordinate point='0 0 0 1 0 0 0 1 0'/></IndexedFaceSet></Shape>"
            .repeat(50),
        "1 ".repeat(100)
    );
    let limit = |limits: Limits| {
        let mut alone = |_: &str| Err(String::new());
        let error = x3d::read(scene.as_bytes(), &limits, &mut alone).unwrap_err();
        assert!(matches!(error, ReadError::LimitExceeded { .. }), "{error}");
        error.to_string()
    };
    let usual = Limits::default();
    assert!(
        limit(Limits {
            bytes: 100,
            ..usual
        })
        .contains("bytes, the limit is 100")
    );
    assert!(
        limit(Limits {
            nodes: 100,
            ..usual
        })
        .contains("101 nodes, the limit is 100")
    );
    assert!(
        limit(Limits {
            elements: 1000,
            ..usual
        })
        .contains("decoded elements")
    );
    assert!(
        limit(Limits {
            frames: 99,
            ..usual
        })
        .contains("100 frames, the limit is 99")
    );
    assert!(limit(Limits { depth: 4, ..usual }).contains("levels of nesting"));
}

#[test]
fn one_list_used_by_many_is_counted_each_time() {
    let points = "0 0 0 ".repeat(2_000);
    let shape =
        "<Shape><IndexedFaceSet coordIndex='0 1 2'><Coordinate USE='c'/></IndexedFaceSet></Shape>";
    let scene = |uses: usize| {
        format!(
            "<X3D><HAnimHumanoid><HAnimJoint name='a' containerField='skeleton'><HAnimSegment>
             <Coordinate DEF='c' point='{points}'/>{}</HAnimSegment></HAnimJoint></HAnimHumanoid></X3D>",
            shape.repeat(uses)
        )
    };
    // Far more than the list and the shapes themselves.
    let limits = Limits {
        elements: 1 << 20,
        ..Limits::default()
    };
    let read = |uses: usize| {
        let mut alone = |_: &str| Err(String::new());
        x3d::read(scene(uses).as_bytes(), &limits, &mut alone).map(drop)
    };
    assert_eq!(read(10), Ok(()));
    let error = read(1_000).unwrap_err().to_string();
    assert!(error.contains("decoded elements"), "{error}");
}

#[test]
fn points_that_hundreds_of_faces_share_end_soon() {
    // A fan of a hundred thousand faces around one point, and a polygon of that size.
    let around: String = (1..100_000).map(|i| format!("{i} 0 1 ")).collect();
    let fan: String = (1..99_999)
        .map(|i| format!("0 {i} {} -1 ", i + 1))
        .collect();
    let polygon: String = (0..99_999).map(|i| format!("{i} ")).collect();
    for (index, fields) in [(fan, "creaseAngle='1'"), (polygon, "convex='false'")] {
        let scene = format!(
            "<X3D><HAnimHumanoid><HAnimJoint name='a' containerField='skeleton'><HAnimSegment>
             <Shape><IndexedFaceSet {fields} coordIndex='{index}'><Coordinate point='0 0 0 {around}'/>
             </IndexedFaceSet></Shape></HAnimSegment></HAnimJoint></HAnimHumanoid></X3D>"
        );
        assert!(read(&scene).is_ok());
    }
}

#[test]
fn too_many_attributes_are_refused() {
    let many: String = (0..1000).map(|i| format!(" a{i}='1'")).collect();
    check(&format!("<X3D{many}/>"), "the limit is 128");
}
