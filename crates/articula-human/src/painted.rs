//! The human with its colours in a picture.

use crate::bake::Canvas;
use crate::charts::{SIDE, unwrapped};
use crate::paint::{Painter, SKIN};
use crate::{person, person_head};
use articula_core::source::{Character, TextureWrap};
use glam::Vec4;

/// The human with a face whose colours are in a picture ([`painted_human`](crate::painted_human)).
#[derive(Debug, Clone, PartialEq)]
pub struct PaintedHuman {
    /// The character, with texture coordinates and white materials. Their base colour image is 0; images are empty,
    /// since this crate writes no picture files.
    pub character: Character,
    /// Width and height of the picture, in px.
    pub side: u32,
    /// Its pixels as bytes of sRGB, row by row from the top.
    pub pixels: Vec<[u8; 3]>,
}

/// Creates the painted human with about this number of triangles.
pub(crate) fn human(triangles: usize) -> PaintedHuman {
    let mut character = person::character(triangles);
    let body = person_head::body();
    let painter = Painter::new(&body);
    let mut canvas = Canvas::new();
    for primitive in character.meshes.iter_mut().flat_map(|m| &mut m.primitives) {
        let material = primitive.material.unwrap_or_default();
        *primitive = unwrapped(primitive, material);
        let vertices = primitive.positions.iter().zip(&primitive.normals);
        let open: Vec<f32> = vertices
            .map(|(p, normal)| painter.openness(material, *p, *normal))
            .collect();
        canvas.fill(primitive, &open, |p, normal| {
            painter.color(material, p, normal)
        });
    }
    for material in &mut character.materials {
        material.base_color = Vec4::ONE;
        material.base_color_image = Some(0);
        material.base_color_wrap = [TextureWrap::Clamp; 2];
    }
    PaintedHuman {
        character,
        side: SIDE,
        pixels: canvas.picture(SKIN),
    }
}
