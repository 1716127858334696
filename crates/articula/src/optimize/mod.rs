//! A character file in fewer bytes, at an error in motion that is measured on the written file.
//!
//! - `source`: the character before anything is rounded, and files that are written of it
//! - `clip`, `optimized_clip`: fewer keys and rounded values for one clip
//! - `report`: what was saved, and the errors
//!
//! Source: ours; `docs/methods/optimize.md`.

mod clip;
mod optimized_clip;
mod report;
mod source;

pub use articula_formats::gltf::{BytesByKind, Compression};
pub use report::{ClipOptimized, OptimizeReport};

use crate::error::{Context, Error, Result};
use crate::open::CharacterFile;
use crate::work::Executor;
use articula_build::greatest_vertex_error;
use clip::Subject;
use optimized_clip::OptimizedClip;
use source::{MeshPrecision, Source};

/// Greatest error in motion that is allowed, of any vertex at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ErrorBound {
    /// In metres of the character.
    Metres(f32),
    /// In pixels of a picture that the character at rest fills from top to bottom.
    Pixels {
        /// The error in pixels.
        px: f32,
        /// Height of the picture in pixels.
        height_px: f32,
    },
}

/// Options of [`optimize`].
#[derive(Debug, Clone, PartialEq)]
pub struct OptimizeOptions {
    /// Greatest error in motion. The default is one pixel of 720.
    pub error: ErrorBound,
    /// Extension that holds compressed arrays.
    pub compression: Compression,
    /// Whether keys are left out; otherwise values are rounded alone.
    pub reduce_keys: bool,
    /// Whether texture coordinates and tangents stay that no material of the file uses, since an engine
    /// may have materials of its own.
    pub keep_attributes: bool,
    /// Seed of the times at which the error is measured, besides key times and their middles.
    pub seed: u64,
}

impl Default for OptimizeOptions {
    fn default() -> Self {
        Self {
            error: ErrorBound::Pixels {
                px: 1.0,
                height_px: 720.0,
            },
            compression: Compression::default(),
            reduce_keys: true,
            keep_attributes: false,
            seed: 1,
        }
    }
}

/// A file in fewer bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimized {
    /// The file, a GLB; a VRM file if the source is one.
    pub glb: Vec<u8>,
    /// What was saved, and the errors measured.
    pub report: OptimizeReport,
}

/// Number of times that a file is written more exactly where its error exceeds the bound.
const ROUNDS: usize = 8;
/// Number of times that meshes are rounded more finely.
const ROUNDS_OF_MESHES: usize = 4;
/// Rounds after which clips that still exceed it keep all their keys, and the share of the bound below
/// which they do at once.
const ROUNDS_OF_CLIPS: usize = 5;
const LEAST_SHARE: f32 = 1e-3;

/// Writes a character in fewer bytes.
///
/// Keys that are not missed are left out, values are rounded as far as the lever of their joint allows,
/// vertices are put into an order that compresses, attributes that no material uses are left out, and
/// arrays are compressed. Key times are those of the file: nothing is resampled.
///
/// The error in motion is measured on the bytes that are returned: they are read as any file is, and every
/// vertex is posed beside the source at all key times of each clip, the middles between them (at most
/// 1500) and random times. The farthest vertex stays within the bound.
///
/// All else of a glTF document is kept: names, extras, VRM and other extensions, hierarchy, materials,
/// skins, pictures. Prepared data and motion tables, which belong to the arrays as they were, are left
/// out. A document with an extension that may refer to arrays, and is not known, keeps all its arrays.
/// A file that was compressed before can become larger, as [`OptimizeReport::bytes_out`] tells.
///
/// # Errors
/// [`Error::Argument`] if the bound is not positive; [`Error::Unsupported`] if it is finer than 24-bit
/// numbers can keep; otherwise an [`Error`] that names the file and the cause. [`Error::Cancelled`] if the
/// caller stops the work.
pub fn optimize(
    opened: &CharacterFile,
    options: &OptimizeOptions,
    work: &Executor<'_>,
) -> Result<Optimized> {
    optimized(opened, options, work).with_context(|| opened.name())
}

