//! Size of a figure in the units of each joint's translation.
//!
//! Files scale figures by joints above the skeleton, so a translation of 0.01 may be a centimetre or
//! a metre. What counts as still or as straight is therefore a share of the figure.

use crate::math::Transform;
use glam::{Affine3A, Vec3A};

/// A joint as [`local_extents`] takes it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RestJoint {
    /// Index of the parent, smaller than the joint's own.
    pub(crate) parent: Option<usize>,
    /// Local transform at rest.
    pub(crate) rest: Transform,
    /// Whether the joint belongs to the figure, as opposed to props and scene nodes.
    pub(crate) in_skin: bool,
}

/// Returns, for each joint, the greatest extent of the figure at rest along a model axis in the
/// units of the joint's translation.
///
/// The extent is that of the joints of skins, or of all joints if there is no such joint. A figure
/// without extent counts as 1 m tall.
///
/// # Panics
/// If a joint is not after its parent.
pub(crate) fn local_extents(joints: &[RestJoint]) -> Vec<f32> {
    let mut model: Vec<Affine3A> = Vec::with_capacity(joints.len());
    let mut scales = Vec::with_capacity(joints.len());
    for joint in joints {
        let above = joint.parent.map_or(Affine3A::IDENTITY, |p| model[p]);
        let axes = above.matrix3.to_cols_array_2d().map(Vec3A::from_array);
        scales.push(
            axes.map(|axis| axis.length())
                .into_iter()
                .fold(0.0, f32::max),
        );
        model.push(above * joint.rest.to_affine());
    }
    let is_any = joints.iter().any(|j| j.in_skin);
    let places = joints.iter().zip(&model);
    let of_figure = places.filter(|(joint, _)| joint.in_skin || !is_any);
    let (low, high) = of_figure.fold(
        (Vec3A::splat(f32::MAX), Vec3A::splat(f32::MIN)),
        |(low, high), (_, place)| (low.min(place.translation), high.max(place.translation)),
    );
    let extent = match (high - low).max_element() {
        extent if extent.is_finite() && extent > 0.0 => extent,
        _ => 1.0,
    };
    let local = |scale: f32| if scale > 0.0 { extent / scale } else { extent };
    scales.into_iter().map(local).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn joint(parent: Option<usize>, y: f32, scale: f32) -> RestJoint {
        RestJoint {
            parent,
            rest: Transform {
                translation: Vec3::Y * y,
                scale: Vec3::splat(scale),
                ..Transform::IDENTITY
            },
            in_skin: parent.is_some(),
        }
    }

    #[test]
    fn a_figure_below_a_scaled_node_by_hand() {
        // Centimetres below a node of scale 0.01: hips at 100, head at 170; 0.7 m apart.
        let joints = [
            joint(None, 5.0, 0.01),
            joint(Some(0), 100.0, 1.0),
            joint(Some(1), 70.0, 1.0),
        ];
        let found = local_extents(&joints);
        for (found, expected) in found.iter().zip([0.7, 70.0, 70.0]) {
            assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
        }
    }

    #[test]
    fn a_point_and_nothing_are_metres() {
        assert_eq!(local_extents(&[joint(None, 3.0, 1.0)]), [1.0]);
        assert!(local_extents(&[]).is_empty());
        assert_eq!(
            local_extents(&[joint(None, 3.0, 0.0), joint(Some(0), 1.0, 1.0)])[1],
            1.0
        );
    }
}
