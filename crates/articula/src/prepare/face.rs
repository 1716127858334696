//! The face as an asset stores it.

use crate::face::FoundFace;
use articula_core::fap_table::FapUnit;
use articula_formats::gltf::{StoredFace, StoredPoint};

impl FoundFace {
    /// The feature points as an asset stores them.
    pub(crate) fn stored(&self) -> StoredFace {
        let units = self.points.units();
        let points = self.points.points.iter().map(|p| StoredPoint {
            point: p.point,
            position: self.head.model_from_head * p.place,
            source: p.source.name().to_owned(),
            confidence: p.confidence,
        });
        StoredFace {
            rotation: self.head.model_from_head,
            units: FapUnit::DISTANCES.map(|u| (u, units.distance(u))).to_vec(),
            points: points.collect(),
        }
    }
}
