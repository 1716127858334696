//! Small files that ask for much: each is refused at once, before memory is taken or time is spent.

use super::read;
use super::tiny::{Record, SECOND, Value, ascii, at, binary, figure, record, text};
use articula_formats::ReadError;
use std::time::Instant;

/// Reads a file that is refused, in both encodings.
fn refused(records: &[Record]) -> Vec<ReadError> {
    let files = [binary(7400, records), binary(7700, records), ascii(records)];
    files.iter().map(|bytes| fault(bytes)).collect()
}

/// The error of a file, which is quick even without optimisation.
#[allow(clippy::disallowed_methods, reason = "the test is about time")]
fn fault(bytes: &[u8]) -> ReadError {
    let start = Instant::now();
    let fault = read(bytes).unwrap_err();
    let secs = start.elapsed().as_secs_f32();
    assert!(secs < 3.0, "{secs} s for {fault}");
    fault
}

fn exceeds(faults: &[ReadError]) {
    for fault in faults {
        assert!(matches!(fault, ReadError::LimitExceeded { .. }), "{fault}");
    }
}

#[test]
fn an_array_that_inflates_beyond_the_file() {
    // 24 million zeros as 187 kB; the size is checked before the bytes are looked at.
    let mut bytes = binary(7400, &figure());
    let tag = b"\x08Vertices";
    let name = bytes.windows(tag.len()).position(|w| w == tag).unwrap();
    let array = name + tag.len();
    assert_eq!(bytes[array], b'd');
    for count in [24_000_000_u32, 1 << 31, u32::MAX] {
        bytes[array + 1..array + 5].copy_from_slice(&count.to_le_bytes());
        bytes[array + 5] = 1;
        exceeds(&[fault(&bytes)]);
    }
}

#[test]
fn counts_that_lie() {
    let whole = binary(7400, &figure());
    // The number of values of the first record, and their bytes.
    for place in [31, 35] {
        for lie in [1 << 31, u32::MAX, 1 << 20] {
            let mut bytes = whole.clone();
            bytes[place..place + 4].copy_from_slice(&lie.to_le_bytes());
            fault(&bytes);
        }
    }
    let text = String::from_utf8(ascii(&figure())).unwrap();
    for count in ["2147483648", "99999999999999999999"] {
        fault(text.replace("*12", &format!("*{count}")).as_bytes());
    }
}

#[test]
fn records_within_records() {
    let mut nested = record("A", vec![], vec![]);
    for _ in 0..20_000 {
        nested = record("A", vec![], vec![nested]);
    }
    let open = b"; FBX 7.4.0 project file\n".to_vec();
    let text = [open, b"A: {\n".repeat(20_000)].concat();
    exceeds(&[fault(&text)]);
    // Written by hand: each record ends where all end.
    let mut bytes = b"Kaydara FBX Binary  \0\x1a\0\xe8\x1c\0\0".to_vec();
    let end = bytes.len() + 20_000 * 14;
    for _ in 0..20_000 {
        bytes.extend((end as u32).to_le_bytes());
        bytes.extend([0; 8]);
        bytes.extend(b"\x01A");
    }
    exceeds(&[fault(&bytes)]);
    // Dropping it level by level spares the stack.
    while let Some(inner) = nested.records.pop() {
        nested = inner;
    }
}

#[test]
fn a_polygon_of_60_000_corners() {
    let mut records = figure();
    let corners = 60_000;
    let point = |corner: usize| {
        let (sin, cos) = (corner as f64 * 1e-4).sin_cos();
        let far = 10.0 + (corner % 7) as f64;
        [far * cos, far * sin, 0.0]
    };
    let points: Vec<f64> = (0..corners).flat_map(point).collect();
    let mut polygon: Vec<i32> = (0..corners as i32).collect();
    polygon[corners - 1] = -(corners as i32);
    at(&mut records, &["Objects", "Geometry", "Vertices"]).values = vec![Value::Reals(points)];
    let indices = at(&mut records, &["Objects", "Geometry", "PolygonVertexIndex"]);
    indices.values = vec![Value::Ints(polygon)];
    exceeds(&[fault(&binary(7400, &records))]);
}

#[test]
fn a_take_of_a_thousand_million_seconds() {
    let long = |secs: i64| {
        let mut records = figure();
        let stack = at(&mut records, &["Objects", "AnimationStack"]);
        stack.records[0].records[0].values[4] = Value::Long(SECOND * secs);
        records
    };
    exceeds(&refused(&long(100_000_000)));
    // Of an hour, in which nothing moves but in its first second, frames are made of this one.
    let parsed = read(&binary(7400, &long(3600))).unwrap();
    let clip = &parsed.value.character.clips[0];
    assert_eq!(clip.duration_secs, 3600.0);
    assert!(clip.channels.iter().all(|c| c.times_secs.len() < 40));
    // Of hours in which all moves, with two keys.
    let mut records = long(30_000);
    let keys = at(&mut records, &["Objects", "AnimationCurve", "KeyTime"]);
    keys.values = vec![Value::Longs(vec![0, SECOND * 30_000])];
    exceeds(&refused(&records));
}

#[test]
fn models_in_a_ring() {
    let mut records = figure();
    let connections = at(&mut records, &["Connections"]);
    // The hips hang from the spine, which hangs from them.
    connections.records[1].values[2] = Value::Long(3);
    for fault in refused(&records) {
        assert!(matches!(fault, ReadError::Malformed { .. }), "{fault}");
    }
}

#[test]
fn numbers_that_are_none() {
    let mut records = figure();
    let points = vec![f64::NAN; 12];
    at(&mut records, &["Objects", "Geometry", "Vertices"]).values = vec![Value::Reals(points)];
    fault(&binary(7400, &records));
    let mut records = figure();
    let model = at(&mut records, &["Objects", "Model"]);
    let mut huge = vec![
        text("Lcl Scaling"),
        text("Lcl Scaling"),
        text(""),
        text("A"),
    ];
    huge.extend([1e300, f64::INFINITY, f64::NAN].map(Value::Real));
    let entry = record("P", huge, vec![]);
    model
        .records
        .push(record("Properties70", vec![], vec![entry]));
    let parsed = read(&binary(7400, &records)).unwrap();
    let joints = &parsed.value.character.skeleton.joints;
    assert!(joints.iter().all(|j| j.rest.is_finite()));
}
