//! 2D forms of an item: an animated picture of the first packaged clip, and a still, both small enough
//! to stand for a character that is too large to send.
//!
//! Both are seen by one camera, which has all of the clip in view.

use super::files::NewFiles;
use super::manifest::FlatEntry;
use super::name::Names;
use super::options::PackageOptions;
use super::sent::FileEntry;
use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::flatten::{FramedCharacter, Shot, TriangleCount, prepared};
use crate::work::Executor;
use articula_core::{Clip, Viewport};
use articula_flat::flatten::{PrepareClipOptions, PreparedClip, Profile, Quality, Settings};
use articula_flat::flatten::{Unmeasured, flatten_unmeasured};
use articula_flat::planar::Shading;

/// Frames per second of the animated picture, and most frames: a longer clip has fewer a second.
const FPS: f32 = 12.0;
const MOST_FRAMES: f32 = 96.0;
/// Triangles of a form, and the fewest.
const TRIANGLES: usize = 600;
const FEWEST: usize = 50;
/// Frames for which so many triangles are about small enough.
const FRAMES: usize = 60;
/// Intervals of a clip between the moments at which a still is compared with it.
const COMPARED: u32 = 32;
/// Most bytes of the animated picture and of the still as they are sent, compressed.
const MOST_MOVING: u64 = 25_000;
const MOST_STILL: u64 = 12_000;
/// Times that a form is made with less until it is small enough, and that the fewest triangles are made with
/// fewer frames.
const ATTEMPTS: usize = 5;
const FRAME_ATTEMPTS: usize = 2;
/// With fewer frames each of them moves farther, so that bytes fall more slowly: frames as a power of bytes.
const BYTES_TO_FRAMES: f64 = 1.5;
/// Compression is worse for a smaller file: a share that is aimed at.
const AIM: f64 = 0.95;
/// How many times as many bytes as allowed an animated picture may have before coarser tolerances.
const SAVED: f64 = 2.0;
/// The same of one that is made with a colour for each triangle at once.
const MUCH_TOO_LARGE: f64 = 8.0;

/// The forms, and what could not be made.
#[derive(Debug, Default)]
pub(super) struct Forms {
    pub(super) entries: Vec<FlatEntry>,
    pub(super) warnings: Vec<String>,
}

/// Makes the forms of a character with this clip, if any. A form that cannot be made is left out, with a
/// warning.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled), and names that two files of the item have.
pub(super) fn forms(
    figure: &Figure,
    clip: Option<usize>,
    options: &PackageOptions,
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<Forms> {
    let maker = Maker {
        figure,
        clip,
        options,
        work,
    };
    let mut forms = Forms::default();
    let framed = maker.framed();
    let made = framed.map(|framed| {
        let moving = clip.map(|_| maker.moving(&framed));
        (moving, maker.still(&framed))
    });
    let (moving, still) = match made {
        Ok((moving, still)) => (moving, still),
        Err(error) => (None, Err(error)),
    };
    let mut names = Names::default();
    for (made, what) in moving
        .map(|made| (made, "animated picture"))
        .into_iter()
        .chain([(still, "still")])
    {
        match made {
            Ok((entry, bytes)) => {
                let stem = names.stem("2d", entry.clip.as_deref().unwrap_or("still"), "moving");
                let file = format!("2d/{stem}.svg");
                forms.entries.push(FlatEntry {
                    bytes: files.put(&file, bytes)?,
                    file,
                    ..entry
                });
            }
            Err(error) if error.is_cancelled() => return Err(error),
            Err(error) => forms.warnings.push(format!("2D: no {what}: {error}")),
        }
    }
    Ok(forms)
}

/// An entry without the name of its file, and the bytes of the file.
type Form = (FlatEntry, Vec<u8>);

/// A form, its bytes as sent, and what it shows.
struct Made<'a> {
    form: Unmeasured,
    sent: u64,
    framed: FramedCharacter<'a>,
}

/// What all forms are made from.
struct Maker<'a> {
    figure: &'a Figure,
    clip: Option<usize>,
    options: &'a PackageOptions,
    work: &'a Executor<'a>,
}

