//! Points of the face as seen from the front.

use crate::field::Group;
use glam::Vec3;

/// The point of the face at x and y, moved outwards by `lift`.
pub(crate) fn on_skin(head: &Group, [x, y]: [f32; 2], lift: f32) -> Vec3 {
    let mut p = Vec3::new(x, y, 0.13);
    for _ in 0..60 {
        p.z -= 0.7 * head.distance(p);
    }
    p + head.normal(p) * lift
}
