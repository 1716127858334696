//! The 52 blend shapes of ARKit face tracking, each with the facial animation parameters (FAP) that
//! it amounts to.
//!
//! Names and order are those of Live Link Face, whose columns begin with a capital. The values are
//! engineering defaults for a face of average proportions (`docs/methods/faces.md`), not part of
//! either system: those of FAP 3 to 68 at weight 1, in their units.

/// A blend shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlendShape {
    /// Name in ARKit, such as `jawOpen`; left and right are the subject's.
    pub name: &'static str,
    /// Number and value of each FAP that the shape moves, in ascending order. Those of the outer
    /// lips (51 to 60) are left out: they equal their [inner twins](outer_lip).
    pub faps: &'static [(u8, i32)],
}

/// Number of blend shapes.
pub const BLEND_SHAPE_COUNT: usize = 52;

/// The blend shapes, in the order of Live Link Face.
#[rustfmt::skip]
pub static BLEND_SHAPES: [BlendShape; BLEND_SHAPE_COUNT] = [
    shape("eyeBlinkLeft", &[(19, 950), (21, 74)]),
    shape("eyeLookDownLeft", &[(19, 250), (25, 43000)]),
    shape("eyeLookInLeft", &[(23, -52000)]),
    shape("eyeLookOutLeft", &[(23, 52000)]),
    shape("eyeLookUpLeft", &[(25, -43000)]),
    shape("eyeSquintLeft", &[(19, 220), (21, 400)]),
    shape("eyeWideLeft", &[(19, -350)]),
    shape("eyeBlinkRight", &[(20, 950), (22, 74)]),
    shape("eyeLookDownRight", &[(20, 250), (26, 43000)]),
    shape("eyeLookInRight", &[(24, 52000)]),
    shape("eyeLookOutRight", &[(24, -52000)]),
    shape("eyeLookUpRight", &[(26, -43000)]),
    shape("eyeSquintRight", &[(20, 220), (22, 400)]),
    shape("eyeWideRight", &[(20, -350)]),
    shape("jawForward", &[(14, 400)]),
    shape("jawRight", &[(15, 200)]),
    shape("jawLeft", &[(15, -200)]),
    shape("jawOpen", &[(3, 1000), (5, -850), (10, -700), (11, -700)]),
    shape("mouthClose", &[(5, 850), (10, 700), (11, 700)]),
    shape("mouthFunnel", &[(4, -150), (5, -250), (6, -160), (7, -160), (16, 250), (17, 250)]),
    shape("mouthPucker", &[(6, -280), (7, -280), (16, 300), (17, 300)]),
    shape("mouthRight", &[(6, -220), (7, 220)]),
    shape("mouthLeft", &[(6, 220), (7, -220)]),
    shape("mouthSmileLeft", &[(6, 250), (12, 250), (41, 150)]),
    shape("mouthSmileRight", &[(7, 250), (13, 250), (42, 150)]),
    shape("mouthFrownLeft", &[(12, -220)]),
    shape("mouthFrownRight", &[(13, -220)]),
    shape("mouthDimpleLeft", &[(6, 160)]),
    shape("mouthDimpleRight", &[(7, 160)]),
    shape("mouthStretchLeft", &[(6, 260), (12, -80)]),
    shape("mouthStretchRight", &[(7, 260), (13, -80)]),
    shape("mouthRollLower", &[(5, 120), (16, -200)]),
    shape("mouthRollUpper", &[(4, 120), (17, -200)]),
    shape("mouthShrugLower", &[(5, 150), (16, 120), (18, 300)]),
    shape("mouthShrugUpper", &[(4, -120), (17, 100)]),
    shape("mouthPressLeft", &[(8, 90), (10, 90)]),
    shape("mouthPressRight", &[(9, 90), (11, 90)]),
    shape("mouthLowerDownLeft", &[(5, -150), (10, -300)]),
    shape("mouthLowerDownRight", &[(5, -150), (11, -300)]),
    shape("mouthUpperUpLeft", &[(4, -130), (8, -260)]),
    shape("mouthUpperUpRight", &[(4, -130), (9, -260)]),
    shape("browDownLeft", &[(31, -220), (33, -180), (35, -120), (37, 150)]),
    shape("browDownRight", &[(32, -220), (34, -180), (36, -120), (38, 150)]),
    shape("browInnerUp", &[(31, 350), (32, 350), (33, 120), (34, 120)]),
    shape("browOuterUpLeft", &[(33, 180), (35, 350)]),
    shape("browOuterUpRight", &[(34, 180), (36, 350)]),
    shape("cheekPuff", &[(39, 400), (40, 400)]),
    shape("cheekSquintLeft", &[(21, 150), (41, 400)]),
    shape("cheekSquintRight", &[(22, 150), (42, 400)]),
    shape("noseSneerLeft", &[(8, -80), (61, 200), (63, 120)]),
    shape("noseSneerRight", &[(9, -80), (62, 200), (63, 120)]),
    shape("tongueOut", &[(44, -80), (45, 900)]),
];

