//! Materials and pictures.

use super::Scene;

/// The colours of a material.
pub(in crate::fbx) struct Surface<'s> {
    pub(in crate::fbx) name: &'s str,
    pub(in crate::fbx) color: [f64; 3],
    pub(in crate::fbx) opacity: f64,
    pub(in crate::fbx) texture: Option<usize>,
    pub(in crate::fbx) opacity_texture: Option<usize>,
    pub(in crate::fbx) is_unlit: bool,
}

/// A picture of a material.
#[derive(Clone, Copy)]
pub(in crate::fbx) struct Texture<'s>(&'s fbx_rs::Texture);

impl Scene {
    /// The material of a part of a node's mesh.
    pub(in crate::fbx) fn material(&self, node: usize, mesh: usize, slot: usize) -> Option<usize> {
        let of_node = self.file.nodes()[node].materials();
        let of_mesh = self.file.meshes()[mesh].materials();
        of_node.get(slot).or_else(|| of_mesh.get(slot)).copied()
    }

    pub(in crate::fbx) fn surface(&self, material: usize) -> Surface<'_> {
        let material = &self.file.materials()[material];
        let map = |name: &str, own: &str| {
            let of_pbr = material.pbr_map(name);
            of_pbr
                .filter(|m| m.has_value || m.texture.is_some())
                .or_else(|| material.fbx_map(own))
        };
        let color = map("base_color", "diffuse_color");
        let factor = map("base_factor", "diffuse_factor").filter(|m| m.has_value);
        let factor = factor.map_or(1.0, |m| m.value[0]);
        let plain = color.filter(|m| m.has_value).map_or([1.0; 3], |m| {
            let [r, g, b, _] = m.value;
            [r * factor, g * factor, b * factor]
        });
        let shown = |m: &&fbx_rs::MaterialMap| m.texture_enabled;
        let texture = color.filter(shown).and_then(|m| m.texture);
        let clear = material.fbx_map("transparency_color");
        Surface {
            name: material.name(),
            color: if texture.is_some() { [1.0; 3] } else { plain },
            opacity: opacity(material),
            texture,
            opacity_texture: clear.and_then(|m| m.texture),
            is_unlit: material.feature("unlit").is_some_and(|f| f.enabled),
        }
    }

    /// A picture; of several layers the first.
    pub(in crate::fbx) fn texture(&self, texture: usize) -> Texture<'_> {
        let all = self.file.textures();
        let layer = all[texture].file_textures().first();
        Texture(&all[layer.copied().unwrap_or(texture)])
    }
}

impl<'s> Texture<'s> {
    pub(in crate::fbx) fn name(self) -> &'s str {
        self.0.name()
    }

    /// Bytes of the picture in the file, or empty.
    pub(in crate::fbx) fn content(self) -> &'s [u8] {
        self.0.content()
    }

    /// Paths of the picture, the one relative to the file first.
    pub(in crate::fbx) fn paths(self) -> [&'s str; 3] {
        [
            self.0.relative_filename(),
            self.0.filename(),
            self.0.absolute_filename(),
        ]
    }

    /// Whether it goes on along u and v by its edge, instead of repeating.
    pub(in crate::fbx) fn clamps(self) -> [bool; 2] {
        self.0.wrap().map(|mode| mode == 1)
    }
}

/// Opacity as stored, else what the transparency leaves; a transparency of 1 is a common mistake.
fn opacity(material: &fbx_rs::Material) -> f64 {
    let stored = material.source_property(b"Opacity");
    let of_pbr = material.pbr_map("opacity").filter(|m| m.has_value);
    let opacity = match (stored, of_pbr) {
        (Some(stored), _) => stored.value_real[0],
        (None, Some(map)) => map.value[0],
        (None, None) => {
            let map = |name: &str| material.fbx_map(name).filter(|m| m.has_value);
            let factor = map("transparency_factor").map_or(0.0, |m| m.value[0]);
            let color = map("transparency_color").map_or(0.0, |m| {
                let [r, g, b, _] = m.value;
                (r + g + b) / 3.0
            });
            1.0 - factor * color
        }
    };
    match opacity {
        o if o > 1e-6 => o.min(1.0),
        _ => 1.0,
    }
}
