//! Skins, projects and lights a character into a [`PlanarClip`].
//!
//! Source: `docs/methods/vector.md` 2. One key light and an ambient term, both fixed to the viewer;
//! light multiplies sRGB levels, since vector players blend in sRGB. Colours of textured vertices
//! are fitted to the texture in the triangles around them.

use super::clip::{MAX_FRAMES, MAX_TRIANGLES, PlanarClip, PlanarFrame, PlanarMaterial};
use super::error::PlanarError;
use super::subject::PlanarSubject;
use super::vertex_colors::{SurfaceColor, fitted};
use crate::projection::{Projection, Screen};
use articula_core::source::Material;
use articula_core::{Camera, PosedMesh, SkinnedMesh, Wrap, sample, sample_morphs};
use glam::{Quat, Vec2, Vec3};

/// Minimum distance of a vertex from a perspective camera, metres.
const NEAREST_M: f32 = 0.01;

/// A directional key light and an ambient term, fixed to the viewer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lighting {
    /// Direction towards the key light in camera space (x right, y up, z to the viewer).
    pub direction: Vec3,
    /// Strength of the ambient light.
    pub ambient: f32,
    /// Strength of the key light on a surface that faces it; the sum is clamped to 1.
    pub diffuse: f32,
}

impl Default for Lighting {
    fn default() -> Self {
        Self {
            direction: Vec3::new(-0.4, 0.5, 0.77),
            ambient: 0.32,
            diffuse: 0.72,
        }
    }
}

/// Camera, light, frame rate and turntable of a bake.
#[derive(Debug, Clone, PartialEq)]
pub struct BakeOptions {
    /// The camera; its viewport is the size of the picture.
    pub camera: Camera,
    /// Perspective or parallel.
    pub projection: Projection,
    /// The light.
    pub lighting: Lighting,
    /// Frames per second of the planar clip.
    pub fps: f32,
    /// Rotation of the subject during the clip.
    pub turn: Turntable,
}

/// A uniform rotation to the subject's left about a vertical axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Turntable {
    /// Position of the axis, as (x, z) in metres.
    pub axis: (f32, f32),
    /// Angular velocity.
    pub radians_per_sec: f32,
}

impl Turntable {
    /// Angle at a time, radians.
    pub(crate) fn at(&self, secs: f64) -> f32 {
        (f64::from(self.radians_per_sec) * secs) as f32
    }

    /// Rotates a point of the subject by an angle.
    pub(crate) fn apply(&self, point: Vec3, radians: f32) -> Vec3 {
        let axis = Vec3::new(self.axis.0, 0.0, self.axis.1);
        axis + Quat::from_rotation_y(radians) * (point - axis)
    }
}

/// Skins, projects and lights a character at the given times of its clip.
///
/// O(times x vertices).
///
/// # Errors
/// [`PlanarError`]: limits, a vertex that is not finite or not in front of the camera, or triangles
/// of another mesh.
pub fn bake(
    subject: &PlanarSubject<'_>,
    frame_times_secs: &[f64],
    options: &BakeOptions,
) -> Result<PlanarClip, PlanarError> {
    if frame_times_secs.is_empty() {
        return Err(PlanarError::NoFrames);
    }
    if frame_times_secs.len() > MAX_FRAMES {
        let (found, most) = (frame_times_secs.len(), MAX_FRAMES);
        return Err(PlanarError::TooManyFrames { found, most });
    }
    let (mut clip, sources) = still_parts(subject, options)?;
    let mut poser = Poser::new(subject);
    for (f, secs) in frame_times_secs.iter().enumerate() {
        poser.pose(*secs);
        let angle = options.turn.at(*secs);
        let frame = project(&poser.skinned, &sources, f, angle, options)?;
        clip.frames.push(frame);
    }
    clip.check()?;
    Ok(clip)
}