const fn shape(name: &'static str, faps: &'static [(u8, i32)]) -> BlendShape {
    BlendShape { name, faps }
}

/// Pairs of shapes that undo each other, at least in part, by their names in ARKit. A face does not show
/// both at once. `mouthClose` is not the opposite of `jawOpen`: it closes the lips over an open jaw.
pub static OPPOSITES: [[&str; 2]; 22] = [
    ["eyeBlinkLeft", "eyeWideLeft"],
    ["eyeBlinkRight", "eyeWideRight"],
    ["eyeLookInLeft", "eyeLookOutLeft"],
    ["eyeLookInRight", "eyeLookOutRight"],
    ["eyeLookDownLeft", "eyeLookUpLeft"],
    ["eyeLookDownRight", "eyeLookUpRight"],
    ["jawLeft", "jawRight"],
    ["mouthLeft", "mouthRight"],
    ["mouthSmileLeft", "mouthFrownLeft"],
    ["mouthSmileRight", "mouthFrownRight"],
    ["mouthPucker", "mouthDimpleLeft"],
    ["mouthPucker", "mouthDimpleRight"],
    ["mouthPucker", "mouthStretchLeft"],
    ["mouthPucker", "mouthStretchRight"],
    ["mouthFunnel", "mouthDimpleLeft"],
    ["mouthFunnel", "mouthDimpleRight"],
    ["mouthFunnel", "mouthRollLower"],
    ["mouthFunnel", "mouthRollUpper"],
    ["mouthShrugLower", "mouthRollLower"],
    ["mouthShrugUpper", "mouthRollUpper"],
    ["mouthLowerDownLeft", "mouthClose"],
    ["mouthLowerDownRight", "mouthClose"],
];

/// Returns whether two shapes, by their indices, undo each other ([`OPPOSITES`]).
pub fn are_opposite(a: usize, b: usize) -> bool {
    let name = |index: usize| BLEND_SHAPES.get(index).map(|s| s.name);
    let [a, b] = [name(a), name(b)];
    OPPOSITES
        .iter()
        .map(|pair| pair.map(Some))
        .any(|pair| pair == [a, b] || pair == [b, a])
}

/// Returns the FAP (51 to 60) of the outer lip beside the one of the inner lip (4 to 13).
pub fn outer_lip(inner: usize) -> Option<usize> {
    (4..=13).contains(&inner).then_some(inner + 47)
}

