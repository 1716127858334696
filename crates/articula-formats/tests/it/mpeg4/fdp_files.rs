//! Xface's description of a face: a file by hand, and rejected files.

use super::texts::FDP;
use articula_formats::mpeg4::fdp::{self, FdpFile};
use articula_formats::{Limits, Parsed, ReadError};
use glam::{Quat, Vec3};

fn read(text: &str) -> Result<Parsed<FdpFile>, ReadError> {
    fdp::read(text.as_bytes(), &Limits::default())
}

#[test]
fn a_face_by_hand() {
    let read = read(FDP).unwrap();
    assert!(read.warnings.is_empty(), "{:?}", read.warnings);
    let face = read.value;
    let units = face.fapu;
    assert_eq!((units.ens0, units.es0, units.irisd0), (51.0, 69.5, 16.0));
    assert_eq!((units.mns0, units.mw0), (30.0, 50.0));
    assert_eq!(face.translation, Vec3::new(0.0, -1.0, -659.0));
    let quarter = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
    assert!(face.rotation.angle_between(quarter) < 1e-3);
    let source = &face.sources[0];
    assert_eq!(
        (source.alias.as_str(), source.category.as_str()),
        ("Rest", "Expression")
    );
    assert_eq!(source.meshes, ["rest.wrl"]);
    assert_eq!(source.parts, [("LeftEye".into(), "rest.wrl_1".into())]);
    let point = &face.points[0];
    assert_eq!(
        (point.point, point.mesh.as_str(), point.vertex),
        ((2, 10), "rest.wrl_3", 7)
    );
    assert_eq!(point.zone, [7, 8, 9]);
    // The file counts FAPs from 0: 17 is depress_chin.
    assert_eq!(
        (point.influences[0].fap, point.influences[0].weight),
        (18, -0.25)
    );
    assert_eq!(point.influences[1].kind, "Other <A>");
    let moved = face.moved();
    let moved: Vec<usize> = (1..=68).filter(|fap| moved[fap - 1]).collect();
    assert_eq!(moved, [18], "a weight of 0 moves nothing");
}

#[test]
fn what_is_odd_is_said() {
    let other = FDP.replace("\"0.2\"", "\"0.3\"");
    assert!(
        read(&other).unwrap().warnings[0]
            .what
            .contains("version \"0.3\"")
    );
    let unit = FDP.lines().find(|l| l.contains("fapu")).unwrap();
    let read = read(&FDP.replace(unit, "")).unwrap();
    assert!(read.warnings[0].what.contains("no <fapu>"));
}

#[test]
fn nothing_is_fetched_or_expanded() {
    let bombs = [
        "<!DOCTYPE xfdp SYSTEM \"file:///etc/passwd\">",
        "<!DOCTYPE x [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>",
    ];
    for bomb in bombs {
        let error = read(&FDP.replace("<xfdp>", &format!("{bomb}<xfdp>"))).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("a document type is not supported; remove"),
            "{error}"
        );
    }
    let error = read(&FDP.replace("7 8", "&a;")).unwrap_err().to_string();
    assert!(
        error.contains("line 17: an entity is not supported"),
        "{error}"
    );
    assert!(read(&FDP.replace("rest.wrl_3", "&a;")).is_err());
}

#[test]
fn faults_name_their_line() {
    let cases = [
        (
            "<xfdp>",
            "<svg>",
            "line 2: the file begins with <svg>, expected <xfdp>",
        ),
        (
            "\"51\"",
            "\"wide\"",
            "line 6: ENS0=\"wide\" found, a number",
        ),
        ("\"51\"", "\"inf\"", "line 6: ENS0=\"inf\" found"),
        (
            "\"51\"",
            "\"0\"",
            "line 6: ENS0 of 0 found, a length above 0",
        ),
        ("ENS0=\"51\"", "", "line 6: ENS0=\"\" found"),
        ("2.10", "chin", "line 16: feature point \"chin\" found"),
        ("index=\"7\"", "index=\"-7\"", "line 16: index=\"-7\" found"),
        ("7 8", "7 x", "line 17: vertex \"x\" found"),
        ("fap=\"17\"", "fap=\"68\"", "line 19: fap 68 found, 0 to 67"),
        ("</fdp>", "</fdb>", "line 21: malformed XML"),
        (
            "<xfdp>",
            "<xfdp><influence fap=\"1\" weight=\"1\"/>",
            "line 2: <influence> found outside",
        ),
        (
            "<xfdp>",
            "<xfdp><indices>1</indices>",
            "line 2: <indices> found outside",
        ),
        ("<xfdp>", "<xfdp><mesh/>", "line 2: <mesh> found outside"),
    ];
    for (from, to, wanted) in cases {
        let error = read(&FDP.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.starts_with(wanted), "{to:?}: {error}");
    }
    let cut = read(FDP.trim_end().trim_end_matches("</xfdp>"))
        .unwrap_err()
        .to_string();
    assert!(cut.contains("the file ends before </xfdp>"), "{cut}");
    assert!(fdp::read(b"<xfdp>\xff</xfdp>", &Limits::default()).is_err());
    assert!(read("").is_err() && read("hello").is_err());
}

#[test]
fn what_a_file_may_ask_for_is_bounded() {
    let deep = format!("<xfdp>{}", "<a>".repeat(200));
    let many = format!(
        "<xfdp><a {}/></xfdp>",
        (0..99).map(|i| format!("b{i}='' ")).collect::<String>()
    );
    assert!(matches!(
        read(&deep),
        Err(ReadError::LimitExceeded { limit: 128, .. })
    ));
    assert!(
        read(&many)
            .unwrap_err()
            .to_string()
            .contains("too many attributes")
    );
    let limits = Limits {
        elements: 10,
        ..Limits::default()
    };
    let error = fdp::read(FDP.as_bytes(), &limits).unwrap_err();
    assert!(matches!(error, ReadError::LimitExceeded { .. }), "{error}");
}
