//! Which character a ray meets first, by the bounds of its clips.

use articula::core::Bound;
use articula::crowd::CrowdPlayer;
use articula::glam::{Affine3A, Vec3};

/// First character that a ray meets, and the distance; `None` if it meets none.
pub(crate) fn first(player: &CrowdPlayer, origin: Vec3, direction: Vec3) -> Option<(usize, f32)> {
    let direction = direction.try_normalize()?;
    let bounds = &player.asset().model().parts().bounds.clips;
    let count = player.positions().len();
    let met = (0..count).filter_map(|character| {
        let world = player.world_from_model(character);
        let model = Affine3A::inverse(&world);
        // Not normalised, so that distances are those of the world.
        let (from, along) = (
            model.transform_point3(origin),
            model.transform_vector3(direction),
        );
        let (clip, next) = player.crowd().clips(character);
        let boxes = [Some(clip), next].into_iter().flatten();
        let distances = boxes.filter_map(|clip| distance(bounds[clip].whole(), from, along));
        Some((character, distances.reduce(f32::min)?))
    });
    met.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Distance along a ray to a box, 0 from inside.
fn distance(bound: &Bound, from: Vec3, along: Vec3) -> Option<f32> {
    let (mut near, mut far) = (0.0f32, f32::INFINITY);
    for axis in 0..3 {
        let (least, greatest) = (
            bound.least[axis] - from[axis],
            bound.greatest[axis] - from[axis],
        );
        if along[axis] == 0.0 {
            if least > 0.0 || greatest < 0.0 {
                return None;
            }
            continue;
        }
        let (a, b) = (least / along[axis], greatest / along[axis]);
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
    }
    (near <= far).then_some(near)
}
