//! Materials, and textures with their mip levels.

use crate::picture::{Picture, linear_table};
use articula_core::source::{Image, Material, TextureWrap};
use glam::{Vec2, Vec3, Vec4};
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
            let shows = |m: &Material| m.images().any(|shown| shown == i);
            let named = materials.iter().any(shows);
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

    /// Returns the decoded base colour texture of a material; `None` without one.
    pub(crate) fn texture_of(&self, material: &Material) -> Option<WrappedTexture<'_>> {
        self.wrapped(material.base_color_image?, material.base_color_wrap)
    }

    /// Returns what a material gives off by itself.
    pub(crate) fn emission_of(&self, material: &Material) -> Emission<'_> {
        let light = material.emissive;
        let image = material.emissive_image.filter(|_| light != Vec3::ZERO);
        Emission {
            light,
            texture: image.and_then(|i| self.wrapped(i, material.emissive_wrap)),
        }
    }

    /// Returns the texture whose texels show the detail of a material: that of its base colour, or
    /// else that of its emission; `None` for a material whose colour is the same everywhere.
    pub(crate) fn detail_of(&self, material: &Material) -> Option<WrappedTexture<'_>> {
        let emission = self.emission_of(material);
        self.texture_of(material).or(emission.texture)
    }

    fn wrapped(&self, image: usize, wrap: [TextureWrap; 2]) -> Option<WrappedTexture<'_>> {
        let texture = self.textures.get(image)?.as_deref()?;
        Some(WrappedTexture { texture, wrap })
    }

    /// Share of a material's colour that does not depend on the light, 0 to 1: all of an unlit one,
    /// none of one that gives off nothing, else by the luminances of base colour and emission.
    pub fn own_light(&self, material: &Material) -> f32 {
        if material.unlit {
            return 1.0;
        }
        let mean = |texture: Option<WrappedTexture<'_>>| {
            texture.map_or(Vec3::ONE, |t| t.texture.mean().truncate())
        };
        let luminance = |color: Vec3| color.dot(Vec3::new(0.2126, 0.7152, 0.0722)).max(0.0);
        let emission = self.emission_of(material);
        let own = luminance(emission.light * mean(emission.texture));
        let lit = luminance(material.base_color.truncate() * mean(self.texture_of(material)));
        if own > 0.0 { own / (own + lit) } else { 0.0 }
    }

    /// Share of the texels of a material's base colour texture that are neither transparent nor
    /// opaque, 0 to 1; without a texture 1 or 0, by the factor.
    pub fn partly_transparent(&self, material: &Material) -> f32 {
        let is_partial = |alpha: f32| (0.02..0.98).contains(&(alpha * material.base_color.w));
        let Some(WrappedTexture { texture, .. }) = self.texture_of(material) else {
            return f32::from(u8::from(is_partial(1.0)));
        };
        let pixels = texture.levels[0].pixels();
        let partial = pixels
            .iter()
            .filter(|p| is_partial(f32::from(p[3]) / 255.0));
        partial.count() as f32 / pixels.len().max(1) as f32
    }
}

/// What a surface gives off by itself.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Emission<'a> {
    light: Vec3,
    pub(crate) texture: Option<WrappedTexture<'a>>,
}

impl Emission<'_> {
    /// Linear RGB at a texture coordinate.
    pub(crate) fn at(&self, at: Vec2, level: usize) -> Vec3 {
        match self.texture {
            None => self.light,
            Some(texture) => self.light * texture.sample(at, level).truncate(),
        }
    }
}

/// A texture with its continuation beyond its edges.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WrappedTexture<'a> {
    texture: &'a Texture,
    wrap: [TextureWrap; 2],
}

