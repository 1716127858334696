//! The picture of the painted human: its charts, filled with the colours of what they show.

use crate::charts::{CHARTS, SIDE, on_left};
use articula_core::source::Primitive;
use glam::{Vec2, Vec3};

/// Samples of a px along both axes.
const FINER: u32 = 2;

/// Samples by which colours go on beyond the border of what a chart shows.
const GUTTER: usize = 8;

/// Colours of a picture while it is painted, finer than the picture.
pub(crate) struct Canvas {
    side: usize,
    /// Linear colours; nothing where no triangle is.
    colors: Vec<Option<Vec3>>,
    /// The factors that are in the colours. Where parts lie over each other, the one with more light is seen.
    shades: Vec<f32>,
}

impl Canvas {
    pub(crate) fn new() -> Self {
        let side = (SIDE * FINER) as usize;
        Self {
            side,
            colors: vec![None; side * side],
            shades: vec![0.0; side * side],
        }
    }

    /// Fills the triangles of the left half of a primitive. `shade` is a factor for each vertex, `color` the colour
    /// of a point.
    pub(crate) fn fill(
        &mut self,
        primitive: &Primitive,
        shade: &[f32],
        color: impl Fn(Vec3, Vec3) -> Vec3,
    ) {
        for t in &primitive.triangles {
            let t = t.map(|v| v as usize);
            let corners = t.map(|v| primitive.positions[v]);
            if corners.iter().map(|p| p.x).sum::<f32>() < 0.0 {
                continue;
            }
            let at = t.map(|v| primitive.texcoords[v] * self.side as f32);
            self.fill_triangle(at, t.map(|v| shade[v]), |[a, b, c]| {
                let p = corners[0] * a + corners[1] * b + corners[2] * c;
                let [i, j, k] = t.map(|v| primitive.normals[v]);
                color(on_left(p), (i * a + j * b + k * c).normalize_or_zero())
            });
        }
    }

    /// Fills the samples whose centres are in a triangle; `color` is that of its barycentric coordinates.
    fn fill_triangle(
        &mut self,
        [a, b, c]: [Vec2; 3],
        shades: [f32; 3],
        color: impl Fn([f32; 3]) -> Vec3,
    ) {
        let area = (b - a).perp_dot(c - a);
        if area.abs() < 1e-6 {
            return;
        }
        let low = a.min(b).min(c).floor().max(Vec2::ZERO);
        let high = a.max(b).max(c).ceil().min(Vec2::splat(self.side as f32));
        for y in low.y as usize..high.y as usize {
            for x in low.x as usize..high.x as usize {
                let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let beside = (p - a).perp_dot(c - a) / area;
                let beyond = (b - a).perp_dot(p - a) / area;
                let shares = [1.0 - beside - beyond, beside, beyond];
                let sample = y * self.side + x;
                let shade = Vec3::from(shares).dot(Vec3::from(shades));
                if shares.iter().all(|s| *s >= 0.0) && shade > self.shades[sample] {
                    self.shades[sample] = shade;
                    self.colors[sample] = Some(color(shares) * shade);
                }
            }
        }
    }

    /// The picture: bytes of sRGB, row by row from the top. Beyond the borders of what a chart shows its colours go
    /// on, so that neither interpolation nor a smaller picture mixes in others.
    pub(crate) fn picture(mut self, background: Vec3) -> Vec<[u8; 3]> {
        for _ in 0..GUTTER {
            self.spread();
        }
        let side = SIDE as usize;
        let finer = FINER as usize;
        let pixel = |i: usize| {
            let (x, y) = (i % side * finer, i / side * finer);
            let samples = (0..finer * finer)
                .map(|s| (y + s / finer) * self.side + x + s % finer)
                .map(|s| self.colors[s].unwrap_or(background));
            let mean = samples.sum::<Vec3>() / (finer * finer) as f32;
            mean.to_array().map(srgb)
        };
        (0..side * side).map(pixel).collect()
    }

    /// Gives each sample without a colour the mean of its neighbours in the same chart that have one.
    fn spread(&mut self) {
        let before = self.colors.clone();
        for chart in &CHARTS {
            let [left, top, width, height] = chart.frame.map(|v| (v * FINER) as usize);
            let (right, bottom) = (left + width - 1, top + height - 1);
            for y in top..=bottom {
                for x in left..=right {
                    if before[y * self.side + x].is_some() {
                        continue;
                    }
                    let side = self.side;
                    let columns = x.saturating_sub(1).max(left)..=(x + 1).min(right);
                    let rows = y.saturating_sub(1).max(top)..=(y + 1).min(bottom);
                    let near = rows.flat_map(|y| columns.clone().map(move |x| y * side + x));
                    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
                    for color in near.filter_map(|i| before[i]) {
                        sum += color;
                        count += 1.0;
                    }
                    if count > 0.0 {
                        self.colors[y * self.side + x] = Some(sum / count);
                    }
                }
            }
        }
    }
}

/// The byte of sRGB (IEC 61966-2-1) of a linear value.
fn srgb(linear: f32) -> u8 {
    let v = linear.clamp(0.0, 1.0);
    let encoded = if v <= 0.003_130_8 {
        12.92 * v
    } else {
        1.055 * v.powf(1.0 / 2.4) - 0.055
    };
    (encoded * 255.0).round() as u8
}
