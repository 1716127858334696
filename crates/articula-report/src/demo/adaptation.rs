//! The section of the demo about adaptation: one item, four contexts.

use super::files::DemoFiles;
use crate::artist::Artist;
use crate::contact_sheet::{ContactSheet, SheetCell, SheetRow};
use articula::core::{Wrap, sample, sample_morphs};
use articula::evaluate::EvaluatedClip;
use articula::flat::vector::{AnimatedSvg, raster};
use articula::flat::{Picture, PictureError};
use articula::item::{
    AdaptOptions, AdaptedItem, Item, PackageOptions, adapt, assemble, decide, package,
};
use articula::stream::description::Context;
use articula::{Error, Executor, Figure, OpenOptions, Result};
use serde::Serialize;

/// Size of a picture in pixels.
const SIZE: (u32, u32) = (230, 300);
/// Time to transfer the item in seconds.
const WAIT_SECS: f64 = 2.0;
/// Background of a form in 2D.
const PAPER: [u8; 4] = [255; 4];

/// What was sent in all contexts.
#[derive(Debug, Serialize)]
pub(super) struct Adapted {
    /// Bytes of the item, without forms in 2D.
    pub(super) bytes: u64,
    /// The contexts.
    pub(super) contexts: Vec<InContext>,
}

/// What was sent in one context.
#[derive(Debug, Serialize)]
pub(super) struct InContext {
    pub(super) name: &'static str,
    /// Bandwidth in kilobits per second; null if nothing bounds it.
    pub(super) bandwidth_kbps: Option<f64>,
    pub(super) distance_m: f64,
    /// `3d`, or the kind of the form in 2D.
    pub(super) modality: String,
    pub(super) bytes: u64,
    /// Bound of the error on the screen.
    pub(super) error_px: f64,
    /// Option of each part.
    pub(super) parts: Vec<String>,
    /// What keeps the error from being smaller.
    pub(super) bounds: Vec<String>,
}

/// Packages the character with its clip, adapts the item and draws what is shown.
pub(super) fn of(
    files: &mut DemoFiles,
    scene: &EvaluatedClip<'_>,
    work: &Executor<'_>,
) -> Result<Adapted> {
    let clip = scene.figure.asset.clips[scene.clip].name.clone();
    let options = PackageOptions {
        clips: vec![clip],
        ..PackageOptions::default()
    };
    let opened = scene.figure.opened.clone();
    let item = package(opened, &options, work)?;
    let whole = item.sent_bytes_of_layers();
    // For the joints, and half of the rest.
    let half = 0.5 * (whole + item.manifest.sent_bytes(&item.manifest.figure.file)) as f64;
    let half_kbps = 8e-3 * half / WAIT_SECS;
    let of_pictures: Vec<String> = item
        .manifest
        .flat
        .iter()
        .flat_map(|f| f.needs.clone())
        .collect();
    let contexts = [
        ("a desktop, near", None, 2.0, &[][..]),
        ("a phone", Some(half_kbps), 3.0, &[]),
        ("far away in a street", None, 40.0, &[]),
        ("a page of pictures", None, 3.0, &of_pictures),
    ];
    let mut found = Vec::new();
    let mut cells = Vec::new();
    for (name, bandwidth_kbps, distance_m, codecs) in contexts {
        let mut context = Context::default();
        context.network.available_bps = bandwidth_kbps.map(|kbps| 1e3 * kbps);
        context.view.distance_m = Some(distance_m);
        context.terminal.codecs = codecs.to_vec();
        let options = AdaptOptions {
            wait_secs: WAIT_SECS,
            ..AdaptOptions::default()
        };
        let decided = decide(&item, &context, &options)?;
        let Some(cut) = &decided.cut else { continue };
        let adapted = adapt(&item, cut)?;
        let decision = &decided.decision;
        let parts = decision.parts.iter();
        let label = format!("{name}: {:.1} kB", adapted.sent_bytes() as f64 / 1e3);
        cells.push(SheetCell::of(drawn(&adapted)?, label));
        found.push(InContext {
            name,
            bandwidth_kbps,
            distance_m,
            modality: decision.modality.clone(),
            bytes: adapted.sent_bytes(),
            error_px: decision.error_px,
            parts: parts
                .map(|p| format!("{}: {}", p.name, p.option_name))
                .collect(),
            bounds: decision.bounds.iter().map(ToString::to_string).collect(),
        });
    }
    let sheet = ContactSheet {
        title: "One item in four contexts".into(),
        rows: vec![SheetRow {
            label: String::new(),
            cells,
        }],
        ..ContactSheet::default()
    };
    files.add_png("adaptation.png", &sheet.draw()?)?;
    Ok(Adapted {
        bytes: whole,
        contexts: found,
    })
}

