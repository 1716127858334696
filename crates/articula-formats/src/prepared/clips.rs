//! The parts `clips` and `clipsInPlace`: clips at a uniform rate, and those whose root motion was
//! removed.

use super::numbers::{Numbers, Writer};
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::crowd::{RootDelta, RootTrajectory};
use articula_core::source::{Interpolation, Property, RawClip};
use articula_core::{Clip, Track, Tracks, same_hemisphere};
use glam::{Quat, Vec3};
use std::borrow::Cow;
use std::collections::HashMap;

/// The values of the track hold until the next frame.
const STEP: u8 = 1;
/// The track has one value for all frames.
const CONSTANT: u8 = 2;
/// The values are those of the other form of the clip, and none follow: the keys of the source for a
/// clip, the track of the clip for a clip in place.
const REFERENCE: u8 = 4;
/// The track in memory has one value, as opposed to one for each frame.
const SINGLE: u8 = 8;

/// Clips of a character whose travelling clips were put in place.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ClipsInPlace {
    /// For each clip that travels, the clip in place and its root motion.
    pub travelling: Vec<Option<(Clip, RootTrajectory)>>,
    /// Warnings about clips that travel but could not be put in place.
    pub warnings: Vec<String>,
}

/// Encodes clips; tracks whose values are the keys of their `sources` are stored by reference.
pub fn write_clips(clips: &[Clip], sources: &[RawClip]) -> Vec<u8> {
    let mut out = Writer::default();
    out.count(clips.len());
    for (c, clip) in clips.iter().enumerate() {
        let keys = sources.get(c).map(|source| keys_of(source, clip.frames()));
        put(&mut out, clip, keys.as_ref());
    }
    out.0
}

/// Decodes the output of [`write_clips`] with the same sources.
///
/// # Errors
/// [`ReadError::Malformed`] with the byte offset, [`ReadError::LimitExceeded`].
pub fn read_clips(
    bytes: &[u8],
    sources: &[RawClip],
    limits: &Limits,
) -> Result<Vec<Clip>, ReadError> {
    let mut r = Numbers::new(bytes, limits)?;
    let count = r.count(1, "clips")?;
    let mut clips = Vec::with_capacity(count);
    let mut spent = 0;
    for c in 0..count {
        clips.push(clip(&mut r, (limits, &mut spent), |frames| {
            sources.get(c).map(|source| keys_of(source, frames))
        })?);
    }
    r.bytes.end()?;
    Ok(clips)
}

/// Encodes clips in place; tracks that equal those of `authored` are stored by reference.
pub fn write_clips_in_place(clips: &ClipsInPlace, authored: &[Clip]) -> Vec<u8> {
    let mut out = Writer::default();
    out.count(clips.travelling.len());
    for (c, travelling) in clips.travelling.iter().enumerate() {
        out.byte(u8::from(travelling.is_some()));
        let Some((clip, path)) = travelling else {
            continue;
        };
        let authored = authored.get(c).filter(|a| a.frames() == clip.frames());
        put(&mut out, clip, authored.map(tracks_of).as_ref());
        out.float(path.rate_hz());
        out.count(path.places().len());
        for place in path.places() {
            out.vector(place.offset);
            out.float(place.yaw_radians);
        }
    }
    out.count(clips.warnings.len());
    clips.warnings.iter().for_each(|w| out.text(w));
    out.0
}

/// Decodes the output of [`write_clips_in_place`] with the same authored clips.
///
/// # Errors
/// [`ReadError::Malformed`] with the byte offset, [`ReadError::LimitExceeded`].
pub fn read_clips_in_place(
    bytes: &[u8],
    authored: &[Clip],
    limits: &Limits,
) -> Result<ClipsInPlace, ReadError> {
    let mut r = Numbers::new(bytes, limits)?;
    let count = r.count(1, "clips")?;
    let mut found = ClipsInPlace::default();
    let mut spent = 0;
    for c in 0..count {
        if r.byte()? == 0 {
            found.travelling.push(None);
            continue;
        }
        let clip = clip(&mut r, (limits, &mut spent), |frames| {
            let authored = authored.get(c).filter(|a| a.frames() == frames);
            authored.map(tracks_of)
        })?;
        let rate_hz = r.float()?;
        let places = r.count(16, "root transforms")?;
        let places = r.groups(places, |[x, y, z, yaw_radians]| RootDelta {
            offset: Vec3::new(x, y, z),
            yaw_radians,
        })?;
        let path = RootTrajectory::new(rate_hz, places).map_err(|e| r.bytes.bad(e.to_string()))?;
        found.travelling.push(Some((clip, path)));
    }
    for _ in 0..r.count(1, "warnings")? {
        found.warnings.push(r.text()?);
    }
    r.bytes.end()?;
    Ok(found)
}

