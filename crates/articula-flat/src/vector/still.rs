//! Writes one frame of a clip as SVG: one colour or one gradient per triangle, or exact.
//!
//! Source: `docs/methods/vector.md` 6, thesis 4.2.4. A surface's ramp is written once; each
//! triangle's gradient references it and adds its line. Differs from the thesis: one triangle
//! replaces its three superposed triangles under filters; [`StillOptions::exact`] paints red, green
//! and blue separately and adds them by `screen`, since `plus-lighter` is not supported everywhere.

use super::path::{on_grid, push_color, push_id, push_numbers, push_outlines};
use crate::planar::PlanarClip;
use crate::planar::PlanarError;
use crate::planar::keyed_clip::GRID;
use crate::planar::shading::{Colors, Shading, flat_color};
use crate::planar::underlap::{Sealer, UnderlapOptions, ranks};
use glam::Vec2;
use std::collections::BTreeMap;

/// Options of a still.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct StillOptions {
    /// Shading of the triangles.
    pub shading: Shading,
    /// Whether red, green and blue are painted separately: exact inside, three times as long, and a
    /// little dark along the silhouette.
    pub exact: bool,
    /// Options of sealing edges.
    pub underlap: UnderlapOptions,
}

/// Writes a frame as SVG.
///
/// `order` holds the triangles that are drawn, back to front.
///
/// # Errors
/// [`PlanarError::Mismatch`] if the frame or a triangle does not exist.
pub(crate) fn still(
    clip: &PlanarClip,
    frame: usize,
    order: &[u32],
    options: &StillOptions,
) -> Result<String, PlanarError> {
    let mismatch = |at, what: String| Err(PlanarError::Mismatch { at, what });
    if frame >= clip.frames.len() {
        return mismatch(
            "frame",
            format!(
                "frame {frame} is out of range: the clip has {} frames",
                clip.frames.len()
            ),
        );
    }
    if let Some(t) = order.iter().find(|t| **t as usize >= clip.triangles.len()) {
        return mismatch(
            "order",
            format!(
                "triangle {t} is out of range: the clip has {} triangles",
                clip.triangles.len()
            ),
        );
    }
    let rank = ranks(clip, order);
    let sealer = Sealer::new(clip, options.underlap);
    let corners = sealer.frame(frame, |t| rank[t].is_some(), |t| rank[t as usize]);
    let mut svg = Svg::new(clip);
    if options.exact {
        exact(&mut svg, clip, frame, (order, &corners));
        return Ok(svg.finish());
    }
    for t in order {
        let t = *t as usize;
        let frames = std::iter::once(frame);
        let colors = match options.shading {
            Shading::Flat => Colors::Flat(flat_color(clip, t, frames)),
            Shading::Gouraud => Colors::of(clip, t, frames),
        };
        svg.triangle(colors, colors.line(clip, frame, t), &corners[t]);
    }
    Ok(svg.finish())
}

/// Writes red, green and blue in separate groups, the later two blended by `screen`.
fn exact(svg: &mut Svg, clip: &PlanarClip, frame: usize, (order, corners): (&[u32], &[[Vec2; 3]])) {
    svg.shapes.push_str("<g style=\"isolation:isolate\">");
    for channel in 0..3 {
        svg.shapes.push_str(match channel {
            0 => "<g>",
            _ => "<g style=\"mix-blend-mode:screen\">",
        });
        for t in order {
            let t = *t as usize;
            let colors = Colors::of_channel(clip, (frame, t), channel);
            svg.triangle(colors, colors.line(clip, frame, t), &corners[t]);
        }
        svg.shapes.push_str("</g>");
    }
    svg.shapes.push_str("</g>");
}

/// An SVG text under construction.
struct Svg {
    /// The opening tag and the gradients.
    head: String,
    shapes: String,
    /// Number of ids so far.
    ids: usize,
    /// Ids of the ramps; `None` is the ramp without colours, which only sets the units.
    ramps: BTreeMap<Option<[u8; 3]>, usize>,
}

