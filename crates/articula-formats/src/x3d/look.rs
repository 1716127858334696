//! Appearances: colours and pictures, reduced to what a preview needs.
//!
//! Source: ISO/IEC 19775-1, clause 12 (shape) and 18 (texturing). Colours of `Material` and
//! `UnlitMaterial` are sRGB, those of `PhysicalMaterial` are linear. A picture replaces the colour
//! up to X3D 3 and is multiplied with it from X3D 4 on.

use super::fields::Reader;
use super::scene::{NodeId, shortened};
use crate::error::ReadError;
use crate::limits::Limits;
use crate::{Resolver, uri};
use articula_core::Libm;
use articula_core::source::{Image, Material, TextureWrap};
use glam::{DMat2, DVec2, DVec3, Vec3, Vec4};
use std::collections::HashMap;

/// Transform of texture coordinates before the lookup.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TextureMove {
    matrix: DMat2,
    offset: DVec2,
}

impl TextureMove {
    /// Reads the transform of the standard: translation, rotation and scale, the latter two about
    /// the center.
    fn read(reader: &mut Reader<'_>, id: NodeId) -> Result<Self, ReadError> {
        let two = |reader: &mut Reader<'_>, field: &str, usual: DVec2| {
            let given = reader.tuples::<2>(id, field)?;
            Ok::<_, ReadError>(given.first().map_or(usual, |v| DVec2::from_array(*v)))
        };
        let center = two(reader, "center", DVec2::ZERO)?;
        let scale = two(reader, "scale", DVec2::ONE)?;
        let translation = two(reader, "translation", DVec2::ZERO)?;
        let angle = reader.number(id, "rotation", 0.0)? * reader.scene.radians;
        // Tc' = -C · S · R · C · T · Tc
        let (sin, cos) = angle.libm_sin_cos();
        let turn = DMat2::from_cols_array(&[cos, sin, -sin, cos]);
        let matrix = DMat2::from_diagonal(scale) * turn;
        Ok(Self {
            matrix,
            offset: matrix * (center + translation) - center,
        })
    }

    /// Transforms a texture coordinate with its origin at the bottom.
    pub(super) fn apply(&self, texcoord: DVec2) -> DVec2 {
        self.matrix * texcoord + self.offset
    }
}

/// Appearance of one shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShapeAppearance {
    pub(super) material: usize,
    pub(super) textured: bool,
    pub(super) texture_move: Option<TextureMove>,
}

/// Properties by which materials are deduplicated.
type LookKey = (
    String,
    [u32; 8],
    [Option<usize>; 2],
    [[TextureWrap; 2]; 2],
    [bool; 3],
);

/// Materials and pictures read so far, without duplicates.
pub(super) struct Looks<'r, 'f> {
    resolver: &'r mut Resolver<'f>,
    pub(super) materials: Vec<Material>,
    pub(super) images: Vec<Image>,
    made: HashMap<(Option<NodeId>, bool), ShapeAppearance>,
    /// Index by properties: files often repeat an appearance for each shape.
    material_of_look: HashMap<LookKey, usize>,
    /// Picture of each texture node; `None` if it could not be read.
    pictures: HashMap<NodeId, Option<usize>>,
    /// Index of the picture of each address.
    addresses: HashMap<String, usize>,
    /// Size of all pictures in bytes.
    spent: u64,
}

impl<'r, 'f> Looks<'r, 'f> {
    pub(super) fn new(resolver: &'r mut Resolver<'f>) -> Self {
        Self {
            resolver,
            materials: Vec::new(),
            images: Vec::new(),
            made: HashMap::new(),
            material_of_look: HashMap::new(),
            pictures: HashMap::new(),
            addresses: HashMap::new(),
            spent: 0,
        }
    }

