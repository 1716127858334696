//! The human bones of VRM: the names that a file's own humanoid map uses.
//!
//! Source: VRM 1.0 `humanoid`; VRM 0.x differs in the thumb.

/// Name of the built-in profile that explains the bones of a humanoid map: the two versions
/// differ in what they call the joints of the thumb.
pub(super) fn profile_of(bones: &[(usize, String)]) -> &'static str {
    let old = bones
        .iter()
        .any(|(_, bone)| bone.ends_with("ThumbIntermediate"));
    if old { "vrm-0" } else { "vrm-1" }
}

/// Bones of the trunk and head; the limbs have a side.
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

/// Whether VRM 1.0 has a human bone of exactly this name.
pub fn is_vrm_bone(name: &str) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

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
