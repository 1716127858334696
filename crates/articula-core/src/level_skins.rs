//! Skins of joint LODs: the vertices of a character at each level, on one palette.
//!
//! The skin of a merged joint moves with an ancestor, so a coarser level has its own weights and
//! rest positions (`docs/methods/motion-lod.md` part 8). `articula-build` computes them,
//! `articula-formats` stores them.

use crate::mesh::{Binding, Mesh, Morph};
use crate::palette::PaletteMap;
use glam::Vec3;

/// Skin of a character at one level, as arrays over the vertices of the full mesh.
///
/// Texture coordinates, colours, triangles and parts are those of the full mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LevelSkin {
    /// Rest positions, each in the space of its own mesh.
    pub positions: Vec<Vec3>,
    /// Rest normals.
    pub normals: Vec<Vec3>,
    /// Number of influences per vertex; unused ones have weight 0.
    pub influences: usize,
    /// `positions.len() * influences` indices into [`LevelSkins::bindings`].
    pub binding_indices: Vec<u16>,
    /// `positions.len() * influences` weights.
    pub weights: Vec<f32>,
    /// Morph targets; slots are those of the full mesh.
    pub morphs: Vec<Morph>,
    /// Number of palette matrices that the level needs: the first ones.
    pub palette: usize,
}

/// Skins of all levels of a character.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelSkins {
    /// Joints and inverse binds in the order of the joint LODs; a level uses a prefix.
    pub bindings: Vec<Binding>,
    /// The bindings by position in the joint order, as the frame loop needs them.
    pub palette: PaletteMap,
    /// One skin per level; the first equals the full character's bit for bit, except for the order
    /// of its bindings.
    pub levels: Vec<LevelSkin>,
}

impl LevelSkins {
    /// Returns the mesh of a level; `full` is the mesh that the skins were made from.
    ///
    /// # Panics
    /// If the level does not exist, or the number of vertices differs.
    pub fn mesh(&self, level: usize, full: &Mesh) -> Mesh {
        let skin = &self.levels[level];
        assert_eq!(
            skin.positions.len(),
            full.len(),
            "the mesh must be the one that the skins were built from"
        );
        Mesh {
            positions: skin.positions.clone(),
            normals: skin.normals.clone(),
            texcoords: full.texcoords.clone(),
            colors: full.colors.clone(),
            influences: skin.influences,
            binding_indices: skin.binding_indices.clone(),
            weights: skin.weights.clone(),
            bindings: self.bindings[..skin.palette].to_vec(),
            triangles: full.triangles.clone(),
            parts: full.parts.clone(),
            morphs: skin.morphs.clone(),
            morph_weights: full.morph_weights.clone(),
            morph_slots: full.morph_slots.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::JointLods;
    use crate::rig::tests::rig_of;
    use glam::{Affine3A, Vec2, Vec4};

    #[test]
    fn a_level_has_its_own_skin_and_the_surface_of_the_full_mesh() {
        let binding = |joint| Binding {
            joint,
            inverse_bind: Affine3A::IDENTITY,
        };
        let morph = |x| Morph {
            slot: 0,
            vertices: vec![1],
            positions: vec![Vec3::splat(x)],
            normals: vec![Vec3::ZERO],
        };
        let full = Mesh {
            positions: vec![Vec3::ZERO; 2],
            normals: vec![Vec3::X; 2],
            texcoords: vec![Vec2::X, Vec2::Y],
            colors: vec![Vec4::X, Vec4::ONE],
            influences: 2,
            binding_indices: vec![0, 1, 2, 0],
            weights: vec![0.5, 0.5, 0.25, 0.75],
            bindings: [0, 1, 2].map(binding).to_vec(),
            triangles: vec![[0, 1, 1]],
            morphs: vec![morph(1.0)],
            morph_weights: vec![0.5],
            morph_slots: vec![0],
            ..Mesh::default()
        };
        let coarse = LevelSkin {
            positions: vec![Vec3::Y, Vec3::Z],
            normals: vec![Vec3::Y; 2],
            influences: 1,
            binding_indices: vec![0, 1],
            weights: vec![1.0; 2],
            morphs: vec![morph(2.0)],
            palette: 2,
        };
        let rig = rig_of(&[
            (None, Vec3::ZERO, 0),
            (Some(0), Vec3::Y, 0),
            (Some(1), Vec3::Y, 0),
        ]);
        let bindings = full.bindings.clone();
        let skins = LevelSkins {
            palette: PaletteMap::joints(&JointLods::whole(&rig).unwrap()),
            bindings,
            levels: vec![LevelSkin::default(), coarse],
        };
        let expected = Mesh {
            positions: vec![Vec3::Y, Vec3::Z],
            normals: vec![Vec3::Y; 2],
            influences: 1,
            binding_indices: vec![0, 1],
            weights: vec![1.0; 2],
            bindings: [0, 1].map(binding).to_vec(),
            morphs: vec![morph(2.0)],
            ..full.clone()
        };
        assert_eq!(skins.mesh(1, &full), expected);
    }
}
