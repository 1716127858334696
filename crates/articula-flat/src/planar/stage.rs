//! Bounds, camera placement and visible triangles of a moving subject.
//!
//! Source: `docs/methods/vector.md` 1 and 3. Triangles that no frame shows (a skull under a helmet)
//! are found before the mesh is simplified: they would consume the triangle budget and cause most
//! cycles of the painting order.

use super::bake::{BakeOptions, Poser, Turntable};
use super::error::PlanarError;
use super::subject::PlanarSubject;
use crate::frame::{Bounds, TightView};
use crate::item_buffer::{Faces, ItemBuffer, Supersampling};
use crate::projection::{Projection, Screen};
use articula_core::{Camera, Viewport};
use glam::Vec3;
use std::collections::BTreeSet;

/// Minimum longer side of the picture in which visibility is tested, pixels.
const CLOSER_PX: f32 = 1024.0;

impl PlanarSubject<'_> {
    /// Returns the smallest box around the subject's triangles at all given times; `None` without
    /// triangles.
    pub fn bounds(&self, frame_times_secs: &[f64], turn: &Turntable) -> Option<Bounds> {
        let used = used_vertices(self);
        let mut poser = Poser::new(self);
        Bounds::around(frame_times_secs.iter().filter_map(|secs| {
            poser.pose(*secs);
            let angle = turn.at(*secs);
            let places = used
                .iter()
                .map(|v| turn.apply(poser.skinned.positions[*v], angle));
            places
                .map(|p| (p, p))
                .reduce(|(low, high), (p, _)| (low.min(p), high.max(p)))
        }))
    }

    /// Returns the closest camera of an azimuth and elevation ([`crate::frame::orbit_view`]) that
    /// sees the subject at all given times; `None` without triangles.
    pub fn camera(
        &self,
        frame_times_secs: &[f64],
        turn: &Turntable,
        (azimuth_radians, elevation_radians): (f32, f32),
        viewport: Viewport,
    ) -> Option<Camera> {
        let mut view = TightView::new(azimuth_radians, elevation_radians, viewport);
        let used = used_vertices(self);
        let mut poser = Poser::new(self);
        for secs in frame_times_secs {
            poser.pose(*secs);
            let angle = turn.at(*secs);
            let places = used.iter().map(|v| poser.skinned.positions[*v]);
            places.for_each(|p| view.add(turn.apply(p, angle)));
        }
        view.camera()
    }

    /// Returns whether each of the subject's triangles owns a sample of the picture at one of the
    /// given times.
    ///
    /// Unlike a bake this accepts meshes of any size. The resolution is higher than the picture's,
    /// and triangles that touch a visible triangle count as visible: small triangles between
    /// samples would leave holes that no simplifier may close. O(times x (vertices + samples
    /// covered)).
    ///
    /// # Errors
    /// [`PlanarError::Picture`] if the camera's picture is too large.
    pub fn seen(
        &self,
        frame_times_secs: &[f64],
        options: &BakeOptions,
    ) -> Result<Vec<bool>, PlanarError> {
        let (camera, projection) = closer(options);
        let (width, height) = (camera.viewport.width_px, camera.viewport.height_px);
        let mut buffer = ItemBuffer::new(width as u32, height as u32, Supersampling::Two)?;
        let screen = Screen::new(&camera, projection);
        let mut poser = Poser::new(self);
        let faces = faces(self);
        let mut seen = vec![false; self.triangles.len()];
        for secs in frame_times_secs {
            poser.pose(*secs);
            let angle = options.turn.at(*secs);
            let corner = |p: &Vec3| screen.corner(options.turn.apply(*p, angle));
            let corners: Vec<_> = poser.skinned.positions.iter().map(corner).collect();
            buffer.clear();
            for (t, triangle) in self.triangles.iter().enumerate() {
                let of = triangle.map(|v| corners.get(v as usize).copied().unwrap_or_default());
                buffer.draw(t as u32, of, faces[t]);
            }
            let (width, height) = buffer.sample_size();
            for y in 0..height {
                for item in (0..width).filter_map(|x| buffer.item(x, y)) {
                    seen[item as usize] = true;
                }
            }
        }
        Ok(with_neighbours(self, &seen))
    }
}

/// The same view in at least about a thousand pixels on the longer side.
fn closer(options: &BakeOptions) -> (Camera, Projection) {
    let mut camera = options.camera;
    let viewport = &mut camera.viewport;
    let side = viewport.width_px.max(viewport.height_px).max(1.0);
    let factor = (CLOSER_PX / side).max(1.0);
    viewport.width_px = (viewport.width_px * factor).round();
    viewport.height_px = (viewport.height_px * factor).round();
    let projection = match options.projection {
        Projection::Perspective => Projection::Perspective,
        Projection::Parallel { pixels_per_metre } => Projection::Parallel {
            pixels_per_metre: pixels_per_metre * factor,
        },
    };
    (camera, projection)
}