/// Projects and lights the rest pose as [`bake`] does, one frame for each set of morph weights.
///
/// O(shapes x vertices).
///
/// # Errors
/// As [`bake`], and [`PlanarError::Mismatch`] if a set has another number of weights than the mesh.
pub fn bake_shapes(
    subject: &PlanarSubject<'_>,
    shapes: &[Vec<f32>],
    options: &BakeOptions,
) -> Result<PlanarClip, PlanarError> {
    let slots = subject.mesh.morph_weights.len();
    if let Some(shape) = shapes.iter().position(|s| s.len() != slots) {
        let what = format!(
            "shape {shape} has {} weights, the mesh has {slots} morph slots",
            shapes[shape].len()
        );
        let at = "shapes";
        return Err(PlanarError::Mismatch { at, what });
    }
    let (mut clip, sources) = still_parts(subject, options)?;
    let still = PlanarSubject {
        clip: None,
        ..*subject
    };
    let mut poser = Poser::new(&still);
    for (f, weights) in shapes.iter().enumerate() {
        poser.shape(weights);
        let frame = project(&poser.skinned, &sources, f, 0.0, options)?;
        clip.frames.push(frame);
    }
    clip.check()?;
    Ok(clip)
}

/// Source of a planar vertex: a vertex of the mesh and the side it shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct SourceVertex {
    pub(super) vertex: u32,
    is_back: bool,
    /// Bits of the share of its colour that does not depend on the light.
    own_light: u32,
}

/// The parts of the clip that are constant over time.
pub(super) fn still_parts(
    subject: &PlanarSubject<'_>,
    options: &BakeOptions,
) -> Result<(PlanarClip, Vec<SourceVertex>), PlanarError> {
    let mesh = subject.mesh;
    if subject.triangles.len() > MAX_TRIANGLES {
        let (found, most) = (subject.triangles.len(), MAX_TRIANGLES);
        return Err(PlanarError::TooManyTriangles { found, most });
    }
    let inside = |v: &u32| (*v as usize) < mesh.len();
    if !subject.triangles.iter().flatten().all(inside) {
        let what = format!(
            "a triangle names a vertex out of range: the mesh has {} vertices",
            mesh.len()
        );
        let at = "triangles";
        return Err(PlanarError::Mismatch { at, what });
    }
    let painter = Painter::new(subject);
    let viewport = options.camera.viewport;
    let mut clip = PlanarClip {
        width: viewport.width_px.round() as u32,
        height: viewport.height_px.round() as u32,
        fps: options.fps,
        frames: Vec::new(),
        triangles: Vec::new(),
        surface: Vec::new(),
        part: Vec::new(),
        surfaces: painter.surfaces(),
        albedo: Vec::new(),
        texture: None,
    };
    let colors = fitted(subject, |triangle| {
        painter.appearance(painter.part_of[triangle[0] as usize])
    });
    let mut index = std::collections::BTreeMap::new();
    let mut sources = Vec::new();
    for triangle in subject.triangles {
        let part = painter.part_of[triangle[0] as usize];
        let material = painter.material(part);
        if painter.is_cut_away(triangle, material) {
            continue;
        }
        for is_back in [false, true] {
            if is_back && !material.double_sided {
                continue;
            }
            let own_light = painter.own_light(triangle).to_bits();
            let mut corners = triangle.map(|vertex| {
                let source = SourceVertex {
                    vertex,
                    is_back,
                    own_light,
                };
                *index.entry(source).or_insert_with(|| {
                    sources.push(source);
                    clip.albedo.push(colors[&vertex]);
                    sources.len() as u32 - 1
                })
            });
            if is_back {
                corners.swap(1, 2);
            }
            clip.triangles.push(corners);
            clip.surface.push(part as u16);
            clip.part.push(painter.joint_of(triangle));
        }
    }
    Ok((clip, sources))
}

/// Computes colours of vertices and materials of parts.
pub(super) struct Painter<'a> {
    subject: PlanarSubject<'a>,
    part_of: Vec<usize>,
    materials: Vec<Material>,
    /// Share of each one's colour that does not depend on the light.
    own_light: Vec<f32>,
}

