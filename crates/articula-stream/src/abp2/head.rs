//! The head of a stream: what is needed before any access unit.
//!
//! Form: `docs/formats/abp2.md`, part 2.

use super::grouping::{Group, Grouping};
use super::pose_unit::MOST_TIERS;
use super::unit_form::{UnitBytes, UnitFault, UnitForm, VERSION, VERSION_WITHOUT_CHECKSUMS};
use super::wavelet::MOST_FRAMES;
use crate::abp2::face_channels;
use crate::error::StreamError;
use crate::limits::StreamLimits;
use articula_core::{ByteReader, MAX_JOINTS, push_varint};
use crc::{CRC_16_IBM_3740, Crc};
use std::ops::Range;

const MAGIC: [u8; 4] = *b"ABP2";
const MAGIC_OF_FACES: [u8; 4] = *b"AFP2";
const NO_UPDATE: u8 = 4;
const SCALES: u8 = 8;
const MORPHS: u8 = 16;
/// Most morph targets of a stream.
const MOST_MORPHS: usize = 1 << 16;
/// Most bytes of a name.
const MOST_NAME: usize = 1 << 12;
/// Bytes of the magic and the length of the head.
pub(super) const PREFIX: usize = 8;

/// Checksum of what comes before the units of a head.
static CHECKSUM: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

/// The head of a motion stream.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionHead {
    /// Version of the form: 2, or 1, which has no checksums and is not written any more.
    pub version: u8,
    /// Name of the clip.
    pub name: String,
    /// How joints are grouped in the access units.
    pub grouping: Grouping,
    /// Whether the wavelet updates coarse samples by details, so that middle tiers are smaller; without,
    /// the finest tier is.
    pub updates: bool,
    /// Number of tiers, 1 to 8.
    pub tiers: usize,
    /// Greatest error of tier 0 in micrometres of skin; of tier k it is 3^k as much.
    pub tolerance_micrometres: u16,
    /// Frames per second.
    pub rate_hz: f32,
    /// Number of frames, at least 1.
    pub frames: usize,
    /// Number of joints of the rig.
    pub joints: usize,
    /// Number of access units; 0 for a single frame.
    pub access_units: usize,
    /// Hash of the rig, 0 if it is not told: of version 2 the first 8 bytes of BLAKE3, of version 1
    /// FNV-1a.
    pub rig_hash: u64,
    /// Whether joints have scale tracks.
    pub scales: bool,
    /// Labels of the groups of joints.
    pub groups: Vec<Group>,
    /// Labels of the groups of morph targets, numbered after those of joints.
    pub morph_groups: Vec<Group>,
    /// For each morph target of the mesh the index of its group. Of a face stream, for each channel;
    /// those that the stream does not have are in none, `u16::MAX`.
    pub morphs: Vec<u16>,
    /// What only the head of a face stream (AFP-2) has: there, morph targets are the channels of facial
    /// animation parameters.
    pub face: Option<FaceHead>,
}

/// What only the head of a face stream has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FaceHead {
    /// If the parameters were made from blend shapes, the name of the columns by which.
    pub bridge: Option<String>,
}

/// A head with the places of its pose units.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ReadHead {
    pub(super) head: MotionHead,
    pub(super) poses: Vec<PosePlace>,
    /// Where the skeleton is, if it is carried.
    pub(super) skeleton: Option<PosePlace>,
    /// Bytes before the first unit of the head.
    pub(super) fields: usize,
    /// Bytes up to the first access unit.
    pub(super) bytes: usize,
}

/// Where a pose unit or the skeleton is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PosePlace {
    pub(super) number: usize,
    /// All its bytes.
    pub(super) bytes: Range<usize>,
    pub(super) body: Range<usize>,
}

impl MotionHead {
    /// Reads the head of a stream, without decoding anything.
    ///
    /// # Errors
    /// A [`StreamError`] that names the byte, also if the stream ends within the head.
    pub fn open(stream: &[u8], limits: &StreamLimits) -> Result<Self, StreamError> {
        Ok(Self::open_read(stream, limits)?.head)
    }

