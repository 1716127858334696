//! One gradient per triangle, as vector players show linear colour between three corners.
//!
//! Source: `docs/methods/vector.md` 6. Triangles of one albedo use a ramp from black to it, shared
//! by all triangles of that albedo, which is exact. Where the corners' albedos differ, the first
//! principal axis of their colours gives two colours. The two colours are constant over time and
//! the gradient line moves. A weak gradient is kept at one level across the triangle, so that its
//! line neither runs to infinity nor turns over between frames.

use super::clip::PlanarClip;
use super::drawn::Drawn;
use glam::{Mat3, Vec2, Vec3};

/// Colours that differ by less than this count as one, levels.
const FLAT_SPREAD: f32 = 1.5;
/// A triangle whose parallelogram is smaller than this is treated as a line, square pixels.
const MIN_AREA: f32 = 1e-2;

/// Fill of the triangles: one colour or one gradient.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Shading {
    /// One colour.
    Flat,
    /// One gradient: exact where the corners have one albedo.
    #[default]
    Gouraud,
}

/// Colours that fill a triangle throughout the clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Colors {
    /// One colour, sRGB levels.
    Flat([u8; 3]),
    /// From black to an albedo, sRGB levels.
    Ramp([u8; 3]),
    /// From one colour to another, not shared; sRGB levels.
    Own([[u8; 3]; 2]),
}

impl Colors {
    /// Returns the colours of a triangle that is shown in these frames.
    pub(crate) fn of(
        clip: &PlanarClip,
        triangle: usize,
        frames: impl Iterator<Item = usize> + Clone,
    ) -> Self {
        let lit = |f: usize| corner_colors(clip, f, triangle);
        let mut low = Vec3::INFINITY;
        let mut high = Vec3::NEG_INFINITY;
        for color in frames.clone().flat_map(lit) {
            low = low.min(color);
            high = high.max(color);
        }
        // Also without frames.
        if (high - low).max_element() < FLAT_SPREAD {
            return Self::Flat(flat_color(clip, triangle, frames));
        }
        if let Some(albedo) = one_albedo(clip, triangle) {
            return Self::Ramp(albedo);
        }
        let (mean, axis) = principal_axis(clip, triangle, frames.clone());
        let mut ends = [0.0f32; 2];
        for color in frames.clone().flat_map(lit) {
            let along = (color - mean).dot(axis);
            ends = [ends[0].min(along), ends[1].max(along)];
        }
        let stops = ends.map(|end| levels(mean + axis * end));
        if stops[0] == stops[1] {
            return Self::Flat(flat_color(clip, triangle, frames));
        }
        Self::Own(stops)
    }

    /// Returns the colours of one channel (0 red, 1 green, 2 blue) of a triangle in one frame; the
    /// other channels are black.
    pub(crate) fn of_channel(
        clip: &PlanarClip,
        (frame, triangle): (usize, usize),
        channel: usize,
    ) -> Self {
        let levels = corner_colors(clip, frame, triangle).map(|color| color[channel]);
        let [low, high] = levels
            .iter()
            .fold([f32::MAX, f32::MIN], |[low, high], level| {
                [low.min(*level), high.max(*level)]
            });
        let only = |level: f32| {
            let mut color = [0; 3];
            color[channel] = level.round().clamp(0.0, 255.0) as u8;
            color
        };
        if high - low < FLAT_SPREAD {
            Self::Flat(only(levels.iter().sum::<f32>() / 3.0))
        } else {
            Self::Ramp(only(255.0))
        }
    }

    /// The colours that were chosen for the triangle: the black end of a ramp is none of them.
    pub(crate) fn chosen(&self) -> impl Iterator<Item = [u8; 3]> {
        let chosen = match self {
            Self::Flat(color) | Self::Ramp(color) => [Some(*color), None],
            Self::Own(stops) => stops.map(Some),
        };
        chosen.into_iter().flatten()
    }

