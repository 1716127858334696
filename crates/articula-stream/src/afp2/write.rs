//! Encoding of a clip.

use super::points;
use crate::abp2::face_channels::{COUNT, field_of, group_of, weight_of_unit};
use crate::abp2::{EncodedMotion, FaceHead, Group, MotionOptions, UnitOrder, encode_face};
use crate::face::{FaceClip, FaceFrame};
use articula_core::face_levels::{FaceLevel, FaceLevels, FaceRegion};
use articula_core::fap_table::FAP_COUNT;
use articula_core::{Clip, Mismatch, Track, Tracks};

/// Least tolerance in metres.
const LEAST_METRES: f64 = 1e-5;

/// How a clip is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Afp2Options {
    /// Greatest error of the finest tier in metres of a feature point of an average face, 10 µm to
    /// 65 mm. Values are whole numbers, of which half a unit is at most 30 µm more.
    pub tolerance_metres: f64,
    /// Number of tiers, 1 to 8; each allows three times the error of the one before.
    pub tiers: usize,
    /// Finest level that is written of each region.
    pub levels: FaceLevels,
    /// Longest access unit in seconds; a stream can be entered at the start of any.
    pub access_unit_secs: f64,
    /// Order of the units of an access unit.
    pub order: UnitOrder,
}

/// 0.1 mm, three tiers, all parameters, access units of up to a second.
impl Default for Afp2Options {
    fn default() -> Self {
        let MotionOptions {
            tolerance_metres,
            access_unit_secs,
            order,
            ..
        } = MotionOptions::default();
        Self {
            tolerance_metres,
            tiers: 3,
            levels: FaceLevels::all(FaceLevel::High),
            access_unit_secs,
            order,
        }
    }
}

/// Encodes a clip, so that no feature point of an average face is farther from its place than the
/// tolerance at any frame. FAP 1 and 2 come back unchanged from every tier.
///
/// Regions of the face that are neutral in all frames are left out. The errors of the result are of
/// the feature points.
///
/// # Errors
/// A [`Mismatch`] for options out of range, a clip without frames, a field of FAP 1 or 2 out of its
/// range ([`FaceClip::check`]), or a value too large for the form.
pub fn write(clip: &FaceClip, options: &Afp2Options) -> Result<EncodedMotion, Mismatch> {
    if options.tolerance_metres < LEAST_METRES {
        let what = format!("{} m, expected 10 µm to 65 mm", options.tolerance_metres);
        return Err(Mismatch::new("tolerance_metres", what));
    }
    clip.check()?;
    let groups = groups(clip, &options.levels);
    let written = |channel: &usize| groups.contains(&group_of(field_of(*channel).0));
    let tracks = Tracks {
        morphs: (0..COUNT)
            .filter(written)
            .map(|channel| track(clip, channel))
            .collect(),
        ..Tracks::default()
    };
    let rig = points::rig()?;
    let rate_hz = clip.rate.hz() as f32;
    let motion = Clip::new(&clip.name, rate_hz, clip.frames.len(), rig.len(), tracks)?;
    let mesh = points::mesh(options.tolerance_metres);
    let of_motion = MotionOptions {
        tolerance_metres: options.tolerance_metres,
        tiers: options.tiers,
        access_unit_secs: options.access_unit_secs,
        order: options.order,
        ..MotionOptions::default()
    };
    let face = FaceHead {
        bridge: clip.bridge.clone(),
    };
    encode_face(&rig, &mesh, &motion, &of_motion, (face, groups))
}

/// The groups that are written, rising: those that the levels keep, of regions that move.
fn groups(clip: &FaceClip, levels: &FaceLevels) -> Vec<Group> {
    let moves = |fap: &usize| clip.frames.iter().any(|frame| frame.moves(*fap));
    let moving: Vec<FaceRegion> = (1..=FAP_COUNT)
        .filter(moves)
        .filter_map(FaceRegion::of)
        .collect();
    let roles = levels.roles();
    let mut groups: Vec<Group> = (1..=FAP_COUNT)
        .filter(|fap| roles.keeps(*fap))
        .filter(|fap| FaceRegion::of(*fap).is_some_and(|region| moving.contains(&region)))
        .map(group_of)
        .collect();
    groups.sort_unstable();
    groups.dedup();
    groups
}

/// The weights of a channel.
fn track(clip: &FaceClip, channel: usize) -> Track<f32> {
    let (fap, field) = field_of(channel);
    let weight = |frame: &FaceFrame| weight_of_unit(fap) * frame.field(fap, field) as f32;
    Track {
        target: channel as u16,
        step: false,
        values: clip.frames.iter().map(weight).collect(),
    }
}
