//! The encoder: a clip within a tolerance of the skin.
//!
//! Form: `docs/methods/motion-stream.md`.
//!
//! In the order of the work:
//!
//! - `truth`: local values at every frame
//! - `skin_points`: points of the skin, and the error of a motion there
//! - `near_points`: bounds of the errors of points that lie near each other
//! - `levers`: how far each track moves each point, and the shares of the tolerance
//! - `plan`: which tracks move, and around which values
//! - `quantise`: levels at given steps, and what a decoder shows of them
//! - `shown_planes`: what it shows without some planes
//! - `search`: steps within the tolerance, planes of coarser tiers
//! - `alone`: the same where each track has a point of its own
//! - `units`: the coded units
//! - `value_order`: units by the error that they take away for their bytes

mod alone;
mod levers;
mod near_points;
mod plan;
mod quantise;
mod search;
mod shown_planes;
mod skin_points;
mod truth;
mod units;
mod value_order;

pub use skin_points::SkinError;

use super::access_unit::{self, AccessUnit};
use super::grouping::{Group, Grouping, groups};
use super::head::{FaceHead, MotionHead};
use super::map::motion_map;
use super::pose_unit::{self, MOST_TIERS, TrackForm};
use super::receiver::MotionReceiver;
use super::skeleton;
use super::tracks::{TrackPlace, TrackTable, pose_tracks};
use super::unit_form::VERSION;
use super::wavelet::MOST_FRAMES;
use crate::abp2::face_channels;
use crate::limits::StreamLimits;
use crate::unit::Unit;
use articula_core::{Clip, Mesh, Mismatch, Rig};
use levers::Rest;
use quantise::{Coding, Levels};
use search::{Judge, Near, Shares, finest, tiers};
use skin_points::{SkinPoints, offsets_by_vertex};
use std::cell::{Cell, OnceCell};
use truth::Truth;
use units::UnitCoder;
use value_order::Prefixes;

/// Points at which steps are searched, and values of all of them over time.
const POINTS: usize = 1500;
const VALUES: usize = 6_000_000;

/// Options of [`encode`].
#[derive(Debug, Clone, PartialEq)]
pub struct MotionOptions {
    /// Greatest error of the finest tier in metres of skin, 1 µm to 65 mm.
    pub tolerance_metres: f64,
    /// Number of tiers, 1 to 8; each allows three times the error of the one before.
    pub tiers: usize,
    /// What the joints of a unit have in common.
    pub grouping: Grouping,
    /// Whether middle tiers are kept small; without, the finest tier is.
    pub updates: bool,
    /// Longest access unit in seconds; a stream can be entered at the start of any.
    pub access_unit_secs: f64,
    /// For each morph target of the mesh its group: level of articulation and region. Empty: one group.
    pub morph_groups: Vec<Group>,
    /// Hash of the rig, by which an application finds it: the first 8 bytes of BLAKE3, as the form says;
    /// 0 does not tell.
    pub rig_hash: u64,
    /// Order of the units of an access unit.
    pub order: UnitOrder,
    /// Whether the errors of the tiers are measured ([`EncodedMotion::errors`]); those of faces are
    /// anyway. The stream is the same.
    pub errors: bool,
    /// Whether the error after each unit is measured.
    pub manifest: bool,
    /// Whether the skeleton is carried ([`CarriedSkeleton`](super::CarriedSkeleton)), so that the stream
    /// can be shown without its character.
    pub skeleton: bool,
}

/// Order of the units of an access unit, which matters where a stream ends early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum UnitOrder {
    /// By tier, then by group: every part of the body, coarse first.
    #[default]
    Tier,
    /// By the mean square of the error that a unit takes away for its bytes, the greatest first; those
    /// of the coarsest tier come before all others.
    Value,
}

/// What a prefix of a stream shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ManifestRow {
    /// Number of the access unit.
    pub access_unit: usize,
    /// Number of the group, and the tier that the last unit of the prefix adds to it.
    pub group: usize,
    /// The tier.
    pub tier: usize,
    /// Bytes of the prefix.
    pub bytes: usize,
    /// Error of the prefix in the frames of the access unit, at the points of the search (1,500 at
    /// most, and the worst of all).
    pub error: SkinError,
}