    /// The same with other colours; flat if both ends become equal.
    pub(crate) fn with(&self, becomes: impl Fn([u8; 3]) -> [u8; 3]) -> Self {
        match self {
            Self::Flat(color) => Self::Flat(becomes(*color)),
            Self::Ramp(albedo) => Self::Ramp(becomes(*albedo)),
            Self::Own(stops) => match stops.map(becomes) {
                [from, to] if from == to => Self::Flat(from),
                stops => Self::Own(stops),
            },
        }
    }

    /// Both end colours in levels; equal if flat.
    pub(crate) fn ends(&self) -> [[u8; 3]; 2] {
        match self {
            Self::Flat(color) => [*color; 2],
            Self::Ramp(albedo) => [[0; 3], *albedo],
            Self::Own(stops) => *stops,
        }
    }

    /// Position of the triangle's corners between the first end colour (0) and the second (1).
    pub(crate) fn shares(&self, clip: &PlanarClip, frame: usize, triangle: usize) -> [f32; 3] {
        let [from, to] = self.ends().map(vec);
        let along = to - from;
        let length = along.length_squared().max(1.0);
        let share = |color: Vec3| ((color - from).dot(along) / length).clamp(0.0, 1.0);
        corner_colors(clip, frame, triangle).map(share)
    }

    /// Gradient line in a frame, pixels: from the position of the first end colour to that of the
    /// second.
    pub(crate) fn line(&self, clip: &PlanarClip, frame: usize, triangle: usize) -> [Vec2; 2] {
        let places = clip.places(frame, triangle);
        let slope = Affine::through(&places, self.shares(clip, frame, triangle));
        let extent = places.map(|p| p.distance(slope.origin));
        let widest = self.span_levels() * extent[0].max(extent[1]).max(extent[2]);
        slope.line(1.0 / widest.max(1.0))
    }

    /// Greatest channel difference between the end colours, levels.
    pub(crate) fn span_levels(&self) -> f32 {
        let [from, to] = self.ends().map(vec);
        (to - from).abs().max_element()
    }
}

/// Flat colour of a triangle: the mean over its frames, weighted by its area in each.
///
/// Black without frames.
pub(crate) fn flat_color(
    clip: &PlanarClip,
    triangle: usize,
    frames: impl Iterator<Item = usize>,
) -> [u8; 3] {
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for f in frames {
        let weight = weight(clip, f, triangle);
        sum += corner_colors(clip, f, triangle).into_iter().sum::<Vec3>() * (weight / 3.0);
        weights += weight;
    }
    levels(sum / f32::max(weights, f32::MIN_POSITIVE))
}

/// Frames in which a triangle is drawn.
pub(crate) fn drawn_frames(drawn: &Drawn, triangle: usize) -> impl Iterator<Item = usize> + Clone {
    (0..drawn.frames()).filter(move |f| drawn.get(*f, triangle))
}

/// An affine function over the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Affine {
    origin: Vec2,
    value: f32,
    slope: Vec2,
}

impl Affine {
    /// Returns the function with these values at the corners; if the corners are collinear, the one
    /// through the values of the longest edge.
    fn through(places: &[Vec2; 3], values: [f32; 3]) -> Self {
        let [a, b, c] = *places;
        let (ab, ac) = (b - a, c - a);
        let area = ab.perp_dot(ac);
        let (to_b, to_c) = (values[1] - values[0], values[2] - values[0]);
        let slope = if area.abs() >= MIN_AREA {
            (ac.perp() * -to_b + ab.perp() * to_c) / area
        } else {
            let edge = |i: usize| {
                let along = places[(i + 1) % 3] - places[i];
                (along, values[(i + 1) % 3] - values[i])
            };
            let longer = |p: (Vec2, f32), q: (Vec2, f32)| {
                if q.0.length_squared() > p.0.length_squared() {
                    q
                } else {
                    p
                }
            };
            let (along, rise) = longer(longer(edge(0), edge(1)), edge(2));
            along * (rise / along.length_squared().max(1e-12))
        };
        Self {
            origin: (a + b + c) / 3.0,
            value: values.iter().sum::<f32>() / 3.0,
            slope,
        }
    }

