//! Vertex colours that approximate a texture when interpolated linearly.
//!
//! Source: least squares of a piecewise linear surface over samples of the texture, solved by
//! projected Gauss-Seidel (Cottle, Pang and Stone 1992, 5.4). A single sample at each vertex misses
//! whatever lies between; it is kept as a weak regularisation for vertices that few samples reach.
//! A colour never leaves the range of the samples around its vertex, so hard edges do not ring.

use super::subject::PlanarSubject;
use crate::appearance::{Emission, WrappedTexture};
use crate::picture::srgb_byte;
use articula_core::source::Material;
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};
use std::collections::BTreeMap;

/// Subdivisions of each side of a triangle; each of the resulting equal triangles is one sample.
const PARTS: usize = 6;
/// Weight of the sample at a vertex, relative to those in its triangles.
const PULL: f32 = 0.02;
/// Rounds of the solver; each reduces the distance to the solution to less than a third.
const ROUNDS: usize = 24;

/// Material, textures and emission of a triangle's surface.
pub(super) struct SurfaceColor<'a> {
    pub(super) material: &'a Material,
    pub(super) texture: Option<WrappedTexture<'a>>,
    pub(super) emission: Emission<'a>,
}

impl<'a> SurfaceColor<'a> {
    /// As [`Appearance::detail_of`](crate::Appearance::detail_of).
    pub(super) fn detail(&self) -> Option<WrappedTexture<'a>> {
        self.texture.or(self.emission.texture)
    }

    /// sRGB levels and opacity at a texture coordinate, without light: base colour and emission, of
    /// which the share that is not lit is [`Appearance::own_light`](crate::Appearance::own_light).
    pub(super) fn color(&self, vertex_color: Vec4, at: Vec2, level: usize) -> (Vec3, f32) {
        let mut color = self.material.base_color * vertex_color;
        if let Some(texture) = self.texture {
            color *= texture.sample(at, level);
        }
        let color = color + self.emission.at(at, level).extend(0.0);
        let levels = color.xyz().to_array().map(|c| f32::from(srgb_byte(c)));
        (Vec3::from(levels), color.w)
    }

    /// Colour sampled at a vertex.
    pub(super) fn at_vertex(&self, subject: &PlanarSubject<'_>, vertex: u32) -> Vec3 {
        let v = vertex as usize;
        let mesh = subject.mesh;
        self.color(mesh.colors[v], mesh.texcoords[v], 0).0
    }
}

/// sRGB levels of the vertices that triangles use; `appearance` returns the surface of a triangle.
///
/// O(triangles).
pub(super) fn fitted<'a>(
    subject: &PlanarSubject<'_>,
    appearance: impl Fn(&[u32; 3]) -> SurfaceColor<'a>,
) -> BTreeMap<u32, [f32; 3]> {
    let mut fit = Fit::new(subject);
    for triangle in subject.triangles {
        fit.add(subject, triangle, &appearance(triangle));
    }
    fit.solve();
    let color = |(vertex, unknown): (&u32, &usize)| {
        let found = fit.unknowns[*unknown].color;
        (*vertex, found.to_array())
    };
    fit.of_vertex.iter().map(color).collect()
}

/// An unknown vertex colour.
#[derive(Debug, Clone)]
struct Unknown {
    color: Vec3,
    low: Vec3,
    high: Vec3,
    /// Row of the normal equations: diagonal, right-hand side, other unknowns.
    diagonal: f32,
    wanted: Vec3,
    others: BTreeMap<usize, f32>,
}

/// The normal equations.
struct Fit {
    unknowns: Vec<Unknown>,
    of_vertex: BTreeMap<u32, usize>,
    /// Unknowns by part, position and texture coordinate: vertices that differ only in their
    /// normals share a colour.
    known: BTreeMap<[u32; 6], usize>,
    part_of: Vec<u32>,
}

impl Fit {
    fn new(subject: &PlanarSubject<'_>) -> Self {
        let mut part_of = vec![0; subject.mesh.len()];
        for (p, part) in (0..).zip(&subject.mesh.parts) {
            part_of[part.vertices.clone()].fill(p);
        }
        Self {
            unknowns: Vec::new(),
            of_vertex: BTreeMap::new(),
            known: BTreeMap::new(),
            part_of,
        }
    }

