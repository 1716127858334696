//! Motions of the face of an item: AFP-2 streams by level and tier, with their errors on this head.

use super::files::NewFiles;
use super::motion_error::{MOST_FRAMES, measured, measured_frames};
use super::motion_part::{keep, kept, needs, region_entries, without_units};
use super::options::FaceMotion;
use super::part::{ItemLayer, ItemPart, PartKind};
use crate::clip_streams::afp2;
use crate::error::{Context, Result};
use crate::face::fit_face;
use crate::figure::Figure;
use crate::work::Executor;
use articula_build::{ClipOptions, sampled_clip};
use articula_core::Clip;
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::abp2::MotionHead;
use articula_stream::afp2::Afp2Options;
use articula_stream::{Cut, FaceReadOptions, StreamLimits};
use std::collections::BTreeSet;

/// Encodes a motion of the face, measures its cuts and adds its files under a name.
pub(super) fn part(
    figure: &Figure,
    motion: &FaceMotion,
    (stem, options): (&str, &Afp2Options),
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<ItemPart> {
    let made = afp2::write(&motion.clip, options).context(&motion.file)?;
    let coded = Cut {
        bytes: made.bytes,
        unit: made.unit,
    };
    let limits = StreamLimits::default();
    let head = MotionHead::open(&coded.bytes, &limits)?;
    let levels: BTreeSet<u8> = head.morph_groups.iter().map(|g| g.loa).collect();
    let regions: BTreeSet<u8> = head.morph_groups.iter().map(|g| g.region).collect();
    let grid = levels
        .iter()
        .flat_map(|loa| (0..head.tiers).rev().map(|tier| (*loa, tier)));
    let grid: Vec<(u8, usize)> = grid.collect();
    let mut cuts = vec![without_units(&coded)?];
    for (loa, tier) in &grid {
        cuts.push(kept(&coded, |unit| {
            unit.marker("face_loa").is_none_or(|l| l <= u32::from(*loa))
                && unit.marker("tier").is_none_or(|t| t as usize >= *tier)
        })?);
    }
    for region in &regions {
        let other =
            |unit: &articula_stream::Unit| unit.marker("face_region") != Some((*region).into());
        cuts.push(kept(&coded, other)?);
    }
    let shown = |bytes: &Vec<u8>| -> Result<Clip> {
        let read = afp2::read(bytes, &FaceReadOptions::default(), &limits)?;
        on_head(figure, &read, &motion.file)
    };
    let truth = on_head(figure, &motion.clip, &motion.file)?;
    let clips = work.map("showing faces", cuts.iter().collect(), shown)?;
    let frames = measured_frames(&truth, MOST_FRAMES);
    let errors = measured(&figure.asset, (&truth, &frames), &clips, work)?;
    let (of_grid, of_regions) = errors[1..].split_at(grid.len());
    let mut layers: Vec<ItemLayer> = Vec::with_capacity(grid.len());
    for (i, ((loa, tier), error)) in grid.iter().zip(of_grid).enumerate() {
        layers.push(ItemLayer {
            name: format!("face loa {loa}, tier {tier}"),
            keep: keep(&[("face_loa", u32::from(*loa)), ("tier", *tier as u32)]),
            needs: needs(i, head.tiers),
            error_m: error.max_metres,
            error_mean_m: Some(error.mean_metres),
            ..ItemLayer::default()
        });
    }
    let without = cuts[1 + grid.len()..].iter().zip(of_regions);
    let regions = region_entries(true, &regions, without);
    let file = format!("faces/{stem}.afp");
    let mut part = ItemPart {
        base_error_m: Some(errors[0].max_metres),
        duration_secs: Some(f64::from(truth.duration_secs())),
        rate_hz: Some(f64::from(head.rate_hz)),
        frames_measured: Some(frames.len() as u64),
        layers,
        regions,
        ..ItemPart::new(stem, PartKind::FaceMotion)
    };
    part.put_stream(&file, coded.bytes, &coded.unit, files)?;
    Ok(part)
}

/// A face motion as the clip that shows it on a figure.
fn on_head(figure: &Figure, clip: &FapClip, file: &str) -> Result<Clip> {
    let source = figure.opened.character();
    let fitted = fit_face(clip, file, &figure.opened)?.fitted.clip;
    let clip = sampled_clip(source, &fitted, &figure.asset.mesh, &ClipOptions::default());
    clip.context(file)
}