    /// Line from value 0 to value 1, along the slope through the origin; a slope below `least` is
    /// raised to it.
    fn line(&self, least: f32) -> [Vec2; 2] {
        let steep = self.slope.length();
        let direction = self.slope.normalize_or(Vec2::X);
        let per_share = direction / steep.max(least);
        let at = |share: f32| self.origin + per_share * (share - self.value);
        [at(0.0), at(1.0)]
    }
}

/// Albedo of a triangle, if its corners have the same one.
fn one_albedo(clip: &PlanarClip, triangle: usize) -> Option<[u8; 3]> {
    let [a, b, c] = clip.triangles[triangle].map(|v| Vec3::from(clip.albedo[v as usize]));
    let spread = a.max(b).max(c) - a.min(b).min(c);
    (spread.max_element() < FLAT_SPREAD).then(|| levels((a + b + c) / 3.0))
}

/// Lit colours at the corners, levels.
fn corner_colors(clip: &PlanarClip, frame: usize, triangle: usize) -> [Vec3; 3] {
    clip.triangles[triangle].map(|v| Vec3::from(clip.color(frame, v)))
}

/// Weight of a frame for a triangle's colours: its area plus a small constant.
fn weight(clip: &PlanarClip, frame: usize, triangle: usize) -> f32 {
    let [a, b, c] = clip.places(frame, triangle);
    (b - a).perp_dot(c - a).abs() + MIN_AREA
}

/// Mean of the corners' colours, and the direction of greatest variance.
fn principal_axis(
    clip: &PlanarClip,
    triangle: usize,
    frames: impl Iterator<Item = usize> + Clone,
) -> (Vec3, Vec3) {
    let (mut mean, mut weights) = (Vec3::ZERO, 0.0);
    let colors = frames.flat_map(|f| {
        let weight = weight(clip, f, triangle);
        corner_colors(clip, f, triangle).map(|color| (color, weight))
    });
    for (color, weight) in colors.clone() {
        mean += color * weight;
        weights += weight;
    }
    mean /= weights;
    let mut spread = Mat3::ZERO;
    let mut furthest = (0.0, Vec3::ZERO);
    for (color, weight) in colors {
        let off = color - mean;
        spread += Mat3::from_cols(off * off.x, off * off.y, off * off.z) * (weight / weights);
        if off.length_squared() > furthest.0 {
            furthest = (off.length_squared(), off);
        }
    }
    // Power method by squaring: twelve squarings equal 4096 iterations.
    for _ in 0..12 {
        let largest = spread
            .to_cols_array()
            .into_iter()
            .fold(0.0, |m: f32, v| m.max(v.abs()));
        spread *= 1.0 / largest.max(f32::MIN_POSITIVE);
        spread = spread * spread;
    }
    let columns = [spread.x_axis, spread.y_axis, spread.z_axis];
    let longest = columns.into_iter().fold(Vec3::ZERO, |a, b| {
        if b.length_squared() > a.length_squared() {
            b
        } else {
            a
        }
    });
    let axis = longest.try_normalize().or(furthest.1.try_normalize());
    // Towards the lighter end, so that equal triangles have equal end colours.
    let axis = axis.unwrap_or(Vec3::ONE);
    let is_darker = axis.element_sum() < 0.0;
    (mean, if is_darker { -axis } else { axis }.normalize())
}

fn vec(color: [u8; 3]) -> Vec3 {
    Vec3::from(color.map(f32::from))
}

