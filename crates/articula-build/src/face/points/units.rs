//! The distances of a neutral face by which FAPs are measured.

use super::template::{POINTS, of, template_height};
use articula_core::fap_table::FapUnit;
use articula_core::feature_points::PointId;
use glam::Vec3;

/// Factor to the proportions of the template from which a distance is doubtful.
const DOUBTFUL: f32 = 1.6;

/// A distance of a face beside that of an average face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitRatio {
    /// Distance by that of an average face.
    pub ratio: f32,
    /// Whether it is above 1.6 or below 1 / 1.6.
    pub doubtful: bool,
}

/// Distances of the neutral face, metres. A unit of a FAP is a 1024th of its distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceUnits {
    /// Diameter of the iris, from the openings of the lids: 3.1 to 3.3, and 3.2 to 3.4.
    pub iris_diameter: f32,
    /// Separation of the eyes: 3.5 to 3.6, sideways.
    pub eye_separation: f32,
    /// Eye to nose: height from 3.5 to 9.15.
    pub eye_nose: f32,
    /// Mouth to nose: height from 9.15 to 2.2.
    pub mouth_nose: f32,
    /// Width of the mouth: 8.3 to 8.4, sideways.
    pub mouth_width: f32,
}

impl FaceUnits {
    /// Distances of the template.
    fn of_template() -> Self {
        Self::between(|point| of(&POINTS, point).unwrap_or_default())
    }

    /// Distances between points at these places.
    pub(super) fn between(at: impl Fn(PointId) -> Vec3) -> Self {
        let high = |a: PointId, b: PointId| (at(a).y - at(b).y).abs();
        let wide = |a: PointId, b: PointId| (at(a).x - at(b).x).abs();
        Self {
            iris_diameter: 0.5 * (high((3, 1), (3, 3)) + high((3, 2), (3, 4))),
            eye_separation: wide((3, 5), (3, 6)),
            eye_nose: high((3, 5), (9, 15)),
            mouth_nose: high((9, 15), (2, 2)),
            mouth_width: wide((8, 3), (8, 4)),
        }
    }

    /// Returns the distance of a unit in metres; 1 for angles, which have none.
    pub fn distance(&self, unit: FapUnit) -> f32 {
        match unit {
            FapUnit::IrisDiameter => self.iris_diameter,
            FapUnit::EyeSeparation => self.eye_separation,
            FapUnit::EyeNose => self.eye_nose,
            FapUnit::MouthNose => self.mouth_nose,
            FapUnit::MouthWidth => self.mouth_width,
            FapUnit::Angle => 1.0,
        }
    }

    /// Returns the ratio of each distance to that of an average face of the same height
    /// ([`FacePoints::height`](super::FacePoints::height)), by which wrong points show.
    pub fn ratios(&self, height: f32) -> [(FapUnit, UnitRatio); 5] {
        let average = Self::of_template();
        let scale = height / template_height();
        let ratio = |unit: FapUnit| {
            let ratio = self.distance(unit) / (average.distance(unit) * scale);
            let doubtful = !(1.0 / DOUBTFUL..=DOUBTFUL).contains(&ratio);
            (unit, UnitRatio { ratio, doubtful })
        };
        FapUnit::DISTANCES.map(ratio)
    }
}
