//! Checks of a manifest that somebody else wrote.

use super::manifest::{FORMAT, Manifest, VERSION, VERSION_WITHOUT_FILES};
use super::name::check_name;
use super::part::{ItemLayer, ItemPart, PIXEL, PartKind};
use crate::error::{Context, Error, Result};
use articula_formats::Limits;
use std::collections::{BTreeMap, BTreeSet};

/// Maximum size of a manifest in bytes.
pub(super) const MANIFEST_BYTES: u64 = 1 << 24;
/// Maximum number of parts, of 2D forms and of whole files.
const MAX_ENTRIES: usize = 1 << 12;
/// Maximum number of layers of a part.
const MAX_LAYERS: usize = 1 << 12;
/// Greatest error in metres or pixels that is taken for a number.
const MAX_ERROR: f64 = 1e9;

/// Reads a manifest and checks it.
pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Manifest> {
    let most = MANIFEST_BYTES.min(limits.bytes);
    if bytes.len() as u64 > most {
        let what = format!("{} bytes, the limit is {most}", bytes.len());
        return Err(Error::unsuited(what));
    }
    let manifest: Manifest = serde_json::from_slice(bytes).map_err(|e| {
        Error::unsuited(format!(
            "{e}; give the folder of an item as `articula package` writes it"
        ))
    })?;
    manifest.check(limits)?;
    Ok(manifest)
}

fn wrong<T>(at: String, what: impl Into<String>) -> Result<T> {
    Err(Error::unsuited(what)).context(at)
}

impl Manifest {
    /// Checks form, names and numbers.
    fn check(&self, limits: &Limits) -> Result<()> {
        if self.format != FORMAT {
            let what = format!("\"{}\", expected \"{FORMAT}\"", self.format);
            return wrong("format".into(), what);
        }
        if ![VERSION, VERSION_WITHOUT_FILES].contains(&self.version) {
            let what = format!(
                "{}, this program reads {VERSION_WITHOUT_FILES} and {VERSION}; update it",
                self.version
            );
            return wrong("version".into(), what);
        }
        for (name, count) in [
            ("parts", self.parts.len()),
            ("flat", self.flat.len()),
            ("whole", self.whole.len()),
        ] {
            if count > MAX_ENTRIES {
                let what = format!("{count} entries, the limit is {MAX_ENTRIES}");
                return wrong(name.into(), what);
            }
        }
        number("figure.size_m".into(), Some(self.figure.size_m))?;
        for (p, part) in self.parts.iter().enumerate() {
            part.check().with_context(|| format!("parts[{p}]"))?;
        }
        for (f, entry) in self.flat.iter().enumerate() {
            number(format!("flat[{f}].error_px"), Some(entry.error_px))?;
        }
        self.check_files(limits)
    }

    /// Checks that names stay in the item, none is used twice, and all bytes are within the limit.
    fn check_files(&self, limits: &Limits) -> Result<()> {
        let mut known = BTreeSet::new();
        let mut sum = 0_u64;
        let indices = self.parts.iter().filter_map(|part| part.index.as_deref());
        let files = self.sizes().into_iter();
        for (name, bytes) in files.chain(indices.map(|name| (name, 0))) {
            check_name(name)?;
            // Names that differ in case alone are one file on some systems.
            if !known.insert(name.to_lowercase()) {
                return wrong(name.to_owned(), "two entries name this file");
            }
            sum = sum.saturating_add(bytes);
        }
        if sum > limits.bytes {
            let what = format!("{sum} bytes in all files, the limit is {}", limits.bytes);
            return Err(Error::unsuited(what));
        }
        self.check_entries()
    }
}

impl Manifest {
    /// Checks what is said of how files travel.
    fn check_entries(&self) -> Result<()> {
        let sizes: BTreeMap<&str, u64> = self.sizes().into_iter().collect();
        for (name, entry) in &self.files {
            let at = || format!("files[\"{name}\"]");
            match sizes.get(name.as_str()) {
                Some(bytes) if *bytes == entry.bytes => {}
                Some(bytes) => {
                    let what = format!("{}, elsewhere {bytes}", entry.bytes);
                    return wrong(format!("{}.bytes", at()), what);
                }
                None => return wrong(at(), "no part of the item has this file"),
            }
            if entry.sent_bytes() > entry.bytes {
                return wrong(format!("{}.compressed_bytes", at()), "more than the bytes");
            }
            let is_digit = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
            if entry.hash.len() != 64 || !entry.hash.chars().all(is_digit) {
                let what = "expected 64 hexadecimal digits in lower case";
                return wrong(format!("{}.hash", at()), what);
            }
        }
        let lacking = sizes.keys().find(|name| !self.files.contains_key(**name));
        match lacking.filter(|_| self.version == VERSION) {
            Some(name) => wrong("files".into(), format!("\"{name}\" is missing")),
            None => Ok(()),
        }
    }
}

