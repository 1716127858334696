//! The least error at which a file fits into limits.

use super::limits::too_large;
use super::simplification::{SURFACE_SHARES, Simplification};
use super::{
    ErrorBound, OptimizeLimits, OptimizeOptions, Optimized, Prepared, TextureOptimized,
    TextureOptions,
};
use crate::error::{Context, Error, Result};
use crate::open::CharacterFile;
use crate::work::Executor;
use serde::Serialize;

/// Factor by which the error grows until the file fits, and how often the range is halved then.
const GROWTH: f32 = 2.0;
const HALVINGS: usize = 4;
/// Greatest error that is tried, of the height of the figure.
const MOST_SHARE: f32 = 0.1;

/// How a file was made to fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fit {
    /// The limits.
    pub limits: OptimizeLimits,
    /// The error that was allowed, in millimetres; the file is within limits at a greater one.
    pub asked_mm: f32,
    /// The error at which it fits, in millimetres.
    pub bound_mm: f32,
    /// Greatest error at which it was found not to fit, in millimetres; `None` if it fits at the first.
    pub too_large_at_mm: Option<f32>,
}

/// Writes a character in fewer bytes, as [`optimize`](super::optimize) does, with the error of the options
/// or the least greater one at which the file is within limits: errors are doubled until it fits, and the
/// range is halved four times, to 5 % of the error.
///
/// # Errors
/// [`Error::Unsupported`] that names the limit, and what is reached at a tenth of the height of the figure,
/// if the file fits at no error up to that, or its joints cannot be as few; otherwise as
/// [`optimize`](super::optimize).
pub fn optimize_to_fit(
    opened: &CharacterFile,
    options: &OptimizeOptions,
    limits: &OptimizeLimits,
    work: &Executor<'_>,
) -> Result<(Optimized, Fit)> {
    fitted(opened, options, limits, work).with_context(|| opened.name())
}

fn fitted(
    opened: &CharacterFile,
    options: &OptimizeOptions,
    limits: &OptimizeLimits,
    work: &Executor<'_>,
) -> Result<(Optimized, Fit)> {
    let options = &with_small_pictures(options, limits);
    let prepared = Prepared::of(opened, options, work)?;
    let prepared = prepared.with_fewer_joints(limits.max_joints, options, work)?;
    pictures_fit(&prepared.textures, limits)?;
    let asked = prepared.bound_metres(options.error)?;
    let share = ErrorBound::Pixels {
        px: 1.0,
        height_px: 1.0 / MOST_SHARE,
    };
    let most = prepared.bound_metres(share)?.max(asked);
    let triangles = |bound: f32| -> Result<usize> {
        let simple = Simplification::of(&prepared, (bound, SURFACE_SHARES[0]), options, work)?;
        let simple = simple.map(|simple| simple.source.triangles());
        Ok(simple.unwrap_or_else(|| prepared.source.triangles()))
    };
    let mut search = Search {
        too_large: None,
        fits: asked,
        most,
    };
    if let Some(max) = limits.max_triangles
        && prepared.source.triangles() > max
    {
        let refused = |found: usize| told("triangles", max, found, most);
        search.run(
            |bound| {
                let found = triangles(bound)?;
                Ok((found <= max).then_some(()).ok_or(found))
            },
            refused,
        )?;
    }
    let whole = |bound: f32| -> Result<std::result::Result<Optimized, usize>> {
        let made = prepared.optimized(bound, options, limits.max_triangles, work)?;
        let Some(made) = made else {
            return Ok(Err(usize::MAX));
        };
        let bytes = made.glb.len();
        let is_small = limits.max_bytes.is_none_or(|max| bytes <= max);
        Ok(if is_small { Ok(made) } else { Err(bytes) })
    };
    let refused = |found: usize| match (limits.max_bytes, found) {
        (Some(max), found) if found < usize::MAX => told("bytes", max, found, most),
        _ => told(
            "triangles",
            limits.max_triangles.unwrap_or(0),
            prepared.source.triangles(),
            most,
        ),
    };
    let made = search.run(whole, refused)?;
    let fit = Fit {
        limits: *limits,
        asked_mm: 1e3 * asked,
        bound_mm: 1e3 * search.fits,
        too_large_at_mm: search.too_large.map(|metres| 1e3 * metres),
    };
    Ok((made, fit))
}

