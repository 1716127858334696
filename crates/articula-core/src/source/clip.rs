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

/// Duration in seconds of the move that stands for a jump, a change from one value to another at once:
/// key times increase strictly, so the first of two keys at one time is kept this much earlier.
pub const JUMP_SECS: f32 = 1e-4;

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

impl Channel {
    /// Returns the times at which the value changes at once: those of the keys of a step channel that
    /// differ from the key before, and of other channels that of the later one of two different keys
    /// that are [`JUMP_SECS`] apart or less.
    pub fn jump_times(&self) -> impl Iterator<Item = f32> + '_ {
        let parts = match self.interpolation {
            Interpolation::CubicSpline => 3,
            _ => 1,
        };
        let width = self.values.len() / (parts * self.times_secs.len()).max(1);
        // The value of a spline's key is the middle one of three parts.
        let value = move |key: usize| {
            let first = (key * parts + parts / 2) * width;
            self.values.get(first..first + width)
        };
        let is_step = self.interpolation == Interpolation::Step;
        let pairs = self.times_secs.windows(2).enumerate();
        // Times are rounded, after minutes by a third of the duration.
        let near = pairs.filter(move |(_, t)| is_step || t[1] - t[0] <= 1.5 * JUMP_SECS);
        let jumps = near.filter(move |(key, _)| value(*key) != value(*key + 1));
        jumps.map(|(_, times)| times[1])
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_change_at_once_at_steps_and_between_near_keys() {
        let mut channel = Channel {
            target: 0,
            property: Property::Expression,
            interpolation: Interpolation::Step,
            times_secs: vec![0.0, 1.0, 2.0, 3.0 - JUMP_SECS, 3.0],
            values: vec![0.5, 0.5, 0.25, 0.25, 1.0],
        };
        let jumps = |c: &Channel| c.jump_times().collect::<Vec<f32>>();
        assert_eq!(jumps(&channel), [2.0, 3.0]);
        channel.interpolation = Interpolation::Linear;
        assert_eq!(jumps(&channel), [3.0]);
        channel.values[3] = 1.0;
        assert!(jumps(&channel).is_empty());
    }
}
