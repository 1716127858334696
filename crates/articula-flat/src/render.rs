//! Renders a skinned character to a lit picture.
//!
//! Smooth normals under a key light, a weaker fill light from the other side and an even ambient
//! term; base colour factor, texture and vertex colour multiply in linear light. Each pixel is
//! shaded once per triangle that it shows, at the mean position of that triangle's samples.

use crate::appearance::Appearance;
use crate::error::PictureError;
use crate::ground::{ContactShadow, Ground, grid_coverage};
use crate::item_buffer::{Faces, ItemBuffer, Supersampling, barycentric};
use crate::picture::{Picture, Rgba, linear_table, srgb_byte};
use crate::projection::{Projection, Screen};
use articula_core::source::Material;
use articula_core::{Camera, Mesh, SkinnedMesh};
use glam::{Vec2, Vec3, Vec4};

/// Selection of the mesh parts that are drawn, by index into [`Mesh::parts`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum PartSelection {
    /// Every part.
    #[default]
    All,
    /// Only these parts.
    Only(Vec<usize>),
    /// All parts except these.
    Except(Vec<usize>),
}

impl PartSelection {
    /// Returns whether a part is drawn.
    pub(crate) fn contains(&self, part: usize) -> bool {
        match self {
            Self::All => true,
            Self::Only(parts) => parts.contains(&part),
            Self::Except(parts) => !parts.contains(&part),
        }
    }
}

/// Direction of the key light and strengths of all lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Direction towards the key light, in camera space (x right, y up, z to the viewer).
    pub key_direction: Vec3,
    /// Strength of the key light; strengths are summed on a surface that faces all lights.
    pub key: f32,
    /// Strength of the fill light, which comes from the opposite side.
    pub fill: f32,
    /// Strength of the ambient light, a quarter more from above and a quarter less from below.
    pub ambient: f32,
}

impl Default for Light {
    fn default() -> Self {
        Self {
            key_direction: Vec3::new(-0.45, 0.65, 0.8),
            key: 0.68,
            fill: 0.12,
            ambient: 0.18,
        }
    }
}

/// Options of [`render()`].
#[derive(Debug, Clone, PartialEq)]
pub struct RenderOptions {
    /// Background colour; may be transparent.
    pub background: Rgba,
    /// Number of samples per pixel.
    pub samples: Supersampling,
    /// Perspective or parallel.
    pub projection: Projection,
    /// Floor with a contact shadow.
    pub ground: Option<Ground>,
    /// Light directions and strengths.
    pub light: Light,
    /// Parts that are drawn.
    pub parts: PartSelection,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            background: [234, 237, 242, 255],
            samples: Supersampling::Two,
            projection: Projection::Perspective,
            ground: None,
            light: Light::default(),
            parts: PartSelection::All,
        }
    }
}

/// Renders a skinned character into a picture of the size of the camera's viewport.
///
/// O(vertices + samples covered).
///
/// # Errors
/// [`PictureError::LimitExceeded`] if the viewport is too large, [`PictureError::Mismatch`] if
/// `skinned` belongs to another mesh.
pub fn render(
    mesh: &Mesh,
    skinned: &SkinnedMesh,
    appearance: &Appearance,
    camera: &Camera,
    options: &RenderOptions,
) -> Result<Picture, PictureError> {
    if skinned.positions.len() != mesh.len() || skinned.normals.len() != mesh.len() {
        return Err(PictureError::Mismatch {
            at: "skinned",
            what: format!(
                "{} positions and {} normals, the mesh has {} vertices",
                skinned.positions.len(),
                skinned.normals.len(),
                mesh.len()
            ),
        });
    }
    let scene = RenderPass::new(mesh, skinned, appearance, camera, options)?;
    let buffer = scene.draw()?;
    scene.shade(&buffer)
}

