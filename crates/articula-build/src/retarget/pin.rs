//! Pinning of feet and hands during contacts: target positions of the end joints.
//!
//! Source: L. Kovar, J. Schreiner, M. Gleicher, Footskate Cleanup for Motion Capture Editing, SCA
//! 2002, for the order: constraints, then the root, then the limbs, blended at their ends. Differs:
//! a foot's heel and toe hand over to each other while it is flat, so that it may roll; a flat foot
//! keeps its direction; limbs never stretch; the root moves vertically only.

use super::contacts::Contact;
use super::steps::Sole;
use articula_core::LibmQuat;
use articula_core::rotation_vector;
use glam::{Quat, Vec3};
use std::ops::Range;

/// Time over which a correction fades in before a contact and out after it.
const FADE_SECS: f32 = 0.15;
/// Maximum angle by which a foot is turned to be flat and keep its direction; 30 degrees.
const MAX_TURN: f32 = 0.5;

/// Path of an end joint before pinning.
#[derive(Debug, Clone, Default)]
pub(super) struct Path {
    /// Position of the end joint at each frame.
    pub(super) places: Vec<Vec3>,
    /// Rotation of the end joint from rest at each frame.
    pub(super) deltas: Vec<Quat>,
}

/// Target of an end joint at a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Goal {
    /// Position of the end joint.
    pub(super) place: Vec3,
    /// Additional rotation, in model space.
    pub(super) turn: Quat,
}

impl Path {
    /// Position of a point that is fixed to the joint.
    fn point(&self, frame: usize, sole: Sole) -> Vec3 {
        sole.at(self.places[frame], self.deltas[frame])
    }
}

/// A contact with the fixed position of its point.
#[derive(Debug, Clone)]
struct Pin {
    frames: Range<usize>,
    sole: Sole,
    place: Vec3,
    on_floor: bool,
}

/// Targets of the end joint with which its points rest during their contacts; `points` are fixed to
/// the joint, `floor` is the target's.
pub(super) fn goals(
    path: &Path,
    points: &[(Sole, &[Contact])],
    floor: f32,
    rate_hz: f32,
) -> Vec<Goal> {
    let pins = pins(path, points, floor);
    let frames = path.places.len();
    let active: Vec<Vec<&Pin>> = (0..frames)
        .map(|f| pins.iter().filter(|p| p.frames.contains(&f)).collect())
        .collect();
    let mut turns: Vec<Option<Vec3>> = (0..frames)
        .map(|f| turn(path.deltas[f], &active[f]))
        .collect();
    fade(&mut turns, rate_hz);
    let turned = |f: usize| Quat::libm_scaled_axis(turns[f].unwrap_or(Vec3::ZERO));
    let mut shifts: Vec<Option<Vec3>> = (0..frames)
        .map(|f| shift(path, f, turned(f), &active[f]))
        .collect();
    fade(&mut shifts, rate_hz);
    (0..frames)
        .map(|f| Goal {
            place: path.places[f] + shifts[f].unwrap_or(Vec3::ZERO),
            turn: turned(f),
        })
        .collect()
}

/// The positions of all contacts, those of one foot consistent with each other.
fn pins(path: &Path, points: &[(Sole, &[Contact])], floor: f32) -> Vec<Pin> {
    let mut contacts: Vec<(Sole, &Contact)> = points
        .iter()
        .flat_map(|(sole, contacts)| contacts.iter().map(|c| (*sole, c)))
        .collect();
    contacts.sort_by_key(|c| (c.1.frames.start, c.1.frames.end));
    let mut pins: Vec<Pin> = Vec::with_capacity(contacts.len());
    for (sole, contact) in contacts {
        let frames = contact.frames.clone();
        let count = frames.len().max(1) as f32;
        let mean = frames.clone().map(|f| path.point(f, sole)).sum::<Vec3>() / count;
        // For a foot that is already flat, the position of the second point follows from the first.
        let mut before = pins.iter().rev().filter(|p| p.frames.end > frames.start);
        let mut place = before.next().map_or(mean, |before| {
            let until = before.frames.end.min(frames.end);
            let middle = (frames.start + until) / 2;
            let way = path.point(middle, sole) - path.point(middle, before.sole);
            before.place + along_floor(way, sole, before.sole)
        });
        place.y = if contact.on_floor { floor } else { mean.y };
        pins.push(Pin {
            frames,
            sole,
            place,
            on_floor: contact.on_floor,
        });
    }
    pins
}

/// The offset between two points of a foot that lies flat on the floor.
fn along_floor(way: Vec3, to: Sole, from: Sole) -> Vec3 {
    let flat = Vec3::new(way.x, 0.0, way.z);
    let rise = to.drop - from.drop;
    let length = to.offset.distance_squared(from.offset) - rise * rise;
    flat.normalize_or_zero() * length.max(0.0).sqrt()
}

/// The rotation of a flat foot with which heel and toe both keep their positions; `None` unless
/// both are in contact.
fn turn(delta: Quat, active: &[&Pin]) -> Option<Vec3> {
    let (first, last) = (active.first()?, active.last()?);
    let is = delta * (last.sole.offset - first.sole.offset);
    let rise = last.sole.drop - first.sole.drop;
    let should = last.place - first.place + Vec3::Y * rise;
    let (is, should) = (is.try_normalize()?, should.try_normalize()?);
    let turn = Quat::from_rotation_arc(is, should);
    let vector = rotation_vector(Quat::IDENTITY, turn);
    (first.on_floor == last.on_floor && vector.length() < MAX_TURN).then_some(vector)
}

/// Displacement of the end joint at a frame; `None` without contact.
fn shift(path: &Path, frame: usize, turn: Quat, active: &[&Pin]) -> Option<Vec3> {
    let delta = turn * path.deltas[frame];
    let need = |pin: &Pin| pin.place - pin.sole.at(path.places[frame], delta);
    let (first, last) = (active.first()?, active.last()?);
    // Where two overlap, the first is blended into the second.
    let start = first.frames.start.max(last.frames.start);
    let end = first.frames.end.min(last.frames.end);
    let share = (frame - start + 1) as f32 / (end - start + 1) as f32;
    Some(need(first).lerp(need(last), smooth(share)))
}

/// Fills frames without a value by fading the values before and after the gap.
fn fade(values: &mut [Option<Vec3>], rate_hz: f32) {
    let reach = (FADE_SECS * rate_hz).max(1.0);
    let known: Vec<usize> = (0..values.len()).filter(|f| values[*f].is_some()).collect();
    for f in 0..values.len() {
        if values[f].is_some() {
            continue;
        }
        let next = known.partition_point(|k| *k < f);
        let before = next.checked_sub(1).map(|i| known[i]);
        let after = known.get(next).copied();
        // In a gap, neither fade reaches beyond the other's contact.
        let gap = match (before, after) {
            (Some(b), Some(a)) => (a - b) as f32,
            _ => reach,
        };
        let span = reach.min(gap);
        let part = |edge: usize| {
            let away = edge.abs_diff(f) as f32;
            values[edge].unwrap_or(Vec3::ZERO) * smooth(1.0 - (away / span).min(1.0))
        };
        let sum: Vec3 = [before, after].into_iter().flatten().map(part).sum();
        values[f] = Some(sum);
    }
}

fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