impl WrappedTexture<'_> {
    /// As [`Texture::level_for`].
    pub(crate) fn level_for(&self, texture_area: f32, pixels: f32) -> usize {
        self.texture.level_for(texture_area, pixels)
    }

    /// Width and height, texels.
    pub(crate) fn size(&self) -> Vec2 {
        let full = &self.texture.levels[0];
        Vec2::new(full.width() as f32, full.height() as f32)
    }

    /// As [`Texture::sample`], with the texture's own continuation.
    pub(crate) fn sample(&self, at: Vec2, level: usize) -> Vec4 {
        self.texture.sample(at, level, self.wrap)
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

    /// The mean of all texels, linear RGBA; white without texels.
    fn mean(&self) -> Vec4 {
        let pixels = self.levels.last().map_or(&[][..], Picture::pixels);
        let sum: Vec4 = pixels.iter().map(|p| linear(*p)).sum();
        match pixels.len() {
            0 => Vec4::ONE,
            count => sum / count as f32,
        }
    }

    /// Samples linear RGBA at a texture coordinate, bilinear.
    ///
    /// A level beyond the last one counts as the last one.
    fn sample(&self, at: Vec2, level: usize, wrap: [TextureWrap; 2]) -> Vec4 {
        let picture = &self.levels[level.min(self.levels.len() - 1)];
        let (w, h) = (picture.width() as i64, picture.height() as i64);
        if w == 0 || h == 0 || !at.is_finite() {
            return Vec4::ONE;
        }
        let at = Vec2::new(turn(at.x, wrap[0]), turn(at.y, wrap[1]));
        let place = at * Vec2::new(w as f32, h as f32) - 0.5;
        let corner = place.floor();
        let blend = place - corner;
        let texel = |dx: i64, dy: i64| {
            let x = texel_of(corner.x as i64 + dx, w, wrap[0]);
            let y = texel_of(corner.y as i64 + dy, h, wrap[1]);
            linear(picture.pixels()[(y * w + x) as usize])
        };
        let upper = texel(0, 0).lerp(texel(1, 0), blend.x);
        let lower = texel(0, 1).lerp(texel(1, 1), blend.x);
        upper.lerp(lower, blend.y)
    }
}

/// A texture coordinate of the same colour, near the texture, where `f32` is exact enough.
fn turn(at: f32, wrap: TextureWrap) -> f32 {
    match wrap {
        TextureWrap::Repeat => at - at.floor(),
        TextureWrap::Mirror => at.rem_euclid(2.0),
        TextureWrap::Clamp => at.clamp(0.0, 1.0),
    }
}

/// The texel that is shown for one at or beyond the edges of a side of `count` texels.
fn texel_of(index: i64, count: i64, wrap: TextureWrap) -> i64 {
    match wrap {
        TextureWrap::Repeat => index.rem_euclid(count),
        TextureWrap::Clamp => index.clamp(0, count - 1),
        TextureWrap::Mirror => {
            let index = index.rem_euclid(2 * count);
            index.min(2 * count - 1 - index)
        }
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
    fn texels_beyond_the_edges_repeat_mirror_or_stay() {
        // Red, green and blue from left to right.
        let pixels = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]];
        let texture = Texture::new(Picture::from_pixels(3, 1, pixels).unwrap());
        let colors = [
            Vec4::new(1.0, 0.0, 0.0, 1.0),
            Vec4::new(0.0, 1.0, 0.0, 1.0),
            Vec4::new(0.0, 0.0, 1.0, 1.0),
        ];
        for (wrap, expected) in [
            (TextureWrap::Repeat, [0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2]),
            (TextureWrap::Mirror, [2, 1, 0, 0, 1, 2, 2, 1, 0, 0, 1, 2]),
            (TextureWrap::Clamp, [0, 0, 0, 0, 1, 2, 2, 2, 2, 2, 2, 2]),
        ] {
            for (i, color) in expected.into_iter().enumerate() {
                let at = Vec2::new((i as f32 - 2.5) / 3.0, 0.5);
                let found = texture.sample(at, 0, [wrap, TextureWrap::Clamp]);
                assert!(
                    (found - colors[color]).length() < 1e-4,
                    "{wrap:?} {i}: {found}"
                );
            }
        }
    }

    #[test]
    fn what_a_material_gives_off_is_its_share_of_the_colour() {
        let of = |base: Vec3, emissive: Vec3, unlit| Material {
            base_color: base.extend(1.0),
            emissive,
            unlit,
            ..Material::default()
        };
        let share = |material: Material| Appearance::default().own_light(&material);
        assert_eq!(share(of(Vec3::ONE, Vec3::ZERO, false)), 0.0);
        assert_eq!(share(of(Vec3::ZERO, Vec3::ZERO, false)), 0.0);
        assert_eq!(share(of(Vec3::ONE, Vec3::ZERO, true)), 1.0);
        assert_eq!(share(of(Vec3::ZERO, Vec3::splat(9.0), false)), 1.0);
        assert!((share(of(Vec3::ONE, Vec3::ONE, false)) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn blends_between_texels_and_repeats() {
        let picture = Texture::new(checker());
        let texture = WrappedTexture {
            texture: &picture,
            wrap: [TextureWrap::Repeat; 2],
        };
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
