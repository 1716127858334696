//! The FAP values of a face's control at full weight, by the control's name.

use super::fap_values::{FapList, FapValues};
use super::high_level::{EXPRESSIONS, VISEMES};
use articula_core::arkit_table::BLEND_SHAPES;

/// Shapes of ARKit that some faces have once for each side.
const HALVES: [(&str, FapList); 4] = [
    ("browinnerupleft", &[(31, 350), (33, 120)]),
    ("browinnerupright", &[(32, 350), (34, 120)]),
    ("cheekpuffleft", &[(39, 400)]),
    ("cheekpuffright", &[(40, 400)]),
];

/// Returns the FAP values of a blend shape of ARKit at weight 1.
///
/// Upper and lower case, underscores and other separators do not matter, and `L` and `R` at the end
/// stand for left and right: `jawOpen`, `JawOpen` and `jaw_open` are the same, as are
/// `mouthSmile_L` and `mouthSmileLeft`. `None` for any other name.
pub fn blend_shape(name: &str) -> Option<FapValues> {
    let name = plain(name)?;
    let half = HALVES.iter().find(|(half, _)| *half == name);
    let whole = || {
        BLEND_SHAPES
            .iter()
            .find(|s| s.name.eq_ignore_ascii_case(&name))
    };
    let list = half
        .map(|(_, list)| *list)
        .or_else(|| Some(whole()?.faps))?;
    let mut values = FapValues::default();
    values.add(list, 1.0);
    Some(values)
}

/// Returns the name in ARKit of a blend shape in any of the spellings of [`blend_shape`]; `None` for
/// any other name, halves of a shape among them.
pub fn arkit_name(name: &str) -> Option<&'static str> {
    let plain = plain(name)?;
    let shape = BLEND_SHAPES
        .iter()
        .find(|s| s.name.eq_ignore_ascii_case(&plain))?;
    Some(shape.name)
}

/// Returns the index in [`BLEND_SHAPES`] of the shape that a name means, as [`blend_shape`] reads it; of
/// a half, that of the whole shape.
pub fn arkit_shape(name: &str) -> Option<usize> {
    let plain = plain(name)?;
    let is_half = HALVES.iter().any(|(half, _)| *half == plain);
    let side = |s: &str| plain.strip_suffix(s).map(str::to_owned);
    let whole = if is_half {
        side("left").or_else(|| side("right"))?
    } else {
        plain
    };
    let is = |s: &articula_core::arkit_table::BlendShape| s.name.eq_ignore_ascii_case(&whole);
    BLEND_SHAPES.iter().position(is)
}

/// Letters in lower case, with a side at the end spelled out; `None` for a name without letters.
fn plain(name: &str) -> Option<String> {
    let is_side = |side: &str| {
        let before = name.strip_suffix(side)?;
        // `_L` and `smileL`, but not the last letter of a word in capitals.
        let last = before.chars().next_back()?;
        (last.is_lowercase() || !last.is_alphanumeric()).then_some(before)
    };
    let (stem, side) = match (is_side("L"), is_side("R")) {
        (Some(stem), _) => (stem, "left"),
        (None, Some(stem)) => (stem, "right"),
        (None, None) => (name, ""),
    };
    let letters = stem.chars().filter(|c| c.is_ascii_alphabetic());
    let plain: String = letters.map(|c| c.to_ascii_lowercase()).collect();
    (!plain.is_empty()).then(|| plain + side)
}

/// Returns the FAP values of an expression preset of VRM 1.0, such as `aa` or `blinkLeft`, at
/// weight 1; `None` for any other name and for `neutral`.
pub fn vrm_preset(name: &str) -> Option<FapValues> {
    const UP: FapList = &[(25, -43000), (26, -43000)];
    const DOWN: FapList = &[(25, 43000), (26, 43000)];
    const LEFT: FapList = &[(23, 52000), (24, 52000)];
    const RIGHT: FapList = &[(23, -52000), (24, -52000)];
    let (list, weight) = match name {
        "happy" => (EXPRESSIONS[1], 1.0),
        "sad" => (EXPRESSIONS[2], 1.0),
        "angry" => (EXPRESSIONS[3], 1.0),
        "surprised" => (EXPRESSIONS[6], 1.0),
        "relaxed" => (EXPRESSIONS[1], 0.4),
        "aa" => (VISEMES[10], 1.0),
        "ee" => (VISEMES[11], 1.0),
        "ih" => (VISEMES[12], 1.0),
        "oh" => (VISEMES[13], 1.0),
        "ou" => (VISEMES[14], 1.0),
        "blinkLeft" | "blinkRight" => {
            return blend_shape(if name == "blinkLeft" {
                "eyeBlinkLeft"
            } else {
                "eyeBlinkRight"
            });
        }
        "blink" => {
            let [left, right] = ["eyeBlinkLeft", "eyeBlinkRight"].map(blend_shape);
            return Some(left?.plus(&right?, 1.0));
        }
        "lookUp" => (UP, 1.0),
        "lookDown" => (DOWN, 1.0),
        "lookLeft" => (LEFT, 1.0),
        "lookRight" => (RIGHT, 1.0),
        _ => return None,
    };
    let mut values = FapValues::default();
    values.add(list, weight);
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_blend_shapes() {
        let smile = blend_shape("mouthSmileLeft").unwrap();
        assert_eq!(
            (smile.get(6), smile.get(12), smile.get(53)),
            (250.0, 250.0, 250.0)
        );
        for name in [
            "MouthSmileLeft",
            "mouthSmile_L",
            "mouth_smile_left",
            "mouthSmileL",
        ] {
            assert_eq!(blend_shape(name), Some(smile), "{name}");
        }
        for name in ["", "_L", "L", "smile", "JAWOPENL", "tongueOutLeft", "12"] {
            assert_eq!(blend_shape(name), None, "{name}");
        }
    }

    #[test]
    fn halves_are_of_the_whole_shape() {
        let named = |name: &str| arkit_shape(name).map(|i| BLEND_SHAPES[i].name);
        assert_eq!(named("browInnerUp_L"), Some("browInnerUp"));
        assert_eq!(named("mouth_smile_left"), Some("mouthSmileLeft"));
        assert_eq!((named("smile"), named("jawOpenLeft")), (None, None));
        assert_eq!(arkit_name("MouthSmile_L"), Some("mouthSmileLeft"));
        assert_eq!(arkit_name("browInnerUp_L"), None);
    }

    #[test]
    fn halves_add_up_to_the_whole() {
        for whole in ["browInnerUp", "cheekPuff"] {
            let [left, right] = ["_L", "_R"].map(|side| blend_shape(&format!("{whole}{side}")));
            let sum = left.unwrap().plus(&right.unwrap(), 1.0);
            assert_eq!(blend_shape(whole), Some(sum));
        }
    }

    #[test]
    fn presets_of_vrm() {
        let known = [
            "happy",
            "angry",
            "sad",
            "relaxed",
            "surprised",
            "aa",
            "ih",
            "ou",
            "ee",
            "oh",
            "blink",
            "blinkLeft",
            "blinkRight",
            "lookUp",
            "lookDown",
            "lookLeft",
            "lookRight",
        ];
        for name in known {
            let moved = vrm_preset(name)
                .unwrap()
                .0
                .iter()
                .filter(|v| **v != 0.0)
                .count();
            assert!(moved > 0, "{name}");
        }
        assert_eq!(vrm_preset("neutral"), None);
        assert_eq!(vrm_preset("lookLeft").unwrap().get(23), 52000.0);
        assert_eq!(vrm_preset("relaxed").unwrap().get(41), 160.0);
    }
}
