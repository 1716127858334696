//! Textures in fewer bytes: each picture in the format that needs the fewest, where it looks the same.
//!
//! What looks the same: `articula_flat::color_difference`; `docs/methods/optimize.md`.

use super::picture_file::{PictureFormat, encoded};
use super::surface_use::SurfaceUse;
use crate::error::Result;
use crate::work::Executor;
use articula_core::source::Image;
use articula_flat::{Averaging, Picture, PictureError, color_difference, number_difference};
use articula_formats::gltf::{Document, PictureUse};
use serde::Serialize;

/// Colour difference that 999 of 1000 texels may have, and that all may have. A difference of 2.3 is just
/// seen, side by side (M. Mahy, L. Van Eycken, A. Oosterlinck, Color Research and Application 19(2), 1994).
const JUST_SEEN: f64 = 2.3;
const LARGEST: f64 = 2.0 * JUST_SEEN;
/// Levels of 0 to 255 by which numbers may be off: root mean square, and largest. Of a normal, 0.5 and 3
/// degrees.
const NUMBERS_RMS: f64 = 1.0;
const NUMBERS_LARGEST: u8 = 6;
/// Qualities that are tried, and the share of the bytes of a lossy picture above which it is not coded again,
/// so that losses do not add up.
const QUALITIES: [u8; 9] = [50, 60, 70, 80, 85, 88, 91, 94, 97];
const AGAIN_BELOW: f64 = 0.85;

/// Format in which textures are written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum TextureFormat {
    /// The smallest of PNG, JPEG and WebP; without WebP, which readers need an extension for, in VRM files
    /// and in files without compressed arrays.
    #[default]
    Auto,
    /// WebP, lossless where that is smaller or a lossy one looks different.
    Webp,
    /// JPEG, or PNG where a picture has alpha or looks different.
    Jpeg,
    /// PNG.
    Png,
    /// The format of each picture; only other sizes are written.
    Keep,
}

/// What is done with textures. No picture needs more bytes than before.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TextureOptions {
    /// Longest side in pixels; larger pictures are made smaller, by the mean of areas. `None` keeps sizes.
    pub longest_px: Option<u32>,
    /// Height of the figure on screen in pixels, as the largest that is shown: pictures are made smaller, to
    /// a power of two, whose texels would then be smaller than its pixels on 99 % of the surface. `None`
    /// keeps sizes.
    pub screen_height_px: Option<u32>,
    /// The format.
    pub format: TextureFormat,
    /// Quality of lossy colours, 1 to 100, whatever they then look like. `None`: the least at which no
    /// difference is seen.
    pub quality: Option<u8>,
}

/// What a picture holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TextureContents {
    /// Colours.
    Colors,
    /// Normals or other numbers.
    Numbers,
    /// No material is known to use it; it stays as it is.
    Unknown,
}

/// One picture before and after.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TextureOptimized {
    /// Index of the picture in the document.
    pub picture: usize,
    /// Its name.
    pub name: String,
    /// What it holds.
    pub holds: TextureContents,
    /// Bytes before.
    pub bytes_in: usize,
    /// Bytes after.
    pub bytes_out: usize,
    /// Media type before.
    pub type_in: String,
    /// Media type after.
    pub type_out: String,
    /// Width and height before; `None` of a picture that was not decoded.
    pub size_in: Option<[u32; 2]>,
    /// Width and height after.
    pub size_out: Option<[u32; 2]>,
    /// Colour difference of CIELAB that 999 of 1000 texels do not exceed, by the coding alone.
    pub delta_e: Option<f64>,
    /// Largest difference of numbers in levels of 0 to 255, by the coding alone.
    pub levels: Option<u8>,
    /// Why it stays as it is, if it is broken.
    pub warning: Option<String>,
}

/// How the pictures of a document are made smaller.
pub(super) struct TextureRun<'a> {
    pub(super) options: &'a TextureOptions,
    /// Whether arrays are not compressed.
    pub(super) is_plain: bool,
    /// The surfaces that show the pictures, where their sizes matter.
    pub(super) surfaces: Option<&'a SurfaceUse>,
}