    /// As [`Self::open`], with the places of what is in the head.
    pub(super) fn open_read(stream: &[u8], limits: &StreamLimits) -> Result<ReadHead, StreamError> {
        let at = format!("byte {}", stream.len());
        let early = || StreamError::malformed(at, "the stream ends within its head");
        Self::read(stream, limits)?.ok_or_else(early)
    }

    /// Returns the error in metres of skin that a tier allows, of the finest of those kept.
    pub fn tolerance_metres(&self, tier: usize) -> f64 {
        f64::from(self.tolerance_micrometres) * 1e-6 * 3_f64.powi(tier as i32)
    }

    /// Returns the frames of an access unit.
    pub fn frames_of(&self, access_unit: usize) -> Range<usize> {
        let start =
            |i: usize| (i as u64 * self.frames as u64 / self.access_units.max(1) as u64) as usize;
        start(access_unit)..start(access_unit + 1)
    }

    /// Numbers of the access units with some of the frames.
    pub(super) fn access_units_of(&self, frames: Range<usize>) -> Range<usize> {
        let count = self.access_units as u64;
        let of = |frame: usize| ((frame as u64 + 1) * count - 1) / self.frames as u64;
        match frames.is_empty() || count == 0 {
            true => 0..0,
            false => of(frames.start) as usize..of(frames.end - 1) as usize + 1,
        }
    }

    /// Number of groups of units, of joints and of morph targets.
    pub(super) fn group_count(&self) -> usize {
        self.groups.len() + self.morph_groups.len()
    }

    /// Labels of a group by its number.
    pub(super) fn group(&self, number: usize) -> &Group {
        let of_morphs = number.wrapping_sub(self.groups.len());
        self.morph_groups
            .get(of_morphs)
            .unwrap_or_else(|| &self.groups[number])
    }

    /// The levels of articulation of the pose units of joints, rising.
    pub(super) fn pose_levels(&self) -> Vec<u8> {
        let mut levels: Vec<u8> = self.groups.iter().map(|group| group.loa).collect();
        levels.sort_unstable();
        levels.dedup();
        levels
    }

    /// Number of pose units that there can be; that of the skeleton comes after theirs.
    pub(super) fn pose_count(&self) -> usize {
        self.pose_levels().len() + self.morph_groups.len()
    }

    /// Form of the units in the head; version 1 has no skeleton.
    pub(super) fn form(&self) -> UnitForm {
        let skeletons = usize::from(self.version != VERSION_WITHOUT_CHECKSUMS);
        UnitForm {
            version: self.version,
            count: self.pose_count() + skeletons,
            place: 0,
        }
    }

    /// Form of the units of an access unit.
    pub(super) fn unit_form(&self, access_unit: usize) -> UnitForm {
        UnitForm {
            version: self.version,
            count: self.group_count() * self.tiers,
            place: access_unit as u32 + 1,
        }
    }

    /// Number of the unit of a group at a tier.
    pub(super) fn unit_number(&self, group: usize, tier: usize) -> usize {
        group * self.tiers + self.tiers - 1 - tier
    }

    /// Group and tier of a unit by its number.
    pub(super) fn group_and_tier(&self, number: usize) -> (usize, usize) {
        (number / self.tiers, self.tiers - 1 - number % self.tiers)
    }

