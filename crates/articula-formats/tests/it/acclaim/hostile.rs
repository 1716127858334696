//! Every error names its line; counts are bounded; truncated files give a value or an error.

use super::{AMC, ASF, plain};
use articula_formats::ReadOptions;
use articula_formats::acclaim;
use articula_formats::{Limits, ReadError};

/// Replaced text of the skeleton, its replacement, and the expected error.
const SKELETON_FAULTS: &[(&str, &str, &str)] = &[
    (
        ":version",
        "version",
        "asf line 2: \"version\" found, a keyword",
    ),
    ("length 1.0", "length 0", "asf line 6: length 0"),
    ("length 1.0", "length -1", "asf line 6: length -1"),
    ("angle deg", "angle turns", "asf line 7: angle \"turns\""),
    ("order TX", "order QX", "asf line 11: \"QX\" found"),
    (
        "order TX",
        "order TX TX TX TX TX",
        "asf line 11: 10 degrees of",
    ),
    ("axis XYZ", "axis XYW", "asf line 12: axis order \"XYW\""),
    ("axis XYZ", "axis XYZX", "asf line 12: axis order"),
    ("axis XYZ", "axis", "asf line 12: axis order \"\""),
    (
        "position 0 0 0",
        "position 0 0",
        "asf line 13: position has 2",
    ),
    (
        "  begin\n     id 1",
        "  id 1",
        "asf line 16: \"id\" found, \"begin\"",
    ),
    (
        "name thigh",
        "",
        "asf line 26: the bone that begins at line 16 has no name",
    ),
    (
        "direction 0 -1 0",
        "direction 0 NaN 0",
        "asf line 19: \"NaN\"",
    ),
    ("length 4", "length 1e20", "asf line 20: \"1e20\""),
    ("length 4", "length", "asf line 20: \"\" found"),
    ("name shin", "name thigh", "asf line 27: two bones"),
    ("name shin", "name root", "asf line 27: two bones"),
    (
        "  end\n:hierarchy",
        ":hierarchy",
        "\"end\" of the bone expected; it begins at line 42",
    ),
    (
        "root joint thigh",
        "root joint knee",
        "asf line 52: \"knee\" is in :hierarchy",
    ),
    (
        "thigh shin",
        "knee shin",
        "asf line 53: \"knee\" is in :hierarchy",
    ),
    (
        "thigh shin",
        "thigh arm",
        "asf line 54: \"arm\" has two parents",
    ),
];

#[test]
fn every_fault_of_a_skeleton_names_its_line() {
    for (from, to, wanted) in SKELETON_FAULTS {
        let error = plain(&ASF.replacen(from, to, 1), None);
        let error = error.unwrap_err().to_string();
        assert!(error.contains(wanted), "{to:?}: {error}");
    }
    for text in ["", "\u{0}\u{1}glTF", ":version 1.10\n", "HIERARCHY"] {
        let error = plain(text, None).unwrap_err().to_string();
        assert!(error.contains("is this an ASF file?"), "{error}");
    }
    assert!(
        plain(&ASF[..400], None)
            .unwrap_err()
            .to_string()
            .contains("no \"end\"")
    );
}

#[test]
fn every_fault_of_a_motion_names_its_line() {
    let cases = [
        (
            "thigh 0 0 0",
            "tail 0 0 0",
            "amc line 6: the skeleton has no bone \"tail\"; use the .asf",
        ),
        (
            "\n1\n",
            "\n",
            "amc line 4: values of a bone found, the number of the first frame",
        ),
        (
            ":DEGREES",
            ":SAMPLES-PER-SECOND 0",
            "amc line 3: 0 frames per second",
        ),
        (
            ":DEGREES",
            ":SAMPLES-PER-SECOND x",
            "amc line 3: \"x\" found",
        ),
    ];
    for (from, to, wanted) in cases {
        let error = plain(ASF, Some(&AMC.replacen(from, to, 1)))
            .unwrap_err()
            .to_string();
        assert!(error.contains(wanted), "{to:?}: {error}");
    }
}

