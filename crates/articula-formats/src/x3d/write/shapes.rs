//! Shapes: triangles with their values, colours, pictures.
//!
//! A picture is embedded as a data URI, so that one file is the whole figure. Source: ISO/IEC
//! 19775-1, 13.3.6 (IndexedFaceSet), clause 12 and 18.

use super::super::names::Names;
use super::bodies::Body;
use super::markup::Markup;
use crate::uri::mime_type;
use articula_core::Libm;
use articula_core::source::{Character, Material, Primitive, RawMesh, TextureWrap};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;

/// Crease angle that makes every edge smooth, for primitives without normals.
const SMOOTH: f32 = std::f32::consts::PI;

/// Appearances written so far, so that each is written once.
#[derive(Debug)]
pub(super) struct Shapes<'c> {
    character: &'c Character,
    appearances: Vec<Option<String>>,
    /// Names of the textures written so far, by picture and continuation.
    textures: Vec<((usize, [TextureWrap; 2]), String)>,
}

impl<'c> Shapes<'c> {
    pub(super) fn new(character: &'c Character) -> Self {
        Self {
            character,
            appearances: vec![None; character.materials.len()],
            textures: Vec::new(),
        }
    }

    /// Writes the primitives of a body; `coord` is the name of its list of points.
    pub(super) fn write(
        &mut self,
        markup: &mut Markup,
        names: &mut Names,
        body: &Body,
        coord: &str,
    ) {
        let mesh: &RawMesh = &self.character.meshes[body.mesh];
        let mut first = body.first_point;
        for (primitive, normals) in mesh.primitives.iter().zip(&body.normals) {
            markup.open("Shape");
            self.appearance(markup, names, primitive.material);
            let of = |m: usize| self.character.materials.get(m);
            let double_sided = primitive
                .material
                .and_then(of)
                .is_some_and(|m| m.double_sided);
            markup.open("IndexedFaceSet");
            if double_sided {
                markup.set("solid", "false");
            }
            if normals.is_empty() {
                markup.numbers("creaseAngle", 1, [SMOOTH]);
            }
            let corners = |offset: usize| {
                let of = move |t: &[u32; 3]| {
                    let [a, b, c] = t.map(|i| i64::from(i) + offset as i64);
                    [a, b, c, -1]
                };
                primitive.triangles.iter().flat_map(of)
            };
            markup.numbers("coordIndex", 4, corners(first));
            for (list, index) in [
                (primitive.texcoords.is_empty(), "texCoordIndex"),
                (normals.is_empty(), "normalIndex"),
                (primitive.colors.is_empty(), "colorIndex"),
            ] {
                if !list {
                    markup.numbers(index, 4, corners(0));
                }
            }
            markup.open("Coordinate").set("USE", coord);
            markup.close();
            values(markup, primitive, normals);
            markup.close();
            markup.close();
            first += primitive.positions.len();
        }
    }

    fn appearance(&mut self, markup: &mut Markup, names: &mut Names, material: Option<usize>) {
        let Some((index, material)) =
            material.and_then(|m| Some((m, self.character.materials.get(m)?)))
        else {
            return;
        };
        markup.open("Appearance");
        if let Some(known) = &self.appearances[index] {
            markup.set("USE", known);
            markup.close();
            return;
        }
        let name = names.give(&format!("{}_look", material.name), "look");
        markup.set("DEF", &name);
        self.appearances[index] = Some(name);
        if material.blends {
            markup.set("alphaMode", "BLEND");
        } else if material.alpha_cutoff > 0.0 {
            markup.set("alphaMode", "MASK");
            markup.numbers("alphaCutoff", 1, [material.alpha_cutoff]);
        }
        self.material(markup, names, material);
        if let Some(image) = material.base_color_image {
            self.texture(markup, names, (image, material.base_color_wrap), None);
        }
        markup.close();
    }