impl Svg {
    fn new(clip: &PlanarClip) -> Self {
        let (width, height) = (clip.width, clip.height);
        let grid = GRID as u32;
        Self {
            head: format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
                 viewBox=\"0 0 {} {}\">",
                width * grid,
                height * grid
            ),
            shapes: String::new(),
            ids: 0,
            ramps: BTreeMap::new(),
        }
    }

    fn finish(self) -> String {
        self.head + &self.shapes + "</svg>\n"
    }

    fn triangle(&mut self, colors: Colors, line: [Vec2; 2], corners: &[Vec2; 3]) {
        let gradient = match colors {
            Colors::Flat(_) => None,
            Colors::Ramp(color) => Some(self.gradient(Some(color), line, "/>")),
            Colors::Own([from, to]) => {
                let mut stops = String::from("><stop stop-color=\"");
                push_color(&mut stops, from);
                stops.push_str("\"/><stop offset=\"1\" stop-color=\"");
                push_color(&mut stops, to);
                stops.push_str("\"/></linearGradient>");
                Some(self.gradient(None, line, &stops))
            }
        };
        let text = &mut self.shapes;
        text.push_str("<path fill=\"");
        match (gradient, colors) {
            (Some(id), _) => {
                text.push_str("url(#");
                push_id(text, id);
                text.push(')');
            }
            (None, Colors::Flat(color)) => push_color(text, color),
            (None, _) => {}
        }
        text.push_str("\" d=\"");
        push_outlines(text, corners.map(on_grid).as_flattened(), &[]);
        text.push_str("\"/>");
    }

    /// Writes a gradient that takes its units, and its stops if it has none, from a ramp.
    fn gradient(&mut self, ramp: Option<[u8; 3]>, line: [Vec2; 2], stops: &str) -> usize {
        let ramp = self.ramp(ramp);
        let id = self.next_id();
        let text = &mut self.head;
        text.push_str("<linearGradient id=\"");
        push_id(text, id);
        text.push_str("\" href=\"#");
        push_id(text, ramp);
        let names = ["x1", "y1", "x2", "y2"];
        for (name, step) in names.iter().zip(line.map(on_grid).as_flattened()) {
            text.push_str("\" ");
            text.push_str(name);
            text.push_str("=\"");
            push_numbers(text, &[*step]);
        }
        text.push('"');
        text.push_str(stops);
        id
    }

    fn ramp(&mut self, color: Option<[u8; 3]>) -> usize {
        if let Some(id) = self.ramps.get(&color) {
            return *id;
        }
        let id = self.next_id();
        self.ramps.insert(color, id);
        let text = &mut self.head;
        text.push_str("<linearGradient id=\"");
        push_id(text, id);
        text.push_str("\" gradientUnits=\"userSpaceOnUse\"");
        if let Some(color) = color {
            text.push_str("><stop/><stop offset=\"1\" stop-color=\"");
            push_color(text, color);
            text.push_str("\"/></linearGradient>");
        } else {
            text.push_str("/>");
        }
        id
    }

    fn next_id(&mut self) -> usize {
        self.ids += 1;
        self.ids - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::item_buffer::Supersampling;
    use crate::picture::{Picture, Rgba};
    use crate::planar::Drawn;
    use crate::planar::clip::fixture;
    use crate::planar::reference::reference_with_mask;
    use crate::vector::raster::raster;

    const WHITE: Rgba = [255; 4];

    /// The drawn triangles of a convex clip: none covers another, so any order is correct.
    fn shown(clip: &PlanarClip, frame: usize) -> Vec<u32> {
        let drawn = Drawn::seen(clip).unwrap();
        (0..12).filter(|t| drawn.get(frame, *t as usize)).collect()
    }

    fn rmse_of_object(clip: &PlanarClip, frame: usize, seen: &Picture) -> f64 {
        let (truth, mask) = reference_with_mask(clip, frame, Supersampling::Eight, WHITE).unwrap();
        let (mut sum, mut count) = (0.0, 0.0);
        for ((p, q), inside) in seen.pixels().iter().zip(truth.pixels()).zip(mask) {
            if inside {
                for k in 0..3 {
                    sum += (f64::from(p[k]) - f64::from(q[k])).powi(2);
                }
                count += 3.0;
            }
        }
        (sum / f64::max(count, 1.0)).sqrt()
    }

    #[test]
    fn a_cube_looks_like_its_reference() {
        let cube = fixture::turning_cube(8);
        for frame in 0..8 {
            let of = |shading, distance_px| {
                let underlap = UnderlapOptions {
                    distance_px,
                    ..UnderlapOptions::default()
                };
                let options = StillOptions {
                    shading,
                    underlap,
                    ..StillOptions::default()
                };
                let text = still(&cube, frame, &shown(&cube, frame), &options).unwrap();
                rmse_of_object(&cube, frame, &raster(&text, WHITE).unwrap())
            };
            let sealed = of(Shading::Gouraud, 0.8);
            // Mostly the outline, on a grid of a quarter pixel.
            assert!(sealed < 6.2, "{sealed} in frame {frame}");
            assert!(sealed < of(Shading::Gouraud, 0.0), "frame {frame}");
            assert!(sealed < of(Shading::Flat, 0.8), "frame {frame}");
        }
    }

    #[test]
    fn exact_shows_three_colours_where_one_gradient_cannot() {
        let wide = [
            [-20.0, -20.0, 0.5],
            [-20.0, 180.0, 0.5],
            [180.0, -20.0, 0.5],
        ];
        let mut clip = fixture::loose(&[(wide, [200; 3])], 1);
        clip.surfaces[0].albedo = None;
        clip.albedo = vec![[255.0, 0.0, 0.0], [0.0, 255.0, 0.0], [0.0, 0.0, 255.0]];
        let of = |exact| {
            let options = StillOptions {
                exact,
                ..StillOptions::default()
            };
            let text = still(&clip, 0, &[0], &options).unwrap();
            rmse_of_object(&clip, 0, &raster(&text, WHITE).unwrap())
        };
        assert!(of(true) < 1.0, "{}", of(true));
        assert!(of(false) > 5.0);
    }

    #[test]
    fn a_ramp_is_written_once_and_ids_are_distinct() {
        let cube = fixture::turning_cube(8);
        let order = shown(&cube, 1);
        let text = still(&cube, 1, &order, &StillOptions::default()).unwrap();
        assert_eq!(
            text,
            still(&cube, 1, &order, &StillOptions::default()).unwrap()
        );
        assert_eq!(text.matches("userSpaceOnUse").count(), 1);
        assert_eq!(text.matches("<path").count(), order.len());
        let ids: Vec<&str> = text
            .split(" id=\"")
            .skip(1)
            .filter_map(|t| t.split('"').next())
            .collect();
        let distinct: std::collections::BTreeSet<_> = ids.iter().collect();
        assert_eq!(distinct.len(), ids.len());
        // Every gradient is used.
        assert!(
            ids[1..]
                .iter()
                .all(|id| text.contains(&format!("url(#{id})")))
        );
    }

    #[test]
    fn an_empty_frame_is_a_picture_and_wrong_arguments_are_told() {
        let cube = fixture::turning_cube(2);
        let options = StillOptions::default();
        let empty = raster(&still(&cube, 0, &[], &options).unwrap(), WHITE).unwrap();
        assert!(empty.pixels().iter().all(|p| *p == WHITE));
        assert!(matches!(
            still(&cube, 2, &[], &options),
            Err(PlanarError::Mismatch { .. })
        ));
        assert!(matches!(
            still(&cube, 0, &[12], &options),
            Err(PlanarError::Mismatch { .. })
        ));
    }
}