/// Replaces the pictures of a document that have been read from it.
pub(super) fn optimize_textures(
    document: &mut Document,
    images: &[Image],
    run: &TextureRun<'_>,
    work: &Executor<'_>,
) -> Result<Vec<TextureOptimized>> {
    let is_vrm = |name: &str| name == "VRM" || name == "VRMC_vrm";
    let extensions = document.json.get("extensions").and_then(|e| e.as_object());
    let is_vrm = extensions.is_some_and(|all| all.keys().any(|name| is_vrm(name)));
    let takes_webp = !run.is_plain && !is_vrm;
    let uses = document.picture_uses();
    let pairs = images.iter().zip(&uses).enumerate().collect();
    let made = work.map("reducing textures", pairs, |(i, (image, uses))| {
        Ok(Texture::new(i, image, *uses).optimized(run, takes_webp))
    })?;
    let changed = made.iter().filter_map(|(texture, bytes)| {
        let bytes = bytes.as_deref()?;
        Some((texture.picture, bytes))
    });
    let changed: Vec<(usize, &[u8])> = changed.collect();
    if !changed.is_empty() {
        document.set_pictures(&changed)?;
    }
    Ok(made.into_iter().map(|(texture, _)| texture).collect())
}

/// A picture of a document.
struct Texture<'a> {
    image: &'a Image,
    uses: PictureUse,
    found: TextureOptimized,
}

/// A coding of a picture, and its error.
struct Coded {
    format: PictureFormat,
    bytes: Vec<u8>,
    delta_e: Option<f64>,
    levels: Option<u8>,
}

impl<'a> Texture<'a> {
    fn new(picture: usize, image: &'a Image, uses: PictureUse) -> Self {
        let holds = match uses {
            // The stricter bound, where both are true.
            PictureUse { numbers: true, .. } => TextureContents::Numbers,
            PictureUse { colors: true, .. } => TextureContents::Colors,
            _ => TextureContents::Unknown,
        };
        let found = TextureOptimized {
            picture,
            name: image.name.clone(),
            holds,
            bytes_in: image.bytes.len(),
            bytes_out: image.bytes.len(),
            type_in: image.mime_type.clone(),
            type_out: image.mime_type.clone(),
            size_in: None,
            size_out: None,
            delta_e: None,
            levels: None,
            warning: None,
        };
        Self { image, uses, found }
    }

    /// The picture after, and its file if that is another.
    fn optimized(
        mut self,
        run: &TextureRun<'_>,
        takes_webp: bool,
    ) -> (TextureOptimized, Option<Vec<u8>>) {
        let keeps_sizes = run.options.longest_px.is_none() && run.surfaces.is_none();
        let is_kept = run.options.format == TextureFormat::Keep && keeps_sizes;
        let own = PictureFormat::of(&self.image.bytes);
        let (Some(own), false) = (own, is_kept) else {
            return (self.found, None);
        };
        if self.found.holds == TextureContents::Unknown {
            return (self.found, None);
        }
        match self.smallest(own, run, takes_webp) {
            Ok(Some(coded)) => {
                let TextureOptimized {
                    bytes_out,
                    type_out,
                    delta_e,
                    levels,
                    ..
                } = &mut self.found;
                (*bytes_out, *delta_e) = (coded.bytes.len(), coded.delta_e);
                (*type_out, *levels) = (coded.format.media_type().to_owned(), coded.levels);
                (self.found, Some(coded.bytes))
            }
            Ok(None) => {
                self.found.size_out = self.found.size_in;
                (self.found, None)
            }
            Err(error) => {
                self.found.size_out = self.found.size_in;
                let what = format!("images[{}]: stays as it is: {error}", self.found.picture);
                self.found.warning = Some(what);
                (self.found, None)
            }
        }
    }

    /// The smallest file that may stand for the picture, if that is smaller than its own.
    fn smallest(
        &mut self,
        own: PictureFormat,
        run: &TextureRun<'_>,
        takes_webp: bool,
    ) -> Result<Option<Coded>, PictureError> {
        let options = run.options;
        let original = Picture::decode(&self.image.bytes)?;
        let size = [original.width(), original.height()];
        self.found.size_in = Some(size);
        self.found.size_out = Some(size);
        let resized = self.resized(&original, run)?;
        let is_resized = resized.is_some();
        if !is_resized && (options.format == TextureFormat::Keep || self.is_deep()) {
            return Ok(None);
        }
        let picture = resized.unwrap_or(original);
        let is_lossy = PictureFormat::is_lossy(&self.image.bytes);
        // Of a lossy picture, lossless files are larger.
        let tries_lossless = is_resized || !is_lossy;
        let limit = match is_lossy && !is_resized && options.quality.is_none() {
            true => (AGAIN_BELOW * self.image.bytes.len() as f64) as usize,
            false => self.image.bytes.len(),
        };
        let formats = self.formats(own, options.format, takes_webp);
        let mut best: Option<Coded> = None;
        let most = |best: &Option<Coded>| best.as_ref().map_or(limit, |best| best.bytes.len());
        for format in formats.iter().filter(|_| tries_lossless) {
            if let Some(bytes) = encoded(&picture, *format, None)?
                && bytes.len() < most(&best)
            {
                best = Some(Coded {
                    format: *format,
                    bytes,
                    delta_e: Some(0.0),
                    levels: Some(0),
                });
            }
        }
        for format in formats {
            let below = most(&best);
            if let Some(coded) = self.lossy(&picture, format, options.quality, below)? {
                best = Some(coded);
            }
        }
        if best.is_some() {
            self.found.size_out = Some([picture.width(), picture.height()]);
        }
        Ok(best)
    }

