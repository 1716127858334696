//! Draws a clip as the script draws it on a canvas: edge by edge, anti-aliased, with the picture as a
//! pattern and the light over it.
//!
//! Source: `player.js`, statement by statement; `docs/methods/vector.md` 8.3 and 9. tiny-skia stands for
//! the canvas, whose pixels are those of Skia in Chromium.

use super::clip::{PlayerClip, PlayerFrame};
use super::texture::STEPS_PER_PIXEL;
use crate::error::PictureError;
use crate::picture::{Picture, Rgba};
use crate::planar::shading::Shading;
use glam::{Mat2, Vec2};
use resvg::tiny_skia::{
    BlendMode, Color, FillRule, FilterQuality, GradientStop, LinearGradient, Paint, Path,
    PathBuilder, Pattern, Pixmap, PixmapPaint, Point, PremultipliedColorU8, Rect, Shader,
    SpreadMode, Transform,
};
use std::collections::BTreeMap;

/// Distance by which edges move under neighbours that are painted later, pixels.
const UNDERLAP_PX: f32 = 0.8;
/// Strengths of light in which there are pictures.
const LIGHTS: f32 = 16.0;

/// The picture that the script shows at a time in frames, over a background.
///
/// # Errors
/// [`PictureError::LimitExceeded`] if the clip's picture is too large.
pub(crate) fn on_canvas(
    clip: &PlayerClip,
    frame: f64,
    background: Rgba,
) -> Result<Picture, PictureError> {
    let refuse = || PictureError::LimitExceeded {
        width: clip.width,
        height: clip.height,
        samples: 1,
        limit: "a picture that fits into memory",
    };
    let new = || Pixmap::new(clip.width, clip.height).ok_or_else(refuse);
    let (mut canvas, mut page) = (new()?, new()?);
    let texture = clip.texture.as_ref().map(|t| pixmap(&t.picture));
    let mut texture = texture.transpose()?.map(LitPictures::new);
    let moment = clip.moment(frame);
    let neighbours = neighbours(clip);
    let mut is_to_come: Vec<bool> = (0..clip.triangles.len())
        .map(|t| clip.is_shown_at(t, frame))
        .collect();
    for t in clip.order_at(frame).iter().map(|t| *t as usize) {
        if std::mem::replace(&mut is_to_come[t], false) {
            let moves = [0, 1, 2].map(|i| neighbours[3 * t + i].iter().any(|n| is_to_come[*n]));
            Fill::new(clip, &moment, t).draw(moves, texture.as_mut(), &mut canvas);
        }
    }
    let [r, g, b, a] = background;
    page.fill(Color::from_rgba8(r, g, b, a));
    let paint = PixmapPaint::default();
    page.draw_pixmap(0, 0, canvas.as_ref(), &paint, Transform::identity(), None);
    let straight = |p: &PremultipliedColorU8| {
        let c = p.demultiply();
        [c.red(), c.green(), c.blue(), c.alpha()]
    };
    let pixels = page.pixels().iter().map(straight).collect();
    Picture::from_pixels(clip.width, clip.height, pixels)
}

/// A picture in sixteenths of full light, those that were asked for.
struct LitPictures {
    picture: Pixmap,
    lit: BTreeMap<u8, Pixmap>,
}

impl LitPictures {
    fn new(picture: Pixmap) -> Self {
        let lit = BTreeMap::new();
        Self { picture, lit }
    }

    fn at(&mut self, sixteenths: u8) -> &Pixmap {
        self.lit.entry(sixteenths).or_insert_with(|| {
            let mut lit = self.picture.clone();
            let paint = Paint {
                shader: Shader::SolidColor(shadow(f32::from(sixteenths) / LIGHTS)),
                blend_mode: BlendMode::SourceAtop,
                ..Paint::default()
            };
            let all = Rect::from_xywh(0.0, 0.0, lit.width() as f32, lit.height() as f32);
            if let Some(all) = all {
                lit.fill_rect(all, &paint, Transform::identity(), None);
            }
            lit
        })
    }
}

