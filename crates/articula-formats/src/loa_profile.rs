//! A saved selection of levels of articulation, as JSON.
//!
//! Source: thesis annex E, the "level of articulation" property of its application (manual, depth,
//! complexity, zones), and 5.1 for single joints. Differs from annex E: JSON instead of XML; zones
//! are a list of names instead of one flag each; single joints and the rule of combination are
//! stored too. The format is described in `docs/formats/loa-profile.md`.

use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::loa::{MAX_HANIM_LEVEL, Rule, Selection};
use articula_core::{Complexity, Region, Zone};
use serde::{Deserialize, Serialize};

/// Expected form of a file, for error messages.
const FORM: &str =
    "{\"rule\": \"sum\", \"depth\": 3, \"complexity\": \"low\", \"zones\": [\"torso\"]}";

/// A saved selection of levels of articulation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LoaProfile {
    /// Whether the selection alone decides which joints are active; otherwise it bounds what the
    /// motion metric may choose.
    pub manual: bool,
    /// The selectors; joint names are resolved later, against a rig.
    pub selection: Selection,
}

impl Default for LoaProfile {
    fn default() -> Self {
        Self {
            manual: true,
            selection: Selection::default(),
        }
    }
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize, Default)]
#[serde(rename_all = "lowercase")]
enum RuleName {
    #[default]
    Sum,
    Restrict,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Joints {
    #[serde(default)]
    plus: Vec<String>,
    #[serde(default)]
    minus: Vec<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default = "yes")]
    manual: bool,
    #[serde(default)]
    rule: RuleName,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    depth: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    complexity: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hanim: Option<u8>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    zones: Option<Vec<String>>,
    #[serde(default)]
    joints: Joints,
}

fn yes() -> bool {
    true
}

/// Reads a saved selection. A member that is absent or null adds no selector; an empty list of
/// zones is a selector that selects no joint.
///
/// # Errors
/// [`ReadError::Malformed`] naming the line or the member: invalid JSON, an unknown member, a
/// complexity or zone that does not exist; [`ReadError::LimitExceeded`].
pub fn read(json: &[u8], limits: &Limits) -> Result<LoaProfile, ReadError> {
    Limits::check("profile", "bytes", json.len() as u64, limits.bytes)?;
    let file: File = serde_json::from_slice(json).map_err(|e| ReadError::of_json(&e, FORM))?;
    let names = (file.joints.plus.len() + file.joints.minus.len()) as u64;
    Limits::check("joints", "joint names", names, limits.nodes)?;
    Ok(LoaProfile {
        manual: file.manual,
        selection: Selection {
            rule: match file.rule {
                RuleName::Sum => Rule::Sum,
                RuleName::Restrict => Rule::Restrict,
            },
            depth: file.depth,
            complexity: file.complexity.as_deref().map(complexity).transpose()?,
            hanim: file.hanim.map(hanim).transpose()?,
            zone: file.zones.as_deref().map(zone).transpose()?,
            plus: file.joints.plus,
            minus: file.joints.minus,
        },
    })
}

/// Writes a selection in the format of [`read`], ending with a line feed.
pub fn write(profile: &LoaProfile) -> Vec<u8> {
    let selection = &profile.selection;
    let zones = |zone: Zone| {
        let regions = Region::ALL.into_iter().filter(move |r| zone.contains(*r));
        regions.map(|r| r.to_string()).collect()
    };
    let file = File {
        manual: profile.manual,
        rule: match selection.rule {
            Rule::Sum => RuleName::Sum,
            Rule::Restrict => RuleName::Restrict,
        },
        depth: selection.depth,
        complexity: selection.complexity.map(|c| c.to_string()),
        hanim: selection.hanim,
        zones: selection.zone.map(zones),
        joints: Joints {
            plus: selection.plus.clone(),
            minus: selection.minus.clone(),
        },
    };
    // Cannot fail: strings, numbers and lists always have a JSON form.
    let mut text = serde_json::to_vec_pretty(&file).unwrap_or_default();
    text.push(b'\n');
    text
}

