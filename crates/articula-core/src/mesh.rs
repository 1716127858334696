//! The triangles of a whole character in one vertex array, ready to be skinned.

use crate::Mismatch;
use crate::source;
use glam::{Affine3A, Vec2, Vec3, Vec4};
use std::ops::Range;

/// A joint and its inverse bind matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Binding {
    /// Joint index in the rig.
    pub joint: u16,
    /// Inverse bind matrix: from mesh space to the joint, in the rest pose.
    pub inverse_bind: Affine3A,
}

/// A drawable part of a [`Mesh`]: one primitive of a source mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Name of the source mesh.
    pub name: String,
    /// Index of the source mesh.
    pub mesh: usize,
    /// Index into the character's materials.
    pub material: Option<usize>,
    /// The material by which it is drawn together with parts of other colours: the first from which its own differs in
    /// base colour alone; its own where there is none, or where it is not known.
    pub draw_material: Option<usize>,
    /// Range of its vertices.
    pub vertices: Range<usize>,
    /// Range of its triangles.
    pub triangles: Range<usize>,
}

/// A sparse morph target: offsets of the vertices that it moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Morph {
    /// Index into the morph target weights.
    pub slot: u16,
    /// Indices of the moved vertices, ascending.
    pub vertices: Vec<u32>,
    /// Position offset of each moved vertex.
    pub positions: Vec<Vec3>,
    /// Normal offset of each moved vertex.
    pub normals: Vec<Vec3>,
}

/// The triangles of a character with skin and morph targets, as structure of arrays.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Rest positions, each in the space of its source mesh.
    pub positions: Vec<Vec3>,
    /// Rest normals; computed from the triangles if the source has none.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, zero if the source has none.
    pub texcoords: Vec<Vec2>,
    /// Linear RGBA vertex colours, white if the source has none.
    pub colors: Vec<Vec4>,
    /// Number of influences per vertex, the maximum over all parts; unused ones have weight 0.
    pub influences: usize,
    /// `positions.len() * influences` indices into `bindings`.
    pub binding_indices: Vec<u16>,
    /// `positions.len() * influences` weights, summing to 1 for each vertex.
    pub weights: Vec<f32>,
    /// Distinct pairs of joint and inverse bind matrix, one for each palette matrix.
    pub bindings: Vec<Binding>,
    /// Vertex indices of the triangles of all parts, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// The drawable parts.
    pub parts: Vec<Part>,
    /// Morph targets of all parts.
    pub morphs: Vec<Morph>,
    /// Default weight of each morph slot.
    pub morph_weights: Vec<f32>,
    /// First morph slot of each source mesh; its morph targets are contiguous.
    pub morph_slots: Vec<usize>,
}

impl Mesh {
    /// Joins the meshes of a character whose rig has `joints` joints.
    ///
    /// # Errors
    /// A [`Mismatch`] if array lengths of a primitive disagree, an index of a joint, vertex or
    /// morph target is out of range, or there are more than 65536 bindings or morph targets.
    pub fn new(meshes: &[source::RawMesh], joints: usize) -> Result<Self, Mismatch> {
        let most = meshes
            .iter()
            .flat_map(|m| m.primitives.iter().map(|p| p.influences))
            .max();
        let mut mesh = Self {
            influences: most.unwrap_or(1).max(1),
            ..Self::default()
        };
        for (m, source) in meshes.iter().enumerate() {
            let palette = mesh.bind(&source.skin, joints).map_err(|e| within(m, e))?;
            mesh.morph_slots.push(mesh.morph_weights.len());
            mesh.morph_weights.extend(&source.morph_weights);
            if mesh.morph_weights.len() > usize::from(u16::MAX) + 1 {
                let what = "more than 65536 morph targets in all meshes";
                return Err(within(m, Mismatch::new("morph_weights", what)));
            }
            for (p, primitive) in source.primitives.iter().enumerate() {
                mesh.append(m, source, primitive, &palette).map_err(|e| {
                    within(
                        m,
                        Mismatch::new(format!("primitives[{p}].{}", e.at), e.what),
                    )
                })?;
            }
        }
        Ok(mesh)
    }

    /// Returns the number of vertices.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Returns whether there is no vertex.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Returns the influences of a vertex as (joint, weight), without zero weights.
    pub fn influences_of(&self, vertex: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        let at = vertex * self.influences..(vertex + 1) * self.influences;
        self.binding_indices[at.clone()]
            .iter()
            .zip(&self.weights[at])
            .filter(|(_, w)| **w > 0.0)
            .map(|(b, w)| (usize::from(self.bindings[usize::from(*b)].joint), *w))
    }