impl<'a> Maker<'a> {
    /// The character, seen by a camera that has all of the clip in view.
    fn framed(&self) -> Result<FramedCharacter<'a>> {
        let secs = self.of_clip().map_or(0.0, Clip::duration_secs);
        let shot = Shot {
            clip: self.clip,
            fps: FPS.min(MOST_FRAMES / secs.max(1.0)),
            viewport: Viewport {
                width_px: self.options.flat_px as f32,
                height_px: self.options.flat_px as f32,
                ..self.options.viewport
            },
            triangles: TriangleCount::About(TRIANGLES),
            ..Shot::default()
        };
        FramedCharacter::new(self.figure, shot, self.work)
    }

    fn moving(&self, framed: &FramedCharacter<'a>) -> Result<Form> {
        let frames = framed.frame_times_secs.len();
        let mut made = match frames > FRAMES {
            true => self.least(framed.with_triangles(FEWEST)?)?,
            false => self.within(framed.clone(), Profile::Smil, MOST_MOVING)?,
        };
        if frames > FRAMES && made.sent <= MOST_MOVING {
            // Bytes are about in proportion to triangles and frames.
            let first = framed.with_triangles((TRIANGLES * FRAMES / frames).max(FEWEST))?;
            made = self.within(first, Profile::Smil, MOST_MOVING)?;
        }
        for _ in 0..FRAME_ATTEMPTS {
            if made.sent <= MOST_MOVING {
                break;
            }
            let share = AIM * MOST_MOVING as f64 / made.sent as f64;
            let fps = made.framed.options.fps * share.powf(BYTES_TO_FRAMES) as f32;
            let slower = made.framed.with_rate(fps)?;
            made = self.least(match slower.count() {
                Some(FEWEST) => slower,
                _ => slower.with_triangles(FEWEST)?,
            })?;
        }
        let clip = self.of_clip().map(|clip| clip.name.clone());
        let between = between_px(&made.framed)?;
        Ok(self.entry(made.form, clip, between))
    }

    fn still(&self, framed: &FramedCharacter<'a>) -> Result<Form> {
        let profile = Profile::Still {
            frame: 0,
            exact: false,
        };
        let moved = self.of_clip().map(|clip| motion_px(framed, clip));
        let made = self.within(framed.still(0.0), profile, MOST_STILL)?;
        Ok(self.entry(made.form, None, moved.transpose()?.unwrap_or(0.0)))
    }

    fn of_clip(&self) -> Option<&'a Clip> {
        self.clip.map(|clip| &self.figure.asset.clips[clip])
    }

    /// An animated form of the fewest bytes that these triangles and frames have.
    fn least(&self, framed: FramedCharacter<'a>) -> Result<Made<'a>> {
        let clip = prepared(&framed, &PrepareClipOptions::default(), self.work)?;
        let settings = Settings {
            quality: Quality::coarsest(Profile::Smil),
            ..self.settings(Profile::Smil)
        };
        let (form, sent) = self.flat(&clip, &settings)?;
        Ok(Made { form, sent, framed })
    }

    fn settings(&self, profile: Profile) -> Settings {
        Settings {
            profile,
            quality: Quality::of(profile),
            name: self.of_clip().map_or("still", |clip| &clip.name).to_owned(),
            max_bytes: None,
        }
    }

    /// A form, and its bytes as sent.
    fn flat(&self, clip: &PreparedClip, settings: &Settings) -> Result<(Unmeasured, u64)> {
        let made = self
            .work
            .with_progress("writing", |p| flatten_unmeasured(clip, settings, p));
        let made = made.with_context(|| self.figure.opened.name())?;
        let sent = FileEntry::of("form.svg", &made.bytes).sent_bytes();
        Ok((made, sent))
    }

    /// A form whose bytes as sent are at most these, or the smallest that was found: with fewer
    /// triangles and coarser tolerances from attempt to attempt.
    fn within(
        &self,
        mut framed: FramedCharacter<'a>,
        profile: Profile,
        most: u64,
    ) -> Result<Made<'a>> {
        let mut settings = self.settings(profile);
        let ready = |framed: &FramedCharacter<'a>| {
            prepared(framed, &PrepareClipOptions::default(), self.work)
        };
        let mut clip = ready(&framed)?;
        let (mut best, mut sent) = self.flat(&clip, &settings)?;
        let mut of_best = framed.clone();
        let (mut raw, mut drawn) = (best.bytes.len(), best.triangles_drawn);
        // Coarser tolerances save about a half at first, fewer triangles the rest.
        let mut saved = if best.frames > 1 { SAVED } else { 1.0 };
        if best.frames > 1 && sent as f64 > MUCH_TOO_LARGE * most as f64 {
            settings.quality.shading = Shading::Flat;
        }
        // Whether the coarsest tolerances were tried on these triangles.
        let mut is_coarsest = false;
        for _ in 0..ATTEMPTS {
            let share = AIM * most as f64 / sent.max(1) as f64;
            if sent <= most {
                break;
            }
            let allowed = (share * best.bytes.len().min(raw) as f64) as u64;
            settings.max_bytes = Some(allowed);
            let wanted = (drawn as f64 * (share * saved).min(1.0)) as usize;
            saved = 1.0;
            let fewer = framed.with_triangles(wanted.max(FEWEST))?;
            if fewer.triangles != framed.triangles {
                clip = ready(&fewer)?;
            } else if is_coarsest {
                break;
            }
            framed = fewer;
            let (made, of_made) = self.flat(&clip, &settings)?;
            (raw, drawn) = (made.bytes.len(), made.triangles_drawn);
            is_coarsest = raw as u64 > allowed;
            if of_made < sent {
                (best, sent) = (made, of_made);
                of_best = framed.clone();
            }
        }
        Ok(Made {
            form: best,
            sent,
            framed: of_best,
        })
    }

    fn entry(&self, made: Unmeasured, clip: Option<String>, moved_px: f64) -> Form {
        let shows = made.representation;
        let entry = FlatEntry {
            modality: shows.modality,
            file: String::new(),
            bytes: 0,
            error_px: shows.error_px + moved_px,
            size_px: [self.options.flat_px; 2],
            clip,
            needs: shows.needs.iter().map(|need| (*need).to_owned()).collect(),
        };
        (entry, made.bytes)
    }
}

/// The root mean square distance on the screen of points, halfway between two frames, from the middle of their
/// places in both: what an animated picture is off by there.
fn between_px(framed: &FramedCharacter<'_>) -> Result<f64> {
    let pairs = framed.frame_times_secs.windows(2);
    let some = pairs.len().div_ceil(COMPARED as usize).max(1);
    let moments = pairs
        .step_by(some)
        .flat_map(|pair| [pair[0], (pair[0] + pair[1]) / 2.0, pair[1]]);
    let shown = framed.at(&moments.collect::<Vec<f64>>())?;
    let (mut sum, mut count) = (0.0, 0);
    for frames in shown.frames.chunks_exact(3) {
        let both = frames[0].xy.iter().zip(&frames[2].xy);
        for (middle, (before, after)) in frames[1].xy.iter().zip(both) {
            let squared = f64::from(middle.distance_squared((*before + *after) / 2.0));
            if squared.is_finite() {
                (sum, count) = (sum + squared, count + 1);
            }
        }
    }
    Ok((sum / f64::from(count.max(1))).sqrt())
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