/// Black that leaves this much of the light.
fn shadow(light: f32) -> Color {
    rgba([0.0, 0.0, 0.0, 255.0 * (1.0 - light)])
}

/// A picture as tiny-skia has it.
fn pixmap(picture: &Picture) -> Result<Pixmap, PictureError> {
    let (width, height) = (picture.width(), picture.height());
    let mut to = Pixmap::new(width, height).ok_or(PictureError::LimitExceeded {
        width,
        height,
        samples: 1,
        limit: "a picture that fits into memory",
    })?;
    for (to, [r, g, b, a]) in to.pixels_mut().iter_mut().zip(picture.pixels()) {
        *to = resvg::tiny_skia::ColorU8::from_rgba(*r, *g, *b, *a).premultiply();
    }
    Ok(to)
}

/// Triangles on the other side of each edge, three edges for each triangle.
fn neighbours(clip: &PlayerClip) -> Vec<Vec<usize>> {
    let point = |wedge: u32| clip.wedge_points[wedge as usize];
    let edges = || {
        let of = |[a, b, c]: &[u32; 3]| [(*a, *b), (*b, *c), (*c, *a)];
        clip.triangles.iter().flat_map(of)
    };
    let mut along: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
    for (k, (from, to)) in edges().enumerate() {
        along
            .entry((point(from), point(to)))
            .or_default()
            .push(k / 3);
    }
    let across = |(from, to): (u32, u32)| along.get(&(point(to), point(from)));
    edges()
        .map(|edge| across(edge).cloned().unwrap_or_default())
        .collect()
}

/// A triangle on the screen.
struct Fill {
    corners: [Vec2; 3],
    /// Outward normals of the edges, as long as these.
    normals: [Vec2; 3],
    /// Twice the area.
    area: f32,
    /// Colours of the corners; with a picture, the opacity of the shadow as the last channel.
    colors: [[f32; 4]; 3],
    /// Corners in the picture, pixels, and the light in which it is, in sixteenths.
    places: Option<([Vec2; 3], u8)>,
}

impl Fill {
    fn new(clip: &PlayerClip, moment: &PlayerFrame, t: usize) -> Self {
        let wedges = clip.triangles[t].map(|w| w as usize);
        let corners = wedges.map(|w| moment.xy[w]);
        let normals = [0, 1, 2].map(|i| {
            let along = corners[(i + 1) % 3] - corners[i];
            Vec2::new(-along.y, along.x)
        });
        let area = normals[0].perp_dot(normals[1]);
        let texture = clip.texture.as_ref().filter(|texture| texture.shows[t]);
        let most = wedges.iter().map(|w| moment.light[*w]).fold(0.0, f32::max);
        let sixteenths = (LIGHTS * most - 0.1).ceil().clamp(1.0, LIGHTS);
        let color = |k: usize| {
            let light = moment.light[wedges[k]];
            match (&texture, clip.shading) {
                (Some(_), _) => [0.0, 0.0, 0.0, 255.0 * (1.0 - light * LIGHTS / sixteenths)],
                (None, Shading::Gouraud) => lit(clip.colors[wedges[k]], light),
                (None, Shading::Flat) => lit(clip.colors[t], 1.0),
            }
        };
        let place = |w: usize| texture.map(|texture| texture.places[w].map(|at| at as f32));
        let places = wedges.map(place);
        Self {
            corners,
            normals,
            area: if area == 0.0 { 1.0 } else { area },
            colors: [0, 1, 2].map(color),
            places: match places {
                [Some(a), Some(b), Some(c)] => {
                    let places = [a, b, c].map(|at| Vec2::from_array(at) / STEPS_PER_PIXEL);
                    Some((places, sixteenths as u8))
                }
                _ => None,
            },
        }
    }

