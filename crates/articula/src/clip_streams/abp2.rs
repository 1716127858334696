//! The motion of a character as ABP-2, and back.
//!
//! Form: `docs/formats/abp2.md`. Unless such a stream carries the skeleton, it is decoded onto the
//! character that it was made from, which it knows by a hash of the joints.

use super::rig_hash::{of_version, rig_hash};
use super::{StreamKind, stream_limits};
use crate::error::{Context, Error, Result};
use articula_build::face::{blend_shape, vrm_preset};
use articula_build::{ClipOptions, rig_and_mesh, sampled_clip};
use articula_core::face_levels::{FaceLevel, FaceLevels, FaceRegion, FapRole, FapRoles};
use articula_core::fap_table::{LOW_FAPS, unit_mm};
use articula_core::source::{Channel, Character, Interpolation, Property, RawClip, RawMesh};
use articula_core::{Articulation, Clip, Mesh, Rig, Track};
use articula_formats::Limits;
use articula_stream::CutRule;
use articula_stream::abp2::{
    EncodedMotion, Group, MotionHead, MotionOptions, MotionReceiver, encode,
};
use serde::Serialize;

/// A tier of a motion stream.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TierReport {
    /// Number of the tier; 0 is the finest.
    pub tier: usize,
    /// Size of the stream cut to this tier, in bytes.
    pub bytes: usize,
    /// Greatest error that the tier allows, in millimetres of skin.
    pub tolerance_mm: f64,
    /// Greatest error over all frames and vertices, in millimetres.
    pub error_mm_max: f64,
    /// Mean error in millimetres.
    pub error_mm_mean: f64,
}

/// Encodes a clip of a character as an ABP-2 stream.
///
/// Expressions become the morph weights and joint motions that show them. Options get the hash of
/// the rig.
///
/// # Errors
/// An [`Error`] if the clip does not exist, an option is out of range, or a value is too large.
pub fn write(
    source: &Character,
    articulation: &Articulation,
    clip: usize,
    options: &MotionOptions,
) -> Result<EncodedMotion> {
    let Some(of_source) = source.clips.get(clip) else {
        return Err(Error::unsuited("clips: the file has no clip to write"));
    };
    let (rig, mesh) = rig_and_mesh(&source.skeleton, &source.meshes, articulation.clone())?;
    let place = || format!("clip \"{}\"", of_source.name);
    let clip = sampled_clip(source, of_source, &mesh, &ClipOptions::default());
    let clip = clip.with_context(place)?;
    write_sampled((&rig, &mesh), &source.meshes, &clip, options).with_context(place)
}

/// The same for a clip of a rig and a mesh that were built of these meshes.
pub(crate) fn write_sampled(
    (rig, mesh): (&Rig, &Mesh),
    meshes: &[RawMesh],
    clip: &Clip,
    options: &MotionOptions,
) -> Result<EncodedMotion> {
    let mut options = MotionOptions {
        rig_hash: rig_hash(rig),
        ..options.clone()
    };
    if options.morph_groups.is_empty() {
        options.morph_groups = morph_groups(meshes);
    }
    Ok(encode(rig, mesh, clip, &options)?)
}

/// Returns for each morph target of these meshes its level of articulation and region of the face: of
/// the parameter that it shows most, by its name. Of other names, those that are dropped last: level
/// very low of the region of visemes and expressions.
pub fn morph_groups(meshes: &[RawMesh]) -> Vec<Group> {
    let roles = FaceLevel::ALL.map(|level| FaceLevels::all(level).roles());
    let group = |name: &str| {
        let values = blend_shape(name).or_else(|| vrm_preset(name))?;
        let moved = |fap: &usize| (values.get(*fap) * unit_mm(*fap)).abs();
        let most = LOW_FAPS.max_by(|a, b| moved(a).total_cmp(&moved(b)));
        let most = most.filter(|fap| moved(fap) > 0.0)?;
        // A parameter that copies another one still moves.
        let shows = |roles: &FapRoles| !matches!(roles.role(most), FapRole::Removed);
        let finer = roles.iter().rev().take_while(|roles| !shows(roles)).count();
        let region = FaceRegion::of(most)?;
        Some([finer as u8, region as u8])
    };
    let mut groups = Vec::new();
    for mesh in meshes {
        for target in 0..mesh.morph_weights.len() {
            let name = mesh.morph_names.get(target);
            let [loa, region] = name.and_then(|name| group(name)).unwrap_or_default();
            groups.push(Group {
                loa,
                region,
                joint: None,
            });
        }
    }
    groups
}