    fn unknown(
        &mut self,
        subject: &PlanarSubject<'_>,
        vertex: u32,
        appearance: &SurfaceColor<'_>,
    ) -> usize {
        if let Some(unknown) = self.of_vertex.get(&vertex) {
            return *unknown;
        }
        let v = vertex as usize;
        let (place, at) = (subject.mesh.positions[v], subject.mesh.texcoords[v]);
        let [x, y, z] = place.to_array().map(f32::to_bits);
        let key = [self.part_of[v], x, y, z, at.x.to_bits(), at.y.to_bits()];
        let unknown = *self.known.entry(key).or_insert_with(|| {
            let color = appearance.at_vertex(subject, vertex);
            self.unknowns.push(Unknown {
                color,
                low: color,
                high: color,
                diagonal: 1e-9,
                wanted: color * 1e-9,
                others: BTreeMap::new(),
            });
            self.unknowns.len() - 1
        });
        self.of_vertex.insert(vertex, unknown);
        unknown
    }

    fn add(
        &mut self,
        subject: &PlanarSubject<'_>,
        triangle: &[u32; 3],
        appearance: &SurfaceColor<'_>,
    ) {
        let mesh = subject.mesh;
        let unknowns = triangle.map(|v| self.unknown(subject, v, appearance));
        let Some(texture) = appearance.detail() else {
            return;
        };
        let places = triangle.map(|v| mesh.positions[v as usize]);
        let size = (places[1] - places[0])
            .cross(places[2] - places[0])
            .length();
        for unknown in unknowns {
            let pull = size * PULL / 3.0;
            let unknown = &mut self.unknowns[unknown];
            unknown.diagonal += pull;
            // The colour is still the one sampled at the vertex.
            unknown.wanted += unknown.color * pull;
        }
        let at = triangle.map(|v| mesh.texcoords[v as usize]);
        let area = (at[1] - at[0]).perp_dot(at[2] - at[0]) / 2.0;
        let level = texture.level_for(area, (PARTS * PARTS) as f32);
        let colors = triangle.map(|v| mesh.colors[v as usize]);
        let weight = size / (PARTS * PARTS) as f32;
        for shares in samples() {
            let blend = |i: usize| shares[i];
            let place = at[0] * blend(0) + at[1] * blend(1) + at[2] * blend(2);
            let vertex_color = colors[0] * blend(0) + colors[1] * blend(1) + colors[2] * blend(2);
            let (wanted, opacity) = appearance.color(vertex_color, place, level);
            if opacity >= appearance.material.alpha_cutoff {
                self.wish(unknowns, shares, wanted, weight);
            }
        }
    }

    /// Adds one sample: the weighted sum of three colours should equal `wanted`.
    fn wish(&mut self, unknowns: [usize; 3], shares: [f32; 3], wanted: Vec3, weight: f32) {
        for i in 0..3 {
            let row = &mut self.unknowns[unknowns[i]];
            row.low = row.low.min(wanted);
            row.high = row.high.max(wanted);
            row.wanted += wanted * (weight * shares[i]);
            for j in 0..3 {
                let both = weight * shares[i] * shares[j];
                if unknowns[i] == unknowns[j] {
                    row.diagonal += both;
                } else {
                    *row.others.entry(unknowns[j]).or_insert(0.0) += both;
                }
            }
        }
    }

    fn solve(&mut self) {
        for _ in 0..ROUNDS {
            for i in 0..self.unknowns.len() {
                let row = &self.unknowns[i];
                let others = row.others.iter();
                let taken: Vec3 = others.map(|(j, a)| self.unknowns[*j].color * *a).sum();
                let best = (row.wanted - taken) / row.diagonal;
                let color = best.clamp(row.low, row.high);
                self.unknowns[i].color = color;
            }
        }
    }
}

