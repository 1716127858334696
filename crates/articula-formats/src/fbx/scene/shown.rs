//! Meshes, skins and blend shapes.

use super::{Scene, affine};
use fbx_rs::SkinningMethod;
use glam::{DAffine3, DVec3};

/// A mesh: corners of triangles, and attributes by corner.
#[derive(Clone, Copy)]
pub(in crate::fbx) struct Mesh<'s>(&'s fbx_rs::Mesh);

/// A cluster of a skin.
pub(in crate::fbx) struct Cluster {
    pub(in crate::fbx) bone: Option<usize>,
    pub(in crate::fbx) geometry_to_bone: DAffine3,
    /// World transform of the bone when it was bound.
    pub(in crate::fbx) bound: DAffine3,
}

/// A skin of a mesh.
#[derive(Clone, Copy)]
pub(in crate::fbx) struct Skin<'s> {
    file: &'s fbx_rs::Scene,
    skin: &'s fbx_rs::SkinDeformer,
}

/// A channel of blend shapes, and the amounts at which its targets have their full effect, rising.
pub(in crate::fbx) struct ShapeChannel {
    /// Index of the channel in poses.
    pub(in crate::fbx) index: usize,
    pub(in crate::fbx) name: String,
    /// Its stored amount; 1 is 100 %.
    pub(in crate::fbx) amount: f64,
    pub(in crate::fbx) targets: Vec<(f64, usize)>,
}

impl Scene {
    pub(in crate::fbx) fn mesh(&self, index: usize) -> Mesh<'_> {
        Mesh(&self.file.meshes()[index])
    }

    /// The skins of a mesh.
    pub(in crate::fbx) fn skins(&self, mesh: usize) -> Vec<Skin<'_>> {
        let file = &self.file;
        let list = file.meshes()[mesh].skin_deformers().iter();
        list.map(|&at| Skin {
            file,
            skin: &file.skin_deformers()[at],
        })
        .collect()
    }

    /// The channels of blend shapes of a mesh.
    pub(in crate::fbx) fn channels(&self, mesh: usize) -> Vec<ShapeChannel> {
        let deformers = self.file.meshes()[mesh].blend_deformers().iter();
        let channels = deformers.flat_map(|&at| &self.file.blend_deformers()[at].channels);
        channels
            .map(|&index| {
                let channel = &self.file.blend_channels()[index];
                let keys = channel.keyframes.iter();
                ShapeChannel {
                    index,
                    name: channel.name.clone(),
                    amount: channel.weight,
                    targets: keys.map(|k| (k.target_weight, k.shape)).collect(),
                }
            })
            .collect()
    }

    /// Number of channels of blend shapes of all meshes.
    pub(in crate::fbx) fn channel_count(&self) -> usize {
        self.file.blend_channels().len()
    }

    /// Offsets of a target shape: point, offset of the position, offset of the normal.
    pub(in crate::fbx) fn shape(&self, shape: usize) -> impl Iterator<Item = (u32, DVec3, DVec3)> {
        let shape = &self.file.blend_shapes()[shape];
        let points = shape.offset_vertices.iter().enumerate();
        points
            .zip(&shape.position_offsets)
            .map(|((i, &point), offset)| {
                let weight = shape.offset_weights.get(i).copied().unwrap_or(1.0);
                let normal = shape.normal_offsets.get(i).copied().unwrap_or_default();
                let [offset, normal] = [*offset, normal].map(|v| DVec3::from(v) * weight);
                (point, offset, normal)
            })
    }

    /// Whether a target shape has offsets of normals.
    pub(in crate::fbx) fn bends_normals(&self, shape: usize) -> bool {
        !self.file.blend_shapes()[shape].normal_offsets.is_empty()
    }
}

impl<'s> Mesh<'s> {
    pub(in crate::fbx) fn name(self) -> &'s str {
        self.0.name()
    }

    /// Positions of the control points.
    pub(in crate::fbx) fn points(self) -> &'s [[f64; 3]] {
        self.0.positions().values()
    }

    /// Corners of triangles, three for each.
    pub(in crate::fbx) fn corners(self) -> &'s [u32] {
        self.0.triangles()
    }

    /// Number of nodes that show the mesh.
    pub(in crate::fbx) fn instances(self) -> usize {
        self.0.instances().len()
    }

    /// Control point of a corner.
    pub(in crate::fbx) fn point(self, corner: usize) -> Option<u32> {
        let point = self.0.positions().indices().get(corner).copied();
        point.filter(|p| (*p as usize) < self.points().len())
    }

    pub(in crate::fbx) fn normal(self, corner: usize) -> Option<[f64; 3]> {
        self.0.normals()?.get(corner)
    }

    /// Texture coordinates of a corner; v grows upward.
    pub(in crate::fbx) fn texcoord(self, corner: usize) -> Option<[f64; 2]> {
        self.0.uv_sets().first()?.uv().get(corner)
    }

    pub(in crate::fbx) fn color(self, corner: usize) -> Option<[f64; 4]> {
        self.0.color_sets().first()?.color().get(corner)
    }

    pub(in crate::fbx) fn has_texcoords(self) -> bool {
        !self.0.uv_sets().is_empty()
    }

    pub(in crate::fbx) fn has_colors(self) -> bool {
        !self.0.color_sets().is_empty()
    }

    pub(in crate::fbx) fn has_normals(self) -> bool {
        self.0.normals().is_some()
    }

    /// First corner, number of corners and material slot of each polygon.
    pub(in crate::fbx) fn polygons(self) -> impl Iterator<Item = (usize, usize, usize)> + 's {
        let slots = self.0.face_material();
        let faces = self.0.faces().iter().enumerate();
        faces.map(move |(at, face)| {
            let slot = slots.get(at).copied().unwrap_or(0);
            (face.begin as usize, face.count as usize, slot as usize)
        })
    }
}

impl Skin<'_> {
    pub(in crate::fbx) fn is_linear(self) -> bool {
        let method = self.skin.skinning_method;
        matches!(method, SkinningMethod::Linear | SkinningMethod::Rigid)
    }

    pub(in crate::fbx) fn clusters(self) -> Vec<Cluster> {
        let clusters = self.skin.clusters.iter();
        let clusters = clusters.map(|&at| &self.file.skin_clusters()[at]);
        clusters
            .map(|c| Cluster {
                bone: c.bone_node,
                geometry_to_bone: affine(&c.geometry_to_bone),
                bound: affine(&c.bind_to_world),
            })
            .collect()
    }

    /// Cluster and weight of the influences on a control point.
    pub(in crate::fbx) fn influences(self, point: u32) -> impl Iterator<Item = (usize, f64)> {
        let list = self.skin.vertices.get(point as usize).and_then(|v| {
            let end = v.weight_begin.checked_add(v.num_weights)?;
            self.skin.weights.get(v.weight_begin..end)
        });
        let list = list.unwrap_or_default().iter();
        list.map(|w| (w.cluster_index, w.weight))
    }
}
