//! The clip of the player: triangles in painting order, positions and light as components.
//!
//! Source: `docs/methods/vector.md` 8.3.

use super::texture::{PlayerTexture, ShownTexture};
use crate::low_rank::quantised::Quantised;
use crate::planar::shading::Shading;
use crate::planar::{PlanarClip, PlanarFrame, PlanarMaterial, PlanarTexture};
use glam::Vec2;
use std::ops::Range;

/// Coefficient of a named input at weight 1, in steps.
pub(super) const INPUT_ONE: f64 = 256.0;

/// A painting order from a frame on, until the next epoch begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct PlayerEpoch {
    /// First frame; 0 for the first epoch.
    pub first_frame: u32,
    /// Triangles back to front.
    pub order: Vec<u32>,
}

/// A compressed 2D clip as stored in the container that the script player reads.
///
/// A *point* is a position shared by all vertices that coincide in every frame; a *wedge* is a
/// point with one light and one colour. Columns of the motion are x and y of each point in pixels,
/// then, with Gouraud shading, the light of each wedge times `light_weight`.
#[derive(Debug, Clone, PartialEq)]
pub struct PlayerClip {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Frames per second.
    pub fps: f32,
    /// Number of frames; frame `i` is at `i / fps` seconds, the last one ends the clip.
    pub frames: u32,
    /// Shading of the triangles.
    pub shading: Shading,
    /// Value of full light in the columns.
    pub(crate) light_weight: f64,
    /// Wedges of each triangle; wedges are numbered in the order of first use.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Point of each wedge; points are numbered in the order of first use.
    pub wedge_points: Vec<u32>,
    /// sRGB albedo of each wedge (Gouraud) or colour of each triangle (flat).
    pub(crate) colors: Vec<[u8; 3]>,
    /// Spans of frames in which each triangle is drawn, ascending and disjoint.
    pub(crate) shown: Vec<Vec<Range<u32>>>,
    /// The painting orders.
    pub(crate) epochs: Vec<PlayerEpoch>,
    /// Positions and light; with inputs, one component per input.
    pub(crate) motion: Quantised,
    /// Names of the inputs that drive the clip; empty if it can only be played.
    pub inputs: Vec<String>,
    /// The picture that triangles show; only with Gouraud shading.
    pub(crate) texture: Option<PlayerTexture>,
}

/// Positions and light of a clip at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct PlayerFrame {
    /// Position of each wedge, pixels.
    pub xy: Vec<Vec2>,
    /// Light of each wedge, 0 to 1 up to the coding error; 1 with flat shading.
    pub light: Vec<f32>,
}

impl PlayerClip {
    /// Number of points.
    pub(crate) fn points(&self) -> usize {
        self.wedge_points
            .iter()
            .max()
            .map_or(0, |p| *p as usize + 1)
    }

    /// Returns positions and light at a time in frames; linear between frames, clamped at the ends.
    pub fn moment(&self, frame: f64) -> PlayerFrame {
        let numbers = self.motion.row(frame);
        let place = |p: &u32| {
            let at = 2 * *p as usize;
            Vec2::new(numbers[at] as f32, numbers[at + 1] as f32)
        };
        let light = match self.shading {
            Shading::Flat => vec![1.0; self.wedge_points.len()],
            Shading::Gouraud => numbers[2 * self.points()..]
                .iter()
                .map(|n| (n / self.light_weight) as f32)
                .collect(),
        };
        PlayerFrame {
            xy: self.wedge_points.iter().map(place).collect(),
            light,
        }
    }

    /// Whether a triangle is drawn at a time in frames: as in the nearest frame.
    pub(crate) fn is_shown_at(&self, triangle: usize, frame: f64) -> bool {
        let nearest = self.nearest(frame);
        self.shown[triangle].iter().any(|s| s.contains(&nearest))
    }

    /// Triangles back to front at a time in frames: as in the nearest frame.
    pub(crate) fn order_at(&self, frame: f64) -> &[u32] {
        let nearest = self.nearest(frame);
        let after = self.epochs.partition_point(|e| e.first_frame <= nearest);
        &self.epochs[after.saturating_sub(1)].order
    }