/// Checks that ranges rise, stay within a stream and have some bytes; none are not checked.
fn ranges(ranges: &[[u64; 2]], bytes: u64, of_stream: u64) -> Result<()> {
    let mut end = 0;
    let mut sum = 0_u64;
    for (r, [start, count]) in ranges.iter().enumerate() {
        let next = start.checked_add(*count).filter(|next| *next <= of_stream);
        let (Some(next), true) = (next, *start >= end && *count > 0) else {
            let what = "ranges must rise, have bytes and stay within the stream";
            return wrong(format!("ranges[{r}]"), what);
        };
        (end, sum) = (next, sum.saturating_add(*count));
    }
    if !ranges.is_empty() && sum != bytes {
        let what = format!("{sum} bytes, but it has {bytes}");
        return wrong("ranges".into(), what);
    }
    Ok(())
}

impl ItemPart {
    fn check(&self) -> Result<()> {
        let count = self.layers.len();
        if count > MAX_LAYERS {
            let what = format!("{count} layers, the limit is {MAX_LAYERS}");
            return wrong("layers".into(), what);
        }
        let is_texture = self.kind == PartKind::Texture;
        if is_texture == self.file.is_some() || is_texture == self.index.is_some() {
            let what = match is_texture {
                true => "a texture has a file for each layer, and no index",
                false => "a stream has a file and an index",
            };
            return wrong("file".into(), what);
        }
        if is_texture && self.image.is_none() {
            return wrong(
                "image".into(),
                "a texture must name a picture of the figure",
            );
        }
        number("base_error_m".into(), self.base_error_m)?;
        number("duration_secs".into(), self.duration_secs)?;
        number("rate_hz".into(), self.rate_hz)?;
        for (name, entries) in [
            ("regions", &self.regions),
            ("face_levels", &self.face_levels),
            ("left_out", &self.left_out),
        ] {
            for (r, entry) in entries.iter().enumerate() {
                number(
                    format!("{name}[{r}].error_without_m"),
                    entry.error_without_m,
                )?;
            }
        }
        for (l, layer) in self.layers.iter().enumerate() {
            let at = || format!("layers[{l}]");
            layer.check(l, is_texture).with_context(at)?;
        }
        let all = vec![true; count];
        if self.bytes_of(&all) != self.bytes && !is_texture {
            let what = format!(
                "{}, but base and layers have {}",
                self.bytes,
                self.bytes_of(&all)
            );
            return wrong("bytes".into(), what);
        }
        ranges(&self.base_ranges, self.base_bytes, self.bytes).context("base")?;
        for (l, layer) in self.layers.iter().enumerate() {
            let of_layer = ranges(&layer.ranges, layer.bytes, self.bytes);
            of_layer.with_context(|| format!("layers[{l}]"))?;
        }
        Ok(())
    }
}

impl ItemLayer {
    fn check(&self, own: usize, is_texture: bool) -> Result<()> {
        if let Some(need) = self.needs.iter().find(|need| **need >= own) {
            let what = format!("{need}, expected layers before this one, {own}");
            return wrong("needs".into(), what);
        }
        // The figure has the pixel.
        let is_pixel = is_texture && self.size_px == Some(PIXEL) && self.bytes == 0;
        if is_texture == self.file.is_none() && !is_pixel {
            let what = "layers of textures above one pixel have a file, all others none";
            return wrong("file".into(), what);
        }
        number("error_m".into(), Some(self.error_m))?;
        number("error_mean_m".into(), self.error_mean_m)?;
        number("error_alone_m".into(), self.error_alone_m)?;
        number("texel_m".into(), self.texel_m)?;
        for (v, view) in self.views.iter().enumerate() {
            for (name, value) in [
                ("distance_m", view.distance_m),
                ("px_per_metre", view.px_per_metre),
                ("rms_levels", view.rms_levels),
                ("error_px", view.error_px),
            ] {
                number(format!("views[{v}].{name}"), Some(value))?;
            }
        }
        Ok(())
    }
}

/// Checks that a number is not negative, and not too large.
fn number(at: String, value: Option<f64>) -> Result<()> {
    match value {
        Some(value) if !(0.0..=MAX_ERROR).contains(&value) => {
            wrong(at, format!("{value}, expected 0 to {MAX_ERROR:e}"))
        }
        _ => Ok(()),
    }
}
