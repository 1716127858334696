//! Sizes and costs of levels: tables 6.1, 6.2 and 6.4 of the thesis for the items.

use super::cases::Packaged;
use crate::measure::median;
use anyhow::{Context, Result};
use articula::item::{ItemPart, PartKind, assemble};
use articula::{Figure, OpenOptions};
use articula_core::{PosedMesh, Wrap};
use articula_report::thread_ns;
use std::fmt::Write as _;
use std::hint::black_box;

/// Rounds of the timings; the median counts.
const ROUNDS: usize = 9;
/// Frames of a round.
const FRAMES: usize = 600;

pub(super) fn write(items: &[Packaged], page: &mut String) -> Result<()> {
    page.push_str(ITEMS);
    for packaged in items {
        let manifest = &packaged.item.manifest;
        let bytes = |kind: PartKind| -> u64 {
            let parts = manifest.parts.iter().filter(|part| part.kind == kind);
            parts.map(|part| part.bytes).sum()
        };
        writeln!(
            page,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            packaged.case.name,
            packaged.source_bytes,
            packaged.item.sent_bytes_of_layers(),
            manifest.sent_bytes(&manifest.figure.file),
            bytes(PartKind::Mesh),
            bytes(PartKind::BodyMotion),
            bytes(PartKind::FaceMotion),
            bytes(PartKind::Texture),
            packaged.item.index_bytes(),
        )?;
    }
    meshes(items, page)?;
    faces(items, page)?;
    bodies(items, page)
}

/// Table 6.1: sizes of mesh levels.
fn meshes(items: &[Packaged], page: &mut String) -> Result<()> {
    page.push_str(MESHES);
    for packaged in items {
        let parts = packaged.item.manifest.parts.iter();
        for part in parts.filter(|part| part.kind == PartKind::Mesh) {
            for level in &part.levels {
                writeln!(
                    page,
                    "| {} | {} | {} | {} | {} | {:.2} | {:.2} |",
                    packaged.case.name,
                    level.level,
                    level.triangles,
                    level.vertices,
                    level.bytes,
                    1e3 * level.error_motion_m,
                    1e3 * level.error_motion_p95_m,
                )?;
            }
        }
    }
    Ok(())
}

/// Table 6.2: sizes of face motions by level.
fn faces(items: &[Packaged], page: &mut String) -> Result<()> {
    page.push_str(FACES);
    for packaged in items {
        let parts = packaged.item.manifest.parts.iter();
        for part in parts.filter(|part| part.kind == PartKind::FaceMotion) {
            rows(packaged, part, "face_loa", page)?;
        }
    }
    Ok(())
}

/// The layers of a motion at its finest tier.
fn rows(packaged: &Packaged, part: &ItemPart, scheme: &str, page: &mut String) -> Result<()> {
    for (i, layer) in part.layers.iter().enumerate() {
        if layer.keep.get("tier").is_some_and(|tier| *tier > 0) {
            continue;
        }
        let bytes = part.bytes_of(&part.closure(&[i]));
        writeln!(
            page,
            "| {} | {} | {} | {:.1} % | {:.2} |",
            packaged.case.name,
            layer.keep.get(scheme).copied().unwrap_or(0),
            bytes,
            100.0 * bytes as f64 / part.bytes as f64,
            1e3 * layer.error_m,
        )?;
    }
    Ok(())
}

