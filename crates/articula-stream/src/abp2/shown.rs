//! What the tracks of a motion show: decoded values, their reference, or the frame before.
//!
//! Form: `docs/formats/abp2.md`, parts 4 and 8. What is shown depends on the values of each access unit
//! alone, not on the order in which they were set.

use super::pose_unit::{Kind, TrackForm};
use super::rotation::{exp, product};
use super::step::POINT;
use super::tracks::{TrackPlace, TrackTable};
use articula_core::{Rig, Track, Tracks, same_hemisphere};
use glam::{Quat, Vec3};
use std::ops::Range;

/// What a track shows in some frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// Decoded values.
    Values,
    /// Its reference value.
    Reference,
    /// The frame before; its reference value before the first.
    Before,
}

/// The tracks at every frame.
#[derive(Debug, Clone)]
pub(super) struct Shown {
    pub(super) tracks: Tracks,
    /// For each track of the table its index in the tracks of its kind.
    at: Vec<usize>,
}

impl Shown {
    /// All tracks at their reference values.
    pub(super) fn new(table: &TrackTable, rig: &Rig, frames: usize) -> Self {
        let mut tracks = Tracks::default();
        let rest = rig.rest_pose();
        let place = |place: &TrackPlace| {
            let target = place.target;
            let count = if place.moving().is_some() { frames } else { 1 };
            let is_rest = place.form == TrackForm::Rest;
            let joint = usize::from(target);
            match place.kind {
                Kind::Rotation if !is_rest => push(
                    &mut tracks.rotations,
                    target,
                    vec![place.rotation(rest.rotations[joint]); count],
                ),
                Kind::Translation if !is_rest => push(
                    &mut tracks.translations,
                    target,
                    vec![place.vector(rest.translations[joint]); count],
                ),
                Kind::Scale if !is_rest => push(
                    &mut tracks.scales,
                    target,
                    vec![place.vector(rest.scales[joint]); count],
                ),
                // A mesh has weights of its own: those at rest are told.
                Kind::Morph => push(
                    &mut tracks.morphs,
                    target,
                    vec![place.reference()[0]; count],
                ),
                _ => usize::MAX,
            }
        };
        let at = table.tracks.iter().map(place).collect();
        Self { tracks, at }
    }

    /// Sets some frames of a track that moves to its reference value.
    pub(super) fn rest(
        &mut self,
        (track, place): (usize, &TrackPlace),
        frames: Range<usize>,
        rig: &Rig,
    ) {
        let pose = rig.rest_pose();
        let (joint, at) = (usize::from(place.target), self.at[track]);
        let tracks = &mut self.tracks;
        match place.kind {
            Kind::Rotation => {
                let value = place.rotation(pose.rotations[joint]);
                tracks.rotations[at].values[frames].fill(value);
            }
            Kind::Translation => {
                let value = place.vector(pose.translations[joint]);
                tracks.translations[at].values[frames].fill(value);
            }
            Kind::Scale => tracks.scales[at].values[frames].fill(place.vector(pose.scales[joint])),
            Kind::Morph => tracks.morphs[at].values[frames].fill(place.reference()[0]),
        }
    }

