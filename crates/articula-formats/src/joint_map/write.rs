//! Writing of joint maps, for a person to edit.

use articula_core::Region;
use articula_core::joint_names::RigScope;
use serde::{Serialize, Serializer};

/// The content of a joint map file; lists are written in their order.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct JointMapText {
    /// Short name.
    pub name: String,
    /// Name for display.
    pub title: String,
    /// Origin of the names.
    pub source: String,
    /// The part of a human that the rig covers.
    #[serde(serialize_with = "scope", skip_serializing_if = "is_body")]
    pub scope: RigScope,
    /// Joint names of the rig with their H-Anim joints.
    #[serde(serialize_with = "members")]
    pub joints: Vec<(String, String)>,
    /// Regions with the names of their details.
    #[serde(serialize_with = "regions", skip_serializing_if = "Vec::is_empty")]
    pub helpers: Vec<(Region, Vec<String>)>,
    /// Names that are left out on purpose.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ignored: Vec<String>,
    /// Names without a meaning yet.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unmapped: Vec<String>,
}

/// Writes a joint map as indented JSON, which [`parse`](super::parse) reads.
pub fn write(map: &JointMapText) -> Vec<u8> {
    let mut bytes = serde_json::to_vec_pretty(map).unwrap_or_default();
    bytes.push(b'\n');
    bytes
}

fn is_body(scope: &RigScope) -> bool {
    *scope == RigScope::Body
}

fn scope<S: Serializer>(scope: &RigScope, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(match scope {
        RigScope::Body => "body",
        RigScope::Hand => "hand",
    })
}

fn members<S: Serializer>(joints: &[(String, String)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(joints.iter().map(|(name, joint)| (name, joint)))
}

fn regions<S: Serializer>(helpers: &[(Region, Vec<String>)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(
        helpers
            .iter()
            .map(|(region, names)| (region.to_string(), names)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_map::parse;
    use crate::limits::Limits;
    use articula_core::joint_names::JointTarget;

    #[test]
    fn a_written_map_is_read_and_keeps_its_order() {
        let own = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        let text = JointMapText {
            name: "x".to_owned(),
            scope: RigScope::Hand,
            joints: vec![own("Wrist", "l_wrist"), own("A \"thumb\"", "l_thumb1")],
            helpers: vec![(Region::Hands, vec!["Tip".to_owned()])],
            ignored: vec!["Twist".to_owned()],
            unmapped: vec!["Prop".to_owned()],
            ..JointMapText::default()
        };
        let bytes = write(&text);
        let shown = std::str::from_utf8(&bytes).unwrap();
        assert!(shown.find("Wrist") < shown.find("thumb"), "{shown}");
        let map = parse(&bytes, &Limits::default()).unwrap();
        assert_eq!((map.name.as_str(), map.scope), ("x", RigScope::Hand));
        let thumb = JointTarget::standard("l_thumb1");
        assert_eq!(map.target("A \"thumb\"").cloned(), thumb);
        assert_eq!(map.target("tip"), Some(&JointTarget::Helper(Region::Hands)));
        assert_eq!(map.target("twist"), Some(&JointTarget::Ignored));
        assert_eq!(map.target("prop"), None);
    }
}
