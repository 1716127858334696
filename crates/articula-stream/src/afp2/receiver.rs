//! Client side of a face stream: bytes as they arrive, frames that refine.

use super::points;
use crate::abp2::face_channels::{faps_of, field_of, weight_of_unit};
use crate::abp2::{MotionHead, MotionReceiver};
use crate::error::StreamError;
use crate::face::fade::Fade;
use crate::face::levels::levels_of;
use crate::face::{DecodedFace, FaceClip, FaceFrame, FaceReadOptions};
use crate::frame_rate::FrameRate;
use crate::limits::StreamLimits;
use articula_core::Track;
use articula_core::face_levels::FapRoles;
use articula_core::fap_table::FAP_COUNT;
use std::ops::Range;

/// Receives a face stream and decodes what is there: whole, in pieces of any length
/// ([`Self::receive`]), or its units in any order ([`Self::receive_at`], [`Self::receive_units`]), as a
/// [`MotionReceiver`] does.
///
/// A group without units in an access unit is not there: its parameters copy others or are
/// neutral at the level that is left of their region. While an access unit is arriving by
/// [`Self::receive`], groups that are not there yet hold the frame before it. Access units that are not
/// there hold the frame before them; before the first, the face is neutral.
#[derive(Debug, Clone)]
pub struct FaceReceiver {
    motion: MotionReceiver,
    options: FaceReadOptions,
    limits: StreamLimits,
}

/// Reads a stream, or a prefix of one; it may have been cut in any way.
///
/// # Errors
/// As [`FaceReceiver::receive`] and [`FaceReceiver::decoded`].
pub fn read(
    bytes: &[u8],
    options: &FaceReadOptions,
    limits: &StreamLimits,
) -> Result<DecodedFace, StreamError> {
    let mut receiver = FaceReceiver::new(options, limits)?;
    receiver.receive(bytes)?;
    receiver.decoded()
}

impl FaceReceiver {
    /// Creates a receiver.
    ///
    /// # Errors
    /// None is known.
    pub fn new(options: &FaceReadOptions, limits: &StreamLimits) -> Result<Self, StreamError> {
        Ok(Self {
            motion: MotionReceiver::of_face(&points::rig()?, limits),
            options: *options,
            limits: *limits,
        })
    }

    /// Takes the next bytes of the stream, decodes the units that they complete, and returns the
    /// frames that changed.
    ///
    /// # Errors
    /// A [`StreamError`] that names the byte: malformed bytes, a head or unit that was damaged, more
    /// than the limits allow. The receiver stays as it was.
    pub fn receive(&mut self, more: &[u8]) -> Result<Range<usize>, StreamError> {
        let changed = self.motion.receive(more)?;
        self.faded(changed)
    }

    /// Takes bytes of the stream from byte `offset` on, as [`MotionReceiver::receive_at`] does, and
    /// returns the frames that changed.
    ///
    /// # Errors
    /// As there.
    pub fn receive_at(&mut self, offset: u64, bytes: &[u8]) -> Result<Range<usize>, StreamError> {
        let changed = self.motion.receive_at(offset, bytes)?;
        self.faded(changed)
    }

    /// Takes whole units of an access unit, as [`MotionReceiver::receive_units`] does, and returns the
    /// frames that changed.
    ///
    /// # Errors
    /// As there.
    pub fn receive_units(
        &mut self,
        access_unit: usize,
        units: &[u8],
    ) -> Result<Range<usize>, StreamError> {
        let changed = self.motion.receive_units(access_unit, units)?;
        self.faded(changed)
    }

    /// Frames that change because some do: access units after them may fade from what they show.
    fn faded(&self, changed: Range<usize>) -> Result<Range<usize>, StreamError> {
        let Some(head) = self.motion.head() else {
            return Ok(changed);
        };
        let elements = (head.frames * FAP_COUNT) as u64;
        StreamLimits::check("the head", "elements", elements, self.limits.elements)?;
        let rate = FrameRate::nearest(f64::from(head.rate_hz));
        let fade = rate.map_or(0, |rate| self.options.fade_frames(rate));
        let mut end = changed.end;
        if !changed.is_empty() {
            let before = changed.end as u64 * head.access_units as u64;
            let after = before.div_ceil(head.frames as u64) as usize..head.access_units;
            let mut starts = after.map(|number| head.frames_of(number).start);
            while let Some(start) = starts.next().filter(|start| *start <= end) {
                end = end.max((start + fade).min(head.frames));
            }
        }
        Ok(changed.start..end)
    }

