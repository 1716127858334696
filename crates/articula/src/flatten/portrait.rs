//! A head as a portrait, and how far it is from the figure.

use super::head::FramedHead;
use super::mouth::{DefaultMouth, TeethAndTongue};
use super::report::{FlatBytes, RepresentationReport};
use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::work::Executor;
use articula_core::Viewport;
use articula_flat::flatten::{FileSize, Representation};
use articula_flat::portrait::{HeadPose, Portrait, PortraitError, PortraitOptions, build};
use serde::Serialize;

/// Yaw angles of the head at which a portrait is compared with the figure, degrees.
const YAWS_DEG: [f32; 5] = [0.0, 10.0, 20.0, 30.0, 40.0];
/// Error above which eyes and mouths of a portrait fall apart, levels of 0 to 255. Heads that hold together
/// have 4 to 24, those whose eyes do not 36 and more.
const FALLEN_APART_LEVELS: f64 = 30.0;
/// Numbers of triangles that are tried before the greatest, and the error of the front picture with which one is taken,
/// levels of 0 to 255: hair and lips with more are ragged.
const FEWER: [usize; 2] = [1000, 2000];
const MOST: usize = 3000;
const GOOD_LEVELS: f64 = 12.0;

/// What a portrait shows, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct PortraitShot {
    /// Index of the clip that it plays; the head at rest without one.
    pub clip: Option<usize>,
    /// About how many triangles it has; as few as look like the figure if not given.
    pub triangles: Option<usize>,
    /// The picture.
    pub viewport: Viewport,
    /// Whether a head without teeth and tongue gets default ones.
    pub default_mouth: bool,
    /// Views, limits of the angles, and tolerance of positions.
    pub options: PortraitOptions,
}

/// Error of a portrait at one yaw angle of the head.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct YawError {
    /// Yaw of the head, degrees.
    pub yaw_deg: f32,
    /// Root mean square over the pixels of the figure, levels of 0 to 255.
    pub image_rmse_levels: f64,
}

/// Report on a portrait.
#[derive(Debug, Clone, Serialize)]
pub struct PortraitReport {
    /// Name of the file.
    pub out: String,
    /// "portrait".
    pub profile: &'static str,
    /// Bytes of all files.
    pub bytes: FlatBytes,
    /// Number of pictures of the head.
    pub views: usize,
    /// Number of triangles of the 2D mesh.
    pub triangles: usize,
    /// Number of its vertices.
    pub vertices: usize,
    /// Number of expressions.
    pub expressions: usize,
    /// Number of further inputs.
    pub inputs: usize,
    /// Number of frames of the clip; 0 without one.
    pub frames: usize,
    /// Where teeth and tongue are from.
    pub teeth_and_tongue: TeethAndTongue,
    /// Width and height, pixels.
    pub size_px: (u32, u32),
    /// Errors when the head turns.
    pub error: Vec<YawError>,
    /// The portrait as an encoding to choose from.
    pub representation: RepresentationReport,
    /// Files that were written.
    pub written: Vec<String>,
    /// What the program says about it.
    pub warnings: Vec<String>,
}

/// Makes the portrait of a head.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file and what cannot be shown, or
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub fn portrait<'a>(
    figure: &'a Figure,
    shot: &PortraitShot,
    work: &Executor<'_>,
) -> Result<(FramedHead<'a>, Portrait)> {
    let mouth = match shot.default_mouth {
        true => DefaultMouth::of(figure),
        false => Err(TeethAndTongue::LeftOut),
    };
    let with = |count: usize| -> Result<_> {
        let head = FramedHead::new(figure, shot.clip, count, shot.viewport)?.with_mouth(&mouth);
        let mut portrait = work.with_progress("making the portrait", |progress| {
            build(&head.source(), &shot.options, progress)
        })?;
        portrait.inputs = head.inputs();
        portrait.levels = head.levels();
        Ok((head, portrait))
    };
    let name = || figure.opened.name().to_owned();
    if let Some(count) = shot.triangles {
        return with(count).with_context(name);
    }
    for count in FEWER {
        let (head, portrait) = with(count).with_context(name)?;
        let front = turned_error(&portrait, &head, &shot.options, 0.0).with_context(name)?;
        if front.image_rmse_levels <= GOOD_LEVELS {
            return Ok((head, portrait));
        }
    }
    with(MOST).with_context(name)
}

