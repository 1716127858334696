//! Key reduction with a bound, in metres, on the displacement of the character.
//!
//! Source: ours. Each channel first keeps the ends of the longest runs of keys that it can omit at
//! its own share of the bound, divided by its lever (as in `docs/methods/motion-lod.md` 4.5). Then
//! the whole body is played against its source on a dense grid of times: where any joint or any
//! skin differs by more than the bound, the channel above it with the largest error gets a key
//! back, until the bound holds everywhere. Optimisers of engines bound every channel by itself;
//! here the bound applies to the combined effect of the joint chain on the skin.
//!
//! Every remaining key is one of the source (except the one value of a constant channel), so the
//! bound can always be met: with all keys the error is zero.

mod choice;
mod morphs;
mod observed;
mod proof;
mod watch;

use super::channel;
use super::subject::EditSubject;
use crate::reduce::{ClipSize, whole_clip_size};
use articula_core::Mismatch;
use articula_core::source::RawClip;
use choice::{Choice, KeptKeys};
use observed::Observed;
use proof::Proof;
use watch::Watch;

/// Options of key reduction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReduceOptions {
    /// Maximum distance of any joint, any skin and any end point from its position in the source,
    /// metres.
    pub bound_metres: f32,
    /// Whether channels that equal the rest pose, within the same bound, are dropped. Otherwise
    /// they keep one key, so that a player that blends clips finds them.
    pub drop_rest: bool,
    /// Which keys channels keep.
    pub timelines: Timelines,
}

/// Times of the keys that are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Timelines {
    /// Each channel keeps the keys that it needs: the fewest values.
    #[default]
    Own,
    /// Channels whose keys have the same times in the source keep the same ones: more values, and one
    /// array of times for all.
    Shared,
}

/// A clip with fewer keys, and measurements of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedClip {
    /// The reduced clip.
    pub clip: RawClip,
    /// Maximum distance of any joint, skin or end point from its position in the source, at any
    /// time of the grid, metres. For skin this is an upper bound: the farthest corner of the box,
    /// in its joint's space, of all vertices that the joint moves.
    pub worst_metres: f32,
    /// Number of times that were verified.
    pub times: usize,
    /// Size of the source clip, morph weights included.
    pub before: ClipSize,
    /// Size of the reduced clip.
    pub after: ClipSize,
}

/// Removes keys as long as nothing of the character moves by more than the bound.
///
/// Splines keep their keys unless they are constant: resample them first to reduce them. Values of
/// expressions, which have no length, stay within 1e-4. Cost grows with the length of the clip
/// times its joints.
///
/// # Errors
/// A [`Mismatch`] if the clip does not belong to this character, the bound is not positive, or the
/// clip is longer than can be verified.
pub fn reduce_keys(
    subject: &EditSubject<'_>,
    clip: &RawClip,
    opts: &ReduceOptions,
) -> Result<ReducedClip, Mismatch> {
    KeyReduction::new(subject, clip)?.reduced(opts)
}

/// A clip of which keys can be removed at several bounds. What is observed of the clip is found once.
pub struct KeyReduction<'a> {
    source: Observed<'a>,
}

impl<'a> KeyReduction<'a> {
    /// Evaluates the clip at the times at which reductions are verified.
    ///
    /// # Errors
    /// A [`Mismatch`] if the clip does not belong to this character, or is longer than can be verified.
    pub fn new(subject: &'a EditSubject<'a>, clip: &'a RawClip) -> Result<Self, Mismatch> {
        let source = Observed::new(subject, clip)?;
        Ok(Self { source })
    }

    /// Removes keys as [`reduce_keys`] does.
    ///
    /// # Errors
    /// A [`Mismatch`] if the bound is not positive.
    pub fn reduced(&self, opts: &ReduceOptions) -> Result<ReducedClip, Mismatch> {
        if !(opts.bound_metres.is_finite() && opts.bound_metres > 0.0) {
            let what = format!("must be positive and finite, found {}", opts.bound_metres);
            return Err(Mismatch::new("bound_metres", what));
        }
        let clip = self.source.clip;
        let mut choices = choice::first(&self.source, opts);
        let mut proof = Proof::new(&self.source, opts);
        let mut worst_metres = proof.tighten(&mut choices);
        // Channels of shared times have lost the same keys.
        if opts.timelines == Timelines::Own && choice::give_back(&mut choices) {
            worst_metres = proof.tighten(&mut choices);
        }
        let left = choices.iter().filter(|c| c.kept != KeptKeys::Rest);
        let mut out = RawClip {
            channels: left.map(Choice::shown).collect(),
            ..clip.clone()
        };
        // A clip without any channel could not be written to a file.
        if out.channels.is_empty() {
            out.channels.extend(choices.first().map(Choice::shown));
        }
        channel::keep_length(&mut out);
        Ok(ReducedClip {
            worst_metres,
            times: self.source.times.len(),
            before: whole_clip_size(clip),
            after: whole_clip_size(&out),
            clip: out,
        })
    }
}

