//! What a control of a face shows, by its name.
//!
//! - `words`: the words of a name
//! - `synonyms`: names of many makers
//! - `table`: all known names by their words
//! - `chosen`: the controls of a face among which no two show the same
//!
//! The rules are described in `docs/formats/face-map.md`.

mod chosen;
mod synonyms;
mod table;
mod words;

pub use chosen::{ChosenControl, FaceCandidate, choose_controls};

use crate::joint_names::MappingConfidence;
use articula_core::face_control::FaceControl;
use table::{Known, TABLE};
use words::words;

/// A control that was recognised by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NamedControl {
    /// What it shows.
    pub control: FaceControl,
    /// How sure that is.
    pub confidence: MappingConfidence,
}

/// Words before or after a name that do not change its meaning: those of programs, meshes and rigs.
/// Single letters count as such too.
const AROUND: [&str; 41] = [
    "blend",
    "shape",
    "shapes",
    "blendshape",
    "blendshapes",
    "morph",
    "morphs",
    "target",
    "targets",
    "key",
    "bs",
    "div",
    "facs",
    "jnt",
    "ctrl",
    "ctr",
    "ectrl",
    "phm",
    "expression",
    "expressions",
    "exp",
    "face",
    "facial",
    "head",
    "body",
    "base",
    "cc",
    "mesh",
    "geo",
    "ai",
    "ca",
    "arkit",
    "fcl",
    "all",
    "vrc",
    "genesis",
    "female",
    "male",
    "avatar",
    "model",
    "fbm",
];
/// Words whose place before a name gives it another meaning.
const PARTS: [&str; 14] = [
    "left", "right", "upper", "lower", "inner", "outer", "brow", "eye", "nose", "cheek", "not",
    "no", "hair", "ear",
];

/// Returns what a morph target or an expression shows, by its name (`docs/formats/face-map.md`): the
/// blend shapes of ARKit in any spelling, visemes, presets of VRM and the names of other makers, after
/// any prefix. `None` for other names.
pub fn face_control(name: &str) -> Option<NamedControl> {
    let mut all = words(without_namespace(name));
    while all.len() > 1 && all.last().is_some_and(|w| is_around(w) && w.len() > 1) {
        all.pop();
    }
    (0..all.len()).find_map(|start| {
        let (before, rest) = all.split_at(start);
        let found = TABLE.get(rest)?;
        after(before, rest, found)
    })
}

/// What a name means after words that do not belong to it.
fn after(before: &[String], rest: &[String], found: &Known) -> Option<NamedControl> {
    let is_known = before.iter().all(|word| is_around(word));
    let changes = before.iter().any(|word| PARTS.contains(&word.as_str()));
    // One word is too little to be sure of after a prefix that nobody knows.
    let confidence = if is_known && (before.is_empty() || !found.alone) {
        found.confidence
    } else if !is_known && !changes && rest.len() > 1 {
        found.confidence.lowered()
    } else {
        return None;
    };
    Some(NamedControl {
        control: found.control,
        confidence,
    })
}

fn is_around(word: &str) -> bool {
    word.chars().count() == 1 || AROUND.contains(&word)
}

/// A name without the mesh or deformer before it: what follows the last `.`, `:` or `|`, unless that
/// is a side (`smile.L`).
fn without_namespace(name: &str) -> &str {
    let Some((_, last)) = name.rsplit_once(['.', ':', '|']) else {
        return name;
    };
    let is_side = matches!(words(last).as_slice(), [side] if side == "left" || side == "right");
    let is_empty = !last.chars().any(char::is_alphabetic);
    if is_side || is_empty { name } else { last }
}

#[cfg(test)]
mod tests {
    use super::*;
    use MappingConfidence::{High, Low, Medium};

    fn check(name: &str, control: &str, confidence: MappingConfidence) {
        let found = face_control(name);
        let found = found.map(|f| (f.control.to_string(), f.confidence));
        assert_eq!(found, Some((control.to_owned(), confidence)), "{name}");
    }