/// Inputs of one picture.
struct RenderPass<'a> {
    mesh: &'a Mesh,
    skinned: &'a SkinnedMesh,
    appearance: &'a Appearance,
    options: &'a RenderOptions,
    screen: Screen,
    corners: Vec<Vec4>,
    part_of: Vec<u32>,
    materials: Vec<Material>,
    lights: Lights,
    floor: Option<Floor>,
}

/// The floor, its shadow, and the rectangle of pixels in which it may be visible.
struct Floor {
    ground: Ground,
    shadow: ContactShadow,
    low: Vec2,
    high: Vec2,
}

impl Floor {
    fn new(ground: Ground, shadow: ContactShadow, screen: &Screen) -> Self {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(x, z)| {
            let place = ground.middle + ground.radius_m * Vec2::new(x, z);
            screen.place(Vec3::new(place.x, ground.height_m, place.y))
        });
        // With a corner behind the camera the floor may appear anywhere.
        let everywhere = corners.iter().any(Option::is_none);
        let seen = corners.into_iter().flatten();
        let (low, high) = if everywhere {
            (Vec2::MIN, Vec2::MAX)
        } else {
            let high = seen.clone().fold(Vec2::MIN, Vec2::max);
            (seen.fold(Vec2::MAX, Vec2::min), high)
        };
        Self {
            ground,
            shadow,
            low,
            high,
        }
    }

    fn may_show(&self, x: u32, y: u32) -> bool {
        let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        at.cmpge(self.low - 1.0).all() && at.cmple(self.high + 1.0).all()
    }
}

/// Unit directions towards the lights in model space, and their strengths.
struct Lights {
    key: Vec3,
    fill: Vec3,
    strength: Light,
}

impl Lights {
    fn new(light: Light, camera: &Camera) -> Self {
        let toward = light.key_direction.try_normalize().unwrap_or(Vec3::Z);
        let opposite = Vec3::new(-toward.x, 0.2, toward.z).normalize_or(Vec3::Z);
        Self {
            key: camera.orientation * toward,
            fill: camera.orientation * opposite,
            strength: light,
        }
    }

    /// Light that a surface with this unit normal receives.
    fn on(&self, normal: Vec3) -> f32 {
        // The key light wraps a little around the terminator, as a large lamp does.
        let key = ((normal.dot(self.key) + 0.2) / 1.2).max(0.0);
        let fill = normal.dot(self.fill).max(0.0);
        let ambient = self.strength.ambient * (1.0 + 0.25 * normal.y);
        ambient + self.strength.key * key + self.strength.fill * fill
    }
}

impl<'a> RenderPass<'a> {
    fn new(
        mesh: &'a Mesh,
        skinned: &'a SkinnedMesh,
        appearance: &'a Appearance,
        camera: &Camera,
        options: &'a RenderOptions,
    ) -> Result<Self, PictureError> {
        let screen = Screen::new(camera, options.projection);
        let mut part_of = vec![0; mesh.triangles.len()];
        for (p, part) in mesh.parts.iter().enumerate() {
            part_of[part.triangles.clone()].fill(p as u32);
        }
        let material = |m: Option<usize>| m.and_then(|m| appearance.materials.get(m)).cloned();
        let materials = mesh.parts.iter().map(|p| material(p.material));
        let materials = materials.map(Option::unwrap_or_default).collect();
        let mut scene = Self {
            mesh,
            skinned,
            appearance,
            options,
            screen,
            corners: skinned
                .positions
                .iter()
                .map(|p| screen.corner(*p))
                .collect(),
            part_of,
            materials,
            lights: Lights::new(options.light, camera),
            floor: None,
        };
        if let Some(ground) = options.ground {
            let triangles = scene.visible().map(|t| mesh.triangles[t]);
            let shadow = ContactShadow::new(&skinned.positions, triangles, ground.height_m)?;
            scene.floor = Some(Floor::new(ground, shadow, &screen));
        }
        Ok(scene)
    }