    /// Fills the triangle, whose edges move outward where `moves` says so.
    fn draw(&self, moves: [bool; 3], texture: Option<&mut LitPictures>, canvas: &mut Pixmap) {
        let Some(path) = self.outline(moves) else {
            return;
        };
        let mut fill = |shader: Shader<'_>, blend_mode| {
            let paint = Paint {
                shader,
                blend_mode,
                ..Paint::default()
            };
            canvas.fill_path(
                &path,
                &paint,
                FillRule::Winding,
                Transform::identity(),
                None,
            );
        };
        match self.places.zip(texture) {
            Some(((places, sixteenths), texture)) => {
                let (spread, quality) = (SpreadMode::Repeat, FilterQuality::Bilinear);
                let map = self.map_from(places);
                fill(
                    Pattern::new(texture.at(sixteenths).as_ref(), spread, quality, 1.0, map),
                    BlendMode::SourceOver,
                );
                fill(self.gradient(), BlendMode::SourceAtop);
            }
            None => fill(self.gradient(), BlendMode::SourceOver),
        }
    }

    /// The triangle with a strip along each edge that moves, without corners between strips: they
    /// would stick out as thorns where triangles are thin.
    fn outline(&self, moves: [bool; 3]) -> Option<Path> {
        let mut path = PathBuilder::new();
        for (i, moves) in moves.into_iter().enumerate() {
            let normal = self.normals[i];
            let off = match moves && normal != Vec2::ZERO {
                true => normal * (UNDERLAP_PX / normal.length()),
                false => Vec2::ZERO,
            };
            for to in [i, (i + 1) % 3].map(|k| self.corners[k] + off) {
                match path.is_empty() {
                    true => path.move_to(to.x, to.y),
                    false => path.line_to(to.x, to.y),
                }
            }
        }
        path.close();
        path.finish()
    }

    /// The affine map from the picture to the screen.
    fn map_from(&self, [a, b, c]: [Vec2; 3]) -> Transform {
        let from = Mat2::from_cols(b - a, c - a);
        let [p, q, r] = self.corners;
        let to = Mat2::from_cols(q - p, r - p);
        let map = match from.determinant() {
            0.0 => to,
            _ => to * from.inverse(),
        };
        let shift = p - map * a;
        Transform::from_row(
            map.x_axis.x,
            map.x_axis.y,
            map.y_axis.x,
            map.y_axis.y,
            shift.x,
            shift.y,
        )
    }

    /// The gradient between the two corners whose colours are farthest apart.
    fn gradient(&self) -> Shader<'static> {
        let apart = [0, 1, 2].map(|i| {
            let (a, b) = (self.colors[(i + 1) % 3], self.colors[(i + 2) % 3]);
            a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f32>()
        });
        let k = (1..3).fold(0, |k, i| if apart[i] > apart[k] { i } else { k });
        let (i, b) = ((k + 1) % 3, (k + 2) % 3);
        if apart[k] < 2.0 {
            return Shader::SolidColor(rgba(self.colors[k]));
        }
        let share = (apart[b] + apart[k] - apart[i]) / 2.0 / apart[k];
        let across = self.normals[k] + share * self.normals[i];
        let from = self.corners[i];
        let square = across.length_squared();
        let to = from + across * (self.area / if square > 0.0 { square } else { 1.0 });
        let stops = vec![
            GradientStop::new(0.0, rgba(self.colors[i])),
            GradientStop::new(1.0, rgba(self.colors[b])),
        ];
        let [from, to] = [from, to].map(|at| Point::from_xy(at.x, at.y));
        let gradient = LinearGradient::new(from, to, stops, SpreadMode::Pad, Transform::identity());
        // Corners too near for a gradient.
        gradient.unwrap_or(Shader::SolidColor(rgba(self.colors[k])))
    }
}

fn lit(color: [u8; 3], light: f32) -> [f32; 4] {
    let [r, g, b] = color.map(|level| f32::from(level) * light);
    [r, g, b, 255.0]
}

fn rgba(levels: [f32; 4]) -> Color {
    let [r, g, b, a] = levels.map(|level| (level / 255.0).clamp(0.0, 1.0));
    Color::from_rgba(r, g, b, a).unwrap_or(Color::BLACK)
}