impl<'a> Painter<'a> {
    pub(super) fn new(subject: &PlanarSubject<'a>) -> Self {
        let mesh = subject.mesh;
        let mut part_of = vec![0; mesh.len()];
        for (p, part) in mesh.parts.iter().enumerate() {
            part_of[part.vertices.clone()].fill(p);
        }
        let appearance = subject.appearance;
        let of = |m: Option<usize>| m.and_then(|m| appearance.materials.get(m)).cloned();
        let mut materials: Vec<Material> = mesh
            .parts
            .iter()
            .map(|part| of(part.material).unwrap_or_default())
            .collect();
        if materials.is_empty() {
            materials.push(Material::default());
        }
        Self {
            own_light: materials.iter().map(|m| appearance.own_light(m)).collect(),
            subject: *subject,
            part_of,
            materials,
        }
    }

    fn material(&self, part: usize) -> &Material {
        &self.materials[part]
    }

    /// Material of a triangle.
    pub(super) fn material_of(&self, triangle: &[u32; 3]) -> &Material {
        self.material(self.part_of[triangle[0] as usize])
    }

    /// Material and texture of a triangle.
    pub(super) fn appearance_of(&self, triangle: &[u32; 3]) -> SurfaceColor<'_> {
        self.appearance(self.part_of[triangle[0] as usize])
    }

    /// sRGB levels and opacity of a triangle at barycentric weights, without light.
    pub(super) fn color(&self, triangle: &[u32; 3], weights: Vec3, level: usize) -> (Vec3, f32) {
        let mesh = self.subject.mesh;
        let [a, b, c] = triangle.map(|v| v as usize);
        let colors = &mesh.colors;
        let vertex = colors[a] * weights.x + colors[b] * weights.y + colors[c] * weights.z;
        let uv = &mesh.texcoords;
        let at = uv[a] * weights.x + uv[b] * weights.y + uv[c] * weights.z;
        self.appearance_of(triangle).color(vertex, at, level)
    }

    /// Texture coordinates of a triangle's corners.
    pub(super) fn texcoords(&self, triangle: &[u32; 3]) -> [Vec2; 3] {
        triangle.map(|v| self.subject.mesh.texcoords[v as usize])
    }

    /// Mip level of a triangle's texture for an area of texture space (1 is all of it) on one pixel.
    pub(super) fn level_of(&self, triangle: &[u32; 3], area: f32) -> usize {
        let detail = self.appearance_of(triangle).detail();
        detail.map_or(0, |texture| texture.level_for(area, 1.0))
    }

    /// Mip level of a triangle's texture if the triangle has this many samples.
    pub(super) fn level_for(&self, triangle: &[u32; 3], samples: f32) -> usize {
        let [a, b, c] = self.texcoords(triangle);
        self.level_of(triangle, (b - a).perp_dot(c - a) / 2.0 / samples)
    }

    /// One material for each part of the mesh.
    fn surfaces(&self) -> Vec<PlanarMaterial> {
        let mesh = self.subject.mesh;
        let of_part = |(p, material): (usize, &Material)| {
            let vertices = mesh.parts.get(p).map_or(0..0, |part| part.vertices.clone());
            let appearance = self.appearance(p);
            let color = |v| appearance.at_vertex(&self.subject, v as u32).to_array();
            let mut colors = vertices.map(|v| color(v).map(|level| level as u8));
            let first = colors.next().unwrap_or([255; 3]);
            let is_plain = appearance.detail().is_none();
            PlanarMaterial {
                name: material.name.clone(),
                albedo: (is_plain && colors.all(|c| c == first)).then_some(first),
            }
        };
        self.materials.iter().enumerate().map(of_part).collect()
    }

    fn appearance(&self, part: usize) -> SurfaceColor<'_> {
        let material = &self.materials[part];
        SurfaceColor {
            material,
            texture: self.subject.appearance.texture_of(material),
            emission: self.subject.appearance.emission_of(material),
        }
    }

    /// Share of a triangle's colour that does not depend on the light.
    pub(super) fn own_light(&self, triangle: &[u32; 3]) -> f32 {
        self.own_light[self.part_of[triangle[0] as usize]]
    }

    /// Whether a triangle of a cut-out material is transparent at its corners and its centroid.
    fn is_cut_away(&self, triangle: &[u32; 3], material: &Material) -> bool {
        let places = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::splat(1.0 / 3.0)];
        let opacity = |weights| self.color(triangle, weights, 0).1;
        material.alpha_cutoff > 0.0
            && places
                .into_iter()
                .all(|place| opacity(place) < material.alpha_cutoff)
    }

    /// Joint with the greatest summed skin weight of a triangle.
    fn joint_of(&self, triangle: &[u32; 3]) -> u16 {
        let mesh = self.subject.mesh;
        let mut weights = std::collections::BTreeMap::new();
        for v in triangle {
            for (joint, weight) in mesh.influences_of(*v as usize) {
                *weights.entry(joint as u16).or_insert(0.0f32) += weight;
            }
        }
        let heaviest = weights
            .into_iter()
            .reduce(|a, b| if b.1 > a.1 { b } else { a });
        heaviest.map_or(0, |(joint, _)| joint)
    }
}