    /// Sets the frames of a track from `start` by decoded values. Rotations then follow each other, but
    /// not yet the frame before `start`.
    pub(super) fn set(
        &mut self,
        (track, place): (usize, &TrackPlace),
        start: usize,
        values: &[i64],
        rig: &Rig,
    ) {
        let (joint, at) = (usize::from(place.target), self.at[track]);
        let frames = values.len() / place.kind.axes();
        let unit = place.unit();
        let value = |axis: usize, i: usize| real(values[axis * frames + i]) * unit;
        let vector = |i: usize| [value(0, i), value(1, i), value(2, i)];
        let rest = rig.rest_pose();
        let tracks = &mut self.tracks;
        match place.kind {
            Kind::Rotation => {
                let reference = place.rotation(rest.rotations[joint]);
                let out = &mut tracks.rotations[at].values[start..];
                let mut before = None;
                for (i, out) in out.iter_mut().take(frames).enumerate() {
                    let value = product(reference, exp(vector(i)));
                    *out = before.map_or(value, |before| same_hemisphere(before, value));
                    before = Some(*out);
                }
            }
            Kind::Translation | Kind::Scale => {
                let (rest, out) = match place.kind {
                    Kind::Scale => (rest.scales[joint], &mut tracks.scales[at].values),
                    _ => (
                        rest.translations[joint],
                        &mut tracks.translations[at].values,
                    ),
                };
                let reference = place.vector(rest);
                for (i, out) in out[start..].iter_mut().take(frames).enumerate() {
                    *out = reference + Vec3::from(vector(i));
                }
            }
            Kind::Morph => {
                let reference = place.reference()[0];
                let out = &mut tracks.morphs[at].values;
                for (i, out) in out[start..].iter_mut().take(frames).enumerate() {
                    *out = reference + value(0, i);
                }
            }
        }
    }

    /// Makes a track follow the frames before: fills what shows the frame before, and gives rotations
    /// the sign that is nearest to it. The rising `spans` join each other; frames before them follow
    /// already. Spans that begin before frame `changed` may be new, later ones change only as they follow
    /// those before. Returns the end of the frames that changed.
    pub(super) fn follow(
        &mut self,
        (track, place): (usize, &TrackPlace),
        spans: impl Iterator<Item = (Range<usize>, Source)>,
        changed: usize,
        rig: &Rig,
    ) -> usize {
        let pose = rig.rest_pose();
        let (joint, at) = (usize::from(place.target), self.at[track]);
        let tracks = &mut self.tracks;
        match place.kind {
            Kind::Rotation => {
                let reference = place.rotation(pose.rotations[joint]);
                let out = &mut tracks.rotations[at].values;
                follow(out, reference, spans, changed, turn)
            }
            Kind::Translation => {
                let reference = place.vector(pose.translations[joint]);
                let out = &mut tracks.translations[at].values;
                follow(out, reference, spans, changed, |_, _| false)
            }
            Kind::Scale => {
                let reference = place.vector(pose.scales[joint]);
                let out = &mut tracks.scales[at].values;
                follow(out, reference, spans, changed, |_, _| false)
            }
            Kind::Morph => {
                let reference = place.reference()[0];
                let out = &mut tracks.morphs[at].values;
                follow(out, reference, spans, changed, |_, _| false)
            }
        }
    }
}

fn push<T>(tracks: &mut Vec<Track<T>>, target: u16, values: Vec<T>) -> usize {
    tracks.push(Track {
        target,
        step: false,
        values,
    });
    tracks.len() - 1
}

/// A decoded whole number as a value.
fn real(x: i64) -> f32 {
    x as f32 * (1.0 / (1_u32 << POINT) as f32)
}

/// As [`Shown::follow`], of the values of one track; `turn` makes values follow the one before them, and
/// tells whether they changed.
fn follow<T: Copy>(
    values: &mut [T],
    reference: T,
    spans: impl Iterator<Item = (Range<usize>, Source)>,
    changed: usize,
    turn: impl Fn(T, &mut [T]) -> bool,
) -> usize {
    let mut end = changed;
    for (frames, source) in spans {
        let (known, rest) = values.split_at_mut(frames.start);
        let before = known.last().copied().unwrap_or(reference);
        let of_span = &mut rest[..frames.len()];
        let has_changed = match source {
            Source::Values => turn(before, of_span),
            Source::Reference => false,
            Source::Before => {
                of_span.fill(before);
                true
            }
        };
        if has_changed {
            end = end.max(frames.end);
        } else if frames.start >= changed {
            break;
        }
    }
    end
}

