//! The surfaces of the human within a triangle budget: skin, lips, brows and eyes.

use crate::body::Body;
use crate::field::Group;
use crate::head::{self, EYE_RADIUS};
use crate::polygonise::{Grid, Surface, polygonise};
use crate::skeleton::EYE;
use crate::suit;
use crate::thin::{Options, thinned};
use glam::Vec3;

/// Spacing of the samples of the skin, in metres: finer than half the radius of a finger.
pub(crate) const SKIN_STEP: f32 = 0.0026;

/// All surfaces, with both halves of the body.
pub(crate) struct Pieces {
    pub(crate) skin: Surface,
    pub(crate) lips: Surface,
    pub(crate) brows: Surface,
    /// Sclera, iris and pupil of both eyes; the left eye first.
    pub(crate) eyes: [Surface; 3],
}

impl Pieces {
    /// Divides the budget and makes each surface from its field.
    pub(crate) fn new(body: &Body, triangles: usize) -> Self {
        let lips = mirrored(&piece(&head::lips(&body.head), triangles / 50));
        let brow = piece(&head::brow(&body.head), triangles / 120);
        let brows = both_sides(&brow);
        let eyes = eyes(triangles);
        let spent = lips.triangles.len()
            + brows.triangles.len()
            + eyes.iter().map(|e| e.triangles.len()).sum::<usize>();
        let skin = mirrored(&skin_half(body, triangles.saturating_sub(spent) / 2));
        Self {
            skin,
            lips,
            brows,
            eyes,
        }
    }
}

/// The left half of the skin, with about `target` triangles.
fn skin_half(body: &Body, target: usize) -> Surface {
    let fine = suit::cut(&fine_half(body, skin_step), body);
    let options = Options {
        target,
        mirrored: true,
        importance: &importance,
    };
    thinned(&fine, &options)
}

/// The left half of a body with the samples spaced along each axis as given.
pub(crate) fn fine_half(body: &Body, step: impl Fn(usize, f32) -> f32) -> Surface {
    let grid = Grid::banded(
        Vec3::new(0.0, -0.012, -0.15),
        Vec3::new(0.3, 1.765, 0.185),
        step,
    );
    polygonise(&grid, &|p: Vec3| body.distance(p))
}

/// Spacing of the samples along an axis (0 to 2) at a position on it.
pub(crate) fn skin_step(axis: usize, at: f32) -> f32 {
    match (axis, at) {
        // Shins, knees and the trunk above the hands have no small features.
        (1, 0.13..0.64 | 0.89..1.47) => 2.0 * SKIN_STEP,
        // The lids are the finest features.
        (0, 0.015..0.048) | (1, 1.621..1.645) | (2, 0.066..0.084) => 0.5 * SKIN_STEP,
        _ => SKIN_STEP,
    }
}

/// Weight of errors. Small round features need as many triangles around them as large ones, so
/// errors count by about the inverse square of the local radius.
fn importance(p: Vec3) -> f32 {
    let hand = p.y < 0.87 && p.x > 0.2;
    let near_eye = p.distance(EYE + Vec3::Z * 0.01) < 0.02;
    let face = p.y > 1.51 && p.z > 0.01;
    let ear = p.y > 1.59 && p.y < 1.665 && p.x > 0.062;
    if near_eye {
        45.0
    } else if hand {
        15.0
    } else if face || ear {
        22.0
    } else if p.y > 1.58 || p.y < 0.05 {
        7.0
    } else if p.y > 1.46 && p.x < 0.08 {
        4.0
    } else {
        1.0
    }
}

/// Surface of a small group, sampled every 0.6 mm and simplified.
fn piece(group: &Group, target: usize) -> Surface {
    solid(group, target, 0.0006)
}

/// Surface of a group, sampled at a spacing in metres and simplified.
pub(crate) fn solid(group: &Group, target: usize, step: f32) -> Surface {
    let (low, high) = group.bounds();
    // The surface may bulge beyond the bounds where shapes blend.
    let margin = Vec3::splat((2.0 * step).max(0.003));
    let grid = Grid::uniform(low - margin, high + margin, step);
    let field = |p: Vec3| group.distance(Vec3::new(p.x.abs(), p.y, p.z));
    let fine = polygonise(&grid, &field);
    let options = Options {
        target: target.max(16),
        mirrored: grid.axes[0][0] < 0.0,
        importance: &|_| 1.0,
    };
    thinned(&fine, &options)
}

pub(crate) const FLIP: Vec3 = Vec3::new(-1.0, 1.0, 1.0);

/// The whole of a half surface: vertices in x = 0 are shared, all others mirrored.
pub(crate) fn mirrored(half: &Surface) -> Surface {
    let mut whole = half.clone();
    let twin: Vec<u32> = half
        .positions
        .iter()
        .enumerate()
        .map(|(v, p)| {
            if p.x == 0.0 {
                return v as u32;
            }
            whole.positions.push(*p * FLIP);
            whole.positions.len() as u32 - 1
        })
        .collect();
    let other = half
        .triangles
        .iter()
        .map(|[a, b, c]| [*a, *c, *b].map(|v| twin[v as usize]));
    whole.triangles.extend(other);
    whole.tones.extend(&half.tones);
    whole
}

/// A closed surface and its mirror image.
pub(crate) fn both_sides(one: &Surface) -> Surface {
    let count = one.positions.len() as u32;
    let mut both = one.clone();
    both.positions
        .extend(one.positions.iter().map(|p| *p * FLIP));
    both.triangles.extend(
        one.triangles
            .iter()
            .map(|[a, b, c]| [a + count, c + count, b + count]),
    );
    both
}

/// Sclera, iris and pupil: bands of one surface of revolution.
fn eyes(triangles: usize) -> [Surface; 3] {
    let around = (triangles / 600).clamp(6, 28);
    let rings = |from: f32, to: f32, count: usize| -> Vec<f32> {
        (0..=count)
            .map(|i| from + (to - from) * i as f32 / count as f32)
            .collect()
    };
    let detail = (around / 4).max(2);
    let sclera = rings(0.54, std::f32::consts::PI, detail + 1);
    [sclera, rings(0.22, 0.54, 1), rings(0.0, 0.22, 1)]
        .map(|angles| both_sides(&band(&angles, around)))
}

/// A band of the left eyeball between polar angles from the viewing direction.
fn band(angles: &[f32], around: usize) -> Surface {
    let mut out = Surface::default();
    let mut rows: Vec<Vec<u32>> = Vec::new();
    for angle in angles {
        let pole = angle.sin() < 1e-3;
        let count = if pole { 1 } else { around };
        let row = (0..count)
            .map(|i| {
                let turn = std::f32::consts::TAU * i as f32 / around as f32;
                let flat = angle.sin();
                let direction = Vec3::new(flat * turn.cos(), flat * turn.sin(), angle.cos());
                out.positions.push(EYE + direction * EYE_RADIUS);
                out.positions.len() as u32 - 1
            })
            .collect();
        rows.push(row);
    }
    for pair in rows.windows(2) {
        for i in 0..around {
            let at = |row: &[u32], i: usize| row[i % row.len()];
            let (a, b) = (at(&pair[0], i), at(&pair[0], i + 1));
            let (c, d) = (at(&pair[1], i), at(&pair[1], i + 1));
            if a != b {
                out.triangles.push([a, c, b]);
            }
            if c != d {
                out.triangles.push([b, c, d]);
            }
        }
    }
    out
}