/// Values that tracks may refer to, by target: the keys of a source, or another clip.
struct Known<'a> {
    translations: HashMap<u16, Cow<'a, [Vec3]>>,
    rotations: HashMap<u16, Cow<'a, [Quat]>>,
    scales: HashMap<u16, Cow<'a, [Vec3]>>,
    morphs: HashMap<u16, Cow<'a, [f32]>>,
}

/// The tracks of a clip.
fn tracks_of(clip: &Clip) -> Known<'_> {
    fn all<T: Clone>(tracks: &[Track<T>]) -> HashMap<u16, Cow<'_, [T]>> {
        let mut known = HashMap::new();
        for track in tracks {
            known.insert(track.target, Cow::Borrowed(track.values.as_slice()));
        }
        known
    }
    let tracks = clip.tracks();
    Known {
        translations: all(&tracks.translations),
        rotations: all(&tracks.rotations),
        scales: all(&tracks.scales),
        morphs: all(&tracks.morphs),
    }
}

/// The keys of a source clip, of channels with one key for each frame; rotations in the hemisphere
/// of the one before.
fn keys_of(source: &RawClip, frames: usize) -> Known<'static> {
    let mut known = Known {
        translations: HashMap::new(),
        rotations: HashMap::new(),
        scales: HashMap::new(),
        morphs: HashMap::new(),
    };
    for channel in &source.channels {
        let is_curve = channel.interpolation == Interpolation::CubicSpline;
        let Some(target) = u16::try_from(channel.target).ok().filter(|_| !is_curve) else {
            continue;
        };
        if channel.times_secs.len() != frames {
            continue;
        }
        let vectors = || {
            channel
                .values
                .as_chunks::<3>()
                .0
                .iter()
                .map(|v| Vec3::from_array(*v))
        };
        match channel.property {
            Property::Translation => {
                known.translations.insert(target, vectors().collect());
            }
            Property::Scale => {
                known.scales.insert(target, vectors().collect());
            }
            Property::Rotation => {
                let keys = channel.values.as_chunks::<4>().0.iter();
                let mut before: Option<Quat> = None;
                let aligned = keys.map(|q| {
                    let q = Quat::from_array(*q);
                    let q = before.map_or(q, |before| same_hemisphere(before, q));
                    before = Some(q);
                    q
                });
                known.rotations.insert(target, aligned.collect());
            }
            _ => {}
        }
    }
    known
}

fn put(out: &mut Writer, clip: &Clip, known: Option<&Known<'_>>) {
    out.text(&clip.name);
    out.float(clip.rate_hz());
    out.count(clip.frames());
    out.count(clip.joints());
    out.count(clip.frames_per_key());
    let tracks = clip.tracks();
    let flat = |v: &Vec3| v.to_array();
    put_tracks(
        out,
        &tracks.translations,
        known.map(|k| &k.translations),
        flat,
    );
    put_tracks(out, &tracks.rotations, known.map(|k| &k.rotations), |q| {
        q.to_array()
    });
    put_tracks(out, &tracks.scales, known.map(|k| &k.scales), flat);
    put_tracks(out, &tracks.morphs, known.map(|k| &k.morphs), |w| [*w]);
}