fn levels(color: Vec3) -> [u8; 3] {
    color
        .to_array()
        .map(|level| level.round().clamp(0.0, 255.0) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::clip::fixture;
    use proptest::prelude::*;

    /// Fraction along a gradient line at a position, 0 to 1, as players paint it.
    fn share_at([from, to]: [Vec2; 2], place: Vec2) -> f32 {
        let along = to - from;
        let length = along.length_squared();
        if length <= 0.0 {
            // SVG 2, 14.2.2: the last stop's colour fills everything.
            return 1.0;
        }
        ((place - from).dot(along) / length).clamp(0.0, 1.0)
    }

    /// Greatest difference, in levels, between the target fractions at the triangle's corners and
    /// those that a gradient line shows there.
    ///
    /// Colour that two stops cannot represent is not counted: it is the same for every line.
    fn error_levels(
        colors: &Colors,
        clip: &PlanarClip,
        (frame, triangle): (usize, usize),
        line: [Vec2; 2],
    ) -> f32 {
        let places = clip.places(frame, triangle);
        let wanted = colors.shares(clip, frame, triangle);
        let apart = |i: usize| (share_at(line, places[i]) - wanted[i]).abs();
        colors.span_levels() * apart(0).max(apart(1)).max(apart(2))
    }

    const RIGHT: [[f32; 3]; 3] = [[0.0, 0.0, 0.5], [0.0, 40.0, 0.5], [40.0, 0.0, 0.5]];

    fn lit(light: [f32; 3]) -> PlanarClip {
        let mut clip = fixture::loose(&[(RIGHT, [200, 100, 50])], 1);
        clip.frames[0].light = light.to_vec();
        clip
    }

    /// Colours at the corners, under full light.
    fn colored(colors: [[f32; 3]; 3]) -> PlanarClip {
        let mut clip = lit([1.0; 3]);
        clip.surfaces[0].albedo = None;
        clip.albedo = colors.to_vec();
        clip
    }

    #[test]
    fn light_that_grows_to_the_right_gives_a_line_to_the_right() {
        let clip = lit([0.0, 0.0, 1.0]);
        let colors = Colors::of(&clip, 0, 0..1);
        assert_eq!(colors, Colors::Ramp([200, 100, 50]));
        let [from, to] = colors.line(&clip, 0, 0);
        assert!(from.distance(Vec2::new(0.0, 40.0 / 3.0)) < 1e-3, "{from}");
        assert!(to.distance(Vec2::new(40.0, 40.0 / 3.0)) < 1e-3, "{to}");
        // Half the light range doubles the distance from dark to bright.
        let clip = lit([0.25, 0.25, 0.75]);
        let [from, to] = Colors::of(&clip, 0, 0..1).line(&clip, 0, 0);
        assert!((from.x + 20.0).abs() < 1e-3 && (to.x - 60.0).abs() < 1e-3);
    }

    #[test]
    fn errors_are_levels_at_the_corners() {
        let clip = lit([0.0, 0.0, 1.0]);
        let colors = Colors::of(&clip, 0, 0..1);
        let line = colors.line(&clip, 0, 0);
        assert!(error_levels(&colors, &clip, (0, 0), line) < 1e-3);
        // A tenth of the distance from 0 to 200.
        let moved = line.map(|p| p + Vec2::new(4.0, 9.0));
        assert!((error_levels(&colors, &clip, (0, 0), moved) - 20.0).abs() < 1e-3);
        assert_eq!(
            error_levels(&Colors::Flat([7; 3]), &clip, (0, 0), line),
            0.0
        );
    }

    #[test]
    fn what_hardly_differs_is_flat_and_its_colour_is_weighted_by_size() {
        let clip = lit([0.5, 0.5, 0.507]);
        assert_eq!(Colors::of(&clip, 0, 0..1), Colors::Flat([100, 50, 25]));
        assert_eq!(Colors::of(&clip, 0, 0..0), Colors::Flat([0; 3]));
        let mut clip = lit([1.0; 3]);
        clip.frames.push(clip.frames[0].clone());
        clip.frames[1].light = vec![0.5; 3];
        // A third of the area, half the light: (3 + 0.5) / 4.
        clip.frames[1].xy[2].x /= 3.0;
        let [r, g, b] = flat_color(&clip, 0, 0..2);
        assert!(r == 175 && (87..=88).contains(&g) && b == 44);
        let drawn = Drawn::none(2, 1);
        assert_eq!(drawn_frames(&drawn, 0).count(), 0);
    }

    #[test]
    fn colours_on_a_line_are_shown_exactly() {
        let clip = colored([
            [10.0, 200.0, 30.0],
            [60.0, 150.0, 30.0],
            [110.0, 100.0, 30.0],
        ]);
        let colors = Colors::of(&clip, 0, 0..1);
        let Colors::Own(mut ends) = colors else {
            panic!("{colors:?}")
        };
        ends.sort_unstable();
        assert_eq!(ends, [[10, 200, 30], [110, 100, 30]]);
        let shares = colors.shares(&clip, 0, 0);
        assert!((shares[1] - 0.5).abs() < 1e-2, "{shares:?}");
        let line = colors.line(&clip, 0, 0);
        assert!(error_levels(&colors, &clip, (0, 0), line) < 0.1);
    }

    #[test]
    fn channels_apart_are_exact_each() {
        let clip = colored([[0.0, 40.0, 9.0], [0.0, 40.0, 9.0], [255.0, 80.0, 10.0]]);
        let of = |channel| Colors::of_channel(&clip, (0, 0), channel);
        assert_eq!(of(0), Colors::Ramp([255, 0, 0]));
        assert_eq!(of(2), Colors::Flat([0, 0, 9]));
        assert!((of(1).shares(&clip, 0, 0)[2] - 80.0 / 255.0).abs() < 1e-4);
        let [from, to] = of(0).line(&clip, 0, 0);
        assert!(from.x.abs() < 1e-3 && (to.x - 40.0).abs() < 1e-3);
    }

    proptest! {
        #[test]
        fn lines_are_finite_bounded_and_show_what_is_wanted(
            corners in prop::collection::vec((0i8..40, 0i8..40), 3),
            levels in prop::collection::vec(prop::array::uniform3(0.0f32..255.0), 3),
        ) {
            let mut clip = colored([levels[0], levels[1], levels[2]]);
            for (to, (x, y)) in clip.frames[0].xy.iter_mut().zip(&corners) {
                *to = Vec2::new(f32::from(*x), f32::from(*y));
            }
            let colors = Colors::of(&clip, 0, 0..1);
            let line = colors.line(&clip, 0, 0);
            prop_assert!(line.iter().all(|p| p.is_finite() && p.length() < 255.0 * 60.0));
            let [a, b, c] = clip.places(0, 0);
            if (b - a).perp_dot(c - a).abs() >= 1.0 {
                let off = error_levels(&colors, &clip, (0, 0), line);
                prop_assert!(off < 1.1, "{off}");
            }
        }

        #[test]
        fn two_colours_are_never_worse_than_one(
            levels in prop::collection::vec(prop::array::uniform3(0.0f32..255.0), 3),
        ) {
            let clip = colored([levels[0], levels[1], levels[2]]);
            let colors = Colors::of(&clip, 0, 0..1);
            let [from, to] = colors.ends().map(vec);
            let shares = colors.shares(&clip, 0, 0);
            let one = vec(flat_color(&clip, 0, 0..1));
            let (mut with_two, mut with_one) = (0.0, 0.0);
            for i in 0..3 {
                let wanted = Vec3::from(levels[i]);
                with_two += (from + (to - from) * shares[i]).distance_squared(wanted);
                with_one += one.distance_squared(wanted);
            }
            // Up to the rounding of the ends.
            prop_assert!(with_two.sqrt() <= with_one.sqrt() + 3.0, "{with_two} {with_one}");
        }
    }
}