    /// Writes the head with its pose units and, if it is carried, the skeleton.
    pub(super) fn write(&self, poses: &[(usize, Vec<u8>)], skeleton: Option<&[u8]>) -> Vec<u8> {
        let magic = if self.face.is_some() {
            MAGIC_OF_FACES
        } else {
            MAGIC
        };
        let mut out = magic.to_vec();
        out.extend([0; 4]);
        out.push(VERSION);
        let flag = |is_set: bool, flag: u8| if is_set { flag } else { 0 };
        let has_morphs = !self.morphs.is_empty();
        out.push(
            self.grouping as u8
                | flag(!self.updates, NO_UPDATE)
                | flag(self.scales, SCALES)
                | flag(has_morphs, MORPHS),
        );
        out.push(self.tiers as u8);
        out.extend(self.tolerance_micrometres.to_be_bytes());
        out.extend(self.rate_hz.to_be_bytes());
        for number in [self.frames, self.joints, self.access_units] {
            push_varint(&mut out, number as u64);
        }
        out.extend(self.rig_hash.to_be_bytes());
        let bridge = |face: &FaceHead| face.bridge.clone().unwrap_or_default();
        for text in std::iter::once(self.name.clone()).chain(self.face.as_ref().map(bridge)) {
            push_varint(&mut out, text.len() as u64);
            out.extend(text.as_bytes());
        }
        push_varint(&mut out, self.groups.len() as u64);
        for group in &self.groups {
            out.extend([group.loa, group.region]);
            if let Some(joint) = group.joint {
                push_varint(&mut out, u64::from(joint));
            }
        }
        if has_morphs {
            push_varint(&mut out, self.morph_groups.len() as u64);
            for group in &self.morph_groups {
                out.extend([group.loa, group.region]);
            }
            // The channels of a face are in groups by their labels.
            let of_mesh = if self.face.is_none() {
                &self.morphs[..]
            } else {
                &[]
            };
            if !of_mesh.is_empty() {
                push_varint(&mut out, of_mesh.len() as u64);
            }
            for group in of_mesh {
                push_varint(&mut out, u64::from(*group));
            }
        }
        out.extend(checksum(&out).to_be_bytes());
        let form = self.form();
        for (number, body) in poses {
            form.write(&mut out, *number, body);
        }
        if let Some(body) = skeleton {
            form.write(&mut out, self.pose_count(), body);
        }
        let length = (out.len() - PREFIX) as u32;
        out[4..PREFIX].copy_from_slice(&length.to_be_bytes());
        out
    }

    /// Reads a head; `None` if the bytes end within it.
    pub(super) fn read(
        bytes: &[u8],
        limits: &StreamLimits,
    ) -> Result<Option<ReadHead>, StreamError> {
        let end = Self::end(bytes, limits)?;
        let Some(head) = end.and_then(|end| bytes.get(..end)) else {
            return Ok(None);
        };
        let mut read = Self::read_fields(head, limits)?;
        let mut reader = ByteReader::new(head);
        reader.slice(read.fields)?;
        while reader.left() > 0 {
            let form = read.head.form();
            let unit = form.read(&mut reader).map_err(UnitFault::of_whole)?;
            let at = format!("byte {}", unit.bytes.start);
            let number = unit.number;
            if !read.put(PosePlace::of(unit)) {
                let what = format!("unit {number} of the head occurs twice");
                return Err(StreamError::malformed(at, what));
            }
        }
        Ok(Some(read))
    }

    /// Returns where the head ends; `None` if too few bytes are there to tell.
    pub(super) fn end(bytes: &[u8], limits: &StreamLimits) -> Result<Option<usize>, StreamError> {
        let known = bytes.len().min(4);
        let is_face = bytes[..known] == MAGIC_OF_FACES[..known];
        if !is_face && bytes[..known] != MAGIC[..known] {
            return Err(StreamError::malformed(
                "byte 0",
                "expected a motion stream, ABP2, or a face stream, AFP2",
            ));
        }
        let Some(length) = bytes.get(4..PREFIX) else {
            return Ok(None);
        };
        let length = u32::from_be_bytes([length[0], length[1], length[2], length[3]]);
        StreamLimits::check(
            "byte 4",
            "bytes of the head",
            u64::from(length),
            limits.bytes,
        )?;
        Ok(Some(PREFIX + length as usize))
    }

