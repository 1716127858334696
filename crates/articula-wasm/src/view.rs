//! Views as JavaScript gives them.

use crate::error::{Fault, Result};
use articula::glam::{Quat, Vec3};
use articula::{Camera, Viewport};

/// Numbers of a view.
pub(crate) const VIEW: usize = 10;

/// Reads views of ten numbers each: position, rotation, size of the picture in pixels, vertical field of view in
/// radians.
pub(crate) fn cameras(views: &[f32]) -> Result<impl Iterator<Item = Camera> + '_> {
    let (views, rest) = views.as_chunks::<VIEW>();
    if !rest.is_empty() {
        let found = views.len() * VIEW + rest.len();
        return Err(Fault::argument(format!(
            "views: {found} numbers; a view has {VIEW}: position x y z, rotation x y z w, width and height in pixels, vertical field of view in radians"
        )));
    }
    Ok(views.iter().map(camera))
}

fn camera([x, y, z, qx, qy, qz, qw, width, height, fov]: &[f32; VIEW]) -> Camera {
    Camera {
        eye: Vec3::new(*x, *y, *z),
        orientation: Quat::from_xyzw(*qx, *qy, *qz, *qw),
        viewport: Viewport {
            width_px: *width,
            height_px: *height,
            fov_y_radians: *fov,
        },
    }
}
