//! Position and light of every vertex in every frame, on the screen.
//!
//! Source: `docs/methods/vector.md` 2. Vertices store nearness instead of depth, since nearness is
//! linear on the screen under every projection ([`crate::projection`]).

use super::error::PlanarError;
use super::texture::PlanarTexture;
use glam::{Vec2, Vec4};
use std::collections::BTreeMap;

/// Maximum number of triangles of a clip.
pub const MAX_TRIANGLES: usize = 20_000;
/// Maximum number of frames of a clip.
pub const MAX_FRAMES: usize = 20_000;
/// Maximum of triangles times frames; about 2 GB in memory.
const MAX_CORNERS: usize = 1 << 26;

/// Appearance of the triangles of one material.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanarMaterial {
    /// Name of the material in the file.
    pub name: String,
    /// sRGB colour (levels, 0 to 255) of all its vertices; `None` if they differ.
    pub albedo: Option<[u8; 3]>,
}

/// Vertex positions and light of one frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlanarFrame {
    /// Position of each vertex, pixels from the top left, y down.
    pub xy: Vec<Vec2>,
    /// Nearness of each vertex: greater is nearer, linear on the screen.
    pub nearness: Vec<f32>,
    /// Light received by each vertex, 0 to 1; it multiplies the albedo's sRGB levels.
    pub light: Vec<f32>,
}

