//! Rasterises a still SVG by resvg, for verification and for single frames.
//!
//! Source: `docs/methods/vector.md` 11. Only elements that draw shapes are accepted: whatever needs
//! fonts, files, other pictures or a stylesheet is refused by name, so that nothing is missing
//! unnoticed. Animation is ignored: the first state is drawn.

use crate::error::PictureError;
use crate::picture::{Picture, Rgba};
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::roxmltree::{Document, Error as XmlError, ParsingOptions};
use resvg::usvg::{Error, ImageHrefResolver, Options, Tree};

/// Maximum size of the SVG text, bytes.
const MAX_BYTES: usize = 256 << 20;
/// Maximum number of elements, texts and comments.
const MAX_NODES: u32 = 4_000_000;
/// Maximum number of pixels; 256 MiB of memory.
const MAX_PIXELS: u64 = 1 << 26;
/// Maximum nesting of groups; each may need an intermediate picture.
const MAX_DEPTH: usize = 16;

/// Elements that are drawn, or occur inside of drawn ones.
const SHAPES: [&str; 16] = [
    "svg",
    "g",
    "defs",
    "path",
    "polygon",
    "polyline",
    "line",
    "rect",
    "circle",
    "ellipse",
    "linearGradient",
    "radialGradient",
    "stop",
    "title",
    "desc",
    "metadata",
];
/// Elements that a still picture ignores.
const ANIMATION: [&str; 4] = ["animate", "animateTransform", "animateMotion", "set"];

/// Renders SVG text over a background, at the size that it specifies.
///
/// # Errors
/// [`PictureError`]: the text is not SVG, has unsupported elements, or is too large.
pub fn raster(svg: &str, background: Rgba) -> Result<Picture, PictureError> {
    raster_scaled(svg, background, 1)
}

/// Renders SVG text over a background, enlarged by a whole factor.
///
/// # Errors
/// As [`raster`].
pub(crate) fn raster_scaled(
    svg: &str,
    background: Rgba,
    factor: u32,
) -> Result<Picture, PictureError> {
    let tree = parse(svg)?;
    let size = tree.size().to_int_size();
    let (width, height) = (
        size.width().saturating_mul(factor),
        size.height().saturating_mul(factor),
    );
    let refuse = || PictureError::LimitExceeded {
        width,
        height,
        samples: 1,
        limit: "67108864 pixels in total",
    };
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(refuse());
    }
    let mut pixels = Pixmap::new(width, height).ok_or_else(refuse)?;
    let [r, g, b, a] = background;
    pixels.fill(Color::from_rgba8(r, g, b, a));
    let scale = Transform::from_scale(factor as f32, factor as f32);
    resvg::render(&tree, scale, &mut pixels.as_mut());
    let straight = |p: &resvg::tiny_skia::PremultipliedColorU8| {
        let c = p.demultiply();
        [c.red(), c.green(), c.blue(), c.alpha()]
    };
    Picture::from_pixels(
        width,
        height,
        pixels.pixels().iter().map(straight).collect(),
    )
}

