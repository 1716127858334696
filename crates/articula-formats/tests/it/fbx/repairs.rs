//! Each repair, in both encodings: the figure is read as without the fault, with one warning.

use super::read;
use super::tiny::{Record, Value, ascii, at, binary, connection, figure, property, record, text};
use crate::cases::case;
use articula_core::source::Character;
use articula_formats::ReadError;
use glam::Vec3;

/// Reads a figure in three encodings, after a change; the warnings of all are the same.
fn changed(change: impl Fn(&mut Vec<Record>)) -> Vec<(Character, Vec<String>)> {
    let mut records = figure();
    change(&mut records);
    let files = [
        binary(7400, &records),
        binary(7700, &records),
        ascii(&records),
    ];
    files
        .iter()
        .map(|bytes| {
            let parsed = read(bytes).unwrap_or_else(|fault| panic!("{fault}"));
            let warnings = parsed.warnings.iter();
            let said = warnings.map(|w| format!("{}: {}", w.at, w.what)).collect();
            (parsed.value.character, said)
        })
        .collect()
}

/// Checks that a change gives the same character with one warning.
fn check(told: &str, change: impl Fn(&mut Vec<Record>)) {
    let wanted = changed(|_| {});
    for ((character, said), (own, none)) in changed(change).into_iter().zip(wanted) {
        assert!(none.is_empty(), "{none:?}");
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].contains(told), "{said:?}");
        assert!(character == own, "{told}: another character");
    }
}

/// Gives the first model a property.
fn given(records: &mut [Record], entry: Record) {
    let model = at(records, &["Objects", "Model"]);
    model
        .records
        .push(record("Properties70", vec![], vec![entry]));
}

#[test]
fn the_small_file_of_the_cases_is_the_figure() {
    // It is a seed of fuzzing.
    assert_eq!(case("two_bones.fbx"), ascii(&figure()));
}

#[test]
fn the_figure_is_bound_and_moves() {
    for (character, _) in changed(|_| {}) {
        let joints = &character.skeleton.joints;
        let names: Vec<&str> = joints.iter().map(|j| j.name.as_str()).collect();
        assert_eq!(names, ["Skin", "Hips", "Spine"]);
        let bones: Vec<bool> = joints.iter().map(|j| j.in_skin).collect();
        assert_eq!(bones, [false, true, true]);
        // The clusters tell the rest, the clip holds the stored place of the hips.
        assert!(joints[1].rest.translation.length() < 1e-6);
        let clip = &character.clips[0];
        assert_eq!((clip.name.as_str(), clip.duration_secs), ("turn", 1.0));
        let held = clip.channels.iter().find(|c| c.target == 1).unwrap();
        assert!(Vec3::from_slice(&held.values).distance(Vec3::X * 0.1) < 1e-6);
        let turned = clip.channels.iter().find(|c| c.target == 2).unwrap();
        let half = 0.5_f32.sqrt();
        assert_eq!(turned.times_secs.len(), 31);
        assert!((turned.values[turned.values.len() - 2] - half).abs() < 1e-6);
        let mesh = &character.meshes[0];
        assert_eq!(mesh.skin.joints, [1, 2, 0]);
        assert_eq!(mesh.primitives[0].triangles.len(), 2);
        assert_eq!(mesh.primitives[0].joints, [0, 0, 1, 1]);
    }
}

#[test]
fn binary_data_of_a_property() {
    check("binary data", |records| {
        let mut blob = property("MoBuAttrBlindData", "Blob", &[]);
        blob.records
            .push(record("BinaryData", vec![text("0123")], vec![]));
        given(records, blob);
    });
    // Without a record of its own, which text files have not.
    let mut records = figure();
    let mut raw = property("Thumb", "Blob", &[]);
    raw.values.push(Value::Raw(vec![0, 255, 7]));
    given(&mut records, raw);
    assert_eq!(read(&binary(7400, &records)).unwrap().warnings.len(), 1);
}