    /// The picture at the size that is wished for; `None` if that is its own.
    fn resized(
        &self,
        original: &Picture,
        run: &TextureRun<'_>,
    ) -> Result<Option<Picture>, PictureError> {
        let (width, height) = (original.width(), original.height());
        let needed = run
            .surfaces
            .and_then(|surfaces| surfaces.longest_px(self.found.picture, [width, height]));
        let longest = needed.into_iter().chain(run.options.longest_px).min();
        let longest = longest.map_or(u32::MAX, |px| px.max(1));
        if width.max(height) <= longest {
            return Ok(None);
        }
        let share = f64::from(longest) / f64::from(width.max(height));
        let side = |side: u32| ((f64::from(side) * share).round() as u32).max(1);
        let averaging = match self.found.holds {
            TextureContents::Numbers => Averaging::Numbers,
            _ => Averaging::Light,
        };
        let resized = original.resized((side(width), side(height)), averaging)?;
        Ok(Some(resized))
    }

    /// Whether the picture is a PNG of 16 bits a sample, which no other file here has.
    fn is_deep(&self) -> bool {
        self.image.bytes.starts_with(b"\x89PNG") && self.image.bytes.get(24) == Some(&16)
    }

    fn formats(
        &self,
        own: PictureFormat,
        format: TextureFormat,
        takes_webp: bool,
    ) -> Vec<PictureFormat> {
        use PictureFormat::{Jpeg, Png, Webp};
        match format {
            // Each of them has the place of its format in the texture.
            _ if self.uses.has_alternative => vec![own],
            TextureFormat::Auto if takes_webp || own == Webp => vec![Png, Webp, Jpeg],
            TextureFormat::Auto | TextureFormat::Jpeg => vec![Png, Jpeg],
            TextureFormat::Webp => vec![Webp],
            TextureFormat::Png => vec![Png],
            TextureFormat::Keep => vec![own],
        }
    }

    /// The lossy file of the least quality that looks the same, or of the quality that is given, if it has
    /// fewer bytes than a limit.
    fn lossy(
        &self,
        picture: &Picture,
        format: PictureFormat,
        quality: Option<u8>,
        below: usize,
    ) -> Result<Option<Coded>, PictureError> {
        let of = |quality: u8| self.coded(picture, format, quality);
        let is_given = quality.filter(|_| self.found.holds == TextureContents::Colors);
        if let Some(quality) = is_given {
            let coded = of(quality)?.map(|(coded, _)| coded);
            return Ok(coded.filter(|coded| coded.bytes.len() < below));
        }
        let (mut low, mut high) = (0, QUALITIES.len());
        // No quality is within the bound and the limit if the least is not within the limit.
        let least = encoded(picture, format, Some(QUALITIES[0]))?;
        if least.is_none_or(|bytes| bytes.len() >= below) {
            return Ok(None);
        }
        let mut best = None;
        while low < high {
            let middle = usize::midpoint(low, high);
            let Some((coded, looks_same)) = of(QUALITIES[middle])? else {
                return Ok(None);
            };
            let is_small = coded.bytes.len() < below;
            match (looks_same, is_small) {
                (true, true) => (best, high) = (Some(coded), middle),
                (true, false) => high = middle,
                (false, true) => low = middle + 1,
                (false, false) => break,
            }
        }
        Ok(best)
    }

    /// The picture at a quality, and whether it looks the same. `None` if the format cannot hold it.
    fn coded(
        &self,
        picture: &Picture,
        format: PictureFormat,
        quality: u8,
    ) -> Result<Option<(Coded, bool)>, PictureError> {
        let Some(bytes) = encoded(picture, format, Some(quality))? else {
            return Ok(None);
        };
        let shown = Picture::decode(&bytes)?;
        let mut coded = Coded {
            format,
            bytes,
            delta_e: None,
            levels: None,
        };
        let looks_same = match self.found.holds {
            TextureContents::Numbers => {
                let found = number_difference(picture, &shown)?;
                coded.levels = Some(found.largest);
                found.rms <= NUMBERS_RMS && found.largest <= NUMBERS_LARGEST
            }
            _ => {
                let found = color_difference(picture, &shown)?;
                coded.delta_e = Some(found.most);
                found.most <= JUST_SEEN && found.largest <= LARGEST
            }
        };
        Ok(Some((coded, looks_same)))
    }
}