    /// Returns the appearance of a shape whose geometry is solid or shows its back.
    pub(super) fn of(
        &mut self,
        reader: &mut Reader<'_>,
        shape: NodeId,
        solid: bool,
    ) -> Result<ShapeAppearance, ReadError> {
        let appearance = reader.node(shape, "appearance");
        if let Some(look) = self.made.get(&(appearance, solid)) {
            return Ok(*look);
        }
        let mut material = Material {
            double_sided: !solid,
            ..Material::default()
        };
        let mut texture = None;
        let mut texture_move = None;
        if let Some(id) = appearance {
            let own = reader.node(id, "material");
            texture = texture_of(reader, id, own);
            if let Some(own) = own {
                material.base_color = base_color(reader, own)?;
                material.name = reader.name(own);
                material.unlit = reader.kind(own) == "UnlitMaterial";
                self.emissive(reader, own, &mut material)?;
            }
            let mode = reader.text(id, "alphaMode");
            match mode.map(str::trim) {
                Some("MASK") => {
                    material.alpha_cutoff = reader.number(id, "alphaCutoff", 0.5)? as f32;
                }
                // A mixture is not drawn; the surface is cut where it is less than half opaque.
                Some("BLEND") => (material.blends, material.alpha_cutoff) = (true, 0.5),
                _ => {}
            }
            let moved = reader.node(id, "textureTransform");
            let moved = moved.filter(|&n| reader.kind(n) == "TextureTransform");
            texture_move = moved.map(|n| TextureMove::read(reader, n)).transpose()?;
        }
        if let Some(texture) = texture {
            material.base_color_image = self.picture(reader, texture)?;
            material.base_color_wrap = wrap(reader, texture);
            if material.base_color_image.is_some() && reader.scene.version < 4 {
                let opacity = material.base_color.w;
                material.base_color = Vec4::ONE.with_w(opacity);
            }
        }
        let look = ShapeAppearance {
            textured: material.base_color_image.is_some(),
            texture_move,
            material: self.material(material),
        };
        self.made.insert((appearance, solid), look);
        Ok(look)
    }

    /// Reads the light that a lit material gives off.
    fn emissive(
        &mut self,
        reader: &mut Reader<'_>,
        own: NodeId,
        material: &mut Material,
    ) -> Result<(), ReadError> {
        if material.unlit {
            return Ok(());
        }
        let color = reader.vector(own, "emissiveColor", DVec3::ZERO)?.to_array();
        let light = match reader.kind(own) {
            "PhysicalMaterial" => color.map(|c| c.clamp(0.0, 1.0) as f32),
            _ => color.map(linear),
        };
        material.emissive = Vec3::from_array(light);
        if material.emissive == Vec3::ZERO {
            return Ok(());
        }
        if let Some(texture) = reader.node(own, "emissiveTexture") {
            material.emissive_image = self.picture(reader, texture)?;
            material.emissive_wrap = wrap(reader, texture);
        }
        Ok(())
    }

    /// Returns the index of a material; equal ones share an index.
    fn material(&mut self, material: Material) -> usize {
        let [r, g, b, a] = material.base_color.to_array();
        let [x, y, z] = material.emissive.to_array();
        let key = (
            material.name.clone(),
            [r, g, b, a, x, y, z, material.alpha_cutoff].map(f32::to_bits),
            [material.base_color_image, material.emissive_image],
            [material.base_color_wrap, material.emissive_wrap],
            [material.double_sided, material.blends, material.unlit],
        );
        let next = self.materials.len();
        let index = *self.material_of_look.entry(key).or_insert(next);
        if index == next {
            self.materials.push(material);
        }
        index
    }

    /// Returns the picture of a texture node, if one can be read.
    fn picture(&mut self, reader: &mut Reader<'_>, id: NodeId) -> Result<Option<usize>, ReadError> {
        if let Some(known) = self.pictures.get(&id) {
            return Ok(*known);
        }
        let mut found = None;
        if reader.kind(id) == "ImageTexture" {
            let mut reasons = Vec::new();
            for address in reader.strings(id, "url")? {
                match self.fetch(reader, id, &address)? {
                    Ok(image) => {
                        found = Some(image);
                        break;
                    }
                    Err(reason) => {
                        reasons.push(format!("\"{}\": {reason}", shortened(&address)));
                    }
                }
            }
            if found.is_none() {
                let reasons = match reasons.is_empty() {
                    true => "the node has no url".to_owned(),
                    false => reasons.join("; "),
                };
                reader.warn(id, format!("shown without its image: {reasons}"));
            }
        } else {
            let what = format!("{} is not read; shown without it", reader.kind(id));
            reader.warn(id, what);
        }
        self.pictures.insert(id, found);
        Ok(found)
    }