/// For each channel of a clip, the change of a value by which nothing of the character moves by more
/// than `metres`, if no other channel changes: in radians for rotations, else in the unit of the values.
///
/// # Errors
/// A [`Mismatch`] if the clip does not belong to this character.
pub fn value_tolerances(
    subject: &EditSubject<'_>,
    clip: &RawClip,
    metres: f32,
) -> Result<Vec<f32>, Mismatch> {
    subject.check(clip)?;
    let levers = Watch::new(subject, clip).levers(subject);
    let tolerance = |channel| choice::value_tolerance(subject, channel, &levers, metres);
    Ok(clip.channels.iter().map(tolerance).collect())
}

#[cfg(test)]
mod tests {
    use super::super::test_clips::{bar, line};
    use super::*;
    use articula_core::source::{Channel, Interpolation, Property};
    use glam::{Quat, Vec3};

    /// The end of a bar of two joints, 1.5 m from the first.
    const END: [(usize, Vec3); 1] = [(1, Vec3::new(0.5, 0.0, 0.0))];

    /// Turns of one joint about z, ten keys a second.
    fn turns(target: usize, radians: &[f32]) -> Channel {
        Channel {
            target,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: (0..radians.len()).map(|i| i as f32 / 10.0).collect(),
            values: radians
                .iter()
                .flat_map(|a| Quat::from_rotation_z(*a).to_array())
                .collect(),
        }
    }

    fn clip(channels: Vec<Channel>) -> RawClip {
        RawClip {
            name: "bar".into(),
            duration_secs: 1.0,
            channels,
        }
    }

    fn keys(
        bar: &EditSubject<'_>,
        clip: &RawClip,
        bound_metres: f32,
        drop_rest: bool,
    ) -> Vec<usize> {
        let opts = ReduceOptions {
            bound_metres,
            drop_rest,
            timelines: Timelines::Own,
        };
        let out = reduce_keys(bar, clip, &opts).unwrap();
        assert!(out.worst_metres <= bound_metres);
        assert_eq!(out.clip.duration_secs, 1.0);
        let channels = out.clip.channels.iter();
        channels.map(|c| c.times_secs.len()).collect()
    }

    #[test]
    fn an_even_turn_needs_two_keys_and_a_bump_as_many_as_it_shows() {
        let (character, articulation) = bar(2);
        let bar = EditSubject::new(&character, articulation, &END).unwrap();
        let mut even: Vec<f32> = (0..=10).map(|i| 0.05 * i as f32).collect();
        assert_eq!(keys(&bar, &clip(vec![turns(0, &even)]), 1e-4, false), [2]);
        // The end of the bar is 1.5 m away: 4 mrad are 6 mm there.
        even[5] += 0.004;
        let bumped = clip(vec![turns(0, &even)]);
        assert_eq!(keys(&bar, &bumped, 0.0061, false), [2]);
        assert_eq!(keys(&bar, &bumped, 0.0059, false), [3]);
        assert!(keys(&bar, &bumped, 1e-4, false)[0] >= 5);
    }

    #[test]
    fn errors_of_a_chain_count_together() {
        // Each joint alone errs by 0.9 mm at the end of the bar; both together by 1.8 mm.
        let (character, articulation) = bar(2);
        let bar = EditSubject::new(&character, articulation, &END).unwrap();
        let bump = |size: f32| (0..=10).map(move |i| if i == 5 { size } else { 0.0 });
        let near: Vec<f32> = bump(0.0009 / 1.5).collect();
        let far: Vec<f32> = bump(0.0009 / 0.5).collect();
        let alone = [turns(0, &near), turns(1, &far)];
        for channel in &alone {
            // As a constant, half of the bump is left on either side.
            assert_eq!(
                keys(&bar, &clip(vec![channel.clone()]), 0.00046, false),
                [1 + 1]
            );
        }
        let both = clip(alone.to_vec());
        assert!(keys(&bar, &both, 0.00091, false).iter().sum::<usize>() <= 3);
        assert!(keys(&bar, &both, 0.00080, false).iter().sum::<usize>() > 3);
    }

