//! A character file in fewer bytes, at an error in motion that is measured on the written file.
//!
//! - `source`: the character before anything is rounded, and files that are written of it
//! - `worn`: what is measured of a file of motion alone
//! - `within`: the file within a bound; `errors`: what is measured of it; `references`: clips beside which it is
//! - `rounds`: a rounded mesh, and clips that are made with it; `sample`: bytes of files that are not made
//! - `simplification`, `constraints`: fewer triangles
//! - `clip`, `optimized_clip`: fewer keys and rounded values for one clip
//! - `shared_constants`: held values that clips have in common
//! - `textures`, `picture_file`: pictures in fewer bytes that look the same
//! - `surface_use`: how large pictures are on screen
//! - `report`: what was saved, and the errors
//! - `kept`: the source itself, where nothing worth an error was saved
//! - `node_precision`: how far nodes may be rounded
//! - `merged_joints`: fewer joints in skins
//! - `fit`, `limits`: the least error at which a file is within limits
//!
//! Source: ours; `docs/methods/optimize.md`.

mod clip;
mod constraints;
mod errors;
mod fit;
mod kept;
mod limits;
mod merged_joints;
mod node_precision;
mod optimized_clip;
mod picture_file;
mod references;
mod report;
mod rounds;
mod sample;
mod shared_constants;
mod simplification;
mod source;
mod surface_use;
mod textures;
mod within;
mod worn;

pub use articula_formats::gltf::{BytesByKind, Compression};
pub use fit::{Fit, optimize_to_fit};
pub use limits::{OptimizeLimits, PlatformLimits};
pub use merged_joints::MergedJoints;
pub use report::{ClipOptimized, OptimizeReport};
pub use textures::{TextureContents, TextureFormat, TextureOptimized, TextureOptions};
pub use worn::MeasuredOn;

use crate::error::{Context, Error, Result};
use crate::open::CharacterFile;
use crate::work::Executor;
use articula_core::Articulation;
use articula_core::source::Character;
use merged_joints::merged_joints;
use sample::Sample;
use simplification::{SURFACE_SHARES, Saving, Simplification, TAKEN};
use source::{Shares, Source};
use std::sync::Arc;
use within::within;

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
    /// Whether triangles are removed.
    pub simplify: bool,
    /// Names of what keeps its triangles: regions of the body, materials, meshes, and morph targets and
    /// joints, of which it is the vertices that they move.
    pub locked: Vec<String>,
    /// Factors on squared errors of the surface by body region name; 1 for regions without an entry.
    pub region_weights: Vec<(String, f32)>,
    /// Whether texture coordinates and tangents stay that no material of the file uses, since an engine
    /// may have materials of its own.
    pub keep_attributes: bool,
    /// The character on whose skin errors are measured of a file without meshes; its joints are found by name.
    /// Without it points around the joints are, half a bone away.
    pub skin: Option<Arc<Character>>,
    /// What is done with textures.
    pub textures: TextureOptions,
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
            simplify: true,
            locked: Vec::new(),
            region_weights: Vec::new(),
            keep_attributes: false,
            skin: None,
            textures: TextureOptions::default(),
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

/// Writes a character in fewer bytes.
///
/// Triangles are removed where the surface is not missed, keys that are not missed are left out, values are
/// rounded as far as the lever of their joint allows, vertices are put into an order that compresses,
/// attributes that no material uses are left out, and arrays are compressed. Key times are those of the
/// file: nothing is resampled.
///
/// The error in motion is measured on the bytes that are returned: they are read as any file is, and every
/// vertex that is left is posed beside the source at all key times of each clip, the middles between them
/// (at most 1500) and random times. Where triangles are gone, the surfaces are measured against each other
/// in both directions, in up to 400 poses of clips and morph targets. The farthest vertex and the farthest
/// point of either surface stay within the bound. Of a file without meshes the vertices of
/// [`OptimizeOptions::skin`] are posed, or points around its joints. How a texture lies on the surface is not measured.
///
/// All else of a glTF document is kept: names, extras, VRM and other extensions, hierarchy, materials,
/// skins. Pictures get the fewest bytes with which they look the same. Prepared data and motion tables, which belong to the arrays as they were, are left
/// out. A document with an extension that may refer to arrays, and is not known, keeps all its arrays.
/// A file that was compressed before can become larger: [`Optimized::or_source`] takes the source then.
///
/// # Errors
/// [`Error::Argument`] if the bound is not positive; [`Error::Unsupported`] if it is finer than 24-bit
/// numbers can keep, or no joint of the skin has the name of one of the file; otherwise an [`Error`] that names the file and the cause. [`Error::Cancelled`] if the
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
    let prepared = Prepared::of(opened, options, work)?;
    let bound = prepared.bound_metres(options.error)?;
    let made = prepared.optimized(bound, options, None, work)?;
    made.ok_or_else(|| Error::unsuited("nothing was written"))
}

/// What fewer triangles save, and the shares of the error that need the fewest bytes with all triangles and with fewer,
/// where they were found on the way.
struct Saved {
    saving: Saving,
    whole: Option<Shares>,
    fewer: Option<Shares>,
}