fn parse(svg: &str) -> Result<Tree, PictureError> {
    let malformed = |what: String| PictureError::Malformed { at: "SVG", what };
    let too_many = |what: &str| PictureError::Unsupported {
        what: what.to_owned(),
        mend: "use fewer shapes".to_owned(),
    };
    if svg.len() > MAX_BYTES {
        return Err(too_many("an SVG file of more than 256 MiB"));
    }
    let strict = ParsingOptions {
        allow_dtd: false,
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(svg, strict).map_err(|e| match e {
        XmlError::NodesLimitReached => too_many("an SVG document of more than 4000000 nodes"),
        other => malformed(other.to_string()),
    })?;
    check(&document)?;
    let nothing_else = ImageHrefResolver {
        resolve_data: Box::new(|_, _, _| None),
        resolve_string: Box::new(|_, _| None),
    };
    let options = Options {
        image_href_resolver: nothing_else,
        ..Options::default()
    };
    Tree::from_xmltree(&document, &options).map_err(|e| match e {
        Error::ElementsLimitReached => too_many("an SVG document of more than 1000000 elements"),
        other => malformed(other.to_string()),
    })
}

/// Refuses what would be drawn wrongly or at excessive cost.
fn check(document: &Document<'_>) -> Result<(), PictureError> {
    let mut depth = 0;
    let mut node = document.root_element();
    loop {
        let name = node.tag_name().name();
        let is_nested_picture = name == "svg" && depth > 0;
        let is_known = SHAPES.contains(&name) || ANIMATION.contains(&name);
        if node.is_element() && (!is_known || is_nested_picture) {
            return Err(PictureError::Unsupported {
                what: format!(
                    "SVG element <{}>",
                    name.chars().take(40).collect::<String>()
                ),
                mend: "replace it by plain shapes".to_owned(),
            });
        }
        if let Some(child) = node.first_child() {
            depth += 1;
            if depth > MAX_DEPTH {
                return Err(PictureError::Unsupported {
                    what: format!("an SVG document of more than {MAX_DEPTH} nested groups"),
                    mend: "nest fewer groups".to_owned(),
                });
            }
            node = child;
            continue;
        }
        node = loop {
            if let Some(sibling) = node.next_sibling() {
                break sibling;
            }
            match node.parent_element() {
                Some(parent) => node = parent,
                None => return Ok(()),
            }
            depth -= 1;
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Rgba = [255; 4];

    fn svg(inside: &str) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"20\" height=\"10\" \
             viewBox=\"0 0 80 40\">{inside}</svg>"
        )
    }

    #[test]
    fn half_a_picture_is_covered() {
        let text = svg("<path fill=\"#102030\" d=\"m0 0 40 0 0 40-40 0\"/>");
        let picture = raster(&text, WHITE).unwrap();
        assert_eq!((picture.width(), picture.height()), (20, 10));
        assert_eq!(picture.get(9, 9), Some([0x10, 0x20, 0x30, 255]));
        assert_eq!(picture.get(10, 9), Some(WHITE));
        let clear = raster(&text, [0; 4]).unwrap();
        assert_eq!(clear.get(10, 9), Some([0; 4]));
        // Half transparent over the background, blended in sRGB.
        let half = svg("<path fill-opacity=\".5\" d=\"m0 0 80 0 0 40-80 0\"/>");
        let [r, ..] = raster(&half, WHITE).unwrap().get(3, 3).unwrap();
        assert!((126..=129).contains(&r), "{r}");
    }

    #[test]
    fn a_gradient_inherits_its_stops_and_units() {
        let text = svg(
            "<defs><linearGradient id=\"a\" gradientUnits=\"userSpaceOnUse\">\
             <stop/><stop offset=\"1\" stop-color=\"#ff0000\"/></linearGradient>\
             <linearGradient id=\"b\" href=\"#a\" x1=\"0\" y1=\"0\" x2=\"80\" y2=\"0\"/></defs>\
             <path fill=\"url(#b)\" d=\"m0 0 80 0 0 40-80 0\"/>",
        );
        let picture = raster(&text, WHITE).unwrap();
        for x in 0..20u8 {
            let [r, g, ..] = picture.get(u32::from(x), 5).unwrap();
            let expected = 255.0 * (f32::from(x) + 0.5) / 20.0;
            assert!(
                (f32::from(r) - expected).abs() < 1.5 && g == 0,
                "{r} at {x}"
            );
        }
    }

    #[test]
    fn animation_shows_its_first_state() {
        let text = svg("<path fill=\"#fff\" d=\"m0 0 80 0 0 40-80 0\">\
             <animate attributeName=\"fill\" values=\"#000;#111\" dur=\"1s\"/></path>");
        assert_eq!(raster(&text, [0; 4]).unwrap().get(0, 0), Some(WHITE));
    }

    #[test]
    fn what_is_not_drawn_is_refused_by_name() {
        for name in [
            "image", "text", "use", "filter", "style", "script", "mask", "svg",
        ] {
            let told = raster(&svg(&format!("<{name}/>")), WHITE).unwrap_err();
            assert!(told.to_string().contains(name), "{told}");
        }
        let deep = svg(&("<g>".repeat(200_000) + &"</g>".repeat(200_000)));
        assert!(matches!(
            raster(&deep, WHITE),
            Err(PictureError::Unsupported { .. })
        ));
        let flat = svg(&("<g><g/></g><g/>".repeat(50)));
        assert!(raster(&flat, WHITE).is_ok());
    }

    #[test]
    fn broken_entity_bombs_and_giants_are_told() {
        let good = svg("<g/>");
        for length in 0..good.len() {
            assert!(raster(&good[..length], WHITE).is_err(), "cut to {length}");
        }
        let bomb = format!(
            "<!DOCTYPE svg [<!ENTITY a \"b\">]>{}",
            svg("<title>&a;</title>")
        );
        assert!(matches!(
            raster(&bomb, WHITE),
            Err(PictureError::Malformed { .. })
        ));
        let giant = good.replace("\"20\"", "\"1e9\"");
        assert!(matches!(
            raster(&giant, WHITE),
            Err(PictureError::LimitExceeded { .. })
        ));
    }
}
