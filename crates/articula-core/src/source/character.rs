//! The editable form of a whole character: everything that one file describes.

use super::{Credits, Expression, Property, RawClip, RawMesh, Skeleton};
use crate::articulation::Articulation;
use crate::face_control::FaceControl;
use crate::level_table::LevelTable;
use glam::{Vec3, Vec4};
use std::collections::BTreeMap;

/// Continuation of a texture beyond its edges, along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum TextureWrap {
    /// It repeats.
    #[default]
    Repeat,
    /// It repeats, every second time mirrored.
    Mirror,
    /// The texels of its edge go on.
    Clamp,
}

/// The appearance of a surface, reduced to the parameters that a preview needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name as stored in the file.
    pub name: String,
    /// Base colour factor, linear RGBA.
    pub base_color: Vec4,
    /// Index of the base colour texture in [`Character::images`]; its colours are sRGB.
    pub base_color_image: Option<usize>,
    /// Continuation of the base colour texture along u and v.
    pub base_color_wrap: [TextureWrap; 2],
    /// Alpha below which fragments are discarded; 0 draws all of them.
    pub alpha_cutoff: f32,
    /// Whether the surface is mixed with what is behind it, by its alpha. Where no mixture is drawn,
    /// [`Self::alpha_cutoff`] decides.
    pub blends: bool,
    /// Light that the surface itself gives off, linear RGB; may exceed 1.
    pub emissive: Vec3,
    /// Index of the texture that is multiplied with [`Self::emissive`] in [`Character::images`]; its
    /// colours are sRGB, and it has the coordinates of the base colour texture.
    pub emissive_image: Option<usize>,
    /// Continuation of the emissive texture along u and v.
    pub emissive_wrap: [TextureWrap; 2],
    /// Whether the surface shows its base colour, whatever light falls on it; [`Self::emissive`] has no
    /// effect then.
    pub unlit: bool,
    /// Whether back faces are drawn too.
    pub double_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_image: None,
            base_color_wrap: [TextureWrap::default(); 2],
            alpha_cutoff: 0.0,
            blends: false,
            emissive: Vec3::ZERO,
            emissive_image: None,
            emissive_wrap: [TextureWrap::default(); 2],
            unlit: false,
            double_sided: false,
        }
    }
}

impl Material {
    /// Indices of the textures that the surface shows, in [`Character::images`].
    pub fn images(&self) -> impl Iterator<Item = usize> {
        let images = [self.base_color_image, self.emissive_image];
        images.into_iter().flatten()
    }
}

/// An encoded image (PNG, JPEG, ...), not decoded.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Image {
    /// Name as stored in the file.
    pub name: String,
    /// Media type such as `image/png`, or empty if unknown.
    pub mime_type: String,
    /// The encoded bytes.
    pub bytes: Vec<u8>,
}

/// The editable form of a character: skeleton, meshes, clips, expressions and materials of one
/// file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Character {
    /// Name as stored in the file, or empty.
    pub name: String,
    /// Joint tree in the rest pose.
    pub skeleton: Skeleton,
    /// H-Anim name, level and region of each joint, if the file stores them.
    pub articulation: Option<Articulation>,
    /// Meshes, in the order of the file's nodes.
    pub meshes: Vec<RawMesh>,
    /// Errors of the levels of [`RawMesh::clustered`], if the file stores them.
    pub mesh_levels: Option<LevelTable>,
    /// Animation clips, in the order of the file.
    pub clips: Vec<RawClip>,
    /// Expressions that clips can drive by name.
    pub expressions: Vec<Expression>,
    /// What morph targets and expressions show by their names, where a person said it; `None` for
    /// those that are left out on purpose.
    pub told_controls: BTreeMap<String, Option<FaceControl>>,
    /// Authors, origin and licence, if the file states any.
    pub credits: Option<Credits>,
    /// Materials that primitives refer to by index.
    pub materials: Vec<Material>,
    /// Images that materials refer to by index.
    pub images: Vec<Image>,
}

impl Character {
    /// Scales all lengths: rest translations, vertices, morph targets, inverse bind matrices, and
    /// keys of translations. Scales of joints stay.
    pub fn scale_lengths(&mut self, factor: f32) {
        for joint in &mut self.skeleton.joints {
            joint.rest.translation *= factor;
        }
        for mesh in &mut self.meshes {
            let levels = mesh.levels.iter_mut();
            let levels = levels.map(|level| (&mut level.skin, &mut level.primitives));
            for (skin, primitives) in [(&mut mesh.skin, &mut mesh.primitives)]
                .into_iter()
                .chain(levels)
            {
                for bind in &mut skin.inverse_bind {
                    bind.translation *= factor;
                }
                for primitive in primitives {
                    primitive.positions.iter_mut().for_each(|p| *p *= factor);
                    let offsets = primitive.morphs.iter_mut().flat_map(|m| &mut m.positions);
                    offsets.for_each(|p| *p *= factor);
                }
            }
        }
        let channels = self.clips.iter_mut().flat_map(|clip| &mut clip.channels);
        for channel in channels.filter(|c| c.property == Property::Translation) {
            channel.values.iter_mut().for_each(|x| *x *= factor);
        }
        let bindings = self.expressions.iter_mut().flat_map(|e| &mut e.joints);
        bindings.for_each(|binding| binding.full.translation *= factor);
    }
}
