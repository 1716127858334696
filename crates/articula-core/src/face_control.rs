//! What a control of a face (a morph target or an expression) shows, whatever it is called: blend
//! shapes of ARKit, a viseme or an emotion.
//!
//! `articula-build` finds it by the name, `articula-formats` reads what a person says in a face map
//! (`docs/formats/face-map.md`).

use crate::arkit_table::{BLEND_SHAPE_COUNT, BLEND_SHAPES};
use crate::joint_names::Side;
use crate::viseme::Viseme;
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// What a control shows at weight 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FaceControl {
    /// Blend shapes of ARKit together, or the same part of each.
    Shapes(ShapeSet, ShapePart),
    /// A mouth shape of speech.
    Viseme(Viseme),
    /// An expression of the whole face.
    Emotion(Emotion),
}

/// A set of blend shapes of ARKit, by their indices in [`BLEND_SHAPES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShapeSet(u64);

/// The part of a blend shape that a control shows; all of it by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct ShapePart {
    /// One lip alone.
    pub lip: Option<Lip>,
    /// One side of the face alone, as seen by the subject.
    pub side: Option<FaceSide>,
}

/// A lip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Lip {
    /// The upper one.
    Upper,
    /// The lower one.
    Lower,
}

/// A side of the face, as seen by the subject.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FaceSide {
    /// The left one, +X.
    Left,
    /// The right one, -X.
    Right,
}

/// The emotions of VRM 1.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Emotion {
    /// Joy in VRM 0.x.
    Happy,
    /// Angry in both versions.
    Angry,
    /// Sorrow in VRM 0.x.
    Sad,
    /// Fun in VRM 0.x.
    Relaxed,
    /// Not in VRM 0.x.
    Surprised,
}

/// What the morph targets and expressions of a kind of head show, as a person says it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FaceMap {
    /// Short name.
    pub name: String,
    /// Name for display.
    pub title: String,
    /// Origin of the names.
    pub source: String,
    /// What each name shows; `None` for names that are left out on purpose. Names are those of the
    /// file, letter by letter.
    pub controls: BTreeMap<String, Option<FaceControl>>,
}

/// A text that is not a [`FaceControl`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownControl(String);

impl fmt::Display for UnknownControl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "\"{}\" is neither a blend shape of ARKit (jawOpen, mouthSmileLeft+mouthSmileRight, \
             mouthFunnel/upper/left), nor a viseme (viseme_PP), nor a preset of VRM (happy, aa, \
             blink)",
            self.0
        )
    }
}

impl std::error::Error for UnknownControl {}

impl FaceControl {
    /// The whole of one blend shape, by its index.
    ///
    /// # Panics
    /// If there is no such shape.
    pub fn shape(index: usize) -> Self {
        Self::Shapes(ShapeSet::of([index]), ShapePart::default())
    }
}

impl ShapeSet {
    /// The set of some shapes.
    ///
    /// # Panics
    /// If an index is none of a shape.
    pub fn of(shapes: impl IntoIterator<Item = usize>) -> Self {
        let bit = |shape: usize| {
            assert!(shape < BLEND_SHAPE_COUNT, "no blend shape {shape}");
            1_u64 << shape
        };
        Self(shapes.into_iter().map(bit).fold(0, |all, bit| all | bit))
    }

    /// The indices, ascending.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        (0..BLEND_SHAPE_COUNT).filter(move |shape| self.has(*shape))
    }

    /// Whether a shape is in the set.
    pub fn has(self, shape: usize) -> bool {
        shape < BLEND_SHAPE_COUNT && self.0 >> shape & 1 == 1
    }

    /// The index, if there is one shape alone.
    pub fn only(self) -> Option<usize> {
        (self.0.count_ones() == 1).then(|| self.0.trailing_zeros() as usize)
    }
}

impl ShapePart {
    /// The quarters that it covers: bits of upper left, upper right, lower left and lower right.
    pub fn quarters(self) -> u8 {
        let lips = match self.lip {
            None => 0b1111,
            Some(Lip::Upper) => 0b0011,
            Some(Lip::Lower) => 0b1100,
        };
        let sides = match self.side {
            None => 0b1111,
            Some(FaceSide::Left) => 0b0101,
            Some(FaceSide::Right) => 0b1010,
        };
        lips & sides
    }
}

impl From<Side> for FaceSide {
    fn from(side: Side) -> Self {
        match side {
            Side::Left => Self::Left,
            Side::Right => Self::Right,
        }
    }
}

impl Emotion {
    /// All, by their number.
    pub const ALL: [Self; 5] = [
        Self::Happy,
        Self::Angry,
        Self::Sad,
        Self::Relaxed,
        Self::Surprised,
    ];

    /// Name of the preset in VRM 1.0.
    pub const fn name(self) -> &'static str {
        const NAMES: [&str; 5] = ["happy", "angry", "sad", "relaxed", "surprised"];
        NAMES[self as usize]
    }
}

