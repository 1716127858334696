//! Renders a crowd at one time, with a colour for each character's level.

use crate::paint::{TextStyle, draw_box, draw_text};
use articula::core::source::Material;
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

/// Material of walls, before those of the levels, and its colour.
const WALL: usize = 0;
const WALL_COLOR: Rgba = [150, 150, 150, 255];

/// The skins of a crowd's characters and the walls around them as one mesh in world space, coloured by
/// level.
#[derive(Debug, Clone)]
pub(crate) struct CrowdPicture {
    mesh: Mesh,
    skinned: SkinnedMesh,
}

impl Default for CrowdPicture {
    fn default() -> Self {
        Self {
            mesh: Mesh {
                influences: 1,
                ..Mesh::default()
            },
            skinned: SkinnedMesh::default(),
        }
    }
}

impl CrowdPicture {
    /// Adds a character: its mesh, its level, its palette, and its position in the world.
    ///
    /// # Panics
    /// If the palette does not belong to the mesh.
    pub(crate) fn add(
        &mut self,
        own: &Mesh,
        level: usize,
        matrices: &[Affine3A],
        world: &Affine3A,
    ) {
        let (mesh, all) = (&mut self.mesh, &mut self.skinned);
        let mut skinned = SkinnedMesh::new(own);
        skin(own, matrices, &own.morph_weights, &mut skinned);
        let (first, triangle) = (all.positions.len(), mesh.triangles.len());
        let place = |p: &Vec3| world.transform_point3(*p);
        let turn = |n: &Vec3| world.transform_vector3(*n);
        all.positions.extend(skinned.positions.iter().map(place));
        all.normals.extend(skinned.normals.iter().map(turn));
        mesh.positions.extend_from_slice(&own.positions);
        mesh.normals.extend_from_slice(&own.normals);
        mesh.texcoords.extend_from_slice(&own.texcoords);
        let moved = |t: &[u32; 3]| t.map(|v| v + first as u32);
        mesh.triangles.extend(own.triangles.iter().map(moved));
        self.close(level + 1, first, triangle);
    }

    /// Adds a character that is too far to tell its limbs: an upright sliver of its level's colour, from
    /// the foot of a bound to its top, `across` the picture.
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
        self.close(level + 1, vertices, triangles);
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
        self.close(WALL, vertices, triangles);
    }

    /// Makes the vertices and triangles from these on a part of a material. What is only posed rests where
    /// it stands.
    fn close(&mut self, material: usize, vertices: usize, triangles: usize) {
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
            material: Some(material),
            vertices: vertices..count,
            triangles: triangles..mesh.triangles.len(),
        });
    }

    /// Renders the characters over a ground of height 0, in the size of the camera's viewport. Each
    /// line of the legend is shown with the colour of its level, if it has one.
    ///
    /// # Errors
    /// [`PictureError::LimitExceeded`] if the viewport is too large.
    pub(crate) fn draw(
        &self,
        camera: &Camera,
        legend: &[(Option<usize>, String)],
    ) -> Result<Picture, PictureError> {
        let last = self.mesh.parts.iter().filter_map(|p| p.material).max();
        let (look, _) = Appearance::new(&materials(last.map_or(0, |m| m + 1)), &[]);
        let middle = camera.eye + camera.forward() * 30.0;
        let options = RenderOptions {
            ground: Some(Ground {
                height_m: 0.0,
                middle: Vec2::new(middle.x, middle.z),
                radius_m: 80.0,
            }),
            ..RenderOptions::default()
        };
        let mut picture = render(&self.mesh, &self.skinned, &look, camera, &options)?;
        if !legend.is_empty() {
            write_legend(&mut picture, legend);
        }
        Ok(picture)
    }
}

fn color(level: usize) -> Rgba {
    COLORS[level.min(COLORS.len() - 1)]
}

fn materials(count: usize) -> Vec<Material> {
    let table = linear_table();
    let linear = |c: Rgba| Vec4::from([0, 1, 2, 3].map(|i| table[usize::from(c[i])]));
    let of = |material: usize| Material {
        base_color: linear(material.checked_sub(1).map_or(WALL_COLOR, color)),
        ..Material::default()
    };
    (0..count).map(of).collect()
}

fn write_legend(picture: &mut Picture, lines: &[(Option<usize>, String)]) {
    let style = TextStyle::default();
    let line = style.height() as i32 + 6;
    let paper = [255, 255, 255, 255];
    let widths = lines.iter().map(|(_, text)| style.width(text));
    let width = widths.max().unwrap_or(0) + 40;
    let height = (lines.len() as i32 * line + 10).unsigned_abs();
    draw_box(picture, 4, 4, width, height, paper);
    let mut y = 8;
    for (level, text) in lines {
        if let Some(level) = level {
            draw_box(picture, 12, y + 3, 14, 14, color(*level));
        }
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
    fn characters_have_the_colour_of_their_level_and_lie_where_they_stand() {
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
        let own = Mesh::new(&[source], 1).unwrap();
        for (level, x) in [(0, -1.0), (7, 1.0)] {
            let world = Affine3A::from_translation(Vec3::X * x);
            crowd.add(&own, level, &[Affine3A::IDENTITY], &world);
        }
        assert_eq!(crowd.mesh.parts.len(), 2);
        let viewport = Viewport {
            width_px: 240.0,
            height_px: 160.0,
            ..Viewport::default()
        };
        let camera = Camera::looking_at(Vec3::new(0.0, 1.0, 6.0), Vec3::Y, viewport);
        let picture = crowd.draw(&camera, &[(Some(7), "far".into())]).unwrap();
        let at = |x: f32| {
            let (at, _) = camera.project(Vec3::new(x, 0.7, 0.0));
            picture.get(at.x as u32, at.y as u32).unwrap()
        };
        let (near, far) = (at(-1.0), at(1.0));
        assert!(near[2] > near[0], "blue: {near:?}");
        assert!(far[0] > far[2], "red: {far:?}");
        assert_eq!(picture.get(15, 15), Some(color(7)), "the legend");
    }
}
