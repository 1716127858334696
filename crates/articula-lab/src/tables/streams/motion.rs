//! ABP-2 of one clip: sizes, errors and speeds of its forms.

use super::judge::{Errors, Sampled, errors};
use crate::measure::median;
use anyhow::Result;
use articula_build::Asset;
use articula_core::Clip;
use articula_report::thread_ns;
use articula_stream::abp2::{EncodedMotion, Grouping, MotionOptions, MotionReceiver, encode};
use articula_stream::{CutRule, StreamLimits, cut};
use std::hint::black_box;

/// Tolerance of all forms in metres.
pub(super) const TOLERANCE_METRES: f64 = 1e-4;
/// Rounds of the timings; the median counts.
pub(super) const ROUNDS: usize = 9;
/// Processor time that one round takes at least, in nanoseconds.
const ROUND_NS: u64 = 20_000_000;

/// A stream with its error.
pub(super) struct Form {
    pub(super) bytes: usize,
    pub(super) errors: Errors,
}

/// All that is measured of a clip.
pub(super) struct Motion {
    /// As few tiers as the motion allows.
    pub(super) single: Form,
    /// Their number, mostly 1.
    pub(super) single_tiers: usize,
    /// By level of articulation, by level and region, and by joint, all with tiers.
    pub(super) layered: [Form; 3],
    /// The stream by level of articulation cut to each tier, finest first.
    pub(super) tiers: Vec<Form>,
    /// Bytes of the units of level 0 at all tiers, and at the coarsest.
    pub(super) level_0: [usize; 2],
    pub(super) joints_moving: usize,
    /// Joints decoded per second in one thread, in millions, by tier: those that move.
    pub(super) decode_millions: Vec<f64>,
    /// Time to encode the stream by level of articulation, in seconds.
    pub(super) encode_secs: f64,
}

/// Encodes a clip in every form.
pub(super) fn measured(asset: &Asset, clip: &Clip, tiers: usize, rounds: usize) -> Result<Motion> {
    let coded = |grouping: Grouping, tiers: usize| {
        let options = MotionOptions {
            tolerance_metres: TOLERANCE_METRES,
            grouping,
            tiers,
            ..MotionOptions::default()
        };
        encode(&asset.rig, &asset.mesh, clip, &options)
    };
    // One tier, or as few as the motion allows.
    let found = (1..tiers).find_map(|few| Some((few, coded(Grouping::Loa, few).ok()?)));
    let (single_tiers, single) = match found {
        Some(found) => found,
        None => (tiers, coded(Grouping::Loa, tiers)?),
    };
    let start = thread_ns();
    let by_level = coded(Grouping::Loa, tiers)?;
    let encode_secs = 1e-9 * (thread_ns() - start) as f64;
    let by_region = coded(Grouping::LoaRegion, tiers)?;
    let by_joint = coded(Grouping::Joint, tiers)?;
    let mut forms = Vec::new();
    let mut speeds = Vec::new();
    let joints = moving(asset, &by_level.bytes)?;
    for tier in 0..tiers {
        let bytes = cut_to(&by_level, tier)?;
        forms.push(form(asset, clip, &bytes)?);
        let joint_frames = (joints * clip.frames()) as f64;
        speeds.push(joint_frames * 1e3 / decode_ns(asset, &bytes, rounds)?);
    }
    Ok(Motion {
        single: form(asset, clip, &single.bytes)?,
        single_tiers,
        layered: [
            form(asset, clip, &by_level.bytes)?,
            form(asset, clip, &by_region.bytes)?,
            form(asset, clip, &by_joint.bytes)?,
        ],
        level_0: [0, tiers - 1].map(|tier| level_0(&by_level, tier)),
        tiers: forms,
        joints_moving: joints,
        decode_millions: speeds,
        encode_secs,
    })
}

fn cut_to(coded: &EncodedMotion, tier: usize) -> Result<Vec<u8>> {
    let rule = CutRule::default().at_least("tier", tier as u32);
    Ok(cut(&coded.bytes, &coded.unit, |unit| rule.keeps(unit))?.bytes)
}

fn form(asset: &Asset, clip: &Clip, bytes: &[u8]) -> Result<Form> {
    let received = MotionReceiver::read(bytes, &asset.rig, &StreamLimits::default())?;
    let shown = received.clip()?;
    Ok(Form {
        bytes: bytes.len(),
        errors: errors(asset, clip, &mut Sampled::new(asset, &shown)),
    })
}

/// Bytes of the units of level of articulation 0 that a cut to a tier keeps.
fn level_0(coded: &EncodedMotion, tier: usize) -> usize {
    let mut bytes = 0;
    coded.unit.visit(&mut |unit| {
        let is_of_level = unit.marker("loa") == Some(0);
        if is_of_level && unit.marker("tier").is_some_and(|t| t as usize >= tier) {
            bytes += unit.bytes() as usize;
        }
    });
    bytes
}

/// Joints with a track that is not constant.
fn moving(asset: &Asset, bytes: &[u8]) -> Result<usize> {
    let received = MotionReceiver::read(bytes, &asset.rig, &StreamLimits::default())?;
    let clip = received.clip()?;
    let tracks = clip.tracks();
    let turned = tracks.rotations.iter().filter(|t| t.values.len() > 1);
    let moved = tracks.translations.iter().chain(&tracks.scales);
    let moved = moved.filter(|t| t.values.len() > 1).map(|t| t.target);
    let mut joints: Vec<u16> = turned.map(|t| t.target).chain(moved).collect();
    joints.sort_unstable();
    joints.dedup();
    Ok(joints.len())
}

/// Nanoseconds of processor time to decode a stream.
fn decode_ns(asset: &Asset, bytes: &[u8], rounds: usize) -> Result<f64> {
    let limits = StreamLimits::default();
    let mut times = Vec::with_capacity(rounds);
    for _ in 0..rounds {
        let (start, mut count) = (thread_ns(), 0_u32);
        while count == 0 || thread_ns() - start < ROUND_NS {
            black_box(MotionReceiver::read(bytes, &asset.rig, &limits)?);
            count += 1;
        }
        times.push((thread_ns() - start) as f64 / f64::from(count));
    }
    Ok(median(&mut times))
}
