//! The tongue: the part of what is inside of the mouth that its parameters move.
//!
//! In many heads it is one piece with the gums, so it is told by the distance along the surface from
//! its feature points.

use super::super::fap_values::FapValues;
use super::super::points::{FacePoints, FaceSurface};
use super::graph::{SurfaceGraph, nearest, smooth};
use super::mirror::Mirror;
use super::rules::component;
use articula_core::Libm;
use articula_core::fap_table::{ANGLE_UNIT, FapUnit};
use articula_core::feature_points::PointId;
use glam::Vec3;

/// Farthest vertex from a feature point of the tongue that stands for it, by height of the face.
const FOUND: f32 = 0.1;
/// Distance along the surface from the middle line and the borders of the tongue from which it begins to
/// rest, and the width of the fade, by height of the face.
const REACH: f32 = 0.1;
const FADE: f32 = 0.08;
/// Places of the middle line that are sought between body and tip.
const BETWEEN: usize = 4;
/// Share of the way from body to tip behind the body over which the tongue rests.
const ROOT: f32 = 0.8;

/// The tongue of a head.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tongue {
    pub(super) vertices: Vec<TongueVertex>,
    /// Half of its width, metres.
    half_width: f32,
}

/// How a vertex follows the tongue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TongueVertex {
    pub(super) vertex: u32,
    /// 1 on the tongue, 0 on what is around it.
    pub(super) share: f32,
    /// 0 at the root, 1 at the tip.
    along: f32,
    /// Shares with which it follows the body, which is highest in the middle.
    body: f32,
    /// Distance from the middle plane, metres.
    aside: f32,
}

impl Tongue {
    /// The tongue among the vertices of the parts that are inside of the mouth; `None` if nothing is
    /// near its feature points.
    pub(super) fn of(
        surface: &FaceSurface,
        points: &FacePoints,
        inside: &[u32],
        mirror: &Mirror,
        height: f32,
    ) -> Option<Self> {
        let at = |v: u32| surface.positions[v as usize];
        let place = |point: PointId| points.get(point).map(|p| p.place);
        let near = |among: &[u32], to: Vec3| {
            let index = nearest(among.iter().map(|v| at(*v)), to)?;
            let vertex = among[index];
            (at(vertex).distance(to) < FOUND * height).then_some(vertex)
        };
        let triangles = surface.triangles_among(inside);
        let joined = &points.parts.joined;
        let graph = SurfaceGraph::of(&surface.positions, joined, &triangles, mirror);
        let (tip, body) = (place((6, 1))?, place((6, 2))?);
        // Teeth may be nearer to the borders than the tongue itself, but are no piece of it.
        let from_body = graph.distances(&[near(inside, body)?]);
        let piece = inside.iter().copied();
        let piece: Vec<u32> = piece
            .filter(|v| from_body[*v as usize].is_finite())
            .collect();
        let near = |to: Vec3| near(&piece, to);
        let mut seeds = vec![near(tip)?, near(body)?];
        for i in 1..BETWEEN {
            let place = body.lerp(tip, i as f32 / BETWEEN as f32);
            seeds.extend(near(place));
        }
        for border in [(6, 3), (6, 4)] {
            seeds.push(near(place(border)?)?);
        }
        let away = graph.distances(&seeds);
        let (tip, body) = (at(seeds[0]), at(seeds[1]));
        let length = tip.z - body.z;
        if length < 0.05 * height {
            return None;
        }
        let root = body.z - ROOT * length;
        let follow = |vertex: &u32| {
            let share = smooth((REACH + FADE - away[*vertex as usize] / height) / FADE);
            let p = at(*vertex);
            let along = smooth((p.z - root) / (tip.z - root));
            (share > 0.0).then(|| TongueVertex {
                vertex: *vertex,
                share,
                along,
                body: smooth(1.0 - (p.z - body.z).abs() / (1.2 * length)),
                aside: p.x - body.x,
            })
        };
        let vertices: Vec<TongueVertex> = inside.iter().filter_map(follow).collect();
        let half_width = 0.5 * (place((6, 3))?.x - place((6, 4))?.x).abs();
        Some(Self {
            vertices,
            half_width: half_width.max(1e-4),
        })
    }

    /// Displacement of each of its vertices by parameters, where the jaw rests; metres.
    pub(super) fn displacements(
        &self,
        values: &FapValues,
        unit: impl Fn(FapUnit) -> f32,
    ) -> impl Iterator<Item = Vec3> {
        let tip = component(values, (6, 1), &unit);
        let body = component(values, (6, 2), &unit);
        let curl = (values.get(47) * ANGLE_UNIT).clamp(0.0, 1.5);
        self.vertices.iter().map(move |v| {
            // The borders turn up about the middle line.
            let border = (v.aside.abs() / self.half_width).min(1.0);
            let angle = curl * border;
            let (sin, cos) = angle.libm_sin_cos();
            let roll = Vec3::new(v.aside * (cos - 1.0), v.aside.abs() * sin, 0.0);
            v.share * (v.along * tip + v.body * body + v.along * roll)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tongue() -> Tongue {
        let vertex = |share: f32, along: f32, body: f32, aside: f32| TongueVertex {
            vertex: 0,
            share,
            along,
            body,
            aside,
        };
        Tongue {
            vertices: vec![
                vertex(1.0, 1.0, 0.0, 0.0),
                vertex(1.0, 0.5, 1.0, 0.0),
                vertex(1.0, 1.0, 0.0, -0.01),
                vertex(0.0, 1.0, 1.0, 0.0),
            ],
            half_width: 0.01,
        }
    }

    fn moved(values: &[(usize, f32)]) -> Vec<Vec3> {
        let mut all = FapValues::default();
        for (fap, value) in values {
            all.0[fap - 3] = *value;
        }
        // 1024 units of each distance are 10 mm.
        let unit = |unit: FapUnit| if unit == FapUnit::Angle { 1.0 } else { 0.01 };
        tongue().displacements(&all, unit).collect()
    }

    #[test]
    fn the_tip_goes_where_its_parameters_say() {
        let [tip, body, border, gum] = moved(&[(43, 102.4), (44, 204.8), (45, 1024.0)])[..] else {
            panic!("four vertices");
        };
        // To the right, up and out; half as far in the middle.
        assert!(
            (tip - Vec3::new(-0.001, 0.002, 0.01)).length() < 1e-7,
            "{tip}"
        );
        assert!((2.0 * body - tip).length() < 1e-7);
        assert_eq!((border, gum), (tip, Vec3::ZERO));
        let raised = moved(&[(46, 1024.0)]);
        assert!((raised[1] - 0.01 * Vec3::Y).length() < 1e-7);
        assert_eq!(raised[0], Vec3::ZERO);
    }

    #[test]
    fn the_borders_roll_up() {
        // As far as they can.
        let [tip, _, border, _] = moved(&[(47, 1.5 / ANGLE_UNIT)])[..] else {
            panic!("four vertices");
        };
        assert_eq!(tip, Vec3::ZERO);
        assert!(
            (border - Vec3::new(0.01 * (1.0 - 1.5_f32.cos()), 0.01 * 1.5_f32.sin(), 0.0)).length()
                < 1e-6
        );
        assert_eq!(moved(&[(47, -500.0)])[2], Vec3::ZERO);
    }
}