#[test]
fn oddities_are_read_with_a_warning() {
    let cases = [
        (":hierarchy", ":skin\n x 1 2\n:hierarchy", None, None),
        (
            ":hierarchy",
            ":namespace a\n:hierarchy",
            None,
            Some("unknown keyword \":namespace\""),
        ),
        (
            "id 2",
            "colour red",
            None,
            Some("asf line 28: unknown property \"colour\" of the bone"),
        ),
        (
            "axis XYZ",
            "shape round",
            None,
            Some("asf line 12: unknown property \"shape\" of the root"),
        ),
        (
            "    joint arm\n",
            "",
            None,
            Some("the bone \"arm\" is not connected"),
        ),
        ("dof rx\n", "dof l\n", Some(AMC), Some("changing lengths")),
        (
            "dof rx\n",
            "dof rx\n",
            Some(":DEGREES\n:UNKNOWN\n1\n"),
            Some("\":UNKNOWN\""),
        ),
        (
            "dof rx\n",
            "dof rx\n",
            Some("1\n3\n7\n"),
            Some("amc line 2: the frame numbers are not consecutive"),
        ),
        ("dof rx\n", "dof rx\n", Some(":DEGREES\n"), Some("no frame")),
    ];
    for (from, to, amc, wanted) in cases {
        let read = plain(&ASF.replacen(from, to, 1), amc).unwrap();
        let said: Vec<String> = read
            .warnings
            .iter()
            .map(|w| format!("{}: {}", w.at, w.what))
            .collect();
        assert_eq!(
            said.len(),
            usize::from(wanted.is_some()),
            "{to:?}: {said:?}"
        );
        assert!(
            wanted.is_none_or(|w| said[0].contains(w)),
            "{to:?}: {said:?}"
        );
    }
    let without_motion = plain(ASF, Some("")).unwrap().value;
    assert!(without_motion.character.clips.is_empty() && without_motion.frame_time_secs == 0.0);
}

#[test]
fn damaged_rows_are_left_out_with_a_warning() {
    for (rows, wanted) in [
        (
            "thigh 0 0\nshin 0\n",
            "amc line 3: 2 values of \"thigh\" found, 3 expected (its degrees of freedom",
        ),
        (
            "joint 0\nshin 0\n",
            "amc line 3: 1 values of \"joint\" found, 0 expected",
        ),
        (
            "shin 0\nroot 0 7 0 0 0 0\n",
            "amc line 4: \"root\" occurs twice in one frame; the row is left out",
        ),
        (
            "thigh 0 NaN 0\nshin 0\n",
            "amc line 3: \"NaN\" found, a number expected; the value of the row before",
        ),
    ] {
        let amc = format!("1\nroot 0 7 0 0 0 0\n{rows}");
        let read = plain(ASF, Some(&amc)).unwrap();
        assert_eq!(read.warnings.len(), 1, "{rows}");
        let told = format!("{}: {}", read.warnings[0].at, read.warnings[0].what);
        assert!(told.contains(wanted), "{told}");
    }
}

#[test]
fn depth_and_counts_are_bounded() {
    let bone = |i: usize| format!("begin\nname b{i}\ndirection 0 1 0\nlength 1\nend\n");
    let link = |i: usize| format!("b{i} b{}\n", i + 1);
    let bones: String = (0..200).map(bone).collect();
    let links: String = (0..199).map(link).collect();
    let deep = format!(":bonedata\n{bones}:hierarchy\nroot b0\n{links}");
    let error = plain(&deep, None).unwrap_err();
    assert!(
        matches!(error, ReadError::LimitExceeded { limit: 128, .. }),
        "{error}"
    );
    // A cycle without a root.
    let ring = format!(":bonedata\n{bones}:hierarchy\n{links}b199 b0\n");
    let read = plain(&ring, None).unwrap();
    assert_eq!(
        (
            read.value.character.skeleton.joints.len(),
            read.warnings.len()
        ),
        (1, 200)
    );

    let tight = |limits: Limits| {
        acclaim::read(
            ASF.as_bytes(),
            Some(AMC.as_bytes()),
            &ReadOptions::default(),
            &limits,
        )
    };
    let all = Limits::default();
    for limits in [
        Limits { nodes: 4, ..all },
        Limits { frames: 1, ..all },
        Limits {
            elements: 23,
            ..all
        },
        Limits { bytes: 10, ..all },
        Limits { depth: 2, ..all },
    ] {
        let error = tight(limits);
        assert!(
            matches!(error, Err(ReadError::LimitExceeded { .. })),
            "{limits:?}"
        );
    }
    let enough = Limits {
        nodes: 5,
        frames: 2,
        elements: 24,
        depth: 3,
        ..all
    };
    assert!(tight(enough).is_ok());
}

#[test]
fn truncated_anywhere_it_gives_a_value_or_an_error() {
    let options = ReadOptions::default();
    let limits = Limits::default();
    let skeleton = |length: usize| {
        acclaim::read(
            &ASF.as_bytes()[..length],
            Some(AMC.as_bytes()),
            &options,
            &limits,
        )
        .is_ok()
    };
    let motion = |length: usize| {
        acclaim::read(
            ASF.as_bytes(),
            Some(&AMC.as_bytes()[..length]),
            &options,
            &limits,
        )
        .is_ok()
    };
    assert!((0..ASF.find(":hierarchy").unwrap() - 1).all(|length| !skeleton(length)));
    assert!(skeleton(ASF.len()) && motion(AMC.len()));
    let good = (0..AMC.len()).filter(|&length| motion(length)).count();
    assert!((10..AMC.len() - 10).contains(&good), "{good}");
}