    #[test]
    fn channels_of_the_same_times_share_their_keys() {
        let (character, articulation) = bar(2);
        let bar = EditSubject::new(&character, articulation, &END).unwrap();
        let bump = |at: usize| (0..=10).map(move |i| if i == at { 0.1 } else { 0.0 });
        let [near, far] = [3, 7].map(|at| bump(at).collect::<Vec<f32>>());
        let still = line(&[0.0, 0.5, 1.0], &[0.2; 3]).channels.remove(0);
        let source = clip(vec![turns(0, &near), turns(1, &far), still]);
        let reduced = |timelines| {
            let opts = ReduceOptions {
                bound_metres: 1e-3,
                drop_rest: false,
                timelines,
            };
            let out = reduce_keys(&bar, &source, &opts).unwrap();
            assert!(out.worst_metres <= 1e-3);
            out.clip.channels.into_iter().map(|c| c.times_secs)
        };
        let [a, b, c] = reduced(Timelines::Own)
            .collect::<Vec<_>>()
            .try_into()
            .unwrap();
        assert!(a.len() == 5 && b.len() == 5 && a != b && c.len() == 1);
        let [a, b, c] = reduced(Timelines::Shared)
            .collect::<Vec<_>>()
            .try_into()
            .unwrap();
        assert_eq!(a, b);
        // The ends, and both bumps with their feet.
        assert_eq!(a, [0.0, 0.2, 0.3, 0.4, 0.6, 0.7, 0.8, 1.0]);
        assert_eq!(c.len(), 1);
    }

    #[test]
    fn what_stands_still_keeps_one_key_and_at_rest_none() {
        let (character, articulation) = bar(3);
        let bar = EditSubject::new(&character, articulation, &[]).unwrap();
        let rest = line(&[0.0, 0.5, 1.0], &[0.0; 3]).channels.remove(0);
        let still = clip(vec![turns(1, &[0.3; 11]), rest, turns(2, &[0.0; 11])]);
        // One channel marks the end of the clip.
        assert_eq!(keys(&bar, &still, 1e-4, false), [2, 1, 1]);
        assert_eq!(keys(&bar, &still, 1e-4, true), [2]);
        let at_rest = clip(vec![turns(2, &[0.0; 11])]);
        assert_eq!(
            keys(&bar, &at_rest, 1e-4, true),
            [2],
            "a clip without channels is none"
        );
        assert!(keys(&bar, &clip(Vec::new()), 1e-4, true).is_empty());
    }

    #[test]
    fn the_turn_of_a_last_joint_counts_by_what_hangs_from_it() {
        let (character, articulation) = bar(2);
        let twist: Vec<f32> = (0..=10).map(|i| 0.01 * (i as f32).sin()).collect();
        let twist = clip(vec![turns(1, &twist)]);
        // Without skin a lever of half of the last bone is used: 0.01 rad move it by less than 5
        // mm.
        let bar_alone = EditSubject::new(&character, articulation.clone(), &[]).unwrap();
        assert_eq!(keys(&bar_alone, &twist, 0.005, false), [2]);
        assert!(keys(&bar_alone, &twist, 0.001, false)[0] > 2);
        // An end that is 2 m away moves by 2 cm.
        let ends = [(1, Vec3::new(2.0, 0.0, 0.0))];
        let with_end = EditSubject::new(&character, articulation, &ends).unwrap();
        assert!(keys(&with_end, &twist, 0.005, false)[0] > 2);
    }

    #[test]
    fn splines_keep_their_keys_and_bad_bounds_are_refused() {
        let (character, articulation) = bar(1);
        let bar = EditSubject::new(&character, articulation, &[]).unwrap();
        let mut spline = line(&[0.0, 0.5, 1.0], &[0.0; 3]);
        spline.channels[0].interpolation = Interpolation::CubicSpline;
        spline.channels[0].values = vec![0.0; 27];
        assert_eq!(keys(&bar, &spline, 1e-3, false), [2]);
        spline.channels[0].values[6] = 1.0;
        assert_eq!(keys(&bar, &spline, 1e-3, false), [3]);
        for bound_metres in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let opts = ReduceOptions {
                bound_metres,
                drop_rest: false,
                timelines: Timelines::Own,
            };
            assert!(reduce_keys(&bar, &spline, &opts).is_err());
        }
    }
}
