//! The scene of a file. This module and those in it alone name the crate `fbx-rs`.
//!
//! The crate resolves templates of properties, pivots, rotation orders, axes, units and layers of animations:
//! all here is in metres, +Y up, facing +Z. Where a scale is not passed on to children, the crate adds a node
//! that holds it, a *helper*: its name is empty, and it has the number of its parent.

mod faults;
mod looks;
mod shown;
mod stacks;

pub(super) use looks::Texture;
pub(super) use shown::{Mesh, Skin};
pub(super) use stacks::{Moment, Stack};

use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::Transform;
use faults::{bounds, read_error};
use fbx_rs::LoadOptions;
use glam::{DAffine3, DMat3, DQuat, DVec3};

/// A whole file.
pub(in crate::fbx) struct Scene {
    file: fbx_rs::Scene,
    pub(in crate::fbx) nodes: Vec<Node>,
}

/// A local transform.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::fbx) struct Local {
    pub(in crate::fbx) translation: DVec3,
    pub(in crate::fbx) rotation: DQuat,
    pub(in crate::fbx) scale: DVec3,
}

impl Local {
    pub(in crate::fbx) const IDENTITY: Self = Self {
        translation: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
        scale: DVec3::ONE,
    };

    pub(in crate::fbx) fn matrix(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }

    /// The transform in single precision.
    pub(in crate::fbx) fn transform(&self) -> Transform {
        Transform {
            translation: self.translation.as_vec3(),
            rotation: self.rotation.normalize().as_quat(),
            scale: self.scale.as_vec3(),
        }
    }

    fn of(t: &fbx_rs::Transform) -> Self {
        Self {
            translation: t.translation.into(),
            rotation: DQuat::from_array(t.rotation),
            scale: t.scale.into(),
        }
    }
}

/// A node of the scene; the first is the scene itself.
#[derive(Debug)]
pub(in crate::fbx) struct Node {
    pub(in crate::fbx) name: String,
    id: Option<i64>,
    /// Always less than the node's own index.
    pub(in crate::fbx) parent: Option<usize>,
    pub(in crate::fbx) is_helper: bool,
    pub(in crate::fbx) is_bone: bool,
    pub(in crate::fbx) is_camera_or_light: bool,
    pub(in crate::fbx) mesh: Option<usize>,
    pub(in crate::fbx) local: Local,
    /// From the geometry to the node.
    pub(in crate::fbx) geometry: DAffine3,
}

impl Scene {
    /// Reads a file; `at` is where a walk through its records ended, if before its end.
    pub(in crate::fbx) fn load(bytes: &[u8], limits: &Limits, at: &str) -> Result<Self, ReadError> {
        let bounds = bounds(bytes.len() as u64, limits);
        let file = fbx_rs::load_with_limits(bytes, &LoadOptions::default(), &bounds);
        let file = file.map_err(|error| read_error(error, at, &bounds))?;
        Limits::check("scene", "nodes", file.nodes().len() as u64, limits.nodes)?;
        let nodes = file.nodes();
        let of = |node: &fbx_rs::Node| Node {
            name: node.name().to_owned(),
            id: node.source_id(),
            parent: node.parent(),
            is_helper: node.name().is_empty()
                && (node.parent())
                    .is_some_and(|p| p > 0 && nodes[p].source_id() == node.source_id()),
            is_bone: node.bone().is_some(),
            is_camera_or_light: node.camera().is_some() || node.light().is_some(),
            mesh: node.mesh(),
            local: Local::of(node.local_transform()),
            geometry: affine(node.geometry_to_node()),
        };
        Ok(Self {
            nodes: nodes.iter().map(of).collect(),
            file,
        })
    }

    /// Frames per second by which the program that wrote the file shows it.
    pub(in crate::fbx) fn rate_hz(&self) -> f64 {
        self.file.settings().frames_per_second()
    }

    /// The program that wrote the file.
    pub(in crate::fbx) fn creator(&self) -> &str {
        self.file.settings().creator()
    }

    /// Whether the number of a node is one of these, which rise.
    pub(in crate::fbx) fn is_called(&self, node: usize, ids: &[i64]) -> bool {
        self.nodes[node]
            .id
            .is_some_and(|id| ids.binary_search(&id).is_ok())
    }

    /// Numbers of cameras and lights.
    pub(in crate::fbx) fn cameras_and_lights(&self) -> [usize; 2] {
        [self.file.cameras().len(), self.file.lights().len()]
    }

    /// Kinds of objects that are not read, once for each object.
    pub(in crate::fbx) fn left_out(&self) -> impl Iterator<Item = &'static str> {
        use fbx_rs::UnsupportedKind as Kind;
        self.file.unsupported().iter().filter_map(|u| match u.kind {
            Kind::Constraint => Some("a constraint or an IK rig is not read; bake it into keys"),
            Kind::CurveOrSurfaceGeometry => {
                Some("curves and NURBS surfaces are not read; convert them to polygons")
            }
            Kind::Cache => Some("a cache of points is not read; use a skin or blend shapes"),
            Kind::Audio => Some("sound is not read"),
            _ => None,
        })
    }

    /// What the crate says about meshes that it could not read.
    pub(in crate::fbx) fn faults(&self) -> usize {
        self.file.warnings().len()
    }
}

fn affine(m: &fbx_rs::Matrix) -> DAffine3 {
    let [x, y, z, t] = [0, 1, 2, 3].map(|i| DVec3::from(m.column(i)));
    DAffine3 {
        matrix3: DMat3::from_cols(x, y, z),
        translation: t,
    }
}