    /// Returns the picture at one address, or the reason why it cannot be read.
    fn fetch(
        &mut self,
        reader: &mut Reader<'_>,
        id: NodeId,
        address: &str,
    ) -> Result<Result<usize, String>, ReadError> {
        if let Some(known) = self.addresses.get(address) {
            return Ok(Ok(*known));
        }
        let at = reader.scene.at(id);
        let (declared, bytes) = match uri::decode_data_uri(address, &at, reader.limits)? {
            Some(inside) => inside,
            None => match self.beside(reader, id, address) {
                Ok(bytes) => (String::new(), bytes),
                Err(reason) => return Ok(Err(reason)),
            },
        };
        self.spent = self.spent.saturating_add(bytes.len() as u64);
        Limits::check(&at, "bytes of pictures", self.spent, reader.limits.bytes)?;
        self.images.push(Image {
            name: reader.name(id),
            mime_type: uri::mime_type(&declared, &bytes),
            bytes,
        });
        let index = self.images.len() - 1;
        // An address may contain a whole picture.
        if address.len() < 1000 {
            self.addresses.insert(address.to_owned(), index);
        }
        Ok(Ok(index))
    }

    /// Requests an external picture from the resolver. For a remote address, its last part is
    /// requested, which may have been saved with the file.
    fn beside(
        &mut self,
        reader: &mut Reader<'_>,
        id: NodeId,
        address: &str,
    ) -> Result<Vec<u8>, String> {
        if !address.contains("://") {
            return (self.resolver)(&uri::file_name(address));
        }
        let name = uri::file_name(address.rsplit('/').next().unwrap_or(""));
        let bytes = (self.resolver)(&name).map_err(|reason| {
            format!("URLs are not fetched, and for a file of that name: {reason}")
        })?;
        let what = format!(
            "\"{}\" is not fetched; the image of that name in the folder of the file is used",
            shortened(address)
        );
        reader.warn(id, what);
        Ok(bytes)
    }
}

/// Returns the texture of the base colour: that of the material (X3D 4), else of the appearance.
fn texture_of(reader: &Reader<'_>, appearance: NodeId, material: Option<NodeId>) -> Option<NodeId> {
    let of_material = material.and_then(|m| {
        let fields: &[&str] = match reader.kind(m) {
            "UnlitMaterial" => &["emissiveTexture"],
            _ => &["diffuseTexture", "baseTexture"],
        };
        fields.iter().find_map(|field| reader.node(m, field))
    });
    let texture = of_material.or_else(|| reader.node(appearance, "texture"))?;
    if reader.kind(texture) == "MultiTexture" {
        return reader.node(texture, "texture");
    }
    Some(texture)
}

/// Continuation of a texture beyond its edges; that of its properties goes before its own fields.
fn wrap(reader: &Reader<'_>, texture: NodeId) -> [TextureWrap; 2] {
    let properties = reader.node(texture, "textureProperties");
    [("repeatS", "boundaryModeS"), ("repeatT", "boundaryModeT")].map(|(repeat, mode)| {
        let mode = properties.and_then(|p| reader.text(p, mode));
        let repeat = reader.text(texture, repeat);
        let clamps = |text: &str| text.trim().eq_ignore_ascii_case("false");
        match mode.map(str::trim) {
            Some("MIRRORED_REPEAT") => TextureWrap::Mirror,
            Some("REPEAT") => TextureWrap::Repeat,
            Some(_) => TextureWrap::Clamp,
            None if repeat.is_some_and(clamps) => TextureWrap::Clamp,
            None => TextureWrap::Repeat,
        }
    })
}

fn base_color(reader: &mut Reader<'_>, id: NodeId) -> Result<Vec4, ReadError> {
    let opacity = 1.0 - reader.number(id, "transparency", 0.0)?.clamp(0.0, 1.0);
    let (field, usual) = match reader.kind(id) {
        "PhysicalMaterial" => ("baseColor", 1.0),
        "UnlitMaterial" => ("emissiveColor", 1.0),
        _ => ("diffuseColor", 0.8),
    };
    let color = reader.vector(id, field, DVec3::splat(usual))?.to_array();
    let [r, g, b] = match field {
        "baseColor" => color.map(|c| c.clamp(0.0, 1.0) as f32),
        _ => color.map(linear),
    };
    Ok(Vec4::new(r, g, b, opacity as f32))
}

/// Converts from sRGB, the space of the file's colours.
pub(super) fn linear(srgb: f64) -> f32 {
    let c = srgb.clamp(0.0, 1.0);
    let linear = if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).libm_powf(2.4)
    };
    linear as f32
}
