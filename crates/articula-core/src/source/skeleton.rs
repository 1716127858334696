//! The joint tree of a character in the rest pose.

use crate::local_extent::{RestJoint, local_extents};
use crate::math::Transform;
use glam::Affine3A;

/// One joint of a [`Skeleton`].
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name as stored in the file; may be empty, need not be unique.
    pub name: String,
    /// Index of the parent in the same skeleton, always smaller than the joint's own index.
    pub parent: Option<usize>,
    /// Local transform in the rest pose.
    pub rest: Transform,
    /// Whether a skin, or the format itself, declares it a joint. Other nodes are kept only if they
    /// carry a mesh, are animated, or are ancestors of a kept node.
    pub in_skin: bool,
}

/// A joint hierarchy, parents before children; several roots are allowed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Skeleton {
    /// The joints; a root has no parent.
    pub joints: Vec<Joint>,
}

impl Skeleton {
    /// Returns, for each joint, the greatest extent of the figure at rest along a model axis in the
    /// units of the joint's translation.
    ///
    /// The extent is that of the joints of skins, or of all joints if there is no such joint. A figure
    /// without extent counts as 1 m tall.
    pub fn local_extents(&self) -> Vec<f32> {
        let joint = |joint: &Joint| RestJoint {
            parent: joint.parent,
            rest: joint.rest,
            in_skin: joint.in_skin,
        };
        local_extents(&self.joints.iter().map(joint).collect::<Vec<_>>())
    }

    /// Returns the rest transform of every joint in model space, in metres. A joint whose parent does
    /// not come before it counts as a root.
    pub fn model_rest(&self) -> Vec<Affine3A> {
        let mut model: Vec<Affine3A> = Vec::with_capacity(self.joints.len());
        for joint in &self.joints {
            let above = joint.parent.and_then(|p| model.get(p)).copied();
            let above = above.unwrap_or(Affine3A::IDENTITY);
            model.push(above * joint.rest.to_affine());
        }
        model
    }

    /// Returns the index of the first joint with this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|j| j.name == name)
    }
}
