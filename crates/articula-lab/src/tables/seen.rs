//! The vertices of a head that are seen from outside.

use articula_build::face::FaceSurface;
use glam::{Quat, Vec3};

/// Which vertices are seen from the front, from either side, from above or below.
pub(super) fn seen(surface: &FaceSurface, height: f32) -> Vec<bool> {
    const CELLS: usize = 600;
    let mut all = vec![false; surface.positions.len()];
    let step = 3.0 * height / CELLS as f32;
    let middle = surface.positions.iter().sum::<Vec3>() / surface.positions.len().max(1) as f32;
    let views = [
        Quat::IDENTITY,
        Quat::from_rotation_y(0.8),
        Quat::from_rotation_y(-0.8),
        Quat::from_rotation_x(0.5),
        Quat::from_rotation_x(-0.5),
    ];
    for view in views {
        let placed: Vec<Vec3> = surface
            .positions
            .iter()
            .map(|p| (view * (*p - middle)) / step + Vec3::new(0.5, 0.5, 0.0) * CELLS as f32)
            .collect();
        let mut front = vec![f32::NEG_INFINITY; CELLS * CELLS];
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|v| placed[v as usize]);
            let low = a.min(b).min(c).max(Vec3::ZERO);
            let high = a.max(b).max(c).min(Vec3::splat(CELLS as f32 - 1.0));
            let area = (b - a).truncate().perp_dot((c - a).truncate());
            if area.abs() < 1e-9 {
                continue;
            }
            for y in low.y.ceil() as usize..=high.y.max(0.0) as usize {
                for x in low.x.ceil() as usize..=high.x.max(0.0) as usize {
                    let p = Vec3::new(x as f32, y as f32, 0.0) - a;
                    let wb = p.truncate().perp_dot((c - a).truncate()) / area;
                    let wc = (b - a).truncate().perp_dot(p.truncate()) / area;
                    if wb >= 0.0 && wc >= 0.0 && wb + wc <= 1.0 {
                        let z = a.z + wb * (b.z - a.z) + wc * (c.z - a.z);
                        let cell = &mut front[y * CELLS + x];
                        *cell = cell.max(z);
                    }
                }
            }
        }
        let slack = 0.01 * height / step;
        for (seen, at) in all.iter_mut().zip(&placed) {
            let (x, y) = (at.x.round(), at.y.round());
            let inside = |v: f32| (0.0..CELLS as f32).contains(&v);
            if inside(x) && inside(y) {
                *seen |= at.z + slack > front[y as usize * CELLS + x as usize];
            }
        }
    }
    all
}