    fn nearest(&self, frame: f64) -> u32 {
        // Halfway belongs to the later frame, as in the player.
        (frame + 0.5).floor().clamp(0.0, f64::from(self.frames - 1)) as u32
    }

    /// The picture that triangles show.
    pub(crate) fn shown_texture(&self) -> Option<ShownTexture> {
        let texture = self.texture.as_ref()?;
        let picture = &texture.picture;
        Some(ShownTexture {
            triangles: texture.shows.iter().filter(|shows| **shows).count(),
            size_px: (picture.width(), picture.height()),
            bytes: texture.file.len() as u64,
        })
    }

    /// One time as a planar clip of a single frame, in which triangles painted later are nearer and
    /// triangles that are not drawn have no area: [`crate::planar::reference`] of it is what an
    /// ideal player shows.
    pub(crate) fn painted(&self, frame: f64) -> PlanarClip {
        let moment = self.planar_frame(frame);
        let mut clip = self.planar(vec![PlanarFrame::default()]);
        let order = self.order_at(frame);
        let texture = clip.texture.take();
        let mut shown = texture.as_ref().map(PlanarTexture::without_triangles);
        let (albedo, triangles) = (clip.albedo, clip.triangles);
        clip.albedo = Vec::new();
        clip.triangles = Vec::new();
        let mut surface = Vec::new();
        for (rank, t) in order.iter().enumerate() {
            if !self.is_shown_at(*t as usize, frame) {
                continue;
            }
            let first = clip.albedo.len() as u32;
            let to = &mut clip.frames[0];
            for wedge in triangles[*t as usize].map(|w| w as usize) {
                to.xy.push(moment.xy[wedge]);
                to.light.push(moment.light[wedge]);
                to.nearness
                    .push((rank + 1) as f32 / (order.len() + 1) as f32);
                clip.albedo.push(albedo[wedge]);
                if let (Some(shown), Some(texture)) = (&mut shown, &texture) {
                    shown.places.push(texture.places[wedge]);
                }
            }
            if let (Some(shown), Some(texture)) = (&mut shown, &texture) {
                shown.shows.push(texture.shows[*t as usize]);
            }
            clip.triangles.push([first, first + 1, first + 2]);
            surface.push(0);
        }
        clip.part = vec![0; surface.len()];
        clip.surface = surface;
        clip.texture = shown;
        clip
    }

    pub(super) fn planar(&self, frames: Vec<PlanarFrame>) -> PlanarClip {
        let count = self.triangles.len();
        let levels = |c: &[u8; 3]| c.map(f32::from);
        let (triangles, albedo) = match self.shading {
            Shading::Gouraud => (
                self.triangles.clone(),
                self.colors.iter().map(levels).collect(),
            ),
            Shading::Flat => (
                (0..count as u32)
                    .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
                    .collect(),
                self.colors.iter().flat_map(|c| [levels(c); 3]).collect(),
            ),
        };
        PlanarClip {
            width: self.width,
            height: self.height,
            fps: self.fps,
            frames,
            triangles,
            surface: vec![0; count],
            part: vec![0; count],
            surfaces: vec![PlanarMaterial {
                name: String::new(),
                albedo: None,
            }],
            albedo,
            texture: self.texture.as_ref().map(PlayerTexture::planar),
        }
    }

    pub(super) fn planar_frame(&self, frame: f64) -> PlanarFrame {
        let moment = self.moment(frame);
        let (xy, light) = match self.shading {
            Shading::Gouraud => (moment.xy, moment.light),
            Shading::Flat => {
                let corners = self.triangles.iter().flatten();
                let xy: Vec<Vec2> = corners.map(|w| moment.xy[*w as usize]).collect();
                let light = vec![1.0; xy.len()];
                (xy, light)
            }
        };
        PlanarFrame {
            nearness: vec![0.0; xy.len()],
            xy,
            light,
        }
    }
}