    /// Indices of the triangles of the parts that are drawn.
    fn visible(&self) -> impl Iterator<Item = usize> + '_ {
        let parts = self.mesh.parts.iter().enumerate();
        parts
            .filter(|(p, _)| self.options.parts.contains(*p))
            .flat_map(|(_, part)| part.triangles.clone())
    }

    fn draw(&self) -> Result<ItemBuffer, PictureError> {
        let viewport = self.screen.camera().viewport;
        let (width, height) = (viewport.width_px.round(), viewport.height_px.round());
        let mut buffer = ItemBuffer::new(width as u32, height as u32, self.options.samples)?;
        for t in self.visible() {
            let material = self.material(t);
            let corners = self.corners_of(t);
            let faces = if material.double_sided {
                Faces::Both
            } else {
                Faces::Front
            };
            if material.alpha_cutoff > 0.0 {
                let level = self.texture_level(t);
                buffer.draw_where(t as u32, corners, faces, |at| {
                    barycentric(&corners, at)
                        .is_some_and(|w| self.surface(t, w, level).w >= material.alpha_cutoff)
                });
            } else {
                buffer.draw(t as u32, corners, faces);
            }
        }
        Ok(buffer)
    }

    fn shade(&self, buffer: &ItemBuffer) -> Result<Picture, PictureError> {
        let (width, height) = buffer.size();
        let mut picture = Picture::new(width, height, self.options.background)?;
        let levels: Vec<u8> = (0..self.mesh.triangles.len())
            .map(|t| self.texture_level(t) as u8)
            .collect();
        let background = linear(self.options.background);
        let mut groups = Groups::default();
        for y in 0..height {
            for x in 0..width {
                if !buffer.is_blank(x, y) {
                    groups.gather(buffer, x, y);
                } else if self.floor.as_ref().is_some_and(|f| f.may_show(x, y)) {
                    // The floor is smooth: one sample in the centre is enough.
                    groups.blank(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
                } else {
                    continue;
                }
                picture.set(x, y, self.pixel(&groups, &levels, background));
            }
        }
        Ok(picture)
    }

    /// Mean colour of the samples of a pixel.
    fn pixel(&self, groups: &Groups, levels: &[u8], background: Vec4) -> Rgba {
        let mut sum = Vec4::ZERO;
        let mut samples = 0.0;
        for group in groups.iter() {
            let at = group.places / group.count;
            let mut color = background;
            if let Some(t) = group.item {
                let t = t as usize;
                color = self.fragment(t, at, usize::from(levels[t]));
            }
            color = self.over_floor(color, background, at, group);
            sum += color.truncate().extend(1.0) * (color.w * group.count);
            samples += group.count;
        }
        encode(sum, samples)
    }

    /// Lit colour of a triangle at a screen position.
    fn fragment(&self, triangle: usize, at: Vec2, level: usize) -> Vec4 {
        let corners = self.corners_of(triangle);
        let weights = barycentric(&corners, at).unwrap_or(Vec3::splat(1.0 / 3.0));
        let [a, b, c] = self.mesh.triangles[triangle].map(|v| v as usize);
        let n = &self.skinned.normals;
        let normal = n[a] * weights.x + n[b] * weights.y + n[c] * weights.z;
        let mut normal = normal.try_normalize().unwrap_or(Vec3::Y);
        // Some files wind part of their triangles backwards; their normals are right, so a triangle
        // counts as a back only if its normal points away too.
        let away = normal.dot(self.screen.ray(at).direction) > 0.0;
        if away && self.shows_back(triangle) {
            normal = -normal;
        }
        let color = self.surface(triangle, weights, level).truncate();
        let material = self.material(triangle);
        if material.unlit {
            return color.extend(1.0);
        }
        let own = self.appearance.emission_of(material);
        let own = own.at(self.texcoord(triangle, weights), level);
        (color * self.lights.on(normal) + own).extend(1.0)
    }

    fn texcoord(&self, triangle: usize, weights: Vec3) -> Vec2 {
        let [a, b, c] = self.mesh.triangles[triangle].map(|v| v as usize);
        let uv = &self.mesh.texcoords;
        uv[a] * weights.x + uv[b] * weights.y + uv[c] * weights.z
    }

    /// Base colour of a triangle: factor, texture and vertex colour, linear RGBA.
    fn surface(&self, triangle: usize, weights: Vec3, level: usize) -> Vec4 {
        let [a, b, c] = self.mesh.triangles[triangle].map(|v| v as usize);
        let material = self.material(triangle);
        let colors = &self.mesh.colors;
        let vertex = colors[a] * weights.x + colors[b] * weights.y + colors[c] * weights.z;
        let mut color = material.base_color * vertex;
        if let Some(texture) = self.appearance.texture_of(material) {
            color *= texture.sample(self.texcoord(triangle, weights), level);
        }
        color
    }

    /// Composites the floor in front of or behind a colour; what lies below the floor shines
    /// through a little.
    fn over_floor(&self, color: Vec4, background: Vec4, at: Vec2, group: &Group) -> Vec4 {
        let Some(Floor { ground, shadow, .. }) = &self.floor else {
            return color;
        };
        let ray = self.screen.ray(at);
        let depth = (ground.height_m - ray.origin.y) / ray.direction.y;
        let seen_from_above = ray.direction.y < 0.0 && depth > 0.0 && depth.is_finite();
        let nearness = group.nearness / group.count;
        let floor_is_nearer = seen_from_above && self.screen.nearness_of(depth) > nearness;
        if !floor_is_nearer {
            return color;
        }
        let point = ray.origin + ray.direction * depth;
        let place = Vec2::new(point.x, point.z);
        let away = place.distance(ground.middle) / ground.radius_m.max(1e-3);
        let fade = (1.0 - away * away).clamp(0.0, 1.0);
        let darkness = shadow.at(place);
        if fade == 0.0 && darkness == 0.0 {
            return color;
        }
        let metres = 1.0 / self.screen.pixels_per_metre_at(point);
        let slant = (ray.direction.y / ray.direction.length()).abs().max(1e-3);
        // A pixel is stretched on the floor along the horizontal viewing direction.
        let flat = Vec2::new(ray.direction.x, ray.direction.z).normalize_or(Vec2::Y);
        let footprint = metres * (flat.abs() / slant + Vec2::new(flat.y, flat.x).abs());
        let line = grid_coverage(place, footprint);
        let tone = 1.0 - fade * (0.05 + 0.30 * line);
        let tone = tone * (1.0 - 0.78 * darkness);
        let floor = floor_tone(background, tone);
        match group.item {
            Some(_) => floor.lerp(color, 0.25),
            None => floor,
        }
    }

    fn material(&self, triangle: usize) -> &Material {
        &self.materials[self.part_of[triangle] as usize]
    }

    fn corners_of(&self, triangle: usize) -> [Vec4; 3] {
        self.mesh.triangles[triangle].map(|v| self.corners[v as usize])
    }

    /// Whether the camera sees the back of a triangle (only possible if it is double-sided).
    fn shows_back(&self, triangle: usize) -> bool {
        // The sign of this volume is that of the area on the screen, clipped or not; the picture's
        // y axis points down, so the front has a negative one.
        let [a, b, c] = self.corners_of(triangle).map(|p| Vec3::new(p.x, p.y, p.w));
        a.dot(b.cross(c)) > 0.0
    }

    fn texture_level(&self, triangle: usize) -> usize {
        let Some(texture) = self.appearance.detail_of(self.material(triangle)) else {
            return 0;
        };
        let uv = self.mesh.triangles[triangle].map(|v| self.mesh.texcoords[v as usize]);
        let area = 0.5 * (uv[1] - uv[0]).perp_dot(uv[2] - uv[0]);
        let corners = self.corners_of(triangle);
        if corners.iter().any(|p| p.w < 1e-3) {
            return 0;
        }
        let [a, b, c] = corners.map(|p| Vec2::new(p.x, p.y) / p.w);
        texture.level_for(area, 0.5 * (b - a).perp_dot(c - a))
    }
}