fn optimized(
    opened: &CharacterFile,
    options: &OptimizeOptions,
    work: &Executor<'_>,
) -> Result<Optimized> {
    let (before, source) = Source::of(opened, options)?;
    let bound = bound_metres(&source, options.error)?;
    let mut precision = MeshPrecision::of(&source, bound);
    let mut mesh = source.with_rounded_mesh(&precision)?;
    let most = MeshPrecision::most(&source);
    for _ in 0..ROUNDS_OF_MESHES {
        if Errors::measured(&source, &mesh, options, work)?.greatest() <= most * bound {
            break;
        }
        precision = precision.finer();
        mesh = source.with_rounded_mesh(&precision)?;
    }
    let mut clips: Vec<Option<OptimizedClip>> = vec![None; source.character.clips.len()];
    let mut allowed = vec![bound; clips.len()];
    for round in 0..ROUNDS {
        let open: Vec<usize> = (0..clips.len()).filter(|c| clips[*c].is_none()).collect();
        let subject = Subject::new(&source, &mesh)?;
        let made = work.map("reducing keys", open, |c| {
            let is_reduced = round < ROUNDS_OF_CLIPS && allowed[c] > LEAST_SHARE * bound;
            let made = match is_reduced && !source.keeps_arrays() {
                true => subject.optimized(c, allowed[c], options)?,
                false => subject.unchanged(c),
            };
            Ok((c, made))
        })?;
        for (c, clip) in made {
            clips[c] = Some(clip);
        }
        let written: Vec<&OptimizedClip> = clips.iter().flatten().collect();
        let glb = source.written(&written, &precision, options)?;
        let shown = Source::read(&glb)?;
        let errors = Errors::measured(&source, &shown, options, work)?;
        if errors.greatest() <= bound {
            let report = OptimizeReport {
                bytes_in: opened.bytes(),
                bound_mm: 1e3 * bound,
                before,
                ..OptimizeReport::new(&source, &written, &errors, &glb)
            };
            return Ok(Optimized { glb, report });
        }
        if errors.rest > bound || round >= 2 {
            precision = precision.finer();
            mesh = source.with_rounded_mesh(&precision)?;
        }
        for (c, error) in errors.clips.iter().enumerate() {
            if *error > bound {
                allowed[c] *= 0.95 * bound / error;
                clips[c] = None;
            }
        }
    }
    let what = format!("error: {} mm is finer than the file can keep", 1e3 * bound);
    Err(Error::unsuited(what))
}

/// The bound in metres of the character.
fn bound_metres(source: &Source, error: ErrorBound) -> Result<f32> {
    let metres = match error {
        ErrorBound::Metres(metres) => metres,
        ErrorBound::Pixels { px, height_px } => {
            let mut posed = source.posed()?;
            let heights = posed.at(None, 0.0).iter().map(|p| p.y);
            let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), y| {
                (low.min(y), high.max(y))
            });
            let height = if high > low { high - low } else { 1.0 };
            px * height / height_px
        }
    };
    if metres.is_finite() && metres > 0.0 {
        return Ok(metres);
    }
    let what = format!("error: expected a positive length, found {metres} m");
    Err(Error::argument(what))
}

/// Greatest errors of a written file, in metres.
struct Errors {
    rest: f32,
    clips: Vec<f32>,
}

impl Errors {
    fn measured(
        source: &Source,
        shown: &Source,
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<Self> {
        let (mut from, mut to) = (source.posed()?, shown.posed()?);
        let is_same = from.count() == to.count()
            && source.character.clips.len() == shown.character.clips.len();
        if !is_same {
            return Err(Error::unsuited(
                "the written file is not read as its source",
            ));
        }
        let rest = greatest_vertex_error((&mut from, None), (&mut to, None), options.seed);
        let clips: Vec<usize> = (0..source.character.clips.len()).collect();
        let clips = work.map("measuring the error", clips, |c| {
            let wanted = (&mut from.clone(), source.character.clips.get(c));
            let found = (&mut to.clone(), shown.character.clips.get(c));
            Ok(greatest_vertex_error(wanted, found, options.seed))
        })?;
        Ok(Self { rest, clips })
    }

    fn greatest(&self) -> f32 {
        self.clips.iter().copied().fold(self.rest, f32::max)
    }
}
