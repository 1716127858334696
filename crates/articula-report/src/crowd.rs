//! Renders a crowd at one time, in its own colours and with a colour for each character's level.

use crate::paint::{TextStyle, draw_box, draw_text};
use crate::thin::thinned;
use articula::core::source::{Character, Image, Material};
use articula::core::{Camera, Mesh, Part, SkinnedMesh, skin};
use articula::flat::{
    Appearance, Ground, Picture, PictureError, RenderOptions, Rgba, linear_table, render,
};
use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};

/// Colours of the levels, from all joints to the fewest: dark blue through green to yellow and red, then
/// violet.
const COLORS: [Rgba; 9] = [
    [58, 76, 160, 255],
    [52, 120, 190, 255],
    [42, 160, 170, 255],
    [70, 175, 110, 255],
    [150, 190, 70, 255],
    [225, 190, 60, 255],
    [235, 140, 60, 255],
    [215, 85, 75, 255],
    [150, 70, 150, 255],
];

/// Material of walls, before those of the levels or of the characters, and its colour.
const WALL: usize = 0;
const WALL_COLOR: Rgba = [150, 150, 150, 255];

/// What a part of the picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Shown {
    /// Level of its character; none of a wall.
    level: Option<usize>,
    /// Material among those of all characters.
    material: Option<usize>,
}

/// The skins of a crowd's characters and the walls around them as one mesh in world space.
#[derive(Debug, Clone)]
pub(crate) struct CrowdPicture {
    mesh: Mesh,
    skinned: SkinnedMesh,
    /// Of each part of the mesh.
    shown: Vec<Shown>,
}

/// The materials of all characters of a crowd, with their textures.
#[derive(Debug, Clone)]
pub(crate) struct CrowdLook {
    look: Appearance,
    /// First material of each character.
    first: Vec<usize>,
}

impl CrowdLook {
    pub(crate) fn new(characters: &[&Character]) -> Self {
        let mut materials = vec![plain(WALL_COLOR)];
        let mut images: Vec<Image> = Vec::new();
        let mut first = Vec::with_capacity(characters.len());
        for character in characters {
            first.push(materials.len());
            let moved = |image: Option<usize>| image.map(|i| i + images.len());
            materials.extend(character.materials.iter().map(|material| Material {
                base_color_image: moved(material.base_color_image),
                emissive_image: moved(material.emissive_image),
                ..material.clone()
            }));
            images.extend_from_slice(&character.images);
        }
        let (look, _) = Appearance::new(&materials, &images);
        Self { look, first }
    }
}