/// Returns the FAP at the same place on the other contour of the lips, inner (4 to 13) or outer (51 to
/// 60).
pub fn twin_lip(fap: usize) -> Option<usize> {
    outer_lip(fap).or_else(|| (51..=60).contains(&fap).then(|| fap - 47))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fap_table::{FapDirection, FapUnit, TABLE};
    use std::collections::BTreeMap;

    #[test]
    fn outer_lips_move_as_the_inner_ones() {
        for inner in 4..=13 {
            let [a, b] = [inner, outer_lip(inner).unwrap()].map(|fap| TABLE[fap - 1]);
            assert_eq!(format!("{}_o", a.name), b.name);
            let [a, b] = [a, b].map(|fap| fap.action.unwrap());
            assert_eq!((a.unit, a.direction), (b.unit, b.direction));
        }
        assert!(outer_lip(3).is_none() && outer_lip(14).is_none());
        assert_eq!(
            [51, 60, 4, 61].map(twin_lip),
            [Some(4), Some(13), Some(51), None]
        );
    }

    #[test]
    fn opposites_share_a_parameter_with_opposite_signs() {
        let shape = |name| BLEND_SHAPES.iter().find(|s| s.name == name).unwrap();
        let undoes = |(fap, value): &(u8, i32), other: &BlendShape| {
            let mut others = other.faps.iter();
            others.any(|(f, v)| f == fap && v.signum() == -value.signum())
        };
        for [a, b] in OPPOSITES {
            let mut faps = shape(a).faps.iter();
            assert!(faps.any(|fap| undoes(fap, shape(b))), "{a} {b}");
        }
        let index = |name| BLEND_SHAPES.iter().position(|s| s.name == name).unwrap();
        assert!(are_opposite(index("jawRight"), index("jawLeft")));
        assert!(!are_opposite(index("jawOpen"), index("mouthClose")));
        assert!(!are_opposite(
            index("mouthSmileLeft"),
            index("mouthFrownRight")
        ));
        assert!(!are_opposite(52, 52));
    }

    /// The FAP of the other side; for one in the middle, itself.
    fn other_side(fap: u8) -> u8 {
        let name = TABLE[usize::from(fap) - 1].name;
        let swapped = ["_l_", "_r_", "_lm", "_rm"];
        let to = ["_r_", "_l_", "_rm", "_lm"];
        let found = swapped
            .iter()
            .zip(to)
            .find(|(side, _)| name.contains(*side));
        let Some((side, to)) = found else {
            return fap;
        };
        let twin = name.replace(side, to);
        let index = TABLE.iter().position(|f| f.name == twin).unwrap();
        u8::try_from(index + 1).unwrap()
    }

    /// The value of the other side's FAP in the mirrored face.
    fn mirrored((fap, value): (u8, i32)) -> (u8, i32) {
        let other = other_side(fap);
        let action = TABLE[usize::from(fap) - 1].action.unwrap();
        let sideways = matches!(action.direction, FapDirection::Left | FapDirection::Right);
        // Both eyes look to the left with a positive value, and the jaw has one parameter.
        let turns = sideways && (action.unit == FapUnit::Angle || other == fap);
        (other, if turns { -value } else { value })
    }

    #[test]
    fn left_shapes_mirror_right_ones() {
        let of: BTreeMap<&str, &[(u8, i32)]> =
            BLEND_SHAPES.iter().map(|s| (s.name, s.faps)).collect();
        assert_eq!(of.len(), BLEND_SHAPE_COUNT);
        for (name, faps) in &of {
            let twin = match name.strip_suffix("Left") {
                Some(stem) => format!("{stem}Right"),
                None if name.ends_with("Right") => continue,
                None => (*name).to_owned(),
            };
            let mut wanted: Vec<(u8, i32)> = faps.iter().copied().map(mirrored).collect();
            wanted.sort_unstable();
            assert_eq!(of[&*twin], wanted, "{name}");
        }
    }

    #[test]
    fn values_are_within_the_ranges_of_the_table() {
        for shape in &BLEND_SHAPES {
            assert!(shape.faps.windows(2).all(|w| w[0].0 < w[1].0));
            for &(fap, value) in shape.faps {
                let known = &TABLE[usize::from(fap) - 1];
                let two_sided = known.action.unwrap().two_sided;
                assert!(value > 0 || two_sided && value < 0, "{}", shape.name);
                let most = i32::from(known.step) * i32::from(known.largest.0);
                assert!(value.abs() <= most, "{} moves {}", shape.name, known.name);
                assert!(!(51..=60).contains(&fap));
            }
        }
    }
}
