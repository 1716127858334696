//! Motions of an item: ABP-2 streams by level of articulation, region and tier.

use super::files::NewFiles;
use super::motion_error::{MOST_FRAMES, MotionError, measured, measured_frames};
use super::part::{ItemLayer, ItemPart, PartKind, RegionEntry};
use crate::clip_streams::abp2::{decode, write_sampled};
use crate::clip_streams::region_name;
use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::work::Executor;
use articula_core::Clip;
use articula_formats::Limits;
use articula_stream::abp2::{Grouping, MotionHead, MotionOptions};
use articula_stream::{Cut, StreamLimits, Unit, cut};
use std::collections::{BTreeMap, BTreeSet};

/// Most frames that the base is measured on. All that are there are measured with the whole of the motion.
const MOST_FRAMES_OF_BASE: usize = 96;

/// A clip as a stream whose cuts are not measured yet.
pub(super) struct CodedMotion {
    clip: usize,
    file: String,
    stream: Cut,
    /// Errors that were measured with the base, if that was on all frames, by the bytes of the cut.
    known: BTreeMap<Vec<u8>, MotionError>,
}

impl CodedMotion {
    /// Encodes a clip for a file of this name.
    pub(super) fn new(
        figure: &Figure,
        clip: usize,
        (stem, options): (&str, &MotionOptions),
    ) -> Result<Self> {
        let asset = &figure.asset;
        let options = MotionOptions {
            // Those of its layers are measured.
            errors: false,
            ..options.clone()
        };
        let meshes = &figure.opened.character().meshes;
        let made = write_sampled(
            (&asset.rig, &asset.mesh),
            meshes,
            &asset.clips[clip],
            &options,
        )?;
        Ok(Self {
            clip,
            file: format!("clips/{stem}.abp"),
            stream: Cut {
                bytes: made.bytes,
                unit: made.unit,
            },
            known: BTreeMap::new(),
        })
    }

    /// Index of the clip.
    pub(super) fn clip(&self) -> usize {
        self.clip
    }

    /// Adds all of the stream, with the errors of each level at each tier and of leaving regions out.
    pub(super) fn part(
        self,
        figure: &Figure,
        files: &mut NewFiles,
        work: &Executor<'_>,
    ) -> Result<ItemPart> {
        let head = MotionHead::open(&self.stream.bytes, &StreamLimits::default())?;
        let cuts = Cuts {
            levels: levels(&head),
            tiers: (0..head.tiers).rev().collect(),
            regions: regions(&head),
            face_levels: face_levels(&head),
            frames: measured_frames(&figure.asset.clips[self.clip], MOST_FRAMES),
        };
        let mut known = self.known;
        let coded = (self.clip, &*self.file, self.stream);
        cuts.part(figure, coded, &mut known, files, work)
    }

    /// Adds the coarsest tier of the stream alone, with the errors of each level.
    pub(super) fn base(
        &mut self,
        figure: &Figure,
        files: &mut NewFiles,
        work: &Executor<'_>,
    ) -> Result<ItemPart> {
        let head = MotionHead::open(&self.stream.bytes, &StreamLimits::default())?;
        let coarsest = head.tiers.saturating_sub(1);
        let is_kept = |unit: &Unit| unit.marker("tier").is_none_or(|t| t as usize >= coarsest);
        let stream = cut(&self.stream.bytes, &self.stream.unit, is_kept)?;
        let clip = &figure.asset.clips[self.clip];
        let frames = measured_frames(clip, MOST_FRAMES_OF_BASE);
        let are_all = frames == measured_frames(clip, MOST_FRAMES);
        let cuts = Cuts {
            levels: levels(&head),
            tiers: vec![coarsest],
            regions: BTreeSet::new(),
            face_levels: Vec::new(),
            frames,
        };
        let coded = (self.clip, &*self.file, stream);
        let mut known = BTreeMap::new();
        let part = cuts.part(figure, coded, &mut known, files, work)?;
        if are_all {
            self.known = known;
        }
        Ok(part)
    }
}

/// The cuts of a stream that are measured.
struct Cuts {
    /// Levels of articulation, coarsest first.
    levels: Vec<u8>,
    /// Tiers, coarsest first.
    tiers: Vec<usize>,
    regions: BTreeSet<u8>,
    face_levels: Vec<u8>,
    /// Frames that they are measured on.
    frames: Vec<usize>,
}

