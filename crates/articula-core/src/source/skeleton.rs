//! The joint tree of a character at rest.

use crate::math::Transform;

/// One joint of a [`Skeleton`].
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name as the file has it; may be empty, need not be unique.
    pub name: String,
    /// Index of the parent in the same skeleton, always smaller than the joint's own.
    pub parent: Option<usize>,
    /// Local transform at rest.
    pub rest: Transform,
    /// Whether a skin (or the format itself) names it a joint. Other nodes are kept only
    /// because they carry a mesh, are animated, or stand above something that is kept.
    pub in_skin: bool,
}

/// A joint forest, parents before children.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Skeleton {
    /// The joints; a root has no parent.
    pub joints: Vec<Joint>,
}

impl Skeleton {
    /// Index of the first joint with this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|j| j.name == name)
    }
}