/// What a client shows.
fn drawn(adapted: &AdaptedItem) -> Result<Picture> {
    match adapted {
        AdaptedItem::Layers(item) => figure(item),
        AdaptedItem::Flat { entry, files, .. } => {
            let of_entry = files.iter().find(|(name, _)| *name == entry.file);
            let text = of_entry.and_then(|(_, bytes)| std::str::from_utf8(bytes).ok());
            let text = text.ok_or_else(|| {
                let what = "the form in 2D is missing or is no text";
                Error::Unsupported(what.to_owned())
            })?;
            let moving = AnimatedSvg::read(text)?;
            let still = moving.at(moving.duration_secs / 4.0)?;
            let picture = raster(&still, PAPER)?;
            Ok(fitted(&picture)?)
        }
    }
}

/// A picture reduced to fit into the size of a picture, in its own proportions.
fn fitted(picture: &Picture) -> Result<Picture, PictureError> {
    let [width, height] = [picture.width(), picture.height()].map(f64::from);
    let fits = (f64::from(SIZE.0) / width).min(f64::from(SIZE.1) / height);
    // Smaller ones are not enlarged.
    let scale = fits.min(1.0);
    let size = [width, height].map(|v| ((scale * v).round() as u32).max(1));
    let small = picture.resized((size[0], size[1]), articula::flat::Averaging::Light)?;
    let mut page = Picture::new(SIZE.0, SIZE.1, PAPER)?;
    let left = SIZE.0.saturating_sub(size[0]) / 2;
    let top = SIZE.1.saturating_sub(size[1]) / 2;
    page.blit(&small, left as i32, top as i32);
    Ok(page)
}

fn figure(item: &Item) -> Result<Picture> {
    let figure = Figure::new(assemble(item, &OpenOptions::default())?)?;
    let asset = &figure.asset;
    let mut pose = asset.rig.rest_pose().clone();
    let mut morphs = asset.mesh.morph_weights.clone();
    if let Some(clip) = asset.clips.first() {
        let secs = f64::from(clip.duration_secs()) / 4.0;
        sample(clip, secs, Wrap::Clamp, &asset.rig.all(), &mut pose);
        sample_morphs(clip, secs, Wrap::Clamp, &mut morphs);
    }
    let mut artist = Artist::of_figure(&figure, SIZE);
    artist.frame_pose(&pose, &morphs);
    Ok(artist.figure(&pose, morphs.clone())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_in_2d_keeps_its_proportions() {
        let ink = [10, 20, 30, 255];
        for (width, height) in [(460, 300), (100, 300), (115, 150)] {
            let page = fitted(&Picture::new(width, height, ink).unwrap()).unwrap();
            assert_eq!((page.width(), page.height()), SIZE);
            let count = |across: bool| {
                let places = if across { SIZE.0 } else { SIZE.1 };
                let at = |i| match across {
                    true => page.get(i, SIZE.1 / 2),
                    false => page.get(SIZE.0 / 2, i),
                };
                (0..places).filter(|i| at(*i) != Some(PAPER)).count() as f64
            };
            let wanted = f64::from(width) / f64::from(height);
            let found = count(true) / count(false);
            assert!((found / wanted - 1.0).abs() < 0.02, "{found}, not {wanted}");
        }
    }
}
