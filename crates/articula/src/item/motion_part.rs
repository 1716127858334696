//! Motions of an item: ABP-2 streams by level of articulation, region and tier.

use super::files::NewFiles;
use super::motion_error::{MotionError, measured};
use super::part::{ItemLayer, ItemPart, PartKind, RegionEntry};
use crate::clip_streams::abp2::{decode, write};
use crate::clip_streams::region_name;
use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::work::Executor;
use articula_core::Clip;
use articula_formats::Limits;
use articula_stream::abp2::{EncodedMotion, Grouping, MotionHead, MotionOptions};
use articula_stream::{Unit, cut};
use std::collections::{BTreeMap, BTreeSet};

/// Encodes a clip, measures its cuts and adds its files under a name.
pub(super) fn part(
    figure: &Figure,
    clip: usize,
    (stem, options): (&str, &MotionOptions),
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<ItemPart> {
    let truth = &figure.asset.clips[clip];
    let opened = &figure.opened;
    let coded = write(opened.character(), &opened.articulation(), clip, options)?;
    let stream_limits = articula_stream::StreamLimits::default();
    let head = MotionHead::open(&coded.bytes, &stream_limits)?;
    let levels: Vec<u8> = levels(&head);
    let grid = levels
        .iter()
        .flat_map(|loa| (0..head.tiers).rev().map(|tier| (*loa, tier)));
    let grid: Vec<(u8, usize)> = grid.collect();
    let regions = regions(&head);

    let mut cuts = vec![without_units(&coded)?];
    for (loa, tier) in &grid {
        cuts.push(kept(&coded, |unit| {
            unit.marker("loa").is_none_or(|l| l <= u32::from(*loa))
                && unit.marker("tier").is_none_or(|t| t as usize >= *tier)
        })?);
    }
    for region in &regions {
        cuts.push(kept(&coded, |unit| {
            unit.marker("region") != Some(u32::from(*region))
        })?);
    }
    let faces = face_levels(&head);
    for finest in &faces {
        cuts.push(kept(&coded, |unit| {
            unit.marker("face_loa")
                .is_none_or(|l| l <= u32::from(*finest))
        })?);
    }
    let (rig, name) = (&figure.asset.rig, figure.opened.name());
    let decoded = |bytes: &Vec<u8>| decode(bytes, rig, name, &Limits::default());
    let clips: Vec<Clip> = cuts.iter().map(decoded).collect::<Result<_>>()?;
    let (errors, frames) = measured(&figure.asset, truth, &clips, work)?;
    let (of_grid, without) = errors[1..].split_at(grid.len());
    let (of_regions, of_faces) = without.split_at(regions.len());

    let mut layers: Vec<ItemLayer> = Vec::with_capacity(grid.len());
    for (i, ((loa, tier), error)) in grid.iter().zip(of_grid).enumerate() {
        layers.push(ItemLayer {
            name: format!("loa {loa}, tier {tier}"),
            keep: keep(&[("loa", u32::from(*loa)), ("tier", *tier as u32)]),
            needs: needs(i, *tier, head.tiers),
            error_m: error.max_metres,
            error_mean_m: Some(error.mean_metres),
            joints: Some(joints(figure, *loa)),
            ..ItemLayer::default()
        });
    }
    let (without_regions, without_faces) = cuts[1 + grid.len()..].split_at(regions.len());
    let without = without_regions.iter().zip(of_regions);
    let regions = region_entries(false, &regions, without);
    let face_levels = faces.into_iter().zip(without_faces.iter().zip(of_faces));
    let face_levels = face_levels.map(|(finest, without)| RegionEntry {
        name: format!("face above level {finest}"),
        ..region_entry(finest, without)
    });
    let file = format!("clips/{stem}.abp");
    let mut part = ItemPart {
        base_error_m: Some(errors[0].max_metres),
        duration_secs: Some(f64::from(truth.duration_secs())),
        rate_hz: Some(f64::from(truth.rate_hz())),
        frames_measured: Some(frames as u64),
        layers,
        regions,
        face_levels: face_levels.collect(),
        ..ItemPart::new(&truth.name, PartKind::BodyMotion)
    };
    part.put_stream(&file, coded.bytes, &coded.unit, files)?;
    Ok(part)
}

/// Indices of the layers that the layer `i` of a motion needs: the next coarser level at its tier, and
/// its level one tier coarser. Layers are listed by level and, within it, by tier, coarsest first.
pub(super) fn needs(i: usize, tier: usize, tiers: usize) -> Vec<usize> {
    let coarser = (tier + 1 < tiers).then(|| i - 1);
    i.checked_sub(tiers).into_iter().chain(coarser).collect()
}

/// The regions of a motion of the body or `of_face`, each with the stream without it and its error.
pub(super) fn region_entries<'a>(
    of_face: bool,
    regions: &BTreeSet<u8>,
    without: impl Iterator<Item = (&'a Vec<u8>, &'a MotionError)>,
) -> Vec<RegionEntry> {
    let entry = |(region, without): (&u8, _)| RegionEntry {
        name: region_name(of_face, *region),
        ..region_entry(*region, without)
    };
    regions.iter().zip(without).map(entry).collect()
}

/// An entry without a name.
fn region_entry(number: u8, (bytes, error): (&Vec<u8>, &MotionError)) -> RegionEntry {
    RegionEntry {
        number: u32::from(number),
        name: String::new(),
        bytes_without: Some(bytes.len() as u64),
        error_without_m: Some(error.max_metres),
    }
}

/// Levels of articulation of the face at which the morph targets of a motion can be cut.
fn face_levels(head: &MotionHead) -> Vec<u8> {
    let finest = head.morph_groups.iter().map(|group| group.loa).max();
    (0..finest.unwrap_or(0)).collect()
}

/// Levels of articulation of the groups, coarsest first; 0 if the stream has morph targets alone.
fn levels(head: &MotionHead) -> Vec<u8> {
    let mut levels: BTreeSet<u8> = head.groups.iter().map(|group| group.loa).collect();
    if levels.is_empty() {
        levels.insert(0);
    }
    levels.into_iter().collect()
}

/// Regions that can be left out.
fn regions(head: &MotionHead) -> BTreeSet<u8> {
    if head.grouping != Grouping::LoaRegion {
        return BTreeSet::new();
    }
    head.groups.iter().map(|group| group.region).collect()
}

/// Number of joints up to a level of articulation.
fn joints(figure: &Figure, loa: u8) -> u64 {
    let joints = figure.asset.rig.articulation().joints.iter();
    joints.filter(|joint| joint.level <= loa).count() as u64
}

/// A stream cut by its units.
pub(super) fn kept(coded: &EncodedMotion, keeps: impl Fn(&Unit) -> bool) -> Result<Vec<u8>> {
    Ok(cut(&coded.bytes, &coded.unit, keeps).context("cut")?.bytes)
}

/// A stream without any unit of a tier.
pub(super) fn without_units(coded: &EncodedMotion) -> Result<Vec<u8>> {
    kept(coded, |unit| unit.marker("tier").is_none())
}

/// Markers by scheme.
pub(super) fn keep(markers: &[(&str, u32)]) -> BTreeMap<String, u32> {
    let owned = markers
        .iter()
        .map(|(scheme, value)| ((*scheme).to_owned(), *value));
    owned.collect()
}
