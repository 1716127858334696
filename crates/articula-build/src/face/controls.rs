//! The FAP values of a face's control at full weight.

use super::fap_values::{FapList, FapValues};
use super::high_level::{EXPRESSIONS, VISEMES};
use super::names::face_control;
use crate::joint_names::MappingConfidence;
use articula_core::arkit_table::{BLEND_SHAPES, are_opposite};
use articula_core::face_control::{FaceControl, FaceSide, Lip, ShapePart, ShapeSet};
use articula_core::fap_table::{LOW_FAPS, TABLE};

/// Returns the FAP values of a control at weight 1, on a face of average proportions.
pub fn control_column(control: FaceControl) -> FapValues {
    match control {
        FaceControl::Shapes(shapes, part) => column_of_shapes(shapes, part),
        FaceControl::Viseme(viseme) => {
            let mut values = FapValues::default();
            values.add(VISEMES[viseme.number()], 1.0);
            values
        }
        FaceControl::Emotion(emotion) => vrm_preset(emotion.name()).unwrap_or_default(),
    }
}

fn column_of_shapes(shapes: ShapeSet, part: ShapePart) -> FapValues {
    let mut values = FapValues::default();
    for shape in shapes.iter() {
        values.add(BLEND_SHAPES[shape].faps, 1.0);
    }
    for (value, fap) in values.0.iter_mut().zip(LOW_FAPS) {
        *value *= share(fap, part);
    }
    values
}

/// Share of a FAP that a part of a face shows: half of one in the middle.
fn share(fap: usize, part: ShapePart) -> f32 {
    let name = TABLE[fap - 1].name;
    let has = |parts: &[&str]| parts.iter().any(|part| name.contains(part));
    let side = if has(&["_l_", "_lm"]) {
        Some(FaceSide::Left)
    } else {
        has(&["_r_", "_rm"]).then_some(FaceSide::Right)
    };
    let lip = if !name.contains("lip") || name.contains("corner") {
        None
    } else if name.contains("_t_") {
        Some(Lip::Upper)
    } else {
        Some(Lip::Lower)
    };
    share_of(part.side, side) * share_of(part.lip, lip)
}

fn share_of<T: PartialEq>(part: Option<T>, own: Option<T>) -> f32 {
    match (part, own) {
        (None, _) => 1.0,
        (Some(_), None) => 0.5,
        (Some(part), Some(own)) => f32::from(u8::from(part == own)),
    }
}

/// Returns the FAP values of a blend shape of ARKit at weight 1.
///
/// Upper and lower case, separators and what programs put before a name do not matter, and `L` and
/// `R` at the end stand for left and right: `jawOpen`, `JawOpen`, `jaw_open` and `blendShape1.jawOpen`
/// are the same, as are `mouthSmile_L` and `mouthSmileLeft`. `None` for any other name
/// ([`face_control`] knows more).
pub fn blend_shape(name: &str) -> Option<FapValues> {
    let (shapes, part) = surely(name)?;
    Some(column_of_shapes(shapes, part))
}

/// Returns the pairs of controls, by their indices, whose shapes undo each other
/// ([`OPPOSITES`](articula_core::arkit_table::OPPOSITES)); a control that shows several is the opposite of
/// those of each.
pub fn opposite_controls(shapes: &[Option<ShapeSet>]) -> Vec<[usize; 2]> {
    let undo = |a: ShapeSet, b: ShapeSet| a.iter().any(|a| b.iter().any(|b| are_opposite(a, b)));
    let known = shapes
        .iter()
        .enumerate()
        .filter_map(|(i, s)| Some((i, (*s)?)));
    let pairs = known.clone().flat_map(|(i, a)| {
        let after = known.clone().filter(move |(j, b)| *j > i && undo(a, *b));
        after.map(move |(j, _)| [i, j])
    });
    pairs.collect()
}

/// Returns the name in ARKit of a blend shape in any of the spellings of [`blend_shape`]; `None` for
/// any other name, halves of a shape among them.
pub fn arkit_name(name: &str) -> Option<&'static str> {
    let (shapes, part) = surely(name)?;
    let whole = (part == ShapePart::default()).then(|| shapes.only())??;
    Some(BLEND_SHAPES[whole].name)
}

/// Returns the index in [`BLEND_SHAPES`] of the shape that a name means, as [`blend_shape`] reads it; of
/// a half, that of the whole shape.
pub fn arkit_shape(name: &str) -> Option<usize> {
    surely(name)?.0.only()
}

/// The shapes of a name in a spelling of ARKit.
fn surely(name: &str) -> Option<(ShapeSet, ShapePart)> {
    let found = face_control(name).filter(|f| f.confidence == MappingConfidence::High)?;
    match found.control {
        FaceControl::Shapes(shapes, part) => Some((shapes, part)),
        FaceControl::Viseme(_) | FaceControl::Emotion(_) => None,
    }
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
    fn quarters_add_up_to_the_whole() {
        let column = |name: &str| control_column(name.parse().unwrap());
        for whole in ["mouthFunnel", "mouthPucker", "mouthClose"] {
            let quarters = ["/upper/left", "/upper/right", "/lower/left", "/lower/right"];
            let sum = quarters.map(|q| column(&format!("{whole}{q}")));
            let sum = sum
                .iter()
                .fold(FapValues::default(), |sum, q| sum.plus(q, 1.0));
            assert_eq!(column(whole), sum);
        }
        // The left half of the upper lip moves nothing on the right and no chin.
        let quarter = column("mouthFunnel/upper/left");
        assert_eq!(
            (quarter.get(4), quarter.get(6), quarter.get(7)),
            (-75.0, -80.0, 0.0)
        );
        assert_eq!(
            (quarter.get(5), quarter.get(16), quarter.get(17)),
            (0.0, 0.0, 125.0)
        );
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