impl Default for MotionOptions {
    fn default() -> Self {
        Self {
            tolerance_metres: 1e-4,
            tiers: 5,
            grouping: Grouping::Loa,
            updates: true,
            access_unit_secs: 1.0,
            morph_groups: Vec::new(),
            rig_hash: 0,
            order: UnitOrder::Tier,
            errors: true,
            manifest: false,
            skeleton: false,
        }
    }
}

/// An encoded motion.
#[derive(Debug, Clone, PartialEq)]
pub struct EncodedMotion {
    /// The stream.
    pub bytes: Vec<u8>,
    /// Map of the bytes.
    pub unit: Unit,
    /// Error of the stream cut to each tier, the finest first, if it was asked for.
    pub errors: Vec<SkinError>,
    /// What each prefix of whole units shows, if it was asked for.
    pub manifest: Vec<ManifestRow>,
}

/// Encodes a clip so that no point of the skin, at any frame, is farther from its place than the
/// tolerance; without a mesh, points around the joints count.
///
/// The error includes rotations, translations, scales and morph targets. It is measured at the frames
/// of the clip; between them, a player interpolates. O(frames x vertices) for the final check and
/// about forty times O(frames x 1500) for the search.
///
/// # Errors
/// A [`Mismatch`] for options out of range, a clip or mesh of another rig, or a motion too large for
/// the form.
pub fn encode(
    rig: &Rig,
    mesh: &Mesh,
    clip: &Clip,
    options: &MotionOptions,
) -> Result<EncodedMotion, Mismatch> {
    let head = head(rig, mesh, clip, options)?;
    encode_with(rig, mesh, clip, options, head)
}

/// Encodes a clip of the channels of a face as a face stream: the morph targets of the mesh are the
/// channels ([`channels`]), of which the stream has those of some groups.
///
/// # Errors
/// As [`encode()`].
pub(crate) fn encode_face(
    rig: &Rig,
    mesh: &Mesh,
    clip: &Clip,
    options: &MotionOptions,
    (face, groups): (FaceHead, Vec<Group>),
) -> Result<EncodedMotion, Mismatch> {
    let head = MotionHead {
        face: Some(face),
        morphs: if groups.is_empty() {
            Vec::new()
        } else {
            face_channels::groups_of(&groups)
        },
        morph_groups: groups,
        ..head(rig, mesh, clip, options)?
    };
    encode_with(rig, mesh, clip, options, head)
}

/// Encodes a clip under a head.
fn encode_with(
    rig: &Rig,
    mesh: &Mesh,
    clip: &Clip,
    options: &MotionOptions,
    mut head: MotionHead,
) -> Result<EncodedMotion, Mismatch> {
    let truth = Truth::new(rig, mesh, clip);
    let offsets = offsets_by_vertex(mesh);
    let all = Near::of(if mesh.is_empty() {
        SkinPoints::of_bones(rig)
    } else {
        SkinPoints::of_vertices(mesh, &offsets, 0..mesh.len())
    });
    let some = |more: &[usize]| {
        if mesh.is_empty() {
            return SkinPoints::of_bones(rig);
        }
        let count = (VALUES / truth.frames.max(1)).clamp(200, POINTS);
        let every = mesh.len().div_ceil(count).max(1);
        let mut vertices: Vec<usize> = (0..mesh.len()).step_by(every).collect();
        vertices.extend(more);
        vertices.sort_unstable();
        vertices.dedup();
        SkinPoints::of_vertices(mesh, &offsets, vertices.into_iter())
    };
    let points = some(&[]);
    let rest = Rest::new(rig, &points, &mesh.morph_weights);
    let planned = plan::plan(
        rig,
        &all.points,
        &Rest::new(rig, &all.points, &mesh.morph_weights),
        &truth,
    );
    head.scales = planned
        .iter()
        .any(|track| track.kind == pose_unit::Kind::Scale);
    let coding = Coding::new(rig, &head, &truth, &planned);
    let shares = Shares::new(rig, &points, &rest, &planned, &coding.compensates);
    let mut judge = Judge {
        rig,
        truth: &truth,
        all: &all,
        some: Near::of(points),
        some_shown: OnceCell::new(),
        all_shown: OnceCell::new(),
        palettes: OnceCell::new(),
        states_errors: options.errors,
        worst_frame: Cell::new(0),
    };
    let tolerance = head.tolerance_metres(0);
    let (levels, errors) = match head.face {
        Some(_) => {
            let (mut levels, shown, error) = alone::finest(&coding, tolerance, &judge)?;
            let errors = alone::tiers(&coding, &mut levels, (&shown, error), &judge, tolerance);
            (levels, errors)
        }
        None => {
            let (mut levels, shown) = finest(&coding, &shares.fine, tolerance, &mut judge, some)?;
            let errors = tiers(&coding, &mut levels, &shown, &shares, &judge, tolerance);
            (levels, errors)
        }
    };
    let (bytes, manifest) = write(&coding, &levels, &judge, options)?;
    let limits = StreamLimits::default();
    let receiver = match head.face {
        Some(_) => MotionReceiver::of_face(rig, &limits),
        None => MotionReceiver::new(rig, &limits),
    };
    let expected = errors.first().map_or(tolerance, |error| error.max_metres);
    checked(&bytes, receiver, mesh, &judge, expected)?;
    Ok(EncodedMotion {
        unit: motion_map(&bytes, &limits)
            .map_err(|e| Mismatch::new("the stream", e.to_string()))?,
        bytes,
        errors,
        manifest,
    })
}

