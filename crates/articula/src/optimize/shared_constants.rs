//! Channels that hold a value, in all clips together.
//!
//! A hand that a motion leaves alone is often held as in the motion before. Such channels are equal but for their rounding, and an
//! array that several of them share is described once.

use super::optimized_clip::OptimizedClip;
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use articula_formats::gltf::{KeySteps, rounded_clip};

/// A held value, as it is stored.
struct Held {
    property: Property,
    values: Vec<f32>,
    stored: Vec<f32>,
    steps: KeySteps,
}

/// Lets channels that hold a value hold the nearest of those that others hold as exactly, if it is within a number of steps
/// of their own, for each clip; clips of none stay as they are. Returns the number of channels that hold another value.
pub(super) fn share_constants(clips: &mut [OptimizedClip], steps: &[f32]) -> usize {
    let mut places: Vec<(usize, usize)> = Vec::new();
    for (c, clip) in clips.iter().enumerate().filter(|(c, _)| steps[*c] > 0.0) {
        let held = clip.clip.channels.iter().zip(&clip.steps).enumerate();
        let held = held.filter(|(_, (channel, _))| is_held(channel));
        places.extend(held.map(|(i, _)| (c, i)));
    }
    // The most exact first: others take their values.
    let step = |(c, i): &(usize, usize)| clips[*c].steps[*i].values;
    places.sort_by(|a, b| step(a).total_cmp(&step(b)).then(a.cmp(b)));
    let mut known = KnownValues::default();
    let mut changed = 0;
    for (c, i) in places {
        let (channel, own) = (&clips[c].clip.channels[i], clips[c].steps[i]);
        let most = steps[c] * allowed(channel.property, &own);
        match known.nearest(channel, most) {
            Some(held) => {
                let (values, steps) = (held.values.clone(), held.steps);
                changed += usize::from(values != channel.values);
                clips[c].clip.channels[i].values = values;
                clips[c].steps[i] = steps;
            }
            None => known.add(held(channel, own)),
        }
    }
    changed
}

/// Held values, found by one number of theirs.
#[derive(Default)]
struct KnownValues {
    all: Vec<Held>,
    /// [`number_of`] each, in ascending order, with its index.
    numbers: Vec<(f32, usize)>,
}

impl KnownValues {
    /// The nearest value within a distance; the one that was added first, of several.
    fn nearest(&self, channel: &Channel, most: f32) -> Option<&Held> {
        let number = number_of(channel.property, &channel.values);
        // Rounding leaves none out.
        let wide = 1.01 * most;
        let first = self.numbers.partition_point(|(n, _)| *n < number - wide);
        let near = self.numbers[first..].iter();
        near.take_while(|(n, _)| *n <= number + wide)
            .map(|(_, i)| (distance(channel, &self.all[*i]), *i))
            .filter(|(distance, _)| *distance <= most)
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|(_, i)| &self.all[i])
    }

    fn add(&mut self, held: Held) {
        let number = number_of(held.property, &held.stored);
        let at = self.numbers.partition_point(|(n, _)| *n < number);
        self.numbers.insert(at, (number, self.all.len()));
        self.all.push(held);
    }
}

/// A number of a value that differs by no more than the [`distance`] of two: of a rotation the magnitude of w,
/// which is the same for both of its quaternions.
fn number_of(property: Property, values: &[f32]) -> f32 {
    match property {
        Property::Rotation => values.last().map_or(0.0, |w| w.abs()),
        _ => values.first().copied().unwrap_or(0.0),
    }
}

fn is_held(channel: &Channel) -> bool {
    let is_of_joint = !matches!(channel.property, Property::Weights | Property::Expression);
    let is_plain = channel.interpolation != Interpolation::CubicSpline;
    channel.times_secs.len() == 1 && is_of_joint && is_plain
}