/// Barycentric weights of the centroids of the equal triangles that a triangle is divided into.
fn samples() -> impl Iterator<Item = [f32; 3]> {
    let cell = |row: usize, column: usize, third: f32| {
        let (u, v) = (row as f32 + third, column as f32 + third);
        let (u, v) = (u / PARTS as f32, v / PARTS as f32);
        [1.0 - u - v, u, v]
    };
    (0..PARTS).flat_map(move |row| {
        let upright = (0..PARTS - row).map(move |column| cell(row, column, 1.0 / 3.0));
        let inverted = (0..PARTS - row - 1).map(move |column| cell(row, column, 2.0 / 3.0));
        upright.chain(inverted)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::Appearance;
    use crate::picture::Picture;
    use crate::planar::fixture::figure;
    use articula_core::source::Image;

    /// Red of 0 in the left half and of 200 in the right.
    fn half_black(width: u32) -> Appearance {
        let level = |x: u32| if x < width / 2 { 0 } else { 200 };
        let pixels = (0..width * width).map(|i| [level(i % width), 50, 50, 255]);
        let picture = Picture::from_pixels(width, width, pixels.collect()).unwrap();
        let image = Image {
            bytes: picture.to_png().unwrap(),
            ..Image::default()
        };
        let material = Material {
            base_color_image: Some(0),
            ..Material::default()
        };
        Appearance::new(&[material], &[image]).0
    }

    #[test]
    fn samples_are_equal_parts_of_a_triangle() {
        let all: Vec<[f32; 3]> = samples().collect();
        assert_eq!(all.len(), PARTS * PARTS);
        for k in 0..3 {
            let mean = all.iter().map(|s| s[k]).sum::<f32>() / all.len() as f32;
            assert!((mean - 1.0 / 3.0).abs() < 1e-5);
        }
        let sound =
            |s: &[f32; 3]| s.iter().all(|w| *w > 0.0) && (s.iter().sum::<f32>() - 1.0).abs() < 1e-5;
        assert!(all.iter().all(sound));
    }

    /// Sum of squared errors over the samples of the subject's triangles.
    fn error(
        subject: &PlanarSubject<'_>,
        appearance: &SurfaceColor<'_>,
        color: impl Fn(u32) -> Vec3,
    ) -> f32 {
        let mut sum = 0.0;
        for t in subject.triangles {
            for s in samples() {
                let at = |i: usize| subject.mesh.texcoords[t[i] as usize] * s[i];
                let (wanted, _) = appearance.color(Vec4::ONE, at(0) + at(1) + at(2), 0);
                let shown = (0..3).map(|i| color(t[i]) * s[i]).sum::<Vec3>();
                sum += shown.distance_squared(wanted);
            }
        }
        sum
    }

    #[test]
    fn fitted_colours_are_nearer_to_the_texture_than_single_samples() {
        let mut figure = figure();
        let mesh = std::sync::Arc::make_mut(&mut figure.asset.mesh);
        mesh.colors.fill(Vec4::ONE);
        for (at, place) in mesh.texcoords.iter_mut().zip(&mesh.positions) {
            *at = Vec2::new(place.x, place.y) * 3.0;
        }
        let look = half_black(16);
        let material = &look.materials[0];
        let subject = figure.subject();
        let appearance = || SurfaceColor {
            material,
            texture: look.texture_of(material),
            emission: look.emission_of(material),
        };
        let found = fitted(&subject, |_| appearance());
        let fit = error(&subject, &appearance(), |v| Vec3::from(found[&v]));
        let single = error(&subject, &appearance(), |v| {
            appearance().at_vertex(&subject, v)
        });
        assert!(fit < 0.95 * single, "{fit} {single}");
        // Nothing is darker or lighter than the texture.
        let levels = found.values().map(|c| c[0]);
        assert!(levels.clone().all(|level| (0.0..=200.0).contains(&level)));
        assert!(found.values().all(|c| c[1] == 50.0));
        // A black surface that gives off the same picture has the same colours.
        let glowing = Material {
            base_color: Vec4::W,
            base_color_image: None,
            emissive: material.base_color.xyz(),
            emissive_image: material.base_color_image,
            emissive_wrap: material.base_color_wrap,
            ..material.clone()
        };
        let given_off = fitted(&subject, |_| SurfaceColor {
            material: &glowing,
            texture: look.texture_of(&glowing),
            emission: look.emission_of(&glowing),
        });
        assert_eq!(given_off, found);
    }

    #[test]
    fn without_a_texture_a_vertex_keeps_its_colour() {
        let figure = figure();
        let subject = figure.subject();
        let (look, material) = (Appearance::default(), Material::default());
        let appearance = || SurfaceColor {
            material: &material,
            texture: None,
            emission: look.emission_of(&material),
        };
        for (vertex, color) in fitted(&subject, |_| appearance()) {
            let expected = appearance().at_vertex(&subject, vertex);
            assert_eq!(expected.to_array(), color);
        }
    }
}