fn head(
    rig: &Rig,
    mesh: &Mesh,
    clip: &Clip,
    options: &MotionOptions,
) -> Result<MotionHead, Mismatch> {
    if clip.joints() != rig.len() {
        let what = format!(
            "made for {} joints, the rig has {}",
            clip.joints(),
            rig.len()
        );
        return Err(Mismatch::new("clip", what));
    }
    let (micrometres, longest) = checked_numbers(clip, options)?;
    let longest = (longest as usize).clamp(3, MOST_FRAMES);
    let frames = clip.frames();
    let slots = mesh.morph_weights.len();
    let of_slot = if options.morph_groups.is_empty() {
        let whole = Group {
            loa: 0,
            region: 0,
            joint: None,
        };
        vec![whole; slots]
    } else {
        options.morph_groups.clone()
    };
    if of_slot.len() != slots {
        let what = format!("{} groups for {slots} morph targets", of_slot.len());
        return Err(Mismatch::new("morph_groups", what));
    }
    let mut morph_groups = of_slot.clone();
    morph_groups.sort_unstable();
    morph_groups.dedup();
    let number = |group: &Group| morph_groups.partition_point(|g| g < group) as u16;
    let moves = clip
        .tracks()
        .morphs
        .iter()
        .any(|track| usize::from(track.target) < slots);
    let has_morphs = moves || mesh.morph_weights.iter().any(|weight| *weight != 0.0);
    Ok(MotionHead {
        version: VERSION,
        name: clip.name.clone(),
        grouping: options.grouping,
        updates: options.updates,
        tiers: options.tiers,
        tolerance_micrometres: micrometres as u16,
        rate_hz: clip.rate_hz(),
        frames,
        joints: rig.len(),
        access_units: if frames > 1 {
            frames.div_ceil(longest)
        } else {
            0
        },
        rig_hash: options.rig_hash,
        scales: false,
        groups: groups(options.grouping, rig)
            .into_iter()
            .map(|g| g.0)
            .collect(),
        morphs: if has_morphs {
            of_slot.iter().map(number).collect()
        } else {
            Vec::new()
        },
        morph_groups: if has_morphs {
            morph_groups.clone()
        } else {
            Vec::new()
        },
        face: None,
    })
}

/// The tolerance in micrometres, and the longest access unit in frames.
fn checked_numbers(clip: &Clip, options: &MotionOptions) -> Result<(f64, f64), Mismatch> {
    let micrometres = (options.tolerance_metres * 1e6).round();
    if !(1.0..=65535.0).contains(&micrometres) {
        let what = format!("{} m, expected 1 µm to 65 mm", options.tolerance_metres);
        return Err(Mismatch::new("tolerance_metres", what));
    }
    if !(1..=MOST_TIERS).contains(&options.tiers) {
        let what = format!("{}, expected 1 to {MOST_TIERS}", options.tiers);
        return Err(Mismatch::new("tiers", what));
    }
    let longest = options.access_unit_secs * f64::from(clip.rate_hz());
    if longest.is_nan() || longest <= 0.0 {
        let what = format!("{}, expected more than 0", options.access_unit_secs);
        return Err(Mismatch::new("access_unit_secs", what));
    }
    Ok((micrometres, longest))
}

