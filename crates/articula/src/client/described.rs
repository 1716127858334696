//! What is there of what plays, by the pieces that are there.

use super::order::CharacterPlan;
use super::plan::units_of;
use super::report::CharacterReport;
use crate::item::delivery::{Kept, is_motion, largest, mesh_level};
use crate::item::{ItemLayer, PartKind, texture_error_px};

impl CharacterPlan {
    /// Whether what plays at a position shows: its coarsest layer is among the pieces that are there, and the
    /// coarsest of all else.
    pub(super) fn is_ready(&self, there: &[bool], position_secs: f64) -> bool {
        let delivery = &self.planned.delivery;
        let least = &delivery.ladder.levels[0];
        let unit = self.unit(position_secs);
        let has_unit = |part: usize| {
            let missing = delivery.missing_of_unit(there, (part, unit), &least[part]);
            missing.is_empty()
        };
        delivery.missing_of_shape(there, least).is_empty() && self.playing.is_none_or(has_unit)
    }

    /// The access unit that plays at a position.
    pub(super) fn unit(&self, position_secs: f64) -> Option<usize> {
        self.near(position_secs).first().and_then(|(unit, _)| *unit)
    }

    /// The finest level of articulation of the body that is there of what plays at a position; `None` of a
    /// motion without levels.
    pub(super) fn loa(&self, there: &[bool], position_secs: f64) -> Option<u32> {
        let delivery = &self.planned.delivery;
        let part = self.playing?;
        let unit = self.unit(position_secs);
        let layers = delivery.layers_there(there, part, unit);
        let layers = delivery.manifest.parts[part].layers.iter().zip(layers);
        let loa = layers.filter_map(|(layer, there)| layer.keep.get("loa").filter(|_| there));
        loa.max().copied()
    }

    /// Describes what is there of what plays at a position.
    pub(super) fn describe(&self, there: &[bool], position_secs: f64) -> CharacterReport {
        let mut report = CharacterReport::default();
        let delivery = &self.planned.delivery;
        let levels = &delivery.ladder.levels;
        let unit = self.unit(position_secs);
        let has_level = |level: &&Kept| {
            let of_unit = |part: usize| {
                delivery
                    .missing_of_unit(there, (part, unit), &level[part])
                    .is_empty()
            };
            delivery.missing_of_shape(there, level).is_empty() && self.playing.is_none_or(of_unit)
        };
        report.level = levels.iter().take_while(has_level).count();
        report.levels = levels.len();
        report.is_complete = self.is_complete(there);
        let scale = delivery.pixels_per_metre();
        let mut errors_px = [0.0_f64; 3];
        for (index, part) in delivery.manifest.parts.iter().enumerate() {
            let unit = match is_motion(part) {
                true if self.playing == Some(index) => unit,
                true => continue,
                false => None,
            };
            let layers = delivery.layers_there(there, index, unit);
            let shown = || part.layers.iter().zip(&layers).filter(|(_, there)| **there);
            match part.kind {
                PartKind::Texture => {
                    let px = largest(part, &layers);
                    report.texture_px = Some(report.texture_px.map_or(px, |least| least.min(px)));
                    let error = texture_error_px(part, &layers, scale);
                    errors_px[0] = errors_px[0].max(error);
                }
                PartKind::Mesh => {
                    report.mesh_level = mesh_level(part, &layers);
                    let level = part
                        .levels
                        .iter()
                        .find(|l| Some(l.level) == report.mesh_level);
                    errors_px[1] = level.map_or(0.0, |level| scale * level.error_motion_m);
                }
                PartKind::BodyMotion | PartKind::FaceMotion => {
                    let value =
                        |(layer, _): (&ItemLayer, _), name: &str| layer.keep.get(name).copied();
                    let loa = |layer| value(layer, "loa").or_else(|| value(layer, "face_loa"));
                    report.loa = shown().filter_map(loa).max();
                    let of_loa = shown().filter(|layer| loa(*layer) == report.loa);
                    report.tier = of_loa.filter_map(|layer| value(layer, "tier")).min();
                    report.joints = shown().filter_map(|(layer, _)| layer.joints).max();
                    let least = shown().map(|(layer, _)| layer.error_m).reduce(f64::min);
                    let error = least.or(part.base_error_m).unwrap_or(0.0) + part.left_out_m();
                    errors_px[2] = scale * error;
                }
            }
        }
        report.error_px = Some(errors_px.iter().sum());
        report
    }

    /// Whether all that the context asks for is among the pieces that are there.
    fn is_complete(&self, there: &[bool]) -> bool {
        let delivery = &self.planned.delivery;
        let top = delivery.ladder.top();
        let mut parts = delivery.manifest.parts.iter().enumerate();
        let has_unit = |part: usize, unit: Option<usize>| {
            delivery
                .missing_of_unit(there, (part, unit), &top[part])
                .is_empty()
        };
        delivery.missing_of_shape(there, top).is_empty()
            && parts.all(|(part, of)| {
                !is_motion(of) || units_of(of).into_iter().all(|unit| has_unit(part, unit))
            })
    }
}