/// Background with a fraction of its light removed; a transparent one gets a black veil.
fn floor_tone(background: Vec4, tone: f32) -> Vec4 {
    let alpha = 1.0 - (1.0 - background.w) * tone;
    if alpha <= 0.0 {
        return Vec4::ZERO;
    }
    (background.truncate() * (background.w * tone / alpha)).extend(alpha)
}

fn linear([r, g, b, a]: Rgba) -> Vec4 {
    let table = linear_table();
    let of = |byte: u8| table[usize::from(byte)];
    Vec4::new(of(r), of(g), of(b), f32::from(a) / 255.0)
}

/// Mean colour as bytes, from a sum of premultiplied colours.
fn encode(sum: Vec4, count: f32) -> Rgba {
    if sum.w <= 0.0 {
        return [0; 4];
    }
    let [r, g, b] = (sum.truncate() / sum.w).to_array().map(srgb_byte);
    let alpha = (sum.w / count * 255.0).round() as u8;
    [r, g, b, alpha]
}

/// Samples of a pixel that show the same triangle.
#[derive(Clone, Copy, Default)]
struct Group {
    item: Option<u32>,
    count: f32,
    places: Vec2,
    nearness: f32,
}

/// The distinct triangles of a pixel, at most sixteen.
#[derive(Default)]
struct Groups {
    groups: [Group; 16],
    len: usize,
}

