//! One frame with three gradients per face.
//!
//! Source: thesis 4.2.4: three copies of a face, each in the colour of one corner with an opacity
//! that falls to zero at the opposite edge; `feComposite` adds them, `feColorMatrix` restores the
//! opacity of the sum, and a face in the mean colour lies under it. The opacities are the
//! barycentric weights, so the sum is the Gouraud colour. Differs: the copies are inserted by
//! `feImage`, the only element for it that current browsers support; it places its picture by the
//! filter region, which therefore begins at the picture's corner (10 bytes per face, and slow to
//! render).

use super::document::{Points, put};
use super::faces::{levels, mean_color};
use crate::planar::PlanarClip;
use glam::Vec2;

/// Appends the faces in painting order.
pub(super) fn write(clip: &PlanarClip, frame: usize, order: &[u32], text: &mut String) {
    for face in order {
        write_one(clip, frame, *face, text);
    }
}

fn write_one(clip: &PlanarClip, frame: usize, face: u32, text: &mut String) {
    let corners = clip.places(frame, face as usize);
    let points = Points(corners, 2);
    text.push_str("<defs>\n");
    for (k, name) in ["a", "b", "c"].into_iter().enumerate() {
        let color = Hex(levels(clip.color(frame, clip.triangles[face as usize][k])));
        let Line { from, to } = fade(corners, k);
        put(
            text,
            format_args!(
                "<linearGradient id=\"{name}{face}\" gradientUnits=\"userSpaceOnUse\" \
                 x1=\"{:.2}\" y1=\"{:.2}\" x2=\"{:.2}\" y2=\"{:.2}\">\
                 <stop offset=\"0\" stop-color=\"{color}\"/>\
                 <stop offset=\"1\" stop-color=\"{color}\" stop-opacity=\"0\"/>\
                 </linearGradient>\n",
                from.x, from.y, to.x, to.y
            ),
        );
    }
    let mean = Hex(mean_color(clip, frame, face));
    put(
        text,
        format_args!(
            "<polygon id=\"p{face}\" points=\"{points}\" fill=\"url(#a{face})\"/>\n\
             <polygon id=\"q{face}\" points=\"{points}\" fill=\"url(#b{face})\"/>\n\
             <filter id=\"f{face}\" filterUnits=\"userSpaceOnUse\" x=\"0\" y=\"0\">\
             <feImage xlink:href=\"#p{face}\" result=\"p\"/>\
             <feImage xlink:href=\"#q{face}\"/>\
             <feComposite in2=\"p\" operator=\"arithmetic\" k2=\"1\" k3=\"1\"/>\
             <feComposite in2=\"SourceGraphic\" operator=\"arithmetic\" k2=\"1\" k3=\"1\"/>\
             <feColorMatrix values=\"1 0 0 0 0 0 1 0 0 0 0 0 1 0 0 0 0 0 2 0\"/>\
             </filter>\n</defs>\n\
             <polygon points=\"{points}\" fill=\"{mean}\"/>\n\
             <polygon points=\"{points}\" fill=\"url(#c{face})\" filter=\"url(#f{face})\"/>\n"
        ),
    );
}

struct Line {
    from: Vec2,
    to: Vec2,
}

/// Line from a corner to the foot of its height, where its colour has faded out.
fn fade(corners: [Vec2; 3], corner: usize) -> Line {
    let [from, p, q] = [0, 1, 2].map(|i| corners[(corner + i) % 3].as_dvec2());
    let edge = q - p;
    // A face in view has area, so no edge has length 0.
    let to = p + edge * ((from - p).dot(edge) / edge.length_squared());
    Line {
        from: from.as_vec2(),
        to: to.as_vec2(),
    }
}

/// A colour as `#rrggbb`.
struct Hex([u8; 3]);

impl std::fmt::Display for Hex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [red, green, blue] = self.0;
        write!(f, "#{red:02x}{green:02x}{blue:02x}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::item_buffer::barycentric;

    #[test]
    fn a_colour_is_gone_at_the_opposite_edge() {
        let corners = [[0.0, 0.0], [10.0, 0.0], [4.0, 8.0]].map(Vec2::from);
        let third = fade(corners, 2);
        assert_eq!((third.from, third.to), (corners[2], Vec2::new(4.0, 0.0)));
        // From the corner (0, 0) to the line through (10, 0) and (4, 8): 4 x + 3 y = 40.
        let first = fade(corners, 0);
        assert!((first.to - Vec2::new(6.4, 4.8)).length() < 1e-5);
    }
    #[test]
    fn opacities_add_up_to_one_and_give_the_colour_of_the_item_buffer() {
        let corners = [[13.0, 8.0], [21.5, 90.0], [70.25, 31.0]].map(Vec2::from);
        let flat = corners.map(|c| glam::Vec4::new(c.x, c.y, 0.5, 1.0));
        for (i, j) in [(0.0, 0.0), (0.2, 0.7), (0.5, 0.5), (0.3, 0.3), (0.0, 1.0)] {
            let (p, q) = (corners[1] - corners[0], corners[2] - corners[0]);
            let at = corners[0] + p * i + q * j;
            let weights = barycentric(&flat, at).unwrap().to_array();
            for (k, weight) in weights.into_iter().enumerate() {
                let Line { from, to } = fade(corners, k);
                let along = (at - from).dot(to - from) / (to - from).length_squared();
                assert!((1.0 - along - weight).abs() < 1e-5, "{k} at {at}");
            }
        }
    }
}