    /// Reads what is in a head before its units, which need not be there.
    pub(super) fn read_fields(
        bytes: &[u8],
        limits: &StreamLimits,
    ) -> Result<ReadHead, StreamError> {
        let early = "the bytes end within the length of the head";
        let end =
            Self::end(bytes, limits)?.ok_or_else(|| StreamError::malformed("byte 4", early))?;
        let is_face = bytes.starts_with(&MAGIC_OF_FACES);
        let bytes = &bytes[..end.min(bytes.len())];
        let mut reader = ByteReader::new(bytes);
        reader.slice(PREFIX)?;
        let mut fields = Fields {
            bytes,
            reader,
            limits,
        };
        let (head, has_morphs) = fields.fixed(is_face)?;
        let mut head = fields.groups(head)?;
        if has_morphs {
            fields.morphs(&mut head)?;
        }
        fields.check(&head)?;
        Ok(ReadHead {
            head,
            poses: Vec::new(),
            skeleton: None,
            fields: fields.reader.at(),
            bytes: end,
        })
    }
}

impl ReadHead {
    /// Adds a unit of the head; false if there is one of its number.
    pub(super) fn put(&mut self, unit: PosePlace) -> bool {
        if self.place(unit.number).is_some() {
            return false;
        }
        if unit.number == self.head.pose_count() {
            self.skeleton = Some(unit);
        } else {
            self.poses.push(unit);
        }
        true
    }

    /// The unit of a number, if it is there.
    pub(super) fn place(&self, number: usize) -> Option<&PosePlace> {
        let mut all = self.poses.iter().chain(&self.skeleton);
        all.find(|unit| unit.number == number)
    }
}

impl PosePlace {
    fn of(unit: UnitBytes) -> Self {
        Self {
            number: unit.number,
            bytes: unit.bytes,
            body: unit.body,
        }
    }
}

/// The checksum of the fields of a head, which its length is not among: a cut changes it.
fn checksum(fields: &[u8]) -> u16 {
    let mut digest = CHECKSUM.digest();
    digest.update(&fields[..MAGIC.len()]);
    digest.update(&fields[PREFIX..]);
    digest.finalize()
}

struct Fields<'a> {
    bytes: &'a [u8],
    reader: ByteReader<'a>,
    limits: &'a StreamLimits,
}