    fn material(&mut self, markup: &mut Markup, names: &mut Names, material: &Material) {
        let [r, g, b, a] = material.base_color.to_array();
        let (kind, color) = match material.unlit {
            true => ("UnlitMaterial", "emissiveColor"),
            false => ("Material", "diffuseColor"),
        };
        markup.open(kind);
        markup.set("DEF", &names.give(&material.name, "material"));
        markup.numbers(color, 3, [r, g, b].map(srgb));
        // An unlit surface has its base colour in this field, and gives off no other light.
        let emits = !material.unlit;
        if emits && material.emissive != Vec3::ZERO {
            let light = material.emissive.to_array().map(srgb);
            markup.numbers("emissiveColor", 3, light);
        }
        if a < 1.0 {
            markup.numbers("transparency", 1, [1.0 - a]);
        }
        if let Some(image) = material.emissive_image.filter(|_| emits) {
            let field = Some("emissiveTexture");
            self.texture(markup, names, (image, material.emissive_wrap), field);
        }
        markup.close();
    }

    /// Writes a texture, in a field of its parent other than `texture` if one is named.
    fn texture(
        &mut self,
        markup: &mut Markup,
        names: &mut Names,
        (index, wrap): (usize, [TextureWrap; 2]),
        field: Option<&str>,
    ) {
        let Some(image) = self.character.images.get(index) else {
            return;
        };
        markup.open("ImageTexture");
        if let Some(field) = field {
            markup.set("containerField", field);
        }
        let known = self.textures.iter().find(|(key, _)| *key == (index, wrap));
        if let Some((_, known)) = known {
            markup.set("USE", known);
            markup.close();
            return;
        }
        let name = names.give(&image.name, "picture");
        let mime = match mime_type(&image.mime_type, &image.bytes) {
            mime if mime.is_empty() => "application/octet-stream".to_owned(),
            mime => mime,
        };
        let url = format!("\"data:{mime};base64,{}\"", STANDARD.encode(&image.bytes));
        markup.set("DEF", &name).set("url", &url);
        write_wrap(markup, wrap);
        markup.close();
        self.textures.push(((index, wrap), name));
    }
}

/// Writes how a texture goes on: nothing if it repeats.
fn write_wrap(markup: &mut Markup, wrap: [TextureWrap; 2]) {
    for (axis, field) in wrap.into_iter().zip(["repeatS", "repeatT"]) {
        if axis == TextureWrap::Clamp {
            markup.set(field, "false");
        }
    }
    if wrap.contains(&TextureWrap::Mirror) {
        markup.open("TextureProperties");
        for (axis, field) in wrap.into_iter().zip(["boundaryModeS", "boundaryModeT"]) {
            let mode = match axis {
                TextureWrap::Repeat => "REPEAT",
                TextureWrap::Mirror => "MIRRORED_REPEAT",
                TextureWrap::Clamp => "CLAMP_TO_EDGE",
            };
            markup.set(field, mode);
        }
        markup.close();
    }
}

fn values(markup: &mut Markup, primitive: &Primitive, normals: &[Vec3]) {
    if !primitive.texcoords.is_empty() {
        let up = primitive.texcoords.iter().flat_map(|t| [t.x, 1.0 - t.y]);
        markup.open("TextureCoordinate").numbers("point", 2, up);
        markup.close();
    }
    if !normals.is_empty() {
        let vectors = normals.iter().flat_map(|n| n.to_array());
        markup.open("Normal").numbers("vector", 3, vectors);
        markup.close();
    }
    if !primitive.colors.is_empty() {
        let colors = primitive.colors.iter();
        let colors = colors.flat_map(|c| [srgb(c.x), srgb(c.y), srgb(c.z), c.w]);
        markup.open("ColorRGBA").numbers("color", 4, colors);
        markup.close();
    }
}

/// Converts a linear colour value to sRGB.
fn srgb(linear: f32) -> f32 {
    let c = f64::from(linear.clamp(0.0, 1.0));
    let srgb = if c <= 0.003_130_8 {
        c * 12.92
    } else {
        1.055 * c.libm_powf(1.0 / 2.4) - 0.055
    };
    srgb as f32
}