impl Cuts {
    /// Measures the cuts of a clip's stream that are not known yet, and adds it under a name.
    fn part(
        self,
        figure: &Figure,
        (clip, file, coded): (usize, &str, Cut),
        known: &mut BTreeMap<Vec<u8>, MotionError>,
        files: &mut NewFiles,
        work: &Executor<'_>,
    ) -> Result<ItemPart> {
        let truth = &figure.asset.clips[clip];
        let tiers = self.tiers.iter();
        let grid = (self.levels.iter()).flat_map(|loa| tiers.clone().map(move |t| (*loa, *t)));
        let grid: Vec<(u8, usize)> = grid.collect();
        let mut cuts = vec![without_units(&coded)?];
        for (loa, tier) in &grid {
            cuts.push(kept(&coded, |unit| {
                unit.marker("loa").is_none_or(|l| l <= u32::from(*loa))
                    && unit.marker("tier").is_none_or(|t| t as usize >= *tier)
            })?);
        }
        for region in &self.regions {
            cuts.push(kept(&coded, |unit| {
                unit.marker("region") != Some(u32::from(*region))
            })?);
        }
        for finest in &self.face_levels {
            cuts.push(kept(&coded, |unit| {
                unit.marker("face_loa")
                    .is_none_or(|l| l <= u32::from(*finest))
            })?);
        }
        let (rig, name) = (&figure.asset.rig, figure.opened.name());
        let decoded = |bytes: &Vec<u8>| decode(bytes, rig, name, &Limits::default());
        let new: Vec<&Vec<u8>> = cuts
            .iter()
            .filter(|cut| !known.contains_key(*cut))
            .collect();
        let clips: Vec<Clip> = new.iter().map(|cut| decoded(cut)).collect::<Result<_>>()?;
        let errors = measured(&figure.asset, (truth, &self.frames), &clips, work)?;
        known.extend(new.into_iter().cloned().zip(errors));
        let errors: Vec<MotionError> = cuts.iter().map(|cut| known[cut]).collect();
        let (of_grid, without) = errors[1..].split_at(grid.len());
        let (of_regions, of_faces) = without.split_at(self.regions.len());

        let mut layers: Vec<ItemLayer> = Vec::with_capacity(grid.len());
        for (i, ((loa, tier), error)) in grid.iter().zip(of_grid).enumerate() {
            layers.push(ItemLayer {
                name: format!("loa {loa}, tier {tier}"),
                keep: keep(&[("loa", u32::from(*loa)), ("tier", *tier as u32)]),
                needs: needs(i, self.tiers.len()),
                error_m: error.max_metres,
                error_mean_m: Some(error.mean_metres),
                joints: Some(joints(figure, *loa)),
                ..ItemLayer::default()
            });
        }
        let (without_regions, without_faces) = cuts[1 + grid.len()..].split_at(self.regions.len());
        let without = without_regions.iter().zip(of_regions);
        let regions = region_entries(false, &self.regions, without);
        let face_levels = self.face_levels.into_iter();
        let face_levels = face_levels.zip(without_faces.iter().zip(of_faces));
        let face_levels = face_levels.map(|(finest, without)| RegionEntry {
            name: format!("face above level {finest}"),
            ..region_entry(finest, without)
        });
        let mut part = ItemPart {
            base_error_m: Some(errors[0].max_metres),
            duration_secs: Some(f64::from(truth.duration_secs())),
            rate_hz: Some(f64::from(truth.rate_hz())),
            frames_measured: Some(self.frames.len() as u64),
            layers,
            regions,
            face_levels: face_levels.collect(),
            ..ItemPart::new(&truth.name, PartKind::BodyMotion)
        };
        part.put_stream(file, coded.bytes, &coded.unit, files)?;
        Ok(part)
    }
}

/// Indices of the layers that the layer `i` of a motion needs: the next coarser level at its tier, and
/// its level one tier coarser. Layers are listed by level and, within it, by tier, coarsest first.
pub(super) fn needs(i: usize, tiers: usize) -> Vec<usize> {
    let coarser = (!i.is_multiple_of(tiers)).then(|| i - 1);
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
pub(super) fn kept(coded: &Cut, keeps: impl Fn(&Unit) -> bool) -> Result<Vec<u8>> {
    Ok(cut(&coded.bytes, &coded.unit, keeps).context("cut")?.bytes)
}

/// A stream without any unit of a tier.
pub(super) fn without_units(coded: &Cut) -> Result<Vec<u8>> {
    kept(coded, |unit| unit.marker("tier").is_none())
}

/// Markers by scheme.
pub(super) fn keep(markers: &[(&str, u32)]) -> BTreeMap<String, u32> {
    let owned = markers
        .iter()
        .map(|(scheme, value)| ((*scheme).to_owned(), *value));
    owned.collect()
}
