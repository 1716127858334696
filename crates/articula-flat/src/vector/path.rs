//! The shortest text for outlines, numbers and ids of an SVG.
//!
//! Source: SVG 2, 9.3 (path data grammar): a relative `m` is followed by relative lines, and a
//! minus sign separates two numbers. Outlines are filled, never stroked, so none needs to be closed
//! by `z`.

use crate::planar::keyed_clip::GRID;
use glam::Vec2;

/// Appends integers as a list, separated by a minus sign where there is one and by a space
/// otherwise.
pub(super) fn push_numbers(text: &mut String, numbers: &[i32]) {
    for number in numbers {
        push_number(text, i64::from(*number));
    }
}

/// Appends the path data of closed outlines in relative commands.
///
/// `points` are x, y, x, y, …; `further_outlines` holds the index of the first point of each
/// outline after the first, ascending.
pub(super) fn push_outlines(text: &mut String, points: &[i32], further_outlines: &[u32]) {
    let mut next = further_outlines.iter().peekable();
    let (mut x, mut y) = (0i64, 0i64);
    for (i, point) in points.chunks_exact(2).enumerate() {
        let is_first = next.next_if(|first| **first as usize == i).is_some() || i == 0;
        if is_first {
            text.push('m');
        }
        let to = (i64::from(point[0]), i64::from(point[1]));
        push_number(text, to.0 - x);
        push_number(text, to.1 - y);
        (x, y) = to;
    }
}

/// Converts a position in pixels to grid steps, clamped to what every player can draw.
pub(super) fn on_grid(place: Vec2) -> [i32; 2] {
    const FURTHEST: f32 = (1 << 26) as f32;
    let step = |v: f32| (v * GRID as f32).round().clamp(-FURTHEST, FURTHEST) as i32;
    [step(place.x), step(place.y)]
}

/// Appends a colour as `#rgb` or `#rrggbb`.
pub(super) fn push_color(text: &mut String, [r, g, b]: [u8; 3]) {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let is_short = [r, g, b].iter().all(|level| level % 17 == 0);
    text.push('#');
    for level in [r, g, b] {
        if !is_short {
            text.push(DIGITS[usize::from(level >> 4)].into());
        }
        text.push(DIGITS[usize::from(level & 15)].into());
    }
}

/// Appends the `index`th of the shortest ids: a letter, then letters and digits.
pub(super) fn push_id(text: &mut String, index: usize) {
    const LETTERS: usize = 52;
    const ALL: usize = 62;
    let digit = |i: usize| match i {
        0..26 => b'a' + i as u8,
        26..LETTERS => b'A' + (i - 26) as u8,
        _ => b'0' + (i - LETTERS) as u8,
    };
    let mut rest = index / LETTERS;
    text.push(digit(index % LETTERS).into());
    while rest > 0 {
        rest -= 1;
        text.push(digit(rest % ALL).into());
        rest /= ALL;
    }
}

/// A number in units of a power of ten, as the shortest decimal number.
pub(super) fn fixed(value: i32, unit: f64) -> String {
    let digits = unit.log10().round() as usize;
    let text = format!("{:.digits$}", f64::from(value.abs()) / unit);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    let text = text
        .strip_prefix("0.")
        .map_or(text.to_owned(), |rest| format!(".{rest}"));
    let sign = if value < 0 { "-" } else { "" };
    format!("{sign}{text}")
}

fn push_number(text: &mut String, number: i64) {
    let follows_number = text.bytes().last().is_some_and(|c| c.is_ascii_digit());
    if follows_number && number >= 0 {
        text.push(' ');
    }
    text.push_str(&number.to_string());
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    #[test]
    fn numbers_and_outlines_by_hand() {
        let mut text = String::from("M");
        push_numbers(&mut text, &[3, -4, 5]);
        assert_eq!(text, "M3-4 5");
        text.clear();
        push_outlines(&mut text, &[4, 8, 1, 9, 4, 2], &[]);
        assert_eq!(text, "m4 8-3 1 3-7");
    }

    #[test]
    fn holes_and_islands_begin_anew_from_the_last_point() {
        let mut text = String::new();
        let points = [0, 0, 10, 0, 0, 10, 2, 2, 2, 4, 4, 2];
        push_outlines(&mut text, &points, &[3]);
        // The second outline begins 2 to the right of (0, 10) and 8 above it.
        assert_eq!(text, "m0 0 10 0-10 10m2-8 0 2 2-2");
    }

    #[test]
    fn colours_take_three_digits_where_they_can() {
        let mut text = String::new();
        push_color(&mut text, [255, 0, 0x33]);
        push_color(&mut text, [255, 0, 0x34]);
        assert_eq!(text, "#f03#ff0034");
    }

    #[test]
    fn ids_are_distinct_short_and_begin_with_a_letter() {
        let ids: Vec<String> = (0..52 + 52 * 62 + 10)
            .map(|i| {
                let mut text = String::new();
                push_id(&mut text, i);
                text
            })
            .collect();
        assert!(ids.iter().all(|id| id.as_bytes()[0].is_ascii_alphabetic()));
        assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len());
        assert_eq!(
            (ids[51].len(), ids[52].len(), ids[52 + 52 * 62].len()),
            (1, 2, 3)
        );
    }

    proptest! {
        #[test]
        fn a_plain_reader_gets_the_points_back(points in prop::collection::vec(-5000i32..5000, 1..20)) {
            let points = &points[..points.len() / 2 * 2];
            let mut text = String::new();
            push_outlines(&mut text, points, &[]);
            let mut numbers = Vec::new();
            for part in text.replace('-', " -").split([' ', 'm']).filter(|p| !p.is_empty()) {
                numbers.push(part.parse::<i32>().unwrap());
            }
            let mut at = [0, 0];
            for (i, number) in numbers.iter().enumerate() {
                at[i % 2] += number;
                prop_assert_eq!(at[i % 2], points[i]);
            }
            prop_assert_eq!(numbers.len(), points.len());
        }
    }
}
