//! The extension `ARTICULA_face`: feature points of a face, and the units of its parameters.
//!
//! The page is `docs/formats/ARTICULA_face.md`; the schema is next to it.

use super::document::Document;
use super::extension::FACE;
use crate::error::ReadError;
use crate::face_points::parsed;
use articula_core::fap_table::FapUnit;
use articula_core::feature_points::PointId;
use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// Version of the extension that is written and read.
const VERSION: u64 = 1;
/// Greatest distance from the origin, metres.
const FARTHEST: f32 = 1e6;

/// Feature points as a document stores them.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredFace {
    /// Rotation from the frame of the head (+X to the subject's left, +Y up, +Z out of the face) to
    /// model space.
    pub rotation: Quat,
    /// Distances of the neutral face by which its parameters are measured, metres.
    pub units: Vec<(FapUnit, f32)>,
    /// The points, in the order of the standard.
    pub points: Vec<StoredPoint>,
}

/// A feature point of a [`StoredFace`].
#[derive(Debug, Clone, PartialEq)]
pub struct StoredPoint {
    /// Group and number.
    pub point: PointId,
    /// Place in model space at rest, metres.
    pub position: Vec3,
    /// How it was found: `given`, `geometry`, `shapes` or `template`.
    pub source: String,
    /// 0 to 1.
    pub confidence: f32,
}

#[derive(Serialize, Deserialize)]
struct Extension {
    version: u64,
    rotation: [f32; 4],
    #[serde(default)]
    units: BTreeMap<String, f32>,
    points: BTreeMap<String, Point>,
}

#[derive(Serialize, Deserialize)]
struct Point {
    position: [f32; 3],
    source: String,
    confidence: f32,
}

impl Document {
    /// Stores feature points in the document and replaces those that it has.
    pub fn set_face(&mut self, face: &StoredFace) {
        let point = |p: &StoredPoint| {
            let stored = Point {
                position: p.position.to_array(),
                source: p.source.clone(),
                confidence: p.confidence,
            };
            (format!("{}.{}", p.point.0, p.point.1), stored)
        };
        let unit = |(unit, distance): &(FapUnit, f32)| (unit.to_string(), *distance);
        let extension = Extension {
            version: VERSION,
            rotation: face.rotation.to_array(),
            units: face.units.iter().map(unit).collect(),
            points: face.points.iter().map(point).collect(),
        };
        // Numbers and texts alone: this does not fail.
        let value = serde_json::to_value(extension).unwrap_or(Value::Null);
        self.extend(FACE, value);
    }

    /// Returns the feature points of the document; `None` if it has none.
    ///
    /// # Errors
    /// [`ReadError::Malformed`] if they cannot be read.
    pub fn face(&self) -> Result<Option<StoredFace>, ReadError> {
        let place = |member: &str| format!("extensions.{FACE}{member}");
        let stored = self.json.get("extensions").and_then(|e| e.get(FACE));
        let Some(stored) = stored else {
            return Ok(None);
        };
        let malformed = |member: &str, what: &str| ReadError::malformed(place(member), what);
        let stored = Extension::deserialize(stored).map_err(|e| malformed("", &e.to_string()))?;
        if stored.version != VERSION {
            let what = format!("version {} found, {VERSION} is read", stored.version);
            return Err(malformed(".version", &what));
        }
        let rotation = Quat::from_array(stored.rotation);
        if !(rotation.length() - 1.0).abs().le(&1e-3) {
            return Err(malformed(".rotation", "a unit quaternion is expected"));
        }
        let mut points = Vec::with_capacity(stored.points.len());
        for (name, found) in stored.points {
            let member = format!(".points.{name}");
            let Some(point) = parsed(&name) else {
                return Err(malformed(&member, "no such feature point"));
            };
            if !found.position.iter().all(|x| x.abs() <= FARTHEST) {
                return Err(malformed(
                    &member,
                    "the place is too far away, expected metres",
                ));
            }
            points.push(StoredPoint {
                point,
                position: Vec3::from(found.position),
                source: found.source,
                confidence: found.confidence.clamp(0.0, 1.0),
            });
        }
        points.sort_by_key(|p| p.point);
        points.dedup_by_key(|p| p.point);
        let unit = |unit: FapUnit| Some((unit, *stored.units.get(&unit.to_string())?));
        Ok(Some(StoredFace {
            rotation,
            units: FapUnit::DISTANCES.into_iter().filter_map(unit).collect(),
            points,
        }))
    }

    /// Removes the feature points of the document.
    pub fn remove_face(&mut self) {
        self.remove_extension(FACE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::feature_points::{FEATURE_POINTS, FeaturePointEntry};
    use serde_json::json;

    fn face() -> StoredFace {
        let point = |(index, entry): (usize, &FeaturePointEntry)| StoredPoint {
            point: entry.point,
            position: Vec3::new(0.1, index as f32, -0.25),
            source: "geometry".to_owned(),
            confidence: 0.5,
        };
        StoredFace {
            rotation: Quat::from_rotation_y(0.5),
            units: FapUnit::DISTANCES.map(|u| (u, 0.05)).to_vec(),
            points: FEATURE_POINTS.iter().enumerate().map(point).collect(),
        }
    }

    fn document() -> Document {
        Document {
            json: json!({"asset": {"version": "2.0"}}),
            buffers: Vec::new(),
            pictures: Vec::new(),
        }
    }

    #[test]
    fn points_come_back_and_go() {
        let mut document = document();
        let before = document.clone();
        assert_eq!(document.face().unwrap(), None);
        document.set_face(&face());
        assert_eq!(document.json["extensionsUsed"], json!(["ARTICULA_face"]));
        assert_eq!(document.face().unwrap(), Some(face()));
        document.set_face(&face());
        document.remove_face();
        assert_eq!(document, before);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let cases: [(&str, Value, &str); 7] = [
            (
                "/version",
                json!(2),
                "ARTICULA_face.version: version 2 found",
            ),
            ("/rotation", json!([0, 0, 0, 0]), "ARTICULA_face.rotation"),
            ("/rotation", json!([0, 0, 0]), "ARTICULA_face:"),
            ("/points", json!([]), "ARTICULA_face:"),
            (
                "/points/2.1/position",
                json!([0, 1e9, 0]),
                "points.2.1: the place is too far",
            ),
            ("/points/2.1/confidence", json!("high"), "ARTICULA_face:"),
            (
                "/points",
                json!({"2.15": {"position": [0, 0, 0], "source": "", "confidence": 1}}),
                "points.2.15: no such",
            ),
        ];
        for (member, value, expected) in cases {
            let mut document = document();
            document.set_face(&face());
            let stored = &mut document.json["extensions"][FACE];
            *stored.pointer_mut(member).unwrap() = value;
            let shown = document.face().unwrap_err().to_string();
            assert!(shown.contains(expected), "{member}: {shown}");
        }
    }
}
