//! Impostors drawn into a picture, as a shader draws them.

use super::plan::ImpostorPlan;
use super::views::ImpostorView;
use crate::picture::{Picture, Rgba, linear_table, srgb_byte};
use crate::projection::Screen;
use glam::{Affine3A, Mat3, Vec3, Vec4};

/// Samples along one side of a pixel.
const SAMPLES: u32 = 4;

/// Premultiplied linear colours of an atlas, with what is needed to place them.
#[derive(Debug)]
pub struct ImpostorPainter<'a> {
    plan: &'a ImpostorPlan,
    atlas: &'a Picture,
    columns: usize,
    views: Vec<ImpostorView>,
}

impl<'a> ImpostorPainter<'a> {
    /// Paints from the atlas of a plan.
    pub fn new(plan: &'a ImpostorPlan, atlas: &'a Picture) -> Self {
        Self {
            plan,
            atlas,
            columns: plan.columns(),
            views: plan.views.iter().collect(),
        }
    }

    /// Composites a pose over a picture of the screen's size. `world` places the character; its
    /// scale is uniform. Does nothing if there is no such pose.
    pub fn paint(&self, picture: &mut Picture, screen: &Screen, world: &Affine3A, pose: usize) {
        let Some((clip, place)) = self.plan.clip_of(pose) else {
            return;
        };
        let centre = &self.plan.clips[clip].centres[place];
        let placed = world.transform_point3(*centre);
        let model = world.inverse();
        // Towards an eye that sees the whole character from one side.
        let eye = screen.eye_of(placed);
        let view = self.plan.views.nearest(model.transform_vector3(eye));
        let Some(axes) = self.views.get(view) else {
            return;
        };
        let cell = &self.plan.cell;
        let [left, bottom] = cell.corner_m;
        let [width, height] = cell.size_px.map(|px| cell.metres_per_px * px as f32);
        let corner = |x: f32, y: f32| {
            let point = *centre + axes.right * x + axes.plane_up * y;
            screen.place(world.transform_point3(point))
        };
        let corners = [
            corner(left, bottom),
            corner(left + width, bottom),
            corner(left, bottom + height),
            corner(left + width, bottom + height),
        ];
        let Some(places) = corners.into_iter().collect::<Option<Vec<_>>>() else {
            return;
        };
        let low = places.iter().fold(glam::Vec2::MAX, |a, b| a.min(*b));
        let high = places.iter().fold(glam::Vec2::MIN, |a, b| a.max(*b));
        let limit = |v: f32, most: u32| v.clamp(0.0, most as f32) as u32;
        let index = pose * self.views.len() + view;
        for y in limit(low.y.floor(), picture.height())..limit(high.y.ceil(), picture.height()) {
            for x in limit(low.x.floor(), picture.width())..limit(high.x.ceil(), picture.width()) {
                let mut sum = Vec4::ZERO;
                for i in 0..SAMPLES * SAMPLES {
                    let at = |v: u32, i: u32| v as f32 + (i as f32 + 0.5) / SAMPLES as f32;
                    let place = glam::Vec2::new(at(x, i % SAMPLES), at(y, i / SAMPLES));
                    let ray = screen.ray(place);
                    let origin = model.transform_point3(ray.origin) - *centre;
                    let along = model.transform_vector3(ray.direction);
                    if let Some([u, v]) = meet(axes, origin, along) {
                        sum += self.sample(index, u, v);
                    }
                }
                sum /= (SAMPLES * SAMPLES) as f32;
                if sum.w > 0.0 {
                    let [r, g, b] = (sum.truncate() / sum.w).to_array().map(srgb_byte);
                    picture.blend(x as i32, y as i32, [r, g, b, 255], sum.w);
                }
            }
        }
    }

    /// Colour of a picture at metres from the centre, filtered, premultiplied and linear.
    fn sample(&self, index: usize, x_m: f32, y_m: f32) -> Vec4 {
        let cell = &self.plan.cell;
        let [width, height] = cell.size_px;
        let x = (x_m - cell.corner_m[0]) / cell.metres_per_px - 0.5;
        let y = height as f32 - 0.5 - (y_m - cell.corner_m[1]) / cell.metres_per_px;
        let (left, top) = (x.floor(), y.floor());
        let (u, v) = (x - left, y - top);
        let first = (
            (index % self.columns) as u32 * width,
            (index / self.columns) as u32 * height,
        );
        let texel = |dx: i32, dy: i32| {
            let (x, y) = (left as i32 + dx, top as i32 + dy);
            let inside = (0..width as i32).contains(&x) && (0..height as i32).contains(&y);
            let at = inside.then(|| self.atlas.get(first.0 + x as u32, first.1 + y as u32));
            at.flatten().map_or(Vec4::ZERO, premultiplied)
        };
        let above = texel(0, 0).lerp(texel(1, 0), u);
        above.lerp(texel(0, 1).lerp(texel(1, 1), u), v)
    }
}

/// Where a ray meets the plane of a picture: metres from the centre along its axes.
fn meet(axes: &ImpostorView, origin: Vec3, along: Vec3) -> Option<[f32; 2]> {
    let matrix = Mat3::from_cols(axes.right, axes.plane_up, -along);
    (matrix.determinant().abs() > 1e-6).then(|| {
        let found = matrix.inverse() * origin;
        [found.x, found.y]
    })
}

fn premultiplied(color: Rgba) -> Vec4 {
    let table = linear_table();
    let [r, g, b] = [0, 1, 2].map(|i| table[usize::from(color[i])]);
    let alpha = f32::from(color[3]) / 255.0;
    Vec4::new(r * alpha, g * alpha, b * alpha, alpha)
}
