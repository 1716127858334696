//! The border between the two tones of the mannequin: a suit from the collar to the middle of upper
//! arms and thighs. Triangles are split along it, so that it is sharp at every triangle count.

use crate::body::Body;
use crate::field::gradient;
use crate::polygonise::{Surface, onto};
use glam::Vec3;
use std::collections::HashMap;

/// Approximate signed distance of a point to the border in metres; positive inside the suit.
pub(crate) fn depth(body: &Body, p: Vec3) -> f32 {
    let p = Vec3::new(p.x.abs(), p.y, p.z);
    // A round collar below the chin; the arm has its own border.
    let neck = Vec3::new(0.0, 1.512, -0.034);
    let collar = (((p - neck) * Vec3::new(0.8, 1.0, 1.0)).length() - 0.093).min(1.512 - p.y);
    let leg = (p - Vec3::new(0.09, 0.69, 0.0)).dot(Vec3::new(-0.16, 1.0, 0.0).normalize());
    let trunk = collar.min(leg);
    if body.upper_limb(p) < body.trunk.distance(p).min(body.leg.distance(p)) {
        let sleeve = (p - Vec3::new(0.203, 1.275, -0.04)).dot(Vec3::new(-0.14, 0.99, 0.0));
        return trunk.min(sleeve);
    }
    trunk
}

/// Moves a point near the border onto it and onto the surface.
fn onto_border(body: &Body, depth: &impl Fn(Vec3) -> f32, from: Vec3, flat: bool) -> Vec3 {
    let field = |p: Vec3| body.distance(p);
    let mut p = from;
    for _ in 0..4 {
        let slope = gradient(depth, p);
        let normal = body.normal(p);
        // Along the surface, so that both conditions are met quickly.
        let along = slope - normal * slope.dot(normal);
        let step = along * (depth(p) / along.length_squared().max(0.05));
        p = onto(&field, p - step.clamp_length_max(0.006), flat, 1);
    }
    p
}

/// Splits the triangles that the border of the suit crosses and assigns the tones: bare, suit.
pub(crate) fn cut(surface: &Surface, body: &Body) -> Surface {
    let depth = |p: Vec3| depth(body, p);
    let split = split(surface, body, &depth);
    toned(split, |p| u8::from(depth(p) > 0.0))
}

/// Assigns the tone at the middle of each triangle.
pub(crate) fn toned(mut surface: Surface, tone: impl Fn(Vec3) -> u8) -> Surface {
    let middle = |t: &[u32; 3]| {
        t.iter()
            .map(|v| surface.positions[*v as usize])
            .sum::<Vec3>()
            / 3.0
    };
    surface.tones = surface.triangles.iter().map(|t| tone(middle(t))).collect();
    surface
}

/// Splits the triangles that a border crosses, which is where `depth` is zero.
pub(crate) fn split(surface: &Surface, body: &Body, depth: &impl Fn(Vec3) -> f32) -> Surface {
    /// Share of an edge within which its end is moved onto the border instead.
    const NEAR: f32 = 0.18;
    let mut out = surface.clone();
    let mut depths: Vec<f32> = surface.positions.iter().map(|p| depth(*p)).collect();
    let mut on_border = vec![false; depths.len()];
    let edges = |t: &[u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    for (a, b) in surface.triangles.iter().flat_map(edges) {
        let (da, db) = (depths[a as usize], depths[b as usize]);
        let share = da / (da - db);
        if (da < 0.0) != (db < 0.0) && !(NEAR..1.0 - NEAR).contains(&share) {
            on_border[if share < 0.5 { a } else { b } as usize] = true;
        }
    }
    for (depth, on) in depths.iter_mut().zip(&on_border) {
        *depth *= f32::from(u8::from(!on));
    }
    let mut between = HashMap::new();
    out.triangles.clear();
    for triangle in &surface.triangles {
        let mut split = |a: u32, b: u32| {
            let (da, db) = (depths[a as usize], depths[b as usize]);
            (da * db < 0.0).then(|| {
                *between.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let [p, q] = [a, b].map(|v| surface.positions[v as usize]);
                    out.positions.push(p.lerp(q, da / (da - db)));
                    on_border.push(true);
                    out.positions.len() as u32 - 1
                })
            })
        };
        let split_points = edges(triangle).map(|(a, b)| split(a, b));
        halves(*triangle, split_points, &mut out.triangles);
    }
    for (p, _) in out
        .positions
        .iter_mut()
        .zip(&on_border)
        .filter(|(_, on)| **on)
    {
        *p = onto_border(body, depth, *p, p.x == 0.0);
    }
    out
}

/// Splits a triangle at points on its edges (the first from the first to the second corner).
fn halves(triangle: [u32; 3], split_points: [Option<u32>; 3], out: &mut Vec<[u32; 3]>) {
    for i in 0..3 {
        let [a, b, c] = std::array::from_fn(|k| triangle[(i + k) % 3]);
        match std::array::from_fn(|k| split_points[(i + k) % 3]) {
            // Corner b is alone on its side.
            [Some(p), Some(q), None] => return out.extend([[p, b, q], [a, p, q], [a, q, c]]),
            [Some(p), None, None] => return out.extend([[a, p, c], [p, b, c]]),
            _ => {}
        }
    }
    out.push(triangle);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_of_a_triangle_cover_it_once() {
        // Corners 0 to 2, points 3 to 5 on the edges; areas by the shoelace formula.
        let at = [
            (0.0, 0.0),
            (4.0, 0.0),
            (0.0, 4.0),
            (1.0, 0.0),
            (3.0, 1.0),
            (0.0, 2.0),
        ];
        let area = |t: &[u32; 3]| {
            let [p, q, r] = t.map(|v| at[v as usize]);
            ((q.0 - p.0) * (r.1 - p.1) - (r.0 - p.0) * (q.1 - p.1)) / 2.0_f32
        };
        for mask in [0, 1, 2, 4, 3, 5, 6] {
            let split_points =
                std::array::from_fn(|e| (mask >> e & 1 == 1).then_some(3 + e as u32));
            let mut pieces = Vec::new();
            halves([0, 1, 2], split_points, &mut pieces);
            assert!(pieces.iter().all(|t| area(t) > 0.0), "{pieces:?}");
            assert_eq!(pieces.iter().map(area).sum::<f32>(), 8.0, "{pieces:?}");
        }
    }

    #[test]
    fn the_border_runs_between_trunk_and_hands_head_and_feet() {
        let body = Body::new();
        for (inside, p) in [
            (true, Vec3::new(0.0, 1.2, 0.08)),
            (true, Vec3::new(-0.19, 1.4, 0.01)),
            (true, Vec3::new(0.1, 0.8, 0.07)),
            (false, Vec3::new(0.0, 1.55, 0.01)),
            (false, Vec3::new(0.0, 1.522, 0.07)),
            (false, Vec3::new(-0.24, 1.0, -0.03)),
            (false, Vec3::new(0.25, 0.75, 0.0)),
            (false, Vec3::new(0.1, 0.5, 0.05)),
        ] {
            assert_eq!(depth(&body, p) > 0.0, inside, "{p}");
        }
    }
}
