//! Levels of a motion at given steps, and the motion that a decoder shows.
//!
//! Form: `docs/methods/motion-stream.md`, part 4.

use super::plan::PlannedTrack;
use super::truth::Truth;
use crate::abp2::head::MotionHead;
use crate::abp2::levels::{MOST_LEVEL, coarser};
use crate::abp2::pose_unit::{Kind, TrackForm, can_code};
use crate::abp2::rotation::log;
use crate::abp2::step::{POINT, code, coefficient, level, level_size, step};
use crate::abp2::tracks::{TrackPlace, unit};
use crate::abp2::wavelet::{Place, closed_loop, forward, inverse, order};
use articula_core::{Mismatch, Rig};
use glam::{DQuat, DVec3, Vec3};

/// Steps of constants, as a part of those that would alone use the tolerance.
const CONSTANT_SHARE: f64 = 0.15;

/// A motion as levels of plane 0.
#[derive(Debug, Clone)]
pub(super) struct Levels {
    /// The tracks that are not at rest.
    pub(super) tracks: Vec<TrackPlace>,
    /// Levels of each track in each access unit: `[track][access unit]`, axis by axis in coded
    /// order; empty for a constant.
    pub(super) levels: Vec<Vec<Vec<i32>>>,
}

/// What stays the same while steps are searched.
pub(super) struct Coding<'a> {
    pub(super) rig: &'a Rig,
    pub(super) head: &'a MotionHead,
    pub(super) truth: &'a Truth,
    pub(super) planned: &'a [PlannedTrack],
    /// Whether the error of a joint's parents can be taken back by its own rotation.
    pub(super) compensates: Vec<bool>,
    /// Coded order of each access unit.
    pub(super) orders: Vec<Vec<Place>>,
}

impl<'a> Coding<'a> {
    pub(super) fn new(
        rig: &'a Rig,
        head: &'a MotionHead,
        truth: &'a Truth,
        planned: &'a [PlannedTrack],
    ) -> Self {
        // A mirrored or uneven scale above a joint turns rotations into others.
        let mut compensates = vec![true; rig.len()];
        for joint in 0..rig.len() {
            if let Some(parent) = rig.parent(joint) {
                let scale = rig.rest_pose().scales[parent];
                let is_even = (scale - Vec3::splat(scale.x)).length() < 1e-4 * scale.x;
                compensates[joint] = compensates[parent] && is_even;
            }
        }
        let frames = |i| head.frames_of(i).len();
        Self {
            rig,
            head,
            truth,
            planned,
            compensates,
            orders: (0..head.access_units).map(|i| order(frames(i))).collect(),
        }
    }

    /// Quantises the motion with the given step of each track. Returns its levels, and the motion
    /// that they decode to.
    ///
    /// # Errors
    /// If a value is too large for the form.
    pub(super) fn quantise(&self, steps: &[f64]) -> Result<(Levels, Truth), Mismatch> {
        let mut shown = Truth {
            rotations: self.rig.rest_pose().rotations.repeat(self.truth.frames),
            translations: self.rig.rest_pose().translations.repeat(self.truth.frames),
            scales: self.rig.rest_pose().scales.repeat(self.truth.frames),
            weights: vec![0.0; self.truth.weights.len()],
            ..self.truth.clone()
        };
        let mut levels = Levels {
            tracks: Vec::with_capacity(self.planned.len()),
            levels: Vec::with_capacity(self.planned.len()),
        };
        // Model rotations of every joint and frame, true and decoded.
        let mut chains = Chains::new(self.truth);
        let mut at = 0;
        for joint in 0..self.rig.len() {
            while let Some(track) = self.planned.get(at)
                && track.kind != Kind::Morph
                && usize::from(track.target) == joint
            {
                self.track(at, steps[at], &chains, &mut levels, &mut shown)?;
                at += 1;
            }
            chains.turn(self.rig, joint, self.truth, &shown);
        }
        for (morph, step) in steps.iter().enumerate().skip(at) {
            self.track(morph, *step, &chains, &mut levels, &mut shown)?;
        }
        Ok((levels, shown))
    }