#[test]
fn letters_beyond_ascii_in_a_property() {
    for place in 0..5 {
        check("beyond ASCII", |records| {
            let mut entry = property("DocumentUrl", "KString", &[]);
            entry.values.push(text("C:/mia/run.fbx"));
            let Value::Text(own) = &mut entry.values[place] else {
                panic!("a text");
            };
            own.extend("é日本".as_bytes());
            given(records, entry);
        });
    }
}

#[test]
fn names_of_joints_keep_their_letters() {
    for (character, said) in changed(|records| {
        let objects = &mut at(records, &["Objects"]).records;
        let hips = objects
            .iter_mut()
            .find(|o| matches!(&o.values[1], Value::Name(n, _) if n == "Hips"));
        hips.unwrap().values[1] = Value::Name("Hüfte".to_owned(), "Model");
    }) {
        assert_eq!(character.skeleton.joints[1].name, "Hüfte");
        assert!(said.is_empty());
    }
}

#[test]
fn connections_that_lead_nowhere() {
    let added = |record: Record| {
        move |records: &mut Vec<Record>| at(records, &["Connections"]).records.push(record.clone())
    };
    let between = connection("PP", 2, 3, Some("Lcl Rotation"));
    check("between properties", added(between));
    check("leads to no object", added(connection("OO", 777, 2, None)));
    check("leads to no object", added(connection("OO", 2, 777, None)));
    check(
        "leads to no object",
        added(connection("OP", 777, 2, Some("Lcl Scaling"))),
    );
    check("two parents", added(connection("OO", 3, 0, None)));
    check("two parents", added(connection("OO", 3, 1, None)));
}

#[test]
fn a_mesh_without_polygons() {
    let lone = |count: usize| {
        let points = record("Vertices", vec![Value::Reals(vec![0.0; count])], vec![]);
        let values = vec![
            Value::Long(900),
            Value::Name("Points".to_owned(), "Geometry"),
            text("Mesh"),
        ];
        record("Geometry", values, vec![points])
    };
    check("no points or no polygons", |records| {
        at(records, &["Objects"]).records.push(lone(3));
    });
    check("no points or no polygons", |records| {
        at(records, &["Objects"]).records.push(lone(3));
        let own = connection("OO", 900, 1, None);
        at(records, &["Connections"]).records.push(own);
    });
}

#[test]
fn every_fault_at_once_is_told_once() {
    for (_, said) in changed(|records| {
        for number in 0..3 {
            let mut entry = property(&format!("ü{number}"), "KString", &[]);
            entry
                .records
                .push(record("BinaryData", vec![text("0")], vec![]));
            given(records, entry);
            let connections = &mut at(records, &["Connections"]).records;
            connections.push(connection("PP", 2, 3, Some("X")));
            connections.push(connection("OO", 3, 0, None));
            connections.push(connection("OO", 50 + number, 0, None));
        }
    }) {
        assert_eq!(said.len(), 5, "{said:?}");
        assert!(said.iter().all(|s| s.ends_with("(and 2 more)")), "{said:?}");
    }
}

#[test]
fn what_cannot_be_mended_is_refused_with_its_place_and_advice() {
    let records = figure();
    let said = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    let whole = binary(7400, &records);
    // Within a record, and within the last block.
    let cut = said(&whole[..whole.len() / 2]);
    assert!(cut.starts_with("byte "), "{cut}");
    let mut text = ascii(&records);
    text.remove(text.len() - 2);
    let cut = said(&text);
    assert!(cut.starts_with("line "), "{cut}");
    for version in [5000, 8000] {
        let fault = read(&binary(version, &records)).unwrap_err();
        assert!(matches!(fault, ReadError::Unsupported { .. }), "{fault}");
        assert!(fault.to_string().contains("FBX 2020 binary"), "{fault}");
    }
    let mut twice = records.clone();
    let again = at(&mut twice, &["Objects"]).records[1].clone();
    at(&mut twice, &["Objects"]).records.push(again);
    let fault = said(&binary(7400, &twice));
    assert!(
        fault.starts_with("object 1:") && fault.contains("export it again"),
        "{fault}"
    );
    let empty = [record("Objects", vec![], vec![])];
    assert!(said(&ascii(&empty)).contains("give a file with a character"));
}
