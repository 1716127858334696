//! Contents of a motion stream, without its character, or of a face stream.

use super::{TrackInspection, WarningInspection};
use crate::clip_streams::{AccessUnitCount, region_name};
use crate::error::{Context, Result};
use articula_stream::abp2::{Grouping, MotionHead, prefix_map};
use articula_stream::{CutRule, StreamLimits, Unit, cut};
use serde::Serialize;

/// Contents of a motion stream (ABP-2) or a face stream (AFP-2).
#[derive(Debug, Serialize)]
pub struct MotionStreamInspection {
    /// Name of the file, as in errors.
    pub file: String,
    /// Name of the format, which is also the file extension.
    pub format: &'static str,
    /// Name of the profile.
    pub profile: &'static str,
    /// Size of the file in bytes.
    pub bytes: usize,
    /// Size of the head in bytes, at the start of the file.
    pub bytes_head: usize,
    /// Name of the clip.
    pub clip: String,
    /// Number of frames.
    pub frames: usize,
    /// Frames per second.
    pub fps: f32,
    /// Duration in seconds.
    pub duration_secs: f32,
    /// Number of joints of the character; 1 for a face stream, which moves none.
    pub joints: usize,
    /// Number of its morph targets, if any is coded; of a face stream, of fields of parameters.
    pub morph_targets: usize,
    /// Hash of the character's joints, as hexadecimal digits; all 0 if it is not stated.
    pub rig_hash: String,
    /// What joints of a group have in common: `loa`, `region` or `joint`.
    pub group_by: &'static str,
    /// Whether the stream carries the skeleton.
    pub skeleton: bool,
    /// How many of its access units are there. Bytes of tiers and groups are of those that are whole.
    pub access_units: AccessUnitCount,
    /// The tiers, finest first.
    pub tiers: Vec<StreamTier>,
    /// The groups that have units.
    pub groups: Vec<StreamGroup>,
    /// Tracks of the MP4 file that the stream is in; left out if it is in none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tracks: Vec<TrackInspection>,
    /// Warnings about that file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<WarningInspection>,
}

/// A tier of a motion stream or face stream.
#[derive(Debug, Serialize)]
pub struct StreamTier {
    /// Number of the tier; 0 is the finest.
    pub tier: usize,
    /// Greatest error of a stream that is cut to it, in millimetres of skin, or of feature points of an
    /// average face.
    pub tolerance_mm: f64,
    /// Size of the stream that is cut to it, in bytes.
    pub bytes: usize,
}

/// A group of joints, morph targets or parameters.
#[derive(Debug, Serialize)]
pub struct StreamGroup {
    /// Whether it is a group of morph targets or facial animation parameters.
    pub is_face: bool,
    /// Level of articulation, of the body or of the face.
    pub loa: u32,
    /// Region of the body or of the face; `None` if the group is of several.
    pub region: Option<String>,
    /// Index of the joint, if the group has one.
    pub joint: Option<u32>,
    /// Size of its units at each tier, finest first, in bytes.
    pub bytes: Vec<usize>,
}

/// Summarises a motion stream, or a prefix of one, and checks its checksums and the map by which it is
/// cut; `file` identifies the file in errors. Units are not decoded, which needs the character.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file and the position in it.
pub fn inspect_motion_stream(
    bytes: &[u8],
    file: &str,
    limits: &StreamLimits,
) -> Result<MotionStreamInspection> {
    let head = MotionHead::open(bytes, limits).context(file)?;
    let map = prefix_map(bytes, limits).context(file)?;
    map.check().context("map")?;
    map.check_values(bytes).context("map")?;
    let whole = &bytes[..map.bytes() as usize];
    let tier = |tier: usize| -> Result<StreamTier> {
        let rule = CutRule::default().at_least("tier", tier as u32);
        let cut = cut(whole, &map, |unit| rule.keeps(unit)).context(file)?;
        Ok(StreamTier {
            tier,
            tolerance_mm: 1e3 * head.tolerance_metres(tier),
            bytes: cut.bytes.len(),
        })
    };
    let is_face = head.face.is_some();
    Ok(MotionStreamInspection {
        file: file.to_owned(),
        format: if is_face { "afp" } else { "abp" },
        profile: if is_face { "AFP-2" } else { "ABP-2" },
        bytes: bytes.len(),
        bytes_head: map.children[0].bytes() as usize,
        frames: head.frames,
        fps: head.rate_hz,
        duration_secs: (head.frames - 1) as f32 / head.rate_hz,
        joints: head.joints,
        morph_targets: head.morphs.len(),
        rig_hash: format!("{:016x}", head.rig_hash),
        group_by: match head.grouping {
            Grouping::Loa => "loa",
            Grouping::LoaRegion => "region",
            Grouping::Joint => "joint",
        },
        skeleton: map.children[0]
            .children
            .iter()
            .any(|unit| unit.label == "skeleton"),
        access_units: AccessUnitCount {
            whole: map.children.len() - 1,
            of: head.access_units,
        },
        tiers: (0..head.tiers).map(tier).collect::<Result<_>>()?,
        groups: groups(&map, head.tiers),
        tracks: Vec::new(),
        warnings: Vec::new(),
        clip: head.name,
    })
}

/// Whether a group is of a face, its level of articulation, region and joint.
type Marks = (bool, u32, Option<u32>, Option<u32>);

/// The groups in the order in which they first occur.
fn groups(map: &Unit, tiers: usize) -> Vec<StreamGroup> {
    let mut groups: Vec<(Marks, Vec<usize>)> = Vec::new();
    map.visit(&mut |unit| {
        let Some(tier) = unit.marker("tier") else {
            return;
        };
        let key = match (unit.marker("loa"), unit.marker("face_loa")) {
            (Some(loa), _) => (false, loa, unit.marker("region"), unit.marker("joint")),
            (_, Some(loa)) => (true, loa, unit.marker("face_region"), None),
            _ => return,
        };
        let at = groups.iter().position(|(known, _)| *known == key);
        let at = at.unwrap_or_else(|| {
            groups.push((key, vec![0; tiers]));
            groups.len() - 1
        });
        groups[at].1[tier as usize] += unit.bytes() as usize;
    });
    groups.sort_by_key(|(key, _)| *key);
    let group = |((is_face, loa, region, joint), bytes): (Marks, Vec<usize>)| StreamGroup {
        is_face,
        loa,
        region: region.map(|number| region_name(is_face, number)),
        joint,
        bytes,
    };
    groups.into_iter().map(group).collect()
}
