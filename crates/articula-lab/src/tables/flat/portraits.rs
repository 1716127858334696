//! Portraits: error of a turned 2D head against the turned figure, by its number of views.
//!
//! Source: `docs/methods/vector.md` part 10.

use super::super::Run;
use super::cases::before;
use anyhow::{Context, Result};
use articula::Figure;
use articula_build::Asset;
use articula_build::decimate;
use articula_core::Progress;
use articula_flat::Appearance;
use articula_flat::Bounds;
use articula_flat::planar::{PlanarSubject, Turntable};
use articula_flat::portrait::PictureFormat;
use articula_flat::portrait::{
    Head, HeadPose, PortraitExpression, PortraitOptions, PortraitSource, build,
};

/// Yaw angles at which the portrait is compared, degrees.
pub(super) const YAWS_DEGREES: [f32; 5] = [0.0, 10.0, 20.0, 30.0, 40.0];
/// A portrait.
pub(super) struct Row {
    pub(super) head: &'static str,
    pub(super) triangles: usize,
    pub(super) views: usize,
    /// Bytes of the document and of its pictures.
    pub(super) document: usize,
    pub(super) pictures: usize,
    /// Colour RMSE at each yaw angle, in levels of 0 to 255.
    pub(super) rmse_levels: Vec<f64>,
}

/// A head, and the number of triangles of its 2D mesh; all triangles if `None`.
struct Sitter {
    name: &'static str,
    file: &'static str,
    triangles: Option<usize>,
}

/// The heads; the first is that of a small run. A 2D mesh as fine as the head has the head's
/// outline; a coarser one is compared with an outline that it cannot have.
const SITTERS: [Sitter; 4] = [
    Sitter {
        name: "ICT head of 554",
        file: "glb/ict_head_talk_554.glb",
        triangles: None,
    },
    Sitter {
        name: "ICT head of 1095",
        file: "glb/ict_head_talk_1095.glb",
        triangles: None,
    },
    Sitter {
        name: "ICT head of 554, the thesis' phone",
        file: "glb/ict_head_talk_554.glb",
        triangles: Some(94),
    },
    Sitter {
        name: "ICT face of 52,220",
        file: "face/ict_facekit_expressions.glb",
        triangles: Some(1000),
    },
];

/// All portraits.
pub(super) fn rows(run: &Run) -> Result<Vec<Row>> {
    let views: &[usize] = if run.small { &[3] } else { &[1, 3, 5] };
    let count = if run.small { 1 } else { SITTERS.len() };
    let mut rows = Vec::new();
    for sitter in &SITTERS[..count] {
        rows.extend(of(run, sitter, views)?);
    }
    Ok(rows)
}

fn of(run: &Run, sitter: &Sitter, views: &[usize]) -> Result<Vec<Row>> {
    let figure = Figure::new(articula::fs::open(run.data.join(sitter.file))?)?;
    let (source, asset) = (figure.opened.character(), &figure.asset);
    let (appearance, _) = Appearance::new(&source.materials, &source.images);
    let mut expressions = Vec::new();
    for (mesh, first) in source.meshes.iter().zip(&asset.mesh.morph_slots) {
        let names = mesh.morph_names.iter().enumerate();
        let of = |(t, name): (usize, &String)| {
            PortraitExpression::of_morph(name.clone(), (first + t) as u16)
        };
        expressions.extend(names.map(of));
    }
    let bounds = at_rest(asset, &appearance)?;
    let keep = vec![true; asset.mesh.triangles.len()];
    let triangles = match sitter.triangles {
        None => asset.mesh.triangles.clone(),
        Some(count) => decimate(asset, &keep, None, count, &[])?,
    };
    let source = PortraitSource {
        mesh: &asset.mesh,
        rig: &asset.rig,
        appearance: &appearance,
        triangles: &triangles,
        head: Head::Whole {
            pivot: bounds.middle(),
        },
        expressions: &expressions,
        clips: &[],
        camera: before(&bounds),
    };
    let row = |views: &usize| row(&source, sitter.name, *views);
    views.iter().map(row).collect()
}

fn row(source: &PortraitSource<'_>, head: &'static str, views: usize) -> Result<Row> {
    let options = PortraitOptions {
        views,
        ..PortraitOptions::default()
    };
    let portrait = build(source, &options, &mut Progress::none())?;
    let files = portrait.to_files(PictureFormat::WebP)?;
    let size = |ending: &str| -> usize {
        let of = files.iter().filter(|(name, _)| name.ends_with(ending));
        of.map(|(_, bytes)| bytes.len()).sum()
    };
    let off = |yaw: &f32| {
        let pose = HeadPose {
            yaw_degrees: *yaw,
            ..HeadPose::default()
        };
        portrait.error(source, &options, &pose, &[])
    };
    let rmse_levels: Result<Vec<f64>, _> = YAWS_DEGREES.iter().map(off).collect();
    Ok(Row {
        head,
        triangles: portrait.counts().triangles,
        views,
        document: size(".json"),
        pictures: size(".webp"),
        rmse_levels: rmse_levels?,
    })
}

fn at_rest(asset: &Asset, appearance: &Appearance) -> Result<Bounds> {
    let subject = PlanarSubject {
        rig: &asset.rig,
        mesh: &asset.mesh,
        triangles: &asset.mesh.triangles,
        appearance,
        clip: None,
        morph_weights: &asset.mesh.morph_weights,
    };
    subject
        .bounds(&[0.0], &Turntable::default())
        .context("the head has no vertex")
}