/// Table 6.4: joints, time and memory of body motions by level.
fn bodies(items: &[Packaged], page: &mut String) -> Result<()> {
    page.push_str(BODIES);
    for packaged in items {
        let parts = &packaged.item.manifest.parts;
        let Some(part) = parts.iter().find(|part| part.kind == PartKind::BodyMotion) else {
            continue;
        };
        let mut last = 0;
        for (i, layer) in part.layers.iter().enumerate() {
            let kept = part.closure(&[i]);
            let bytes = part.bytes_of(&kept);
            // Levels that add nothing are not listed again.
            if layer.keep.get("tier").is_some_and(|tier| *tier > 0) || bytes == last {
                continue;
            }
            last = bytes;
            let cut = packaged.item.kept(|p, l| {
                if p.kind == PartKind::BodyMotion && p.name == part.name {
                    kept[l]
                } else {
                    true
                }
            })?;
            let shown = Figure::new(assemble(&cut, &OpenOptions::default())?)?;
            let clip = shown.clip(Some(&part.name))?.context("the clip is gone")?;
            let tracks = shown.asset.clips[clip].tracks();
            let moving = tracks.rotations.iter().filter(|t| t.values.len() > 1);
            let kilobytes = memory(&shown, clip) as f64 / 1e3;
            writeln!(
                page,
                "| {} | {} | {} | {} | {} | {:.2} | {:.1} | {:.1} |",
                packaged.case.name,
                layer.keep.get("loa").copied().unwrap_or(0),
                layer.joints.unwrap_or(0),
                moving.count(),
                bytes,
                1e3 * layer.error_m,
                pose_us(&shown, clip),
                kilobytes,
            )?;
        }
    }
    Ok(())
}

/// Bytes of the decoded tracks of a clip.
fn memory(figure: &Figure, clip: usize) -> usize {
    let tracks = figure.asset.clips[clip].tracks();
    let rotations: usize = tracks.rotations.iter().map(|t| 16 * t.values.len()).sum();
    let vectors = tracks.translations.iter().chain(&tracks.scales);
    rotations + vectors.map(|t| 12 * t.values.len()).sum::<usize>()
}

/// Microseconds of processor time for one pose of a clip: sampling and hierarchy.
fn pose_us(figure: &Figure, clip: usize) -> f64 {
    let clip = &figure.asset.clips[clip];
    let mut posed = PosedMesh::new(&figure.asset.rig, &figure.asset.mesh);
    let step = f64::from(clip.duration_secs()) / FRAMES as f64;
    let mut times = Vec::with_capacity(ROUNDS);
    for _ in 0..ROUNDS {
        let start = thread_ns();
        for frame in 0..FRAMES {
            black_box(posed.pose_at(clip, frame as f64 * step, Wrap::Loop));
        }
        times.push((thread_ns() - start) as f64 / FRAMES as f64);
    }
    1e-3 * median(&mut times)
}

const ITEMS: &str = "
## Items

Bytes as sent. *Item*: all that is sent for 3D, without manifest, unit indices and forms in 2D. *Index*: the unit indices, which a server
keeps. The figure has joints, skins, materials and the names of morph targets.

| item | source file | item | figure | meshes | motions | faces | textures | index |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const MESHES: &str = "
## Mesh levels (table 6.1 of the thesis)

Bytes of the stream that ends with a level, head included, and the error in motion: the greatest distance of the original surface
from the level, and its 95th percentile, mm. A level chosen for each region costs what its chunks add. Beside discrete levels and
Draco: [mesh levels](mesh-levels.md).

| item | level | triangles | vertices | bytes | mm | p95, mm |
| --- | --- | --- | --- | --- | --- | --- |
";

const FACES: &str = "
## Faces by level (tables 6.2 and 6.3)

A stream of facial parameters (AFP-2) cut to each level of articulation, 0 very low to 3 high, at its finest tier, with the error on this
head. The thesis has 77.4, 62.6 and 54.4 % for medium, low and very low. More clips: [motion streams](streams.md); processing times:
[face levels](face-levels.md).

| item | level | bytes | of all | mm |
| --- | --- | --- | --- | --- |
";

const BODIES: &str = "
## Bodies by level (table 6.4)

The first motion cut to each level of articulation at its finest tier. *Joints*: of this level or below. *Moving*: joints that the
stream moves. *Time*: of one pose, sampling and hierarchy, in microseconds; joints that do not move save sampling alone. *Memory*: of
the decoded tracks. The thesis shows frame rates and memory of a whole player, whose numbers are lost in the scan.

| item | level | joints | moving | bytes | error, mm | time, us | memory, kB |
| --- | --- | --- | --- | --- | --- | --- | --- |
";