impl Saved {
    fn of(saving: Saving) -> Self {
        Self {
            saving,
            whole: None,
            fewer: None,
        }
    }
}

/// A source, and what is known of the file that it is from.
struct Prepared {
    source: Source,
    before: BytesByKind,
    bytes_in: usize,
    articulation: Articulation,
    textures: Vec<TextureOptimized>,
    merged_joints: Option<MergedJoints>,
}

impl Prepared {
    fn of(opened: &CharacterFile, options: &OptimizeOptions, work: &Executor<'_>) -> Result<Self> {
        let (before, source) = Source::of(opened, options)?;
        let (source, textures) = source.with_small_textures(options, work)?;
        Ok(Self {
            textures,
            source,
            before,
            bytes_in: opened.bytes(),
            articulation: opened.articulation(),
            merged_joints: None,
        })
    }

    /// The same with at most a number of joints in its skins, if it has more.
    fn with_fewer_joints(
        mut self,
        max: Option<usize>,
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<Self> {
        if let Some(max) = max.filter(|max| self.skin_joints() > *max) {
            let (source, found) = merged_joints(&self.source, max, options, work)?;
            (self.source, self.merged_joints) = (source, Some(found));
        }
        Ok(self)
    }

    /// The file within a bound in metres, with fewer triangles if that makes it smaller or it has too many;
    /// `None` if it has too many anyway.
    fn optimized(
        &self,
        bound: f32,
        options: &OptimizeOptions,
        max_triangles: Option<usize>,
        work: &Executor<'_>,
    ) -> Result<Option<Optimized>> {
        let source = &self.source;
        let is_few = |triangles: usize| max_triangles.is_none_or(|max| triangles <= max);
        let is_whole_few = is_few(source.triangles());
        let (mut least, mut saved) = (None, Saved::of(Saving::None));
        let shares = SURFACE_SHARES.into_iter().filter(|_| options.simplify);
        for share in shares {
            let Some(simple) = Simplification::of(self, (bound, share), options, work)? else {
                break;
            };
            saved = match is_whole_few {
                true => self.saved(&simple, bound, options, work)?,
                false => Saved::of(Saving::Surely),
            };
            if saved.saving == Saving::None || !is_few(simple.source.triangles()) {
                break;
            }
            least = self.simplified(&simple, (bound, saved.fewer), options, work)?;
            if least.is_some() {
                break;
            }
        }
        let made = match (least, saved.saving) {
            (Some(least), Saving::Surely) => Some(least),
            (None, _) if !is_whole_few => None,
            (least, _) => {
                let whole = within(source, (bound, saved.whole), options, work)?;
                let least = least.filter(|least| least.glb.len() < whole.glb.len());
                least.or(Some(whole))
            }
        };
        Ok(made.map(|mut made| {
            made.report.bytes_in = self.bytes_in;
            made.report.bound_mm = 1e3 * bound;
            made.report.before = self.before;
            made.report.textures.clone_from(&self.textures);
            made.report.triangles_in = source.triangles();
            made.report.merged_joints.clone_from(&self.merged_joints);
            made
        }))
    }

    /// What fewer triangles save: of many clips, by some of them.
    fn saved(
        &self,
        simple: &Simplification,
        bound: f32,
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<Saved> {
        let source = &self.source;
        let saving = simple.saving(source, bound, options)?;
        let (Some(sample), Saving::Perhaps) = (Sample::of(source), saving) else {
            return Ok(Saved::of(saving));
        };
        let whole = sample.least(source, bound, options, work)?;
        let left = bound - TAKEN[0] * simple.metres;
        let fewer = sample.least(&simple.source, left, options, work)?;
        Ok(Saved {
            saving: match fewer.0 < whole.0 {
                true => Saving::Surely,
                false => Saving::None,
            },
            whole: Some(whole.1),
            fewer: Some(fewer.1),
        })
    }

    /// The file with fewer triangles, if its surface is within a bound in metres.
    fn simplified(
        &self,
        simple: &Simplification,
        (bound, mut shares): (f32, Option<Shares>),
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<Option<Optimized>> {
        for taken in TAKEN {
            let left = (bound - taken * simple.metres, shares.take());
            let mut made = within(&simple.source, left, options, work)?;
            let metres = simple.surface_error(&self.source, &made.glb, options.seed)?;
            if metres <= bound {
                made.report.add_surface(metres);
                return Ok(Some(made));
            }
        }
        Ok(None)
    }

    /// Number of joints of all skins.
    fn skin_joints(&self) -> usize {
        let joints = self.source.character.skeleton.joints.iter();
        joints.filter(|joint| joint.in_skin).count()
    }

    /// The bound in metres of the character.
    fn bound_metres(&self, error: ErrorBound) -> Result<f32> {
        bound_metres(&self.source, error)
    }
}

/// The bound in metres of the character.
fn bound_metres(source: &Source, error: ErrorBound) -> Result<f32> {
    let metres = match error {
        ErrorBound::Metres(metres) => metres,
        ErrorBound::Pixels { px, height_px } => px * source.height_metres()? / height_px,
    };
    if metres.is_finite() && metres > 0.0 {
        return Ok(metres);
    }
    let what = format!("error: expected a positive length, found {metres} m");
    Err(Error::argument(what))
}