impl Groups {
    /// Groups the samples of a pixel by triangle.
    fn gather(&mut self, buffer: &ItemBuffer, x: u32, y: u32) {
        self.len = 0;
        let n = buffer.samples().per_side();
        for sample_y in y * n..(y + 1) * n {
            for sample_x in x * n..(x + 1) * n {
                let place = buffer.position(sample_x, sample_y);
                let (item, nearness) = buffer.sample(sample_x, sample_y);
                let group = self.of(item);
                group.count += 1.0;
                group.places += place;
                group.nearness += nearness;
            }
        }
    }

    /// Adds one sample that shows nothing.
    fn blank(&mut self, place: Vec2) {
        self.groups[0] = Group {
            item: None,
            count: 1.0,
            places: place,
            nearness: f32::NEG_INFINITY,
        };
        self.len = 1;
    }

    fn of(&mut self, item: Option<u32>) -> &mut Group {
        let known = self.groups[..self.len].iter().position(|g| g.item == item);
        // In a pixel with more than sixteen triangles the last group takes the rest.
        let at = known.unwrap_or(self.len.min(self.groups.len() - 1));
        if at == self.len {
            self.groups[at] = Group {
                item,
                ..Group::default()
            };
            self.len += 1;
        }
        &mut self.groups[at]
    }

