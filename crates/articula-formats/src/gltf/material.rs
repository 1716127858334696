//! Materials and pictures, reduced to what a preview needs.
//!
//! Source: glTF 2.0, 3.9; KHR_materials_pbrSpecularGlossiness for files that have only that.

use super::place::Place;
use super::reader::Reader;
use super::texcoord::Texcoords;
use super::texture_source::sources;
use crate::error::ReadError;
use crate::limits::Limits;
use crate::uri::mime_type;
use articula_core::source::{Image, Material, TextureWrap};
use glam::{Vec3, Vec4};

/// Values of `wrapS` and `wrapT`, other than those that repeat.
pub(super) const CLAMP_TO_EDGE: u64 = 33071;
pub(super) const MIRRORED_REPEAT: u64 = 33648;

/// Materials, pictures, and the texture coordinates that each material uses.
#[derive(Debug)]
pub(super) struct GltfMaterials {
    pub(super) materials: Vec<Material>,
    pub(super) images: Vec<Image>,
    /// Texture coordinates of each material's base colour picture.
    pub(super) texcoords: Vec<Texcoords>,
}

/// Reads all materials and pictures in order.
pub(super) fn read_all(reader: &mut Reader<'_>) -> Result<GltfMaterials, ReadError> {
    let images = read_images(reader)?;
    let mut materials = Vec::new();
    let mut texcoords = Vec::new();
    for place in reader.root.entries("materials")? {
        let (material, wanted) = read_material(reader, &place, &images)?;
        materials.push(material);
        texcoords.push(wanted);
    }
    Ok(GltfMaterials {
        materials,
        images,
        texcoords,
    })
}

fn read_material(
    reader: &mut Reader<'_>,
    place: &Place<'_>,
    images: &[Image],
) -> Result<(Material, Texcoords), ReadError> {
    let metallic = place.get("pbrMetallicRoughness");
    let glossy = place.dig(&["extensions", "KHR_materials_pbrSpecularGlossiness"]);
    let (surface, factor, texture) = match (metallic, glossy) {
        (None, Some(glossy)) => (Some(glossy), "diffuseFactor", "diffuseTexture"),
        (metallic, _) => (metallic, "baseColorFactor", "baseColorTexture"),
    };
    let mut material = Material {
        name: place.text("name").to_owned(),
        double_sided: place.is_true("doubleSided"),
        alpha_cutoff: alpha_cutoff(place)?,
        blends: place.text("alphaMode") == "BLEND",
        unlit: place.dig(&["extensions", "KHR_materials_unlit"]).is_some(),
        ..Material::default()
    };
    if place.dig(&["extensions", "MSFT_lod"]).is_some() {
        reader.warn(place, "coarser levels of a material are left out");
    }
    let mut texcoords = None;
    if let Some(surface) = surface {
        if let Some(color) = surface.floats::<4>(factor)? {
            material.base_color = Vec4::from_array(color);
        }
        if let Some(texture) = surface.get(texture) {
            texcoords = Some(Texcoords::read(reader, &texture)?);
            material.base_color_image = texture_image(reader, &texture, images)?;
            material.base_color_wrap = wrap(reader, &texture);
        }
    }
    if !material.unlit {
        emissive(reader, place, images, &mut material, &mut texcoords)?;
    }
    Ok((material, texcoords.unwrap_or_default()))
}

/// Reads the light that a material gives off. The picture is looked up with the coordinates of the base
/// colour, so that one with others is left out, and the light with it.
fn emissive(
    reader: &mut Reader<'_>,
    place: &Place<'_>,
    images: &[Image],
    material: &mut Material,
    texcoords: &mut Option<Texcoords>,
) -> Result<(), ReadError> {
    let Some(factor) = place.floats::<3>("emissiveFactor")? else {
        return Ok(());
    };
    let strength = place.dig(&["extensions", "KHR_materials_emissive_strength"]);
    let strength = strength.and_then(|s| s.get("emissiveStrength")?.float().ok());
    let light = Vec3::from_array(factor) * strength.unwrap_or(1.0);
    if light == Vec3::ZERO || !light.is_finite() {
        return Ok(());
    }
    if let Some(texture) = place.get("emissiveTexture") {
        let own = Texcoords::read(reader, &texture)?;
        if *texcoords.get_or_insert(own) != own {
            let what = "the emissive texture has other texture coordinates than the base colour; \
                        shown without its light";
            reader.warn(&texture, what);
            return Ok(());
        }
        material.emissive_image = texture_image(reader, &texture, images)?;
        material.emissive_wrap = wrap(reader, &texture);
    }
    material.emissive = light.max(Vec3::ZERO);
    Ok(())
}

/// Alpha below which a surface is cut; a mixed one, whose mixture is not drawn, where it is less than
/// half opaque.
fn alpha_cutoff(place: &Place<'_>) -> Result<f32, ReadError> {
    match place.text("alphaMode") {
        "MASK" => place
            .get("alphaCutoff")
            .map_or(Ok(0.5), |cutoff| cutoff.float()),
        "BLEND" => Ok(0.5),
        _ => Ok(0.0),
    }
}

/// Continuation of a texture beyond its edges.
fn wrap(reader: &Reader<'_>, info: &Place<'_>) -> [TextureWrap; 2] {
    let texture = reader.root.entry_of("textures", info, "index").ok();
    let sampler = texture.and_then(|t| reader.root.entry_of("samplers", &t, "sampler").ok());
    ["wrapS", "wrapT"].map(|key| {
        let mode = sampler.as_ref().and_then(|s| s.get(key)?.whole().ok());
        match mode {
            Some(CLAMP_TO_EDGE) => TextureWrap::Clamp,
            Some(MIRRORED_REPEAT) => TextureWrap::Mirror,
            _ => TextureWrap::Repeat,
        }
    })
}

/// Returns the picture of a texture: the first of PNG, JPEG or WebP, else the first of any format.
fn texture_image(
    reader: &mut Reader<'_>,
    info: &Place<'_>,
    images: &[Image],
) -> Result<Option<usize>, ReadError> {
    let texture = reader.root.entry_of("textures", info, "index")?;
    let own = texture.index("source", images.len())?;
    let named = || sources(texture.value()).filter(|source| *source < images.len());
    let shown = named().find(|i| is_shown(&images[*i].mime_type));
    let image = shown.or(own).or_else(|| named().next());
    if image.is_none() {
        reader.warn(&texture, "it names no picture; shown without it");
    }
    Ok(image)
}

/// Whether a picture of a media type can be decoded; one of an unknown type may be.
fn is_shown(mime: &str) -> bool {
    matches!(mime, "image/png" | "image/jpeg" | "image/webp" | "")
}

fn read_images(reader: &mut Reader<'_>) -> Result<Vec<Image>, ReadError> {
    let mut images = Vec::new();
    let mut spent = 0u64;
    for (i, place) in reader.root.entries("images")?.iter().enumerate() {
        let fetched = reader.document.pictures.get(i).and_then(Option::as_deref);
        let bytes = match fetched {
            Some(bytes) => bytes,
            None if place.has("bufferView") => reader.buffer_view(place)?.0,
            None => &[],
        };
        // Counted, since many entries may name one large view.
        spent = spent.saturating_add(bytes.len() as u64);
        Limits::check(place, "bytes of pictures", spent, reader.limits.bytes)?;
        images.push(Image {
            name: place.text("name").to_owned(),
            mime_type: mime_type(place.text("mimeType"), bytes),
            bytes: bytes.to_vec(),
        });
    }
    Ok(images)
}