/// Writes the stream of a motion.
fn write(
    coding: &Coding<'_>,
    levels: &Levels,
    judge: &Judge<'_>,
    options: &MotionOptions,
) -> Result<(Vec<u8>, Vec<ManifestRow>), Mismatch> {
    let (head, rig) = (coding.head, coding.rig);
    let find = |kind, target| {
        let track = levels
            .tracks
            .iter()
            .find(|t| t.kind == kind && t.target == target);
        track.map_or(TrackForm::Rest, |track| track.form)
    };
    let mut poses = Vec::new();
    let mut places = Vec::new();
    for (number, tracks) in pose_tracks(head, rig).into_iter().enumerate() {
        let kinds: Vec<_> = tracks.iter().map(|(kind, _)| *kind).collect();
        let forms: Vec<TrackForm> = tracks.iter().map(|(k, t)| find(*k, *t)).collect();
        poses.push((number, pose_unit::write(head.tiers, &kinds, &forms)));
        let place = tracks.iter().zip(forms);
        let place = place.map(|((kind, target), form)| TrackPlace {
            kind: *kind,
            target: *target,
            form,
        });
        places.push(Some(place.collect()));
    }
    let table = TrackTable::new(head, rig, places);
    let levels = in_table_order(&table, levels);
    let coder = UnitCoder {
        head,
        table: &table,
        levels: &levels,
    };
    let mut prefixes = Prefixes::new(coding, &coder, judge);
    let carried = options.skeleton.then(|| skeleton::write(rig)).transpose()?;
    let mut bytes = head.write(&poses, carried.as_deref());
    let mut manifest = Vec::new();
    for (number, order) in coding.orders.iter().enumerate() {
        let mut units = coder.units(number, order)?;
        if options.order == UnitOrder::Value {
            units = prefixes.by_value(number, units);
        }
        let start = bytes.len();
        access_unit::write(&mut bytes, number, head, &units);
        if options.manifest {
            let whole = AccessUnit::read(&bytes, start, number, head);
            let read = whole
                .ok()
                .flatten()
                .map_or_else(Vec::new, |found| found.units);
            let errors = prefixes.errors(number, &units);
            manifest.extend(read.iter().zip(errors).map(|(place, error)| ManifestRow {
                access_unit: number,
                group: place.group,
                tier: place.tier,
                bytes: place.bytes.end,
                error,
            }));
        }
    }
    Ok((bytes, manifest))
}

/// The levels in the order of the table's tracks; tracks at rest have none.
fn in_table_order(table: &TrackTable, levels: &Levels) -> Levels {
    let levels_of = |place: &TrackPlace| {
        let same = |t: &TrackPlace| t.kind == place.kind && t.target == place.target;
        let at = levels.tracks.iter().position(same);
        at.map_or_else(Vec::new, |at| levels.levels[at].clone())
    };
    Levels {
        levels: table.tracks.iter().map(levels_of).collect(),
        tracks: table.tracks.clone(),
    }
}

/// Decodes the stream and compares its error with the one that the search measured.
fn checked(
    bytes: &[u8],
    mut receiver: MotionReceiver,
    mesh: &Mesh,
    judge: &Judge<'_>,
    expected: f64,
) -> Result<(), Mismatch> {
    let wrong = |what: String| Mismatch::new("the coded stream", what);
    receiver.receive(bytes).map_err(|e| wrong(e.to_string()))?;
    let shown = Truth::new(judge.rig, mesh, &receiver.clip()?);
    let limit = expected * 1.001 + 1e-7;
    match judge.some_beyond(&shown, 0..judge.truth.frames, limit) {
        Some(frame) => Err(wrong(format!(
            "decodes to more than {expected} m from its place in frame {frame}"
        ))),
        None => Ok(()),
    }
}
