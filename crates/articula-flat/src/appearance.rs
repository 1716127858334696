//! Materials, and textures with their mip levels.

use crate::picture::{Picture, linear_table};
use articula_core::source::{Image, Material};
use glam::{Vec2, Vec4};
use std::sync::Arc;

/// Materials of a character with their decoded textures.
#[derive(Debug, Clone, Default)]
pub struct Appearance {
    /// Materials, indexed by the material index of mesh parts.
    pub materials: Vec<Material>,
    textures: Vec<Option<Arc<Texture>>>,
}

/// A texture that could not be decoded; its material is drawn in its base colour.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UndecodedTexture {
    /// Index of the image.
    pub image: usize,
    /// Description of the error.
    pub what: String,
}

impl Appearance {
    /// Decodes the images that materials refer to; also returns the images that could not be
    /// decoded.
    pub fn new(materials: &[Material], images: &[Image]) -> (Self, Vec<UndecodedTexture>) {
        let mut faults = Vec::new();
        let mut textures = Vec::with_capacity(images.len());
        for (i, image) in images.iter().enumerate() {
            let named = materials.iter().any(|m| m.base_color_image == Some(i));
            let decoded = named.then(|| Picture::decode(&image.bytes));
            textures.push(match decoded {
                None => None,
                Some(Ok(picture)) => Some(Arc::new(Texture::new(picture))),
                Some(Err(e)) => {
                    let what = e.to_string();
                    faults.push(UndecodedTexture { image: i, what });
                    None
                }
            });
        }
        let materials = materials.to_vec();
        let appearance = Self {
            materials,
            textures,
        };
        (appearance, faults)
    }

    /// Returns the appearance with another picture as one of its textures; an index of no image
    /// changes nothing. The other textures are shared, not copied.
    #[must_use]
    pub fn with_texture(&self, image: usize, picture: Picture) -> Self {
        let mut changed = self.clone();
        if let Some(texture) = changed.textures.get_mut(image) {
            *texture = Some(Arc::new(Texture::new(picture)));
        }
        changed
    }

    /// Returns whether an image was decoded as a texture of a material.
    pub fn has_texture(&self, image: usize) -> bool {
        self.textures.get(image).is_some_and(Option::is_some)
    }

    /// Returns the decoded texture of a material; `None` without one.
    pub(crate) fn texture_of(&self, material: &Material) -> Option<&Texture> {
        self.textures.get(material.base_color_image?)?.as_deref()
    }
}

/// A picture with its mip levels, down to one pixel.
#[derive(Debug, Clone)]
pub(crate) struct Texture {
    levels: Vec<Picture>,
}

impl Texture {
    /// Builds the mip levels, averaged in linear light.
    pub(crate) fn new(picture: Picture) -> Self {
        let mut levels = vec![picture];
        while let Some(last) = levels.last()
            && last.width() > 1
            && last.height() > 1
        {
            levels.push(last.downsample(2));
        }
        Self { levels }
    }

    /// Mip level at which a texel covers about one pixel, for a surface patch with this area in
    /// texture space (1 is the whole texture) and this area in pixels.
    pub(crate) fn level_for(&self, texture_area: f32, pixels: f32) -> usize {
        let full = &self.levels[0];
        let texels = texture_area.abs() * full.width() as f32 * full.height() as f32;
        let ratio = texels / pixels.abs().max(1e-6);
        if ratio.is_nan() || ratio <= 1.0 {
            return 0;
        }
        // Half the logarithm, since both are areas; rounded down for sharpness.
        let level = (0.5 * ratio.log2()) as usize;
        level.min(self.levels.len() - 1)
    }

    /// Samples linear RGBA at a texture coordinate, bilinear; the texture repeats.
    ///
    /// A level beyond the last one counts as the last one.
    pub(crate) fn sample(&self, at: Vec2, level: usize) -> Vec4 {
        let picture = &self.levels[level.min(self.levels.len() - 1)];
        let (w, h) = (picture.width() as i64, picture.height() as i64);
        if w == 0 || h == 0 || !at.is_finite() {
            return Vec4::ONE;
        }
        let place = (at - at.floor()) * Vec2::new(w as f32, h as f32) - 0.5;
        let corner = place.floor();
        let blend = place - corner;
        let texel = |dx: i64, dy: i64| {
            let x = (corner.x as i64 + dx).rem_euclid(w);
            let y = (corner.y as i64 + dy).rem_euclid(h);
            linear(picture.pixels()[(y * w + x) as usize])
        };
        let upper = texel(0, 0).lerp(texel(1, 0), blend.x);
        let lower = texel(0, 1).lerp(texel(1, 1), blend.x);
        upper.lerp(lower, blend.y)
    }
}

fn linear([r, g, b, a]: [u8; 4]) -> Vec4 {
    let table = linear_table();
    let of = |byte: u8| table[usize::from(byte)];
    Vec4::new(of(r), of(g), of(b), f32::from(a) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checker() -> Picture {
        let (black, white) = ([0, 0, 0, 255], [255; 4]);
        Picture::from_pixels(2, 2, vec![black, white, white, black]).unwrap()
    }

    #[test]
    fn blends_between_texels_and_repeats() {
        let texture = Texture::new(checker());
        assert_eq!(texture.sample(Vec2::new(0.25, 0.25), 0), Vec4::W);
        assert_eq!(texture.sample(Vec2::new(1.75, -0.75), 0), Vec4::ONE);
        let middle = texture.sample(Vec2::new(0.5, 0.25), 0);
        assert!((middle - Vec4::new(0.5, 0.5, 0.5, 1.0)).length() < 1e-6);
        let seam = texture.sample(Vec2::new(0.0, 0.25), 0);
        assert!((seam.x - 0.5).abs() < 1e-6);
        // The one-pixel copy is the mean in linear light: half, up to the byte's rounding.
        assert!((texture.sample(Vec2::ZERO, 9).x - 0.5).abs() < 0.005);
        assert!(texture.sample(Vec2::NAN, 0).is_finite());
    }

    #[test]
    fn level_halves_the_texture_for_a_quarter_of_the_pixels() {
        let texture = Texture::new(Picture::new(64, 64, [255; 4]).unwrap());
        assert_eq!(texture.level_for(1.0, 64.0 * 64.0), 0);
        assert_eq!(texture.level_for(1.0, 32.0 * 32.0), 1);
        assert_eq!(texture.level_for(1.0, 0.0), 6);
        assert_eq!(texture.level_for(f32::NAN, 1.0), 0);
    }

    #[test]
    fn says_which_image_is_broken_and_skips_the_unused() {
        let image = |bytes: Vec<u8>| Image {
            bytes,
            ..Image::default()
        };
        let using = |image| Material {
            base_color_image: Some(image),
            ..Material::default()
        };
        let images = [
            image(checker().to_png().unwrap()),
            image(vec![1]),
            image(vec![]),
        ];
        let (appearance, faults) = Appearance::new(&[using(0), using(1), using(7)], &images);
        assert_eq!(faults.len(), 1);
        assert_eq!(faults[0].image, 1);
        let has = |m: usize| appearance.texture_of(&appearance.materials[m]).is_some();
        assert!(has(0) && !has(1) && !has(2));
    }
}
