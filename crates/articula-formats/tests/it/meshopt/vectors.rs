//! The decoder vectors of npm `meshoptimizer` (see the README in this folder).

use articula_formats::Limits;
use articula_formats::meshopt::{Filter, Mode, ViewLayout, decode};
use serde_json::Value;

/// An encoded view and its decoded bytes.
pub(crate) struct Vector {
    pub(crate) name: String,
    pub(crate) shape: ViewLayout,
    pub(crate) encoded: Vec<u8>,
    pub(crate) decoded: Vec<u8>,
}

pub(crate) fn all() -> Vec<Vector> {
    let list: Value = serde_json::from_str(include_str!("vectors.json")).unwrap();
    list.as_array().unwrap().iter().map(vector).collect()
}

fn vector(value: &Value) -> Vector {
    let text = |key: &str| value[key].as_str().unwrap();
    Vector {
        name: text("name").to_owned(),
        shape: ViewLayout {
            mode: match text("mode") {
                "ATTRIBUTES" => Mode::Attributes,
                "TRIANGLES" => Mode::Triangles,
                _ => Mode::Indices,
            },
            filter: match text("filter") {
                "OCTAHEDRAL" => Filter::Octahedral,
                "QUATERNION" => Filter::Quaternion,
                "EXPONENTIAL" => Filter::Exponential,
                "COLOR" => Filter::Color,
                _ => Filter::None,
            },
            count: value["count"].as_u64().unwrap(),
            stride: value["stride"].as_u64().unwrap(),
        },
        encoded: bytes(text("encoded")),
        decoded: bytes(text("decoded")),
    }
}

fn bytes(hex: &str) -> Vec<u8> {
    let pairs = hex.as_bytes().as_chunks::<2>().0.iter();
    pairs
        .map(|pair| u8::from_str_radix(str::from_utf8(pair).unwrap(), 16).unwrap())
        .collect()
}

#[test]
fn all_are_decoded_to_the_bit() {
    let vectors = all();
    assert_eq!(vectors.len(), 21);
    for v in vectors {
        let found = decode(&v.encoded, &v.shape, &Limits::default()).unwrap();
        assert_eq!(found, v.decoded, "{}", v.name);
    }
}

#[test]
fn cut_at_every_byte_none_is_decoded() {
    for v in all() {
        for end in 0..v.encoded.len() {
            let cut = decode(&v.encoded[..end], &v.shape, &Limits::default());
            assert!(cut.is_err(), "{} cut at {end}", v.name);
        }
        let longer = [&v.encoded[..], &[0]].concat();
        let longer = decode(&longer, &v.shape, &Limits::default());
        assert!(longer.is_err(), "{} with a byte more", v.name);
    }
}

#[test]
fn of_another_count_or_kind_none_is_decoded() {
    for v in all() {
        let other = |change: &dyn Fn(&mut ViewLayout)| {
            let mut shape = v.shape;
            change(&mut shape);
            decode(&v.encoded, &shape, &Limits::default())
        };
        for mode in [Mode::Attributes, Mode::Triangles, Mode::Indices] {
            if mode != v.shape.mode {
                assert!(other(&|s| s.mode = mode).is_err(), "{} {mode:?}", v.name);
            }
        }
        assert!(other(&|s| s.count *= 100).is_err(), "{}", v.name);
        assert!(other(&|s| s.count = 0).is_err(), "{}", v.name);
        assert!(other(&|s| s.count = 1 << 40).is_err(), "{}", v.name);
    }
}