    fn bind(&mut self, skin: &source::Skin, joints: usize) -> Result<Vec<u16>, Mismatch> {
        if skin.joints.len() != skin.inverse_bind.len() {
            let what = format!(
                "{} matrices for {} joints",
                skin.inverse_bind.len(),
                skin.joints.len()
            );
            return Err(Mismatch::new("skin.inverse_bind", what));
        }
        let mut palette = Vec::with_capacity(skin.joints.len());
        for (i, (&joint, &inverse_bind)) in skin.joints.iter().zip(&skin.inverse_bind).enumerate() {
            if joint >= joints {
                let what =
                    format!("joint {joint} is out of range: the skeleton has {joints} joints");
                return Err(Mismatch::new(format!("skin.joints[{i}]"), what));
            }
            let binding = Binding {
                joint: joint as u16,
                inverse_bind,
            };
            let at = match self.bindings.iter().position(|b| *b == binding) {
                Some(at) => at,
                None => {
                    self.bindings.push(binding);
                    self.bindings.len() - 1
                }
            };
            let at = u16::try_from(at)
                .map_err(|_| Mismatch::new("skin.joints", "more than 65536 bindings"))?;
            palette.push(at);
        }
        Ok(palette)
    }

    fn append(
        &mut self,
        index: usize,
        mesh: &source::RawMesh,
        primitive: &source::Primitive,
        palette: &[u16],
    ) -> Result<(), Mismatch> {
        check(primitive, palette.len(), mesh.morph_weights.len())?;
        let first = self.positions.len();
        let count = primitive.positions.len();
        self.positions.extend(&primitive.positions);
        if primitive.normals.is_empty() {
            self.normals.extend(smooth_normals(primitive));
        } else {
            self.normals.extend(&primitive.normals);
        }
        self.texcoords.extend(&primitive.texcoords);
        self.texcoords.resize(first + count, Vec2::ZERO);
        self.colors.extend(&primitive.colors);
        self.colors.resize(first + count, Vec4::ONE);
        for v in 0..count {
            let at = v * primitive.influences..(v + 1) * primitive.influences;
            self.binding_indices.extend(
                primitive.joints[at.clone()]
                    .iter()
                    .map(|j| palette[usize::from(*j)]),
            );
            self.weights.extend(&primitive.weights[at]);
            let padded = (first + v + 1) * self.influences;
            // A padded influence repeats the vertex's first binding, with weight 0.
            let filler = self.binding_indices[(first + v) * self.influences];
            self.binding_indices.resize(padded, filler);
            self.weights.resize(padded, 0.0);
        }
        let first_triangle = self.triangles.len();
        let offset = first as u32;
        self.triangles
            .extend(primitive.triangles.iter().map(|t| t.map(|v| v + offset)));
        for (t, target) in primitive.morphs.iter().enumerate() {
            let slot = self.morph_slots[index] + t;
            self.morphs.extend(sparse(target, slot as u16, first));
        }
        self.parts.push(Part {
            name: mesh.name.clone(),
            mesh: index,
            material: primitive.material,
            draw_material: primitive.material,
            vertices: first..first + count,
            triangles: first_triangle..self.triangles.len(),
        });
        Ok(())
    }
}

fn within(mesh: usize, e: Mismatch) -> Mismatch {
    Mismatch::new(format!("meshes[{mesh}].{}", e.at), e.what)
}

fn check(p: &source::Primitive, joints: usize, morphs: usize) -> Result<(), Mismatch> {
    let count = p.positions.len();
    let length = |what: &str, found: usize, expected: usize| {
        if found == expected {
            return Ok(());
        }
        Err(Mismatch::new(
            what,
            format!("{found} values, expected {expected}"),
        ))
    };
    let optional = |what: &str, found: usize| match found {
        0 => Ok(()),
        _ => length(what, found, count),
    };
    if p.influences == 0 {
        return Err(Mismatch::new("influences", "must be at least 1"));
    }
    optional("normals", p.normals.len())?;
    optional("texcoords", p.texcoords.len())?;
    optional("colors", p.colors.len())?;
    length("joints", p.joints.len(), count * p.influences)?;
    length("weights", p.weights.len(), count * p.influences)?;
    length("morphs", p.morphs.len(), morphs)?;
    for target in &p.morphs {
        length("morphs.positions", target.positions.len(), count)?;
        optional("morphs.normals", target.normals.len())?;
    }
    if let Some(at) = p.joints.iter().position(|j| usize::from(*j) >= joints) {
        let what = format!(
            "skin joint {} is out of range: the skin has {joints} joints",
            p.joints[at]
        );
        return Err(Mismatch::new(format!("joints[{at}]"), what));
    }
    let outside = |t: &[u32; 3]| t.iter().any(|v| *v as usize >= count);
    if let Some(at) = p.triangles.iter().position(outside) {
        let what = format!(
            "{:?} names a vertex out of range: the primitive has {count} vertices",
            p.triangles[at]
        );
        return Err(Mismatch::new(format!("triangles[{at}]"), what));
    }
    Ok(())
}

