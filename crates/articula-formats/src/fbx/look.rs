//! Materials and pictures, reduced to what a preview needs.
//!
//! A picture takes the place of the colour. Colours are linear.

use super::kinds::Kinds;
use super::scene::Texture;
use super::source::Reader;
use crate::error::ReadError;
use crate::limits::Limits;
use crate::words::shortened;
use crate::{Resolver, uri};
use articula_core::source::{Image, Material, TextureWrap};
use glam::{Vec3, Vec4};
use std::collections::HashMap;

/// Alpha below which a surface is cut where its picture says what is seen.
const CUTOFF: f32 = 0.5;

/// Materials and pictures read so far.
pub(super) struct Looks<'r, 'f> {
    resolver: &'r mut Resolver<'f>,
    /// Name of the file without its extension.
    stem: &'r str,
    pub(super) materials: Vec<Material>,
    pub(super) images: Vec<Image>,
    of_material: HashMap<usize, usize>,
    /// Picture of each address; `None` if it cannot be read.
    of_path: HashMap<String, Option<usize>>,
    /// Bytes of all pictures.
    spent: u64,
}

impl<'r, 'f> Looks<'r, 'f> {
    pub(super) fn new(resolver: &'r mut Resolver<'f>, stem: &'r str) -> Self {
        Self {
            resolver,
            stem,
            materials: Vec::new(),
            images: Vec::new(),
            of_material: HashMap::new(),
            of_path: HashMap::new(),
            spent: 0,
        }
    }

    /// Reads a material of the scene.
    pub(super) fn material(
        &mut self,
        reader: &mut Reader<'_>,
        index: usize,
    ) -> Result<usize, ReadError> {
        if let Some(known) = self.of_material.get(&index) {
            return Ok(*known);
        }
        let surface = reader.scene.surface(index);
        let [r, g, b] = surface.color.map(|c| c.clamp(0.0, 1.0) as f32);
        let opacity = surface.opacity as f32;
        let mut material = Material {
            name: surface.name.to_owned(),
            base_color: Vec4::new(r, g, b, opacity),
            unlit: surface.is_unlit,
            emissive: Vec3::ZERO,
            ..Material::default()
        };
        if let Some(texture) = surface.texture {
            let texture = reader.scene.texture(texture);
            material.base_color_image = self.picture(reader, texture)?;
            material.base_color_wrap = texture.clamps().map(|clamps| match clamps {
                true => TextureWrap::Clamp,
                false => TextureWrap::Repeat,
            });
        }
        let cuts = surface.opacity_texture.map(|t| reader.scene.texture(t));
        let same = surface.texture.map(|t| reader.scene.texture(t));
        if let Some((cuts, same)) = cuts.zip(same)
            && cuts.paths() == same.paths()
        {
            (material.blends, material.alpha_cutoff) = (true, CUTOFF);
        }
        if opacity < 1.0 {
            material.blends = true;
        }
        self.materials.push(material);
        let made = self.materials.len() - 1;
        self.of_material.insert(index, made);
        Ok(made)
    }

    fn picture(
        &mut self,
        reader: &mut Reader<'_>,
        texture: Texture<'_>,
    ) -> Result<Option<usize>, ReadError> {
        let [relative, whole, absolute] = texture.paths();
        let key = [whole, relative, absolute, texture.name()];
        let key = key.into_iter().find(|p| !p.is_empty()).unwrap_or_default();
        if let Some(known) = self.of_path.get(key) {
            return Ok(*known);
        }
        let at = format!("picture \"{}\"", shortened(last_part(key)));
        let bytes = match texture.content() {
            [] => match self.beside(texture) {
                Ok(bytes) => Some(bytes),
                Err(reason) => {
                    note_missing(&mut reader.kinds, &at, &reason);
                    None
                }
            },
            content => Some(content.to_vec()),
        };
        let mut made = None;
        if let Some(bytes) = bytes {
            self.spent = self.spent.saturating_add(bytes.len() as u64);
            Limits::check(&at, "bytes of pictures", self.spent, reader.limits.bytes)?;
            let name = last_part(key);
            self.images.push(Image {
                name: name.to_owned(),
                mime_type: uri::mime_type(declared(name), &bytes),
                bytes,
            });
            made = Some(self.images.len() - 1);
        }
        self.of_path.insert(key.to_owned(), made);
        Ok(made)
    }

    /// Asks the resolver for a picture: by its relative path, by its name, and by that in the folder of the
    /// file's own pictures.
    fn beside(&mut self, texture: Texture<'_>) -> Result<Vec<u8>, String> {
        let paths = texture.paths();
        let relative = paths[0].replace('\\', "/");
        let is_inside = !relative.is_empty()
            && !relative.starts_with('/')
            && !relative.contains(':')
            && relative.split('/').all(|part| part != "..");
        let name = paths.iter().map(|p| last_part(p)).find(|n| !n.is_empty());
        let Some(name) = name else {
            return Err("the material names no file".to_owned());
        };
        let mut asked = Vec::new();
        if is_inside {
            asked.push(relative.trim_start_matches("./").to_owned());
        }
        asked.push(name.to_owned());
        asked.push(format!("{}.fbm/{name}", self.stem));
        asked.dedup();
        let mut reason = String::new();
        for path in asked {
            match (self.resolver)(&path) {
                Ok(bytes) => return Ok(bytes),
                Err(why) => reason = why,
            }
        }
        Err(reason)
    }
}

/// The last part of a path of any system.
fn last_part(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or_default()
}

/// Media type by the name of a picture whose bytes do not tell it.
fn declared(name: &str) -> &'static str {
    let ending = name.rsplit('.').next().unwrap_or_default();
    match ending.to_ascii_lowercase().as_str() {
        "tga" => "image/x-tga",
        "psd" => "image/vnd.adobe.photoshop",
        "tif" | "tiff" => "image/tiff",
        "bmp" => "image/bmp",
        "gif" => "image/gif",
        _ => "",
    }
}

fn note_missing(kinds: &mut Kinds, at: &str, reason: &str) {
    kinds.note(
        || format!("{at} ({reason})"),
        "a surface is shown without its picture",
    );
}
