//! Signed distance fields: lofts, tapered cones and ellipsoids, joined smoothly.
//!
//! In metres, negative inside. Distances are first-order exact near the surface and never exceed
//! the true one far away, as the pruning of the polygoniser requires. Sources: round cone and
//! smooth minimum after I. Quilez' articles on distance functions.

use glam::{Mat3, Vec3, Vec4};

/// A solid with a signed distance function.
#[derive(Debug, Clone)]
pub(crate) enum Shape {
    /// Ellipses stacked along y.
    Loft(Loft),
    /// A round cone or an ellipsoid, scaled along its own axes.
    Cone(Cone),
}

/// One ellipse of a [`Loft`]: height, inner and outer x, front and back z.
pub(crate) type Section = [f32; 5];

/// Ellipses stacked along y and joined by cubic curves; both ends are rounded.
#[derive(Debug, Clone)]
pub(crate) struct Loft {
    heights: Vec<f32>,
    /// Centre x, half width, centre z, half depth at each height, and their slopes.
    rows: Vec<(Vec4, Vec4)>,
}

/// A capsule with two radii along the local y axis, in a scaled frame.
#[derive(Debug, Clone)]
pub(crate) struct Cone {
    origin: Vec3,
    /// Model space to the local axes.
    turn: Mat3,
    scale: Vec3,
    length: f32,
    radii: [f32; 2],
}

/// How a shape is combined with the shapes before it in its [`Group`].
#[derive(Debug, Clone, Copy)]
pub(crate) enum Join {
    /// Smooth union over this blend distance.
    Add(f32),
    /// Smooth subtraction over this blend distance.
    Carve(f32),
}

/// A shape with its bounding box.
#[derive(Debug, Clone)]
struct Part {
    shape: Shape,
    join: Join,
    bounds: (Vec3, Vec3),
}

/// A list of shapes that are combined in order and culled together.
#[derive(Debug, Clone, Default)]
pub(crate) struct Group {
    parts: Vec<Part>,
    bounds: Option<(Vec3, Vec3)>,
}

/// Distance from the box of a group above which only the box counts; wider than every blend.
const REACH: f32 = 0.07;

impl Shape {
    /// A solid through the sections, lowest first.
    pub(crate) fn loft(sections: &[Section]) -> Self {
        let heights: Vec<f32> = sections.iter().map(|s| s[0]).collect();
        let values: Vec<Vec4> = sections
            .iter()
            .map(|[_, inner, outer, front, back]| {
                0.5 * Vec4::new(inner + outer, outer - inner, front + back, front - back)
            })
            .collect();
        let last = values.len() - 1;
        let rows = (0..=last)
            .map(|i| {
                let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
                // Zero slope at the ends, so that their round caps continue them smoothly.
                let inner = if i == 0 || i == last { 0.0 } else { 1.0 };
                (
                    values[i],
                    (values[b] - values[a]) * (inner / (heights[b] - heights[a])),
                )
            })
            .collect();
        Self::Loft(Loft { heights, rows })
    }

    /// A capsule from `a` to `b` with a radius at each end.
    pub(crate) fn cone(a: [f32; 3], b: [f32; 3], radii: [f32; 2]) -> Self {
        Self::flat_cone(a, b, radii, Vec3::X, 1.0)
    }

    /// A capsule whose section is wider by `factor` along `wide`, made perpendicular to the axis.
    pub(crate) fn flat_cone(
        a: [f32; 3],
        b: [f32; 3],
        radii: [f32; 2],
        wide: Vec3,
        factor: f32,
    ) -> Self {
        let (a, b) = (Vec3::from(a), Vec3::from(b));
        let axis = (b - a).normalize();
        let side = (wide - axis * wide.dot(axis)).try_normalize();
        let side = side.unwrap_or_else(|| axis.any_orthonormal_vector());
        Self::Cone(Cone {
            origin: a,
            turn: Mat3::from_cols(side, axis, side.cross(axis)).transpose(),
            scale: Vec3::new(factor, 1.0, 1.0),
            length: (b - a).length(),
            radii,
        })
    }

    /// An ellipsoid along the axes of the model, rotated by `turn`.
    pub(crate) fn ellipsoid(center: [f32; 3], radii: [f32; 3], turn: Mat3) -> Self {
        Self::Cone(Cone {
            origin: Vec3::from(center),
            turn: turn.transpose(),
            scale: Vec3::from(radii),
            length: 0.0,
            radii: [1.0, 1.0],
        })
    }