/// Area-weighted vertex normals; vertices at the same position share one, so seams stay smooth.
fn smooth_normals(primitive: &source::Primitive) -> Vec<Vec3> {
    let p = &primitive.positions;
    let mut sums = std::collections::HashMap::<[u32; 3], Vec3>::new();
    let key = |v: u32| p[v as usize].to_array().map(f32::to_bits);
    for t in &primitive.triangles {
        let [a, b, c] = t.map(|v| p[v as usize]);
        let normal = (b - a).cross(c - a);
        for v in t {
            *sums.entry(key(*v)).or_default() += normal;
        }
    }
    (0..p.len() as u32)
        .map(|v| {
            sums.get(&key(v))
                .map_or(Vec3::Y, |n| n.try_normalize().unwrap_or(Vec3::Y))
        })
        .collect()
}

fn sparse(target: &source::MorphTarget, slot: u16, first: usize) -> Option<Morph> {
    let moves = |v: &usize| {
        target.positions[*v] != Vec3::ZERO
            || target.normals.get(*v).is_some_and(|n| *n != Vec3::ZERO)
    };
    let vertices: Vec<usize> = (0..target.positions.len()).filter(moves).collect();
    (!vertices.is_empty()).then(|| Morph {
        slot,
        positions: vertices.iter().map(|v| target.positions[*v]).collect(),
        normals: vertices
            .iter()
            .map(|v| target.normals.get(*v).copied().unwrap_or(Vec3::ZERO))
            .collect(),
        vertices: vertices.iter().map(|v| (first + v) as u32).collect(),
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// One triangle; two corners on joint 0, one on joint 1.
    pub(crate) fn triangle() -> source::RawMesh {
        source::RawMesh {
            name: "t".into(),
            skin: source::Skin {
                joints: vec![0, 1],
                inverse_bind: vec![Affine3A::IDENTITY, Affine3A::from_translation(-Vec3::Y)],
            },
            primitives: vec![source::Primitive {
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                influences: 1,
                joints: vec![0, 0, 1],
                weights: vec![1.0; 3],
                triangles: vec![[0, 1, 2]],
                morphs: vec![source::MorphTarget {
                    positions: vec![Vec3::ZERO, Vec3::Z, Vec3::ZERO],
                    normals: vec![],
                }],
                ..source::Primitive::default()
            }],
            morph_names: vec!["bulge".into()],
            morph_weights: vec![0.0],
            ..source::RawMesh::default()
        }
    }

    #[test]
    fn joins_meshes_and_shares_bindings() {
        let mesh = Mesh::new(&[triangle(), triangle()], 2).unwrap();
        assert_eq!(
            (mesh.len(), mesh.triangles.len(), mesh.parts.len()),
            (6, 2, 2)
        );
        assert_eq!(mesh.bindings.len(), 2, "equal bindings are stored once");
        assert_eq!(mesh.triangles[1], [3, 4, 5]);
        assert_eq!(mesh.normals[0], Vec3::Z, "normals come from the triangles");
        assert_eq!(mesh.morphs[1].vertices, [4]);
        assert_eq!(mesh.morphs[1].slot, 1);
    }

    #[test]
    fn refuses_indices_out_of_range() {
        let at = |mesh: source::RawMesh, joints| Mesh::new(&[mesh], joints).unwrap_err().at;
        assert_eq!(at(triangle(), 1), "meshes[0].skin.joints[1]");
        let mut bad = triangle();
        bad.primitives[0].triangles[0][2] = 3;
        assert_eq!(at(bad, 2), "meshes[0].primitives[0].triangles[0]");
        let mut bad = triangle();
        bad.primitives[0].joints[0] = 2;
        assert_eq!(at(bad, 2), "meshes[0].primitives[0].joints[0]");
        let mut bad = triangle();
        bad.primitives[0].weights.pop();
        assert_eq!(at(bad, 2), "meshes[0].primitives[0].weights");
        let bad = source::RawMesh {
            primitives: vec![],
            morph_weights: vec![0.0; 65537],
            ..triangle()
        };
        assert_eq!(at(bad, 2), "meshes[0].morph_weights");
    }
}
