//! 2D forms of an item: an animated picture of the first clip, and a still.

use super::files::NewFiles;
use super::manifest::FlatEntry;
use super::name::Names;
use super::options::PackageOptions;
use crate::error::Result;
use crate::figure::Figure;
use crate::flatten::{FramedCharacter, Shot, TriangleCount, flatten};
use crate::work::Executor;
use articula_core::Viewport;
use articula_flat::flatten::{PrepareClipOptions, Profile, Quality, Settings};

/// Frames per second of the animated picture.
const FPS: f32 = 12.0;
/// Fewest triangles of a form.
const LEAST: usize = 600;

/// Makes the forms of a character.
pub(super) fn entries(
    figure: &Figure,
    options: &PackageOptions,
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<Vec<FlatEntry>> {
    let clip = (!figure.asset.clips.is_empty()).then_some(0);
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
        let wanted = if is_still { "still" } else { &title };
        let file = format!("2d/{}.svg", names.stem("2d", wanted, "moving"));
        entries.push(FlatEntry {
            modality: shows.modality,
            bytes: files.put(&file, made.bytes)?,
            file,
            error_px: shows.error_px,
            size_px: [options.flat_px; 2],
            clip: of_clip.filter(|_| !is_still),
            needs: shows.needs.iter().map(|need| (*need).to_owned()).collect(),
        });
    }
    Ok(entries)
}