    fn distance(&self, p: Vec3) -> f32 {
        match self {
            Self::Loft(loft) => loft.distance(p),
            Self::Cone(cone) => cone.distance(p),
        }
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        match self {
            Self::Loft(loft) => loft.bounds(),
            Self::Cone(cone) => cone.bounds(),
        }
    }
}

impl Loft {
    fn at(&self, y: f32) -> Vec4 {
        let last = self.heights.len() - 1;
        let upper = self.heights.iter().position(|h| *h > y).unwrap_or(last);
        let i = upper.clamp(1, last) - 1;
        let width = self.heights[i + 1] - self.heights[i];
        let t = (y - self.heights[i]) / width;
        let ((a, da), (b, db)) = (self.rows[i], self.rows[i + 1]);
        let (t2, t3) = (t * t, t * t * t);
        a * (2.0 * t3 - 3.0 * t2 + 1.0)
            + da * width * (t3 - 2.0 * t2 + t)
            + b * (3.0 * t2 - 2.0 * t3)
            + db * width * (t3 - t2)
    }

    fn distance(&self, p: Vec3) -> f32 {
        let last = self.heights.len() - 1;
        let y = p.y.clamp(self.heights[0], self.heights[last]);
        let s = self.at(y);
        let radii = Vec3::new(s.y, s.y.min(s.w), s.w);
        scaled_sphere(Vec3::new(p.x - s.x, p.y - y, p.z - s.z), radii)
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        let mut low = Vec3::splat(f32::MAX);
        let mut high = -low;
        for (y, (s, _)) in self.heights.iter().zip(&self.rows) {
            let half = Vec3::new(s.y, s.y.min(s.w), s.w);
            let center = Vec3::new(s.x, *y, s.z);
            low = low.min(center - half);
            high = high.max(center + half);
        }
        // The curves between sections may exceed them slightly.
        (low - 0.01, high + 0.01)
    }
}

impl Cone {
    fn distance(&self, p: Vec3) -> f32 {
        let q = self.turn * (p - self.origin) / self.scale;
        let [r0, r1] = self.radii;
        if self.length == 0.0 {
            return scaled_sphere(q * self.scale, self.scale * r0);
        }
        let slope = (r0 - r1) / self.length;
        let level = (1.0 - slope * slope).max(0.0).sqrt();
        let across = (q.x * q.x + q.z * q.z).sqrt();
        let along = q.y * level - across * slope;
        if along < 0.0 {
            return scaled_sphere(q * self.scale, self.scale * r0);
        }
        if along > level * self.length {
            let q = q - Vec3::Y * self.length;
            return scaled_sphere(q * self.scale, self.scale * r1);
        }
        let gap = across * level + q.y * slope - r0;
        let side = level / across.max(1e-9);
        let normal = Vec3::new(q.x * side, slope, q.z * side) / self.scale;
        gap / normal.length().max(1e-9)
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        let b = self.origin + self.turn.transpose() * Vec3::Y * (self.length * self.scale.y);
        let largest = self.scale.max_element() * self.radii[0].max(self.radii[1]);
        (self.origin.min(b) - largest, self.origin.max(b) + largest)
    }
}

/// Distance to an ellipsoid around the origin, first-order exact at its surface.
fn scaled_sphere(p: Vec3, radii: Vec3) -> f32 {
    let q = p / radii;
    let length = q.length();
    if length < 1e-6 {
        return -radii.min_element();
    }
    (length - 1.0) * length / (q / radii).length()
}

impl Group {
    /// Adds a shape.
    pub(crate) fn with(mut self, shape: Shape, join: Join) -> Self {
        let (low, high) = shape.bounds();
        if let Join::Add(_) = join {
            let (l, h) = self.bounds.unwrap_or((low, high));
            self.bounds = Some((l.min(low), h.max(high)));
        }
        self.parts.push(Part {
            shape,
            join,
            bounds: (low, high),
        });
        self
    }

    /// Signed distance; a lower bound where the group is farther than [`REACH`].
    pub(crate) fn distance(&self, p: Vec3) -> f32 {
        let far = self.bounds.map_or(f32::MAX, |b| outside(b, p));
        if far > REACH {
            return far;
        }
        let mut sum = f32::MAX;
        for part in &self.parts {
            let (sign, blend) = match part.join {
                Join::Add(blend) => (1.0, blend),
                Join::Carve(blend) => (-1.0, blend),
            };
            // Distances of flat shapes are somewhat too small, hence the margin.
            if outside(part.bounds, p) <= sign * sum + 1.5 * blend {
                sum = sign * smooth_min(sign * sum, part.shape.distance(p), blend);
            }
        }
        sum
    }