    fn iter(&self) -> impl Iterator<Item = &Group> {
        self.groups[..self.len].iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Viewport;
    use articula_core::source::{self, Image};

    /// Ambient light only, so that colours come out unchanged.
    const EVEN: Light = Light {
        key_direction: Vec3::Z,
        key: 0.0,
        fill: 0.0,
        ambient: 1.0,
    };

    /// Squares of one metre that face +Z, one part at each depth.
    fn plates(depths: &[f32]) -> (Mesh, SkinnedMesh) {
        let plate = |z: &f32| source::RawMesh {
            skin: source::Skin {
                joints: vec![0],
                inverse_bind: vec![glam::Affine3A::IDENTITY],
            },
            primitives: vec![source::Primitive {
                positions: [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
                    .map(|(x, y)| Vec3::new(x, y, *z))
                    .to_vec(),
                texcoords: [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)]
                    .map(|(u, v)| Vec2::new(u, v))
                    .to_vec(),
                influences: 1,
                joints: vec![0; 4],
                weights: vec![1.0; 4],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                material: Some(0),
                ..source::Primitive::default()
            }],
            ..source::RawMesh::default()
        };
        let sources: Vec<source::RawMesh> = depths.iter().map(plate).collect();
        let mesh = Mesh::new(&sources, 1).unwrap();
        let mut skinned = SkinnedMesh::new(&mesh);
        skinned.positions.clone_from(&mesh.positions);
        skinned.normals.clone_from(&mesh.normals);
        (mesh, skinned)
    }

    fn camera(eye: Vec3) -> Camera {
        let viewport = Viewport {
            width_px: 64.0,
            height_px: 64.0,
            ..Viewport::default()
        };
        Camera::looking_at(eye, Vec3::ZERO, viewport)
    }

    fn even() -> RenderOptions {
        RenderOptions {
            background: [1, 2, 3, 255],
            light: EVEN,
            ..RenderOptions::default()
        }
    }

    /// Colour in the centre of a picture of one plate.
    fn middle(material: Material, images: &[Image], eye: Vec3) -> Rgba {
        let (mesh, skinned) = plates(&[0.0]);
        let (appearance, faults) = Appearance::new(&[material], images);
        assert!(faults.is_empty());
        let picture = render(&mesh, &skinned, &appearance, &camera(eye), &even()).unwrap();
        picture.get(31, 31).unwrap()
    }

    #[test]
    fn colours_multiply_in_linear_light() {
        let base = Material {
            base_color: Vec4::new(0.5, 0.25, 1.0, 1.0),
            ..Material::default()
        };
        // Half the light is byte 188, a quarter byte 137: 255 * (1.055 * 0.25^(1/2.4) - 0.055).
        let plain = middle(base.clone(), &[], Vec3::Z * 2.0);
        assert_eq!(plain, [188, 137, 255, 255]);
        let grey = Picture::new(4, 4, [188, 188, 188, 255]).unwrap();
        let image = Image {
            bytes: grey.to_png().unwrap(),
            ..Image::default()
        };
        let textured = Material {
            base_color_image: Some(0),
            ..base
        };
        // Byte 188 is 0.5029 linear: blue comes back as 188 itself, red is 0.2514 and green
        // 0.1257, byte 255 * (1.055 * 0.1257^(1/2.4) - 0.055) = 99.4.
        let seen = middle(textured, &[image], Vec3::Z * 2.0);
        assert_eq!(seen, [137, 99, 188, 255]);
    }

    #[test]
    fn backs_show_only_if_double_sided_and_cut_alpha_never() {
        let material = |double_sided, alpha, alpha_cutoff| Material {
            base_color: Vec3::ONE.extend(alpha),
            double_sided,
            alpha_cutoff,
            ..Material::default()
        };
        let behind = Vec3::Z * -2.0;
        assert_eq!(
            middle(material(false, 1.0, 0.0), &[], behind),
            [1, 2, 3, 255]
        );
        assert_eq!(middle(material(true, 1.0, 0.0), &[], behind), [255; 4]);
        let front = Vec3::Z * 2.0;
        assert_eq!(middle(material(true, 0.4, 0.5), &[], front), [1, 2, 3, 255]);
        assert_eq!(middle(material(true, 0.6, 0.5), &[], front), [255; 4]);
    }

    #[test]
    fn light_from_the_camera_is_the_same_from_both_sides() {
        let (mesh, skinned) = plates(&[0.0]);
        let both = Material {
            double_sided: true,
            ..Material::default()
        };
        let appearance = Appearance::new(&[both], &[]).0;
        let options = RenderOptions {
            light: Light {
                key: 0.5,
                ambient: 0.1,
                ..EVEN
            },
            ..RenderOptions::default()
        };
        let grey = srgb_byte(0.6);
        for z in [2.0, -2.0] {
            let picture =
                render(&mesh, &skinned, &appearance, &camera(Vec3::Z * z), &options).unwrap();
            assert_eq!(picture.get(31, 31), Some([grey, grey, grey, 255]));
        }
    }

    #[test]
    fn parallel_size_is_the_scale_and_parts_can_be_left_out() {
        let (mesh, skinned) = plates(&[0.0, -3.0]);
        let appearance = Appearance::new(&[Material::default()], &[]).0;
        let camera = camera(Vec3::Z * 2.0);
        let area = |parts, projection| {
            let options = RenderOptions {
                parts,
                projection,
                ..even()
            };
            let picture = render(&mesh, &skinned, &appearance, &camera, &options).unwrap();
            picture.pixels().iter().filter(|p| **p == [255; 4]).count()
        };
        let parallel = Projection::Parallel {
            pixels_per_metre: 20.0,
        };
        assert_eq!(area(PartSelection::Only(vec![0]), parallel), 400);
        assert_eq!(area(PartSelection::Except(vec![0]), parallel), 400);
        let near = area(PartSelection::Only(vec![0]), Projection::Perspective);
        let far = area(PartSelection::Only(vec![1]), Projection::Perspective);
        assert!(near > 5 * far && far > 0, "{near} and {far}");
        assert_eq!(area(PartSelection::All, Projection::Perspective), near);
        assert_eq!(area(PartSelection::Only(vec![]), parallel), 0);
    }

    #[test]
    fn the_floor_hides_what_is_below_and_darkens_where_it_is_touched() {
        let (mesh, mut skinned) = plates(&[0.0]);
        // It leans towards the camera, so that its shadow lies in front of it.
        for p in &mut skinned.positions {
            p.z = p.y;
        }
        let both = Material {
            double_sided: true,
            ..Material::default()
        };
        let appearance = Appearance::new(&[both], &[]).0;
        let camera = camera(Vec3::new(0.0, 1.2, 2.2));
        let at = |height_m: f32, place: Vec3| {
            let ground = Ground {
                height_m,
                ..Ground::default()
            };
            let options = RenderOptions {
                background: [200, 200, 200, 255],
                ground: Some(ground),
                ..even()
            };
            let picture = render(&mesh, &skinned, &appearance, &camera, &options).unwrap();
            let (pixel, _) = camera.project(place);
            picture.get(pixel.x as u32, pixel.y as u32).unwrap()[0]
        };
        let foot = Vec3::new(0.2, -0.5, -0.4);
        assert!(
            u32::from(at(-0.5, foot)) + 20 < at(-0.9, foot).into(),
            "a shadow where it stands"
        );
        let shin = Vec3::new(0.2, -0.3, -0.3);
        assert_eq!(at(-0.5, shin), 255);
        assert!(at(0.0, shin) < 230, "sunk below the floor");
    }

    #[test]
    fn more_samples_change_only_edges_and_wrong_sizes_are_refused() {
        let (mesh, skinned) = plates(&[0.0]);
        let appearance = Appearance::default();
        let camera = camera(Vec3::new(0.7, 0.4, 2.0));
        let with = |samples| {
            let options = RenderOptions { samples, ..even() };
            render(&mesh, &skinned, &appearance, &camera, &options).unwrap()
        };
        let (coarse, fine) = (with(Supersampling::Two), with(Supersampling::Eight));
        // The plate's outline is about 100 pixels long.
        let pairs = coarse.pixels().iter().zip(fine.pixels());
        let changed = pairs.filter(|(a, b)| a != b).count();
        assert!((1..200).contains(&changed), "{changed}");
        assert_eq!(coarse.get(31, 31), fine.get(31, 31));
        let other = SkinnedMesh::default();
        assert!(matches!(
            render(&mesh, &other, &appearance, &camera, &even()),
            Err(PictureError::Mismatch { .. })
        ));
    }
}