/// Poses the subject at given times; reuses its buffers.
pub(super) struct Poser<'a> {
    subject: PlanarSubject<'a>,
    local: articula_core::LocalPose,
    posed: PosedMesh<'a>,
    weights: Vec<f32>,
    pub(super) skinned: SkinnedMesh,
}

impl<'a> Poser<'a> {
    pub(super) fn new(subject: &PlanarSubject<'a>) -> Self {
        Self {
            subject: *subject,
            local: subject.rig.rest_pose().clone(),
            posed: PosedMesh::new(subject.rig, subject.mesh),
            weights: subject.morph_weights.to_vec(),
            skinned: SkinnedMesh::new(subject.mesh),
        }
    }

    /// Poses the subject at a time of its clip.
    pub(super) fn pose(&mut self, secs: f64) {
        let PlanarSubject { rig, clip, .. } = self.subject;
        self.local.copy_from(rig.rest_pose());
        self.weights.copy_from_slice(self.subject.morph_weights);
        if let Some(clip) = clip {
            // At the last frame itself the clip does not wrap to the first one; durations are
            // rounded.
            let is_within = secs <= f64::from(clip.duration_secs()) + 1e-4;
            let wrap = if is_within { Wrap::Clamp } else { Wrap::Loop };
            sample(clip, secs, wrap, &rig.all(), &mut self.local);
            sample_morphs(clip, secs, wrap, &mut self.weights);
        }
        self.skin();
    }

    /// Applies morph weights in the rest pose.
    pub(super) fn shape(&mut self, weights: &[f32]) {
        self.local.copy_from(self.subject.rig.rest_pose());
        self.weights.copy_from_slice(weights);
        self.skin();
    }

    fn skin(&mut self) {
        let posed = self.posed.pose(&self.local);
        posed.skin(&self.weights, &mut self.skinned);
    }
}

fn project(
    skinned: &SkinnedMesh,
    sources: &[SourceVertex],
    frame: usize,
    angle: f32,
    options: &BakeOptions,
) -> Result<PlanarFrame, PlanarError> {
    let screen = Screen::new(&options.camera, options.projection);
    let turn = Quat::from_rotation_y(angle);
    let lighting = options.lighting;
    let toward = options.camera.orientation * lighting.direction.normalize_or(Vec3::Z);
    let mut out = PlanarFrame::default();
    for source in sources {
        let v = source.vertex as usize;
        let position = options.turn.apply(skinned.positions[v], angle);
        let normal = turn * skinned.normals[v];
        let vertex = source.vertex;
        let corner = screen.corner(position);
        if !corner.is_finite() || !normal.is_finite() {
            return Err(PlanarError::NotFinite { frame, vertex });
        }
        if corner.w < NEAREST_M {
            return Err(PlanarError::BehindCamera { frame, vertex });
        }
        out.xy.push(Vec2::new(corner.x, corner.y) / corner.w);
        out.nearness.push(corner.z / corner.w);
        let light = vertex_light(&lighting, normal.dot(toward), source.is_back);
        out.light
            .push(with_own(light, f32::from_bits(source.own_light)));
    }
    Ok(out)
}

/// The light by which a colour is multiplied of which a share does not depend on it.
pub(super) fn with_own(light: f32, share: f32) -> f32 {
    share + (1.0 - share) * light
}