/// Presets of VRM 1.0 for mouth and eyes, with the viseme or the shapes that they are.
const PRESETS: [(&str, &str); 12] = [
    ("aa", "viseme_aa"),
    ("ee", "viseme_E"),
    ("ih", "viseme_I"),
    ("oh", "viseme_O"),
    ("ou", "viseme_U"),
    ("blink", "eyeBlinkLeft+eyeBlinkRight"),
    ("blinkLeft", "eyeBlinkLeft"),
    ("blinkRight", "eyeBlinkRight"),
    ("lookUp", "eyeLookUpLeft+eyeLookUpRight"),
    ("lookDown", "eyeLookDownLeft+eyeLookDownRight"),
    ("lookLeft", "eyeLookOutLeft+eyeLookInRight"),
    ("lookRight", "eyeLookInLeft+eyeLookOutRight"),
];

impl fmt::Display for FaceControl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Viseme(viseme) => write!(f, "viseme_{}", viseme.name()),
            Self::Emotion(emotion) => f.write_str(emotion.name()),
            Self::Shapes(shapes, part) => {
                for (index, shape) in shapes.iter().enumerate() {
                    let plus = if index == 0 { "" } else { "+" };
                    write!(f, "{plus}{}", BLEND_SHAPES[shape].name)?;
                }
                match part.lip {
                    Some(Lip::Upper) => f.write_str("/upper")?,
                    Some(Lip::Lower) => f.write_str("/lower")?,
                    None => {}
                }
                match part.side {
                    Some(FaceSide::Left) => f.write_str("/left"),
                    Some(FaceSide::Right) => f.write_str("/right"),
                    None => Ok(()),
                }
            }
        }
    }
}

impl FromStr for FaceControl {
    type Err = UnknownControl;

    /// Reads what [`Display`](fmt::Display) writes, and the presets of VRM 1.0.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let preset = PRESETS.iter().find(|(name, _)| *name == text);
        let told = preset.map_or(text, |(_, control)| control);
        let viseme = |name: &str| Viseme::ALL.into_iter().find(|v| v.name() == name);
        if let Some(found) = told.strip_prefix("viseme_").and_then(viseme) {
            return Ok(Self::Viseme(found));
        }
        if let Some(found) = Emotion::ALL.into_iter().find(|e| e.name() == told) {
            return Ok(Self::Emotion(found));
        }
        shapes(told).ok_or_else(|| UnknownControl(text.to_owned()))
    }
}

/// Reads names of shapes and the part of them.
fn shapes(text: &str) -> Option<FaceControl> {
    let mut words = text.split('/');
    let names = words.next()?.split('+');
    let shape = |name: &str| BLEND_SHAPES.iter().position(|s| s.name == name);
    let shapes: Option<Vec<usize>> = names.map(shape).collect();
    let mut part = ShapePart::default();
    for word in words {
        match word {
            "upper" if part == ShapePart::default() => part.lip = Some(Lip::Upper),
            "lower" if part == ShapePart::default() => part.lip = Some(Lip::Lower),
            "left" if part.side.is_none() => part.side = Some(FaceSide::Left),
            "right" if part.side.is_none() => part.side = Some(FaceSide::Right),
            _ => return None,
        }
    }
    Some(FaceControl::Shapes(ShapeSet::of(shapes?), part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_control_is_read_as_it_is_written() {
        let shapes = (0..BLEND_SHAPE_COUNT).map(FaceControl::shape);
        let visemes = Viseme::ALL.into_iter().map(FaceControl::Viseme);
        let emotions = Emotion::ALL.into_iter().map(FaceControl::Emotion);
        let part = ShapePart {
            lip: Some(Lip::Upper),
            side: Some(FaceSide::Right),
        };
        let parts = [FaceControl::Shapes(ShapeSet::of([3, 51]), part)];
        for control in shapes.chain(visemes).chain(emotions).chain(parts) {
            assert_eq!(control.to_string().parse(), Ok(control));
        }
        assert_eq!(
            "mouthFunnel/lower/left"
                .parse::<FaceControl>()
                .map(|c| c.to_string()),
            Ok("mouthFunnel/lower/left".to_owned())
        );
    }

    #[test]
    fn presets_of_vrm_are_shapes_and_visemes() {
        for (name, control) in PRESETS {
            let read: FaceControl = name.parse().unwrap();
            assert_eq!(Ok(read), control.parse(), "{name}");
        }
        assert_eq!("aa".parse(), Ok(FaceControl::Viseme(Viseme::Aa)));
    }

    #[test]
    fn other_texts_are_refused() {
        for text in [
            "",
            "jawOpen+",
            "jawopen",
            "jawOpen/up",
            "jawOpen/left/upper",
            "viseme_x",
        ] {
            let refused = text.parse::<FaceControl>().unwrap_err().to_string();
            assert!(refused.starts_with(&format!("\"{text}\"")), "{refused}");
        }
    }

    #[test]
    fn quarters_of_parts_add_up() {
        let part = |lip, side| ShapePart { lip, side }.quarters();
        assert_eq!(part(None, None), 15);
        let all = [Lip::Upper, Lip::Lower]
            .map(|lip| [FaceSide::Left, FaceSide::Right].map(|side| part(Some(lip), Some(side))));
        assert_eq!(all.as_flattened().iter().sum::<u8>(), 15);
    }
}