    fn track(
        &self,
        at: usize,
        wanted: f64,
        chains: &Chains,
        levels: &mut Levels,
        shown: &mut Truth,
    ) -> Result<(), Mismatch> {
        let planned = &self.planned[at];
        let too_large = || {
            let what = "a value too large for a motion stream; scale the character to metres";
            Mismatch::new(format!("{:?} of {}", planned.kind, planned.target), what)
        };
        let place = |form| TrackPlace {
            kind: planned.kind,
            target: planned.target,
            form,
        };
        let exponent = planned.exponent;
        // Steps are in the unit of the track.
        let wanted = wanted / f64::from(unit(exponent));
        if !planned.moves {
            let code = code(wanted * CONSTANT_SHARE);
            let size = step(code) * f64::from(unit(exponent));
            let form = TrackForm::Constant {
                code,
                exponent,
                numbers: planned.reference.map(|x| (x / size).round() as i32),
            };
            if !can_code(&form) {
                return Err(too_large());
            }
            let track = place(form);
            show(&track, self.rig, 0..self.truth.frames, None, shown);
            levels.tracks.push(track);
            levels.levels.push(Vec::new());
            return Ok(());
        }
        let code = code(wanted);
        let form = TrackForm::Moving {
            code,
            exponent,
            numbers: planned.numbers(),
            planes: Default::default(),
        };
        if !can_code(&form) {
            return Err(too_large());
        }
        let track = place(form);
        let targets = self.targets(&track, chains);
        let scale = f64::from(1_u32 << POINT) / f64::from(unit(exponent));
        let mut of_units = Vec::with_capacity(self.orders.len());
        for (number, places) in self.orders.iter().enumerate() {
            let frames = self.head.frames_of(number);
            let n = frames.len();
            let mut values = vec![0; track.kind.axes() * n];
            let mut found = vec![0; values.len()];
            for axis in 0..track.kind.axes() {
                let x = &mut values[axis * n..][..n];
                for (x, target) in x.iter_mut().zip(&targets[frames.clone()]) {
                    *x = (target[axis] * scale).round() as i64;
                }
                let fits = quantise_axis(
                    x,
                    &mut found[axis * n..][..n],
                    places,
                    code,
                    self.head.updates,
                );
                fits.ok_or_else(too_large)?;
            }
            show(&track, self.rig, frames, Some(&values), shown);
            of_units.push(found);
        }
        levels.tracks.push(track);
        levels.levels.push(of_units);
        Ok(())
    }

    /// The values that a moving track should have, relative to its reference.
    fn targets(&self, track: &TrackPlace, chains: &Chains) -> Vec<DVec3> {
        let target = usize::from(track.target);
        let rest = self.rig.rest_pose();
        let at = |frame: usize| frame * self.truth.joints + target;
        let reference = match track.kind {
            Kind::Rotation => None,
            Kind::Translation => Some(track.vector(rest.translations[target])),
            Kind::Scale => Some(track.vector(rest.scales[target])),
            Kind::Morph => Some(Vec3::from(track.reference())),
        };
        let rotation = (track.kind == Kind::Rotation).then(|| {
            track
                .rotation(rest.rotations[target])
                .as_dquat()
                .normalize()
        });
        let mut before = DVec3::ZERO;
        (0..self.truth.frames)
            .map(|frame| {
                let value = match track.kind {
                    Kind::Rotation => {
                        let wanted = if self.compensates[target] {
                            chains.wanted(self.rig, target, frame, self.truth)
                        } else {
                            self.truth.rotation(frame, target)
                        };
                        let key = rotation.unwrap_or(DQuat::IDENTITY);
                        before = log(key.conjugate() * wanted, before);
                        return before;
                    }
                    Kind::Translation => self.truth.translations[at(frame)],
                    Kind::Scale => self.truth.scales[at(frame)],
                    Kind::Morph => Vec3::X * self.truth.weights(frame)[target],
                };
                value.as_dvec3() - reference.unwrap_or(Vec3::ZERO).as_dvec3()
            })
            .collect()
    }

    /// The motion that the levels show if each track drops some planes.
    pub(super) fn shown(&self, levels: &Levels, dropped: &[u8], start: &Truth) -> Truth {
        let mut shown = start.clone();
        let mut values = Vec::new();
        let moving = levels.tracks.iter().zip(&levels.levels).zip(dropped);
        for ((track, of_units), dropped) in
            moving.filter(|((track, _), _)| track.moving().is_some())
        {
            for (number, found) in of_units.iter().enumerate() {
                self.values(track, found, number, *dropped, &mut values);
                show(
                    track,
                    self.rig,
                    self.head.frames_of(number),
                    Some(&values),
                    &mut shown,
                );
            }
        }
        shown
    }

    /// The decoded values of a track in an access unit.
    pub(super) fn values(
        &self,
        track: &TrackPlace,
        levels: &[i32],
        access_unit: usize,
        dropped: u8,
        values: &mut Vec<i64>,
    ) {
        let places = &self.orders[access_unit];
        let Some((code, _)) = track.moving() else {
            return;
        };
        values.clear();
        values.resize(levels.len(), 0);
        for (levels, x) in levels
            .chunks(places.len())
            .zip(values.chunks_mut(places.len()))
        {
            for (level, place) in levels.iter().zip(places) {
                let level = (0..dropped).fold(*level, |level, _| coarser(level));
                let size = level_size(code, place.class, place.band, self.head.updates);
                let value = coefficient(level, u32::from(dropped), size);
                x[place.frame as usize] = value.unwrap_or(0);
            }
            inverse(x, self.head.updates);
        }
    }
}

