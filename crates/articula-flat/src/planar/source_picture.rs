//! Pictures of a subject with its textures, under the light of a planar clip.
//!
//! Source: `docs/methods/vector.md` 9. What a conversion loses shows only against the character
//! itself: all triangles and every texel. Light is interpolated between vertices and multiplies
//! sRGB levels as in [`super::bake()`], so that the lamp is no difference. Textures are sampled for
//! each sample of a pixel and averaged in sRGB.

use super::bake::{BakeOptions, Painter, Poser, vertex_light, with_own};
use super::error::PlanarError;
use super::shading::Shading;
use super::stage::faces;
use super::subject::PlanarSubject;
use super::vertex_colors::fitted;
use crate::item_buffer::{Faces, ItemBuffer, Supersampling, barycentric};
use crate::picture::{Picture, Rgba};
use crate::projection::Screen;
use glam::{Quat, Vec2, Vec3, Vec4};

/// Samples of a pixel.
const SAMPLES: Supersampling = Supersampling::Four;

/// Draws a subject at times of its clip.
pub(crate) struct SourcePainter<'a> {
    subject: PlanarSubject<'a>,
    options: &'a BakeOptions,
    painter: Painter<'a>,
    faces: Vec<Faces>,
    poser: Poser<'a>,
    buffer: ItemBuffer,
    corners: Vec<Vec4>,
    light: Vec<f32>,
}

impl<'a> SourcePainter<'a> {
    /// Prepares pictures of the size of the camera's viewport.
    ///
    /// # Errors
    /// [`PlanarError::Picture`] if the picture is too large.
    pub(crate) fn new(
        subject: &PlanarSubject<'a>,
        options: &'a BakeOptions,
    ) -> Result<Self, PlanarError> {
        let viewport = options.camera.viewport;
        let (width, height) = (viewport.width_px.round(), viewport.height_px.round());
        Ok(Self {
            subject: *subject,
            options,
            painter: Painter::new(subject),
            faces: faces(subject),
            poser: Poser::new(subject),
            buffer: ItemBuffer::new(width as u32, height as u32, SAMPLES)?,
            corners: Vec::new(),
            light: Vec::new(),
        })
    }

    /// Poses the subject at a time in seconds and finds the visible triangle of every sample.
    pub(crate) fn pose(&mut self, secs: f64) {
        self.poser.pose(secs);
        let Self {
            subject, options, ..
        } = self;
        let angle = options.turn.at(secs);
        let screen = Screen::new(&options.camera, options.projection);
        let toward = options.camera.orientation * options.lighting.direction.normalize_or(Vec3::Z);
        let turn = Quat::from_rotation_y(angle);
        let skinned = &self.poser.skinned;
        let corner = |p: &Vec3| screen.corner(options.turn.apply(*p, angle));
        self.corners = skinned.positions.iter().map(corner).collect();
        let facing = |n: &Vec3| (turn * *n).dot(toward);
        self.light = skinned.normals.iter().map(facing).collect();
        self.buffer.clear();
        for (t, triangle) in subject.triangles.iter().enumerate() {
            let corners = triangle.map(|v| self.corners[v as usize]);
            let material = self.painter.material_of(triangle);
            let (id, side) = (t as u32, self.faces[t]);
            if material.alpha_cutoff > 0.0 {
                let level = self.texture_level(t);
                let cutoff = material.alpha_cutoff;
                let opaque = |at| {
                    barycentric(&corners, at)
                        .is_some_and(|w| self.painter.color(triangle, w, level).1 >= cutoff)
                };
                self.buffer.draw_where(id, corners, side, opaque);
            } else {
                self.buffer.draw(id, corners, side);
            }
        }
    }

    /// Triangle that the first covered sample of each pixel shows, row by row.
    pub(crate) fn triangles(&self) -> Vec<Option<u32>> {
        let (width, height) = self.buffer.size();
        let n = SAMPLES.per_side();
        let of = |x: u32, y: u32| {
            let mut samples = (0..n * n).map(|k| (x * n + k % n, y * n + k / n));
            samples.find_map(|(x, y)| self.buffer.item(x, y))
        };
        (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| of(x, y))
            .collect()
    }

    /// Name of the mesh at a pixel, or next to it.
    pub(crate) fn mesh_at(&self, x: u32, y: u32) -> Option<String> {
        let n = SAMPLES.per_side();
        let around = [(0, 0), (1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, -1)];
        let item = |(i, j): (i32, i32)| {
            let at = (x.checked_add_signed(i)?, y.checked_add_signed(j)?);
            self.buffer.item(at.0 * n + n / 2, at.1 * n + n / 2)
        };
        let triangle = self.subject.triangles[around.into_iter().find_map(item)? as usize];
        let vertex = triangle[0] as usize;
        let mut parts = self.subject.mesh.parts.iter();
        Some(parts.find(|p| p.vertices.contains(&vertex))?.name.clone())
    }

