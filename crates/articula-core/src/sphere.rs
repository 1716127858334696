//! Bounding sphere, the cheapest bound to transform and to test.

use glam::{Quat, Vec3};

/// A bounding sphere, in metres in the space of what it bounds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sphere {
    /// Centre.
    pub centre: Vec3,
    /// Radius.
    pub radius: f32,
}

impl Sphere {
    /// Returns the smallest sphere around the box between two corners, enlarged to cover rounding.
    pub fn from_corners(least: Vec3, greatest: Vec3) -> Self {
        let centre = 0.5 * (least + greatest);
        let corner = (greatest - centre).abs().max((least - centre).abs());
        Self {
            centre,
            radius: rounded_up(corner.length(), centre),
        }
    }

    /// Returns the smallest sphere around two, enlarged to cover rounding.
    #[must_use]
    pub(crate) fn union(self, other: Self) -> Self {
        let apart = other.centre - self.centre;
        let distance = apart.length();
        if distance + other.radius <= self.radius {
            return self;
        }
        if distance + self.radius <= other.radius {
            return other;
        }
        // Neither contains the other, so their centres differ and the division is safe.
        let radius = 0.5 * (distance + self.radius + other.radius);
        let centre = self.centre + apart * ((radius - self.radius) / distance);
        Self {
            centre,
            radius: rounded_up(radius, centre),
        }
    }

    /// Returns the sphere transformed with its body: scaled, then rotated, then translated.
    #[must_use]
    pub fn carried(self, position: Vec3, rotation: Quat, scale: f32) -> Self {
        Self {
            centre: position + rotation * (self.centre * scale),
            radius: self.radius * scale.abs(),
        }
    }

    /// Whether a point lies inside the sphere or on it.
    pub(crate) fn contains(&self, point: Vec3) -> bool {
        point.distance(self.centre) <= self.radius
    }
}

/// Adds four roundings of f32 at the magnitude of the numbers that a radius is computed from.
fn rounded_up(radius: f32, centre: Vec3) -> f32 {
    radius + 4.0 * f32::EPSILON * (radius + centre.abs().max_element())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sphere() -> impl Strategy<Value = Sphere> {
        (-50.0f32..50.0, -50.0f32..50.0, -50.0f32..50.0, 0.0f32..20.0).prop_map(
            |(x, y, z, radius)| Sphere {
                centre: Vec3::new(x, y, z),
                radius,
            },
        )
    }

    #[test]
    fn by_hand() {
        let box_ball = Sphere::from_corners(Vec3::new(-1.0, 0.0, -2.0), Vec3::new(1.0, 4.0, 2.0));
        assert_eq!(box_ball.centre, Vec3::Y * 2.0);
        assert!((box_ball.radius - 3.0).abs() < 1e-5);
        let unit = |x| Sphere {
            centre: Vec3::X * x,
            radius: 1.0,
        };
        let both = unit(0.0).union(unit(4.0));
        assert!((both.centre - Vec3::X * 2.0).length() < 1e-5 && (both.radius - 3.0).abs() < 1e-5);
        assert_eq!(unit(1.0).union(unit(1.0)), unit(1.0));
        let quarter = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
        let carried = unit(1.0).carried(Vec3::Y, quarter, -2.0);
        assert!((carried.centre - Vec3::new(0.0, 1.0, 2.0)).length() < 1e-6);
        assert_eq!(carried.radius, 2.0);
    }

    proptest! {
        #[test]
        fn a_union_holds_both(a in sphere(), b in sphere(), toward in sphere()) {
            let both = a.union(b);
            for s in [a, b] {
                let way = (toward.centre - s.centre).normalize_or_zero();
                // Just inside, so that the rounding of the point itself does not matter.
                prop_assert!(both.contains(s.centre + way * s.radius * (1.0 - 1e-5)));
            }
        }
    }
}