/// Compares a portrait with the figure at 0 to 40 degrees of yaw.
///
/// # Errors
/// As [`portrait()`].
pub fn portrait_errors(
    portrait: &Portrait,
    head: &FramedHead<'_>,
    options: &PortraitOptions,
    work: &Executor<'_>,
) -> Result<Vec<YawError>> {
    let turned = YAWS_DEG.iter().enumerate().map(|(i, yaw_deg)| {
        work.step("comparing the portrait", i, YAWS_DEG.len())?;
        Ok(turned_error(portrait, head, options, *yaw_deg)?)
    });
    turned.collect()
}

/// The error of the portrait with its head turned.
fn turned_error(
    portrait: &Portrait,
    head: &FramedHead<'_>,
    options: &PortraitOptions,
    yaw_deg: f32,
) -> Result<YawError, PortraitError> {
    let pose = HeadPose {
        yaw_degrees: yaw_deg,
        ..HeadPose::default()
    };
    Ok(YawError {
        yaw_deg,
        image_rmse_levels: portrait.error(&head.source(), options, &pose, &[])?,
    })
}

impl PortraitReport {
    /// Describes a portrait as files, with its errors; a portrait far from the figure has a warning.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) if the files cannot be compressed.
    pub fn new(
        out: String,
        portrait: &Portrait,
        head: &FramedHead<'_>,
        files: &[(String, Vec<u8>)],
        error: Vec<YawError>,
        options: &PortraitOptions,
    ) -> Result<Self> {
        let all: Vec<u8> = files.iter().flat_map(|(_, bytes)| bytes).copied().collect();
        let sizes = FileSize::of(&all)?;
        let counts = portrait.counts();
        Ok(Self {
            out,
            profile: "portrait",
            bytes: FlatBytes {
                raw: sizes.raw,
                gzip: sizes.gzip,
                brotli: sizes.brotli,
            },
            views: counts.views,
            triangles: counts.triangles,
            vertices: counts.vertices,
            expressions: counts.expressions,
            inputs: portrait.inputs.len(),
            frames: portrait.clips.first().map_or(0, |c| c.poses.len()),
            teeth_and_tongue: head.teeth_and_tongue,
            size_px: portrait.size,
            representation: RepresentationReport::new(Representation {
                modality: "portrait".into(),
                bytes: sizes.raw,
                error_px: f64::from(options.tolerance_px),
                needs: vec!["script", "canvas", "webp"],
            }),
            written: files.iter().map(|(name, _)| name.clone()).collect(),
            warnings: fallen_apart(&error).into_iter().collect(),
            error,
        })
    }
}

/// A warning, if the portrait is far from the figure.
fn fallen_apart(errors: &[YawError]) -> Option<String> {
    let worst = errors
        .iter()
        .map(|e| e.image_rmse_levels)
        .fold(0.0, f64::max);
    (worst > FALLEN_APART_LEVELS).then(|| {
        format!(
            "the portrait is {worst:.0} levels from the figure (bound {FALLEN_APART_LEVELS}), so parts such as \
             the eyes may fall apart; give more --triangles, or show it in 3D"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_portrait_far_from_the_figure_is_told() {
        let at = |image_rmse_levels| YawError {
            yaw_deg: 0.0,
            image_rmse_levels,
        };
        assert_eq!(fallen_apart(&[at(3.9), at(24.3)]), None);
        let told = fallen_apart(&[at(3.9), at(41.6)]).unwrap();
        assert!(
            told.contains("42 levels") && told.contains("--triangles"),
            "{told}"
        );
    }
}
