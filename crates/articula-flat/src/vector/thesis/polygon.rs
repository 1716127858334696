//! A `polygon` for each face and frame in view.
//!
//! Source: thesis 4.2.2: a polygon cannot be deformed, so a face needs a series of them, each
//! visible for one frame. A hidden pair of face and frame has none, which follows from the printed
//! sizes of the pyramid (6.2.2: both formulas agree on the number of frames only if four or five of
//! the eight faces have polygons). The colour is that of the frame.

use super::document::{Clock, Points, put};
use super::faces::{Faces, mean_color};
use crate::planar::PlanarClip;
use glam::Vec2;

/// Appends all polygons, face by face in painting order.
pub(super) fn write(clip: &PlanarClip, faces: &Faces, clock: Clock, text: &mut String) {
    for face in &faces.order {
        for frame in 0..clip.frames.len() {
            if faces.is_shown(frame, *face) {
                write_one(clip, (*face, frame), clock, text);
            }
        }
    }
}

/// Appends the polygon of a face without animation.
pub(super) fn write_still(
    face: u32,
    corners: [Vec2; 3],
    [red, green, blue]: [u8; 3],
    text: &mut String,
) {
    let points = Points(corners, 3);
    put(
        text,
        format_args!(
            "<polygon id=\"face{face}\" points=\"{points}\" fill=\"rgb({red},{green},{blue})\" \
             stroke=\"none\"/>\n"
        ),
    );
}

fn write_one(clip: &PlanarClip, (face, frame): (u32, usize), clock: Clock, text: &mut String) {
    let points = Points(clip.places(frame, face as usize), 3);
    let [red, green, blue] = mean_color(clip, frame, face);
    let is_first = frame == 0;
    let visibility = if is_first { "visible" } else { "hidden" };
    put(
        text,
        format_args!(
            "<polygon id=\"face{face}frame{frame}\" points=\"{points}\" \
             fill=\"rgb({red},{green},{blue})\" stroke=\"none\" visibility=\"{visibility}\">\n"
        ),
    );
    let is_last = frame + 1 == clip.frames.len();
    let (begin, length) = (clock.begin(frame), clock.between(frame, frame + 1));
    // Viewers without animation show the first frame, so its polygon is hidden when the frame ends.
    if is_first && !is_last {
        put(
            text,
            format_args!(
                "<set attributeName=\"visibility\" attributeType=\"CSS\" to=\"hidden\" \
                 begin=\"{length}\" fill=\"freeze\"/>\n"
            ),
        );
    } else if !is_first {
        let fill = if is_last { "freeze" } else { "remove" };
        put(
            text,
            format_args!(
                "<set attributeName=\"visibility\" attributeType=\"CSS\" to=\"visible\" \
                 begin=\"{begin}\" dur=\"{length}\" fill=\"{fill}\"/>\n"
            ),
        );
    }
    text.push_str("</polygon>\n");
}