/// How a [`CrowdPicture`] is coloured.
#[derive(Debug, Clone, Copy)]
pub(crate) enum CrowdColors<'a> {
    /// Each character has its own.
    Own(&'a CrowdLook),
    /// Each character has that of its level, which the lines of a legend explain.
    Levels(&'a [(usize, String)]),
}

impl Default for CrowdPicture {
    fn default() -> Self {
        Self {
            mesh: Mesh {
                influences: 1,
                ..Mesh::default()
            },
            skinned: SkinnedMesh::default(),
            shown: Vec::new(),
        }
    }
}

impl CrowdPicture {
    /// Adds a figure of a character: its mesh, its level, its palette, and its position in the world.
    /// Vertices within a cell of a grid count as one; a cell of 0 keeps all. Returns the number of
    /// triangles.
    ///
    /// # Panics
    /// If the palette does not belong to the mesh.
    pub(crate) fn add(
        &mut self,
        (own, character): (&Mesh, usize),
        level: usize,
        (matrices, world): (&[Affine3A], &Affine3A),
        (look, cell_m): (&CrowdLook, f32),
    ) -> usize {
        let mut skinned = SkinnedMesh::new(own);
        skin(own, matrices, &own.morph_weights, &mut skinned);
        let place = |p: &Vec3| world.transform_point3(*p);
        let places: Vec<Vec3> = skinned.positions.iter().map(place).collect();
        let before = self.mesh.triangles.len();
        for part in &own.parts {
            let triangles = &own.triangles[part.triangles.clone()];
            let (kept, triangles) = thinned(&places, triangles, cell_m);
            let (mesh, all) = (&mut self.mesh, &mut self.skinned);
            let (first, triangle) = (all.positions.len(), mesh.triangles.len());
            let kept = || kept.iter().map(|v| *v as usize);
            let turn = |v: usize| world.transform_vector3(skinned.normals[v]);
            all.positions.extend(kept().map(|v| places[v]));
            all.normals.extend(kept().map(turn));
            mesh.positions.extend(kept().map(|v| own.positions[v]));
            mesh.normals.extend(kept().map(|v| own.normals[v]));
            mesh.texcoords.extend(kept().map(|v| own.texcoords[v]));
            mesh.colors.extend(kept().map(|v| own.colors[v]));
            let moved = |t: &[u32; 3]| t.map(|v| v + first as u32);
            mesh.triangles.extend(triangles.iter().map(moved));
            let shown = Shown {
                level: Some(level),
                material: part.material.map(|m| look.first[character] + m),
            };
            self.close(shown, first, triangle);
        }
        self.mesh.triangles.len() - before
    }

    /// Adds a figure that is smaller than a pixel: an upright sliver from the foot of a bound to its top,
    /// `across` the picture.
    pub(crate) fn add_far(&mut self, level: usize, centre: Vec3, radius: f32, across: Vec3) {
        let (mesh, all) = (&mut self.mesh, &mut self.skinned);
        let (vertices, triangles) = (all.positions.len(), mesh.triangles.len());
        let (side, up) = (across * (0.2 * radius), Vec3::Y * radius);
        let corners = [centre - side - up, centre + side - up, centre + up];
        let towards = across.cross(Vec3::Y);
        all.positions.extend_from_slice(&corners);
        all.normals.extend_from_slice(&[towards; 3]);
        mesh.triangles
            .push([0, 1, 2].map(|v| (vertices + v) as u32));
        let shown = Shown {
            level: Some(level),
            material: Some(WALL),
        };
        self.close(shown, vertices, triangles);
    }

    /// Adds a wall: a box in world space, with its centre, half of its size, and its rotation about +Y.
    pub(crate) fn add_wall(&mut self, centre: Vec3, half_size: Vec3, yaw_radians: f32) {
        let (mesh, all) = (&mut self.mesh, &mut self.skinned);
        let (vertices, triangles) = (all.positions.len(), mesh.triangles.len());
        let turn = Quat::from_rotation_y(yaw_radians);
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
            let mut normal = Vec3::ZERO;
            normal[axis] = sign;
            let first = all.positions.len() as u32;
            let (across, up) = ((axis + 1) % 3, (axis + 2) % 3);
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut corner = normal;
                corner[across] = x * sign;
                corner[up] = y;
                all.positions.push(centre + turn * (corner * half_size));
                all.normals.push(turn * normal);
            }
            for corners in [[0, 1, 2], [0, 2, 3]] {
                mesh.triangles.push(corners.map(|c| first + c));
            }
        }
        let shown = Shown {
            level: None,
            material: Some(WALL),
        };
        self.close(shown, vertices, triangles);
    }

    /// Makes the vertices and triangles from these on a part. What is only posed rests where it stands.
    fn close(&mut self, shown: Shown, vertices: usize, triangles: usize) {
        self.shown.push(shown);
        let (mesh, all) = (&mut self.mesh, &self.skinned);
        let count = all.positions.len();
        let at_rest = mesh.positions.len();
        mesh.positions.extend_from_slice(&all.positions[at_rest..]);
        mesh.normals.extend_from_slice(&all.normals[at_rest..]);
        mesh.texcoords.resize(count, Vec2::ZERO);
        mesh.colors.resize(count, Vec4::ONE);
        mesh.parts.push(Part {
            name: String::new(),
            mesh: 0,
            material: shown.material,
            draw_material: shown.material,
            vertices: vertices..count,
            triangles: triangles..mesh.triangles.len(),
        });
    }

    /// Renders the characters over a ground of height 0, in the size of the camera's viewport.
    ///
    /// # Errors
    /// [`PictureError::LimitExceeded`] if the viewport is too large.
    pub(crate) fn draw(
        &mut self,
        camera: &Camera,
        colors: CrowdColors<'_>,
    ) -> Result<Picture, PictureError> {
        let middle = camera.eye + camera.forward() * 30.0;
        let options = RenderOptions {
            ground: Some(Ground {
                height_m: 0.0,
                middle: Vec2::new(middle.x, middle.z),
                radius_m: 80.0,
            }),
            ..RenderOptions::default()
        };
        match colors {
            CrowdColors::Own(own) => render(&self.mesh, &self.skinned, &own.look, camera, &options),
            CrowdColors::Levels(legend) => {
                let material = |shown: &Shown| shown.level.map_or(WALL, |level| level + 1);
                let each = self.shown.iter().map(material);
                let last = each.clone().max().unwrap_or(WALL);
                for (part, material) in self.mesh.parts.iter_mut().zip(each) {
                    part.material = Some(material);
                }
                let painted = std::mem::take(&mut self.mesh.colors);
                self.mesh.colors = vec![Vec4::ONE; painted.len()];
                let (look, _) = Appearance::new(&materials(last + 1), &[]);
                let drawn = render(&self.mesh, &self.skinned, &look, camera, &options);
                self.mesh.colors = painted;
                for (part, shown) in self.mesh.parts.iter_mut().zip(&self.shown) {
                    part.material = shown.material;
                }
                let mut picture = drawn?;
                if !legend.is_empty() {
                    write_legend(&mut picture, legend);
                }
                Ok(picture)
            }
        }
    }
}