/// Gives rotations that follow each other the sign nearest to the one before them; tells whether that
/// changed any.
fn turn(before: Quat, values: &mut [Quat]) -> bool {
    let Some(first) = values.first_mut() else {
        return false;
    };
    // Neither sign is nearer: one that depends on the value alone, whatever it was turned to before.
    let sign = |q: Quat| q.to_array().into_iter().find(|x| *x != 0.0).unwrap_or(0.0);
    if !opposes(before, *first) && (opposes(before, -*first) || sign(*first) >= 0.0) {
        return false;
    }
    *first = -*first;
    for i in 1..values.len() {
        // Where a value has no nearer sign, it has its own, and so have those that follow.
        if !opposes(values[i - 1], values[i]) {
            break;
        }
        values[i] = -values[i];
    }
    true
}

/// Whether the other sign of `b` is nearer to `a`.
fn opposes(a: Quat, b: Quat) -> bool {
    same_hemisphere(a, b) != b
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn signs_follow_by_hand() {
        let z = |degrees: f32| Quat::from_rotation_z(degrees.to_radians());
        let mut values = [-z(10.0), -z(20.0), -z(30.0)];
        assert!(turn(z(0.0), &mut values));
        assert_eq!(values, [z(10.0), z(20.0), z(30.0)]);
        assert!(!turn(z(0.0), &mut values));
        // Half a turn about x from rest: no sign is nearer.
        let half = Quat::from_xyzw(1.0, 0.0, 0.0, 0.0);
        for mut values in [[half], [-half]] {
            turn(Quat::IDENTITY, &mut values);
            assert_eq!(values, [half]);
        }
        // What follows at a right angle keeps its own sign.
        let mut values = [-Quat::IDENTITY, half, half];
        assert!(turn(Quat::IDENTITY, &mut values));
        assert_eq!(values, [Quat::IDENTITY, half, half]);
    }

    proptest! {
        #[test]
        fn what_follows_depends_on_the_values_alone(
            turns in prop::collection::vec(0_u8..4, 12),
            sources in prop::collection::vec(0_u8..3, 4),
            order in prop::collection::vec(0_usize..4, 1..8),
        ) {
            // Four access units of three frames; half turns about x have no nearer sign.
            let half = Quat::from_xyzw(1.0, 0.0, 0.0, 0.0);
            let all = [Quat::IDENTITY, half, -Quat::IDENTITY, -half];
            let raw: Vec<Quat> = turns.iter().map(|turn| all[usize::from(*turn)]).collect();
            let of = |access_unit: usize| match sources[access_unit] {
                0 => Source::Values,
                1 => Source::Reference,
                _ => Source::Before,
            };
            let own = |values: &mut [Quat], access_unit: usize| {
                let frames = 3 * access_unit..3 * access_unit + 3;
                match of(access_unit) {
                    Source::Values => {
                        values[frames.clone()].copy_from_slice(&raw[frames.clone()]);
                        for i in frames.start + 1..frames.end {
                            values[i] = same_hemisphere(values[i - 1], values[i]);
                        }
                    }
                    Source::Reference => values[frames].fill(Quat::IDENTITY),
                    Source::Before => {}
                }
            };
            // What is not there yet shows the frame before.
            let spans = |there: &[bool; 4], first: usize| {
                let source = |i: usize| if there[i] { of(i) } else { Source::Before };
                let span = |i: usize| (3 * i..3 * i + 3, source(i));
                (first..4).map(span).collect::<Vec<_>>().into_iter()
            };
            let mut there = [false; 4];
            let mut shown = vec![Quat::IDENTITY; 12];
            for access_unit in order {
                there[access_unit] = true;
                own(&mut shown, access_unit);
                let end = 3 * access_unit + 3;
                follow(&mut shown, Quat::IDENTITY, spans(&there, access_unit), end, turn);
                // The same from nothing, in rising order.
                let mut expected = vec![Quat::IDENTITY; 12];
                (0..4).filter(|i| there[*i]).for_each(|i| own(&mut expected, i));
                follow(&mut expected, Quat::IDENTITY, spans(&there, 0), 12, turn);
                let bits = |q: &[Quat]| q.iter().map(|q| q.to_array().map(f32::to_bits)).collect::<Vec<_>>();
                prop_assert_eq!(bits(&shown), bits(&expected));
            }
        }
    }
}
