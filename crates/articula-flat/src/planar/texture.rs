//! The picture that triangles of a planar clip show.
//!
//! Source: `docs/methods/vector.md` 2 and 8.3.

use super::error::PlanarError;
use crate::picture::Picture;
use glam::{Vec2, Vec4};
use std::sync::Arc;

/// A picture shared by all triangles that show it, each part of it lit like an albedo.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanarTexture {
    /// The picture.
    pub picture: Arc<Picture>,
    /// Texture coordinate of each vertex, pixels of the picture from its top left; linear on the
    /// screen inside a triangle.
    pub places: Vec<Vec2>,
    /// Whether each triangle shows the picture; others show the albedo of their vertices.
    pub shows: Vec<bool>,
}

impl PlanarTexture {
    /// The picture, for a clip that has no vertices and triangles yet.
    pub(crate) fn without_triangles(&self) -> Self {
        Self {
            picture: self.picture.clone(),
            places: Vec::new(),
            shows: Vec::new(),
        }
    }

    /// Adds a vertex between two others.
    pub(super) fn add_between(&mut self, from: usize, to: usize, way: f32) {
        self.places
            .push(self.places[from].lerp(self.places[to], way));
    }

    /// sRGB levels of the picture and opacity, 0 to 255, between its pixels by bilinear
    /// interpolation, as a canvas draws it; beyond its edges those of the edge.
    pub(crate) fn at(&self, place: Vec2) -> Vec4 {
        let (width, height) = (self.picture.width() as i64, self.picture.height() as i64);
        let pixels = self.picture.pixels();
        let place = place - 0.5;
        let corner = place.floor();
        let blend = place - corner;
        let pixel = |dx: i64, dy: i64| {
            let x = (corner.x as i64 + dx).clamp(0, width - 1);
            let y = (corner.y as i64 + dy).clamp(0, height - 1);
            let levels = pixels.get((y * width + x) as usize).copied();
            Vec4::from_array(levels.unwrap_or([0; 4]).map(f32::from))
        };
        let upper = pixel(0, 0).lerp(pixel(1, 0), blend.x);
        let lower = pixel(0, 1).lerp(pixel(1, 1), blend.x);
        upper.lerp(lower, blend.y)
    }

    /// Checks array lengths and that every number is finite.
    pub(super) fn check(&self, vertices: usize, triangles: usize) -> Result<(), PlanarError> {
        let mismatch = |what: String| {
            let at = "texture";
            Err(PlanarError::Mismatch { at, what })
        };
        if self.places.len() != vertices || self.shows.len() != triangles {
            return mismatch(format!(
                "expected a place for each of {vertices} vertices and a value for each of \
                 {triangles} triangles"
            ));
        }
        if !self.places.iter().all(|place| place.is_finite()) {
            return mismatch("a place is not finite".to_owned());
        }
        if self.picture.pixels().is_empty() {
            return mismatch("the picture has no pixels".to_owned());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_run_straight_between_the_centres_of_pixels() {
        let pixels = vec![[0, 0, 0, 255], [200, 100, 0, 255]];
        let texture = PlanarTexture {
            picture: Arc::new(Picture::from_pixels(2, 1, pixels).unwrap()),
            places: Vec::new(),
            shows: Vec::new(),
        };
        let red = |x: f32| texture.at(Vec2::new(x, 0.5)).x;
        assert_eq!(
            [red(0.5), red(0.75), red(1.0), red(1.5)],
            [0.0, 50.0, 100.0, 200.0]
        );
        assert_eq!([red(-9.0), red(9.0)], [0.0, 200.0]);
        assert_eq!(
            texture.at(Vec2::new(1.0, 7.0)),
            Vec4::new(100.0, 50.0, 0.0, 255.0)
        );
    }
}
