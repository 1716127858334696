//! Fewer colours: those that hardly differ become one.
//!
//! A file repeats a colour for less than it names another one, and gradients of equal colours are one. Colours are
//! taken in the order of how many others lie within the tolerance, so that each that is kept stands for many.

use super::clip::PlanarClip;
use super::drawn::Drawn;
use super::shading::{Colors, Shading, drawn_frames, flat_color};
use std::collections::BTreeMap;

type Color = [u8; 3];

/// Colours in the cell of a grid as wide as the tolerance, so that all that are near lie in its 27 neighbours.
struct Near {
    cells: BTreeMap<[i16; 3], Vec<Color>>,
    tolerance: u8,
}

impl Near {
    fn new(tolerance: u8) -> Self {
        Self {
            cells: BTreeMap::new(),
            tolerance,
        }
    }

    fn cell(&self, color: Color) -> [i16; 3] {
        color.map(|level| i16::from(level) / (i16::from(self.tolerance) + 1))
    }

    fn add(&mut self, color: Color) {
        self.cells.entry(self.cell(color)).or_default().push(color);
    }

    /// The colours within the tolerance in each channel.
    fn of(&self, color: Color) -> impl Iterator<Item = Color> {
        let [r, g, b] = self.cell(color);
        let rows = (r - 1..=r + 1).flat_map(move |r| (g - 1..=g + 1).map(move |g| [r, g]));
        rows.flat_map(move |[r, g]| self.cells.range([r, g, b - 1]..=[r, g, b + 1]))
            .flat_map(|(_, colors)| colors)
            .copied()
            .filter(move |other| (0..3).all(|c| other[c].abs_diff(color[c]) <= self.tolerance))
    }
}

/// Returns the colours of each of the triangles throughout the clip, off by at most a tolerance in levels for having
/// few of them.
pub(super) fn few_colors(
    clip: &PlanarClip,
    drawn: &Drawn,
    triangles: impl Iterator<Item = u32>,
    (shading, tolerance): (Shading, u8),
) -> BTreeMap<u32, Colors> {
    let mut colors = BTreeMap::new();
    for triangle in triangles {
        colors.entry(triangle).or_insert_with(|| {
            let t = triangle as usize;
            let frames = drawn_frames(drawn, t);
            match shading {
                Shading::Flat => Colors::Flat(flat_color(clip, t, frames)),
                Shading::Gouraud => Colors::of(clip, t, frames),
            }
        });
    }
    make_few(colors.values_mut(), tolerance);
    colors
}

/// Replaces colours by others of them that differ by at most `tolerance` levels in each channel. A gradient whose
/// ends become one colour is flat.
fn make_few<'a>(all: impl Iterator<Item = &'a mut Colors>, tolerance: u8) {
    let all: Vec<&mut Colors> = all.collect();
    let mut counts: BTreeMap<Color, usize> = BTreeMap::new();
    for color in all.iter().flat_map(|colors| colors.chosen()) {
        *counts.entry(color).or_default() += 1;
    }
    let mut near = Near::new(tolerance);
    counts.keys().for_each(|color| near.add(*color));
    let around = |color: &Color| near.of(*color).map(|other| counts[&other]).sum::<usize>();
    let mut order: Vec<(usize, Color)> = counts.keys().map(|c| (around(c), *c)).collect();
    order.sort_unstable_by_key(|(count, color)| (std::cmp::Reverse(*count), *color));
    let mut kept = Near::new(tolerance);
    let mut becomes: BTreeMap<Color, Color> = BTreeMap::new();
    let distance = |a: Color, b: Color| (0..3).map(|c| u16::from(a[c].abs_diff(b[c]))).sum::<u16>();
    for (_, color) in order {
        let closest = kept
            .of(color)
            .min_by_key(|other| (distance(color, *other), *other));
        if closest.is_none() {
            kept.add(color);
        }
        becomes.insert(color, closest.unwrap_or(color));
    }
    for colors in all {
        *colors = colors.with(|color| becomes[&color]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn by_hand() {
        let mut all = [
            Colors::Flat([100, 50, 10]),
            Colors::Flat([102, 50, 10]),
            Colors::Ramp([104, 50, 10]),
            Colors::Own([[99, 51, 11], [200; 3]]),
            Colors::Own([[100, 50, 10], [101, 52, 10]]),
            Colors::Flat([107, 50, 10]),
        ];
        make_few(all.iter_mut(), 2);
        // 100 has five ends around it, as 102 has, and comes first.
        let kept = [100, 50, 10];
        let wanted = [
            Colors::Flat(kept),
            Colors::Flat(kept),
            Colors::Ramp([104, 50, 10]),
            Colors::Own([kept, [200; 3]]),
            Colors::Flat(kept),
            Colors::Flat([107, 50, 10]),
        ];
        assert_eq!(all, wanted);
    }

    proptest! {
        #[test]
        fn none_is_off_by_more_than_the_tolerance_and_what_is_kept_stays_apart(
            colors in prop::collection::vec(prop::array::uniform3(0u8..=40), 1..60),
            tolerance in 0u8..=5,
        ) {
            let before: Vec<Colors> = colors.iter().map(|c| Colors::Flat(*c)).collect();
            let mut after = before.clone();
            make_few(after.iter_mut(), tolerance);
            let ends = |of: &[Colors]| -> Vec<Color> { of.iter().map(|c| c.ends()[0]).collect() };
            let apart = |a: Color, b: Color| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap();
            let (before, after) = (ends(&before), ends(&after));
            for (a, b) in before.iter().zip(&after) {
                prop_assert!(apart(*a, *b) <= tolerance);
            }
            for (a, b) in after.iter().flat_map(|a| after.iter().map(move |b| (a, b))) {
                prop_assert!(a == b || apart(*a, *b) > tolerance);
            }
        }
    }
}