    /// Outward unit normal, symmetric about x = 0.
    pub(crate) fn normal(&self, p: Vec3) -> Vec3 {
        let half = |q: Vec3| self.distance(Vec3::new(q.x.abs(), q.y, q.z));
        gradient(half, p).try_normalize().unwrap_or(Vec3::Y)
    }

    /// The point of a face at x and y, moved outwards by `lift`.
    pub(crate) fn on_skin(&self, [x, y]: [f32; 2], lift: f32) -> Vec3 {
        let mut p = Vec3::new(x, y, 0.13);
        for _ in 0..60 {
            p.z -= 0.7 * self.distance(p);
        }
        p + self.normal(p) * lift
    }

    /// Corners of the bounding box.
    pub(crate) fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds.unwrap_or((Vec3::ZERO, Vec3::ZERO))
    }
}

/// Distance to a box, 0 inside.
fn outside((low, high): (Vec3, Vec3), p: Vec3) -> f32 {
    (low - p).max(p - high).max(Vec3::ZERO).length()
}

/// Cubic smooth minimum: rounds the crease where both values differ by less than `blend`, so that
/// shading stays smooth; the plain minimum elsewhere.
pub(crate) fn smooth_min(a: f32, b: f32, blend: f32) -> f32 {
    let near = (blend - (a - b).abs()).max(0.0);
    if near == 0.0 {
        return a.min(b);
    }
    let h = near / blend;
    a.min(b) - h * h * h * blend / 6.0
}

/// Gradient of a field by central differences.
pub(crate) fn gradient(field: impl Fn(Vec3) -> f32, p: Vec3) -> Vec3 {
    const STEP: f32 = 4e-4;
    let along = |axis: Vec3| field(p + axis * STEP) - field(p - axis * STEP);
    Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)) / (2.0 * STEP)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_minimum_only_differs_inside_its_blend() {
        assert_eq!(smooth_min(1.0, 2.0, 0.5), 1.0);
        assert_eq!(smooth_min(2.0, 1.0, 0.0), 1.0);
        // Equal values are lowered by a sixth of the blend, which is the maximum.
        assert!((smooth_min(1.0, 1.0, 0.6) - 0.9).abs() < 1e-6);
    }

    #[test]
    fn shapes_are_zero_on_their_surfaces_and_signed_around_them() {
        let ellipsoid = Shape::ellipsoid([1.0, 0.0, 0.0], [0.1, 0.2, 0.3], Mat3::IDENTITY);
        assert!(ellipsoid.distance(Vec3::new(1.0, 0.2, 0.0)).abs() < 1e-6);
        assert!((ellipsoid.distance(Vec3::new(1.0, 0.0, 0.4)) - 0.1).abs() < 1e-6);
        assert!(ellipsoid.distance(Vec3::X) < 0.0);
        // A capsule of one radius, with known exact distance.
        let capsule = Shape::cone([0.0; 3], [0.0, 1.0, 0.0], [0.1, 0.1]);
        assert!((capsule.distance(Vec3::new(0.3, 0.5, 0.4)) - 0.4).abs() < 1e-6);
        assert!((capsule.distance(Vec3::new(0.0, 1.5, 0.0)) - 0.4).abs() < 1e-6);
    }

    #[test]
    fn a_loft_passes_through_its_sections() {
        let sections = [
            [0.0, -0.1, 0.1, 0.2, -0.2],
            [1.0, -0.2, 0.4, 0.1, -0.3],
            [2.0, -0.1, 0.1, 0.2, -0.2],
        ];
        let loft = Shape::loft(&sections);
        for [y, inner, outer, front, back] in sections {
            let (x, z) = (0.5 * (inner + outer), 0.5 * (front + back));
            for p in [
                Vec3::new(inner, y, z),
                Vec3::new(outer, y, z),
                Vec3::new(x, y, front),
                Vec3::new(x, y, back),
            ] {
                assert!(loft.distance(p).abs() < 1e-6, "{p}");
            }
        }
    }

    #[test]
    fn skipping_far_shapes_changes_nothing_near_the_surface() {
        let group = Group::default()
            .with(
                Shape::cone([0.0; 3], [0.0, 1.0, 0.0], [0.1, 0.1]),
                Join::Add(0.0),
            )
            .with(
                Shape::cone([0.0, 5.0, 0.0], [0.0, 6.0, 0.0], [0.1, 0.1]),
                Join::Add(0.05),
            );
        assert!((group.distance(Vec3::new(0.15, 0.5, 0.0)) - 0.05).abs() < 1e-6);
        let far = group.distance(Vec3::new(3.0, 0.5, 0.0));
        assert!(far > REACH && far <= 2.9, "a lower bound: {far}");
    }
}
