//! The meshopt decoder against both decoders of npm `meshoptimizer`, the plain reference and the
//! compiled one, over random data from that package's encoder (`oracle/meshopt_cases.mjs`).

use crate::judges::{ask, judges_are_here};
use articula::formats::Limits;
use articula::formats::meshopt::{Filter, Mode, ViewLayout, decode};
use serde_json::Value;

/// Views, each also with a change in its bytes.
const CASES: usize = 600;

/// One line of the script.
struct Case {
    shape: ViewLayout,
    encoded: Vec<u8>,
    reference: Option<Vec<u8>>,
    library: Option<Vec<u8>>,
}

fn cases() -> Vec<Case> {
    let words = ["20071".to_owned(), CASES.to_string()];
    let (answer, good) = ask("meshopt_cases.mjs", &words);
    assert!(good, "{answer}");
    answer.lines().map(case).collect()
}

fn case(line: &str) -> Case {
    let value: Value = serde_json::from_str(line).unwrap();
    let bytes = |key: &str| value[key].as_str().map(bytes);
    Case {
        shape: ViewLayout {
            mode: match value["mode"].as_str().unwrap() {
                "ATTRIBUTES" => Mode::Attributes,
                "TRIANGLES" => Mode::Triangles,
                _ => Mode::Indices,
            },
            filter: match value["filter"].as_str().unwrap() {
                "OCTAHEDRAL" => Filter::Octahedral,
                "QUATERNION" => Filter::Quaternion,
                "EXPONENTIAL" => Filter::Exponential,
                "COLOR" => Filter::Color,
                _ => Filter::None,
            },
            count: value["count"].as_u64().unwrap(),
            stride: value["stride"].as_u64().unwrap(),
        },
        encoded: bytes("encoded").unwrap(),
        reference: bytes("reference"),
        library: bytes("library"),
    }
}

fn bytes(hex: &str) -> Vec<u8> {
    let digit = |d: u8| char::from(d).to_digit(16).unwrap() as u8;
    let pairs = hex.as_bytes().as_chunks::<2>().0.iter();
    pairs.map(|[a, b]| digit(*a) << 4 | digit(*b)).collect()
}

/// Maximum difference of two outputs in units of the last place: the extension allows one for
/// filters that round, and none for the others.
fn apart(shape: &ViewLayout, a: &[u8], b: &[u8]) -> u32 {
    assert_eq!(a.len(), b.len());
    let rounds = !matches!(shape.filter, Filter::None | Filter::Exponential);
    if !rounds {
        return if a == b { 0 } else { u32::MAX };
    }
    let is_color = shape.filter == Filter::Color;
    let number = |bytes: &[u8]| match (bytes, is_color) {
        ([x], true) => i32::from(*x),
        ([x], false) => i32::from(*x as i8),
        (x, true) => i32::from(u16::from_le_bytes([x[0], x[1]])),
        (x, false) => i32::from(i16::from_le_bytes([x[0], x[1]])),
    };
    let size = shape.stride as usize / 4;
    let pairs = a.chunks_exact(size).zip(b.chunks_exact(size));
    let each = pairs.map(|(a, b)| number(a).abs_diff(number(b)));
    each.max().unwrap_or(0)
}

#[test]
fn decoded_as_both_of_the_makers_do() {
    if !judges_are_here() {
        return;
    }
    let (mut compared, mut accepted, mut refused) = (0, 0, 0);
    for case in cases() {
        let found = decode(&case.encoded, &case.shape, &Limits::default());
        let Some(reference) = &case.reference else {
            // Modified data that Articula decodes is decoded by the library to the same values.
            match (&found, &case.library) {
                (Ok(ours), Some(theirs)) => {
                    assert_eq!(apart(&case.shape, ours, theirs), 0, "{:?}", case.shape);
                    accepted += 1;
                }
                (Ok(_), None) => panic!("only we decode {:?}: {:02x?}", case.shape, case.encoded),
                (Err(_), _) => refused += 1,
            }
            continue;
        };
        let found = found.unwrap_or_else(|e| panic!("{:?}: {e}", case.shape));
        for theirs in [reference, case.library.as_ref().unwrap()] {
            let apart = apart(&case.shape, &found, theirs);
            assert!(apart <= 1, "{:?}: {apart} units apart", case.shape);
        }
        compared += 1;
    }
    println!("{compared} views, {accepted} changed ones decoded, {refused} refused");
    assert_eq!(compared, CASES);
    assert!(
        accepted > CASES / 4,
        "only {accepted} changed views were decoded"
    );
}