impl Fields<'_> {
    fn bad(&self, what: impl Into<String>) -> StreamError {
        self.reader.bad(what).into()
    }

    fn number(&mut self, what: &str, least: usize, most: usize) -> Result<usize, StreamError> {
        let found = self.reader.varint()?;
        match usize::try_from(found) {
            Ok(found) if (least..=most).contains(&found) => Ok(found),
            _ => Err(self.bad(format!("{found} {what}, expected {least} to {most}"))),
        }
    }

    /// The fields before the groups, and whether there are morph targets.
    fn fixed(&mut self, is_face: bool) -> Result<(MotionHead, bool), StreamError> {
        let [version] = self.reader.take()?;
        if version != VERSION && version != VERSION_WITHOUT_CHECKSUMS {
            return Err(StreamError::Unsupported {
                at: format!("byte {PREFIX}"),
                what: format!("version {version}"),
                mend: format!("expected version {VERSION_WITHOUT_CHECKSUMS} or {VERSION}"),
            });
        }
        let [flags] = self.reader.take()?;
        let grouping = Grouping::ALL.get(usize::from(flags & 3)).copied();
        let grouping = grouping.filter(|_| flags < 2 * MORPHS);
        let grouping = grouping.ok_or_else(|| self.bad(format!("unknown flags {flags:#x}")))?;
        let [tiers] = self.reader.take()?;
        if !(1..=MOST_TIERS).contains(&usize::from(tiers)) {
            return Err(self.bad(format!("{tiers} tiers, expected 1 to {MOST_TIERS}")));
        }
        let tolerance_micrometres = u16::from_be_bytes(self.reader.take()?);
        let rate_hz = f32::from_be_bytes(self.reader.take()?);
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(self.bad(format!("{rate_hz} frames a second, expected more than 0")));
        }
        let most = usize::try_from(self.limits.elements).unwrap_or(usize::MAX);
        let frames = self.number("frames", 1, most)?;
        let joints = self.number("joints", 1, MAX_JOINTS)?;
        // An access unit has at least two frames.
        let access_units = self.number("access units", usize::from(frames > 1), frames / 2)?;
        let rig_hash = u64::from_be_bytes(self.reader.take()?);
        let name = self.text()?;
        let face = if is_face {
            let bridge = Some(self.text()?).filter(|text| !text.is_empty());
            Some(FaceHead { bridge })
        } else {
            None
        };
        let head = MotionHead {
            version,
            name,
            grouping,
            updates: flags & NO_UPDATE == 0,
            tiers: usize::from(tiers),
            tolerance_micrometres,
            rate_hz,
            frames,
            joints,
            access_units,
            rig_hash,
            scales: flags & SCALES != 0,
            groups: Vec::new(),
            morph_groups: Vec::new(),
            morphs: Vec::new(),
            face,
        };
        if access_units > 0 && frames.div_ceil(access_units) > MOST_FRAMES {
            return Err(self.bad(format!("{frames} frames in {access_units} access units")));
        }
        Ok((head, flags & MORPHS != 0))
    }

    fn text(&mut self) -> Result<String, StreamError> {
        let length = self.number("bytes of a name", 0, MOST_NAME)?;
        let text = std::str::from_utf8(self.reader.slice(length)?).map(str::to_owned);
        text.map_err(|_| self.bad("expected a name in UTF-8"))
    }

    fn groups(&mut self, mut head: MotionHead) -> Result<MotionHead, StreamError> {
        let count = self.number("groups", 1, head.joints)?;
        for _ in 0..count {
            let [loa, region] = self.reader.take()?;
            let joint = match head.grouping {
                Grouping::Joint => Some(self.number("as a joint", 0, head.joints - 1)? as u16),
                _ => None,
            };
            head.groups.push(Group { loa, region, joint });
        }
        Ok(head)
    }

    fn morphs(&mut self, head: &mut MotionHead) -> Result<(), StreamError> {
        let count = self.number("groups of morph targets", 1, MOST_MORPHS)?;
        for _ in 0..count {
            let [loa, region] = self.reader.take()?;
            head.morph_groups.push(Group {
                loa,
                region,
                joint: None,
            });
        }
        if head.face.is_some() {
            if !head.morph_groups.is_sorted_by(|a, b| a < b) {
                return Err(self.bad("groups that do not rise by level, then region"));
            }
            head.morphs = face_channels::groups_of(&head.morph_groups);
            return Ok(());
        }
        let targets = self.number("morph targets", 1, MOST_MORPHS)?;
        for _ in 0..targets {
            let group = self.number("as a group", 0, count - 1)?;
            head.morphs.push(group as u16);
        }
        Ok(())
    }

    /// Reads the checksum of the fields so far, which version 1 does not have.
    fn check(&mut self, head: &MotionHead) -> Result<(), StreamError> {
        if head.version == VERSION_WITHOUT_CHECKSUMS {
            return Ok(());
        }
        let end = self.reader.at();
        let expected = checksum(&self.bytes[..end]);
        let found = u16::from_be_bytes(self.reader.take()?);
        if found == expected {
            return Ok(());
        }
        let what = format!("the checksum of the head is {found:#06x}, expected {expected:#06x}");
        Err(StreamError::malformed(format!("byte {end}"), what))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn access_units_of_frames_are_those_that_have_some_of_them() {
        for (frames, access_units) in [(41, 2), (41, 41), (7, 3), (100, 9), (1, 0)] {
            let head = MotionHead {
                frames,
                access_units,
                ..head()
            };
            for (start, end) in
                (0..frames).flat_map(|start| (start..=frames).map(move |e| (start, e)))
            {
                let shares = |i: &usize| {
                    let of = head.frames_of(*i);
                    of.start.max(start) < of.end.min(end)
                };
                let expected: Vec<usize> = (0..access_units).filter(shares).collect();
                let found: Vec<usize> = head.access_units_of(start..end).collect();
                assert_eq!(found, expected, "{start}..{end} of {frames}");
            }
        }
    }

    fn head() -> MotionHead {
        let group = |loa, region| Group {
            loa,
            region,
            joint: None,
        };
        MotionHead {
            version: VERSION,
            name: "wave".into(),
            grouping: Grouping::LoaRegion,
            updates: true,
            tiers: 5,
            tolerance_micrometres: 100,
            rate_hz: 119.88,
            frames: 41,
            joints: 67,
            access_units: 2,
            rig_hash: 0x0123_4567_89ab_cdef,
            scales: true,
            groups: vec![group(0, 4), group(1, 2), group(1, 5)],
            morph_groups: vec![group(2, 1)],
            morphs: vec![0, 0, 0],
            face: None,
        }
    }

    #[test]
    fn a_head_comes_back() {
        let head = head();
        let poses = [(0, vec![1, 2, 3]), (2, vec![]), (1, vec![9])];
        let skeleton = [7; 300];
        let bytes = head.write(&poses, Some(&skeleton));
        let read = MotionHead::read(&bytes, &StreamLimits::default())
            .unwrap()
            .unwrap();
        assert_eq!((&read.head, read.bytes), (&head, bytes.len()));
        assert_eq!(bytes[read.skeleton.unwrap().body], skeleton);
        for ((number, body), place) in poses.iter().zip(&read.poses) {
            assert_eq!(
                (number, &body[..]),
                (&place.number, &bytes[place.body.clone()])
            );
            assert_eq!(place.bytes.len(), place.body.len() + 2);
        }
        assert_eq!((head.frames_of(0), head.frames_of(1)), (0..20, 20..41));
        for length in 0..bytes.len() {
            let part = MotionHead::read(&bytes[..length], &StreamLimits::default());
            assert_eq!(part, Ok(None), "{length} bytes");
        }
    }

    #[test]
    fn the_checksum_is_the_one_of_the_catalogue() {
        // The check values of the CRC catalogue (reveng) are those of these nine characters.
        assert_eq!(CHECKSUM.checksum(b"123456789"), 0x29b1);
        // The length of the head, the four bytes after the magic, is left out.
        assert_eq!(checksum(b"1234....56789"), 0x29b1);
    }

    #[test]
    fn what_is_wrong_is_refused() {
        let good = head().write(&[(0, vec![1])], None);
        let refused = |at: usize, value: u8| {
            let mut bytes = good.clone();
            bytes[at] = value;
            let read = MotionHead::read(&bytes, &StreamLimits::default());
            read.unwrap_err().to_string()
        };
        assert!(refused(0, b'X').contains("ABP2"));
        assert!(refused(8, 3).contains("version 3"));
        // Version 1 has no checksums, so that they are taken for what comes next.
        assert!(refused(8, 1).contains("unit"));
        assert!(refused(9, 0x23).contains("flags"));
        assert!(refused(10, 0).contains("0 tiers"));
        assert!(refused(10, 9).contains("9 tiers"));
        assert!(refused(13, 0xff).contains("frames a second"));
        assert!(refused(17, 0).contains("0 frames"));
        assert!(refused(18, 0).contains("0 joints"));
        assert!(refused(19, 40).contains("40 access units"));
        let last = good.len() - 1;
        // In the hash of the rig; the one unit has three bytes, after the two of the checksum.
        let of_head = format!("byte {}: the checksum of the head", last - 4);
        assert!(refused(24, 0x10).contains(&of_head));
        let of_unit = format!("byte {}: the checksum of unit 0", last - 2);
        assert!(refused(last, good[last] ^ 1).contains(&of_unit));
        assert!(refused(last - 1, 7).contains(&of_unit));
        let small = StreamLimits {
            elements: 40,
            ..StreamLimits::default()
        };
        assert!(MotionHead::read(&good, &small).is_err());
    }
}
