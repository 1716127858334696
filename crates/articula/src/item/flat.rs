//! 2D forms of an item: an animated picture of the first packaged clip, and a still.

use super::files::NewFiles;
use super::manifest::FlatEntry;
use super::name::Names;
use super::options::PackageOptions;
use crate::error::Result;
use crate::figure::Figure;
use crate::flatten::{FramedCharacter, Shot, TriangleCount, flatten};
use crate::work::Executor;
use articula_core::{Clip, Viewport};
use articula_flat::flatten::{PrepareClipOptions, Profile, Quality, Settings};

/// Frames per second of the animated picture.
const FPS: f32 = 12.0;
/// Fewest triangles of a form.
const LEAST: usize = 600;
/// Intervals of a clip between the moments at which a still is compared with it.
const COMPARED: u32 = 32;

/// Makes the forms of a character with this clip, if any.
pub(super) fn entries(
    figure: &Figure,
    clip: Option<usize>,
    options: &PackageOptions,
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<Vec<FlatEntry>> {
    let still = Profile::Still {
        frame: 0,
        exact: false,
    };
    let mut forms = vec![(still, true)];
    if clip.is_some() {
        forms.insert(0, (Profile::Smil, false));
    }
    let mut names = Names::default();
    let mut entries = Vec::with_capacity(forms.len());
    for (profile, is_still) in forms {
        let shot = Shot {
            clip,
            still_at: is_still.then_some(0.0),
            cycles: 1,
            fps: FPS,
            yaw_deg: 0.0,
            pitch_deg: 0.0,
            turn_deg: 0.0,
            viewport: Viewport {
                width_px: options.flat_px as f32,
                height_px: options.flat_px as f32,
                ..options.viewport
            },
            triangles: TriangleCount::Judged { least: LEAST },
        };
        let of_clip = clip.map(|clip| figure.asset.clips[clip].name.clone());
        let title = of_clip.clone().unwrap_or_else(|| "still".to_owned());
        let framed = FramedCharacter::new(figure, shot, work)?;
        let settings = Settings {
            profile,
            quality: Quality::of(profile),
            name: title.clone(),
            max_bytes: None,
        };
        let made = flatten(&framed, PrepareClipOptions::default(), &settings, work)?;
        let shows = made.representation();
        let still_px = match clip.filter(|_| is_still) {
            Some(clip) => motion_px(&framed, &figure.asset.clips[clip])?,
            None => 0.0,
        };
        let wanted = if is_still { "still" } else { &title };
        let file = format!("2d/{}.svg", names.stem("2d", wanted, "moving"));
        entries.push(FlatEntry {
            modality: shows.modality,
            bytes: files.put(&file, made.bytes)?,
            file,
            error_px: shows.error_px + still_px,
            size_px: [options.flat_px; 2],
            clip: of_clip.filter(|_| !is_still),
            needs: shows.needs.iter().map(|need| (*need).to_owned()).collect(),
        });
    }
    Ok(entries)
}

/// The greatest distance on the screen of a point of a moving character from its place in the first
/// frame: what a still of that frame is off by.
fn motion_px(framed: &FramedCharacter<'_>, clip: &Clip) -> Result<f64> {
    let moment = |i| f64::from(clip.duration_secs()) * f64::from(i) / f64::from(COMPARED);
    let moments: Vec<f64> = (0..=COMPARED).map(moment).collect();
    let shown = framed.at(&moments)?;
    let Some((first, others)) = shown.frames.split_first() else {
        return Ok(0.0);
    };
    let apart = others
        .iter()
        .flat_map(|frame| frame.xy.iter().zip(&first.xy))
        .map(|(now, then)| f64::from(now.distance(*then)))
        .filter(|px| px.is_finite());
    Ok(apart.fold(0.0, f64::max))
}