fn complexity(name: &str) -> Result<Complexity, ReadError> {
    name.parse().map_err(|_| {
        let known = Complexity::ALL.map(|c| c.to_string()).join(", ");
        ReadError::malformed(
            "complexity",
            format!("\"{name}\" found, expected one of {known}"),
        )
    })
}

fn hanim(level: u8) -> Result<u8, ReadError> {
    if level > MAX_HANIM_LEVEL {
        let what = format!("{level} found, expected a level of 0 to {MAX_HANIM_LEVEL}");
        return Err(ReadError::malformed("hanim", what));
    }
    Ok(level)
}

fn zone(names: &[String]) -> Result<Zone, ReadError> {
    let mut all = Zone::default();
    for (index, name) in names.iter().enumerate() {
        let zone = name.parse().map_err(|_| {
            let known = Region::ALL.map(|r| r.to_string()).join(", ");
            let what =
                format!("\"{name}\" found; expected {known}, upper, lower, face-shoulders or all");
            ReadError::malformed(format!("zones[{index}]"), what)
        })?;
        all = all | zone;
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(json: &str, wanted: &str) {
        let error = read(json.as_bytes(), &Limits::default()).unwrap_err();
        assert!(error.to_string().contains(wanted), "{error} lacks {wanted}");
    }

    #[test]
    fn the_sample_of_annex_e() {
        let json = br#"{
            "manual": true, "depth": 3, "complexity": "none", "zones": ["torso", "legs"]
        }"#;
        let profile = read(json, &Limits::default()).unwrap();
        let torso_and_legs = Zone::from(Region::Torso) | Region::Legs.into();
        let wanted = LoaProfile {
            manual: true,
            selection: Selection {
                rule: Rule::Sum,
                depth: Some(3),
                complexity: Some(Complexity::None),
                hanim: None,
                zone: Some(torso_and_legs),
                plus: vec![],
                minus: vec![],
            },
        };
        assert_eq!(profile, wanted);
        assert_eq!(read(&write(&profile), &Limits::default()), Ok(wanted));
    }

    #[test]
    fn absent_is_told_from_empty() {
        let read = |json: &str| read(json.as_bytes(), &Limits::default()).unwrap();
        assert_eq!(read("{}"), LoaProfile::default());
        assert_eq!(read(r#"{"zones": null}"#).selection.zone, None);
        assert_eq!(
            read(r#"{"zones": []}"#).selection.zone,
            Some(Zone::default())
        );
        let zones = read(r#"{"zones": ["Face-Shoulders"]}"#).selection.zone;
        assert_eq!(zones, Some(Zone::FACE_SHOULDERS));
    }

    #[test]
    fn every_selection_comes_back() {
        for complexity in [None, Some(Complexity::None), Some(Complexity::VeryHigh)] {
            for rule in [Rule::Sum, Rule::Restrict] {
                let profile = LoaProfile {
                    manual: rule == Rule::Sum,
                    selection: Selection {
                        rule,
                        depth: complexity.map(|c| c as u32),
                        complexity,
                        hanim: complexity.map(|_| 2),
                        zone: complexity.map(|_| Zone::UPPER),
                        plus: vec!["l_knee".to_owned(), "odd \"name\"".to_owned()],
                        minus: vec!["Tail".to_owned()],
                    },
                };
                assert_eq!(read(&write(&profile), &Limits::default()), Ok(profile));
            }
        }
    }

    #[test]
    fn faults_name_their_member() {
        check(r#"{"dept": 3}"#, "dept");
        check(r#"{"depth": -1}"#, "line 1");
        check(r#"{"depth": 1, "depth": 2}"#, "depth");
        check(r#"{"complexity": "most"}"#, "complexity: \"most\" found");
        check(r#"{"hanim": 4}"#, "hanim: 4 found");
        check(r#"{"zones": ["torso", "tail"]}"#, "zones[1]: \"tail\"");
        check(r#"{"joints": {"add": []}}"#, "add");
        check(r#"{"rule": "both"}"#, "both");
        check("", "line 1");
    }
}