    /// Returns the head, if it has arrived.
    pub fn head(&self) -> Option<&MotionHead> {
        self.motion.head()
    }

    /// Returns the number of frames that can be shown, from the first: those before the first access
    /// unit that is not there.
    pub fn frames(&self) -> usize {
        self.motion.frames()
    }

    /// Returns whether every access unit is there, and none is still arriving in the order of the bytes.
    pub fn is_whole(&self) -> bool {
        self.motion.is_whole()
    }

    /// Returns the frames up to the last access unit that is there.
    ///
    /// # Errors
    /// A [`StreamError`] if the head has not arrived, has a rate that no face has, or a field of FAP 1
    /// or 2 is out of its range.
    pub fn decoded(&self) -> Result<DecodedFace, StreamError> {
        let motion = self.motion.clip()?;
        let Some((head, face)) = self.motion.head().and_then(|h| Some((h, h.face.as_ref()?)))
        else {
            return Err(StreamError::malformed("byte 0", "the head has not arrived"));
        };
        let rate = FrameRate::nearest(f64::from(head.rate_hz)).ok_or_else(|| {
            StreamError::malformed("the head", format!("a frame rate of {}", head.rate_hz))
        })?;
        let mut decoding = Decoding {
            head,
            tracks: &motion.tracks().morphs,
            fade: Fade::new(self.options.fade_frames(rate)),
            coded: [false; FAP_COUNT],
            frames: Vec::with_capacity(self.motion.frames()),
        };
        if head.access_units == 0 {
            // The pose of the head alone.
            decoding.add(&faps_of(&head.morph_groups), 0..head.frames)?;
        }
        let mut before = [false; FAP_COUNT];
        for access_unit in self.motion.access_units() {
            let gap = decoding.frames.len()..access_unit.frames.start;
            if !gap.is_empty() {
                decoding.add(&before, gap)?;
            }
            let mut is_there = faps_in(&access_unit.groups, head);
            if access_unit.is_arriving {
                for (is_there, before) in is_there.iter_mut().zip(before) {
                    *is_there |= before;
                }
            }
            decoding.add(&is_there, access_unit.frames.clone())?;
            before = is_there;
        }
        Ok(DecodedFace {
            clip: FaceClip {
                name: head.name.clone(),
                bridge: face.bridge.clone(),
                rate,
                frames: decoding.frames,
            },
            coded: decoding.coded,
        })
    }
}

/// The FAPs (index 0 is FAP 1) of some groups.
fn faps_in(groups: &[usize], head: &MotionHead) -> [bool; FAP_COUNT] {
    let of_morphs = groups
        .iter()
        .filter_map(|group| group.checked_sub(head.groups.len()));
    let groups: Vec<_> = of_morphs.map(|at| head.morph_groups[at]).collect();
    faps_of(&groups)
}

/// Frames of a face from the weights of its channels.
struct Decoding<'a> {
    head: &'a MotionHead,
    tracks: &'a [Track<f32>],
    fade: Fade,
    coded: [bool; FAP_COUNT],
    frames: Vec<FaceFrame>,
}

impl Decoding<'_> {
    /// Adds frames in which some FAPs (index 0 is FAP 1) are there.
    fn add(
        &mut self,
        is_there: &[bool; FAP_COUNT],
        range: Range<usize>,
    ) -> Result<(), StreamError> {
        for (coded, there) in self.coded.iter_mut().zip(is_there) {
            *coded |= there;
        }
        let roles = levels_of(is_there).roles();
        self.fade.access_unit(&roles, is_there);
        for frame in range {
            let shown = self.frame(frame, is_there, &roles)?;
            self.frames.push(shown);
        }
        Ok(())
    }

    fn frame(
        &mut self,
        frame: usize,
        is_there: &[bool; FAP_COUNT],
        roles: &FapRoles,
    ) -> Result<FaceFrame, StreamError> {
        let mut shown = FaceFrame::NEUTRAL;
        for track in self.tracks {
            let (fap, field) = field_of(usize::from(track.target));
            if !is_there[fap - 1] {
                continue;
            }
            let at = if track.values.len() == self.head.frames {
                frame
            } else {
                0
            };
            let value = (track.values[at] / weight_of_unit(fap)).round() as i32;
            shown.set_field(fap, field, value).ok_or_else(|| {
                let what = format!("a field of FAP {fap} is {value}");
                StreamError::malformed(format!("frame {frame}"), what)
            })?;
        }
        roles.expand(&mut shown.low);
        self.fade.frame(&mut shown.low);
        Ok(shown)
    }
}
