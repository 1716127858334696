//! Capsule: a sphere swept along a segment, which approximates a trunk, a limb or a head.

use glam::{Quat, Vec3};

/// All points within a radius of a segment; metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Capsule {
    /// Ends of the segment.
    pub ends: [Vec3; 2],
    /// Radius around the segment.
    pub radius: f32,
}

impl Capsule {
    /// Returns the capsule transformed with its body: scaled, then rotated, then translated.
    #[must_use]
    pub fn carried(self, position: Vec3, rotation: Quat, scale: f32) -> Self {
        Self {
            ends: self.ends.map(|end| position + rotation * (end * scale)),
            radius: self.radius * scale.abs(),
        }
    }

    /// Whether a point lies inside the capsule or on it.
    pub fn contains(&self, point: Vec3) -> bool {
        let [a, b] = self.ends;
        let along = b - a;
        let t = (point - a).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
        point.distance(a + along * t.clamp(0.0, 1.0)) <= self.radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inside_and_carried_by_hand() {
        let limb = Capsule {
            ends: [Vec3::ZERO, Vec3::Y * 2.0],
            radius: 0.5,
        };
        assert!(limb.contains(Vec3::new(0.4, 1.0, 0.0)) && limb.contains(Vec3::Y * 2.4));
        assert!(!limb.contains(Vec3::new(0.4, 2.4, 0.0)) && !limb.contains(Vec3::X * 0.6));
        let lying = limb.carried(
            Vec3::X,
            Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2),
            2.0,
        );
        assert!((lying.ends[1] - Vec3::X * 5.0).length() < 1e-6);
        assert_eq!(lying.radius, 1.0);
        let ball = Capsule {
            ends: [Vec3::X; 2],
            radius: 1.0,
        };
        assert!(ball.contains(Vec3::X * 1.9) && !ball.contains(Vec3::X * 2.1));
    }
}
