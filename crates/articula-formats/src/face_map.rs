//! Face maps as JSON files: what the morph targets and expressions of a head show.
//!
//! Source: a format of this project, described in `docs/formats/face-map.md`.

use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::face_control::{FaceControl, FaceMap};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Expected form of a file, for error messages.
const FORM: &str = "{\"name\": \"…\", \"title\": \"…\", \"source\": \"…\", \"controls\": {\"name in the file\": \"jawOpen\", …}}";

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    #[serde(default)]
    title: String,
    #[serde(default)]
    source: String,
    controls: BTreeMap<String, String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    ignored: Vec<String>,
    /// Names without a meaning yet, listed for a person to edit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    unmapped: Vec<String>,
}

/// Reads a face map.
///
/// # Errors
/// [`ReadError::Malformed`] if the JSON is invalid, has an unknown member, gives a name a control that
/// does not exist, or lists it as ignored too; [`ReadError::LimitExceeded`].
pub fn parse(json: &[u8], limits: &Limits) -> Result<FaceMap, ReadError> {
    Limits::check("face map", "bytes", json.len() as u64, limits.bytes)?;
    let file: File = serde_json::from_slice(json).map_err(|e| ReadError::of_json(&e, FORM))?;
    let names = (file.controls.len() + file.ignored.len() + file.unmapped.len()) as u64;
    Limits::check("face map", "names", names, limits.nodes)?;
    let mut controls: BTreeMap<String, Option<FaceControl>> = BTreeMap::new();
    for (name, text) in file.controls {
        let control = text.parse::<FaceControl>();
        let control = control
            .map_err(|e| ReadError::malformed(format!("controls.\"{name}\""), e.to_string()))?;
        controls.insert(name, Some(control));
    }
    for name in file.ignored {
        if let Some(Some(control)) = controls.insert(name.clone(), None) {
            let what = format!("\"{name}\" is ignored, but controls says that it shows {control}");
            return Err(ReadError::malformed("ignored", what));
        }
    }
    Ok(FaceMap {
        name: file.name,
        title: file.title,
        source: file.source,
        controls,
    })
}

/// Writes a face map as indented JSON, which [`parse`] reads; `unmapped` are names without a meaning yet.
pub fn write(map: &FaceMap, unmapped: Vec<String>) -> Vec<u8> {
    let told = map.controls.iter();
    let file = File {
        name: map.name.clone(),
        title: map.title.clone(),
        source: map.source.clone(),
        controls: told
            .clone()
            .filter_map(|(name, control)| Some((name.clone(), control.as_ref()?.to_string())))
            .collect(),
        ignored: told
            .filter(|(_, control)| control.is_none())
            .map(|(name, _)| name.clone())
            .collect(),
        unmapped,
    };
    let mut bytes = serde_json::to_vec_pretty(&file).unwrap_or_default();
    bytes.push(b'\n');
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_map_is_read() {
        let told = [
            ("Smile", Some("mouthSmileLeft+mouthSmileRight")),
            ("Key 3", Some("viseme_PP")),
            ("Fat", None),
        ];
        let told = told.map(|(n, c)| (n.to_owned(), c.map(|c| c.parse().unwrap())));
        let map = FaceMap {
            name: "x".to_owned(),
            controls: told.into(),
            ..FaceMap::default()
        };
        let bytes = write(&map, vec!["Ears".to_owned()]);
        assert_eq!(parse(&bytes, &Limits::default()), Ok(map));
    }

    #[test]
    fn every_wrong_map_is_told_why() {
        for (json, wanted) in [
            ("{", "line 1"),
            (r#"{"name": "x"}"#, "controls"),
            (r#"{"name": "x", "controls": {}, "morphs": 1}"#, "morphs"),
            (
                r#"{"name": "x", "controls": {"A": "jawopen"}}"#,
                "controls.\"A\"",
            ),
            (
                r#"{"name": "x", "controls": {"A": "aa"}, "ignored": ["A"]}"#,
                "viseme_aa",
            ),
        ] {
            let error = parse(json.as_bytes(), &Limits::default()).unwrap_err();
            assert!(error.to_string().contains(wanted), "{error}");
        }
    }
}