/// Lists the tiers of an encoded motion, finest first.
///
/// # Errors
/// An [`Error`] if the map does not belong to the bytes.
pub fn tiers(coded: &EncodedMotion, tolerance_metres: f64) -> Result<Vec<TierReport>> {
    let tier = |(tier, error): (usize, &articula_stream::abp2::SkinError)| {
        let rule = CutRule::default().at_least("tier", tier as u32);
        let cut = articula_stream::cut(&coded.bytes, &coded.unit, |unit| rule.keeps(unit))?;
        Ok(TierReport {
            tier,
            bytes: cut.bytes.len(),
            tolerance_mm: 1e3 * tolerance_metres * 3_f64.powi(tier as i32),
            error_mm_max: 1e3 * error.max_metres,
            error_mm_mean: 1e3 * error.mean_metres,
        })
    };
    coded.errors.iter().enumerate().map(tier).collect()
}

/// Whether a stream tells the hash of a rig.
pub(crate) fn is_of_rig(head: &MotionHead, rig: &Rig) -> bool {
    head.rig_hash == of_version(head.version, rig)
}

/// Whether a stream can be shown with a rig: it is of this one, or does not tell of which it is.
pub(crate) fn suits(head: &MotionHead, rig: &Rig) -> bool {
    head.rig_hash == 0 || is_of_rig(head, rig)
}

/// Decodes a stream with the rig of the character called `of`.
pub(crate) fn decode(bytes: &[u8], rig: &Rig, of: &str, limits: &Limits) -> Result<Clip> {
    if StreamKind::of(bytes) != Some(StreamKind::Abp2) {
        let what = "the file does not begin as a motion stream does, with ABP2";
        return Err(Error::unsuited(what));
    }
    let received = MotionReceiver::read(bytes, rig, &stream_limits(limits))?;
    if let Some(head) = received.head()
        && !suits(head, rig)
    {
        return Err(Error::unsuited(format!(
            "the stream was made for another character than {of}: joint names or rest poses differ"
        )));
    }
    Ok(received.clip()?)
}

/// A clip as keys at every frame, for a character with these meshes.
pub(crate) fn raw_clip(clip: &Clip, meshes: &[RawMesh]) -> RawClip {
    let secs = |frame: usize| frame as f32 / clip.rate_hz();
    let times_secs: Vec<f32> = (0..clip.frames()).map(secs).collect();
    let tracks = clip.tracks();
    let mut channels = Vec::new();
    keys(
        &tracks.rotations,
        Property::Rotation,
        &times_secs,
        &mut channels,
        |q| q.to_array().to_vec(),
    );
    keys(
        &tracks.translations,
        Property::Translation,
        &times_secs,
        &mut channels,
        |t| t.to_array().to_vec(),
    );
    keys(
        &tracks.scales,
        Property::Scale,
        &times_secs,
        &mut channels,
        |s| s.to_array().to_vec(),
    );
    let mut first = 0;
    for (target, mesh) in meshes.iter().enumerate() {
        let slots = first..first + mesh.morph_weights.len();
        first = slots.end;
        let mut rows: Vec<f32> = mesh.morph_weights.repeat(times_secs.len());
        let mut moves = false;
        for track in &tracks.morphs {
            let slot = usize::from(track.target);
            if slots.contains(&slot) {
                moves = true;
                let of_slot = rows.iter_mut().skip(slot - slots.start);
                for (frame, weight) in of_slot.step_by(slots.len()).enumerate() {
                    *weight = track.values[frame.min(track.values.len() - 1)];
                }
            }
        }
        if moves {
            channels.push(Channel {
                target,
                property: Property::Weights,
                interpolation: Interpolation::Linear,
                times_secs: times_secs.clone(),
                values: rows,
            });
        }
    }
    RawClip {
        name: clip.name.clone(),
        duration_secs: times_secs.last().copied().unwrap_or(0.0),
        channels,
    }
}

/// Appends the channels of some tracks.
fn keys<T: Copy>(
    tracks: &[Track<T>],
    property: Property,
    times_secs: &[f32],
    channels: &mut Vec<Channel>,
    numbers: impl Fn(T) -> Vec<f32>,
) {
    channels.extend(tracks.iter().map(|track| {
        Channel {
            target: usize::from(track.target),
            property,
            interpolation: Interpolation::Linear,
            times_secs: times_secs[..track.values.len().min(times_secs.len())].to_vec(),
            values: track
                .values
                .iter()
                .flat_map(|value| numbers(*value))
                .collect(),
        }
    }));
}
