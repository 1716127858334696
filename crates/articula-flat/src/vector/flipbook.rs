//! Writes an SVG file with a group for each frame, one shown at a time.
//!
//! Source: `docs/methods/vector.md` 8.2. Nothing is interpolated: every frame has its own shapes,
//! order and paint. Corners are off by the grid only; gradient lines are rounded as coarsely as the
//! colour tolerance allows. The file is large, so the profile suits up to about 25 frames.

use super::smil::SvgWriter;
use crate::planar::PlanarError;
use crate::planar::keyed_clip::{KeyedClip, KeyedShape};

/// Returns the SVG text of frames, each a clip of one frame; `name` becomes the title.
///
/// Ramps, size and frame rate are those of the first.
///
/// # Errors
/// [`PlanarError::NoFrames`], or [`PlanarError::Mismatch`] if a page is invalid, has more than one
/// frame, or has other ramps or another size than the first.
pub(crate) fn flipbook(pages: &[KeyedClip], name: &str) -> Result<String, PlanarError> {
    let Some(first) = pages.first() else {
        return Err(PlanarError::NoFrames);
    };
    let head = |page: &KeyedClip| (page.width, page.height, page.fps);
    for (f, page) in pages.iter().enumerate() {
        page.check()?;
        if page.frames != 1
            || head(page) != head(first)
            || page.ramps != first.ramps
            || page.lines != first.lines
        {
            return Err(PlanarError::Mismatch {
                at: "flip-book",
                what: format!(
                    "page {f} must be one frame with the size and ramps of the first page"
                ),
            });
        }
    }
    let frames = pages.len() as u32;
    let whole = KeyedClip {
        frames,
        shapes: Vec::new(),
        ..first.clone()
    };
    whole.check()?;
    let mut writer = SvgWriter::new(&whole, name);
    for (f, page) in pages.iter().enumerate() {
        if pages.len() > 1 {
            let hidden = if f > 0 { r#" display="none""# } else { "" };
            let shown = KeyedShape::shown_in(std::slice::from_ref(&(f..f + 1)), frames);
            writer.begin_group(hidden, &shown);
        }
        for shape in &page.shapes {
            writer.still_shape(shape);
        }
        if pages.len() > 1 {
            writer.end_group();
        }
    }
    Ok(writer.finish())
}

#[cfg(test)]
mod tests {
    use super::super::smil_sampler::AnimatedSvg;
    use super::*;
    use crate::planar::keyed_clip::{KeyedPaint, KeyedTrack, LineUnits};

    fn page(x: i32) -> KeyedClip {
        KeyedClip {
            width: 10,
            height: 10,
            fps: 10.0,
            frames: 1,
            lines: LineUnits::Grid,
            ramps: vec![],
            motions: vec![],
            shapes: vec![KeyedShape {
                motion: None,
                outline: KeyedTrack::still(vec![x, 0, x + 8, 0, x, 8]),
                further_outlines: vec![],
                paint: KeyedPaint::Flat([255, 0, 0]),
                shown: KeyedShape::shown_in(std::slice::from_ref(&(0..1)), 1),
            }],
        }
    }

    #[test]
    fn one_page_is_shown_at_a_time() {
        let pages: Vec<KeyedClip> = (0..5).map(|f| page(4 * f)).collect();
        let text = flipbook(&pages, "").unwrap();
        let moving = AnimatedSvg::read(&text).unwrap();
        assert_eq!(moving.duration_secs, 0.4);
        for (secs, x) in [
            (0.0, 0),
            (0.06, 4),
            (0.14, 4),
            (0.2, 8),
            (0.36, 16),
            (0.4, 0),
        ] {
            let still = moving.at(secs).unwrap();
            let groups: Vec<&str> = still.split("<g").skip(1).collect();
            let shown: Vec<&&str> = groups
                .iter()
                .filter(|g| g.contains(r#"display="inline""#))
                .collect();
            assert_eq!(groups.len(), 5);
            assert_eq!(shown.len(), 1, "{secs}: {still}");
            assert!(
                shown[0].contains(&format!(r#"d="m{x} 0"#)),
                "{secs}: {still}"
            );
        }
        // Viewers without animation show the first page.
        assert_eq!(text.matches(r#"<g display="none">"#).count(), 4);
    }

    #[test]
    fn one_frame_is_a_still_and_odd_pages_are_refused() {
        let text = flipbook(&[page(0)], "").unwrap();
        assert!(
            text.ends_with(r##"<path fill="#f00" d="m0 0 8 0-8 8"/></svg>"##),
            "{text}"
        );
        assert_eq!(flipbook(&[], "").unwrap_err(), PlanarError::NoFrames);
        let other = KeyedClip {
            width: 9,
            ..page(0)
        };
        assert!(flipbook(&[page(0), other], "").is_err());
    }
}