fn put_tracks<T: Copy, const N: usize>(
    out: &mut Writer,
    tracks: &[Track<T>],
    known: Option<&HashMap<u16, Cow<'_, [T]>>>,
    flat: impl Fn(&T) -> [f32; N],
) where
    [T]: ToOwned,
{
    let bits = |t: &T| flat(t).map(f32::to_bits);
    out.count(tracks.len());
    for track in tracks {
        out.count(usize::from(track.target));
        let step = if track.step { STEP } else { 0 };
        let known = known.and_then(|k| k.get(&track.target));
        let is_known = |known: &&Cow<'_, [T]>| {
            known.len() == track.values.len()
                && known.iter().map(bits).eq(track.values.iter().map(bits))
        };
        if known.filter(is_known).is_some() {
            out.byte(REFERENCE | step);
            continue;
        }
        let first = track.values.first().map(bits);
        let is_constant = track.values.iter().all(|v| Some(bits(v)) == first);
        let shown = if is_constant {
            &track.values[..1]
        } else {
            &track.values
        };
        let flags = [(is_constant, CONSTANT), (track.values.len() == 1, SINGLE)];
        let flags = flags
            .iter()
            .filter(|(is_set, _)| *is_set)
            .map(|(_, flag)| flag);
        out.byte(flags.fold(step, |all, flag| all | flag));
        shown.iter().for_each(|v| out.floats(&flat(v)));
    }
}

fn clip<'a>(
    r: &mut Numbers<'_>,
    (limits, spent): (&Limits, &mut u64),
    known: impl FnOnce(usize) -> Option<Known<'a>>,
) -> Result<Clip, ReadError> {
    let name = r.text()?;
    let rate_hz = r.float()?;
    let frames = r.index()?;
    Limits::check("a clip", "frames", frames as u64, limits.frames)?;
    let joints = r.at_most(usize::from(u16::MAX), "a number of joints")?;
    let frames_per_key = r.index()?;
    let known = known(frames);
    let known = known.as_ref();
    let mut shape = Shape {
        frames,
        limits,
        spent,
    };
    let vector = |[x, y, z]: [f32; 3]| Vec3::new(x, y, z);
    let tracks = Tracks {
        translations: shape.tracks(r, known.map(|k| &k.translations), vector)?,
        rotations: shape.tracks(r, known.map(|k| &k.rotations), Quat::from_array)?,
        scales: shape.tracks(r, known.map(|k| &k.scales), vector)?,
        morphs: shape.tracks(r, known.map(|k| &k.morphs), |[w]: [f32; 1]| w)?,
    };
    let clip = Clip::new(name, rate_hz, frames, joints, tracks);
    let clip = clip.map_err(|e| r.bytes.bad(e.to_string()))?;
    Ok(clip.with_frames_per_key(frames_per_key))
}

struct Shape<'a> {
    frames: usize,
    limits: &'a Limits,
    /// Values of all clips so far; constant tracks request memory without supplying bytes.
    spent: &'a mut u64,
}

impl Shape<'_> {
    fn tracks<T: Copy, const N: usize>(
        &mut self,
        r: &mut Numbers<'_>,
        known: Option<&HashMap<u16, Cow<'_, [T]>>>,
        of: impl Fn([f32; N]) -> T + Copy,
    ) -> Result<Vec<Track<T>>, ReadError>
    where
        [T]: ToOwned<Owned = Vec<T>>,
    {
        let count = r.count(2, "tracks")?;
        let mut tracks = Vec::with_capacity(count);
        for _ in 0..count {
            let target = r.at_most(usize::from(u16::MAX), "a target")? as u16;
            let flags = r.byte()?;
            *self.spent += (self.frames * N) as u64;
            let limit = self.limits.elements;
            Limits::check("a track", "values of all clips", *self.spent, limit)?;
            let step = flags & STEP != 0;
            if flags & !STEP == REFERENCE {
                let Some(values) = known.and_then(|k| k.get(&target)) else {
                    let what = "a track refers to values that do not exist";
                    return Err(r.bytes.bad(what).into());
                };
                tracks.push(Track {
                    target,
                    step,
                    values: values.to_vec(),
                });
                continue;
            }
            if flags & !(STEP | CONSTANT | SINGLE) != 0 {
                return Err(r.bytes.bad(format!("flags {flags} of a track")).into());
            }
            let is_one = flags & (CONSTANT | SINGLE) != 0;
            let mut values = r.groups(if is_one { 1 } else { self.frames }, of)?;
            if flags & SINGLE == 0 && is_one {
                values = vec![values[0]; self.frames];
            }
            tracks.push(Track {
                target,
                step,
                values,
            });
        }
        Ok(tracks)
    }
}