fn color(level: usize) -> Rgba {
    COLORS[level.min(COLORS.len() - 1)]
}

/// A material of one colour.
fn plain(color: Rgba) -> Material {
    let table = linear_table();
    Material {
        base_color: Vec4::from([0, 1, 2, 3].map(|i| table[usize::from(color[i])])),
        ..Material::default()
    }
}

/// The materials of walls and levels.
fn materials(count: usize) -> Vec<Material> {
    let of = |material: usize| plain(material.checked_sub(1).map_or(WALL_COLOR, color));
    (0..count).map(of).collect()
}

fn write_legend(picture: &mut Picture, lines: &[(usize, String)]) {
    let style = TextStyle::default();
    let line = style.height() as i32 + 6;
    let paper = [255, 255, 255, 255];
    let widths = lines.iter().map(|(_, text)| style.width(text));
    let width = widths.max().unwrap_or(0) + 40;
    let height = (lines.len() as i32 * line + 10).unsigned_abs();
    draw_box(picture, 4, 4, width, height, paper);
    let mut y = 8;
    for (level, text) in lines {
        draw_box(picture, 12, y + 3, 14, 14, color(*level));
        draw_text(picture, 34, y, text, style, [30, 34, 44, 255]);
        y += line;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula::core::Viewport;
    use articula::core::source::{self, Primitive, Skin};

    #[test]
    fn characters_have_their_own_colour_or_that_of_their_level_where_they_stand() {
        let mut crowd = CrowdPicture::default();
        let primitive = Primitive {
            positions: vec![
                Vec3::new(-0.5, 0.0, 0.0),
                Vec3::new(0.5, 0.0, 0.0),
                Vec3::new(0.0, 1.8, 0.0),
            ],
            normals: vec![Vec3::Z; 3],
            triangles: vec![[0, 1, 2]],
            influences: 1,
            joints: vec![0; 3],
            weights: vec![1.0; 3],
            ..Primitive::default()
        };
        let skin = Skin {
            joints: vec![0],
            inverse_bind: vec![Affine3A::IDENTITY],
        };
        let source = source::RawMesh {
            skin,
            primitives: vec![primitive],
            ..source::RawMesh::default()
        };
        let mut own = Mesh::new(&[source], 1).unwrap();
        own.parts[0].material = Some(0);
        let green = Character {
            materials: vec![plain([0, 200, 0, 255])],
            ..Character::default()
        };
        let look = CrowdLook::new(&[&green]);
        for (level, x) in [(0, -1.0), (7, 1.0)] {
            let world = Affine3A::from_translation(Vec3::X * x);
            let pose = (&[Affine3A::IDENTITY][..], &world);
            assert_eq!(crowd.add((&own, 0), level, pose, (&look, 0.0)), 1);
        }
        assert_eq!(crowd.mesh.parts.len(), 2);
        let viewport = Viewport {
            width_px: 240.0,
            height_px: 160.0,
            ..Viewport::default()
        };
        let camera = Camera::looking_at(Vec3::new(0.0, 1.0, 6.0), Vec3::Y, viewport);
        let at = |picture: &Picture| {
            [-1.0, 1.0].map(|x| {
                let (at, _) = camera.project(Vec3::new(x, 0.7, 0.0));
                picture.get(at.x as u32, at.y as u32).unwrap()
            })
        };
        let legend = [(7, "far".into())];
        let levels = CrowdColors::Levels(&legend);
        let picture = crowd.draw(&camera, levels).unwrap();
        let [near, far] = at(&picture);
        assert!(near[2] > near[0], "blue: {near:?}");
        assert!(far[0] > far[2], "red: {far:?}");
        assert_eq!(picture.get(15, 15), Some(color(7)), "the legend");
        // The own colours stay after those of the levels.
        let own = crowd.draw(&camera, CrowdColors::Own(&look)).unwrap();
        let is_green = |p: Rgba| p[1] > p[0] && p[1] > p[2];
        assert!(at(&own).into_iter().all(is_green), "{:?}", at(&own));
    }
}
