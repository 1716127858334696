//! The editable form of a clip: keyed channels, as files store them.

/// The property that a [`Channel`] animates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Property {
    /// Local translation of a joint in metres; 3 floats per key.
    Translation,
    /// Local rotation of a joint, a unit quaternion x y z w; 4 floats per key.
    Rotation,
    /// Local scale of a joint; 3 floats per key.
    Scale,
    /// Morph target weights of a mesh; one float per morph target and key.
    Weights,
    /// Weight of one of the character's expressions, from 0 (off) to 1 (full); one float per key.
    /// Values outside the range are clamped when the expression is applied.
    Expression,
}

impl Property {
    /// Returns whether the target of such a channel is a joint.
    pub fn is_of_joint(self) -> bool {
        matches!(self, Self::Translation | Self::Rotation | Self::Scale)
    }
}

/// Interpolation between the keys of a channel: the three modes of glTF 2.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// Linear; spherical linear for rotations.
    #[default]
    Linear,
    /// The value of the previous key.
    Step,
    /// Cubic Hermite spline; each key stores in-tangent, value and out-tangent.
    CubicSpline,
}

/// The keys of one property of one target.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Joint index; for [`Property::Weights`] a mesh index, for [`Property::Expression`] an index
    /// into the character's expressions.
    pub target: usize,
    /// The animated property.
    pub property: Property,
    /// Interpolation between keys.
    pub interpolation: Interpolation,
    /// Key times in seconds, strictly increasing; never empty.
    pub times_secs: Vec<f32>,
    /// Flat array of key values: `times_secs.len()` times the number of floats per key, three times
    /// as many for [`Interpolation::CubicSpline`].
    pub values: Vec<f32>,
}

/// A keyed animation clip over `0..=duration_secs`; a channel holds its first key before the time
/// of that key.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawClip {
    /// Name as stored in the file, or one generated from the clip's index.
    pub name: String,
    /// Time of the last key in seconds.
    pub duration_secs: f32,
    /// The channels; at most one for each (target, property).
    pub channels: Vec<Channel>,
}
