//! Joint maps as JSON files.
//!
//! Source: a format of this project, described in `docs/formats/joint-map.md`.

use super::names::{self, HAND, SIDE};
use super::standard;
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::Region;
use articula_core::joint_names::{JointMap, JointTarget, RigScope, folded};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Expected form of a file, for error messages.
const FORM: &str = "{\"name\": \"…\", \"title\": \"…\", \"source\": \"…\", \"joints\": {\"joint of the rig\": \"l_hip\", …}}";

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum FileScope {
    #[default]
    Body,
    Hand,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    #[serde(default)]
    title: String,
    #[serde(default)]
    source: String,
    #[serde(default)]
    scope: FileScope,
    #[serde(default)]
    prefixes: Vec<String>,
    #[serde(default)]
    suffixes: Vec<String>,
    joints: BTreeMap<String, String>,
    #[serde(default)]
    helpers: BTreeMap<String, Vec<String>>,
    #[serde(default)]
    ignored: Vec<String>,
    /// Names without a meaning yet, listed for a person to edit.
    #[serde(default)]
    unmapped: Vec<String>,
}

/// Reads a joint map.
///
/// # Errors
/// [`ReadError::Malformed`] if the JSON is invalid, has an unknown member, names a joint or region
/// that the standard does not have, or gives one name two meanings; [`ReadError::LimitExceeded`].
pub fn parse(json: &[u8], limits: &Limits) -> Result<JointMap, ReadError> {
    Limits::check("profile", "bytes", json.len() as u64, limits.bytes)?;
    let file: File = serde_json::from_slice(json).map_err(|e| ReadError::of_json(&e, FORM))?;
    let helpers = file.helpers.values().map(Vec::len).sum::<usize>();
    let lists = helpers + file.ignored.len() + file.unmapped.len();
    let patterns = (file.joints.len() + lists) as u64;
    Limits::check("profile", "joint name patterns", patterns, limits.nodes)?;
    let fold = |list: &[String]| list.iter().map(|s| folded(s)).collect();
    Ok(JointMap {
        prefixes: fold(&file.prefixes),
        suffixes: fold(&file.suffixes),
        targets: targets(&file)?,
        name: file.name,
        title: file.title,
        source: file.source,
        scope: match file.scope {
            FileScope::Body => RigScope::Body,
            FileScope::Hand => RigScope::Hand,
        },
    })
}

/// Returns the joint map that maps each name of the standard to itself.
pub(super) fn of_the_standard() -> JointMap {
    let named = |name: &str| {
        let joint = standard::joint(name)?;
        Some((folded(name), JointTarget::Joint(joint)))
    };
    let names = standard::all_names().chain(["HumanoidRoot"]);
    JointMap {
        name: "hanim".to_owned(),
        title: "H-Anim 1.1 and 2".to_owned(),
        source: "ISO/IEC 19774".to_owned(),
        scope: RigScope::Body,
        prefixes: vec!["hanim".to_owned()],
        suffixes: Vec::new(),
        targets: names.filter_map(named).collect(),
    }
}

fn targets(file: &File) -> Result<BTreeMap<String, JointTarget>, ReadError> {
    let mut all = BTreeMap::new();
    for (pattern, meaning) in &file.joints {
        let at = format!("joints.\"{pattern}\"");
        for (name, meaning) in names::spellings(pattern, meaning) {
            insert(&mut all, &at, name, joint_target(&at, &meaning)?)?;
        }
    }
    for (region_name, patterns) in &file.helpers {
        let at = format!("helpers.{region_name}");
        let region = region_name.parse::<Region>().map_err(|_| {
            let known = Region::ALL.map(|r| r.to_string()).join(", ");
            ReadError::malformed(&*at, format!("unknown region; the regions are {known}"))
        })?;
        for (name, _) in patterns.iter().flat_map(|p| names::spellings(p, "")) {
            insert(&mut all, &at, name, JointTarget::Helper(region))?;
        }
    }
    for (name, _) in file.ignored.iter().flat_map(|p| names::spellings(p, "")) {
        insert(&mut all, "ignored", name, JointTarget::Ignored)?;
    }
    Ok(all)
}

fn joint_target(at: &str, meaning: &str) -> Result<JointTarget, ReadError> {
    if meaning == "spine" {
        return Ok(JointTarget::Spine);
    }
    if meaning.contains(SIDE) {
        let what = format!("\"{meaning}\" needs a {SIDE} in the joint name as well");
        return Err(ReadError::malformed(at, what));
    }
    let unknown = || {
        ReadError::malformed(
            at,
            format!("\"{meaning}\" is neither an H-Anim joint nor \"spine\""),
        )
    };
    if let Some(rest) = meaning.strip_prefix(HAND) {
        let left = standard::joint(&format!("l{rest}"));
        return left.map(JointTarget::HandJoint).ok_or_else(unknown);
    }
    standard::joint(meaning)
        .map(JointTarget::Joint)
        .ok_or_else(unknown)
}

fn insert(
    all: &mut BTreeMap<String, JointTarget>,
    at: &str,
    name: String,
    target: JointTarget,
) -> Result<(), ReadError> {
    if let Some(other) = all.get(&name).filter(|other| **other != target) {
        let what = format!("the joint name \"{name}\" has two meanings: {other:?} and {target:?}");
        return Err(ReadError::malformed(at, what));
    }
    all.insert(name, target);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(json: &str, wanted: &str) {
        let error = parse(json.as_bytes(), &Limits::default()).unwrap_err();
        assert!(error.to_string().contains(wanted), "{error} lacks {wanted}");
    }

    #[test]
    fn smallest_profile_maps_both_sides() {
        let json = r#"{"name": "x", "joints": {"{side}Arm": "{side}_shoulder"}}"#;
        let profile = parse(json.as_bytes(), &Limits::default()).unwrap();
        let Some(JointTarget::Joint(joint)) = profile.target("Rig|arm.R") else {
            panic!("arm.R is not found");
        };
        assert_eq!(joint.name, "r_shoulder");
        assert!(profile.target("leg.R").is_none());
    }

    #[test]
    fn every_wrong_profile_is_told_why() {
        check("{", "line 1");
        check(r#"{"name": "x"}"#, "joints");
        check(r#"{"name": "x", "joints": {}, "bones": 1}"#, "bones");
        check(
            r#"{"name": "x", "joints": {"Tail": "tail"}}"#,
            "joints.\"Tail\"",
        );
        check(
            r#"{"name": "x", "joints": {"Arm": "{side}_shoulder"}}"#,
            "needs a {side}",
        );
        check(
            r#"{"name": "x", "joints": {}, "helpers": {"tail": []}}"#,
            "unknown region",
        );
        check(
            r#"{"name": "x", "joints": {"l_arm": "l_elbow", "{side}Arm": "{side}_shoulder"}}"#,
            "two meanings",
        );
        check(
            r#"{"name": "x", "joints": {"a": "vl5"}, "ignored": ["A"]}"#,
            "two meanings",
        );
    }

    #[test]
    fn unmapped_names_are_skipped() {
        let json = r#"{"name": "x", "joints": {"a": "vl5"}, "unmapped": ["b", "a"]}"#;
        let map = parse(json.as_bytes(), &Limits::default()).unwrap();
        assert!(map.target("b").is_none() && map.target("a").is_some());
    }

    #[test]
    fn limits_hold() {
        let tight = Limits {
            nodes: 0,
            ..Limits::default()
        };
        let json = br#"{"name": "x", "joints": {"a": "vl5"}}"#;
        assert!(matches!(
            parse(json, &tight),
            Err(ReadError::LimitExceeded { .. })
        ));
    }
}