/// Visible triangles, and those that have a rest position in common with one.
fn with_neighbours(subject: &PlanarSubject<'_>, seen: &[bool]) -> Vec<bool> {
    let key = |v: u32| {
        let at = subject.mesh.positions.get(v as usize).copied();
        at.unwrap_or_default().to_array().map(f32::to_bits)
    };
    let pairs = subject.triangles.iter().zip(seen);
    let touched: BTreeSet<[u32; 3]> = pairs
        .clone()
        .filter(|(_, seen)| **seen)
        .flat_map(|(t, _)| t.map(key))
        .collect();
    let is_near = |t: &[u32; 3]| t.iter().any(|v| touched.contains(&key(*v)));
    pairs.map(|(t, seen)| *seen || is_near(t)).collect()
}

fn used_vertices(subject: &PlanarSubject<'_>) -> Vec<usize> {
    let mut used = vec![false; subject.mesh.len()];
    for v in subject.triangles.iter().flatten() {
        if let Some(used) = used.get_mut(*v as usize) {
            *used = true;
        }
    }
    (0..used.len()).filter(|v| used[*v]).collect()
}

/// Sides of each triangle that are drawn.
pub(super) fn faces(subject: &PlanarSubject<'_>) -> Vec<Faces> {
    let mut two_sided = vec![false; subject.mesh.len()];
    for part in &subject.mesh.parts {
        let material = part
            .material
            .and_then(|m| subject.appearance.materials.get(m));
        two_sided[part.vertices.clone()].fill(material.is_some_and(|m| m.double_sided));
    }
    let of = |t: &[u32; 3]| {
        let is_two_sided = two_sided.get(t[0] as usize).copied().unwrap_or_default();
        if is_two_sided {
            Faces::Both
        } else {
            Faces::Front
        }
    };
    subject.triangles.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::bake::{Lighting, bake};
    use crate::planar::drawn::Drawn;
    use crate::planar::fixture::figure;

    #[test]
    fn bounds_hold_the_figure_and_its_turn() {
        let figure = figure();
        let still = figure
            .subject()
            .bounds(&[0.0], &Turntable::default())
            .unwrap();
        assert!(still.high.y > 1.5 && still.low.y < 0.1);
        let turn = Turntable {
            axis: (0.0, 0.0),
            radians_per_sec: std::f32::consts::FRAC_PI_2,
        };
        let turned = figure.subject().bounds(&[1.0], &turn).unwrap();
        // A quarter turn to the left maps x to -z and z to x.
        assert!((turned.high.z + still.low.x).abs() < 1e-4);
        assert!((turned.high.x - still.high.z).abs() < 1e-4);
        let mut empty = figure.subject();
        empty.triangles = &[];
        assert_eq!(empty.bounds(&[0.0], &Turntable::default()), None);
    }

    #[test]
    fn the_camera_sees_every_place_of_the_clip() {
        let figure = figure();
        let viewport = figure.options.camera.viewport;
        let (subject, turn) = (figure.subject(), Turntable::default());
        let camera = subject.camera(&[0.0], &turn, (0.4, 0.0), viewport).unwrap();
        let options = BakeOptions {
            camera,
            ..figure.options.clone()
        };
        let clip = bake(&subject, &[0.0], &options).unwrap();
        let inside = |p: &glam::Vec2| p.min_element() > 9.0 && p.max_element() < 191.0;
        assert!(clip.frames[0].xy.iter().all(inside));
        let near_edge = |p: &glam::Vec2| p.y < 12.0 || p.y > 188.0;
        assert!(clip.frames[0].xy.iter().any(near_edge));
    }

    #[test]
    fn holds_what_a_bake_draws_and_leaves_out_the_back() {
        let figure = figure();
        let seen = figure.subject().seen(&[0.0], &figure.options).unwrap();
        let options = BakeOptions {
            lighting: Lighting::default(),
            ..figure.options.clone()
        };
        let clip = bake(&figure.subject(), &[0.0], &options).unwrap();
        let drawn = Drawn::seen(&clip).unwrap();
        assert!((0..seen.len()).all(|t| seen[t] || !drawn.get(0, t)));
        let share = seen.iter().filter(|s| **s).count() as f64 / seen.len() as f64;
        assert!((0.4..0.8).contains(&share), "{share}");
    }
}