/// Light on a vertex, 0 to 1, from the cosine between its normal and the direction to the light.
pub(super) fn vertex_light(lighting: &Lighting, cosine: f32, is_back: bool) -> f32 {
    let facing = cosine * if is_back { -1.0 } else { 1.0 };
    (lighting.ambient + lighting.diffuse * facing.max(0.0)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::fixture::figure;

    #[test]
    fn places_are_those_of_the_camera() {
        let figure = figure();
        let clip = bake(&figure.subject(), &[0.0], &figure.options).unwrap();
        let mesh = &figure.asset.mesh;
        let rig = &figure.asset.rig;
        let mut posed = PosedMesh::new(rig, mesh);
        let skinned = posed.pose(rig.rest_pose()).skinned(&mesh.morph_weights);
        let (expected, depth) = figure
            .options
            .camera
            .project(skinned.positions[mesh.triangles[7][1] as usize]);
        let v = clip.triangles[7][1] as usize;
        assert!((clip.frames[0].xy[v] - expected).length() < 1e-3);
        assert!((clip.frames[0].nearness[v] * depth - 1.0).abs() < 1e-4);
    }

    #[test]
    fn a_full_turn_ends_where_it_began_and_half_of_it_shows_the_back() {
        let mut figure = figure();
        figure.options.turn.radians_per_sec = std::f32::consts::PI;
        let turned = bake(&figure.subject(), &[0.0, 1.0, 2.0], &figure.options).unwrap();
        let apart = |a: usize, b: usize| {
            let pairs = turned.frames[a].xy.iter().zip(&turned.frames[b].xy);
            pairs.map(|(p, q)| (*p - *q).length()).fold(0.0, f32::max)
        };
        assert!(apart(0, 2) < 1e-2);
        assert!(apart(0, 1) > 10.0);
    }

    #[test]
    fn a_camera_inside_and_a_foreign_triangle_are_told() {
        let mut figure = figure();
        figure.options.camera.eye = Vec3::new(0.0, 1.2, 0.0);
        let inside = bake(&figure.subject(), &[0.0], &figure.options);
        assert!(matches!(
            inside,
            Err(PlanarError::BehindCamera { frame: 0, .. })
        ));
        let mut foreign = figure.subject();
        foreign.triangles = &[[0, 1, u32::MAX]];
        let foreign = bake(&foreign, &[0.0], &figure.options);
        assert!(matches!(foreign, Err(PlanarError::Mismatch { .. })));
        let none = bake(&figure.subject(), &[], &figure.options);
        assert_eq!(none, Err(PlanarError::NoFrames));
    }

    #[test]
    fn the_part_of_a_triangle_is_the_joint_that_moves_it_most() {
        let figure = figure();
        let clip = bake(&figure.subject(), &[0.0], &figure.options).unwrap();
        let mesh = &figure.asset.mesh;
        for (triangle, part) in mesh.triangles.iter().zip(&clip.part) {
            let mut sums = vec![0.0f32; figure.asset.rig.len()];
            for (joint, weight) in triangle
                .iter()
                .flat_map(|v| mesh.influences_of(*v as usize))
            {
                sums[joint] += weight;
            }
            let most = sums.iter().copied().fold(0.0, f32::max);
            assert!(sums[usize::from(*part)] >= most - 1e-5);
        }
    }

    #[test]
    fn two_sided_triangles_are_there_twice_with_opposite_light() {
        let mut figure = figure();
        for material in &mut figure.appearance.materials {
            material.double_sided = true;
        }
        let clip = bake(&figure.subject(), &[0.0], &figure.options).unwrap();
        let count = figure.asset.mesh.triangles.len();
        assert_eq!(clip.triangles.len(), 2 * count);
        let [a, b, c] = clip.places(0, 0);
        let [p, q, r] = clip.places(0, 1);
        assert_eq!((a, b, c), (p, r, q));
        let ambient = figure.options.lighting.ambient;
        let light = |t: usize| clip.frames[0].light[clip.triangles[t][0] as usize];
        assert!((light(0).min(light(1)) - ambient).abs() < 1e-6);
    }
}