    #[test]
    fn blend_shapes_of_arkit_in_their_spellings() {
        for name in [
            "mouthSmileLeft",
            "MouthSmileLeft",
            "mouth_smile_left",
            "mouthSmile_L",
            "mouthSmileL",
            "MOUTH_SMILE_LEFT",
            "Mouth Smile.L",
            "mouthsmileleft",
            "blendShape1.mouthSmileLeft",
            "Wolf3D_Head|mouthSmile_L",
            "L_mouthSmile",
            "BS_mouthSmileLeft",
            "A38_Mouth_Smile_Left",
            "facs_bs_MouthSmileLeft_div2",
            "head__facs_ctrl_MouthSmileLeft",
        ] {
            check(name, "mouthSmileLeft", High);
        }
        check("browInnerUp_L", "browInnerUp/left", High);
        check("cheekPuffRight", "cheekPuff/right", High);
        check("hero_jawOpen", "jawOpen", Medium);
        check("JawLeft", "jawLeft", High);
        check("Mouth_R", "mouthRight", High);
    }

    #[test]
    fn names_of_other_makers() {
        for (name, control) in [
            ("CC_Base_Body.Eye_Blink_L", "eyeBlinkLeft"),
            ("Mouth_Funnel_Up_R", "mouthFunnel/upper/right"),
            ("Eye_R_Look_L", "eyeLookInRight"),
            ("Eye_L_Look_L", "eyeLookOutLeft"),
            ("Brow_Raise_Inner_L", "browInnerUp/left"),
            ("Merged_Open_Mouth", "jawOpen"),
            ("CTRL_expressions_mouthCornerPullL", "mouthSmileLeft"),
            ("CTRL_expressions_eyeLookLeftR", "eyeLookInRight"),
            (
                "CTRL_expressions_mouthLipsPurseDL",
                "mouthPucker/lower/left",
            ),
            ("Genesis8Female__eCTRLEyesClosedR", "eyeBlinkRight"),
            ("eCTRLMouthOpen", "jawOpen"),
            ("facs_bs_MouthPurseUpperLeft", "mouthPucker/upper/left"),
            ("LipFunnelerLB", "mouthFunnel/lower/left"),
            ("InnerBrowRaiserL", "browInnerUp/left"),
            ("EyesLookLeftL", "eyeLookOutLeft"),
            ("eye_left_right", "eyeLookInLeft"),
            ("mouth_lower_right_down", "mouthLowerDownRight"),
            ("LeftUpperLidClosed", "eyeBlinkLeft"),
            ("RightEyeturnLeft", "eyeLookInRight"),
            ("MouthLeftPullUp", "mouthSmileLeft"),
            ("face_shapes.ai_LipsFunnel", "mouthFunnel"),
            ("face_shapes.ca_BrowsUpCenter", "browInnerUp"),
            ("Fcl_EYE_Close_L", "eyeBlinkLeft"),
            ("Fcl_MTH_A", "viseme_aa"),
            ("Face.M_F00_000_00_Fcl_MTH_I", "viseme_I"),
            ("Fcl_ALL_Sorrow", "sad"),
            ("eCTRLvAA", "viseme_aa"),
            ("V_Dental_Lip", "viseme_FF"),
            ("blink_left", "eyeBlinkLeft"),
            ("look_left", "eyeLookOutLeft+eyeLookInRight"),
        ] {
            let found = face_control(name).map(|f| f.control.to_string());
            assert_eq!(found.as_deref(), Some(control), "{name}");
        }
    }

    #[test]
    fn visemes_and_vowels() {
        for name in ["viseme_kk", "vrc.v_kk", "V_KK", "Viseme_kk"] {
            check(name, "viseme_kk", High);
        }
        check("vrc.v_ou", "viseme_U", Medium);
        check("A", "viseme_aa", Low);
        check("う", "viseme_U", Medium);
    }

    #[test]
    fn other_names_are_not_recognised() {
        for name in [
            "",
            "Key 1",
            "HideHairBalls",
            "Fcl_BRW_Joy",
            "hair_smile",
            "head_a",
            "Body_Fat",
            "wide",
            "tongue_up",
            "Left_jaw_open",
            "identity_03",
            "mouth",
            "Left",
            "L",
        ] {
            assert_eq!(face_control(name), None, "{name}");
        }
    }
}