/// Quantises the values of one axis, and replaces them by decoded ones; `None` if they are too
/// large.
fn quantise_axis(
    x: &mut [i64],
    levels: &mut [i32],
    places: &[Place],
    code: i32,
    updates: bool,
) -> Option<()> {
    let mut fits = true;
    let mut quantised = |value: i64, class, band| {
        let size = level_size(code, class, band, updates);
        let level = level(value, size);
        fits &= level.abs() <= f64::from(MOST_LEVEL);
        let level = if fits { level as i32 } else { 0 };
        let decoded = coefficient(level, 0, size);
        fits &= decoded.is_some();
        (level, decoded.unwrap_or(0))
    };
    if updates {
        forward(x, true);
        for (place, out) in places.iter().zip(&mut *levels) {
            let frame = place.frame as usize;
            (*out, x[frame]) = quantised(x[frame], place.class, place.band);
        }
        inverse(x, true);
    } else {
        let mut place_of = vec![0; x.len()];
        for (at, place) in places.iter().enumerate() {
            place_of[place.frame as usize] = at;
        }
        closed_loop(x, |frame, difference| {
            let at = place_of[frame];
            let (level, decoded) = quantised(difference, places[at].class, places[at].band);
            levels[at] = level;
            decoded
        });
    }
    fits.then_some(())
}

/// Writes the values of a track at some frames into a motion: `values` relative to its reference,
/// or the reference alone.
pub(super) fn show(
    track: &TrackPlace,
    rig: &Rig,
    frames: std::ops::Range<usize>,
    values: Option<&[i64]>,
    shown: &mut Truth,
) {
    use crate::abp2::rotation::{exp, product};
    let target = usize::from(track.target);
    let rest = rig.rest_pose();
    let n = frames.len();
    let unit = track.unit();
    let real = |axis: usize, i: usize| {
        values.map_or(0.0, |x| {
            x[axis * n + i] as f32 * (1.0 / (1_u32 << POINT) as f32) * unit
        })
    };
    let vector = |i: usize| [real(0, i), real(1, i), real(2, i)];
    let at = |frame: usize| frame * shown.joints + target;
    match track.kind {
        Kind::Rotation => {
            let reference = track.rotation(rest.rotations[target]);
            for (i, frame) in frames.enumerate() {
                shown.rotations[at(frame)] = product(reference, exp(vector(i)));
            }
        }
        Kind::Translation => {
            let reference = track.vector(rest.translations[target]);
            for (i, frame) in frames.enumerate() {
                shown.translations[at(frame)] = reference + Vec3::from(vector(i));
            }
        }
        Kind::Scale => {
            let reference = track.vector(rest.scales[target]);
            for (i, frame) in frames.enumerate() {
                shown.scales[at(frame)] = reference + Vec3::from(vector(i));
            }
        }
        Kind::Morph => {
            let reference = track.reference()[0];
            for (i, frame) in frames.enumerate() {
                shown.weights[frame * shown.targets + target] = reference + real(0, i);
            }
        }
    }
}

/// Model rotations of joints, true and decoded, without scale.
struct Chains {
    frames: usize,
    joints: usize,
    truth: Vec<DQuat>,
    decoded: Vec<DQuat>,
}

impl Chains {
    fn new(truth: &Truth) -> Self {
        let count = truth.frames * truth.joints;
        Self {
            frames: truth.frames,
            joints: truth.joints,
            truth: vec![DQuat::IDENTITY; count],
            decoded: vec![DQuat::IDENTITY; count],
        }
    }

    /// The local rotation with which a joint has its true model rotation below decoded parents.
    fn wanted(&self, rig: &Rig, joint: usize, frame: usize, truth: &Truth) -> DQuat {
        let local = truth.rotation(frame, joint);
        match rig.parent(joint) {
            Some(parent) => {
                let at = frame * self.joints + parent;
                (self.decoded[at].conjugate() * self.truth[at] * local).normalize()
            }
            None => local,
        }
    }

    /// Adds a joint whose parents are there.
    fn turn(&mut self, rig: &Rig, joint: usize, truth: &Truth, shown: &Truth) {
        for frame in 0..self.frames {
            let at = frame * self.joints + joint;
            let local = truth.rotation(frame, joint);
            let decoded = shown.rotation(frame, joint);
            let above = rig.parent(joint).map(|parent| frame * self.joints + parent);
            let on = |chain: &[DQuat], local| above.map_or(local, |above| chain[above] * local);
            self.truth[at] = on(&self.truth, local);
            self.decoded[at] = on(&self.decoded, decoded);
        }
    }
}