/// A clip projected to the screen. Triangles show only their front (counter-clockwise to the
/// viewer); two-sided ones are stored twice.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanarClip {
    /// Width of the picture, pixels.
    pub width: u32,
    /// Height of the picture, pixels.
    pub height: u32,
    /// Frames per second.
    pub fps: f32,
    /// The frames; frame `i` is at `i / fps` seconds, the last one ends the clip.
    pub frames: Vec<PlanarFrame>,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Self::surfaces`] for each triangle; triangles of different surfaces share no
    /// vertex.
    pub surface: Vec<u16>,
    /// Dominant joint of each triangle.
    pub part: Vec<u16>,
    /// The materials.
    pub surfaces: Vec<PlanarMaterial>,
    /// sRGB albedo of each vertex in levels, 0 to 255.
    pub albedo: Vec<[f32; 3]>,
    /// Picture that triangles show instead of their vertices' albedo; only the player draws it.
    pub texture: Option<PlanarTexture>,
}

impl PlanarClip {
    /// Number of vertices.
    pub(crate) fn vertices(&self) -> usize {
        self.albedo.len()
    }

    /// Colour of a vertex in a frame, sRGB levels 0 to 255.
    pub(crate) fn color(&self, frame: usize, vertex: u32) -> [f32; 3] {
        let light = self.frames[frame].light[vertex as usize];
        self.albedo[vertex as usize].map(|level| level * light)
    }

    /// Positions of a triangle's corners on the screen.
    pub(crate) fn places(&self, frame: usize, triangle: usize) -> [Vec2; 3] {
        self.triangles[triangle].map(|v| self.frames[frame].xy[v as usize])
    }

    /// A triangle's corners for [`crate::item_buffer::ItemBuffer::draw`].
    pub(crate) fn corners(&self, frame: usize, triangle: usize) -> [Vec4; 3] {
        let frame = &self.frames[frame];
        self.triangles[triangle].map(|v| {
            let xy = frame.xy[v as usize];
            Vec4::new(xy.x, xy.y, frame.nearness[v as usize], 1.0)
        })
    }

    /// Position class of each vertex: equal for vertices that coincide in every frame (seams of
    /// normals, texture and material).
    pub(crate) fn position_classes(&self) -> Vec<u32> {
        let mut classes = vec![0u32; self.vertices()];
        for frame in &self.frames {
            let mut known = BTreeMap::new();
            for (v, class) in classes.iter_mut().enumerate() {
                let xy = frame.xy[v];
                let key = (
                    *class,
                    xy.x.to_bits(),
                    xy.y.to_bits(),
                    frame.nearness[v].to_bits(),
                );
                let next = known.len() as u32;
                *class = *known.entry(key).or_insert(next);
            }
        }
        classes
    }

    /// Returns the share of the area of all front faces in all frames, hidden ones included, that
    /// shows the texture; 0 without one.
    pub fn textured_share(&self) -> f32 {
        let Some(texture) = &self.texture else {
            return 0.0;
        };
        let (mut shown, mut all) = (0.0, 0.0);
        for f in 0..self.frames.len() {
            for (t, is_shown) in texture.shows.iter().enumerate() {
                let [a, b, c] = self.places(f, t);
                let front = (-(b - a).perp_dot(c - a)).max(0.0);
                all += front;
                shown += if *is_shown { front } else { 0.0 };
            }
        }
        shown / f32::max(all, f32::MIN_POSITIVE)
    }

    /// Checks array lengths, indices, limits and that every number is finite.
    ///
    /// # Errors
    /// The first violation, as a [`PlanarError`].
    pub(crate) fn check(&self) -> Result<(), PlanarError> {
        if self.frames.is_empty() {
            return Err(PlanarError::NoFrames);
        }
        if self.frames.len() > MAX_FRAMES {
            let (found, most) = (self.frames.len(), MAX_FRAMES);
            return Err(PlanarError::TooManyFrames { found, most });
        }
        if self.triangles.len() > MAX_TRIANGLES {
            let (found, most) = (self.triangles.len(), MAX_TRIANGLES);
            return Err(PlanarError::TooManyTriangles { found, most });
        }
        if self.frames.len() * self.triangles.len() > MAX_CORNERS {
            let most = MAX_CORNERS / self.triangles.len();
            let found = self.frames.len();
            return Err(PlanarError::TooManyFrames { found, most });
        }
        let mismatch = |at, what: String| Err(PlanarError::Mismatch { at, what });
        let vertices = self.vertices();
        if !self
            .triangles
            .iter()
            .flatten()
            .all(|v| (*v as usize) < vertices)
        {
            return mismatch(
                "triangles",
                format!("a triangle names a vertex out of range: the clip has {vertices} vertices"),
            );
        }
        let triangles = self.triangles.len();
        if self.surface.len() != triangles || self.part.len() != triangles {
            return mismatch(
                "surface and part",
                format!("expected one entry for each of {triangles} triangles"),
            );
        }
        if !self
            .surface
            .iter()
            .all(|s| usize::from(*s) < self.surfaces.len())
        {
            return mismatch(
                "surface",
                format!(
                    "a surface index is out of range: the clip has {} surfaces",
                    self.surfaces.len()
                ),
            );
        }
        if let Some(texture) = &self.texture {
            texture.check(vertices, triangles)?;
        }
        if !self.fps.is_finite() || self.fps <= 0.0 {
            return mismatch("fps", format!("{}, expected more than 0", self.fps));
        }
        for (f, frame) in self.frames.iter().enumerate() {
            let lengths = [frame.xy.len(), frame.nearness.len(), frame.light.len()];
            if lengths != [vertices; 3] {
                return mismatch("frames", format!("frame {f} must hold {vertices} vertices"));
            }
            for v in 0..vertices {
                let ok = frame.xy[v].is_finite()
                    && frame.nearness[v].is_finite()
                    && frame.light[v].is_finite();
                if !ok {
                    let vertex = v as u32;
                    return Err(PlanarError::NotFinite { frame: f, vertex });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
pub(crate) mod fixture {
    //! Small clips for the tests of this crate.

    use super::*;
    use glam::{Mat3, Vec3};

    /// A unit cube that turns once about a slanted axis, seen from the front under perspective, 100
    /// x 100 pixels; its twelve triangles share eight vertices.
    pub(crate) fn turning_cube(frames: usize) -> PlanarClip {
        let corner = |i: usize| {
            let of = |bit: usize| if i >> bit & 1 == 0 { -0.5 } else { 0.5 };
            Vec3::new(of(0), of(1), of(2))
        };
        // Counter-clockwise seen from outside.
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangles: Vec<[u32; 3]> = quads
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .collect();
        let axis = Vec3::new(0.3, 1.0, 0.1).normalize();
        let frame = |f: usize| {
            let angle = f as f32 / frames.max(1) as f32 * std::f32::consts::TAU;
            let turn = Mat3::from_axis_angle(axis, angle + 0.2);
            let mut out = PlanarFrame::default();
            for i in 0..8 {
                let p = turn * corner(i);
                let depth = 4.0 - p.z;
                out.xy.push(Vec2::new(
                    50.0 + 180.0 * p.x / depth,
                    50.0 - 180.0 * p.y / depth,
                ));
                out.nearness.push(1.0 / depth);
                out.light
                    .push((0.6 + 0.4 * (p.z + 0.3 * p.y)).clamp(0.0, 1.0));
            }
            out
        };
        PlanarClip {
            width: 100,
            height: 100,
            fps: 25.0,
            frames: (0..frames).map(frame).collect(),
            surface: vec![0; triangles.len()],
            part: vec![0; triangles.len()],
            triangles,
            surfaces: vec![PlanarMaterial {
                name: "grey <&> \"green\"".into(),
                albedo: Some([120, 200, 90]),
            }],
            albedo: vec![[120.0, 200.0, 90.0]; 8],
            texture: None,
        }
    }

    /// Separate triangles of one colour each, constant for `frames` frames; corners are `(x, y,
    /// nearness)` in a picture of 40 x 40 pixels.
    pub(crate) fn loose(triangles: &[([[f32; 3]; 3], [u8; 3])], frames: usize) -> PlanarClip {
        let mut frame = PlanarFrame::default();
        let mut albedo = Vec::new();
        for (corners, color) in triangles {
            for [x, y, near] in corners {
                frame.xy.push(Vec2::new(*x, *y));
                frame.nearness.push(*near);
                frame.light.push(1.0);
                albedo.push(color.map(f32::from));
            }
        }
        let count = triangles.len();
        PlanarClip {
            width: 40,
            height: 40,
            fps: 25.0,
            frames: vec![frame; frames],
            triangles: (0..count as u32)
                .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
                .collect(),
            surface: (0..count as u16).collect(),
            part: vec![0; count],
            surfaces: triangles
                .iter()
                .map(|(_, color)| PlanarMaterial {
                    name: String::new(),
                    albedo: Some(*color),
                })
                .collect(),
            albedo,
            texture: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_is_sound_and_its_numbers_are_checked() {
        let cube = fixture::turning_cube(5);
        cube.check().unwrap();
        let mut broken = cube.clone();
        broken.frames[3].xy[2].x = f32::NAN;
        assert_eq!(
            broken.check(),
            Err(PlanarError::NotFinite {
                frame: 3,
                vertex: 2
            })
        );
        let none = PlanarClip {
            frames: vec![],
            ..cube.clone()
        };
        assert_eq!(none.check(), Err(PlanarError::NoFrames));
        let many = PlanarClip {
            triangles: vec![[0; 3]; MAX_TRIANGLES + 1],
            ..cube
        };
        assert!(matches!(
            many.check(),
            Err(PlanarError::TooManyTriangles { .. })
        ));
    }

    #[test]
    fn classes_join_what_is_never_apart() {
        let mut clip = fixture::loose(
            &[
                ([[1.0, 1.0, 0.5], [9.0, 1.0, 0.5], [1.0, 9.0, 0.5]], [9; 3]),
                ([[9.0, 1.0, 0.5], [9.0, 9.0, 0.5], [1.0, 9.0, 0.5]], [9; 3]),
            ],
            2,
        );
        assert_eq!(clip.position_classes(), [0, 1, 2, 1, 3, 2]);
        // A difference in one frame is enough.
        clip.frames[1].xy[3].y += 0.5;
        let classes = clip.position_classes();
        assert_ne!(classes[1], classes[3]);
        assert_eq!(classes[2], classes[5]);
    }
}
