//! The parts `clips` and `clipsInPlace`: clips at a uniform rate, and those whose root motion was
//! removed.

use super::numbers::{Numbers, Writer};
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::crowd::{RootDelta, RootTrajectory};
use articula_core::{Clip, Track, Tracks};
use glam::{Quat, Vec3};

/// The values of the track hold until the next frame.
const STEP: u8 = 1;
/// The track has one value for all frames.
const CONSTANT: u8 = 2;
/// The track equals that of the authored clip, and no values follow.
const AS_AUTHORED: u8 = 4;

/// Clips of a character whose travelling clips were put in place.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ClipsInPlace {
    /// For each clip that travels, the clip in place and its root motion.
    pub travelling: Vec<Option<(Clip, RootTrajectory)>>,
    /// Warnings about clips that travel but could not be put in place.
    pub warnings: Vec<String>,
}

/// Encodes clips.
pub fn write_clips(clips: &[Clip]) -> Vec<u8> {
    let mut out = Writer::default();
    out.count(clips.len());
    clips.iter().for_each(|clip| put(&mut out, clip, None));
    out.0
}

/// Decodes the output of [`write_clips`].
///
/// # Errors
/// [`ReadError::Malformed`] with the byte offset, [`ReadError::LimitExceeded`].
pub fn read_clips(bytes: &[u8], limits: &Limits) -> Result<Vec<Clip>, ReadError> {
    let mut r = Numbers::new(bytes, limits)?;
    let count = r.count(1, "clips")?;
    let mut clips = Vec::with_capacity(count);
    for _ in 0..count {
        clips.push(clip(&mut r, None, limits)?);
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
        put(&mut out, clip, authored.get(c));
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
    for c in 0..count {
        if r.byte()? == 0 {
            found.travelling.push(None);
            continue;
        }
        let clip = clip(&mut r, authored.get(c), limits)?;
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

fn put(out: &mut Writer, clip: &Clip, authored: Option<&Clip>) {
    out.text(&clip.name);
    out.float(clip.rate_hz());
    out.count(clip.frames());
    out.count(clip.joints());
    out.count(clip.frames_per_key());
    let tracks = clip.tracks();
    let authored = authored
        .filter(|a| a.frames() == clip.frames())
        .map(Clip::tracks);
    let flat = |v: &Vec3| v.to_array();
    put_tracks(
        out,
        &tracks.translations,
        authored.map(|a| &a.translations),
        flat,
    );
    put_tracks(
        out,
        &tracks.rotations,
        authored.map(|a| &a.rotations),
        |q| q.to_array(),
    );
    put_tracks(out, &tracks.scales, authored.map(|a| &a.scales), flat);
    put_tracks(out, &tracks.morphs, authored.map(|a| &a.morphs), |w| [*w]);
}

fn put_tracks<T: Copy, const N: usize>(
    out: &mut Writer,
    tracks: &[Track<T>],
    authored: Option<&Vec<Track<T>>>,
    flat: impl Fn(&T) -> [f32; N],
) {
    let bits = |t: &T| flat(t).map(f32::to_bits);
    let is_same = |a: &Track<T>, b: &Track<T>| {
        (a.target, a.step, a.values.len()) == (b.target, b.step, b.values.len())
            && a.values.iter().map(bits).eq(b.values.iter().map(bits))
    };
    out.count(tracks.len());
    for (t, track) in tracks.iter().enumerate() {
        out.count(usize::from(track.target));
        if authored
            .and_then(|a| a.get(t))
            .is_some_and(|a| is_same(a, track))
        {
            out.byte(AS_AUTHORED);
            continue;
        }
        let first = track.values.first().map(bits);
        let is_constant = track.values.iter().all(|v| Some(bits(v)) == first);
        let shown = if is_constant {
            &track.values[..1]
        } else {
            &track.values
        };
        let single = track.values.len() == 1;
        out.byte(
            if track.step { STEP } else { 0 }
                | if is_constant { CONSTANT } else { 0 }
                | if single { SINGLE } else { 0 },
        );
        shown.iter().for_each(|v| out.floats(&flat(v)));
    }
}

/// The track in memory has one value, as opposed to one for each frame.
const SINGLE: u8 = 8;

fn clip(r: &mut Numbers<'_>, authored: Option<&Clip>, limits: &Limits) -> Result<Clip, ReadError> {
    let name = r.text()?;
    let rate_hz = r.float()?;
    let frames = r.index()?;
    Limits::check("a clip", "frames", frames as u64, limits.frames)?;
    let joints = r.at_most(usize::from(u16::MAX), "a number of joints")?;
    let frames_per_key = r.index()?;
    let authored = authored.filter(|a| a.frames() == frames).map(Clip::tracks);
    let mut spent = 0;
    let mut shape = Shape {
        frames,
        limits,
        spent: &mut spent,
    };
    let vector = |[x, y, z]: [f32; 3]| Vec3::new(x, y, z);
    let tracks = Tracks {
        translations: shape.tracks(r, authored.map(|a| &a.translations), vector)?,
        rotations: shape.tracks(r, authored.map(|a| &a.rotations), Quat::from_array)?,
        scales: shape.tracks(r, authored.map(|a| &a.scales), vector)?,
        morphs: shape.tracks(r, authored.map(|a| &a.morphs), |[w]: [f32; 1]| w)?,
    };
    let clip = Clip::new(name, rate_hz, frames, joints, tracks);
    let clip = clip.map_err(|e| r.bytes.bad(e.to_string()))?;
    Ok(clip.with_frames_per_key(frames_per_key))
}

struct Shape<'a> {
    frames: usize,
    limits: &'a Limits,
    /// Values so far; constant tracks request memory without supplying bytes.
    spent: &'a mut u64,
}

impl Shape<'_> {
    fn tracks<T: Copy, const N: usize>(
        &mut self,
        r: &mut Numbers<'_>,
        authored: Option<&Vec<Track<T>>>,
        of: impl Fn([f32; N]) -> T + Copy,
    ) -> Result<Vec<Track<T>>, ReadError> {
        let count = r.count(2, "tracks")?;
        let mut tracks = Vec::with_capacity(count);
        for t in 0..count {
            let target = r.at_most(usize::from(u16::MAX), "a target")? as u16;
            let flags = r.byte()?;
            *self.spent += (self.frames * N) as u64;
            Limits::check(
                "a track",
                "values of a clip",
                *self.spent,
                self.limits.elements,
            )?;
            if flags == AS_AUTHORED {
                let track = authored
                    .and_then(|a| a.get(t))
                    .filter(|a| a.target == target);
                let Some(track) = track else {
                    let what = "a track refers to one that the authored clip does not have";
                    return Err(r.bytes.bad(what).into());
                };
                tracks.push(track.clone());
                continue;
            }
            if flags & !(STEP | CONSTANT | SINGLE) != 0 {
                return Err(r.bytes.bad(format!("flags {flags} of a track")).into());
            }
            let stored = if flags & (CONSTANT | SINGLE) != 0 {
                1
            } else {
                self.frames
            };
            let mut values = r.groups(stored, of)?;
            if flags & SINGLE == 0 && stored == 1 {
                values = vec![values[0]; self.frames];
            }
            tracks.push(Track {
                target,
                step: flags & STEP != 0,
                values,
            });
        }
        Ok(tracks)
    }
}