    /// The picture with textures.
    ///
    /// # Errors
    /// [`PlanarError::Picture`] if the picture is too large.
    pub(crate) fn textured(&self, background: Rgba) -> Result<Picture, PlanarError> {
        let count = self.subject.triangles.len();
        let levels: Vec<usize> = (0..count).map(|t| self.texture_level(t)).collect();
        self.shaded(background, |t, weights| {
            let triangle = &self.subject.triangles[t];
            self.painter.color(triangle, weights, levels[t]).0
        })
    }

    /// The picture with one gradient or one colour for each triangle instead of textures.
    ///
    /// # Errors
    /// [`PlanarError::Picture`] if the picture is too large.
    pub(crate) fn untextured(
        &self,
        shading: Shading,
        background: Rgba,
    ) -> Result<Picture, PlanarError> {
        let colors = fitted(&self.subject, |t| self.painter.appearance_of(t));
        self.shaded(background, |t, weights| {
            let corners = self.subject.triangles[t].map(|v| Vec3::from(colors[&v]));
            let weights = match shading {
                Shading::Gouraud => weights,
                Shading::Flat => Vec3::splat(1.0 / 3.0),
            };
            corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z
        })
    }

    fn shaded(
        &self,
        background: Rgba,
        color: impl Fn(usize, Vec3) -> Vec3,
    ) -> Result<Picture, PlanarError> {
        let (width, height) = self.buffer.size();
        let mut picture = Picture::new(width, height, background)?;
        let n = SAMPLES.per_side();
        let empty = Vec3::from([0, 1, 2].map(|k| f32::from(background[k])));
        for y in 0..height {
            for x in (0..width).filter(|x| !self.buffer.is_blank(*x, y)) {
                let mut sum = Vec3::ZERO;
                for (i, j) in (0..n * n).map(|k| (x * n + k % n, y * n + k / n)) {
                    sum += match self.buffer.item(i, j) {
                        None => empty,
                        Some(t) => self.lit(t as usize, self.buffer.position(i, j), &color),
                    };
                }
                let level = |v: f32| (v / SAMPLES.per_pixel() as f32).round() as u8;
                picture.set(x, y, [level(sum.x), level(sum.y), level(sum.z), 255]);
            }
        }
        Ok(picture)
    }

    fn lit(&self, triangle: usize, at: Vec2, color: &impl Fn(usize, Vec3) -> Vec3) -> Vec3 {
        let vertices = self.subject.triangles[triangle].map(|v| v as usize);
        let corners = vertices.map(|v| self.corners[v]);
        let weights = barycentric(&corners, at).unwrap_or(Vec3::splat(1.0 / 3.0));
        let is_back = self.faces[triangle] == Faces::Both && shows_back(&corners);
        let of = |v: usize| vertex_light(&self.options.lighting, self.light[v], is_back);
        let light = Vec3::from(vertices.map(of)).dot(weights);
        let own = self.painter.own_light(&self.subject.triangles[triangle]);
        let light = with_own(light, own);
        color(triangle, weights) * light
    }

    fn texture_level(&self, triangle: usize) -> usize {
        let corners = self.subject.triangles[triangle];
        let Some(texture) = self.painter.appearance_of(&corners).detail() else {
            return 0;
        };
        let uv = corners.map(|v| self.subject.mesh.texcoords[v as usize]);
        let area = 0.5 * (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]);
        let places = corners.map(|v| self.corners[v as usize]);
        if places.iter().any(|p| p.w < 1e-3) {
            return 0;
        }
        let [a, b, c] = places.map(|p| Vec2::new(p.x, p.y) / p.w);
        texture.level_for(area, 0.5 * (b - a).perp_dot(c - a))
    }
}

/// Whether the camera sees the back of a triangle with these homogeneous corners.
fn shows_back(corners: &[Vec4; 3]) -> bool {
    // The picture's y axis points down, so the front has a negative volume.
    let [a, b, c] = corners.map(|p| Vec3::new(p.x, p.y, p.w));
    a.dot(b.cross(c)) > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::rmse;
    use crate::planar::bake::bake;
    use crate::planar::fixture::figure;
    use crate::planar::reference::reference;

    const BACKGROUND: Rgba = [255; 4];

    #[test]
    fn a_figure_without_textures_looks_as_its_planar_clip() {
        let mut figure = figure();
        for material in &mut figure.appearance.materials {
            material.base_color_image = None;
        }
        let clip = bake(&figure.subject(), &[0.0], &figure.options).unwrap();
        let expected = reference(&clip, 0, SAMPLES, BACKGROUND).unwrap();
        let mut painter = SourcePainter::new(&figure.subject(), &figure.options).unwrap();
        painter.pose(0.0);
        let textured = painter.textured(BACKGROUND).unwrap();
        assert!(rmse(&textured, &expected).unwrap() < 0.5);
        let plain = painter.untextured(Shading::Gouraud, BACKGROUND).unwrap();
        assert!(rmse(&plain, &textured).unwrap() < 0.5);
        let shown = painter.triangles();
        let blank = expected.pixels().iter().zip(&shown);
        assert!(blank.clone().any(|(_, t)| t.is_some()));
        assert!(
            blank
                .into_iter()
                .all(|(p, t)| t.is_some() || *p == BACKGROUND)
        );
    }
}