fn held(channel: &Channel, steps: KeySteps) -> Held {
    let clip = RawClip {
        name: String::new(),
        duration_secs: 0.0,
        channels: vec![channel.clone()],
    };
    let mut rounded = rounded_clip(&clip, &[steps]);
    Held {
        property: channel.property,
        values: channel.values.clone(),
        stored: rounded.channels.pop().map_or_else(Vec::new, |c| c.values),
        steps,
    }
}

/// What rounding may change: a turn by a step, a number by half of one.
fn allowed(property: Property, steps: &KeySteps) -> f32 {
    match property {
        Property::Rotation => steps.values,
        _ => 0.5 * steps.values,
    }
}

/// Distance of the value of a channel from one that is stored: the turn between rotations, else of the number that differs
/// most.
fn distance(channel: &Channel, held: &Held) -> f32 {
    if channel.property != held.property || channel.values.len() != held.stored.len() {
        return f32::INFINITY;
    }
    let pairs = || channel.values.iter().zip(&held.stored);
    if channel.property != Property::Rotation {
        return pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    }
    let apart = |sign: f32| -> f32 { pairs().map(|(a, b)| (a - sign * b).powi(2)).sum() };
    2.0 * apart(1.0).min(apart(-1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use proptest::prelude::*;

    fn turn(target: usize, radians: f32) -> Channel {
        Channel {
            target,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: vec![0.0],
            values: Quat::from_rotation_x(radians).to_array().to_vec(),
        }
    }

    fn clip(radians: &[f32], step: f32) -> OptimizedClip {
        let steps = KeySteps {
            values: step,
            times_secs: 1e-3,
        };
        let channels = radians.iter().enumerate().map(|(i, angle)| turn(i, *angle));
        OptimizedClip {
            clip: RawClip {
                name: "hold".into(),
                duration_secs: 1.0,
                channels: channels.collect(),
            },
            steps: vec![steps; radians.len()],
        }
    }

    #[test]
    fn near_values_become_the_most_exact_of_them_and_far_ones_stay() {
        let mut clips = [clip(&[0.505, 0.9], 0.02), clip(&[0.5], 0.001)];
        let before = clips.clone();
        assert_eq!(share_constants(&mut clips, &[1.0, 1.0]), 1);
        assert_eq!(
            clips[0].clip.channels[0].values,
            before[1].clip.channels[0].values
        );
        assert_eq!(clips[0].steps[0], before[1].steps[0]);
        assert_eq!(clips[0].clip.channels[1], before[0].clip.channels[1]);
        assert_eq!(clips[1], before[1]);
        let mut clips = before.clone();
        assert_eq!(share_constants(&mut clips, &[0.0, 1.0]), 0);
        assert_eq!(clips, before);
    }

    proptest! {
        #[test]
        fn no_value_is_nearer_than_the_one_that_is_found(
            angles in proptest::collection::vec(-7.0f32..7.0, 1..40),
            wanted in -7.0f32..7.0,
            most in 0.01f32..1.0,
        ) {
            let mut known = KnownValues::default();
            for angle in &angles {
                let of = clip(&[*angle], 1e-4);
                known.add(held(&of.clip.channels[0], of.steps[0]));
            }
            let channel = turn(0, wanted);
            let found = known.nearest(&channel, most).map(|held| distance(&channel, held));
            let all = known.all.iter().map(|held| distance(&channel, held));
            let least = all.fold(f32::INFINITY, f32::min);
            prop_assert_eq!(found, (least <= most).then_some(least));
        }
    }

    #[test]
    fn what_moves_or_is_of_another_kind_keeps_its_values() {
        let mut moving = clip(&[0.5], 0.02);
        moving.clip.channels[0].times_secs = vec![0.0, 1.0];
        moving.clip.channels[0].values.extend_from_within(..);
        let mut scale = clip(&[0.5], 0.02);
        scale.clip.channels[0].property = Property::Scale;
        scale.clip.channels[0].values = vec![1.0; 3];
        let before = [moving, scale, clip(&[0.5], 0.001)];
        let mut clips = before.clone();
        assert_eq!(share_constants(&mut clips, &[1.0; 3]), 0);
        assert_eq!(clips, before);
    }
}