/// The options with the greatest size of pictures that is allowed.
fn with_small_pictures(options: &OptimizeOptions, limits: &OptimizeLimits) -> OptimizeOptions {
    let max = limits.max_textures_px;
    let max = max.map(|max| u32::try_from(max).unwrap_or(u32::MAX));
    let own = options.textures.longest_px;
    OptimizeOptions {
        textures: TextureOptions {
            longest_px: own.into_iter().chain(max).min(),
            ..options.textures.clone()
        },
        ..options.clone()
    }
}

/// # Errors
/// [`Error::Unsupported`] that names the first picture that could not be made small enough.
fn pictures_fit(textures: &[TextureOptimized], limits: &OptimizeLimits) -> Result<()> {
    let (Some(texture), Some(max)) = (
        too_large(textures, limits.max_textures_px, |t| t.size_out),
        limits.max_textures_px,
    ) else {
        return Ok(());
    };
    let found = match texture.size_out {
        Some([width, height]) => format!("stays {width} x {height} px"),
        None => format!("is {}, whose size is not known", texture.type_in),
    };
    let what = format!(
        "textures: images[{}] {found}; {max} px are allowed: make it smaller beforehand, or store it as PNG, JPEG or WebP",
        texture.picture
    );
    Err(Error::unsuited(what))
}

fn told(what: &str, max: usize, found: usize, most: f32) -> Error {
    let what = format!(
        "{what}: {max} allowed, {found} are the fewest within {:.0} mm, the greatest error that is tried",
        1e3 * most
    );
    Error::unsuited(what)
}

/// A search for the least error at which something fits.
struct Search {
    /// Greatest error that was too small.
    too_large: Option<f32>,
    /// Least error that may fit.
    fits: f32,
    most: f32,
}

impl Search {
    /// Tries errors from the least that may fit on; returns what was made at the least that fits.
    fn run<T>(
        &mut self,
        mut made: impl FnMut(f32) -> Result<std::result::Result<T, usize>>,
        refused: impl Fn(usize) -> Error,
    ) -> Result<T> {
        let first = self.fits;
        let mut bound = first;
        let mut best = loop {
            match made(bound)? {
                Ok(fits) => break fits,
                Err(found) if bound >= self.most => return Err(refused(found)),
                Err(_) => {
                    self.too_large = Some(bound);
                    bound = (GROWTH * bound).min(self.most);
                }
            }
        };
        self.fits = bound;
        for _ in 0..HALVINGS {
            let Some(low) = self.too_large.filter(|low| *low >= first && bound > first) else {
                break;
            };
            let middle = (low * self.fits).sqrt();
            match made(middle)? {
                Ok(fits) => (best, self.fits) = (fits, middle),
                Err(_) => self.too_large = Some(middle),
            }
        }
        Ok(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn searched(fits_at: f32) -> (Result<f32>, Search, usize) {
        let mut search = Search {
            too_large: None,
            fits: 1.0,
            most: 50.0,
        };
        let mut tries = 0;
        let found = search.run(
            |bound| {
                tries += 1;
                Ok(if bound >= fits_at { Ok(bound) } else { Err(7) })
            },
            |found| Error::unsuited(format!("{found} left")),
        );
        (found, search, tries)
    }

    #[test]
    fn the_least_error_that_fits_is_found_within_five_percent() {
        for fits_at in [1.5, 3.0, 17.0, 49.0] {
            let (found, search, tries) = searched(fits_at);
            let found = found.unwrap();
            assert!(
                found >= fits_at && found < 1.05 * fits_at,
                "{found} {fits_at}"
            );
            assert_eq!(search.fits, found);
            assert!(search.too_large.is_some_and(|low| low < fits_at));
            assert!(tries <= 11);
        }
        let (found, search, tries) = searched(0.5);
        assert_eq!((found.unwrap(), search.too_large, tries), (1.0, None, 1));
        let (found, ..) = searched(60.0);
        assert!(found.unwrap_err().to_string().contains("7 left"));
    }
}
