//! Feature points of a face in a file of their own, as JSON: to give points that are known, and to
//! edit those that were found (`docs/formats/face-points.md`).

use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::feature_points::{FEATURE_POINT_COUNT, PointId, feature_point_index};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Expected form of a file, for error messages.
const FORM: &str = "{\"points\": {\"9.3\": [0.0, 1.62, 0.13]}}";
/// Greatest distance from the origin, metres.
const FARTHEST: f32 = 1e6;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    points: BTreeMap<String, [f32; 3]>,
}

/// Reads feature points and their places in model space, in metres, in ascending order.
///
/// # Errors
/// [`ReadError::Malformed`] naming the line or the point: invalid JSON, an unknown member, a point
/// that the standard does not have, a place that is not finite; [`ReadError::LimitExceeded`].
pub fn read(json: &[u8], limits: &Limits) -> Result<Vec<(PointId, Vec3)>, ReadError> {
    Limits::check("file", "bytes", json.len() as u64, limits.bytes)?;
    let file: File = serde_json::from_slice(json).map_err(|e| ReadError::of_json(&e, FORM))?;
    let mut points = Vec::with_capacity(FEATURE_POINT_COUNT);
    for (name, place) in &file.points {
        let at = format!("points.{name}");
        let Some(point) = parsed(name) else {
            let what = "no such feature point, expected one such as 2.10";
            return Err(ReadError::malformed(at, what));
        };
        if !place.iter().all(|x| x.abs() <= FARTHEST) {
            let what = "the place is too far away, expected metres";
            return Err(ReadError::malformed(at, what));
        }
        points.push((point, Vec3::from(*place)));
    }
    points.sort_by_key(|(point, _)| *point);
    let twice = points.windows(2).find(|pair| pair[0].0 == pair[1].0);
    if let Some([((group, number), _), _]) = twice {
        let at = format!("points.{group}.{number}");
        return Err(ReadError::malformed(at, "the point is given twice"));
    }
    Ok(points)
}

/// Writes feature points in the format of [`read`], ending with a line feed.
pub fn write(points: &[(PointId, Vec3)]) -> Vec<u8> {
    // One line for each point, in the order of the standard.
    let line = |((group, number), place): &(PointId, Vec3)| {
        let [x, y, z] = place.to_array();
        format!("    \"{group}.{number}\": [{x:.5}, {y:.5}, {z:.5}]")
    };
    let lines: Vec<String> = points.iter().map(line).collect();
    format!("{{\n  \"points\": {{\n{}\n  }}\n}}\n", lines.join(",\n")).into_bytes()
}

/// The point that a name such as `2.10` means, if the standard has it.
pub(crate) fn parsed(name: &str) -> Option<PointId> {
    let (group, number) = name.split_once('.')?;
    let point = (group.parse().ok()?, number.parse().ok()?);
    feature_point_index(point)?;
    Some(point)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_come_back_in_the_order_of_the_standard() {
        let points = [
            ((2, 1), Vec3::new(0.0, 1.5, 0.1)),
            ((2, 10), Vec3::new(0.0, 1.52, 0.125)),
            ((9, 3), Vec3::new(-0.00012, 1.6, 0.13)),
        ];
        let back = read(&write(&points), &Limits::default()).unwrap();
        assert_eq!(back, points);
        let swapped = br#"{"points": {"2.10": [0, 1, 0], "2.1": [0, 0, 1]}}"#;
        let back = read(swapped, &Limits::default()).unwrap();
        assert_eq!(back, [((2, 1), Vec3::Z), ((2, 10), Vec3::Y)]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let cases: [(&str, &str); 6] = [
            (
                r#"{"points": {"2.15": [0, 0, 0]}}"#,
                "points.2.15: no such feature point",
            ),
            (
                r#"{"points": {"chin": [0, 0, 0]}}"#,
                "points.chin: no such feature point",
            ),
            (
                r#"{"points": {"2.1": [0, 1e30, 0]}}"#,
                "points.2.1: the place is too far",
            ),
            (
                r#"{"points": {"2.1": [0, 0, 0], "2.01": [0, 0, 1]}}"#,
                "points.2.1: the point is given twice",
            ),
            (r#"{"points": {"2.1": [0, 0]}}"#, "line 1"),
            ("{\"points\": {},\n \"place\": 1}", "line 2"),
        ];
        for (text, expected) in cases {
            let error = read(text.as_bytes(), &Limits::default()).unwrap_err();
            let shown = error.to_string();
            assert!(shown.contains(expected), "{text}: {shown}");
        }
    }
}
