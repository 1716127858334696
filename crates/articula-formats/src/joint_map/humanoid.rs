//! The human bones of VRM, the names used by a file's humanoid map.
//!
//! Source: VRM 1.0 `humanoid`; VRM 0.x differs in the thumb.

use articula_core::Articulation;
use articula_core::joint_names::JointTarget;
use std::collections::HashMap;

/// Bones of trunk and head, which have no side.
const MIDDLE: [&str; 7] = [
    "hips",
    "spine",
    "chest",
    "upperChest",
    "neck",
    "head",
    "jaw",
];
const LIMBS: [&str; 9] = [
    "Eye", "UpperLeg", "LowerLeg", "Foot", "Toes", "Shoulder", "UpperArm", "LowerArm", "Hand",
];
const FINGERS: [&str; 4] = ["Index", "Middle", "Ring", "Little"];
const PARTS: [&str; 3] = ["Proximal", "Intermediate", "Distal"];

/// Returns whether VRM 1.0 has a human bone of exactly this name.
pub(crate) fn is_vrm_bone(name: &str) -> bool {
    let Some(part) = name
        .strip_prefix("left")
        .or_else(|| name.strip_prefix("right"))
    else {
        return MIDDLE.contains(&name);
    };
    let thumb = part.strip_prefix("Thumb");
    let finger = FINGERS.iter().find_map(|finger| part.strip_prefix(finger));
    LIMBS.contains(&part)
        || thumb.is_some_and(|p| ["Metacarpal", "Proximal", "Distal"].contains(&p))
        || finger.is_some_and(|p| PARTS.contains(&p))
}

/// Returns the joints that have a VRM 1.0 human bone, with its name, from their H-Anim mapping. Of
/// a spine with several joints the first is `spine`, the last `upperChest` (`chest` if there are
/// two) and one between them `chest`.
pub fn vrm_bones(articulation: &Articulation) -> Vec<(usize, String)> {
    let profile = super::builtin().iter().find(|p| p.name == "vrm-1");
    let hanim_of = |bone: &str| match profile.and_then(|p| p.target(bone)) {
        Some(JointTarget::Joint(joint)) => Some(joint.name.clone()),
        _ => None,
    };
    let bones = all_bones().filter_map(|bone| Some((hanim_of(&bone)?, bone)));
    let bone_of: HashMap<String, String> = bones.collect();
    let mut found: Vec<(usize, String)> = Vec::new();
    let mut spine = Vec::new();
    for (j, joint) in articulation.joints.iter().enumerate() {
        let hanim = joint.hanim.as_deref().unwrap_or_default();
        let bone = match hanim.get(..2) {
            Some("vl" | "vt") => {
                spine.push(j);
                None
            }
            Some("vc") => Some("neck".to_owned()),
            _ => bone_of.get(hanim).cloned(),
        };
        // Of several neck joints, the lowest is used.
        found.extend(
            bone.filter(|b| found.iter().all(|(_, f)| f != b))
                .map(|b| (j, b)),
        );
    }
    let names: &[&str] = match spine.len() {
        0 => &[],
        1 => &["spine"],
        2 => &["spine", "chest"],
        _ => &["spine", "chest", "upperChest"],
    };
    let last = spine.len().saturating_sub(1);
    let places = [0, if spine.len() == 2 { 1 } else { last / 2 }, last];
    found.extend(
        names
            .iter()
            .zip(places)
            .map(|(name, at)| (spine[at], (*name).to_owned())),
    );
    found
}

fn all_bones() -> impl Iterator<Item = String> {
    let finger = |finger: &'static str| PARTS.map(|part| format!("{finger}{part}"));
    let thumb = ["Metacarpal", "Proximal", "Distal"].map(|part| format!("Thumb{part}"));
    let parts = LIMBS.iter().map(|limb| (*limb).to_owned());
    let parts: Vec<String> = parts
        .chain(thumb)
        .chain(FINGERS.iter().flat_map(|f| finger(f)))
        .collect();
    let sided = ["left", "right"].into_iter();
    let sided = sided.flat_map(move |side| {
        let parts = parts.clone().into_iter();
        parts.map(move |part| format!("{side}{part}"))
    });
    MIDDLE.iter().map(|bone| (*bone).to_owned()).chain(sided)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_standard_has_every_bone() {
        let standard = articula_core::hanim_table::JOINTS.iter();
        let joints = standard.map(|j| articula_core::JointArticulation {
            hanim: Some(j.name.to_owned()),
            level: j.level,
            region: j.region,
        });
        let articulation = Articulation {
            profile: String::new(),
            joints: joints.collect(),
        };
        let bones = vrm_bones(&articulation);
        assert_eq!(bones.len(), 55, "{bones:?}");
        let hanim = |bone: &str| {
            let (j, _) = bones.iter().find(|(_, b)| b == bone).unwrap();
            articulation.joints[*j].hanim.clone().unwrap()
        };
        assert_eq!(hanim("hips"), "humanoid_root");
        assert_eq!(hanim("leftThumbMetacarpal"), "l_thumb1");
        assert_eq!(
            (hanim("spine"), hanim("upperChest")),
            ("vl5".into(), "vt1".into())
        );
        assert_eq!(hanim("neck"), "vc7");
        assert!(all_bones().all(|bone| is_vrm_bone(&bone)));
    }

    #[test]
    fn names_of_vrm_1() {
        for name in [
            "hips",
            "leftEye",
            "rightThumbMetacarpal",
            "leftLittleDistal",
        ] {
            assert!(is_vrm_bone(name), "{name}");
        }
        for name in [
            "Hips",
            "left",
            "leftHips",
            "rightThumbIntermediate",
            "leftIndex",
            "",
        ] {
            assert!(!is_vrm_bone(name), "{name}");
        }
    }
}
