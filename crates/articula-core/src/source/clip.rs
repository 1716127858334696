//! A motion as keyed channels, as files store it.

/// What a [`Channel`] drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Property {
    /// Local translation of a joint; 3 floats a key, metres.
    Translation,
    /// Local rotation of a joint; 4 floats a key, unit quaternion x y z w.
    Rotation,
    /// Local scale of a joint; 3 floats a key.
    Scale,
    /// Morph weights of a mesh; one float for each of its morph targets a key.
    Weights,
    /// Value of an expression of the character, from 0 (off) to 1 (full); one float a key.
    /// Values beyond are clamped when it is applied.
    Expression,
}

impl Property {
    /// Whether a channel's target is a joint.
    pub fn is_of_joint(self) -> bool {
        matches!(self, Self::Translation | Self::Rotation | Self::Scale)
    }
}

/// How a channel runs between its keys (the three modes of glTF 2.0).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// Straight line; spherical for rotations.
    #[default]
    Linear,
    /// The value of the key before.
    Step,
    /// Cubic Hermite; each key stores in-tangent, value, out-tangent.
    CubicSpline,
}

/// One property of one target over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Joint index; mesh index where `property` is [`Property::Weights`], index into the
    /// expressions where it is [`Property::Expression`].
    pub target: usize,
    /// Which property the keys drive.
    pub property: Property,
    /// How to read between keys.
    pub interpolation: Interpolation,
    /// Key times in seconds, strictly increasing; never empty.
    pub times_secs: Vec<f32>,
    /// Key values, flat: `times_secs.len()` times the floats of one key (three times as many
    /// for [`Interpolation::CubicSpline`]).
    pub values: Vec<f32>,
}

/// A motion. It runs from 0 to `duration_secs`; before its first key a channel holds it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawClip {
    /// Name as the file has it, or one made from its number.
    pub name: String,
    /// Time of the last key.
    pub duration_secs: f32,
    /// The channels; at most one for each (target, property).
    pub channels: Vec<Channel>,
}
